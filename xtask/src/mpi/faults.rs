//! Refusals of a job, and processes that panic, are killed or are stopped: each ends with a code
//! and a word about it, and none hangs.

use super::library::RANK;
use super::{Bench, Outcome, begin, end, watched, words_of};
use crate::shell;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// The longest time from a fault to the end of its job.
pub(super) const PATIENCE: Duration = Duration::from_secs(20);
/// The longest time from the loss of a process to the end of its job.
const LOSS: Duration = Duration::from_secs(5);
/// The longest time in which processes begin.
const BEGIN: Duration = Duration::from_secs(60);
/// The delay of mails that makes a run long: in microseconds.
const LATE: &str = "20000";
/// A job whose points take long with late mails.
const INSERTED: [&str; 2] = ["delaunay", "uniform-20000.npy"];
/// A job half of whose time is the first process's, which moves vertices.
const SMOOTHED: [&str; 6] = ["mesh", "tee.poly", "--max-volume", "2e-5", "--smooth", "16"];

/// Runs them all; returns their number.
pub(crate) fn run(bench: &Bench) -> Result<u32, String> {
    let folder = &bench.folder;
    fs::write(folder.join("nan.xyz"), "0 0 0\n1 0 0\n0 NaN 0\n0 0 1\n1 1 1\n")
        .map_err(|error| error.to_string())?;
    fs::write(folder.join("short.node"), "3 3 0 0\n1 0 0 0\n2 1 0 0\n")
        .map_err(|error| error.to_string())?;
    let refusals: [(&[&str], i32, &str); 10] = [
        (&["delaunay", "missing.npy"], 3, "missing.npy"),
        (&["delaunay", "nan.xyz"], 3, "ltbw: nan.xyz: line 3: `NaN` is not a finite number"),
        (&["delaunay", "short.node"], 3, "short.node: line 4: the file announces 3 points"),
        (&["mesh", "uniform-40.npy"], 3, "uniform-40.npy"),
        (&["delaunay", "uniform-40.npy", "--no-such-option"], 2, "--no-such-option"),
        (&["simulate"], 2, "delaunay and mesh"),
        (&["delaunay", "-", "--format", "npy"], 2, "stdin"),
        (&["delaunay", "uniform-40.npy", "--threads", "2", "--balance"], 2, "--balance"),
        (&["delaunay", "uniform-40.npy", "-o", "no-such-folder/m.vtu"], 6, "no-such-folder"),
        (&["delaunay", "uniform-40.npy", "-o", "no-such-folder/m.pvtu"], 6, "no-such-folder"),
    ];
    let mut count = 0;
    for (arguments, code, word) in refusals {
        let mut job = bench.job(2, false);
        let outcome = watched(job.arg(&bench.ranked).args(arguments), PATIENCE)?;
        expect(&format!("{arguments:?}"), &outcome, code, word)?;
        count += 1;
    }
    count += different(bench)? + full_disk(bench)?;
    for rank in 0..3 {
        let mut job = bench.job(3, false);
        let number = rank.to_string();
        job.env("LTBW_MPI_PANIC_RANK", &number).env("LTBW_MPI_PANIC_LETTER", "40");
        job.arg(&bench.ranked).args(["delaunay", "uniform-20000.npy"]);
        let outcome = watched(&mut job, PATIENCE)?;
        expect(&format!("a panic of rank {rank}"), &outcome, 70, &format!("rank {rank}: a panic"))?;
        count += 1;
    }
    for rank in 0..2 {
        let outcome = signalled(bench, rank, "KILL", 2, &INSERTED)?;
        expect(&format!("SIGKILL of rank {rank}"), &outcome, bench.mpi.code_of(9), "signal 9")?;
        let partial = folder.join("partial.vtu");
        _ = fs::remove_file(&partial);
        let job = [&INSERTED[..], &["-o", "partial.vtu", "--json", "partial.json"]].concat();
        let outcome = signalled(bench, rank, "TERM", 2, &job)?;
        expect(&format!("SIGTERM of rank {rank}"), &outcome, 4, "points meshed")?;
        let check = words_of(&["check", "partial.vtu", "--delaunay"]);
        let checked = bench.ltbw(&check)?;
        expect("the mesh so far", &checked, 0, "")?;
        count += 2;
    }
    for rank in 0..2 {
        let run = |seconds| signalled(bench, rank, "TERM", seconds, &SMOOTHED);
        let mut outcome = run(2)?;
        for seconds in [4, 8] {
            // A process that has not begun ends at once.
            if outcome.code == Some(bench.mpi.code_of(15)) {
                outcome = run(seconds)?;
            }
        }
        let what = format!("SIGTERM of rank {rank} as vertices are moved, or soon to be");
        expect(&what, &outcome, 4, "cancelled")?;
        count += 1;
    }
    Ok(count)
}

