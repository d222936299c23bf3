//! `measure_refine`: the refinement of domains against TetGen's, side by side, and how evenly its
//! time is spread over random domains. `cargo xtask bench refine` builds it with the release
//! profile.
//!
//! Every run is a process of its own, ours and TetGen's in turn, so that a slow spell of the
//! machine hits both; times are those of the processor, and the median of the pairs' ratios of time
//! per tetrahedron counts. TetGen is the Python package `tetgen`; `LTBW_TETGEN_PYTHON` names a
//! Python that has it. Rounds are compared with splitting one item after the other in the same way,
//! and with the commit before where `LTBW_BEFORE` names a `measure_refine` built from it.

use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::io;
use ltbw::refine::{RefineOutcome, Refiner};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_tests::domains::{PROBLEMS, random_domain};
use ltbw_tests::require::skip;
use ltbw_tests::{cases, median};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// Pairs of runs for a median.
const PAIRS: usize = 9;

/// The model problem of a million tetrahedra, with TetGen's number of them; the first of the other
/// problems is a tenth of it.
const MILLION: (DomainKind, f64, usize) = (DomainKind::CubeOctahedron, 1.73783e-6, 1_048_174);
/// Of TetGen's time per tetrahedron the million may take this part.
const SLOWEST: f64 = 0.38;
/// Its peak memory, KiB.
const MEMORY: f64 = 150e6 / 1024.0;
/// The most rounds that it may take, and the most more than a tenth of it takes.
const ROUNDS: [u64; 2] = [400, 80];
/// The most searches that it may take a point.
const SEARCHES: f64 = 1.6;
/// It makes at least this part of the tetrahedra a second that the commit before makes.
const SPEED: f64 = 0.9;
/// No random domain may take this many times the median time per tetrahedron.
const UNEVEN: f64 = 10.0;

type Failure = Box<dyn std::error::Error>;

/// The cost of a run.
#[derive(Clone, Copy, Debug)]
struct Taken {
    tets: usize,
    seconds: f64,
    /// KiB.
    peak: f64,
    /// Rounds, and searches a point, where the program tells.
    rounds: Option<(u64, f64)>,
}

impl Taken {
    /// From the last line of a run's output.
    fn parse(text: &str) -> Option<Self> {
        let line = text.lines().rev().find_map(|line| line.strip_prefix("result "))?;
        let mut words = line.split(' ');
        let tets = words.next()?.parse().ok()?;
        let mut number = || words.next()?.parse::<f64>().ok();
        let (seconds, peak) = (number()?, number()?);
        let rounds = number().zip(number()).map(|(rounds, searches)| (rounds as u64, searches));
        Some(Self { tets, seconds, peak, rounds })
    }

