//! `measure bench [SET]...` and `measure bars`: our build against CGAL's, side by side.
//!
//! Times are order plus insertion, input in memory, one thread each. Runs are interleaved in pairs
//! (ours, CGAL's, ours, ...) so that a slow spell of the machine hits both, and the median of the
//! pairs' ratios is reported beside the median times. `cargo xtask bench` and `cargo xtask bars`
//! build this with the release profile.

use ltbw::{Builder, Order, PointSet};
use ltbw_tests::cgal::{Ask, Cgal};
use ltbw_tests::families::{Family, Size, all};
use std::process::ExitCode;

/// Pairs per set for a median.
const PAIRS: usize = 7;
/// No set may take more than this many times CGAL's time.
const SLOWEST: f64 = 3.0;
/// The uniform million must take at most this part of CGAL's time.
const UNIFORM: f64 = 0.75;

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let result = match args.split_first() {
        Some((mode, names)) if mode == "bench" => run(names, PAIRS, false),
        Some((mode, [])) if mode == "bars" => run(&[], 1, true),
        _ => Err("usage: measure bench [SET]... | measure bars".into()),
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

/// Measures the sets called `names` (all, if none), in at least `pairs` pairs; with `hashes`, the
/// meshes are compared, too. True if every bar is met.
fn run(names: &[String], pairs: usize, hashes: bool) -> Result<bool, Failure> {
    let sets = all(Size::Full);
    if let Some(unknown) = names.iter().find(|name| sets.iter().all(|set| set.name != **name)) {
        let known: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        return Err(format!("no set is called {unknown}; there are {}", known.join(", ")).into());
    }
    println!("| set | points | tetrahedra | ltbw, s | CGAL, s | ratio | limit | hash |");
    println!("|---|--:|--:|--:|--:|--:|--:|---|");
    let mut met = true;
    for set in sets.into_iter().filter(|set| names.is_empty() || names.contains(&set.name)) {
        met &= measure(&set, pairs, hashes)?;
    }
    println!(
        "\nltbw / CGAL, order + insert, one thread; bars {}",
        if met { "met" } else { "MISSED" }
    );
    Ok(met)
}

/// One row of the table; true if its bars are met.
fn measure(family: &Family, pairs: usize, hashes: bool) -> Result<bool, Failure> {
    let limit = if family.name == "uniform" { UNIFORM } else { SLOWEST };
    // A tight bar deserves a median even where the others make do with one pair.
    let pairs = if limit < 1.0 { pairs.max(PAIRS) } else { pairs };
    // A server per set, so that no set inherits the memory of another.
    let mut cgal = Cgal::start()?;
    let (mut ours, mut theirs, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let (mut tets, mut hash) = (0, "-");
    for pair in 0..pairs {
        let set = PointSet::new(family.points.clone())?;
        let built = Builder::new().order(Order::Brio).build(&set)?;
        let seconds = built.stats.order_seconds + built.stats.insert_seconds;
        tets = built.mesh.tets().count();
        let ask = Ask { hash: hashes && pair == 0, ..Ask::default() };
        let reply = cgal.ask(&family.points, ask)?;
        if ask.hash {
            hash = if reply.hash == Some(built.mesh.hash()?) { "equal" } else { "DIFFERS" };
        }
        ours.push(seconds);
        theirs.push(reply.seconds);
        ratios.push(seconds / reply.seconds);
    }
    let ratio = median(&mut ratios);
    println!(
        "| {} | {} | {tets} | {:.3} | {:.3} | {ratio:.2} | {limit} | {hash} |",
        family.name,
        family.points.len(),
        median(&mut ours),
        median(&mut theirs),
    );
    Ok(ratio <= limit && hash != "DIFFERS")
}

/// The middle of at least one number; of an even count, the upper of the two.
fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}
