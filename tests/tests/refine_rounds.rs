//! Refinement in rounds: one mesh whatever the order of insertion, judged by the independent
//! checker and against the engine with queues.
//!
//! Random domains: 50 by default, `LTBW_CASES` for more (500 for the full bar).

use ltbw::domain::{Domain, Facet, PrepareOptions, Prepared};
use ltbw::refine::{Engine, InsertOrder, RefineOutcome, Refined, Refiner};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_tests::cases;
use ltbw_tests::domains::random_domain;
use ltbw_verify::{Breach, Limits, Mesh, Options, Plc, PlcFacet, conforms};

/// The orders that every domain is refined in.
const ORDERS: [InsertOrder; 5] = [
    InsertOrder::Hilbert,
    InsertOrder::Forwards,
    InsertOrder::Backwards,
    InsertOrder::Random(1),
    InsertOrder::Random(2),
];

fn prepared(domain: &Domain) -> Prepared {
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

fn plc_of(domain: &Domain) -> Plc {
    let facet = |f: &Facet| PlcFacet {
        polygons: f.polygons.clone(),
        holes: f.holes.clone(),
        marker: f.marker,
    };
    Plc {
        flat_tolerance: 0.0,
        vertices: domain.vertices.clone(),
        facets: domain.facets.iter().map(facet).collect(),
        segments: domain.segments.iter().map(|(ends, _)| *ends).collect(),
        holes: domain.holes.clone(),
        regions: domain.regions.iter().map(|r| r.seed).collect(),
    }
}

/// Refines in all orders, from `start` vertices on: one hash, as many excuses. Judges the mesh.
fn one_mesh(ready: &Prepared, refiner: &Refiner<'_>, start: usize, name: &str) -> Refined {
    let run = |order| {
        let refiner = refiner.engine(Engine::Rounds { order, start });
        refiner.refine(&ready.domain, &ready.lattice).unwrap_or_else(|e| panic!("{name}: {e}"))
    };
    let first = run(ORDERS[0]);
    let hash = first.mesh().hash().expect("a hash");
    for order in &ORDERS[1..] {
        let other = run(*order);
        assert_eq!(other.mesh().hash().expect("a hash"), hash, "{name} {order:?}");
        assert_eq!(other.excuses.len(), first.excuses.len(), "{name} {order:?}");
    }
    let mesh = first.to_tet_mesh(false);
    let limits = Limits { radius_edge: Some(2.0), ..Limits::default() };
    let view = Mesh::new(&mesh.points, &mesh.tets);
    let plc = plc_of(&ready.domain);
    let found = conforms(&view, &plc, mesh.tet_tags.as_deref(), &limits, &Options::default());
    assert!(first.lost.is_empty(), "{name}: {:?}", first.lost.first());
    assert_eq!(found.mesh_defect_count, 0, "{name}: {:?}", found.mesh_defects.first());
    let bounds = |b: &Breach| matches!(b, Breach::RatioExceeded);
    assert!(found.counts.keys().all(bounds), "{name}: {:?}", found.findings.first());
    first
}

#[test]
fn random_domains_have_one_mesh_for_all_orders() {
    let count = cases(50);
    let (mut excused, mut excused_by_queues, mut points) = (0, 0, 0);
    for seed in 0..count as u64 {
        let (name, domain) = random_domain(seed);
        let (name, ready) = (format!("{name} {seed}"), prepared(&domain));
        // One in two has a bound on volumes, or few would need any point.
        let (low, high) = ready.domain.bounds().expect("vertices");
        let volume = (0..3).map(|k| high[k] - low[k]).product::<f64>() / 2000.0;
        let refiner = Refiner::new();
        let refiner = if seed % 2 == 0 { refiner.max_volume(volume) } else { refiner };
        let rounds = one_mesh(&ready, &refiner, 0, &name);
        let queues = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        if queues.outcome == RefineOutcome::Met {
            assert_eq!(rounds.outcome, RefineOutcome::Met, "{name}");
        }
        excused += rounds.excuses.len();
        excused_by_queues += queues.excuses.len();
        points += rounds.stats.round_points;
    }
    println!("{count} domains, {points} points by rounds; excused: {excused} tetrahedra");
    println!("excused by queues: {excused_by_queues}");
    assert!(points > 10 * count as u64);
    assert!(excused <= excused_by_queues, "{excused} {excused_by_queues}");
}

#[test]
fn the_problems_of_the_paper_need_no_more_tetrahedra_than_tetgen() {
    let bars = [
        (DomainKind::CubeOctahedron, 1.73783e-5, 104_182.0),
        (DomainKind::CubeInCube, 1.68e-5, 104_956.0),
        (DomainKind::Tee, 5e-5, 109_003.0),
        (DomainKind::Gear, 1e-5, 0.99 * 107_094.0),
    ];
    for (kind, volume, most) in bars {
        let ready = prepared(&generate_domain(kind, &Shape::default()).expect("a domain"));
        let engine = Engine::Rounds { order: InsertOrder::Hilbert, start: 4096 };
        let refiner = Refiner::new().max_volume(volume).engine(engine);
        let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        assert_eq!(refined.outcome, RefineOutcome::Met, "{kind:?}");
        assert!(refined.num_tets() as f64 <= most, "{kind:?}: {}", refined.num_tets());
        let stats = refined.stats;
        let searches = stats.searches as f64 / stats.round_points as f64;
        assert!(searches <= 1.6, "{kind:?}: {searches}");
        assert!(stats.rounds.iter().sum::<u64>() <= 200, "{kind:?}: {:?}", stats.rounds);
    }
}
