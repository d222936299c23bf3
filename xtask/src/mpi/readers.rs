//! `--readers`: what processes have written, read by the programs from which solvers take it.

use super::{Bench, Outcome, watched, words_of};
use crate::require;
use crate::shell::root;
use std::process::Command;
use std::time::Duration;

/// The exit code of the script when a package is missing.
const MISSING: i32 = 3;

/// The longest time of a script.
const PATIENCE: Duration = Duration::from_secs(600);

/// Lets DOLFINx read the domain's mesh `whole.msh` in the bench's folder, on two processes. Its
/// package is one for the Python of the system, and for Open MPI.
pub(crate) fn by_dolfinx(bench: &Bench, name: &str) -> Result<(), String> {
    let python = std::env::var("LTBW_DOLFINX_PYTHON");
    let python = python.unwrap_or_else(|_| "/usr/bin/python3".to_owned());
    let mut job = bench.job(2, false);
    job.arg(python).arg(root().join("tests/dolfinx_read.py")).arg("whole.msh");
    let outcome = watched(&mut job, PATIENCE)?;
    judge(&format!("{name} by DOLFINx"), &outcome, "whole files by DOLFINx", "dolfinx")
}

/// Compares the files `parts` in the bench's folder with what one process writes.
pub(crate) fn run(
    bench: &Bench,
    name: &str,
    arguments: &[String],
    count: u32,
) -> Result<(), String> {
    let whole = words_of(&["-o", "whole.vtu"]);
    let outcome = bench.ltbw(&[arguments, &whole].concat())?;
    if outcome.code != Some(0) {
        return Err(format!("{name}: {}", outcome.stderr));
    }
    let python = std::env::var("LTBW_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let mut command = Command::new(python);
    command.arg(root().join("tests/parted.py")).arg(&bench.folder);
    let outcome = watched(command.args(["whole.vtu", "parts", &count.to_string()]), PATIENCE)?;
    judge(&format!("{name} by readers"), &outcome, "readers of parts", "readback")
}

/// The verdict of a script on `run`; `what` is skipped where it lacks a package.
fn judge(run: &str, outcome: &Outcome, what: &str, tool: &str) -> Result<(), String> {
    print!("{run}: {}", outcome.stdout);
    match outcome.code {
        Some(0) => Ok(()),
        Some(MISSING) => require::skip(what, tool, outcome.stdout.trim()),
        _ => Err(format!("{run}: {}{}", outcome.stdout, outcome.stderr)),
    }
}
