//! Domains refined on several processors at once, without rounds: a Delaunay mesh that conforms to
//! the domain and keeps the bounds, whatever the timing.

use ltbw::domain::{Domain, Facet, PrepareOptions, Prepared};
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Closure, Config, Correct, Rule};
use ltbw::refine::{ComplexError, Refiner};
use ltbw::refining::{RefineError, SimulatedDomain, simulate_domain};
use ltbw::simulate::{Bursts, Distribution, Network, Options};
use ltbw::{Builder, Point, PointSet, invariants};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_verify::{Limits, Plc, PlcFacet, conforms};
use std::collections::HashSet;

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

/// The mesh conforms to the domain and keeps all bounds, by the independent checker; it is part of
/// the Delaunay mesh of its vertices; and nothing was given up.
fn check(name: &str, ready: &Prepared, volume: f64, run: &SimulatedDomain) {
    let own = &run.refined;
    assert_eq!((own.over, own.refused), (0, 0), "{name}: given up; {:?}", own.splits);
    let mesh = &own.gathered.mesh;
    invariants::check_all(mesh).unwrap_or_else(|defect| panic!("{name}: {defect}"));
    let tets: Vec<[u32; 4]> = own.tets.iter().map(|(v, _)| *v).collect();
    let tags: Vec<i64> = own.tets.iter().map(|(_, region)| i64::from(*region)).collect();
    let limits = Limits {
        radius_edge: Some(2.0),
        max_volume: Some(volume),
        region_volumes: ready
            .domain
            .regions
            .iter()
            .map(|r| r.max_volume.filter(|v| *v > 0.0))
            .collect(),
    };
    let view = ltbw_verify::Mesh::new(&own.points, &tets);
    let options = ltbw_verify::Options::default();
    let options = ltbw_verify::Options { numbered_regions: true, ..options };
    let found = conforms(&view, &plc_of(&ready.domain), Some(&tags), &limits, &options);
    assert_eq!(found.mesh_defect_count, 0, "{name}: {:?}", found.mesh_defects.first());
    assert!(found.counts.is_empty(), "{name}: {:?} {:?}", found.counts, found.findings.first());
    // All points of the Delaunay mesh, exterior included.
    let vertices: Vec<Point> = mesh.vertices().map(|(_, p)| p).collect();
    let anew =
        Builder::new().build(&PointSet::new(vertices).expect("finite points")).expect("mesh");
    assert_eq!(mesh.hash().ok(), anew.mesh.hash().ok(), "{name}: no Delaunay mesh");
    let inserted: u64 = own.splits.inserted.iter().sum();
    assert_eq!(own.started as u64 + inserted, mesh.num_vertices() as u64, "{name}");
    let distinct: HashSet<[u64; 3]> = own.points.iter().map(|p| p.map(f64::to_bits)).collect();
    assert_eq!(distinct.len(), own.points.len(), "{name}");
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
        let layout = |points| {
            let config = Config { window: 16, closure, ..Config::new(processors) };
            (Layout { ownership, ..Layout::new(points, processors) }, config)
        };
        let options = Options { network, seed, check_every: 5003, ..Options::default() };
        let refiner = Refiner::new().max_volume(volume);
        let domain = (&ready.domain, &ready.lattice);
        simulate_domain::<Correct>(&refiner, domain, start, layout, &options).expect("a run ends")
    }
}

const PROBLEMS: [(DomainKind, f64); 4] = [
    (DomainKind::CubeOctahedron, 1e-3),
    (DomainKind::CubeInCube, 1e-3),
    (DomainKind::Tee, 1e-3),
    (DomainKind::Gear, 4e-4),
];

#[test]
fn the_papers_problems_conform_on_any_number_of_processors() {
    for (kind, volume) in PROBLEMS {
        let ready = prepared(kind);
        for processors in [1, 4, 16, 64] {
            let run = Run { processors, ..Run::default() }.of(&ready, volume, 0);
            check(&format!("{kind:?} on {processors}"), &ready, volume, &run);
            let own = run.refined.splits;
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
        let regions: HashSet<u32> = run.refined.tets.iter().map(|(_, region)| *region).collect();
        let is_single = kind == DomainKind::LBlock;
        assert_eq!(regions.len() == 1, is_single, "{kind:?}: {regions:?}");
    }
}

/// Equal workers, options and seeds give one run; another seed gives another mesh.
#[test]
fn a_run_repeats_but_timing_matters() {
    let ready = prepared(DomainKind::CubeOctahedron);
    let network = Network { distribution: Distribution::Exponential, ..Network::default() };
    let hash = |seed| {
        let run = Run { network, seed, ..Run::default() }.of(&ready, 1e-3, 0);
        run.refined.gathered.mesh.hash().expect("a hash")
    };
    assert_eq!(hash(1), hash(1));
    assert_ne!(hash(1), hash(2));
}

#[test]
fn domains_that_only_rounds_can_refine_are_refused() {
    let ready = prepared(DomainKind::Spike);
    let layout = |points| (Layout::new(points, 4), Config::new(4));
    let domain = (&ready.domain, &ready.lattice);
    let run = |refiner: Refiner<'_>| {
        simulate_domain::<Correct>(&refiner, domain, 0, layout, &Options::default())
            .map(|run| run.refined.splits)
    };
    let of = |what| Err(RefineError::Complex(ComplexError::Unsupported(what)));
    let angles = of("features at small angles, or too near to each other");
    assert_eq!(run(Refiner::new()), angles);
    let rule = |points| (Layout::new(points, 4), Config { rule: Rule::Paper, ..Config::new(4) });
    let found = simulate_domain::<Correct>(&Refiner::new(), domain, 0, rule, &Options::default());
    assert_eq!(found.map(|run| run.refined.splits), Err(RefineError::Ageless));
}

#[test]
fn a_sizing_field_is_met() {
    let ready = prepared(DomainKind::CubeOctahedron);
    let field = |p: Point| 0.1 + 0.1 * p[0];
    let layout = |points| (Layout::new(points, 6), Config::new(6));
    let refiner = Refiner::new().sizing(&field);
    let domain = (&ready.domain, &ready.lattice);
    let run = simulate_domain::<Correct>(&refiner, domain, 0, layout, &Options::default());
    let refined = run.expect("a run ends").refined;
    assert_eq!((refined.over, refined.refused), (0, 0));
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let (tets, engine) = (refined.tets.len(), engine.num_tets());
    assert!(tets * 4 > engine * 3 && tets * 3 < engine * 4, "{tets} {engine}");
}

/// A run with too small a budget ends, and says what is over its bounds.
#[test]
fn a_budget_ends_a_run() {
    let ready = prepared(DomainKind::CubeOctahedron);
    let refiner = Refiner::new().max_volume(1e-4).max_points(200);
    let layout = |points| (Layout::new(points, 4), Config::new(4));
    let domain = (&ready.domain, &ready.lattice);
    let run = simulate_domain::<Correct>(&refiner, domain, 0, layout, &Options::default());
    let own = run.expect("a run ends").refined;
    assert!(own.over > 100, "{own:?}");
    invariants::check_all(&own.gathered.mesh).expect("a sound mesh");
}
