//! The thread runtime: the sequential kernel's mesh for any number of threads.

use ltbw::balance::Balance;
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Closure, Rule};
use ltbw::threads::{Parallel, RunError};
use ltbw::{BuildError, Builder, CancelToken, Outcome, Phase, PointSet, Progress, invariants};
use ltbw_generate::{PointKind, generate};
use std::fs;
use std::io::Write;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

/// Longer than any of these tests takes, on a slow machine, too, and than the runtime's own
/// watchdog waits (120 s), which tells the state of each worker.
const PATIENCE: Duration = Duration::from_secs(400);

/// A watch over one test: a run that hangs in a step, where no worker hears of anything, fails,
/// too, and shows what its threads do.
struct Watch(#[allow(dead_code, reason = "is dropped at the end of the test")] Sender<()>);

impl Watch {
    fn new() -> Self {
        Self::with(PATIENCE, || std::process::exit(101))
    }

    fn with(patience: Duration, end: impl FnOnce() + Send + 'static) -> Self {
        let (sender, receiver) = channel();
        let test = thread::current().name().unwrap_or("a test").to_owned();
        thread::spawn(move || {
            if receiver.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
                // Not by `eprintln`, which a test keeps to itself until it ends.
                let mut out = std::io::stderr();
                let _ = writeln!(out, "{test} hangs; its threads, with their clock ticks:");
                let _ = write!(out, "{}", threads());
                thread::sleep(Duration::from_secs(1));
                let _ = write!(out, "a second later:\n{}", threads());
                end();
            }
        });
        Self(sender)
    }
}

/// The threads of this process: name, state, and clock ticks so far. Empty where there is no
/// `/proc`.
fn threads() -> String {
    let tasks = fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let stats = tasks.filter_map(|task| fs::read_to_string(task.path().join("stat")).ok());
    let line = |stat: String| {
        // `number (name) state ...`, of which the twelfth after the name is the time.
        let (name, rest) = stat.split_once('(')?.1.rsplit_once(')')?;
        let fields: Vec<&str> = rest.split_whitespace().collect();
        Some(format!("  {name}: {}, {} ticks\n", fields.first()?, fields.get(11)?))
    };
    stats.filter_map(line).collect()
}

#[test]
fn a_test_that_hangs_is_told_from_one_that_ends() {
    let (sender, hung) = channel();
    let other = sender.clone();
    drop(Watch::with(Duration::from_millis(50), move || sender.send("ended").expect("a test")));
    let watch =
        Watch::with(Duration::from_millis(50), move || other.send("hangs").expect("a test"));
    assert_eq!(hung.recv_timeout(PATIENCE), Ok("hangs"));
    drop(watch);
    assert!(hung.recv_timeout(PATIENCE).is_err(), "both are gone");
    assert!(!cfg!(target_os = "linux") || threads().contains(": "), "{}", threads());
}

fn set(kind: PointKind, count: u64, seed: u64) -> PointSet {
    PointSet::new(generate(kind, count as usize, seed)).expect("finite points")
}

#[test]
fn any_number_of_threads_gives_one_mesh() {
    let _watch = Watch::new();
    for kind in [PointKind::Uniform, PointKind::Grid, PointKind::Clusters, PointKind::Sphere] {
        let set = set(kind, 8000, 5);
        let expected = Builder::new().build(&set).expect("a mesh").mesh.hash().expect("a hash");
        for workers in [1, 2, 3, 4, 8, 16] {
            let run = Parallel::new(workers).build(&set).expect("a mesh");
            assert_eq!(run.outcome, Outcome::Complete);
            assert_eq!(run.mesh.hash().expect("a hash"), expected, "{kind:?} on {workers}");
            let operations: u64 = run.workers.iter().map(|w| w.operations).sum();
            assert_eq!(operations > 0, workers > 1);
        }
    }
}

