//! `--validate`: runs on two processes with late letters beside the simulator's word on them.
//!
//! The simulator's costs are those of its machine. Runs on one process, two beside each other, as
//! two cores share their memory, tell how many times slower this one is, and virtual times are
//! multiples of that; a run on two with fewer points and no delay, what a letter costs that goes by
//! MPI. All else is predicted.

use super::{Bench, WATCHDOG, begin, end, words_of};
use std::fs;

/// The delays of letters, in microseconds.
const DELAYS: [u32; 3] = [0, 100, 300];
/// Microseconds that a letter through shared memory takes, with the look that finds it.
const SHARED: f64 = 2.0;
/// Runs whose median counts.
const RUNS: usize = 5;
/// Runs of the simulator, each with a seed of its own.
const SEEDS: usize = 10;
/// The points of a run, and of those that tell the costs of letters.
const POINTS: &str = "100000";
const FEWER: &str = "20000";
/// Halvings until the cost of a letter is known.
const HALVINGS: usize = 10;
/// The figures, with their units.
const FIGURES: [&str; 3] = ["makespan, ms", "messages", "setbacks"];

/// Makespan in milliseconds, messages and setbacks.
type Figures = [f64; 3];

/// A run to be simulated; times in the simulator's microseconds.
#[derive(Clone, Copy)]
struct Simulated<'a> {
    points: &'a str,
    processors: u32,
    latency: f64,
    /// A letter at either end.
    message: f64,
    seed: usize,
}

/// Prints a table: by delay and figure what the simulator predicts, what is measured, the ratio.
pub(super) fn run(bench: &Bench) -> Result<(), String> {
    for points in [POINTS, FEWER] {
        let file = format!("validate-{points}.npy");
        let words = words_of(&["generate", "uniform", points, "--seed", "1", "-o", &file]);
        let made = bench.ltbw(&words)?;
        if made.code != Some(0) {
            return Err(made.stderr);
        }
    }
    let beside = Jobs { beside: 2, processes: 1, delay: 0 };
    let alone = measured(bench, POINTS, beside)?.median[0];
    let one = Simulated { points: POINTS, processors: 1, latency: 1e-3, message: 0.5, seed: 1 };
    let own = simulated(bench, one)?[0];
    let slower = alone / own;
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("{POINTS} points, medians of {RUNS}; load {}", load.trim());
    println!("one process beside another: {alone:.0} ms, simulated {own:.0} ms");
    println!("all costs are {slower:.2} times");
    let two = Simulated { processors: 2, ..one };
    let message = message_of(bench, two, slower)?;
    println!("a letter costs {:.2} us at either end, by {FEWER} points", message * slower);
    println!("setbacks: the mean of {SEEDS} seeds, with their standard deviation");
    println!("| delay, us | | predicted | measured | predicted / measured |");
    println!("|---|---|---|---|---|");
    for delay in DELAYS {
        let found = measured(bench, POINTS, Jobs { delay, ..OF_TWO })?;
        let latency = (f64::from(delay) + SHARED) / slower;
        let of_seed = |seed| simulated(bench, Simulated { latency, message, seed, ..two });
        let runs: Vec<Figures> = (1..=SEEDS).map(of_seed).collect::<Result<_, _>>()?;
        let [mut time, messages, setbacks] = [0, 1, 2].map(|k| spread(&runs, k));
        time[0] *= slower;
        for (k, [mean, deviation]) in [time, messages, setbacks].into_iter().enumerate() {
            let (name, own) = (FIGURES[k], found.median[k]);
            let spread = if k == 2 { format!(" ± {deviation:.0}") } else { String::new() };
            let range = format!("{own:.0} ({:.0} to {:.0})", found.least[k], found.largest[k]);
            println!("| {delay} | {name} | {mean:.0}{spread} | {range} | {:.2} |", mean / own);
        }
    }
    Ok(())
}

/// The time that a letter takes at either end, in the simulator's microseconds: that with which it
/// predicts the makespan of fewer points on two processes without a delay.
fn message_of(bench: &Bench, two: Simulated<'_>, slower: f64) -> Result<f64, String> {
    let measured = measured(bench, FEWER, OF_TWO)?.median[0];
    let (mut low, mut high) = (0.1, 50.0);
    for _ in 0..HALVINGS {
        let message = f64::midpoint(low, high);
        let latency = SHARED / slower;
        let own = simulated(bench, Simulated { points: FEWER, latency, message, ..two })?[0];
        match own * slower < measured {
            true => low = message,
            false => high = message,
        }
    }
    Ok(f64::midpoint(low, high))
}

