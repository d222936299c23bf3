//! Stacks of thin layers: all angles are right ones, so nothing excuses a bound that is not met,
//! and one mesh comes of any number of threads or workers.
//!
//! 60 by default, none of them very large, most with ratio 2 alone or a 3,000th of the volume,
//! every tenth with a 30,000th; `LTBW_CASES` for more, and then each with all bounds
//! (`cargo xtask stacks [COUNT]`, 1,000).

use ltbw::domain::Prepared;
use ltbw::refine::{RefineOutcome, Refined, Refiner};
use ltbw::refining::rounds_on_threads;
use ltbw::threads::Parallel;
use ltbw_tests::domains::prepared;
use ltbw_tests::excuses::{ALLOWED, Meeting, judge_refined, limits};
use ltbw_tests::layered::Stack;
use ltbw_tests::seeds;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::available_parallelism;

/// The stacks of a usual run.
const USUAL: u32 = 60;

/// Stacks after which a long run says how far it is.
const SHOWN: usize = 50;

/// The bound beside that of a circumradius of at most twice the shortest edge: a volume of at most
/// this part of the stack's, if any.
type Parts = Option<f64>;

/// Numbers of threads that share a mesh, and of workers that share none; the first is judged.
const THREADS: [usize; 3] = [1, 2, 5];
const WORKERS: [u32; 2] = [1, 3];

/// A stack, and bounds.
struct Case {
    name: String,
    ready: Prepared,
    volume: f64,
}

impl Case {
    fn new(seed: u64) -> Self {
        let most = if seed < u64::from(USUAL) { 6e3 } else { 4e4 };
        let stack = Stack::random(seed, most);
        Self { name: stack.to_string(), ready: prepared(&stack.domain()), volume: stack.volume() }
    }

    /// Refines in all ways from `start` vertices on, if that is said; tells what is wrong.
    fn run(&self, parts: Parts, start: Option<usize>) -> Result<(), String> {
        let max_volume = parts.map(|parts| self.volume / parts);
        let mut refiner = Refiner::new().radius_edge(2.0);
        if let Some(volume) = max_volume {
            refiner = refiner.max_volume(volume);
        }
        if let Some(start) = start {
            refiner = refiner.start(start);
        }
        let name = format!("{}; ratio 2, volume / {parts:?}, rounds from {start:?}", self.name);
        let whole = (&self.ready.domain, &self.ready.lattice);
        let on_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let refined = pool.expect("threads").install(|| refiner.refine(whole.0, whole.1));
            refined.map_err(|error| format!("{name}: {threads} threads: {error}"))
        };
        let first = on_threads(THREADS[0])?;
        let bounds = limits(&self.ready.domain, Some(2.0), max_volume);
        let (found, count) = judge_refined(&self.ready, &first, &bounds)
            .map_err(|defect| format!("{name}: {defect}"))?;
        assert_eq!(count.features.meeting(), Meeting::Wide, "{name}: right angles only");
        let mut wrong = Vec::new();
        if count.is_broken() {
            wrong.push(count.to_string());
        }
        if first.outcome == RefineOutcome::Met && !found.passed() {
            wrong.push(format!("called met, but {:?}", found.counts));
        }
        let hash = |refined: &Refined| refined.mesh().hash().map(|h| h.to_string());
        let own = hash(&first).map_err(|error| format!("{name}: {error}"))?;
        let mut compare = |way: String, other: &Refined| {
            let hash = hash(other).unwrap_or_else(|error| error.to_string());
            if hash != own || other.outcome != first.outcome {
                let outcomes = [first.outcome, other.outcome];
                wrong.push(format!("{way}: {hash}, one thread: {own}; {outcomes:?}"));
            }
        };
        for threads in &THREADS[1..] {
            compare(format!("{threads} threads"), &on_threads(*threads)?);
        }
        for workers in WORKERS {
            let run = rounds_on_threads(&refiner, whole, &Parallel::new(workers));
            let run = run.map_err(|error| format!("{name}: {workers} workers: {error}"))?;
            compare(format!("{workers} workers"), &run.refined);
        }
        if wrong.is_empty() { Ok(()) } else { Err(format!("{name}: {}", wrong.join("; "))) }
    }
}

/// Runs `judge` for every seed, on all processors if there are more than the usual ones, and fails
/// with all that it has found wrong.
fn for_each_stack(what: &str, judge: impl Fn(u64) -> Vec<Result<(), String>> + Sync) {
    let seeds = seeds(USUAL);
    let count = seeds.clone().count();
    let (next, found) = (AtomicU64::new(seeds.start), Mutex::new(BTreeMap::new()));
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return;
            }
            let judged = judge(seed);
            judged.iter().filter_map(|case| case.as_ref().err()).for_each(|text| {
                println!("{what}: {text}");
            });
            let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
            found.insert(seed, judged);
            if found.len().is_multiple_of(SHOWN) {
                println!("{what}: {} of {count} are done", found.len());
            }
        }
    };
    let processors = available_parallelism().map_or(1, usize::from);
    let together = if seeds.end > u64::from(USUAL) { processors } else { 1 };
    std::thread::scope(|scope| {
        (0..together).for_each(|_| drop(scope.spawn(work)));
    });
    let found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    assert_eq!(found.len(), count, "every stack is judged");
    let stacks = found.values().filter(|judged| judged.iter().any(Result::is_err)).count();
    let judged: Vec<_> = found.into_values().flatten().collect();
    let runs = judged.len();
    let wrong: Vec<String> = judged.into_iter().filter_map(Result::err).collect();
    println!("{what}: {count} stacks, {runs} cases, {} of them wrong", wrong.len());
    assert!(runs >= count, "{runs} cases of {count} stacks");
    assert!(
        wrong.is_empty(),
        "{what}: {stacks} of {count} stacks are wrong (at most {} % of the volume may be over a \
         bound, and all meshes are one):\n{}",
        100.0 * ALLOWED,
        wrong.join("\n")
    );
}

/// As users call it: rounds begin where they are worth it.
#[test]
fn stacks_meet_their_bounds() {
    for_each_stack("stacks", |seed| {
        let case = Case::new(seed);
        let all = [None, Some(3_000.0), Some(30_000.0)];
        let is_usual = seeds(USUAL).end <= u64::from(USUAL);
        let parts = match seed % 10 {
            _ if !is_usual => &all[..],
            0 => &all[2..],
            k if k % 2 == 1 => &all[..1],
            _ => &all[1..2],
        };
        parts.iter().map(|parts| case.run(*parts, None)).collect()
    });
}

/// In rounds from the first point on: most of these meshes have too few vertices for any otherwise.
#[test]
fn stacks_meet_their_bounds_in_rounds() {
    for_each_stack("stacks in rounds", |seed| {
        let case = Case::new(seed);
        let parts = if seed % 2 == 0 { Some(3_000.0) } else { None };
        vec![case.run(parts, Some(0))]
    });
}
