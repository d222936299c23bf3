//! `--validate`: runs on two processes with late letters beside the simulator's word on them, of
//! points, and of a domain that is refined without rounds.
//!
//! The simulator's costs are those of its machine. Runs on one process, two beside each other, as
//! two cores share their memory, tell how many times slower this one is, and virtual times are
//! multiples of that; a run on two of a smaller problem and without a delay, what a letter costs
//! that goes by MPI. All else is predicted.

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
/// The part of latencies and letters by which one seed differs from the next: a seed determines
/// points, and nothing of a domain.
const SPREAD: f64 = 0.01;
/// The kind of the domain.
const KIND: &str = "cube-octahedron";
/// Vertices of the domain with which two processes begin.
const START: &str = "4096";
/// Halvings until the cost of a letter is known.
const HALVINGS: usize = 10;
/// The figures, with their units.
const FIGURES: [&str; 3] = ["makespan, ms", "messages", "setbacks"];

/// Makespan in milliseconds, messages and setbacks.
type Figures = [f64; 3];

/// A problem for processes and the simulator.
#[derive(Clone, Copy)]
enum Problem {
    /// Uniform points, as many as the size says.
    Points,
    /// A domain, refined without rounds to the volume that the size says.
    Domain,
}

impl Problem {
    /// The sizes: of a run, and of the smaller one that tells the cost of a letter.
    fn sizes(self) -> [&'static str; 2] {
        match self {
            Self::Points => ["100000", "20000"],
            Self::Domain => ["9e-6", "3e-5"],
        }
    }

    fn title(self, size: &str) -> String {
        match self {
            Self::Points => format!("{size} points"),
            Self::Domain => format!("{KIND} without rounds, volumes up to {size}"),
        }
    }

    fn file(self, size: &str) -> String {
        match self {
            Self::Points => format!("validate-{size}.npy"),
            Self::Domain => "validate.poly".to_owned(),
        }
    }

    /// The words that make the file.
    fn made(self, size: &str) -> Vec<String> {
        let words: &[&str] = match self {
            Self::Points => &["uniform", size, "--seed", "1"],
            Self::Domain => &[KIND],
        };
        words_of(&[&["generate"], words, &["-o", &self.file(size)]].concat())
    }

    /// The words for processes.
    fn on_processes(self, size: &str) -> Vec<String> {
        let file = self.file(size);
        let words: &[&str] = match self {
            Self::Points => &["delaunay", &file],
            // The simulator's domains have no slivers.
            Self::Domain => &["mesh", &file, "--min-dihedral", "0"],
        };
        words_of(&[words, &self.bounds(size)].concat())
    }

    /// The words for the simulator.
    fn on_processors(self, size: &str) -> Vec<String> {
        let file = self.file(size);
        let words: &[&str] = match self {
            Self::Points => &["simulate", "--points", size],
            Self::Domain => &["simulate", "--domain", &file, "--start", START],
        };
        words_of(&[words, &self.bounds(size)].concat())
    }

    /// The bounds, in the words of either.
    fn bounds(self, size: &str) -> Vec<&str> {
        match self {
            Self::Points => Vec::new(),
            Self::Domain => vec!["--mode", "async", "--max-volume", size],
        }
    }
}

/// A run to be simulated; times in the simulator's microseconds.
#[derive(Clone, Copy)]
struct Simulated {
    processors: u32,
    latency: f64,
    /// A letter at either end.
    message: f64,
    seed: usize,
}

/// Prints a table for each problem: by delay and figure what the simulator predicts, what is
/// measured, the ratio.
pub(super) fn run(bench: &Bench) -> Result<(), String> {
    [Problem::Points, Problem::Domain].into_iter().try_for_each(|problem| compare(bench, problem))
}

