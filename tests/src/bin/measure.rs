//! `measure bench [SET]...`, `measure bench removal`, `measure bars` and `measure once SET`: our
//! build against CGAL's, side by side.
//!
//! Times are order plus insertion, input in memory, one thread each. Runs are interleaved in pairs
//! (ours, CGAL's, ours, ...) so that a slow spell of the machine hits both, and the median of the
//! pairs' ratios is reported beside the median times. `cargo xtask bench` and `cargo xtask bars`
//! build this with the release profile. Peak memory is that of a process of its own that holds the
//! input and builds once (`measure once`); CGAL's is its server's.

use ltbw::order::hilbert;
use ltbw::{Builder, Order, PointSet};
use ltbw_tests::cgal::{Ask, Cgal};
use ltbw_tests::families::{Family, Size, all, more_speed, uniform, wide};
use ltbw_tests::median;
use std::process::{Command, ExitCode};
use std::time::Instant;

/// Pairs per set for a median.
const PAIRS: usize = 7;
/// Pairs with CGAL's parallel version.
const TBB_PAIRS: usize = 3;
/// Threads of CGAL's parallel version.
const TBB_THREADS: u16 = 2;
/// No set may take more than this many times CGAL's time ...
const SLOWEST: f64 = 3.0;
/// ... and these sets at most this part of CGAL's time.
const LIMITS: [(&str, f64); 7] = [
    ("uniform", 0.58),
    ("grid", 0.60),
    ("rounded-sphere", 0.60),
    ("shell", 0.68),
    ("clusters", 0.68),
    ("moment-curve", 1.0),
    ("skew-lines", 1.0),
];
/// Largest peak memory of the uniform million, MiB.
const MEMORY: f64 = 400.0 * 1e6 / 1_048_576.0;
/// Removing may take this many times the time of inserting.
const REMOVAL: f64 = 3.0;
/// Uniform points of which half are removed and put back.
const REMOVED: usize = 200_000;
/// Time per point may grow by this factor from 100,000 to 4,000,000 uniform points.
const GROWTH: f64 = 1.4;

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let result = match args[..] {
        ["bench", "removal"] => removal(),
        ["bench", ref names @ ..] => run(names, PAIRS, false),
        ["bars"] => run(&[], 1, true),
        ["once", name] => once(name),
        _ => Err("usage: measure bench [SET]... | measure bars | measure once SET".into()),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(failure) => {
            eprintln!("measure: {failure}");
            ExitCode::FAILURE
        }
    }
}

/// The sets whose speed counts.
fn sets() -> Vec<Family> {
    all(Size::Full).into_iter().chain(more_speed(Size::Full)).collect()
}

/// Measures the sets called `names` (all, if none), in at least `pairs` pairs; with `hashes`, the
/// meshes are compared, too. True if every bar is met.
fn run(names: &[&str], pairs: usize, hashes: bool) -> Result<bool, Failure> {
    let mut sets = sets();
    if let Some(unknown) = names.iter().find(|name| sets.iter().all(|set| set.name != **name)) {
        let known: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        return Err(format!("no set is called {unknown}; there are {}", known.join(", ")).into());
    }
    sets.retain(|set| names.is_empty() || names.contains(&set.name.as_str()));
    println!(
        "| set | points | tetrahedra | ltbw, s | CGAL, s | ratio | limit | TBB ratio | \
         ltbw, MiB | CGAL, MiB | hash |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|");
    let mut met = true;
    for set in sets {
        met &= measure(&set, pairs, hashes)?;
    }
    if hashes {
        met &= wide_hashes()?;
    }
    if names.is_empty() {
        met &= growth()? & removal()?;
    }
    println!(
        "\nltbw / CGAL: order + insert, one thread, median of pairs; TBB ratio: ours on one thread \
         against CGAL's parallel version on {TBB_THREADS}; MiB: peak of the process; bars {}",
        if met { "met" } else { "MISSED" }
    );
    Ok(met)
}

/// Seconds of our build, and the mesh.
fn ours(set: &PointSet) -> Result<(f64, ltbw::Mesh), Failure> {
    let built = Builder::new().order(Order::Brio).build(set)?;
    Ok((built.stats.order_seconds + built.stats.insert_seconds, built.mesh))
}

