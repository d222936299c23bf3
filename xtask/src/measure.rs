//! `bench` and `bars`: the programs `measure`, `measure_refine` and `measure_threads` of the tests
//! package, built with the release profile.

use crate::python;
use crate::require;
use crate::shell::{self, cargo, command, target};

/// Builds and runs `measure` with `mode` and `args`, or `measure_refine` for `bench refine` and
/// `measure_threads` for `bench threads`; `bench python` is of the Python package.
pub(crate) fn run(mode: &str, args: &[String]) -> Result<(), String> {
    if mode == "bench" && args == ["refine"] {
        return refine();
    }
    if mode == "bench" && args.first().is_some_and(|name| name == "threads") {
        return threads(&args[1..]);
    }
    if mode == "bench" && args.first().is_some_and(|name| name == "python") {
        return python::bench(&args[1..]);
    }
    // One thread, ordering included: that is what CGAL's sequential version gets.
    shell::run(
        cargo()
            .env("RAYON_NUM_THREADS", "1")
            .args([
                "run",
                "--quiet",
                "--release",
                "-p",
                "ltbw-tests",
                "--bin",
                "measure",
                "--",
                mode,
            ])
            .args(args),
    )?;
    if mode == "bench" && args.is_empty() {
        refine()?;
        return instructions();
    }
    Ok(())
}

/// The parallel kernel against the sequential one and CGAL's parallel version.
fn threads(args: &[String]) -> Result<(), String> {
    let program = ["--release", "-p", "ltbw-tests", "--bin", "measure_threads"];
    shell::run(cargo().args(["run", "--quiet"]).args(program).arg("--").args(args))
}

/// Refinement against TetGen.
fn refine() -> Result<(), String> {
    println!();
    let program = ["--release", "-p", "ltbw-tests", "--bin", "measure_refine"];
    shell::run(cargo().env("RAYON_NUM_THREADS", "1").args(["run", "--quiet"]).args(program))
}

/// Instructions of a build of 100,000 uniform points, by callgrind: a figure for regressions that
/// no noise touches.
fn instructions() -> Result<(), String> {
    if !shell::works(command("valgrind").arg("--version")) {
        return require::skip("instruction counts", "valgrind", "valgrind is not installed");
    }
    let example = ["--release", "-p", "ltbw-core", "--example", "build_speed"];
    shell::run(cargo().args(["build", "--quiet"]).args(example))?;
    let program = target().join("release/examples/build_speed");
    let output = command("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(["uniform", "100000"])
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .map_err(|e| format!("valgrind: {e}"))?;
    let log = String::from_utf8_lossy(&output.stderr);
    let count = log.lines().find_map(|line| line.split_once("refs:"));
    let (_, count) = count.ok_or_else(|| format!("valgrind printed no count: {log}"))?;
    println!("\ninstructions to generate and build 100,000 uniform points: {}", count.trim());
    Ok(())
}
