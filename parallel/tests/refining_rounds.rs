//! Domains refined in rounds by workers that share no mesh, on threads and on simulated processors:
//! the mesh is that of the engine, whatever the number of workers and the timing.

use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::{Layout, Ownership, Redeal};
use ltbw::protocol::{Config, Correct, Rules, WorkerId};
use ltbw::refine::{ComplexError, RefineOutcome, Refined, Refiner};
use ltbw::refining::{
    Ending, Plan, RefineError, SimulatedRounds, rounds_on_threads, simulate_rounds,
    simulate_rounds_as,
};
use ltbw::simulate::{Bursts, Network, Options};
use ltbw::threads::Parallel;
use ltbw::{BuildError, Builder, CancelToken, Mesh, MeshHash, Point, PointSet, invariants};
use ltbw_generate::layers::stack;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::time::Duration;

/// The number of random cases: that of `LTBW_CASES`, if it is set.
fn cases(number: u64) -> u64 {
    std::env::var("LTBW_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(number)
}

pub(crate) fn prepared(kind: DomainKind, shape: &Shape) -> Prepared {
    let domain = generate_domain(kind, shape).expect("a shape");
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

fn hash(mesh: &Mesh) -> MeshHash {
    mesh.hash().expect("a hash")
}

/// Processors with messages of `latency` nanoseconds.
pub(crate) fn options(latency: u64) -> Options {
    let network = Network { latency, ..Network::default() };
    Options { network, max_events: 100_000_000, ..Options::default() }
}

pub(crate) fn simulated(
    refiner: &Refiner<'_>,
    ready: &Prepared,
    of: (u32, u64),
) -> SimulatedRounds {
    simulated_by::<Correct>(refiner, ready, of).expect("a run ends")
}

/// Refines on simulated processors, of a latency, that keep to these rules.
pub(crate) fn simulated_by<C: Rules>(
    refiner: &Refiner<'_>,
    ready: &Prepared,
    (processors, latency): (u32, u64),
) -> Result<SimulatedRounds, RefineError> {
    let mut options = options(latency);
    options.check_every = 20_000;
    let plan =
        |points| Plan { layout: Layout::new(points, processors), config: Config::new(processors) };
    simulate_rounds_as::<C>(refiner, &ready.domain, &ready.lattice, plan, &options)
}

pub(crate) fn same(name: &str, one: &Refined, other: &Refined) {
    assert_eq!(hash(one.mesh()), hash(other.mesh()), "{name}");
    let [a, b] = [one, other].map(Refined::with_exterior);
    assert!(a.points == b.points && a.tets == b.tets, "{name}");
    assert!(a.tet_tags == b.tet_tags && a.faces == b.faces, "{name}");
    assert_eq!(one.outcome, other.outcome, "{name}");
    let excuses = |refined: &Refined| -> Vec<_> {
        refined.excuses.iter().map(|e| (refined.tet(e.tet), e.reason)).collect()
    };
    assert!(excuses(one) == excuses(other), "{name}: other excuses");
    let figures = |refined: &Refined| {
        let stats = refined.stats;
        let rounds = (stats.rounds, stats.rounds_with, stats.widest, stats.round_points);
        (rounds, stats.searches, stats.joint_phases, stats.before_slivers)
    };
    assert_eq!(figures(one), figures(other), "{name}");
}

/// The matrix that every domain goes through, beside simulated processors and cuts that move:
/// workers, and the threads of all that is not theirs (the start, late steps, sorting). Without
/// workers it is the engine; that on one thread is what all are compared with.
const MATRIX: [(u32, usize); 8] = [(0, 2), (0, 8), (1, 1), (1, 2), (2, 1), (2, 2), (3, 2), (8, 1)];

/// Refines in every way: one mesh. Returns how the workers' rounds have ended.
pub(crate) fn one_mesh(
    name: &str,
    refiner: &Refiner<'_>,
    ready: &Prepared,
) -> Result<Ending, ComplexError> {
    let refiner = &refiner.count_angles();
    let engine = in_pool(1, || refiner.refine(&ready.domain, &ready.lattice)).expect("a mesh");
    invariants::check_all(engine.mesh()).expect("invariants of the mesh");
    let whole = (&ready.domain, &ready.lattice);
    // Where something was refused the engine splits slivers. Asked of few.
    let no_points = || {
        let plain = refiner.min_dihedral(0.0).refine(&ready.domain, &ready.lattice);
        plain.expect("a mesh").stats.round_points == 0
    };
    for (workers, threads) in MATRIX {
        let name = format!("{name}, {workers} workers, {threads} threads");
        if workers == 0 {
            let refined = in_pool(threads, || refiner.refine(whole.0, whole.1));
            same(&name, &refined.expect("a mesh"), &engine);
            continue;
        }
        let run = in_pool(threads, || rounds_on_threads(refiner, whole, &Parallel::new(workers)));
        let run = run.expect("a run ends");
        same(&name, &run.refined, &engine);
        // At patches something may be refused in the first round.
        let is_done = run.ending.is_err() || run.ending == Ok(Ending::Irregular);
        assert!(is_done || run.figures.points > 0 || no_points(), "{name}");
    }
    redealt(name, refiner, ready, &engine);
    let mut ending = None;
    for (processors, latency) in [(2, 1_200), (16, 100_000), (64, 10_000)] {
        let run = simulated(refiner, ready, (processors, latency));
        same(&format!("{name} on {processors} processors"), &run.refined, &engine);
        let points = run.summary.map_or(0, |summary| summary.operations());
        assert_eq!(points, run.figures.points + run.figures.parted_points, "{name}");
        ending = Some(run.ending);
    }
    ending.expect("a run")
}

/// Does something where this number of threads shares the work.
fn in_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(work)
}

/// Refines by workers whose cuts move after every round, or every few: the engine's mesh. Cases
/// have one way of three each, by their names; with `LTBW_CASES` they have all.
fn redealt(name: &str, refiner: &Refiner<'_>, ready: &Prepared, engine: &Refined) {
    let turn = name.bytes().map(usize::from).sum::<usize>() % 3;
    let is_due = |way| way == turn || cases(0) > 0;
    let whole = (&ready.domain, &ready.lattice);
    let by_threads = [(3, 2, Ownership::Newest), (8, 1, Ownership::Block)];
    for (way, (workers, every, ownership)) in by_threads.into_iter().enumerate() {
        if !is_due(way) {
            continue;
        }
        let name = format!("{name}, {workers} threads, cuts move every {every} rounds");
        let layout = Layout { ownership, redeal: Redeal::Every(every), ..Layout::new(0, workers) };
        let parallel = Parallel::new(workers).layout(layout);
        let run = rounds_on_threads(refiner, whole, &parallel).expect("a run ends");
        same(&name, &run.refined, engine);
    }
    if !is_due(2) {
        return;
    }
    let plan = |points| {
        let ownership = Ownership::Creator;
        let layout = Layout { ownership, redeal: Redeal::Every(1), ..Layout::new(points, 5) };
        Plan { layout, config: Config::new(5) }
    };
    let options = Options { check_every: 20_000, ..options(1_200) };
    let run = simulate_rounds(refiner, whole.0, whole.1, &plan, &options).expect("a run ends");
    same(&format!("{name}, cuts move on processors"), &run.refined, engine);
}

#[test]
fn the_papers_problems_have_the_engines_mesh_on_any_number_of_workers() {
    let cases = [
        (DomainKind::CubeOctahedron, 1e-3),
        (DomainKind::CubeInCube, 1e-3),
        (DomainKind::Tee, 1e-3),
        (DomainKind::Gear, 4e-4),
    ];
    for (kind, volume) in cases {
        let ready = prepared(kind, &Shape::default());
        let refiner = Refiner::new().max_volume(volume).start(0);
        let ending = one_mesh(&format!("{kind:?}"), &refiner, &ready);
        assert_eq!(ending, Ok(Ending::Done), "{kind:?}");
    }
}

/// Cuts move as often as they are told to, and tetrahedra with them.
#[test]
fn cuts_move_between_rounds() {
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    let whole = (&ready.domain, &ready.lattice);
    let refiner = Refiner::new().max_volume(3e-4).start(64);
    let engine = refiner.refine(whole.0, whole.1).expect("a mesh");
    for workers in [1, 2, 3, 8] {
        for every in [1, 4] {
            let layout = Layout { redeal: Redeal::Every(every), ..Layout::new(0, workers) };
            let parallel = Parallel::new(workers).layout(layout);
            let run = rounds_on_threads(&refiner, whole, &parallel).expect("a run ends");
            same(&format!("{workers} workers, {every}"), &run.refined, &engine);
            let (figures, redeals) = (run.figures, run.figures.rounds[0] / every);
            assert_eq!(figures.redeals > 0 && figures.moved > 0, workers > 1, "{figures:?}");
            assert!(figures.redeals <= redeals, "{figures:?}");
            assert!(workers == 1 || 2 * figures.redeals > redeals, "{figures:?}");
        }
    }
}

#[test]
fn cavities_are_found_while_others_are_waited_for() {
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    let refiner = Refiner::new().max_volume(1e-4).start(1000);
    let share = |processors| {
        let figures = simulated(&refiner, &ready, (processors, 10_000)).figures;
        figures.ahead as f64 / figures.searches as f64
    };
    // One processor waits for nobody.
    assert_eq!(share(1), 0.0);
    assert!(share(8) > 0.1, "{}", share(8));
}

/// Two of these have a half and a quarter of the cube around them for their own: their ends are
/// where cells of a curve through that cube meet.
#[test]
fn no_worker_has_much_more_than_its_part() {
    for kind in [DomainKind::TwoMaterial, DomainKind::LBlock, DomainKind::CubeOctahedron] {
        let ready = prepared(kind, &Shape::default());
        let refiner = Refiner::new().max_volume(1e-4).start(1000);
        let summary = simulated(&refiner, &ready, (8, 1_000)).summary.expect("rounds");
        let all = summary.workers.iter();
        let sum: u64 = all.clone().map(|own| own.tets).sum();
        let most = all.map(|own| own.tets).max().unwrap_or(0);
        let share = (8 * most) as f64 / sum as f64;
        println!("{kind:?}: the most tetrahedra of a worker are {share:.2} times the mean");
        assert!(share < 1.25, "{kind:?}: {share}");
    }
}

#[test]
fn all_kinds_of_domains_have_the_engines_mesh() {
    let mut workers = 0;
    for kind in DomainKind::ALL {
        let ready = prepared(kind, &Shape::default());
        let refiner = Refiner::new().max_volume(3e-3).start(64);
        workers += usize::from(one_mesh(&format!("{kind:?}"), &refiner, &ready).is_ok());
    }
    println!("{workers} of {} kinds by workers", DomainKind::ALL.len());
    assert!(workers == DomainKind::ALL.len(), "{workers}");
    for angle in [5.0, 30.0] {
        let ready = prepared(DomainKind::Wedge, &Shape { angle: Some(angle), ..Shape::default() });
        let refiner = Refiner::new().max_volume(1e-4).start(64);
        let ending = one_mesh(&format!("wedge {angle}"), &refiner, &ready);
        assert!(ending.is_ok(), "wedge {angle}: {ending:?}");
    }
    let mut two = prepared(DomainKind::TwoMaterial, &Shape::default());
    two.domain.regions[0].max_volume = Some(1e-3);
    two.domain.regions[1].max_volume = Some(2e-3);
    assert_eq!(one_mesh("two materials", &Refiner::new().start(64), &two), Ok(Ending::Done));
    let field = |p: Point| 0.05 + 0.2 * p[0];
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    let refiner = Refiner::new().sizing(&field).start(0);
    assert_eq!(one_mesh("a field", &refiner, &ready), Ok(Ending::Done));
}

#[test]
fn bursts_slow_and_many_processors_change_nothing() {
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    let refiner = Refiner::new().max_volume(1e-3).start(200);
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let bursts =
        Network { bursts: Some(Bursts { every: 400_000, length: 100_000 }), ..Network::default() };
    let cases = [
        (8, Ownership::Block, options(50_000)),
        (8, Ownership::Newest, options(5_000)),
        (4, Ownership::Creator, Options { network: bursts, ..options(0) }),
        (5, Ownership::Newest, Options { slow: vec![(WorkerId::new(1), 30.0)], ..options(1_000) }),
        // More workers than tetrahedra at the start of some.
        (300, Ownership::Block, options(10_000)),
        // A second.
        (3, Ownership::Block, options(1_000_000_000)),
    ];
    for (processors, ownership, options) in cases {
        let plan = |points| {
            let layout = Layout { ownership, ..Layout::new(points, processors) };
            Plan { layout, config: Config::new(processors) }
        };
        let run = simulate_rounds(&refiner, &ready.domain, &ready.lattice, &plan, &options);
        let run = run.unwrap_or_else(|e| panic!("{processors} {ownership:?}: {e}"));
        same(&format!("{processors} {ownership:?}"), &run.refined, &engine);
    }
}

/// A budget ends the rounds before one that would exceed it: the partial mesh is one, too.
#[test]
fn a_budget_leaves_the_engines_partial_mesh() {
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    for most in [150, 400, 401, 700] {
        let refiner = Refiner::new().max_volume(5e-4).max_points(most).start(100);
        let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        let run = simulated(&refiner, &ready, (5, 2_000));
        same(&format!("{most} points"), &run.refined, &engine);
    }
}

/// The round that a budget ends at is chosen once more by the engine, which has to know no more of
/// it than if it had chosen it first: so each that splits boundary items beside tetrahedra is the
/// last one in turn.
#[test]
fn a_round_that_is_handed_over_is_chosen_as_if_nobody_had() {
    let mut count = 0;
    for (kind, volume) in [(DomainKind::LBlock, 1e-3), (DomainKind::CubeOctahedron, 3e-4)] {
        let ready = prepared(kind, &Shape::default());
        let whole = (&ready.domain, &ready.lattice);
        let refiner = Refiner::new().max_volume(volume).start(0);
        let engine = refiner.refine(whole.0, whole.1).expect("a mesh");
        let all =
            engine.stats.segment_points + engine.stats.facet_points + engine.stats.free_points;
        let mut points = all - engine.rounds.iter().map(|round| round.points as u64).sum::<u64>();
        for (k, round) in engine.rounds.iter().enumerate() {
            points += round.points as u64;
            if round.class != "all" {
                continue;
            }
            // One too few for this round.
            let refiner = refiner.max_points(points - 1);
            let engine = refiner.refine(whole.0, whole.1).expect("a mesh");
            assert_eq!(engine.outcome, RefineOutcome::Budget, "{kind:?}, round {k}");
            for workers in [1, 3] {
                let run = rounds_on_threads(&refiner, whole, &Parallel::new(workers));
                let run = run.expect("a run ends");
                assert_eq!(run.ending, Ok(Ending::Budget), "{kind:?}, round {k}");
                same(&format!("{kind:?}, round {k}, {workers} workers"), &run.refined, &engine);
            }
            count += 1;
        }
    }
    println!("{count} rounds");
    assert!(count > 10, "{count} rounds");
}

/// Where circles of items stay that cannot be split together, workers go on without them: one mesh,
/// and one list of excuses, for any number of threads and of workers. None of these would stay if
/// joint steps were not cut short here.
#[test]
fn circles_that_cannot_be_parted_leave_the_engines_mesh() {
    let cases: [([f64; 2], &[u32]); 4] = [
        ([3.0, 2.0], &[42, 6, 4]),
        ([1.0, 1.0], &[29, 1, 3]),
        ([2.0, 2.0], &[49; 7]),
        ([1.0, 1.0], &[52, 54, 19, 27, 38, 22, 30, 55]),
    ];
    let (mut circles, mut points) = (0, 0);
    for (base, layers) in cases {
        let thicknesses: Vec<f64> = layers.iter().map(|&t| f64::from(t) / 64.0).collect();
        let domain = stack(base, &thicknesses, false);
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let volume = base[0] * base[1] * thicknesses.iter().sum::<f64>();
        let whole = (&ready.domain, &ready.lattice);
        for (parts, start) in [(5000.0, None), (5000.0, Some(0)), (500.0, Some(0))] {
            let refiner = Refiner::new().max_volume(volume / parts).joint_most(1);
            let refiner = start.map_or(refiner, |start| refiner.start(start));
            let on_threads = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                pool.expect("threads").install(|| refiner.refine(whole.0, whole.1).expect("a mesh"))
            };
            let engine = on_threads(1);
            let name = format!("{base:?} {layers:?}, volume / {parts}, start {start:?}");
            for threads in [2, 5] {
                same(&format!("{name}: {threads} threads"), &on_threads(threads), &engine);
            }
            for workers in [1, 2, 3] {
                let run = rounds_on_threads(&refiner, whole, &Parallel::new(workers));
                let run = run.expect("a run ends");
                same(&format!("{name}: {workers} workers"), &run.refined, &engine);
                circles += usize::from(run.figures.parted > 0);
            }
            points += engine.stats.round_points;
        }
    }
    println!("{circles} runs of workers had circles, {points} points by rounds");
    assert!(circles > 20 && points > 1000, "{circles} {points}");
}