/// The mean and the standard deviation of a figure.
fn spread(runs: &[Figures], k: usize) -> [f64; 2] {
    let count = runs.len() as f64;
    let mean = runs.iter().map(|run| run[k]).sum::<f64>() / count;
    let squares = runs.iter().map(|run| (run[k] - mean) * (run[k] - mean)).sum::<f64>();
    [mean, (squares / (count - 1.0)).sqrt()]
}

/// Jobs at a time, the processes of each, and the delay of their letters in microseconds.
#[derive(Clone, Copy)]
struct Jobs {
    beside: usize,
    processes: u32,
    delay: u32,
}

const OF_TWO: Jobs = Jobs { beside: 1, processes: 2, delay: 0 };

/// A few runs on processes, figure by figure.
struct Measured {
    median: Figures,
    least: Figures,
    largest: Figures,
}

/// Runs on processes.
fn measured(bench: &Bench, points: &str, jobs: Jobs) -> Result<Measured, String> {
    let mut runs: Vec<Figures> = Vec::new();
    let input = format!("validate-{points}.npy");
    let Jobs { beside, processes, delay } = jobs;
    for _ in 0..RUNS {
        let start = |k: usize| {
            let mut job = bench.job(processes, false);
            // Open MPI binds the first process of each job to the same core.
            job.env("OMPI_MCA_hwloc_base_binding_policy", "none");
            job.env("LTBW_MPI_LATENCY_US", delay.to_string()).arg(&bench.ranked);
            job.args(["--quiet", "delaunay", &input, "--check", "off", "--json"]);
            begin(job.arg(report_of(k)))
        };
        let all = (0..beside).map(start).collect::<Result<Vec<_>, _>>()?;
        for (k, job) in all.into_iter().enumerate() {
            let outcome = end(job, WATCHDOG)?;
            if outcome.code != Some(0) {
                return Err(format!("{processes} processes, {delay} us: {}", outcome.stderr));
            }
            let report = read(bench, k)?;
            let sum = |field| all_of(&report, field).iter().sum::<f64>();
            runs.push([1e3 * sum("insert"), sum("messages"), sum("setbacks")]);
        }
    }
    let of_figure = |k: usize| {
        let mut own: Vec<f64> = runs.iter().map(|run| run[k]).collect();
        own.sort_by(f64::total_cmp);
        own
    };
    let all = [0, 1, 2].map(of_figure);
    let last = runs.len() - 1;
    let [least, median, largest] =
        [0, runs.len() / 2, last].map(|at| [0, 1, 2].map(|k| all[k][at]));
    Ok(Measured { median, least, largest })
}

/// The simulator's figures.
fn simulated(bench: &Bench, what: Simulated<'_>) -> Result<Figures, String> {
    let Simulated { points, processors, latency, message, seed } = what;
    let nanos = |us: f64| format!("{:.0}ns", 1e3 * us);
    let (count, latency, message) = (processors.to_string(), nanos(latency), nanos(message));
    let seed = seed.to_string();
    let command = ["simulate", "--processors", &count, "--latency", &latency, "--points", points];
    let report = report_of(0);
    let costs = ["--message", &message, "--seed", &seed, "--json", &report];
    let outcome = bench.ltbw(&words_of(&[&command[..], &["--as-processes"], &costs].concat()))?;
    if outcome.code != Some(0) {
        return Err(outcome.stderr);
    }
    let report = read(bench, 0)?;
    // The figures of the whole come before those of kinds and processors.
    let first = |field| all_of(&report, field).first().copied().unwrap_or(f64::NAN);
    Ok([1e-6 * first("makespan"), first("count"), first("setbacks")])
}

/// The report's name of a job, by its number among those at a time.
fn report_of(job: usize) -> String {
    format!("validate-{job}.json")
}

/// The report of the last run.
fn read(bench: &Bench, job: usize) -> Result<String, String> {
    fs::read_to_string(bench.folder.join(report_of(job))).map_err(|error| error.to_string())
}

/// The numbers of all fields of a name.
pub(super) fn all_of(report: &str, field: &str) -> Vec<f64> {
    let name = format!("\"{field}\": ");
    let number = |line: &str| line.trim().strip_prefix(&name)?.trim_end_matches(',').parse().ok();
    report.lines().filter_map(number).collect()
}
