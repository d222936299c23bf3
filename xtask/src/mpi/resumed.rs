//! A job that loses a process, and jobs of other sizes that go on from its checkpoint: to the mesh
//! of one process, or to a refusal with its word.

use super::faults::{PATIENCE, expect, pid_of, telling, within};
use super::{Bench, Outcome, WATCHDOG, begin, end, watched};
use crate::shell;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// The command that all give.
const MESH: [&str; 6] = ["mesh", "kept.poly", "--max-volume", "5e-5", "-o", "kept.vtu"];
/// The checkpoint, a copy of it, and the rounds from one to the next.
const KEPT: &str = "kept.checkpoint";
const COPY: &str = "kept.copy";
const ROUNDS: &str = "4";
/// The delay of mails that makes the first job long: in microseconds.
const LATE: &str = "3000";

/// Runs them all; returns their number.
pub(crate) fn run(bench: &Bench) -> Result<u32, String> {
    let file = |name: &str| bench.folder.join(name);
    copy(&file("cube-octahedron.poly"), &file("kept.poly"))?;
    let words: Vec<String> = MESH.iter().map(|word| (*word).to_owned()).collect();
    let alone = bench.ltbw(&words)?;
    [KEPT, COPY, "kept.vtu"].iter().for_each(|name| _ = fs::remove_file(file(name)));
    let outcome = killed(bench)?;
    let code = bench.mpi.code_of(9);
    expect("SIGKILL of rank 1 after a checkpoint", &outcome, code, "signal 9")?;
    if file("kept.vtu").exists() {
        return Err("a job that has lost a process has written a mesh".to_owned());
    }
    copy(&file(KEPT), &file(COPY))?;
    for count in [1, 2, 3] {
        copy(&file(COPY), &file(KEPT))?;
        let outcome = resumed(bench, count, &[])?;
        expect(&format!("{count} go on"), &outcome, 0, "goes on after")?;
        if outcome.stdout != alone.stdout {
            return Err(format!("{count} go on: {}, not {}", outcome.stdout, alone.stdout));
        }
    }
    let mut bytes = fs::read(file(COPY)).map_err(|error| error.to_string())?;
    copy(&file(COPY), &file(KEPT))?;
    let outcome = resumed(bench, 2, &["--radius-edge", "1.9"])?;
    expect("a checkpoint of another command line", &outcome, 2, "another command line")?;
    copy(&file("tee.poly"), &file("kept.poly"))?;
    let outcome = resumed(bench, 2, &[])?;
    expect("a checkpoint of another input", &outcome, 3, "a checkpoint of another input")?;
    copy(&file("cube-octahedron.poly"), &file("kept.poly"))?;
    bytes.iter_mut().rev().take(1).for_each(|byte| *byte ^= 1);
    fs::write(file(KEPT), bytes).map_err(|error| error.to_string())?;
    let outcome = resumed(bench, 2, &[])?;
    expect("a damaged checkpoint", &outcome, 3, "its hash is not what it says")?;
    let mut job = bench.job(2, false);
    job.env("LTBW_MPI_CHECKPOINT", KEPT).arg(&bench.ranked).args(["delaunay", "uniform-40.npy"]);
    expect("a checkpoint of points", &watched(&mut job, PATIENCE)?, 2, "is for domains")?;
    let outcome = resumed(bench, 2, &["--mode", "async"])?;
    expect("a checkpoint without rounds", &outcome, 2, "is for rounds")?;
    Ok(9)
}

/// A job that loses a process as soon as it has a checkpoint.
fn killed(bench: &Bench) -> Result<Outcome, String> {
    let mut job = telling(bench, 2);
    job.env("LTBW_MPI_CHECKPOINT", KEPT).env("LTBW_MPI_CHECKPOINT_ROUNDS", ROUNDS);
    let child = begin(job.env("LTBW_MPI_LATENCY_US", LATE).args(MESH))?;
    let pid = pid_of(bench, 1);
    let is_kept = || bench.folder.join(KEPT).exists().then_some(());
    let (Some(pid), Some(())) = (pid, within(WATCHDOG, is_kept)) else {
        let ended = end(child, Duration::ZERO).err().unwrap_or_default();
        return Err(format!("no checkpoint: {ended}"));
    };
    shell::run(Command::new("kill").args(["-KILL", &pid.to_string()]))?;
    end(child, PATIENCE)
}

/// A job that goes on.
fn resumed(bench: &Bench, count: u32, more: &[&str]) -> Result<Outcome, String> {
    let mut job = bench.job(count, false);
    job.env("LTBW_MPI_CHECKPOINT", KEPT).env("LTBW_MPI_CHECKPOINT_ROUNDS", ROUNDS);
    watched(job.arg(&bench.ranked).args(MESH).args(more), WATCHDOG)
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    fs::copy(from, to).map(drop).map_err(|error| format!("{}: {error}", from.display()))
}
