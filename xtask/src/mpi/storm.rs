//! Faults at random: in each of many small jobs one process panics, is killed or is stopped, at a
//! moment that is drawn. No process hangs, and each job ends with the code that its fault has.
//!
//! `mpirun` of Open MPI 4.1 hangs, about once in a hundred times, when a process dies as it
//! introduces itself: all processes have ended, and it waits for itself. That is counted, and no
//! fault of ours.

use super::faults::{PATIENCE, file_of, pid_of, telling};
use super::{Bench, Outcome, WATCHDOG, begin, end_or, watched, words_of};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fs;
use std::process::Command;
use std::time::{Duration, Instant};

/// The commands that are run.
const JOBS: [&[&str]; 4] = [
    &["delaunay", "uniform-20000.npy", "-o", "storm.pvtu"],
    &["mesh", "cube-octahedron.poly", "--max-volume", "2e-4", "-o", "storm.pvtu"],
    &["mesh", "tee.poly", "--max-volume", "6e-4", "-o", "storm.vtu"],
    &["mesh", "gear.poly", "--max-volume", "2e-4", "--min-dihedral", "0", "-o", "storm.pvtu"],
];

/// The numbers of processes.
const RANKS: [u32; 3] = [2, 3, 4];

/// The latest letter at which a process panics.
const LETTERS: u64 = 600;

/// The delays of mails, in microseconds.
const LATE: [&str; 3] = ["0", "0", "300"];

/// A fault of one process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fault {
    Panic,
    Kill,
    Stop,
}

impl Fault {
    const ALL: [Self; 3] = [Self::Panic, Self::Kill, Self::Stop];

    /// The codes with which a job ends after it. It may come after the end; and a process that is
    /// stopped before it listens ends as any other one does.
    fn codes(self) -> &'static [i32] {
        match self {
            Self::Panic => &[70, 0],
            Self::Kill => &[137, 0],
            Self::Stop => &[4, 143, 0],
        }
    }
}

/// A job without a fault.
struct Sound {
    stdout: String,
    seconds: f64,
}

/// Numbers that follow from a seed (SplitMix64).
struct Draw(u64);

impl Draw {
    /// A number below `end`.
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % end.max(1)
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len() as u64) as usize]
    }
}

/// Runs the given number of jobs with faults.
pub(crate) fn run(bench: &Bench, count: u64, seed: u64) -> Result<(), String> {
    println!("{count} jobs with faults at random: --seed {seed}");
    let mut draw = Draw(seed);
    let mut sound: BTreeMap<(usize, u32), Sound> = BTreeMap::new();
    let mut ends: BTreeMap<(Fault, Option<i32>), u64> = BTreeMap::new();
    let (mut wrong, mut longest) = (Vec::new(), 0.0_f64);
    for number in 0..count {
        let job = draw.below(JOBS.len() as u64) as usize;
        let ranks = draw.one(&RANKS);
        let (fault, late) = (draw.one(&Fault::ALL), draw.one(&LATE));
        let (rank, part) = (draw.below(ranks.into()) as u32, draw.below(1100));
        let letter = draw.below(LETTERS);
        let name = format!("{number}: {} on {ranks}, {fault:?} of {rank}", JOBS[job][1]);
        if let std::collections::btree_map::Entry::Vacant(entry) = sound.entry((job, ranks)) {
            entry.insert(alone(bench, job, ranks)?);
        }
        let own = &sound[&(job, ranks)];
        _ = fs::remove_file(bench.folder.join("storm.pvtu"));
        let mut command = telling(bench, ranks);
        command.env("LTBW_MPI_LATENCY_US", late);
        if fault == Fault::Panic {
            command.env("LTBW_MPI_PANIC_RANK", rank.to_string());
            command.env("LTBW_MPI_PANIC_LETTER", letter.to_string());
        }
        let child = begin(command.arg("--quiet").args(JOBS[job]))?;
        let mut since = Instant::now();
        if fault != Fault::Panic
            && let Some(pid) = pid_of(bench, rank)
        {
            std::thread::sleep(Duration::from_secs_f64(own.seconds * part as f64 / 1000.0));
            let signal = if fault == Fault::Kill { "-KILL" } else { "-TERM" };
            // It may have ended.
            let mut kill = Command::new("kill");
            let _ =
                kill.args([signal, &pid.to_string()]).stderr(std::process::Stdio::null()).status();
            since = Instant::now();
        }
        let patience = if fault == Fault::Panic { WATCHDOG } else { PATIENCE };
        let living = Cell::new(0);
        match end_or(child, patience, || living.set(living_of(bench, ranks))) {
            Ok(outcome) => {
                *ends.entry((fault, outcome.code)).or_default() += 1;
                longest = longest.max(since.elapsed().as_secs_f64());
                wrong.extend(amiss(&outcome, fault, own).map(|why| format!("{name}: {why}")));
                let clock = Instant::now();
                while living_of(bench, ranks) > 0 && clock.elapsed() < PATIENCE {
                    std::thread::sleep(Duration::from_millis(20));
                }
                let left = living_of(bench, ranks);
                wrong.extend((left > 0).then(|| format!("{name}: {left} processes live on")));
            }
            Err(why) => {
                *ends.entry((fault, None)).or_default() += 1;
                let hung = format!("{name}: {} of its processes hang: {why}", living.get());
                wrong.extend((living.get() > 0).then_some(hung));
            }
        }
    }
    for ((fault, code), count) in &ends {
        let none = || "mpirun has not ended, or processes".to_owned();
        let code = code.map_or_else(none, |code| format!("code {code}"));
        println!("{fault:?}: {code}: {count}");
    }
    println!("at most {longest:.1} s from a signal, or from the start, to the end");
    match wrong.is_empty() {
        true => {
            println!("{count} jobs with faults: no process hangs, each with its code");
            Ok(())
        }
        false => Err(format!("{} of {count}: --seed {seed}\n{}", wrong.len(), wrong.join("\n"))),
    }
}

/// Processes of a job that have not ended; those that nobody has waited for have.
fn living_of(bench: &Bench, ranks: u32) -> usize {
    let lives = |rank: &u32| {
        let pid = fs::read_to_string(file_of(bench, *rank)).ok()?;
        let stat = fs::read_to_string(format!("/proc/{}/stat", pid.trim())).ok()?;
        // The name before it is in brackets.
        let state = stat.rsplit(')').next()?.split_whitespace().next()?;
        Some(state != "Z")
    };
    (0..ranks).filter(|rank| lives(rank) == Some(true)).count()
}

/// A job without a fault: its hash, and its time.
fn alone(bench: &Bench, job: usize, ranks: u32) -> Result<Sound, String> {
    let mut command = bench.job(ranks, &[]);
    command.arg(&bench.ranked).arg("--quiet").args(JOBS[job]);
    let Outcome { code, stdout, stderr, seconds } = watched(&mut command, WATCHDOG)?;
    match code {
        Some(0) => Ok(Sound { stdout, seconds }),
        _ => Err(format!("{:?}: code {code:?}\n{stderr}", words_of(JOBS[job]))),
    }
}

/// The thing that is wrong with an end, if something is.
fn amiss(outcome: &Outcome, fault: Fault, sound: &Sound) -> Option<String> {
    let Outcome { code, stdout, stderr, .. } = outcome;
    match code {
        Some(0) if *stdout != sound.stdout => Some(format!("{stdout}, not {}", sound.stdout)),
        Some(code) if fault.codes().contains(code) => None,
        _ => Some(format!("code {code:?}, not of {:?}\n{stderr}", fault.codes())),
    }
}
