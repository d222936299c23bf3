//! `dist`: published things, in `target/dist`: crates packaged without a warning, an archive of
//! the program with completions, manual, kit and licences, one of the C interface, the wheel.

use crate::shell::{self, cargo, command, root, target};
use crate::{c, python};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

const PARTS: [&str; 4] = ["crates", "program", "c", "python"];
/// Pages that go with everything.
const PAGES: [&str; 4] = ["CHANGELOG.md", "SECURITY.md", "LICENSE-MIT", "LICENSE-APACHE"];
const SHELLS: [(&str, &str); 3] = [
    ("bash", "share/bash-completion/completions/ltbw"),
    ("zsh", "share/zsh/site-functions/_ltbw"),
    ("fish", "share/fish/vendor_completions.d/ltbw.fish"),
];

/// Makes the parts that are named, or all.
pub(crate) fn run(parts: &[String]) -> Result<(), String> {
    if let Some(other) = parts.iter().find(|part| !PARTS.contains(&part.as_str())) {
        return Err(format!("dist {other}: one of {}", PARTS.join(", ")));
    }
    let is_wanted = |part: &str| parts.is_empty() || parts.iter().any(|other| other == part);
    let dist = target().join("dist");
    fs::create_dir_all(&dist).map_err(|error| told(&dist, &error))?;
    if is_wanted("crates") {
        crates()?;
    }
    if is_wanted("program") {
        program(&dist)?;
    }
    if is_wanted("c") {
        library(&dist)?;
    }
    if is_wanted("python") {
        let wheel = python::wheel(&dist)?;
        python::try_alone(&wheel)?;
        python::sources(&dist)?;
        println!("dist: {}, and the sources beside it", wheel.display());
    }
    Ok(())
}

fn told(path: &Path, error: &dyn std::fmt::Display) -> String {
    format!("{}: {error}", path.display())
}

/// Packages every crate that is published; a warning is a failure.
fn crates() -> Result<(), String> {
    let manifest = read(&root().join("Cargo.toml"))?;
    let members = manifest.split("members = [").nth(1).and_then(|rest| rest.split(']').next());
    let mut names = Vec::new();
    for member in members.unwrap_or_default().split('"').skip(1).step_by(2) {
        let manifest = read(&root().join(member).join("Cargo.toml"))?;
        let name = manifest.lines().find_map(|line| line.strip_prefix("name = "));
        if !manifest.contains("publish = false") {
            names.extend(name.map(|name| name.trim_matches('"').to_owned()));
        }
    }
    let mut packaging = cargo();
    packaging.args(["package", "--no-verify", "--allow-dirty"]);
    packaging.args(names.iter().flat_map(|name| ["-p", name]));
    let output = packaging.stderr(Stdio::piped()).output().map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() || text.contains("warning") || names.is_empty() {
        return Err(format!("{packaging:?}:\n{text}"));
    }
    println!("dist: packages of {}", names.join(", "));
    Ok(())
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| told(path, &error))
}

/// The program, and what it says of itself.
fn program(dist: &Path) -> Result<(), String> {
    let program = shell::program()?;
    let folder = fresh(dist, "ltbw")?;
    copy(&program, &folder.join("bin/ltbw"))?;
    for (shell, place) in SHELLS {
        let words = ["completions", shell];
        let output = command(&program.to_string_lossy()).args(words).output();
        let output = output.map_err(|error| told(&program, &error))?;
        if !output.status.success() || output.stdout.is_empty() {
            return Err(format!("completions for {shell}: {}", output.status));
        }
        write(&folder.join(place), &output.stdout)?;
    }
    let manual = folder.join("share/man/man1");
    fs::create_dir_all(&manual).map_err(|error| told(&manual, &error))?;
    let quiet = |words: [&str; 2], folder: &Path| {
        let mut command = command(&program.to_string_lossy());
        shell::run(command.arg("--quiet").args(words.iter().filter(|w| !w.is_empty())).arg(folder))
    };
    quiet(["man", ""], &manual)?;
    quiet(["vectors", "unpack"], &folder.join("share/ltbw/vectors"))?;
    let schemas = root().join("docs/schema");
    for entry in fs::read_dir(&schemas).map_err(|error| told(&schemas, &error))? {
        let entry = entry.map_err(|error| told(&schemas, &error))?;
        copy(&entry.path(), &folder.join("share/ltbw/schema").join(entry.file_name()))?;
    }
    let pages = folder.join("share/doc/ltbw");
    copy(&root().join("cli/README.md"), &pages.join("README.md"))?;
    archive(dist, &folder, &pages)
}

/// The C interface: header, libraries, pkg-config, examples.
fn library(dist: &Path) -> Result<(), String> {
    let built = c::build()?;
    let folder = fresh(dist, "ltbw-c")?;
    // Links stay links.
    fs::create_dir_all(dist).map_err(|error| told(dist, &error))?;
    shell::run(command("cp").arg("-a").arg(&built).arg(&folder))?;
    let pages = folder.join("share/doc/ltbw-c");
    for name in
        ["README.md", "examples/points.c", "examples/domain.cpp", "examples/cmake/CMakeLists.txt"]
    {
        copy(&root().join("bindings/c").join(name), &pages.join(name))?;
    }
    archive(dist, &folder, &pages)
}

/// An empty folder for an archive, by name, version and machine.
fn fresh(dist: &Path, name: &str) -> Result<PathBuf, String> {
    let version = read(&root().join("Cargo.toml"))?;
    let version = version.split("\nversion = \"").nth(1).and_then(|rest| rest.split('"').next());
    let (version, machine) = (version.unwrap_or("0"), std::env::consts::ARCH);
    let folder = dist.join(format!("{name}-{version}-{machine}-{}", std::env::consts::OS));
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(|error| told(&folder, &error))?;
    }
    Ok(folder)
}

/// Adds the pages that go with everything, and packs a folder: the same files make the same bytes.
fn archive(dist: &Path, folder: &Path, pages: &Path) -> Result<(), String> {
    PAGES.iter().try_for_each(|page| copy(&root().join(page), &pages.join(page)))?;
    let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let file = dist.join(format!("{name}.tar.gz"));
    let mut tar = command("tar");
    tar.args(["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=@0", "-C"]);
    shell::run(tar.arg(dist).args(["-I", "gzip -n", "-cf"]).arg(&file).arg(&name))?;
    println!("dist: {}", file.display());
    Ok(())
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let parent = to.parent().unwrap_or(to);
    fs::create_dir_all(parent).map_err(|error| told(parent, &error))?;
    fs::copy(from, to).map(drop).map_err(|error| told(from, &error))
}

fn write(to: &Path, bytes: &[u8]) -> Result<(), String> {
    let parent = to.parent().unwrap_or(to);
    fs::create_dir_all(parent).map_err(|error| told(parent, &error))?;
    fs::write(to, bytes).map_err(|error| told(to, &error))
}
