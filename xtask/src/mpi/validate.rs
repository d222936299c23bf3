//! `--validate`: runs on two processes with late mails beside the simulator's word on them.
//!
//! The simulator's costs are those of its machine: a run on one process tells how many times slower
//! this one is, and virtual times are multiples of that. Mails that nobody delays take some time,
//! too: [`SHARED`].

use super::{Bench, WATCHDOG, watched, words_of};
use std::fs;

/// The delays of mails, in microseconds.
const DELAYS: [u32; 3] = [0, 100, 300];
/// Microseconds that a mail through shared memory takes, with the look of a process that finds it.
const SHARED: f64 = 2.0;
/// Runs whose median counts, and the points of each.
const RUNS: usize = 5;
const POINTS: &str = "100000";
/// The simulator's options for what processes do unless they are told otherwise.
const AS_PROCESSES: [&str; 4] = ["--window", "16", "--ownership", "newest"];
/// The figures, with their units.
const FIGURES: [&str; 3] = ["makespan, ms", "messages", "setbacks"];

/// Makespan in milliseconds, messages and setbacks.
type Figures = [f64; 3];

/// Prints a table: by delay and figure what the simulator predicts, what is measured, the ratio.
pub(super) fn run(bench: &Bench) -> Result<(), String> {
    let file = "validate.npy";
    let made =
        bench.ltbw(&words_of(&["generate", "uniform", POINTS, "--seed", "1", "-o", file]))?;
    if made.code != Some(0) {
        return Err(made.stderr);
    }
    let alone = median(bench, 1, 0)?[0];
    let own = simulated(bench, 1, 1e-3)?[0];
    let slower = alone / own;
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("{POINTS} points, medians of {RUNS}; load {}", load.trim());
    println!("one process: {alone:.0} ms, simulated {own:.0} ms: all costs are {slower:.2} times");
    println!("| delay, us | | predicted | measured | predicted / measured |");
    println!("|---|---|---|---|---|");
    for delay in DELAYS {
        let measured = median(bench, 2, delay)?;
        let mut predicted = simulated(bench, 2, (f64::from(delay) + SHARED) / slower)?;
        predicted[0] *= slower;
        for (k, name) in FIGURES.iter().enumerate() {
            let [one, other] = [predicted[k], measured[k]];
            println!("| {delay} | {name} | {one:.0} | {other:.0} | {:.2} |", one / other);
        }
    }
    Ok(())
}

/// The median of each figure of a few runs on processes.
fn median(bench: &Bench, count: u32, delay: u32) -> Result<Figures, String> {
    let mut runs: Vec<Figures> = Vec::new();
    for _ in 0..RUNS {
        let mut job = bench.job(count, &[]);
        job.env("LTBW_MPI_LATENCY_US", delay.to_string()).arg(&bench.ranked);
        job.args(["--quiet", "delaunay", "validate.npy", "--check", "off"]);
        let outcome = watched(job.args(["--json", "validate.json"]), WATCHDOG)?;
        if outcome.code != Some(0) {
            return Err(format!("{count} processes, {delay} us: {}", outcome.stderr));
        }
        let report = read(bench)?;
        let sum = |field| all(&report, field).iter().sum::<f64>();
        runs.push([1e3 * sum("insert"), sum("messages"), sum("setbacks")]);
    }
    Ok([0, 1, 2].map(|k| {
        let mut own: Vec<f64> = runs.iter().map(|run| run[k]).collect();
        own.sort_by(f64::total_cmp);
        own[RUNS / 2]
    }))
}

/// The simulator's figures, with mails that take `latency` of its microseconds.
fn simulated(bench: &Bench, count: u32, latency: f64) -> Result<Figures, String> {
    let (count, latency) = (count.to_string(), format!("{:.0}ns", 1e3 * latency));
    let command = ["simulate", "--processors", &count, "--latency", &latency, "--points", POINTS];
    let words = [&command[..], &AS_PROCESSES, &["--json", "validate.json"]].concat();
    let outcome = bench.ltbw(&words_of(&words))?;
    if outcome.code != Some(0) {
        return Err(outcome.stderr);
    }
    let report = read(bench)?;
    // The figures of the whole come before those of kinds and processors.
    let first = |field| all(&report, field).first().copied().unwrap_or(f64::NAN);
    Ok([1e-6 * first("makespan"), first("count"), first("setbacks")])
}

/// The report of the last run.
fn read(bench: &Bench) -> Result<String, String> {
    fs::read_to_string(bench.folder.join("validate.json")).map_err(|error| error.to_string())
}

/// The numbers of all fields of a name.
fn all(report: &str, field: &str) -> Vec<f64> {
    let name = format!("\"{field}\": ");
    let number = |line: &str| line.trim().strip_prefix(&name)?.trim_end_matches(',').parse().ok();
    report.lines().filter_map(number).collect()
}
