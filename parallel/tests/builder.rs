//! The builder: one mesh, one meaning of budget, cancel and progress, for any number of threads.

use ltbw::{Budget, BuildError, Builder, Built, CancelToken, Order, Outcome, Phase, Progress};
use ltbw::{PointSet, invariants, threads::RunError};
use ltbw_generate::{PointKind, generate};
use std::sync::Mutex;
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

fn set(kind: PointKind, count: usize) -> PointSet {
    PointSet::new(generate(kind, count, 7)).expect("finite points")
}

fn points(most: u64) -> Budget {
    Budget { max_points: Some(most), ..Budget::default() }
}

fn hash(built: &Built) -> String {
    built.mesh.hash().expect("a hash").to_string()
}

#[test]
fn a_budget_means_the_same_for_any_number_of_threads() {
    for kind in PointKind::ALL {
        let set = set(kind, 250);
        let n = set.len() as u64;
        let mut meshes = Vec::new();
        for most in [0, 4, 5, n / 3, n - 1, n, n + 1] {
            let order = if most % 2 == 0 { Order::Brio } else { Order::Input };
            let build = |threads| {
                let builder = Builder::new().threads(threads).order(order);
                builder.budget(points(most)).build(&set).expect("a mesh")
            };
            let mut expected = build(1);
            let outcome = if most < n { Outcome::Budget } else { Outcome::Complete };
            assert_eq!(expected.outcome, outcome, "{kind:?}, {most} of {n}");
            meshes.push(hash(&expected));
            let next = expected.mesh.insert([0.1, 0.2, 0.3]).expect("one more");
            for threads in [2, 3] {
                let mut built = build(threads);
                let what = format!("{kind:?}, {most} of {n}, {threads} threads");
                assert_eq!(Some(&hash(&built)), meshes.last(), "{what}");
                assert_eq!((built.outcome, &built.duplicates), (outcome, &expected.duplicates));
                let mut numbers: Vec<u32> = built.mesh.vertices().map(|(v, _)| v).collect();
                numbers.sort_unstable();
                assert!(numbers.len() as u64 <= most.max(4) && numbers.last() < Some(&(n as u32)));
                assert_eq!(built.mesh.insert([0.1, 0.2, 0.3]), Ok(next), "{what}");
                invariants::check_all(&built.mesh).expect(&what);
            }
        }
        meshes.dedup();
        assert!(meshes.len() >= 4, "{kind:?}: budgets differ");
    }
}

#[test]
fn a_budget_of_tetrahedra_means_the_same_for_any_number_of_threads() {
    let set = set(PointKind::Uniform, 5000);
    let budget = Budget { max_tets: Some(9000), ..Budget::default() };
    let build = |threads| Builder::new().threads(threads).budget(budget).build(&set);
    let expected = build(1).expect("a mesh");
    assert_eq!(expected.outcome, Outcome::Budget);
    assert!((9000..20_000).contains(&expected.mesh.num_tets()));
    for threads in [2, 3] {
        assert_eq!(hash(&build(threads).expect("a mesh")), hash(&expected));
    }
}

#[test]
fn progress_comes_from_the_calling_thread_by_time() {
    let set = set(PointKind::Uniform, 150_000);
    for threads in [1, 2, 3] {
        let reports: Mutex<Vec<(Progress, ThreadId, Instant)>> = Mutex::default();
        let watch = |p: Progress| {
            reports.lock().expect("reports").push((p, thread::current().id(), Instant::now()));
        };
        let built = Builder::new().threads(threads).observer(&watch).build(&set).expect("a mesh");
        assert_eq!(built.workers.len(), if threads == 1 { 0 } else { threads as usize });
        let reports = reports.into_inner().expect("reports");
        let mut phases: Vec<Phase> = reports.iter().map(|(p, ..)| p.phase).collect();
        phases.dedup();
        let expected = [Phase::Order, Phase::Insert, Phase::Gather];
        assert_eq!(phases, expected[..if threads == 1 { 2 } else { 3 }]);
        assert!(reports.iter().all(|(p, ..)| p.total == Some(150_000)));
        assert!(reports.iter().all(|(_, id, _)| *id == thread::current().id()));
        let inserted: Vec<_> = reports.iter().filter(|(p, ..)| p.phase == Phase::Insert).collect();
        assert!(inserted.windows(2).all(|pair| pair[0].0.done <= pair[1].0.done));
        assert_eq!(inserted.last().expect("a report").0.done, 150_000);
        // The last one says that all is done, whenever that is.
        let by_time = &inserted[..inserted.len() - 1];
        assert!(by_time.windows(2).all(|p| p[1].2 - p[0].2 >= Duration::from_millis(99)));
        if threads > 1 {
            // The figures are those of the workers on the way, not of the ends alone.
            assert!(by_time.iter().any(|(p, ..)| p.done > 20_000), "{by_time:?}");
        }
    }
}

