//! Running other programs, from the root of the workspace.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The root of the workspace: the parent of this package.
pub(crate) fn root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package).to_path_buf()
}

/// The cargo target folder, as cargo itself would choose it.
pub(crate) fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// The names, without `.rs`, of the Rust files in `folder` of the workspace, sorted.
pub(crate) fn rust_files(folder: &str) -> Result<Vec<String>, String> {
    let folder = root().join(folder);
    let entries =
        fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut names: Vec<String> = entries
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .filter_map(|path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned()))
        .collect();
    names.sort();
    Ok(names)
}

/// A command that runs in the root of the workspace.
pub(crate) fn command(program: &str) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// Cargo: the one that runs this program.
pub(crate) fn cargo() -> Command {
    command(&std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_string()))
}

/// A program of the tests package: that in the folder `LTBW_TEST_PROGRAMS`, where the tests of the
/// workspace have left it, or one that is built for itself, which takes its crates once more.
pub(crate) fn of_tests(name: &str) -> Command {
    if let Some(folder) = std::env::var_os("LTBW_TEST_PROGRAMS") {
        return command(&PathBuf::from(folder).join(name).to_string_lossy());
    }
    let mut command = cargo();
    command.args(["run", "--quiet", "-p", "ltbw-tests", "--bin", name, "--"]);
    command
}

/// The target folder of the bindings: their workspaces build the same crates, once.
pub(crate) fn bindings() -> PathBuf {
    target().join("bindings")
}

/// Runs `command` with our own output; anything but success is an error.
pub(crate) fn run(command: &mut Command) -> Result<(), String> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{command:?}: {status}")),
        Err(error) => Err(format!("{command:?}: {error}")),
    }
}

/// The program `ltbw`: the one that `LTBW_PROGRAM` names, or one that is built for this.
pub(crate) fn program() -> Result<PathBuf, String> {
    if let Some(program) = std::env::var_os("LTBW_PROGRAM") {
        return Ok(program.into());
    }
    run(cargo().args(["build", "--quiet", "--release", "-p", "ltbw-cli"]))?;
    Ok(target().join("release/ltbw"))
}

/// Does `command` start and succeed? Its output is dropped.
pub(crate) fn works(command: &mut Command) -> bool {
    let quiet = command.stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}

/// A Python with packages, beside what cargo builds; made where there is none that carries out
/// `test`.
pub(crate) fn python(name: &str, packages: &[&str], test: &str) -> Result<PathBuf, String> {
    let folder = target().join(name);
    let python = folder.join("bin/python");
    let program = python.to_string_lossy().into_owned();
    let has = || works(command(&program).args(["-c", test]));
    if has() {
        return Ok(python);
    }
    run(command("python3").args(["-m", "venv"]).arg(&folder))?;
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    run(command(&program).args(install).args(packages))?;
    if has() { Ok(python) } else { Err(format!("{test}: fails with {}", packages.join(" "))) }
}
