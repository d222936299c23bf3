//! Domains refined on several processors at once, without rounds: a Delaunay mesh that conforms to
//! the domain and keeps the bounds, whatever the timing.

use crate::refining_patches::surface;
use ltbw::balance::Balance;
use ltbw::domain::{Domain, Facet, PrepareOptions, Prepared};
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Closure, Config, Rule, WorkerId};
use ltbw::refine::{RefineOutcome, Refined, Refiner};
use ltbw::refining::{Plan, SimulatedDomain, domain_on_threads, simulate_domain};
use ltbw::simulate::{Bursts, Distribution, Network, Options, RandomMigrations};
use ltbw::threads::Parallel;
use ltbw::{Builder, CancelToken, Point, PointSet, invariants};
use ltbw_generate::surfaces::{single, torus, turned};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_verify::{Limits, Plc, PlcFacet, conforms};
use std::collections::HashSet;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

fn prepared(kind: DomainKind) -> Prepared {
    let domain = generate_domain(kind, &Shape::default()).expect("a shape");
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

fn plc_of(domain: &Domain) -> Plc {
    let facet = |f: &Facet| PlcFacet {
        polygons: f.polygons.clone(),
        holes: f.holes.clone(),
        marker: f.marker,
    };
    Plc {
        vertices: domain.vertices.clone(),
        facets: domain.facets.iter().map(facet).collect(),
        segments: domain.segments.iter().map(|(ends, _)| *ends).collect(),
        holes: domain.holes.clone(),
        regions: domain.regions.iter().map(|r| r.seed).collect(),
        flat_tolerance: 0.0,
    }
}

/// The mesh conforms to the domain, by the independent checker, and no more tetrahedra are over a
/// bound than are excused.
fn check_sound(name: &str, ready: &Prepared, refined: &Refined) {
    use RefineOutcome::{Excused, Met};
    assert!(matches!(refined.outcome, Met | Excused), "{name}: {:?}", refined.outcome);
    invariants::check_all(refined.mesh()).unwrap_or_else(|defect| panic!("{name}: {defect}"));
    let inside = refined.inside();
    let view = ltbw_verify::Mesh::new(&inside.points, &inside.tets);
    let options = ltbw_verify::Options { numbered_regions: true, ..Default::default() };
    let plc = Plc { flat_tolerance: refined.stats.flat_tolerance, ..plc_of(&ready.domain) };
    let tags = inside.tet_tags.as_deref();
    let found = conforms(&view, &plc, tags, &Limits::default(), &options);
    assert_eq!(found.mesh_defect_count, 0, "{name}: {:?}", found.mesh_defects.first());
}

/// The mesh conforms to the domain and keeps all bounds, by the independent checker, and is the
/// Delaunay mesh of its vertices.
fn check_mesh(name: &str, ready: &Prepared, volume: f64, refined: &Refined) {
    assert_eq!(refined.outcome, RefineOutcome::Met, "{name}");
    let mesh = refined.mesh();
    invariants::check_all(mesh).unwrap_or_else(|defect| panic!("{name}: {defect}"));
    let inside = refined.inside();
    let limits = Limits {
        radius_edge: Some(2.0),
        max_volume: Some(volume),
        region_volumes: ready
            .domain
            .regions
            .iter()
            .map(|r| r.max_volume.filter(|v| *v > 0.0))
            .collect(),
        ..Limits::default()
    };
    let view = ltbw_verify::Mesh::new(&inside.points, &inside.tets);
    let options = ltbw_verify::Options::default();
    let options = ltbw_verify::Options { numbered_regions: true, ..options };
    let plc = plc_of(&ready.domain);
    let found = conforms(&view, &plc, inside.tet_tags.as_deref(), &limits, &options);
    assert_eq!(found.mesh_defect_count, 0, "{name}: {:?}", found.mesh_defects.first());
    assert!(found.counts.is_empty(), "{name}: {:?} {:?}", found.counts, found.findings.first());
    // All points of the Delaunay mesh, exterior included.
    let vertices: Vec<Point> = mesh.vertices().map(|(_, p)| p).collect();
    let distinct: HashSet<[u64; 3]> = vertices.iter().map(|p| p.map(f64::to_bits)).collect();
    assert_eq!(distinct.len(), vertices.len(), "{name}");
    let anew =
        Builder::new().build(&PointSet::new(vertices).expect("finite points")).expect("mesh");
    assert_eq!(mesh.hash().ok(), anew.mesh.hash().ok(), "{name}: no Delaunay mesh");
}

/// As [`check_mesh`]; and nothing was given up, so that one processor has split slivers alone.
fn check(name: &str, ready: &Prepared, volume: f64, run: &SimulatedDomain) {
    let splits = run.splits;
    assert_eq!(splits.refused, [0, 0], "{name}: given up; {splits:?}");
    check_mesh(name, ready, volume, &run.refined);
    let inserted = run.started as u64 + splits.inserted.iter().sum::<u64>();
    // Slivers, and what relieves small angles.
    let late = run.refined.mesh().num_vertices() as u64 - inserted;
    assert!(late >= run.refined.stats.round_points && late * 10 < inserted, "{name}: {late}");
}

struct Run {
    processors: u32,
    ownership: Ownership,
    network: Network,
    closure: Closure,
    seed: u64,
}

impl Default for Run {
    fn default() -> Self {
        let network = Network { latency: 100_000, ..Network::default() };
        let (ownership, closure) = (Ownership::Newest, Closure::default());
        Self { processors: 4, ownership, network, closure, seed: 1 }
    }
}

impl Run {
    fn of(&self, ready: &Prepared, volume: f64, start: usize) -> SimulatedDomain {
        let Self { processors, ownership, network, closure, seed } = *self;
        let plan = |points| {
            let config = Config { window: 16, closure, ..Config::new(processors) };
            let layout = Layout { ownership, ..Layout::new(points, processors) };
            Plan { layout, config }
        };
        let options = Options { network, seed, check_every: 5003, ..Options::default() };
        let refiner = Refiner::new().max_volume(volume).start(start);
        simulate_domain(&refiner, &ready.domain, &ready.lattice, &plan, &options)
            .expect("a run ends")
    }
}

/// Problems with a largest volume and the vertices at the start: before, items at the bore of the
/// gear take each other out, which processors leave to the engine.
const PROBLEMS: [(DomainKind, f64, usize); 4] = [
    (DomainKind::CubeOctahedron, 1e-3, 0),
    (DomainKind::CubeInCube, 1e-3, 0),
    (DomainKind::Tee, 1e-3, 0),
    (DomainKind::Gear, 2e-4, 1024),
];

#[test]
fn the_papers_problems_conform_on_any_number_of_processors() {
    for (kind, volume, start) in PROBLEMS {
        let ready = prepared(kind);
        for processors in [1, 4, 16, 64] {
            let run = Run { processors, ..Run::default() }.of(&ready, volume, start);
            check(&format!("{kind:?} on {processors}"), &ready, volume, &run);
            let own = run.splits;
            assert!(own.inserted.iter().all(|&points| points > 50), "{kind:?}: {own:?}");
            assert!(own.deferred > 100, "{kind:?}: {own:?}");
            let remote = run.summary.cavities.interface_all();
            assert_eq!(processors > 1, remote > 100, "{kind:?} on {processors}: {remote}");
        }
    }
}

/// Latencies from nothing to a second, with spread and stalls; every ownership and closure.
#[test]
fn no_timing_loses_anything_of_the_boundary() {
    let (ready, volume) = (prepared(DomainKind::CubeInCube), 5e-4);
    let steady = |latency| Network { latency, ..Network::default() };
    let spread = Network { distribution: Distribution::Exponential, ..steady(50_000) };
    let stalls = Network { bursts: Some(Bursts { every: 900_000, length: 400_000 }), ..spread };
    for (k, network) in [steady(0), steady(1_000_000_000), spread, stalls].into_iter().enumerate() {
        for seed in 0..4 {
            let run = Run {
                network,
                seed,
                processors: [3, 8, 24, 5][seed as usize],
                ownership: Ownership::ALL[(k + seed as usize) % 3],
                closure: Closure::ALL[(k + seed as usize / 2) % 2],
            };
            let done = run.of(&ready, volume, 0);
            check(&format!("network {k}, seed {seed}"), &ready, volume, &done);
        }
    }
}

#[test]
fn regions_keep_their_own_bounds() {
    let shape = Shape::default();
    for kind in [DomainKind::TwoMaterial, DomainKind::Voxels, DomainKind::LBlock] {
        let mut domain = generate_domain(kind, &Shape { count: None, ..shape }).expect("a shape");
        let volume = match kind {
            DomainKind::TwoMaterial => 2e-3,
            _ => 5e-2,
        };
        for (k, region) in domain.regions.iter_mut().enumerate() {
            region.max_volume = Some(volume / (2.0 + k as f64));
        }
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let run = Run { processors: 6, ..Run::default() }.of(&ready, volume, 0);
        check(kind.name(), &ready, volume, &run);
        let tags = run.refined.inside().tet_tags.expect("regions");
        let regions: HashSet<i64> = tags.into_iter().collect();
        let is_single = kind == DomainKind::LBlock;
        assert_eq!(regions.len() == 1, is_single, "{kind:?}: {regions:?}");
    }
}

/// Blocks that move, in a storm or to workers that have little left, take the boundary and regions
/// along.
#[test]
fn blocks_move_with_their_boundary() {
    let mut moved = 0;
    for (kind, volume) in [(DomainKind::CubeInCube, 1e-3), (DomainKind::TwoMaterial, 2e-3)] {
        let ready = prepared(kind);
        for seed in 0..6 {
            let plan = |points| {
                let config = Config { window: 16, ..Config::new(5) };
                let layout = Layout { blocks_per_worker: 6, ..Layout::new(points, 5) };
                Plan { layout, config }
            };
            let network = Network { latency: 20_000 << (2 * (seed % 3)), ..Network::default() };
            let storm = (seed % 2 == 0).then_some(RandomMigrations { every: 300_000 });
            let balance = (seed % 2 == 1).then(Balance::default);
            // One is slow, so that others ask for its blocks.
            let slow = vec![(WorkerId::new(0), 8.0)];
            let options = Options {
                network,
                seed,
                check_every: 503,
                storm,
                balance,
                slow,
                ..Options::default()
            };
            let refiner = Refiner::new().max_volume(volume).start(0);
            let run = simulate_domain(&refiner, &ready.domain, &ready.lattice, &plan, &options);
            let run = run.expect("a run ends");
            check(&format!("{kind:?}, seed {seed}"), &ready, volume, &run);
            moved += run.summary.workers.iter().map(|own| own.migrations).sum::<u64>();
        }
    }
    assert!(moved > 100, "{moved} moves");
}

/// The paper's rule for locks, under which operations have no age, and start again after a time.
#[test]
fn the_papers_rule_refines_domains_too() {
    for (k, (kind, volume, start)) in PROBLEMS.into_iter().enumerate() {
        let ready = prepared(kind);
        for processors in [2, 8, 24] {
            for latency in [1_000, 100_000] {
                let plan = |points| {
                    let config =
                        Config { rule: Rule::Paper, window: 16, ..Config::new(processors) };
                    let ownership = Ownership::ALL[k % 3];
                    let layout = Layout { ownership, ..Layout::new(points, processors) };
                    Plan { layout, config }
                };
                let network = Network { latency, ..Network::default() };
                let options = Options { network, max_events: 20_000_000, ..Options::default() };
                let refiner = Refiner::new().max_volume(volume).start(start);
                let run = simulate_domain(&refiner, &ready.domain, &ready.lattice, &plan, &options);
                let run = run.expect("a run ends");
                let name = format!("{kind:?} on {processors}, {latency} ns");
                check_mesh(&name, &ready, volume, &run.refined);
                // An item may ask in vain for locks that others take again and again.
                let [items, tets] = run.splits.refused;
                let inserted: u64 = run.splits.inserted.iter().sum();
                assert!((items + tets) * 20 < inserted, "{name}: {:?}", run.splits);
            }
        }
    }
}

/// Equal workers, options and seeds give one run; another seed gives another mesh.
#[test]
fn a_run_repeats_but_timing_matters() {
    let ready = prepared(DomainKind::CubeOctahedron);
    let network = Network { distribution: Distribution::Exponential, ..Network::default() };
    let hash = |seed| {
        let run = Run { network, seed, ..Run::default() }.of(&ready, 1e-3, 0);
        run.refined.mesh().hash().expect("a hash")
    };
    assert_eq!(hash(1), hash(1));
    assert_ne!(hash(1), hash(2));
}

/// Small angles, and facets that are coplanar within a tolerance: what is there is left to the
/// engine, all else is the processors'.
#[test]
fn what_is_at_small_angles_and_patches_is_left_to_the_engine() {
    let angle = |kind, degrees| {
        let shape = Shape { angle: Some(degrees), ..Shape::default() };
        surface(&generate_domain(kind, &shape).expect("a shape")).0
    };
    let (torus, tolerance) = surface(&turned(&single(torus(10))));
    let plan = |points| Plan {
        layout: Layout::new(points, 4),
        config: Config { window: 16, ..Config::new(4) },
    };
    for (name, ready, tolerance, volume, start) in [
        ("spike", angle(DomainKind::Spike, 5.0), 0.0, 2e-4, 64),
        ("wedge", angle(DomainKind::Wedge, 10.0), 0.0, 1e-5, 1024),
        ("torus", torus, tolerance, 3e-5, 1024),
    ] {
        let refiner = Refiner::new().flat_tolerance(tolerance).max_volume(volume).start(start);
        let run =
            simulate_domain(&refiner, &ready.domain, &ready.lattice, &plan, &Options::default());
        let run = run.unwrap_or_else(|error| panic!("{name}: {error}"));
        let splits = run.splits;
        let inserted: u64 = splits.inserted.iter().sum();
        let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        let (tets, whole) = (run.refined.num_tets(), engine.num_tets());
        println!(
            "{name}: {tets} for {whole}, {splits:?}, {} in rounds",
            run.refined.stats.round_points
        );
        assert!(splits.refused.iter().sum::<u64>() > 0 && inserted > 50, "{name}: {splits:?}");
        assert!(tets * 10 > whole * 9 && tets * 10 < whole * 11, "{name}: {tets} {whole}");
        check_sound(name, &ready, &run.refined);
        let excused = [&run.refined, &engine].map(|own| own.excuses.len());
        assert!(excused[0] <= excused[1] + excused[1] / 2 + 8, "{name}: {excused:?}");
    }
}

#[test]
fn a_sizing_field_is_met() {
    let ready = prepared(DomainKind::CubeOctahedron);
    let field = |p: Point| 0.1 + 0.1 * p[0];
    let plan = |points| Plan { layout: Layout::new(points, 6), config: Config::new(6) };
    let refiner = Refiner::new().sizing(&field).start(0);
    let run = simulate_domain(&refiner, &ready.domain, &ready.lattice, &plan, &Options::default());
    let run = run.expect("a run ends");
    assert_eq!((run.splits.refused, run.refined.outcome), ([0, 0], RefineOutcome::Met));
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let (tets, engine) = (run.refined.num_tets(), engine.num_tets());
    assert!(tets * 4 > engine * 3 && tets * 3 < engine * 4, "{tets} {engine}");
}

/// A run with too small a budget ends: no worker exceeds its share.
#[test]
fn a_budget_ends_a_run() {
    let ready = prepared(DomainKind::CubeOctahedron);
    let corners = ready.domain.vertices.len();
    let refiner = Refiner::new().max_volume(1e-4).max_points(200).start(0);
    let plan = |points| Plan { layout: Layout::new(points, 4), config: Config::new(4) };
    let run = simulate_domain(&refiner, &ready.domain, &ready.lattice, &plan, &Options::default());
    let run = run.expect("a run ends");
    assert!(run.splits.refused[1] > 50, "{:?}", run.splits);
    assert_eq!(run.refined.outcome, RefineOutcome::Budget);
    assert!(run.refined.mesh().num_vertices() <= 200 + corners, "{:?}", run.splits);
    invariants::check_all(run.refined.mesh()).expect("a sound mesh");
}

/// Threads in the place of simulated processors: nothing depends on who they are.
#[test]
fn threads_refine_domains_without_rounds() {
    for (kind, volume, start) in PROBLEMS {
        let ready = prepared(kind);
        for workers in [1, 2, 5] {
            let name = format!("{kind:?} by {workers}");
            let refiner = Refiner::new().max_volume(volume).start(start);
            let run =
                domain_on_threads(&refiner, &ready.domain, &ready.lattice, &Parallel::new(workers));
            let run = run.unwrap_or_else(|error| panic!("{name}: {error}"));
            check_mesh(&name, &ready, volume, &run.refined);
            let splits = run.splits.expect("a plain domain");
            assert_eq!(splits.refused, [0, 0], "{name}: given up; {splits:?}");
            assert_eq!(run.workers.len(), workers as usize, "{name}");
            let counted: u64 = run.workers.iter().map(|own| own.local + own.operations).sum();
            assert!(counted >= splits.inserted.iter().sum(), "{name}: {splits:?}");
            let owners: HashSet<u32> = run.owners.of(&run.refined, true).into_iter().collect();
            assert_eq!(owners.len(), workers as usize, "{name}");
        }
    }
}

/// Every rule, closure and ownership on threads, with messages that take their time; blocks move.
#[test]
fn threads_take_every_setting_of_the_protocol() {
    let (ready, volume) = (prepared(DomainKind::TwoMaterial), 1e-3);
    let parallel = || Parallel::new(3);
    for (name, parallel) in [
        ("paper's rule", parallel().rule(Rule::Paper)),
        ("vertex closure", parallel().closure(Closure::Vertex)),
        ("latency", parallel().latency(Duration::from_micros(50))),
        ("balance", parallel().balance(Balance::default())),
    ] {
        let refiner = Refiner::new().max_volume(volume).start(0);
        let run = domain_on_threads(&refiner, &ready.domain, &ready.lattice, &parallel);
        let run = run.unwrap_or_else(|error| panic!("{name}: {error}"));
        check_mesh(name, &ready, volume, &run.refined);
        let inserted: u64 = run.splits.expect("a plain domain").inserted.iter().sum();
        assert!(inserted > 300, "{name}: {inserted}");
    }
}

/// On threads as on simulated processors.
#[test]
fn threads_leave_what_is_at_small_angles_to_the_engine() {
    let ready = prepared(DomainKind::Spike);
    let refiner = Refiner::new().max_volume(2e-5).start(0);
    let run = domain_on_threads(&refiner, &ready.domain, &ready.lattice, &Parallel::new(3))
        .expect("a mesh");
    let splits = run.splits.expect("workers have split some");
    assert!(splits.inserted[2] > 100 && run.workers.len() == 3, "{splits:?}");
    check_sound("spike", &ready, &run.refined);
}

/// A run that is cancelled at any time ends: nobody waits for one that splits nothing any more.
#[test]
fn a_run_that_is_cancelled_at_any_time_ends() {
    let (ready, volume) = (prepared(DomainKind::CubeOctahedron), 1e-3);
    let (domain, lattice) = (&ready.domain, &ready.lattice);
    for rule in Rule::ALL {
        let plan = |points| {
            let config = Config { rule, window: 16, ..Config::new(8) };
            Plan { layout: Layout::new(points, 8), config }
        };
        let refiner = Refiner::new().max_volume(volume).start(0);
        let network = Network { latency: 100_000, ..Network::default() };
        let options =
            |cancel| Options { network, cancel, max_events: 5_000_000, ..Options::default() };
        let whole = simulate_domain(&refiner, domain, lattice, &plan, &options(None));
        let makespan = whole.expect("a run ends").summary.makespan;
        for part in (1..40).step_by(4) {
            let options = options(Some(makespan * part / 40));
            let run = simulate_domain(&refiner, domain, lattice, &plan, &options);
            let run = run.unwrap_or_else(|error| panic!("{rule}, {part} of 40: {error}"));
            // The engine goes on where the processors have stopped.
            assert_eq!(run.refined.outcome, RefineOutcome::Met, "{rule}, {part} of 40");
        }
    }
}

/// A run that is cancelled has a sound mesh.
#[test]
fn a_run_that_is_cancelled_has_a_sound_mesh() {
    let ready = prepared(DomainKind::CubeOctahedron);
    for asked in [6_000, 20_000, 40_000] {
        let token = CancelToken::new();
        let refiner = Refiner::new().max_volume(1e-4).start(0).cancel(&token);
        let parallel = Parallel::new(3).cancel(&token);
        let field = AtomicU32::new(0);
        // Cancelled as the workers look at their tetrahedra.
        let sizes = |_: Point| {
            if field.fetch_add(1, Ordering::Relaxed) == asked {
                token.cancel();
            }
            0.03
        };
        let refiner = refiner.sizing(&sizes);
        let run = domain_on_threads(&refiner, &ready.domain, &ready.lattice, &parallel);
        let run = run.expect("a mesh");
        assert_eq!(run.refined.outcome, RefineOutcome::Cancelled, "{asked}");
        invariants::check_all(run.refined.mesh()).expect("a sound mesh");
    }
}
