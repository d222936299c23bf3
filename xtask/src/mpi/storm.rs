//! Faults at random: in each of many small jobs one process panics, is killed or is stopped, at a
//! moment that is drawn. No process hangs, and each job ends with the code that its fault has.
//!
//! `mpirun` of Open MPI 4.1 hangs, about once in a hundred times, when a process dies as it
//! introduces itself: all processes have ended, and it waits for itself. MPICH 4.0 has a code of
//! its own as often then: its launcher, or a process that greets the dead one, ends with an error.
//! Both are counted, and no fault of ours.

use super::draw::Draw;
use super::faults::{PATIENCE, file_of, pid_of, telling};
use super::{Bench, Outcome, WATCHDOG, begin, end_unless, watched, words_of};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The commands that are run.
const JOBS: [&[&str]; 5] = [
    &["delaunay", "uniform-20000.npy", "-o", "storm.pvtu"],
    &["mesh", "cube-octahedron.poly", "--max-volume", "2e-4", "-o", "storm.pvtu"],
    &["mesh", "tee.poly", "--max-volume", "6e-4", "--smooth", "6", "-o", "storm.vtu"],
    &["mesh", "gear.poly", "--max-volume", "2e-4", "--min-dihedral", "0", "-o", "storm.pvtu"],
    &[
        "mesh",
        "cube-octahedron.poly",
        "--max-volume",
        "2e-5",
        "--mode",
        "async",
        "-o",
        "storm.pvtu",
    ],
];

/// The numbers of processes.
const RANKS: [u32; 3] = [2, 3, 4];

/// The latest letter at which a process panics.
const LETTERS: u64 = 600;

/// The delays of mails, in microseconds.
const LATE: [&str; 3] = ["0", "0", "300"];

/// The time after which a launcher none of whose processes lives is ended.
const GRACE: Duration = Duration::from_secs(5);

/// The number of jobs in which MPI itself may fail, or one in fifty.
const MOST_OF_MPI: u64 = 1;

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
    fn codes(self, bench: &Bench) -> Vec<i32> {
        match self {
            Self::Panic => vec![70, 0],
            Self::Kill => vec![bench.mpi.code_of(9), 0],
            Self::Stop if is_mpich(bench) => vec![4, 15, KILLED, 0],
            Self::Stop => vec![4, bench.mpi.code_of(15), 0],
        }
    }
}

/// A job without a fault.
struct Sound {
    /// Its hash; none of one without rounds, which has another mesh each time.
    hash: Option<String>,
    seconds: f64,
}

/// A job with a fault, as it is drawn.
struct Faulty {
    job: usize,
    ranks: u32,
    fault: Fault,
    late: &'static str,
    rank: u32,
    /// The moment, in thousandths of the time of the job without a fault.
    part: u64,
    letter: u64,
}

/// The end of such a job.
struct Ended {
    /// None if the launcher has not ended, though no process lives.
    outcome: Option<Outcome>,
    /// Seconds from the signal, or from the start, until no process lives.
    processes: f64,
}

impl Faulty {
    fn drawn(draw: &mut Draw) -> Self {
        let job = draw.below(JOBS.len() as u64) as usize;
        let ranks = draw.one(&RANKS);
        let (fault, late) = (draw.one(&Fault::ALL), draw.one(&LATE));
        let (rank, part) = (draw.below(ranks.into()) as u32, draw.below(1100));
        Self { job, ranks, fault, late, rank, part, letter: draw.below(LETTERS) }
    }

    /// Runs it to its end; one of whose processes hang is an error.
    fn run(&self, bench: &Bench, sound: &Sound) -> Result<Ended, String> {
        _ = fs::remove_file(bench.folder.join("storm.pvtu"));
        let mut command = telling(bench, self.ranks);
        command.env("LTBW_MPI_LATENCY_US", self.late);
        if self.fault == Fault::Panic {
            command.env("LTBW_MPI_PANIC_RANK", self.rank.to_string());
            command.env("LTBW_MPI_PANIC_LETTER", self.letter.to_string());
        }
        let child = begin(command.arg("--quiet").args(JOBS[self.job]))?;
        if self.fault == Fault::Panic {
            return self.end(bench, child, WATCHDOG);
        }
        if let Some(pid) = pid_of(bench, self.rank) {
            std::thread::sleep(Duration::from_secs_f64(sound.seconds * self.part as f64 / 1000.0));
            let signal = if self.fault == Fault::Kill { "-KILL" } else { "-TERM" };
            // It may have ended.
            let mut kill = Command::new("kill");
            let _ = kill.args([signal, &pid.to_string()]).stderr(Stdio::null()).status();
        }
        self.end(bench, child, PATIENCE)
    }

    /// Waits for its end, and for that of its processes.
    fn end(&self, bench: &Bench, child: Child, patience: Duration) -> Result<Ended, String> {
        let clock = Instant::now();
        let (mut last, mut living) = (Duration::ZERO, 0);
        let mut look = || {
            living = living_of(bench, self.ranks);
            let since = clock.elapsed();
            last = if living > 0 { since } else { last };
            let waits = !last.is_zero() && since.saturating_sub(last) >= GRACE;
            let is_late = waits || since >= patience;
            is_late.then(|| format!("{} s", since.as_secs()))
        };
        let outcome = end_unless(child, &mut look);
        // The processes of a launcher that has ended may be about to.
        while living_of(bench, self.ranks) > 0 && clock.elapsed() < patience {
            look();
            std::thread::sleep(Duration::from_millis(5));
        }
        match outcome {
            Err(why) if living > 0 => Err(format!("{living} of its processes hang: {why}")),
            outcome => match living_of(bench, self.ranks) {
                0 => Ok(Ended { outcome: outcome.ok(), processes: last.as_secs_f64() }),
                left => Err(format!("{left} processes live on")),
            },
        }
    }
}

