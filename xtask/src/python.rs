//! `python`: the package of `bindings/python`, linted, built as a wheel, installed into a Python of
//! its own beside what cargo builds, and tested.

use crate::shell::{self, cargo, command, root, target};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The packages that build and test it; Zig is the linker that asks for no newer C library than the
/// wheel's tag says.
const PACKAGES: [&str; 8] = [
    "maturin==1.16.0",
    "ziglang==0.15.2",
    "numpy==2.4.6",
    "pytest==9.2.0",
    "meshio==5.3.5",
    "pyvista==0.49.1",
    "scipy==1.17.1",
    "scikit-fem==12.0.2",
];

/// Tells whether they are there.
const TEST: &str = "import maturin, numpy, pytest, meshio, pyvista, scipy, skfem";

/// The tag of wheels for Linux: they run where the C library is as old as that, from 2018.
const MANYLINUX: &str = "manylinux_2_28";

/// The first lines of a user, in a Python without anything but the wheel.
const FIRST: &str = "\
import ltbw
cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
mesh = ltbw.tetrahedralize((cube, faces), size=0.2)
assert mesh.outcome == 'met' and mesh.certificate, mesh.outcome
mesh.save('first.vtu')
";

/// Lints, builds, installs, tests.
pub(crate) fn run() -> Result<(), String> {
    let cargo_program = cargo().get_program().to_string_lossy().into_owned();
    shell::run(in_package(&cargo_program).args(["fmt", "--check"]))?;
    let clippy = ["clippy", "--quiet", "--release", "--all-targets", "--", "-D", "warnings"];
    shell::run(in_package(&cargo_program).args(clippy))?;
    let python = installed()?;
    let program = shell::program()?;
    let tests = |arguments: &[&str]| {
        let mut pytest = in_package(&python);
        pytest.args(["-m", "pytest", "-q"]).args(arguments).env("LTBW_PROGRAM", &program);
        shell::run(&mut pytest)
    };
    tests(&[])?;
    tests(&["--doctest-modules", "--pyargs", "ltbw"])?;
    shell::run(in_package(&python).arg("tutorial.py"))
}

/// Measures the package beside the program: `bench.py`.
pub(crate) fn bench(arguments: &[String]) -> Result<(), String> {
    let (python, program) = (installed()?, shell::program()?);
    shell::run(in_package(&python).arg("bench.py").arg(&program).args(arguments))
}

/// A program that runs in the package's folder.
fn in_package(program: &str) -> Command {
    let mut command = command(program);
    command.current_dir(root().join("bindings/python"));
    command.env("CARGO_TARGET_DIR", shell::bindings());
    command
}

/// Builds the wheel and installs it into the Python of its own, whose path it returns.
fn installed() -> Result<String, String> {
    let python = shell::python("python-bindings", &PACKAGES, TEST)?.to_string_lossy().into_owned();
    let wheel = wheel(&target().join("python/dist"))?;
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    let fresh = ["--force-reinstall", "--no-deps"];
    shell::run(in_package(&python).args(install).args(fresh).arg(&wheel))?;
    Ok(python)
}

/// Builds the wheel, the only one of its folder.
pub(crate) fn wheel(wheels: &Path) -> Result<PathBuf, String> {
    let python = shell::python("python-bindings", &PACKAGES, TEST)?;
    // Only one wheel is to be installed or handed out: this one.
    if let Ok(old) = wheel_in(wheels) {
        std::fs::remove_file(&old).map_err(|error| format!("{}: {error}", old.display()))?;
    }
    let mut maturin = in_package(&python.to_string_lossy());
    maturin.args(["-m", "maturin", "build", "--release", "--quiet", "--locked", "--out"]);
    maturin.arg(wheels).arg("-i").arg(&python);
    if cfg!(target_os = "linux") {
        maturin.args(["--zig", "--compatibility", MANYLINUX]);
        // It asks a Python of the path for Zig.
        let path = std::env::var("PATH").unwrap_or_default();
        let own = python.parent().unwrap_or(&python).to_string_lossy();
        maturin.env("PATH", format!("{own}:{path}"));
    }
    shell::run(&mut maturin)?;
    let wheel = wheel_in(wheels)?;
    let name = wheel.file_name().unwrap_or_default().to_string_lossy();
    if cfg!(target_os = "linux") && !name.contains(MANYLINUX) {
        return Err(format!("{name}: no wheel for {MANYLINUX}"));
    }
    Ok(wheel)
}

/// Packs the sources as pip builds them.
pub(crate) fn sources(folder: &Path) -> Result<(), String> {
    let python = shell::python("python-bindings", &PACKAGES, TEST)?;
    let mut maturin = in_package(&python.to_string_lossy());
    shell::run(maturin.args(["-m", "maturin", "sdist", "--out"]).arg(folder))
}

/// Installs a wheel into a Python that has nothing else, and meshes, without Rust in reach.
pub(crate) fn try_alone(wheel: &Path) -> Result<(), String> {
    let folder = target().join("python-alone");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    shell::run(command("python3").args(["-m", "venv"]).arg(&folder))?;
    let alone = || {
        let mut python = command(&folder.join("bin/python").to_string_lossy());
        python.current_dir(&folder).env("PATH", folder.join("bin"));
        python
    };
    let start = std::time::Instant::now();
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    shell::run(alone().args(install).arg(wheel))?;
    shell::run(alone().args(["-c", FIRST]))?;
    println!("a Python of its own: installed, and meshed, in {} s", start.elapsed().as_secs());
    Ok(())
}

/// The wheel in a folder.
fn wheel_in(folder: &Path) -> Result<PathBuf, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths = entries.filter_map(Result::ok).map(|entry| entry.path());
    let wheel = paths.find(|path| path.extension().is_some_and(|e| e == "whl"));
    wheel.ok_or_else(|| format!("{}: no wheel", folder.display()))
}
