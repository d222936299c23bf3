//! `measure_threads [N [ROUNDS]]`: the parallel kernel on one and two threads against the
//! sequential kernel and CGAL's parallel version, side by side, on N points (4,000,000) of three
//! kinds.
//!
//! Times are from points in memory to one mesh, distribution and gathering included. Runs are
//! interleaved in rounds, in which each comes first in its turn, and medians of the rounds' ratios
//! are reported. Before each, memory is touched and given back: in a virtual machine the host takes
//! free memory away after some seconds, and who comes next would wait for it. Beside them stands what the machine gives to two sequential builds at once, which
//! have nothing to do with each other: their speed together, that of one alone being 1. It is below
//! 2 where processors share caches, memory, or more. `cargo xtask bench threads` builds this with the
//! release profile.

use ltbw::generate::{PointKind, generate};
use ltbw::threads::{Parallel, WorkerStats};
use ltbw::{Builder, PointSet};
use ltbw_tests::cgal::{Ask, Cgal};
use ltbw_tests::median;
use std::process::ExitCode;
use std::time::Instant;

/// Rounds for a median, if not said otherwise.
const ROUNDS: usize = 8;
/// Threads of both parallel versions.
const THREADS: u32 = 2;
/// At least this part of the sequential kernel's speed on one thread ...
const ALONE: f64 = 0.95;
/// ... and at most this part of CGAL's time on two.
const CGAL: f64 = 0.50;
/// Kinds of points, and how many times as fast as the sequential kernel two threads should be.
const KINDS: [(&str, PointKind, f64); 3] = [
    ("uniform", PointKind::Uniform, 1.7),
    ("clusters", PointKind::Clusters, 1.5),
    ("shell", PointKind::Shell, 1.5),
];

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    let number = |k, default| std::env::args().nth(k).map_or(Ok(default), |text| text.parse());
    let numbers = number(1, 4_000_000).and_then(|count| Ok((count, number(2, ROUNDS)?)));
    match numbers.map_err(Failure::from).and_then(|(count, rounds)| run(count, rounds)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("measure_threads: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn run(count: usize, rounds: usize) -> Result<(), Failure> {
    println!(
        "| set | points | sequential, s | speed of 1 thread (aim {ALONE}) | of {THREADS} | aim | two at once | \
         time / CGAL's on {THREADS} (aim {CGAL}) | interface | set back |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let mut met = true;
    for (name, kind, aim) in KINDS {
        met &= measure(name, generate(kind, count, 1), rounds.max(1), aim)?;
    }
    println!(
        "\nmedians of {rounds} interleaved rounds; aims {}",
        if met { "met" } else { "MISSED" }
    );
    Ok(())
}

/// One row of the table; true if its aims are met.
fn measure(name: &str, points: Vec<[f64; 3]>, rounds: usize, aim: f64) -> Result<bool, Failure> {
    let mut cgal = Cgal::start_tbb().ok();
    let set = PointSet::new(points)?;
    let (mut base, mut alone, mut both, mut twice, mut theirs) =
        (vec![], vec![], vec![], vec![], vec![]);
    let sequential = || Builder::new().build(&set).map(drop);
    let mut figures = (0, 0);
    for round in 0..rounds {
        let mut seconds = [0.0; 5];
        for turn in 0..5 {
            touch_memory(set.len());
            let who = (turn + round) % 5;
            seconds[who] = match who {
                0 => timed(sequential)?,
                1 => timed(|| Parallel::new(1).build(&set).map(drop))?,
                2 => timed(|| {
                    Parallel::new(THREADS).build(&set).map(|run| {
                        let sum = |f: fn(&WorkerStats) -> u64| run.workers.iter().map(f).sum();
                        figures = (sum(|w| w.interface), sum(|w| w.setbacks));
                    })
                })?,
                3 => timed(|| {
                    let (one, other) = std::thread::scope(|scope| {
                        let other = scope.spawn(sequential);
                        (sequential(), other.join().expect("no panic in a build"))
                    });
                    one.and(other)
                })?,
                _ => match &mut cgal {
                    Some(cgal) => {
                        let ask = Ask { threads: THREADS as u16, ..Ask::default() };
                        cgal.ask(set.points(), ask)?.seconds
                    }
                    None => 0.0,
                },
            };
        }
        let [sequential, one, two, at_once, other] = seconds;
        base.push(sequential);
        alone.push(sequential / one);
        both.push(sequential / two);
        twice.push(2.0 * sequential / at_once);
        if other > 0.0 {
            theirs.push(two / other);
        }
    }
    let share = |count: u64| 100.0 * count as f64 / set.len() as f64;
    let (alone, both) = (median(&mut alone), median(&mut both));
    let theirs = if theirs.is_empty() { None } else { Some(median(&mut theirs)) };
    println!(
        "| {name} | {} | {:.3} | {alone:.2} | {both:.2} | {aim} | {:.2} | {} | {:.2} % | {:.3} % |",
        set.len(),
        median(&mut base),
        median(&mut twice),
        theirs.map_or("no TBB".to_string(), |ratio| format!("{ratio:.2}")),
        share(figures.0),
        share(figures.1),
    );
    Ok(alone >= ALONE && both >= aim && theirs.is_none_or(|ratio| ratio <= CGAL))
}

/// Uses about as much memory as two builds of `points` points, and gives it back.
fn touch_memory(points: usize) {
    let mut memory = vec![0_u8; 1500 * points];
    memory.iter_mut().step_by(4096).for_each(|byte| *byte = 1);
    std::hint::black_box(&memory);
}

fn timed<E: Into<Failure>>(work: impl FnOnce() -> Result<(), E>) -> Result<f64, Failure> {
    let clock = Instant::now();
    work().map_err(Into::into)?;
    Ok(clock.elapsed().as_secs_f64())
}