/// Runs the given number of jobs with faults.
pub(crate) fn run(bench: &Bench, count: u64, seed: u64) -> Result<(), String> {
    println!("{count} jobs with faults at random: --seed {seed}");
    let mut draw = Draw(seed);
    let mut sound: BTreeMap<(usize, u32), Sound> = BTreeMap::new();
    let mut ends: BTreeMap<(Fault, Option<i32>), u64> = BTreeMap::new();
    let (mut wrong, mut longest) = (Vec::new(), BTreeMap::<Fault, f64>::new());
    let mut of_mpi = 0;
    for number in 0..count {
        let faulty = Faulty::drawn(&mut draw);
        let Faulty { job, ranks, fault, rank, .. } = faulty;
        let what = JOBS[job].join(" ");
        let name = format!("{number}: {what} on {ranks}, {fault:?} of {rank}");
        if let Entry::Vacant(entry) = sound.entry((job, ranks)) {
            entry.insert(alone(bench, job, ranks)?);
        }
        let own = &sound[&(job, ranks)];
        let ended = match faulty.run(bench, own) {
            Ok(ended) => ended,
            Err(why) => {
                wrong.push(format!("{name}: {why}"));
                continue;
            }
        };
        let most = longest.entry(fault).or_default();
        *most = most.max(ended.processes);
        let code = ended.outcome.as_ref().map(|outcome| outcome.code);
        *ends.entry((fault, code.flatten())).or_default() += 1;
        match ended.outcome {
            Some(outcome) if is_mpich(bench) && is_of_mpi(&outcome) => {
                of_mpi += 1;
                println!("{name}: an error of MPI's own");
            }
            Some(outcome) => {
                let why = amiss(bench, &outcome, fault, own);
                wrong.extend(why.map(|why| format!("{name}: {why}")));
            }
            None => println!("{name}: no process lives, and the launcher has not ended"),
        }
    }
    for ((fault, code), count) in &ends {
        let none = || "the launcher has not ended, its processes have".to_owned();
        let code = code.map_or_else(none, |code| format!("code {code}"));
        println!("{fault:?}: {code}: {count}");
    }
    for (fault, seconds) in &longest {
        let since = if *fault == Fault::Panic { "start" } else { "signal" };
        println!("{fault:?}: at most {seconds:.1} s from the {since} to the last process's end");
    }
    if of_mpi > MOST_OF_MPI.max(count / 50) {
        wrong.push(format!("{of_mpi} errors of MPI's own"));
    }
    match wrong.is_empty() {
        true => {
            println!("{count} jobs with faults: no process hangs; {of_mpi} errors of MPI's own");
            println!("each other job has ended with its code");
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
    let mut command = bench.job(ranks, false);
    command.arg(&bench.ranked).arg("--quiet").args(JOBS[job]);
    let Outcome { code, stdout, stderr, seconds } = watched(&mut command, WATCHDOG)?;
    match code {
        Some(0) => {
            let hash = (!JOBS[job].contains(&"async")).then_some(stdout);
            Ok(Sound { hash, seconds })
        }
        _ => Err(format!("{:?}: code {code:?}\n{stderr}", words_of(JOBS[job]))),
    }
}

/// Words of errors in MPICH itself: of its launcher, and of a process that the library has failed,
/// or that has read memory shared with one that is gone.
const OF_MPI: [&str; 3] =
    ["[mpiexec@", "Other MPI error, error stack:", "Caught signal 7 (Bus error"];

/// The codes of such: that of a signal which has read such memory, of `MPI_Abort` in the library,
/// of the launcher.
const CODES_OF_MPI: [i32; 3] = [7, 15, 255];

/// The code when MPICH has killed the others of one that has ended alone.
const KILLED: i32 = 9;

fn is_mpich(bench: &Bench) -> bool {
    bench.mpi.library.name == "MPICH"
}

/// Has a job a code of MPICH's own, since that has failed?
fn is_of_mpi(outcome: &Outcome) -> bool {
    let is_told = OF_MPI.iter().any(|words| outcome.stderr.contains(words));
    is_told && outcome.code.is_some_and(|code| CODES_OF_MPI.contains(&code))
}

/// The thing that is wrong with an end, if something is.
fn amiss(bench: &Bench, outcome: &Outcome, fault: Fault, sound: &Sound) -> Option<String> {
    let codes = fault.codes(bench);
    let Outcome { code, stdout, stderr, .. } = outcome;
    match code {
        Some(0) if sound.hash.as_ref().is_some_and(|hash| hash != stdout) => {
            Some(format!("{stdout}, not {:?}", sound.hash))
        }
        Some(code) if codes.contains(code) => None,
        _ => Some(format!("code {code:?}, not of {codes:?}\n{stderr}")),
    }
}
