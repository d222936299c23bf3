//! The rounds of domains inserted by the protocol, on threads and on simulated processors: the mesh
//! is that of the engine, whatever the number of workers and the timing.

use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Config, Correct, WorkerId};
use ltbw::refine::{Refined, Refiner, Script};
use ltbw::refining::{RefineError, rounds_on_threads, simulate_rounds};
use ltbw::simulate::{Bursts, Network, Options, RandomMigrations};
use ltbw::threads::Parallel;
use ltbw::{
    BuildError, Builder, CancelToken, Mesh, MeshHash, Outcome, Point, PointSet, invariants,
};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::time::Duration;

fn prepared(kind: DomainKind, shape: &Shape) -> Prepared {
    let domain = generate_domain(kind, shape).expect("a shape");
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

/// The mesh of the engine, and what its rounds insert.
fn script(refiner: &Refiner<'_>, ready: &Prepared, start: usize) -> (Refined, Script) {
    let refiner = refiner.start(start);
    let (refined, script) =
        refiner.refine_with_script(&ready.domain, &ready.lattice).expect("a mesh");
    let points: usize = script.rounds.iter().map(Vec::len).sum();
    let stats = refined.stats;
    assert!(points as u64 >= stats.round_points && points > 100, "{points} points, {stats:?}");
    assert_eq!(script.start.len() + points, refined.mesh().num_vertices());
    (refined, script)
}

fn hash(mesh: &Mesh) -> MeshHash {
    mesh.hash().expect("a hash")
}

/// Processors with messages of `latency` nanoseconds.
fn options(latency: u64) -> Options {
    let network = Network { latency, ..Network::default() };
    Options { network, max_events: 100_000_000, ..Options::default() }
}

/// Inserts a script in every way: one mesh.
fn one_mesh(name: &str, refined: &Refined, script: &Script) {
    let expected = hash(refined.mesh());
    for threads in [1, 2, 3, 4, 8] {
        let run = rounds_on_threads(script, &Parallel::new(threads)).expect("a run ends");
        assert_eq!(hash(&run.gathered.mesh), expected, "{name} on {threads} threads");
        let inserted: u64 = run.workers.iter().map(|w| w.local + w.operations).sum();
        let points: usize = script.rounds.iter().map(Vec::len).sum();
        assert_eq!(inserted, points as u64, "{name} on {threads} threads");
    }
    for (processors, latency) in [(2, 1_200), (16, 100_000), (64, 10_000)] {
        let layout =
            Layout { ownership: Ownership::Newest, ..Layout::new(script.start.len(), processors) };
        let mut options = options(latency);
        options.balance = None;
        options.check_every = 20_000;
        let config = Config::new(processors);
        let run =
            simulate_rounds::<Correct>(script, &layout, config, &options).expect("a run ends");
        assert_eq!(hash(&run.gathered.mesh), expected, "{name} on {processors} processors");
        assert_eq!(run.rounds.len(), script.rounds.len());
        let points = |k: usize| (run.rounds[k].operations(), script.rounds[k].len() as u64);
        assert!((0..run.rounds.len()).all(|k| points(k).0 == points(k).1), "{name}");
        let remote: u64 = run.rounds.iter().map(|r| r.cavities.interface_all()).sum();
        assert!(remote > 0, "{name} on {processors} processors: nothing at an interface");
    }
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
        let (refined, script) = script(&Refiner::new().max_volume(volume), &ready, 0);
        one_mesh(&format!("{kind:?}"), &refined, &script);
        invariants::check_all(refined.mesh()).expect("invariants of the mesh");
    }
}