#[test]
fn a_cancelled_build_has_a_valid_mesh_soon() {
    let set = set(PointKind::Uniform, 400_000);
    for threads in [1, 2, 3] {
        let token = CancelToken::new();
        let cancelled: Mutex<Option<Instant>> = Mutex::default();
        let watch = |p: Progress| {
            if p.phase == Phase::Insert && p.done > 30_000 && !token.is_cancelled() {
                *cancelled.lock().expect("a time") = Some(Instant::now());
                token.cancel();
            }
        };
        let builder = Builder::new().threads(threads).observer(&watch).cancel(&token);
        let built = builder.build(&set).expect("a mesh");
        let cancelled = cancelled.into_inner().expect("a time").expect("cancelled");
        assert!(cancelled.elapsed() < Duration::from_millis(500), "{:?}", cancelled.elapsed());
        assert_eq!(built.outcome, Outcome::Cancelled);
        let vertices = built.mesh.num_vertices();
        assert!((30_000..400_000).contains(&vertices), "{vertices} on {threads}");
        invariants::check_all(&built.mesh).expect("invariants");
    }
}

#[test]
fn a_build_that_is_cancelled_before_has_no_mesh() {
    let token = CancelToken::new();
    token.cancel();
    let set = set(PointKind::Uniform, 2000);
    for (threads, most) in [(1, None), (2, None), (3, None), (2, Some(500))] {
        let budget = Budget { max_points: most, max_tets: None };
        let builder = Builder::new().threads(threads).cancel(&token).budget(budget);
        let error = builder.build(&set).expect_err("no mesh");
        assert_eq!(error, RunError::Build(BuildError::Cancelled), "{threads} threads");
    }
}

/// The points that a budget allows are sorted out before the workers begin: a phase, too.
#[test]
fn the_choice_of_a_budget_is_told_and_may_be_cancelled() {
    let set = set(PointKind::Uniform, 20_000);
    let told = Mutex::new(Vec::new());
    let watch = |p: Progress| told.lock().expect("a list").push(p);
    let builder = Builder::new().threads(2).observer(&watch);
    builder.budget(points(5000)).build(&set).expect("a mesh");
    let order = |told: &[Progress]| told.iter().filter(|p| p.phase == Phase::Order).count();
    let list = std::mem::take(&mut *told.lock().expect("a list"));
    assert_eq!(list[0], Progress { phase: Phase::Order, done: 0, total: Some(5000) });
    assert_eq!(order(&list), 2, "the choice, and the workers' order: {list:?}");
    builder.build(&set).expect("a mesh");
    assert_eq!(order(&told.lock().expect("a list")), 1, "nothing to choose");
    // Cancelled by the first report, the points are not sorted: four threads would not begin.
    let token = CancelToken::new();
    let reports = Mutex::new(0);
    let cancels = |_: Progress| {
        *reports.lock().expect("a number") += 1;
        token.cancel();
    };
    let builder = Builder::new().threads(4).observer(&cancels).cancel(&token);
    let error = builder.budget(points(5000)).build(&set).expect_err("no mesh");
    assert_eq!(error, RunError::Build(BuildError::Cancelled));
    assert_eq!(*reports.lock().expect("a number"), 1);
}

#[test]
fn parts_and_figures_are_kept_if_wanted() {
    let set = set(PointKind::Uniform, 4000);
    for threads in [1, 2, 3] {
        let built = Builder::new().threads(threads).build(&set).expect("a mesh");
        assert!(built.parts.is_empty() && built.summary.is_none() && built.trace.is_none());
        let built = Builder::new().threads(threads).parts().measure(1 << 20).build(&set);
        let built = built.expect("a mesh");
        assert_eq!(built.parts.len(), threads as usize);
        assert_eq!(built.parts.iter().map(Vec::len).sum::<usize>(), built.mesh.num_tets());
        assert_eq!(built.summary.is_some(), threads > 1);
        assert_eq!(built.trace.is_some(), threads > 1);
    }
}

#[test]
fn a_builder_shows_its_settings() {
    let watch = |_: Progress| {};
    let builder = Builder::new().threads(3).order(Order::Input).observer(&watch).budget(points(9));
    let text = format!("{builder:?}");
    for part in ["threads: 3", "order: Input", "max_points: Some(9)", "observer: true"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}