/// One row of the table; true if its bars are met.
fn measure(family: &Family, pairs: usize, hashes: bool) -> Result<bool, Failure> {
    let limit = LIMITS.iter().find(|(name, _)| *name == family.name).map_or(SLOWEST, |l| l.1);
    // A tight bar deserves a median even where the others make do with one pair.
    let pairs = if limit < SLOWEST { pairs.max(PAIRS) } else { pairs };
    // A server per set, so that no set inherits the memory of another.
    let mut cgal = Cgal::start()?;
    let (mut own, mut theirs, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let (mut tets, mut hash, mut peak) = (0, "-", 0);
    let set = PointSet::new(family.points.clone())?;
    for pair in 0..pairs {
        let (seconds, mesh) = ours(&set)?;
        tets = mesh.num_tets();
        let ask = Ask { hash: hashes && pair == 0, ..Ask::default() };
        let reply = cgal.ask(&family.points, ask)?;
        if ask.hash {
            hash = if reply.hash == Some(mesh.hash()?) { "equal" } else { "DIFFERS" };
        } else if peak == 0 {
            peak = reply.peak_rss;
        }
        own.push(seconds);
        theirs.push(reply.seconds);
        ratios.push(seconds / reply.seconds);
    }
    let ratio = median(&mut ratios);
    let memory = peak_of(&family.name)?;
    let fits = family.name != "uniform" || memory <= MEMORY;
    println!(
        "| {} | {} | {tets} | {:.3} | {:.3} | {ratio:.2} | {limit:.2} | {} | {memory:.0} | {:.0} | \
         {hash} |",
        family.name,
        family.points.len(),
        median(&mut own),
        median(&mut theirs),
        if hashes { "-".to_string() } else { tbb_ratio(family, &set)? },
        peak as f64 / 1_048_576.0,
    );
    Ok(ratio <= limit && hash != "DIFFERS" && fits)
}

/// Our time on one thread against that of CGAL's parallel version.
fn tbb_ratio(family: &Family, set: &PointSet) -> Result<String, Failure> {
    let Ok(mut cgal) = Cgal::start_tbb() else { return Ok("no TBB".to_string()) };
    let mut ratios = Vec::new();
    for _ in 0..TBB_PAIRS {
        let (seconds, _) = ours(set)?;
        let ask = Ask { threads: TBB_THREADS, ..Ask::default() };
        ratios.push(seconds / cgal.ask(&family.points, ask)?.seconds);
    }
    Ok(format!("{:.2}", median(&mut ratios)))
}

/// The hashes of the sets outside the exactness window; true if all are equal.
fn wide_hashes() -> Result<bool, Failure> {
    let mut equal = true;
    for family in wide(Size::Full) {
        let (_, mesh) = ours(&PointSet::new(family.points.clone())?)?;
        let same = Cgal::start()?.hash(&family.points)? == Some(mesh.hash()?);
        println!(
            "\n{}, {} points, {} tetrahedra: hash {}",
            family.name,
            family.points.len(),
            mesh.num_tets(),
            if same { "equal" } else { "DIFFERS" }
        );
        equal &= same;
    }
    Ok(equal)
}

/// The growth of the time per point with the number of points; true if the bar is met.
fn growth() -> Result<bool, Failure> {
    let mut ratios = Vec::new();
    let small = PointSet::new(uniform(100_000, 1))?;
    let large = PointSet::new(uniform(4_000_000, 1))?;
    for _ in 0..TBB_PAIRS {
        let few = (0..5).map(|_| ours(&small).map(|(s, _)| s)).collect::<Result<Vec<f64>, _>>()?;
        let few = median(&mut few.clone()) / 100_000.0;
        let many = ours(&large)?.0 / 4_000_000.0;
        ratios.push(many / few);
    }
    let growth = median(&mut ratios);
    println!(
        "\ntime per point at 4,000,000 / at 100,000 uniform points: {growth:.2}, limit {GROWTH}"
    );
    Ok(growth <= GROWTH)
}

/// The time of removing uniform points beside that of putting them back, and beside CGAL's; true if
/// the bar is met.
fn removal() -> Result<bool, Failure> {
    let mut points = uniform(REMOVED, 1);
    // The points that stay, then the others, each along the curve.
    for half in points.chunks_mut(REMOVED / 2) {
        let sorted: Vec<_> = hilbert(half).into_iter().map(|i| half[i as usize]).collect();
        half.copy_from_slice(&sorted);
    }
    let set = PointSet::new(points.clone())?;
    let mut cgal = Cgal::start()?;
    let (mut times, mut against) = (Vec::new(), Vec::new());
    for _ in 0..PAIRS {
        let (_, mut mesh) = ours(&set)?;
        let clock = Instant::now();
        for v in REMOVED / 2..REMOVED {
            mesh.remove(v as u32)?;
        }
        let removed = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        for &p in &points[REMOVED / 2..] {
            mesh.insert(p)?;
        }
        times.push(removed / clock.elapsed().as_secs_f64());
        let theirs = cgal.ask(&points, Ask { remove: true, ..Ask::default() })?;
        against.push(removed / theirs.seconds);
    }
    let (times, against) = (median(&mut times), median(&mut against));
    println!(
        "\nremoving half of {REMOVED} uniform points / putting them back: {times:.2}, limit \
         {REMOVAL}; / CGAL's removing: {against:.2}"
    );
    Ok(times <= REMOVAL)
}

/// Peak memory, in MiB, of a process that holds the set and builds its mesh.
fn peak_of(name: &str) -> Result<f64, Failure> {
    let output = Command::new(std::env::current_exe()?).args(["once", name]).output()?;
    let text = String::from_utf8(output.stdout)?;
    let kib = text.trim().parse::<f64>().map_err(|_| format!("measure once {name}: {text}"))?;
    Ok(kib / 1024.0)
}

/// Builds the set once and prints the peak memory of this process, in KiB.
fn once(name: &str) -> Result<bool, Failure> {
    let points = match name {
        // Without the other sets in memory.
        "uniform" => uniform(1_000_000, 1),
        _ => {
            let set = sets().into_iter().find(|set| set.name == name);
            set.ok_or_else(|| format!("no set is called {name}"))?.points
        }
    };
    reset_peak();
    let set = PointSet::new(points)?;
    let mesh = ours(&set)?;
    let status = std::fs::read_to_string("/proc/self/status")?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    println!("{}", peak.ok_or("no VmHWM")?.trim().trim_end_matches(" kB"));
    drop(mesh);
    Ok(true)
}

/// Lets the peak count from now, where the system can: making the sets took memory, too.
fn reset_peak() {
    // Linux: see clear_refs in proc(5). Elsewhere, or refused, the peak is an upper bound.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}