#[test]
fn duplicates_are_those_of_the_builder() {
    let _watch = Watch::new();
    let mut points = generate(PointKind::Uniform, 3000, 6);
    for k in (0..3000).step_by(7) {
        let p = points[(k * 13 + 5) % 3000];
        points.push(p.map(|c| if c == 0.0 { -c } else { c }));
    }
    let set = PointSet::new(points).expect("finite points");
    let built = Builder::new().build(&set).expect("a mesh");
    assert!(built.duplicates.len() > 400);
    for workers in [1, 2, 3, 8] {
        let run = Parallel::new(workers).build(&set).expect("a mesh");
        assert_eq!(run.duplicates, built.duplicates, "on {workers} workers");
        assert_eq!(run.mesh.duplicates(), built.mesh.duplicates());
    }
}

#[test]
fn the_result_is_a_sound_mesh() {
    let _watch = Watch::new();
    let run = Parallel::new(3).build(&set(PointKind::Uniform, 3000, 1)).expect("a mesh");
    invariants::check_all(&run.mesh).expect("invariants");
    let mut mesh = run.mesh;
    mesh.insert([0.5, 0.25, 0.125]).expect("one more point");
    invariants::check_all(&mesh).expect("invariants");
}

#[test]
fn rules_and_latency_change_nothing() {
    let _watch = Watch::new();
    let set = set(PointKind::Uniform, 1500, 9);
    let expected = Builder::new().build(&set).expect("a mesh").mesh.hash().expect("a hash");
    for rule in Rule::ALL {
        for latency in [0, 300] {
            let run = Parallel::new(4).rule(rule).latency(Duration::from_micros(latency));
            let run = run.build(&set).expect("a mesh");
            assert_eq!(run.mesh.hash().expect("a hash"), expected, "{rule}, {latency} us");
        }
    }
}

#[test]
fn closures_and_ownerships_change_nothing() {
    let _watch = Watch::new();
    let set = set(PointKind::Uniform, 1500, 3);
    let expected = Builder::new().build(&set).expect("a mesh").mesh.hash().expect("a hash");
    for (workers, closure) in [2, 5].into_iter().flat_map(|w| Closure::ALL.map(|c| (w, c))) {
        for ownership in Ownership::ALL {
            let layout = Layout { ownership, ..Layout::new(set.len(), workers) };
            let kernel = Parallel::new(workers).closure(closure).layout(layout);
            let run = kernel.build(&set).expect("a mesh");
            let hash = run.mesh.hash().expect("a hash");
            assert_eq!(hash, expected, "{ownership:?}, {closure} on {workers}");
            let refused = kernel.balance(Balance::default()).build(&set).map(drop);
            let is_refused = matches!(refused, Err(RunError::Settings(_)));
            assert_eq!(is_refused, ownership != Ownership::Block, "{refused:?}");
        }
    }
}

#[test]
fn errors_are_those_of_the_builder() {
    let _watch = Watch::new();
    let flat = (0..50).map(|i| [f64::from(i % 7), f64::from(i / 7), 0.0]).collect();
    let flat = PointSet::new(flat).expect("finite points");
    let error = Parallel::new(2).build(&flat).expect_err("no mesh");
    assert_eq!(error, RunError::Build(BuildError::Coplanar { distinct: 50 }));
    for count in 0..4 {
        let few = set(PointKind::Uniform, count, 1);
        let error = Parallel::new(2).build(&few).expect_err("no mesh");
        assert!(matches!(error, RunError::Build(BuildError::TooFewPoints { .. })), "{error}");
    }
}

#[test]
fn a_cancelled_run_has_a_mesh_of_some_points() {
    let _watch = Watch::new();
    let token = CancelToken::new();
    let set = set(PointKind::Uniform, 20_000, 2);
    // As the first point is inserted.
    let watch = |p: Progress| {
        if p.phase == Phase::Insert {
            token.cancel();
        }
    };
    let run = Parallel::new(4).cancel(&token).observer(&watch).latency(Duration::from_millis(5));
    let run = run.build(&set).expect("a mesh");
    assert_eq!(run.outcome, Outcome::Cancelled);
    assert!((4..20_000).contains(&run.mesh.num_vertices()), "{}", run.mesh.num_vertices());
    invariants::check_all(&run.mesh).expect("invariants");
}

