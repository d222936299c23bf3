//! `c`: the C interface of `bindings/c`: lints, tests, header; tests and examples in C and C++
//! compiled and run under valgrind, one also by the pkg-config file and by CMake; the conformance
//! kit through the library. What users install goes to `target/c/dist`.

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

/// A surface to mesh: the unit cube.
const CUBE: &str = "OFF\n8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n\
    4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

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
    let (static_library, shared) = (lib.join("libltbw.a"), format!("-L{}", lib.display()));
    let rpath = format!("-Wl,-rpath,{}", lib.display());
    let compiled = |source: &str| -> Result<PathBuf, String> {
        let program = own_target.join(source.replace(['/', '.'], "-"));
        // C is linked with the archive, C++ with the shared library.
        let mut compiler = command(if source.ends_with(".c") { "cc" } else { "c++" });
        compiler.args(FLAGS).arg(&include).arg(package.join(source));
        match source.ends_with(".c") {
            true => {
                compiler.arg("-std=c11").arg(&static_library).args(["-lm", "-lpthread", "-ldl"])
            }
            false => compiler.args(["-std=c++17", &shared, "-lltbw", &rpath]),
        };
        shell::run(compiler.arg("-o").arg(&program))?;
        Ok(program)
    };
    let valgrind = |program: &Path| {
        let mut command = command("valgrind");
        command.current_dir(&own_target).args(VALGRIND).arg(program);
        command
    };
    let surface = own_target.join("cube.off");
    fs::write(&surface, CUBE).map_err(|error| told(&surface, &error))?;
    for source in ["tests/points.c", "tests/domain.cpp", "examples/points.c"] {
        shell::run(valgrind(&compiled(source)?).arg(own_target.join("domain.vtu")))?;
    }
    let example = compiled("examples/domain.cpp")?;
    shell::run(valgrind(&example).arg(surface).arg(own_target.join("part.vtu")))?;
    by_pkg_config(&package, &dist, &own_target)?;
    by_cmake(&package, &dist, &own_target)?;
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
    let mut example = command(&program.to_string_lossy());
    shell::run(example.current_dir(own_target).env("LD_LIBRARY_PATH", library))
}

/// Builds and runs a project of CMake that finds the package.
fn by_cmake(package: &Path, dist: &Path, own_target: &Path) -> Result<(), String> {
    if !shell::works(command("cmake").arg("--version")) {
        let reason = "cmake does not start";
        return require::skip("the CMake package of the C interface", "cmake", reason);
    }
    let folder = own_target.join("cmake");
    let mut configure = command("cmake");
    configure.arg("-S").arg(package.join("examples/cmake")).arg("-B").arg(&folder);
    shell::run(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", dist.display())))?;
    shell::run(command("cmake").arg("--build").arg(&folder))?;
    shell::run(command(&folder.join("points").to_string_lossy()).current_dir(&folder))
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
    install(&dist)?;
    Ok(dist)
}

/// Puts header, libraries, and what pkg-config and CMake read where users would have them.
fn install(dist: &Path) -> Result<(), String> {
    let version = version()?;
    let [major, minor] = [0, 1].map(|i| version.split('.').nth(i).unwrap_or("0"));
    let package = root().join("bindings/c");
    let lib = dist.join("lib");
    let cmake = lib.join("cmake/ltbw");
    for folder in [&dist.join("include"), &lib.join("pkgconfig"), &cmake] {
        fs::create_dir_all(folder).map_err(|error| told(folder, &error))?;
    }
    let copy =
        |from: &Path, to: &Path| fs::copy(from, to).map(drop).map_err(|error| told(from, &error));
    let built = shell::bindings().join("release");
    copy(&package.join("include/ltbw.h"), &dist.join("include/ltbw.h"))?;
    copy(&package.join("ltbw-config.cmake"), &cmake.join("ltbw-config.cmake"))?;
    copy(&built.join("libltbw.a"), &lib.join("libltbw.a"))?;
    // The loader asks for the major version, the linker for the plain name.
    let whole = format!("libltbw.so.{version}");
    copy(&built.join("libltbw.so"), &lib.join(&whole))?;
    for (link, to) in [(format!("libltbw.so.{major}"), &whole), ("libltbw.so".into(), &whole)] {
        let link = lib.join(link);
        _ = fs::remove_file(&link);
        std::os::unix::fs::symlink(to, &link).map_err(|error| told(&link, &error))?;
    }
    let filled = |name: &str, to: &Path| {
        let from = package.join(name);
        let text = fs::read_to_string(&from).map_err(|error| told(&from, &error))?;
        let text = text.replace("@VERSION@", &version);
        let text = text.replace("@MAJOR@", major).replace("@MINOR@", minor);
        fs::write(to, text).map_err(|error| told(to, &error))
    };
    filled("ltbw.pc.in", &lib.join("pkgconfig/ltbw.pc"))?;
    filled("ltbw-config-version.cmake.in", &cmake.join("ltbw-config-version.cmake"))
}

/// The version of the C interface.
fn version() -> Result<String, String> {
    let manifest = root().join("bindings/c/Cargo.toml");
    let text = fs::read_to_string(&manifest).map_err(|error| told(&manifest, &error))?;
    let version = text.split("\nversion = \"").nth(1).and_then(|rest| rest.split('"').next());
    version.map(str::to_owned).ok_or_else(|| format!("{}: no version", manifest.display()))
}

fn told(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
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
