//! `c`: the C interface of `bindings/c`: lints, tests, header, both examples compiled and run under
//! valgrind, one also by the pkg-config file, the conformance kit through the library. What users
//! install goes to `target/c/dist`.

use crate::require;
use crate::shell::{self, cargo, command, root, target};
use std::fs;
use std::path::{Path, PathBuf};

/// Warnings are errors.
const FLAGS: [&str; 5] = ["-Wall", "-Wextra", "-Werror", "-O1", "-g"];

/// Leaks of memory that nobody points to; what the runtime keeps for the process's life is none.
/// Threads take turns: else the one that works may starve the one that is to stop it.
const VALGRIND: [&str; 6] = [
    "--quiet",
    "--fair-sched=yes",
    "--leak-check=full",
    "--show-leak-kinds=definite,indirect",
    "--errors-for-leak-kinds=definite,indirect",
    "--error-exitcode=9",
];

/// Lints, builds, compiles, runs.
pub(crate) fn run() -> Result<(), String> {
    let package = root().join("bindings/c");
    let own_target = target().join("c");
    in_package(&["fmt", "--check"])?;
    in_package(&["clippy", "--quiet", "--release", "--all-targets", "--", "-D", "warnings"])?;
    in_package(&["test", "--quiet", "--release", "--tests"])?;
    let dist = build()?;
    for tool in ["cc", "c++", "valgrind"] {
        if !shell::works(command(tool).arg("--version")) {
            let reason = format!("{tool} does not start");
            return require::skip("the examples of the C interface", tool, &reason);
        }
    }
    let (include, lib) = (dist.join("include"), dist.join("lib"));
    let include = format!("-I{}", include.display());
    let points = own_target.join("points");
    let mut cc = command("cc");
    cc.args(FLAGS).args(["-std=c11", &include]).arg(package.join("examples/points.c"));
    cc.arg(lib.join("libltbw.a")).args(["-lm", "-lpthread", "-ldl", "-o"]).arg(&points);
    shell::run(&mut cc)?;
    let domain = own_target.join("domain");
    let mut cxx = command("c++");
    cxx.args(FLAGS).args(["-std=c++17", &include]).arg(package.join("examples/domain.cpp"));
    cxx.arg(format!("-L{}", lib.display())).arg("-lltbw");
    cxx.arg(format!("-Wl,-rpath,{}", lib.display())).arg("-o").arg(&domain);
    shell::run(&mut cxx)?;
    let valgrind = |program: &Path| {
        let mut command = command("valgrind");
        command.args(VALGRIND).arg(program);
        command
    };
    shell::run(&mut valgrind(&points))?;
    by_pkg_config(&package, &dist, &own_target)?;
    shell::run(valgrind(&domain).arg(own_target.join("domain.vtu")))?;
    kit(&lib.join("libltbw.so"))
}

/// Compiles and runs an example with no more than what the pkg-config file says.
fn by_pkg_config(package: &Path, dist: &Path, own_target: &Path) -> Result<(), String> {
    let mut pkg_config = command("pkg-config");
    pkg_config.env("PKG_CONFIG_PATH", dist.join("lib/pkgconfig"));
    let output = pkg_config.args(["--cflags", "--libs", "ltbw"]).output();
    let Ok(output) = output else {
        let reason = "pkg-config does not start";
        return require::skip("the pkg-config file of the C interface", "pkg-config", reason);
    };
    if !output.status.success() {
        return Err(format!("{pkg_config:?}: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let flags = String::from_utf8_lossy(&output.stdout).into_owned();
    let program = own_target.join("points-by-pkg-config");
    let mut cc = command("cc");
    cc.args(FLAGS).arg("-std=c11").arg(package.join("examples/points.c"));
    shell::run(cc.args(flags.split_whitespace()).arg("-o").arg(&program))?;
    let library = dist.join("lib");
    shell::run(command(&program.to_string_lossy()).env("LD_LIBRARY_PATH", library))
}

/// Runs cargo in the package.
fn in_package(arguments: &[&str]) -> Result<(), String> {
    let mut cargo = command(&cargo().get_program().to_string_lossy());
    cargo.current_dir(root().join("bindings/c")).env("CARGO_TARGET_DIR", shell::bindings());
    shell::run(cargo.args(arguments))
}

/// Builds the libraries; the folder of what users install.
pub(crate) fn build() -> Result<PathBuf, String> {
    let dist = target().join("c/dist");
    in_package(&["build", "--quiet", "--release"])?;
    let failed = |error| format!("{}: {error}", dist.display());
    install(&root().join("bindings/c"), &dist).map_err(failed)?;
    Ok(dist)
}

/// Puts header, libraries and the pkg-config file where users would have them.
fn install(package: &Path, dist: &Path) -> std::io::Result<()> {
    let (include, lib) = (dist.join("include"), dist.join("lib"));
    fs::create_dir_all(&include)?;
    fs::create_dir_all(lib.join("pkgconfig"))?;
    fs::copy(package.join("include/ltbw.h"), include.join("ltbw.h"))?;
    for name in ["libltbw.so", "libltbw.a"] {
        fs::copy(shell::bindings().join("release").join(name), lib.join(name))?;
    }
    let text = fs::read_to_string(package.join("ltbw.pc.in"))?;
    let text = text.replace("@PREFIX@", &dist.to_string_lossy());
    fs::write(lib.join("pkgconfig/ltbw.pc"), text)
}

/// The conformance kit through the library: all that it says it can must be right.
fn kit(library: &Path) -> Result<(), String> {
    let program = shell::program()?;
    let mut command = command(&program.to_string_lossy());
    command.args(["vectors", "run", "--folder", "predicates", "--folder", "delaunay"]);
    command.args(["--executor", "python3", "--"]);
    command.arg("bindings/c/tests/executor.py").arg(library);
    shell::run(&mut command)
}