/// Cancelled at any time it is a sound mesh, and says so.
#[test]
fn cancelled_rounds_leave_a_sound_mesh() {
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    let whole = (&ready.domain, &ready.lattice);
    let mut cancelled = 0;
    for millis in [0, 1, 2, 4, 8, 16, 32, 64] {
        let token = CancelToken::default();
        let refiner = Refiner::new().max_volume(1e-4).start(100).cancel(&token);
        let run = std::thread::scope(|scope| {
            let token = &token;
            scope.spawn(move || {
                std::thread::sleep(Duration::from_millis(millis));
                token.cancel();
            });
            rounds_on_threads(&refiner, whole, &Parallel::new(3).cancel(token))
        });
        let run = match run {
            Ok(run) => run,
            Err(RefineError::Domain(_) | RefineError::Build(BuildError::Cancelled)) => continue,
            Err(error) => panic!("after {millis} ms: {error}"),
        };
        let mesh = run.refined.mesh();
        invariants::check_all(mesh).unwrap_or_else(|defect| panic!("{defect}"));
        if run.refined.outcome == RefineOutcome::Cancelled {
            cancelled += 1;
            let points: Vec<Point> = mesh.vertices().map(|(_, p)| p).collect();
            let set = PointSet::new(points).expect("finite");
            let anew = Builder::new().build(&set).expect("a mesh");
            assert_eq!(hash(mesh), hash(&anew.mesh), "after {millis} ms");
        }
    }
    assert!(cancelled > 0, "no run was cancelled half-way");
}