/// Cancelled at any time it is an error, if there is no mesh yet, or a Delaunay mesh of its own
/// vertices, and says so.
#[test]
fn cancelled_rounds_leave_a_sound_mesh() {
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    let (refined, script) = script(&Refiner::new().max_volume(1e-4), &ready, 100);
    let mut cancelled = 0;
    for millis in [0, 1, 2, 4, 8, 16, 32, 64] {
        let token = CancelToken::default();
        let run = std::thread::scope(|scope| {
            let token = &token;
            scope.spawn(move || {
                std::thread::sleep(Duration::from_millis(millis));
                token.cancel();
            });
            rounds_on_threads(&script, &Parallel::new(3).cancel(token))
        });
        let run = match run {
            Ok(run) => run,
            Err(RefineError::Build(BuildError::Cancelled)) => continue,
            Err(error) => panic!("after {millis} ms: {error}"),
        };
        let mesh = &run.gathered.mesh;
        if run.outcome == Outcome::Complete {
            assert_eq!(hash(mesh), hash(refined.mesh()));
            continue;
        }
        cancelled += 1;
        assert!(mesh.num_vertices() < refined.mesh().num_vertices(), "after {millis} ms");
        invariants::check_all(mesh).unwrap_or_else(|defect| panic!("{defect}"));
        let points: Vec<Point> = mesh.vertices().map(|(_, p)| p).collect();
        let anew = Builder::new().build(&PointSet::new(points).expect("finite")).expect("a mesh");
        assert_eq!(hash(mesh), hash(&anew.mesh), "after {millis} ms");
    }
    assert!(cancelled > 0, "no run was cancelled half-way");
}

#[test]
fn wedges_regions_and_fields_have_the_engines_mesh() {
    for (angle, volume) in [(30.0, 1e-4), (5.0, 2e-5)] {
        let ready = prepared(DomainKind::Wedge, &Shape { angle: Some(angle), ..Shape::default() });
        let (refined, script) = script(&Refiner::new().max_volume(volume), &ready, 0);
        one_mesh(&format!("wedge {angle}"), &refined, &script);
    }
    let mut two = prepared(DomainKind::TwoMaterial, &Shape::default());
    two.domain.regions[0].max_volume = Some(1e-3);
    two.domain.regions[1].max_volume = Some(2e-3);
    let (refined, found) = script(&Refiner::new(), &two, 64);
    one_mesh("two materials", &refined, &found);
    let field = |p: Point| 0.05 + 0.2 * p[0];
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    let (refined, found) = script(&Refiner::new().sizing(&field), &ready, 0);
    one_mesh("a field", &refined, &found);
}

#[test]
fn moves_bursts_slow_and_many_processors_change_nothing() {
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    let (refined, script) = script(&Refiner::new().max_volume(1e-3), &ready, 200);
    let storm = Some(RandomMigrations { every: 30_000 });
    let bursts =
        Network { bursts: Some(Bursts { every: 400_000, length: 100_000 }), ..Network::default() };
    let cases = [
        (8, Ownership::Block, Options { storm, ..options(5_000) }),
        (8, Ownership::Block, options(50_000)),
        (4, Ownership::Creator, Options { balance: None, network: bursts, ..options(0) }),
        (
            5,
            Ownership::Newest,
            Options { balance: None, slow: vec![(WorkerId::new(1), 30.0)], ..options(1_000) },
        ),
        // More workers than tetrahedra at the start of some.
        (300, Ownership::Newest, Options { balance: None, ..options(10_000) }),
    ];
    for (processors, ownership, options) in cases {
        let layout = Layout { ownership, ..Layout::new(script.start.len(), processors) };
        let config = Config::new(processors);
        let run = simulate_rounds::<Correct>(&script, &layout, config, &options);
        let run = run.unwrap_or_else(|e| panic!("{processors} {ownership:?}: {e}"));
        assert_eq!(hash(&run.gathered.mesh), hash(refined.mesh()), "{processors} {ownership:?}");
    }
}

/// A point that is left out changes the mesh, and one that begins at a tetrahedron that is nowhere
/// is an error: a script is not taken for granted.
#[test]
fn a_script_that_is_not_the_engines_is_found_out() {
    let ready = prepared(DomainKind::CubeInCube, &Shape::default());
    let (refined, script) = script(&Refiner::new().max_volume(1e-3), &ready, 0);
    let parallel = Parallel::new(2);
    let mut shorter = script.clone();
    let last = shorter.rounds.last_mut().and_then(Vec::pop);
    assert!(last.is_some());
    let run = rounds_on_threads(&shorter, &parallel).expect("a run ends");
    assert_ne!(hash(&run.gathered.mesh), hash(refined.mesh()));
    let mut without = script.clone();
    without.rounds.remove(0);
    let cut = rounds_on_threads(&without, &parallel);
    assert!(matches!(cut, Err(RefineError::Script)), "{cut:?}");
}