/// Processes that differ: in their command line, their build, their input.
fn different(bench: &Bench) -> Result<u32, String> {
    let folder = &bench.folder;
    let program = bench.ranked.to_string_lossy().into_owned();
    let other = folder.join("ltbw-mpi-of-another-build");
    let mut bytes = fs::read(&bench.ranked).map_err(|error| error.to_string())?;
    bytes.push(0);
    write_program(&other, &bytes)?;
    let other = other.to_string_lossy().into_owned();
    let apart = |first: &[&str], second: &[&str]| {
        let mut job = bench.job(1, false);
        watched(job.args(first).args([":", "-n", "1"]).args(second), PATIENCE)
    };
    let usual = [&*program, "delaunay", "uniform-40.npy"];
    let outcome = apart(&usual, &[&program, "delaunay", "sphere-5000.npy"])?;
    expect("another command line", &outcome, 2, "rank 1 has another command line")?;
    let outcome = apart(&usual, &[&other, "delaunay", "uniform-40.npy"])?;
    expect("another build", &outcome, 2, "rank 1 has another build")?;
    // Each in a folder of its own, with an input of the same name.
    let input = |rank: u32, from: &str| -> Result<(), String> {
        let own = folder.join(format!("rank-{rank}"));
        fs::create_dir_all(&own).map_err(|error| error.to_string())?;
        let copied = fs::copy(folder.join(from), own.join("points.npy"));
        copied.map(drop).map_err(|error| error.to_string())
    };
    input(0, "uniform-40.npy")?;
    // As long, and different in the second one's slice.
    let mut bytes = fs::read(folder.join("uniform-40.npy")).map_err(|error| error.to_string())?;
    bytes.iter_mut().rev().take(1).for_each(|byte| *byte ^= 1);
    fs::write(folder.join("other-40.npy"), bytes).map_err(|error| error.to_string())?;
    input(1, "other-40.npy")?;
    let script = &format!("cd rank-{RANK} && exec \"$0\" delaunay points.npy");
    let own_folders = || {
        let mut job = bench.job(2, false);
        watched(job.args(["sh", "-c", script, &program]), PATIENCE)
    };
    expect("another slice", &own_folders()?, 3, "rank 1 has read another input")?;
    input(1, "sphere-5000.npy")?;
    expect("another input", &own_folders()?, 3, "rank 1 has read another input")?;
    fs::remove_file(folder.join("rank-1/points.npy")).map_err(|error| error.to_string())?;
    expect("no input at one rank", &own_folders()?, 3, "rank 1: points.npy")?;
    let mut job = bench.job(2, false);
    job.env("LTBW_MPI_WAIT", "sometimes").args(usual);
    expect("another way to wait", &watched(&mut job, PATIENCE)?, 2, "spin, yield or nap")?;
    Ok(6)
}

