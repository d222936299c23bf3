//! `--speed`: two processes beside two threads of `ltbw`, in turn, the first place going round.
//!
//! A build without link-time optimisation, or of many units, is half as fast, and not by the same
//! factor in both programs: these have to be those that are shipped.

use super::validate::all_of;
use super::{Bench, WATCHDOG, watched, words_of};
use std::fs;

/// Runs of each.
const RUNS: usize = 6;

/// An input, what `ltbw` is told beside, and the figure that counts.
const CASES: [(&[&str], &[&str], &str); 2] = [
    (&["delaunay", "speed.npy"], &["--threads", "2"], "insert"),
    (&["mesh", "cube-octahedron.poly", "--max-volume", "1e-6"], &["--workers", "2"], "refine"),
];

/// The seconds of a run: of the figure that counts, and in all.
type Seconds = [f64; 2];

/// Prints a table: by input the seconds of threads and of processes, and the ratio.
pub(super) fn run(bench: &Bench) -> Result<(), String> {
    bench.generate(&["uniform", "1000000", "--seed", "1", "-o", "speed.npy"])?;
    bench.generate(&["cube-octahedron", "-o", "cube-octahedron.poly"])?;
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("seconds, medians (and least) of {RUNS} runs in turn; load {}", load.trim());
    println!("| job | seconds of | 2 threads | 2 processes | threads / processes |");
    println!("|---|---|--:|--:|--:|");
    for (job, threads, figure) in CASES {
        let mut found: [Vec<Seconds>; 2] = [Vec::new(), Vec::new()];
        for k in 0..2 * RUNS {
            // Threads, processes, processes, threads.
            let way = k.div_ceil(2) % 2;
            let more = if way == 0 { threads } else { &[] };
            found[way].push(measured(bench, job, more, figure)?);
        }
        for (place, what) in [figure, "all"].into_iter().enumerate() {
            let [threads, processes] = found.each_ref().map(|own| spread(own, place));
            let ratio = [0, 1].map(|k| threads[k] / processes[k]);
            let told = |[median, least]: [f64; 2]| format!("{median:.2} ({least:.2})");
            let row = [told(threads), told(processes), told(ratio)].join(" | ");
            println!("| {} | {what} | {row} |", job.join(" "));
        }
    }
    Ok(())
}

/// The seconds of a run: by threads if they are told how many, else by two processes.
fn measured(
    bench: &Bench,
    job: &[&str],
    threads: &[&str],
    figure: &str,
) -> Result<Seconds, String> {
    let report = ["--check", "off", "--json", "speed.json"];
    let arguments = words_of(&[job, threads, &report].concat());
    let outcome = match threads {
        [] => watched(bench.job(2, false).arg(&bench.ranked).args(&arguments), WATCHDOG)?,
        _ => bench.ltbw(&arguments)?,
    };
    if outcome.code != Some(0) {
        return Err(format!("{arguments:?}: {:?}\n{}", outcome.code, outcome.stderr));
    }
    let report = fs::read_to_string(bench.folder.join("speed.json"));
    let report = report.map_err(|error| error.to_string())?;
    // Seconds come before all other figures.
    let of = |field| match all_of(&report, field)[..] {
        [seconds, ..] => Ok(seconds),
        [] => Err(format!("a report without seconds of `{field}`")),
    };
    Ok([of(figure)?, of("total")?])
}

/// The median and the least of a figure.
fn spread(runs: &[Seconds], place: usize) -> [f64; 2] {
    let mut all: Vec<f64> = runs.iter().map(|own| own[place]).collect();
    all.sort_by(f64::total_cmp);
    let middle = all.len() / 2;
    [(all[middle] + all[all.len() - 1 - middle]) / 2.0, all[0]]
}
