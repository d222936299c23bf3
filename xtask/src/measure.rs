//! `bench` and `bars`: the programs `measure`, `measure_refine` and `measure_threads` of the tests
//! package, built with the release profile.

use crate::python;
use crate::require;
use crate::shell::{self, cargo, command, target};
use std::path::{Path, PathBuf};

/// Builds and runs `measure` with `mode` and `args`, or `measure_refine` for `bench refine` and
/// `measure_threads` for `bench threads`; `bench python` is of the Python package.
pub(crate) fn run(mode: &str, args: &[String]) -> Result<(), String> {
    if mode == "bench" && args == ["refine"] {
        return refine();
    }
    if mode == "bench" && args.first().is_some_and(|name| name == "threads") {
        return threads(&args[1..]);
    }
    if mode == "bench" && args == ["instructions"] {
        return instructions();
    }
    if mode == "bench" && args.first().is_some_and(|name| name == "quality") {
        return quality("beside.py", &args[1..]);
    }
    if mode == "bench" && args == ["iterations"] {
        return quality("iterations.py", &[]);
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

/// Dihedral angles beside TetGen's, Gmsh's and CGAL's, or what they cost, by a script of
/// `tests/quality`.
fn quality(script: &str, args: &[String]) -> Result<(), String> {
    let packages = ["numpy==2.4.6", "tetgen==0.8.4", "gmsh==4.15.2"];
    let test = "import numpy, tetgen, gmsh";
    let python = match shell::python("quality-python", &packages, test) {
        Ok(python) => python,
        Err(reason) => return require::skip("what dihedral angles are worth", "gmsh", &reason),
    };
    let mut measure = command(&python.to_string_lossy());
    measure.arg(format!("tests/quality/{script}"));
    measure.arg(shell::program()?).arg(target().join("quality"));
    shell::run(measure.args(args))
}

/// Refinement against TetGen.
fn refine() -> Result<(), String> {
    println!();
    let program = ["--release", "-p", "ltbw-tests", "--bin", "measure_refine"];
    shell::run(cargo().env("RAYON_NUM_THREADS", "1").args(["run", "--quiet"]).args(program))
}

/// Instructions of a build of 100,000 uniform points, and of `ltbw mesh` on two model domains, by
/// callgrind: figures for regressions that no noise touches. Of `mesh` also beside the program of
/// the commit before, which `LTBW_BEFORE_PROGRAM` names.
fn instructions() -> Result<(), String> {
    if !shell::works(command("valgrind").arg("--version")) {
        return require::skip("instruction counts", "valgrind", "valgrind is not installed");
    }
    let example = ["--release", "-p", "ltbw-core", "--example", "build_speed"];
    shell::run(cargo().args(["build", "--quiet"]).args(example))?;
    let example = target().join("release/examples/build_speed");
    let count = counted(&example, &["uniform", "100000"])?;
    println!("\ninstructions to generate and build 100,000 uniform points: {}", grouped(count));
    let before = std::env::var_os("LTBW_BEFORE_PROGRAM").map(PathBuf::from);
    let program = shell::program()?;
    for (domain, volume) in [("gear", "1e-4"), ("tee", "1e-4")] {
        let file = target().join(format!("bench-{domain}.poly")).to_string_lossy().into_owned();
        shell::run(command(&program.to_string_lossy()).args(["generate", domain, "-o", &file]))?;
        let words = ["mesh", &file, "--max-volume", volume, "--quiet"];
        let now = counted(&program, &words)?;
        println!("instructions of `mesh` on {domain}, volume {volume}: {}", grouped(now));
        if let Some(before) = &before {
            let then = counted(before, &words)?;
            let more = (now as f64 / then as f64 - 1.0) * 100.0;
            println!("  {} before: {more:+.2} %", grouped(then));
            if more > MOST {
                return Err(format!("`mesh` on {domain} takes {more:.2} % more instructions"));
            }
        }
    }
    match before {
        Some(_) => Ok(()),
        None => {
            let reason = "LTBW_BEFORE_PROGRAM names no program of it";
            require::skip("the commit before", "before", reason)
        }
    }
}

/// The most instructions that a change may add, in percent.
const MOST: f64 = 2.0;

/// A number with its digits in groups of three.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().map(text).collect();
    groups.join(",")
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap_or_default()
}

/// Instructions of a program on one thread.
fn counted(program: &Path, words: &[&str]) -> Result<u64, String> {
    let output = command("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(words)
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .map_err(|e| format!("valgrind: {e}"))?;
    let log = String::from_utf8_lossy(&output.stderr);
    let count = log.lines().find_map(|line| line.split_once("refs:"));
    let count = count.and_then(|(_, count)| count.trim().replace(',', "").parse().ok());
    count.ok_or_else(|| format!("valgrind printed no count: {log}"))
}