/// Prints the table of a problem.
fn compare(bench: &Bench, problem: Problem) -> Result<(), String> {
    let [size, smaller] = problem.sizes();
    for size in [size, smaller] {
        let made = bench.ltbw(&problem.made(size))?;
        if made.code != Some(0) {
            return Err(made.stderr);
        }
    }
    let case = Case { bench, problem, size };
    let beside = Jobs { beside: 2, processes: 1, delay: 0 };
    let alone = case.measured(beside)?.median[0];
    let one = Simulated { processors: 1, latency: 1e-3, message: 0.5, seed: 1 };
    let own = case.simulated(one)?[0];
    let slower = alone / own;
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("{}, medians of {RUNS}; load {}", problem.title(size), load.trim());
    println!("one process beside another: {alone:.0} ms, simulated {own:.0} ms");
    println!("all costs are {slower:.2} times");
    let two = Simulated { processors: 2, ..one };
    let message = Case { size: smaller, ..case }.message(two, slower)?;
    let by = problem.title(smaller);
    println!("a letter costs {:.2} us at either end, by {by}", message * slower);
    println!("setbacks: the mean of {SEEDS} seeds, with their standard deviation");
    println!("| delay, us | | predicted | measured | predicted / measured |");
    println!("|---|---|---|---|---|");
    for delay in DELAYS {
        let found = case.measured(Jobs { delay, ..OF_TWO })?;
        let latency = (f64::from(delay) + SHARED) / slower;
        let of_seed = |seed: usize| {
            let part = 1.0 + SPREAD * (seed as f64 - f64::midpoint(1.0, SEEDS as f64));
            let (latency, message) = (part * latency, part * message);
            case.simulated(Simulated { latency, message, seed, ..two })
        };
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

/// A problem of one size.
#[derive(Clone, Copy)]
struct Case<'a> {
    bench: &'a Bench,
    problem: Problem,
    size: &'a str,
}

impl Case<'_> {
    /// The time that a letter takes at either end, in the simulator's microseconds: that with which
    /// it predicts the makespan on two processes without a delay.
    fn message(self, two: Simulated, slower: f64) -> Result<f64, String> {
        let measured = self.measured(OF_TWO)?.median[0];
        let (mut low, mut high) = (0.1, 50.0);
        for _ in 0..HALVINGS {
            let message = f64::midpoint(low, high);
            let latency = SHARED / slower;
            let own = self.simulated(Simulated { latency, message, ..two })?[0];
            match own * slower < measured {
                true => low = message,
                false => high = message,
            }
        }
        Ok(f64::midpoint(low, high))
    }

    /// Runs on processes.
    fn measured(self, jobs: Jobs) -> Result<Measured, String> {
        let Self { bench, problem, size } = self;
        let mut runs: Vec<Figures> = Vec::new();
        let Jobs { beside, processes, delay } = jobs;
        for _ in 0..RUNS {
            let start = |k: usize| {
                let mut job = bench.job(processes, false);
                // Open MPI binds the first process of each job to the same core.
                job.env("OMPI_MCA_hwloc_base_binding_policy", "none");
                job.env("LTBW_MPI_LATENCY_US", delay.to_string()).arg(&bench.ranked);
                job.arg("--quiet").args(problem.on_processes(size));
                begin(job.args(["--check", "off", "--json", &report_of(k)]))
            };
            let all = (0..beside).map(start).collect::<Result<Vec<_>, _>>()?;
            for (k, job) in all.into_iter().enumerate() {
                let outcome = end(job, WATCHDOG)?;
                if outcome.code != Some(0) {
                    return Err(format!("{processes} processes, {delay} us: {}", outcome.stderr));
                }
                let report = read(bench, k)?;
                let sum = |field| all_of(&report, field).iter().sum::<f64>();
                let time = all_of(&report, "seconds").into_iter().fold(0.0, f64::max);
                runs.push([1e3 * time, sum("messages"), sum("setbacks")]);
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
    fn simulated(self, what: Simulated) -> Result<Figures, String> {
        let Self { bench, problem, size } = self;
        let Simulated { processors, latency, message, seed } = what;
        let nanos = |us: f64| format!("{:.0}ns", 1e3 * us);
        let (count, latency, message) = (processors.to_string(), nanos(latency), nanos(message));
        let (seed, report) = (seed.to_string(), report_of(0));
        let machine = ["--processors", &count, "--latency", &latency, "--message", &message];
        let others = ["--as-processes", "--seed", &seed, "--json", &report];
        let words = [machine.to_vec(), others.to_vec()].concat();
        let outcome = bench.ltbw(&[problem.on_processors(size), words_of(&words)].concat())?;
        if outcome.code != Some(0) {
            return Err(outcome.stderr);
        }
        let report = read(bench, 0)?;
        // The figures of the whole come before those of kinds and processors.
        let first = |field| all_of(&report, field).first().copied().unwrap_or(f64::NAN);
        Ok([1e-6 * first("makespan"), first("count"), first("setbacks")])
    }
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