/// A disk that is full at one process: no file gets its name.
fn full_disk(bench: &Bench) -> Result<u32, String> {
    bench.generate(&["uniform", "100000", "-o", "uniform-100000.npy"])?;
    for (rank, name) in [(0, "full.pvtu"), (1, "full.pvtu"), (0, "full.vtkhdf"), (1, "full.vtkhdf")]
    {
        // Blocks of 512 bytes: room for what an MPI writes itself, and not for a part.
        let script = &format!("[ {RANK} != {rank} ] || ulimit -f 10000; exec \"$0\" \"$@\"");
        let mut job = bench.job(2, false);
        job.args(["sh", "-c", script]).arg(&bench.ranked);
        job.args(["delaunay", "uniform-100000.npy", "-o", name]);
        let what = format!("a full disk at rank {rank}, {name}");
        expect(&what, &watched(&mut job, PATIENCE)?, 6, "File too large")?;
        let entries = fs::read_dir(&bench.folder).map_err(|error| error.to_string())?;
        let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
        if let Some(left) = names.into_iter().find(|name| name.contains("full")) {
            return Err(format!("{what}: {left} is left"));
        }
    }
    Ok(4)
}

/// Writes a program that can be run.
fn write_program(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()))?;
    shell::run(Command::new("chmod").arg("+x").arg(path))
}

/// The file in which a process tells its number.
pub(super) fn file_of(bench: &Bench, rank: u32) -> PathBuf {
    bench.folder.join(format!("rank-{rank}.pid"))
}

/// A job of some processes that tell their numbers, without arguments.
pub(super) fn telling(bench: &Bench, count: u32) -> Command {
    (0..count).for_each(|rank| _ = fs::remove_file(file_of(bench, rank)));
    let script = &format!("echo $$ > rank-{RANK}.pid && exec \"$0\" \"$@\"");
    let mut job = bench.job(count, false);
    job.args(["sh", "-c", script]).arg(&bench.ranked);
    job
}

/// The number of a process of such a job, as soon as it tells.
pub(super) fn pid_of(bench: &Bench, rank: u32) -> Option<u32> {
    let read = || fs::read_to_string(file_of(bench, rank)).ok()?.trim().parse().ok();
    within(BEGIN, read)
}

/// The first find within some time.
pub(super) fn within<T>(patience: Duration, find: impl Fn() -> Option<T>) -> Option<T> {
    let clock = Instant::now();
    while clock.elapsed() < patience {
        if let Some(found) = find() {
            return Some(found);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    None
}

/// A job whose process `rank` gets a signal `seconds` after it has begun; mails of points are late.
fn signalled(
    bench: &Bench,
    rank: u32,
    signal: &str,
    seconds: u64,
    arguments: &[&str],
) -> Result<Outcome, String> {
    let mut job = telling(bench, 2);
    if arguments.starts_with(&INSERTED) {
        job.env("LTBW_MPI_LATENCY_US", LATE);
    }
    job.args(["--progress", "json"]).args(arguments);
    let child = begin(&mut job)?;
    let Some(pid) = pid_of(bench, rank) else {
        let ended = end(child, Duration::ZERO).err().unwrap_or_default();
        return Err(format!("rank {rank} has not begun: {ended}"));
    };
    // The start takes a fraction of a second, the insertion with late mails many.
    std::thread::sleep(Duration::from_secs(seconds));
    shell::run(Command::new("kill").args([&format!("-{signal}"), &pid.to_string()]))?;
    end(child, if signal == "KILL" { LOSS } else { PATIENCE })
}

/// Makes sure that a run has ended with this code, and has said this.
pub(super) fn expect(what: &str, outcome: &Outcome, code: i32, word: &str) -> Result<(), String> {
    // The launcher of MPICH tells of signals on stdout.
    let told = [&outcome.stdout, &outcome.stderr].iter().any(|text| text.contains(word));
    if outcome.code == Some(code) && told {
        println!("{what}: {code}, {:.2} s", outcome.seconds);
        return Ok(());
    }
    let Outcome { code: found, stderr, .. } = outcome;
    Err(format!("{what}: code {found:?}, not {code}, or no word `{word}`:\n{stderr}"))
}
