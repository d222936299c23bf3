//! `measure_threads [N [ROUNDS]]`: the parallel kernel on one and two threads against the
//! sequential kernel and CGAL's parallel version, side by side, on N points (4,000,000) of three
//! kinds.
//!
//! Times are from points in memory to one mesh, distribution and gathering included. Every build
//! has a process of its own: what one has left behind, memory above all, is not the next one's gain
//! or loss. Runs are interleaved in rounds, in which each comes first in its turn, and medians of
//! the rounds' ratios are reported. Beside them stands what the machine gives to two sequential
//! builds at once, which have nothing to do with each other: their speed together, where one alone
//! has 1. It is below 2 where processors share caches, memory, or more. On a virtual machine the
//! last column has the part of the busy processors' time that the host took away meanwhile: with
//! more than a few percent of it, a thread waits for one that does not run, and figures tell of the
//! host. `cargo xtask bench threads` builds this with the release profile.

use ltbw::threads::{Parallel, WorkerStats};
use ltbw::{Builder, PointSet};
use ltbw_generate::{PointKind, generate};
use ltbw_tests::cgal::{Ask, Cgal};
use ltbw_tests::median;
use std::process::{Child, Command, ExitCode, Stdio};
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

/// First argument of a process that builds once.
const ONCE: &str = "--once";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let done = match words.as_slice() {
        [ONCE, kind, count, threads] => once(kind, count, threads),
        words => {
            let number = |k: usize, default| words.get(k).map_or(Ok(default), |word| word.parse());
            let numbers = number(0, 4_000_000).and_then(|count| Ok((count, number(1, ROUNDS)?)));
            numbers.map_err(Failure::from).and_then(|(count, rounds)| run(count, rounds))
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("measure_threads: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn run(count: usize, rounds: usize) -> Result<(), Failure> {
    println!(
        "| set | points | sequential, s | speed of 1 thread (aim {ALONE}) | of {THREADS} | aim | \
         two at once | time / CGAL's on {THREADS} (aim {CGAL}) | interface | set back | stolen |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let mut met = true;
    for (name, kind, aim) in KINDS {
        met &= measure(name, kind, count, rounds.max(1), aim)?;
    }
    println!(
        "\nmedians of {rounds} interleaved rounds; aims {}",
        if met { "met" } else { "MISSED" }
    );
    Ok(())
}

/// Builds once on `threads` threads, 0 for the sequential kernel; prints the seconds that it took,
/// how many operations were interface operations, and how many were set back.
fn once(kind: &str, count: &str, threads: &str) -> Result<(), Failure> {
    let set = PointSet::new(generate(kind.parse()?, count.parse()?, 1))?;
    let threads: u32 = threads.parse()?;
    let clock = Instant::now();
    let (mut interface, mut setbacks) = (0, 0);
    if threads == 0 {
        let built = Builder::new().build(&set)?;
        println!("{}", clock.elapsed().as_secs_f64());
        drop(built);
    } else {
        let run = Parallel::new(threads).build(&set)?;
        println!("{}", clock.elapsed().as_secs_f64());
        let sum = |f: fn(&WorkerStats) -> u64| run.workers.iter().map(f).sum::<u64>();
        (interface, setbacks) = (sum(|w| w.interface), sum(|w| w.setbacks));
    }
    println!("{interface} {setbacks}");
    Ok(())
}

/// A process that builds once: seconds, interface operations, setbacks.
struct Once(Child);

impl Once {
    fn start(kind: PointKind, count: usize, threads: u32) -> Result<Self, Failure> {
        let words = [ONCE.to_string(), kind.to_string(), count.to_string(), threads.to_string()];
        let mut command = Command::new(std::env::current_exe()?);
        Ok(Self(command.args(words).stdout(Stdio::piped()).spawn()?))
    }

    fn finish(self) -> Result<(f64, u64, u64), Failure> {
        let output = self.0.wait_with_output()?;
        let text = String::from_utf8(output.stdout)?;
        let mut words = text.split_whitespace();
        let mut word = || words.next().ok_or("a build has failed");
        Ok((word()?.parse()?, word()?.parse()?, word()?.parse()?))
    }
}

/// Time of all processors so far, in ticks: the time when they were busy or wanted to be, and the
/// part of that time that the host of a virtual machine took (`/proc/stat`, proc(5)). `None` where
/// there is no such file.
fn busy_and_stolen() -> Option<(u64, u64)> {
    let text = std::fs::read_to_string("/proc/stat").ok()?;
    let words = text.lines().next()?.split_whitespace().skip(1);
    let ticks: Vec<u64> = words.map_while(|word| word.parse().ok()).collect();
    let [user, nice, system, _idle, _iowait, irq, softirq, stolen, ..] = ticks[..] else {
        return None;
    };
    Some((user + nice + system + irq + softirq + stolen, stolen))
}

/// One row of the table; true if its aims are met.
fn measure(
    name: &str,
    kind: PointKind,
    count: usize,
    rounds: usize,
    aim: f64,
) -> Result<bool, Failure> {
    let mut cgal = Cgal::start_tbb().ok();
    let set = PointSet::new(generate(kind, count, 1))?;
    let (mut base, mut alone, mut both, mut twice, mut theirs) =
        (vec![], vec![], vec![], vec![], vec![]);
    let build = |threads| Once::start(kind, count, threads)?.finish();
    let mut figures = (0, 0);
    let before = busy_and_stolen();
    for round in 0..rounds {
        let mut seconds = [0.0; 5];
        for turn in 0..5 {
            let who = (turn + round) % 5;
            seconds[who] = match who {
                0 => build(0)?.0,
                1 => build(1)?.0,
                2 => {
                    let (seconds, interface, setbacks) = build(THREADS)?;
                    figures = (interface, setbacks);
                    seconds
                }
                3 => {
                    let [one, other] = [Once::start(kind, count, 0)?, Once::start(kind, count, 0)?];
                    one.finish()?.0.max(other.finish()?.0)
                }
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
    let stolen = before.zip(busy_and_stolen()).map(|((busy, stolen), (busy_now, stolen_now))| {
        100.0 * stolen_now.saturating_sub(stolen) as f64
            / busy_now.saturating_sub(busy).max(1) as f64
    });
    let share = |count: u64| 100.0 * count as f64 / set.len() as f64;
    let (alone, both) = (median(&mut alone), median(&mut both));
    let theirs = if theirs.is_empty() { None } else { Some(median(&mut theirs)) };
    println!(
        "| {name} | {} | {:.3} | {alone:.2} | {both:.2} | {aim} | {:.2} | {} | {:.2} % | {:.3} % \
         | {} |",
        set.len(),
        median(&mut base),
        median(&mut twice),
        theirs.map_or("no TBB".to_string(), |ratio| format!("{ratio:.2}")),
        share(figures.0),
        share(figures.1),
        stolen.map_or("unknown".to_string(), |percent| format!("{percent:.0} %")),
    );
    Ok(alone >= ALONE && both >= aim && theirs.is_none_or(|ratio| ratio <= CGAL))
}