#[test]
fn blocks_that_move_change_nothing() {
    let _watch = Watch::new();
    let set = set(PointKind::Clusters, 20_000, 4);
    let expected = Builder::new().build(&set).expect("a mesh").mesh.hash().expect("a hash");
    let mut moved = 0;
    // Sixteen threads on fewer cores do not run out of points at the same time: sooner or later,
    // as a rule at once, one has blocks to give to another.
    for _ in 0..20 {
        let run = Parallel::new(16).balance(Balance::default()).build(&set).expect("a mesh");
        assert_eq!(run.mesh.hash().expect("a hash"), expected);
        assert_eq!(run.outcome, Outcome::Complete);
        moved += run.workers.iter().map(|w| w.migrated).sum::<u64>();
        if moved > 0 {
            return;
        }
    }
    panic!("no block has ever moved");
}

#[test]
fn blocks_move_in_a_cancelled_run() {
    let _watch = Watch::new();
    let set = set(PointKind::Uniform, 100_000, 4);
    let token = CancelToken::new();
    // No worker waits for the observer.
    let watch = |p: Progress| {
        if p.phase == Phase::Insert {
            thread::sleep(Duration::from_millis(20));
            token.cancel();
        }
    };
    let balance = Balance { low: 2000, ask: 4, again: 10_000 };
    let kernel = Parallel::new(12).balance(balance).cancel(&token).observer(&watch);
    let run = kernel.latency(Duration::from_millis(2)).build(&set);
    let run = run.expect("a mesh");
    assert_eq!(run.outcome, Outcome::Cancelled);
    invariants::check_all(&run.mesh).expect("invariants");
}

#[test]
fn a_mesh_may_stay_distributed() {
    let _watch = Watch::new();
    let set = set(PointKind::Uniform, 5000, 8);
    let parts = Parallel::new(4).build_distributed(&set).expect("a mesh");
    assert_eq!((parts.parts(), parts.outcome()), (4, Outcome::Complete));
    let mut tets: Vec<[u32; 4]> = (0..4).flat_map(|part| parts.tets(part)).collect();
    assert!((0..4).all(|part| parts.tets(part).count() > 1000), "parts are nearly even");
    assert_eq!(parts.tets(4).count(), 0);
    let sort = |tets: &mut Vec<[u32; 4]>| {
        tets.iter_mut().for_each(|tet| tet.sort_unstable());
        tets.sort_unstable();
    };
    let mut whole: Vec<[u32; 4]> = parts.gather().expect("a mesh").mesh.tets().collect();
    sort(&mut tets);
    sort(&mut whole);
    assert_eq!(tets, whole);
}

#[test]
fn figures_are_taken_if_wanted() {
    let _watch = Watch::new();
    let set = set(PointKind::Uniform, 5000, 8);
    let run = Parallel::new(3).build(&set).expect("a mesh");
    assert!(run.summary.is_none() && run.trace.is_none());
    let run = Parallel::new(3).measure(0).build(&set).expect("a mesh");
    assert!(run.trace.is_none());
    let run = Parallel::new(3).measure(1 << 20).build(&set).expect("a mesh");
    let (summary, trace) = (run.summary.expect("figures"), run.trace.expect("a timeline"));
    assert!(trace.is_complete);
    let counted = |w: &ltbw::threads::WorkerStats| w.local + w.operations;
    assert_eq!(summary.operations(), run.workers.iter().map(counted).sum::<u64>());
    assert_eq!(summary.setbacks(), run.workers.iter().map(|w| w.setbacks).sum::<u64>());
    let messages: u64 = run.workers.iter().map(|w| w.messages).sum();
    assert_eq!(summary.all_messages().count, messages);
    for (worker, stats) in summary.workers.iter().zip(&run.workers) {
        assert_eq!(worker.times.all(), summary.makespan, "all time is accounted for");
        assert_eq!([worker.polls.total, worker.polls.useful], stats.polls);
        assert!(worker.tets > 0 && worker.times.meshing > 0);
        let spans: Vec<_> = trace.spans.iter().filter(|s| s.worker == worker.worker).collect();
        assert!(spans.windows(2).all(|pair| pair[0].end == pair[1].begin), "a gap");
    }
    assert!(summary.lt().is_none_or(|lt| (0.0..=1.0).contains(&lt)));
}