    fn microseconds_each(&self) -> f64 {
        self.seconds * 1e6 / self.tets as f64
    }
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let result = match args[..] {
        [] => engines().and_then(|met| Ok(met & compare()? & evenness()?)),
        ["engines"] => engines(),
        ["once", volume] => once(MILLION.0, volume, Refiner::new()),
        ["once", volume, "singly"] => once(MILLION.0, volume, Refiner::new().start(usize::MAX)),
        ["once", volume, kind] => match kind.parse() {
            Ok(kind) => once(kind, volume, Refiner::new()),
            Err(error) => Err(Failure::from(error)),
        },
        _ => Err("usage: measure_refine [engines]".into()),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(failure) => {
            eprintln!("measure_refine: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn ready(kind: DomainKind) -> Result<Prepared, Failure> {
    let domain = generate_domain(kind, &Shape::default())?;
    Ok(domain.prepare(&PrepareOptions::default())?)
}

/// Refines a domain in this process and prints what it took.
fn once(kind: DomainKind, volume: &str, refiner: Refiner<'_>) -> Result<bool, Failure> {
    let ready = ready(kind)?;
    let refiner = refiner.max_volume(volume.parse()?);
    let start = processor_seconds();
    let refined = refiner.refine(&ready.domain, &ready.lattice)?;
    let seconds = processor_seconds() - start;
    if refined.outcome != RefineOutcome::Met {
        return Err(format!("{:?}", refined.outcome).into());
    }
    let status = std::fs::read_to_string("/proc/self/status")?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let peak = peak.ok_or("no VmHWM")?.trim().trim_end_matches(" kB");
    let stats = &refined.stats;
    let searches = stats.searches as f64 / stats.round_points.max(1) as f64;
    println!("result {} {seconds} {peak} {} {searches}", refined.num_tets(), stats.rounds);
    Ok(true)
}

/// Seconds that this thread ran, where the system tells; else those of the clock on the wall.
fn processor_seconds() -> f64 {
    thread_local!(static START: Instant = Instant::now());
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = stat.and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.with(|s| s.elapsed().as_secs_f64()), |ns| ns * 1e-9)
}

/// Runs a program that prints what it took.
fn run(command: &mut Command) -> Result<Taken, Failure> {
    let output = command.stderr(Stdio::inherit()).output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    Taken::parse(&text).ok_or_else(|| format!("{command:?}: {} {text}", output.status).into())
}

/// A Python that has TetGen, if there is one.
fn python() -> Option<String> {
    let python = std::env::var("LTBW_TETGEN_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let mut probe = Command::new(&python);
    probe.args(["-c", "import tetgen"]).stdout(Stdio::null()).stderr(Stdio::null());
    probe.status().is_ok_and(|status| status.success()).then_some(python)
}

/// The paper's problems beside TetGen; true if every bar is met.
fn compare() -> Result<bool, Failure> {
    let own = std::env::current_exe()?;
    let python = python();
    if python.is_none() {
        skip("refinement against TetGen", "tetgen", "Python has no package `tetgen`")?;
    }
    println!(
        "| domain | largest volume | tets | TetGen's | at most | us/tet | TetGen's | ratio | MiB \
         | TetGen's | rounds | searches |\n|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
    );
    let (mut met, mut rounds) = (true, Vec::new());
    for problem in std::iter::once(MILLION).chain(PROBLEMS) {
        let (kind, volume, most) = problem;
        let turns = turns_of(&own, python.as_deref(), kind, volume)?;
        let taken = turns[0].0;
        let (count, searches) = taken.rounds.ok_or("a run has not told its rounds")?;
        rounds.push(count);
        let middle = |number: &dyn Fn(&Turn) -> Option<f64>| {
            let mut all: Vec<f64> = turns.iter().filter_map(number).collect();
            (!all.is_empty()).then(|| median(&mut all))
        };
        let told = |number: Option<f64>, digits| match number {
            Some(number) => format!("{number:.digits$}"),
            None => "-".to_owned(),
        };
        let each = Taken::microseconds_each;
        let ratio = middle(&|(own, other)| Some(each(own) / each(other.as_ref()?)));
        let peak = middle(&|(own, _)| Some(own.peak));
        println!(
            "| {} | {volume:e} | {} | {} | {most} | {} | {} | {} | {} | {} | {count} | \
             {searches:.2} |",
            kind.name(),
            taken.tets,
            told(turns[0].1.map(|other| other.tets as f64), 0),
            told(middle(&|(own, _)| Some(each(own))), 2),
            told(middle(&|(_, other)| Some(each(other.as_ref()?))), 2),
            told(ratio, 2),
            told(peak.map(|peak| peak / 1024.0), 0),
            told(middle(&|(_, other)| Some(other.as_ref()?.peak / 1024.0)), 0),
        );
        met &= taken.tets <= most;
        if problem == MILLION {
            met &= ratio.is_none_or(|ratio| ratio <= SLOWEST);
            met &= peak.is_some_and(|peak| peak <= MEMORY) && searches <= SEARCHES;
        }
    }
    // The million comes first, then a tenth of it.
    met &= rounds[0] <= ROUNDS[0] && rounds[0] <= rounds[1] + ROUNDS[1];
    println!(
        "\nprocessor time of the refinement, one thread, medians of {PAIRS} turns; MiB: peak of \
         the process (TetGen's has Python in it, and reads no facets with holes, as the gear has); \
         searches: a point; a million tetrahedra: at most \
         {SLOWEST} of TetGen's time, {:.0} MiB, {} rounds, {} more than a tenth of it, {SEARCHES} \
         searches; bars {}",
        MEMORY / 1024.0,
        ROUNDS[0],
        ROUNDS[1],
        verdict(met)
    );
    Ok(met)
}

/// A run of this program, and one of TetGen if there is one.
type Turn = (Taken, Option<Taken>);

/// Runs this program, and TetGen if there is one that can read the domain, in turn.
fn turns_of(
    own: &Path,
    python: Option<&str>,
    kind: DomainKind,
    volume: f64,
) -> Result<Vec<Turn>, Failure> {
    let (name, volume) = (kind.name(), format!("{volume:e}"));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tetgen/run.py");
    let file = std::env::temp_dir().join(format!("ltbw-{name}-{}.poly", std::process::id()));
    let domain = ready(kind)?.domain;
    io::write_domain(&file, &domain)?;
    let python = python.filter(|_| domain.facets.iter().all(|facet| facet.holes.is_empty()));
    let turn = |_| {
        let ours = run(Command::new(own).args(["once", &volume, name]))?;
        let theirs =
            python.map(|python| run(Command::new(python).arg(&script).arg(&file).arg(&volume)));
        Ok((ours, theirs.transpose()?))
    };
    let turns = (0..PAIRS).map(turn).collect();
    std::fs::remove_file(&file)?;
    turns
}

fn verdict(met: bool) -> &'static str {
    if met { "met" } else { "MISSED" }
}

/// The table beside one item after the other and the commit before: tetrahedra, time of each, its
/// ratio to that of rounds in the same turn, and memory. True if rounds are as fast as they are to
/// be.
fn engines() -> Result<bool, Failure> {
    let own = std::env::current_exe()?;
    let mut programs = vec![("rounds", own.clone(), None), ("one by one", own, Some("singly"))];
    match std::env::var_os("LTBW_BEFORE") {
        Some(before) => programs.push(("before", PathBuf::from(before), None)),
        None => skip("the commit before", "before", "LTBW_BEFORE names no measure_refine of it")?,
    }
    println!(
        "| largest volume | engine | tets | us/tet | to rounds | MiB |\n|---|---|--:|--:|--:|--:|"
    );
    let mut is_fast = true;
    for (_, volume, _) in [PROBLEMS[0], MILLION] {
        let volume = format!("{volume:e}");
        let mut turns: Vec<Vec<Taken>> = Vec::new();
        for _ in 0..PAIRS {
            let once = |(_, program, engine): &(&str, PathBuf, Option<&str>)| {
                run(Command::new(program).args(["once", &volume]).args(engine))
            };
            turns.push(programs.iter().map(once).collect::<Result<_, _>>()?);
        }
        for (k, (name, ..)) in programs.iter().enumerate() {
            let middle = |number: &dyn Fn(&Vec<Taken>) -> f64| {
                median(&mut turns.iter().map(number).collect::<Vec<_>>())
            };
            let ratio = middle(&|turn| turn[k].microseconds_each() / turn[0].microseconds_each());
            println!(
                "| {volume} | {name} | {} | {:.2} | {ratio:.2} | {:.0} |",
                turns[0][k].tets,
                middle(&|turn| turn[k].microseconds_each()),
                middle(&|turn| turn[k].peak) / 1024.0,
            );
            // The last volume is the million's.
            is_fast = *name != "before" || ratio >= SPEED;
        }
    }
    println!(
        "\nprocessor time of the refinement, one thread, medians of {PAIRS} turns; of a million \
         tetrahedra at least {SPEED} of the speed before; bar {}\n",
        verdict(is_fast)
    );
    Ok(is_fast)
}

/// Time per tetrahedron over random domains (500; `LTBW_CASES`), the least of five runs each; true
/// if none is far slower than the others. By the clock on the wall: a system may count the time
/// that a thread runs in steps that are longer than such a run.
fn evenness() -> Result<bool, Failure> {
    let mut all = Vec::new();
    for seed in 0..u64::from(cases(500)) {
        let (name, domain) = random_domain(seed);
        let ready = domain.prepare(&PrepareOptions::default())?;
        let mut least = f64::INFINITY;
        for _ in 0..5 {
            let start = Instant::now();
            let refined = Refiner::new().refine(&ready.domain, &ready.lattice)?;
            let seconds = start.elapsed().as_secs_f64();
            least = least.min(seconds * 1e6 / refined.num_tets() as f64);
        }
        all.push((least, name, seed));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (median, most) = (all[all.len() / 2].0, all[all.len() - 1]);
    let ratio = most.0 / median;
    println!(
        "\n{} random domains: {median:.2} us for a tetrahedron (median), the slowest ({} {}) \
         {:.2} times that, limit {UNEVEN}; bar {}",
        all.len(),
        most.1,
        most.2,
        ratio,
        verdict(ratio <= UNEVEN)
    );
    Ok(ratio <= UNEVEN)
}
