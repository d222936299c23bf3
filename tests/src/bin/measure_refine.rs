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
use ltbw_tests::domains::random_domain;
use ltbw_tests::require::skip;
use ltbw_tests::{cases, median};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// Pairs of runs for a median.
const PAIRS: usize = 5;
/// The model problem's largest volumes in the paper, and the most tetrahedra allowed: 1.03 times
/// what TetGen makes.
const VOLUMES: [(&str, usize); 2] = [("1.73783e-5", 107_307), ("1.73783e-6", 1_079_619)];
/// Our time per tetrahedron may be this part of TetGen's at the smaller volume.
const SLOWEST: f64 = 1.0;
/// The largest peak memory there, KiB.
const MEMORY: f64 = 300e6 / 1024.0;
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
}

impl Taken {
    /// From the last line of a run's output.
    fn parse(text: &str) -> Option<Self> {
        let line = text.lines().rev().find_map(|line| line.strip_prefix("result "))?;
        let mut words = line.split(' ');
        let tets = words.next()?.parse().ok()?;
        let mut number = || words.next()?.parse().ok();
        Some(Self { tets, seconds: number()?, peak: number()? })
    }

    fn microseconds_each(self) -> f64 {
        self.seconds * 1e6 / self.tets as f64
    }
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let result = match args[..] {
        [] => engines().and_then(|()| Ok(compare()? & evenness()?)),
        ["engines"] => engines().map(|()| true),
        ["once", volume] => once(volume, Refiner::new()),
        ["once", volume, "singly"] => once(volume, Refiner::new().start(usize::MAX)),
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

fn model() -> Result<Prepared, Failure> {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default())?;
    Ok(domain.prepare(&PrepareOptions::default())?)
}

/// Refines the model problem in this process and prints what it took.
fn once(volume: &str, refiner: Refiner<'_>) -> Result<bool, Failure> {
    let ready = model()?;
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
    println!("result {} {seconds} {peak}", refined.num_tets());
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

/// The table; true if every bar is met.
fn compare() -> Result<bool, Failure> {
    let own = std::env::current_exe()?;
    let Some(python) = python() else {
        skip("refinement against TetGen", "tetgen", "Python has no package `tetgen`")?;
        return alone(&own);
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tetgen/run.py");
    let file = std::env::temp_dir().join(format!("ltbw-model-{}.poly", std::process::id()));
    io::write_domain(&file, &model()?.domain)?;
    let result = table(&own, || {
        let mut command = Command::new(&python);
        command.arg(&script).arg(&file);
        command
    });
    std::fs::remove_file(&file)?;
    result
}

/// The table beside one item after the other and the commit before: tetrahedra, time of each, its
/// ratio to that of rounds in the same turn, and memory.
fn engines() -> Result<(), Failure> {
    let own = std::env::current_exe()?;
    let mut programs = vec![("rounds", own.clone(), None), ("one by one", own, Some("singly"))];
    match std::env::var_os("LTBW_BEFORE") {
        Some(before) => programs.push(("before", PathBuf::from(before), None)),
        None => skip("the commit before", "before", "LTBW_BEFORE names no measure_refine of it")?,
    }
    println!(
        "| largest volume | engine | tets | us/tet | to rounds | MiB |\n|---|---|--:|--:|--:|--:|"
    );
    for (volume, _) in VOLUMES {
        let mut turns: Vec<Vec<Taken>> = Vec::new();
        for _ in 0..PAIRS {
            let once = |(_, program, engine): &(&str, PathBuf, Option<&str>)| {
                run(Command::new(program).args(["once", volume]).args(engine))
            };
            turns.push(programs.iter().map(once).collect::<Result<_, _>>()?);
        }
        for (k, (name, ..)) in programs.iter().enumerate() {
            let middle = |number: &dyn Fn(&Vec<Taken>) -> f64| {
                median(&mut turns.iter().map(number).collect::<Vec<_>>())
            };
            println!(
                "| {volume} | {name} | {} | {:.2} | {:.2} | {:.0} |",
                turns[0][k].tets,
                middle(&|turn| turn[k].microseconds_each()),
                middle(&|turn| turn[k].microseconds_each() / turn[0].microseconds_each()),
                middle(&|turn| turn[k].peak) / 1024.0,
            );
        }
    }
    println!("\nprocessor time of the refinement, one thread, medians of {PAIRS} turns\n");
    Ok(())
}

fn table(own: &PathBuf, theirs: impl Fn() -> Command) -> Result<bool, Failure> {
    println!(
        "| largest volume | ltbw, tets | TetGen, tets | ltbw, us/tet | TetGen, us/tet | ratio | \
         limit | ltbw, MiB | TetGen, MiB |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|"
    );
    let mut met = true;
    for (k, (volume, most)) in VOLUMES.into_iter().enumerate() {
        let mut pairs = Vec::new();
        for _ in 0..PAIRS {
            let ours = run(Command::new(own).args(["once", volume]))?;
            pairs.push((ours, run(theirs().arg(volume))?));
        }
        let last = k + 1 == VOLUMES.len();
        let middle = |number: &dyn Fn(&(Taken, Taken)) -> f64| {
            median(&mut pairs.iter().map(number).collect::<Vec<_>>())
        };
        let ratio = middle(&|(a, b)| a.microseconds_each() / b.microseconds_each());
        let (ours, theirs) = pairs[0];
        println!(
            "| {volume} | {} | {} | {:.2} | {:.2} | {ratio:.2} | {} | {:.0} | {:.0} |",
            ours.tets,
            theirs.tets,
            middle(&|p| p.0.microseconds_each()),
            middle(&|p| p.1.microseconds_each()),
            if last { format!("{SLOWEST:.2}") } else { "-".to_owned() },
            middle(&|p| p.0.peak) / 1024.0,
            middle(&|p| p.1.peak) / 1024.0,
        );
        met &= ours.tets <= most && (!last || ratio <= SLOWEST && ours.peak <= MEMORY);
    }
    println!(
        "\nprocessor time of the refinement, one thread, median of {PAIRS} interleaved pairs; MiB: \
         peak of the process (TetGen's has Python in it); bars {}",
        if met { "met" } else { "MISSED" }
    );
    Ok(met)
}

/// The bars that need no TetGen.
fn alone(own: &PathBuf) -> Result<bool, Failure> {
    let mut met = true;
    for (volume, most) in VOLUMES {
        let ours = run(Command::new(own).args(["once", volume]))?;
        println!(
            "largest volume {volume}: {} tetrahedra, {:.2} us each, {:.0} MiB",
            ours.tets,
            ours.microseconds_each(),
            ours.peak / 1024.0
        );
        met &= ours.tets <= most && ours.peak <= MEMORY;
    }
    Ok(met)
}

/// Time per tetrahedron over random domains (500; `LTBW_CASES`), the least of three runs each; true
/// if none is far slower than the others.
fn evenness() -> Result<bool, Failure> {
    let mut all = Vec::new();
    for seed in 0..u64::from(cases(500)) {
        let (name, domain) = random_domain(seed);
        let ready = domain.prepare(&PrepareOptions::default())?;
        let mut least = f64::INFINITY;
        for _ in 0..3 {
            let start = processor_seconds();
            let refined = Refiner::new().refine(&ready.domain, &ready.lattice)?;
            let seconds = processor_seconds() - start;
            least = least.min(seconds * 1e6 / refined.num_tets() as f64);
        }
        all.push((least, name, seed));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (median, most) = (all[all.len() / 2].0, all[all.len() - 1]);
    let ratio = most.0 / median;
    println!(
        "\n{} random domains: {median:.2} us for a tetrahedron (median), the slowest ({} {}) \
         {:.2} times that, limit {UNEVEN}",
        all.len(),
        most.1,
        most.2,
        ratio
    );
    Ok(ratio <= UNEVEN)
}
