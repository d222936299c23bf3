//! Domains and bounds that no mesh can do justice to: each ends, soon, with an outcome that has
//! names.
//!
//! "Soon" is told in transactions, which no noise touches: some 100,000 of them take a second.

use ltbw::domain::{Domain, Facet, PrepareError, PrepareOptions};
use ltbw::refine::{Reason, RefineError, RefineOutcome, Refined, Refiner};
use ltbw_generate::{DomainKind, Shape, generate_domain};

/// The most points that such a domain may take.
const FEW: u64 = 100_000;

fn refine(domain: &Domain, refiner: &Refiner<'_>) -> Refined {
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    refiner.refine(&ready.domain, &ready.lattice).expect("a mesh")
}

fn points(refined: &Refined) -> u64 {
    let stats = &refined.stats;
    stats.segment_points + stats.facet_points + stats.free_points
}

/// The outcome is named: everything over its bounds has a reason of the input's own.
fn assert_named(refined: &Refined, name: &str) {
    assert!(points(refined) < FEW, "{name}: {} points", points(refined));
    assert!(refined.lost.is_empty(), "{name}: {:?}", refined.lost.first());
    match refined.outcome {
        RefineOutcome::Met => assert!(refined.excuses.is_empty(), "{name}"),
        RefineOutcome::Excused => assert!(!refined.excuses.is_empty(), "{name}"),
        other => panic!("{name}: {other:?}"),
    }
    let named = |reason| !matches!(reason, Reason::Budget | Reason::Cancelled | Reason::Rounding);
    let bad = refined.excuses.iter().find(|e| !named(e.reason));
    assert!(bad.is_none(), "{name}: {bad:?}");
}

#[test]
fn wedges_and_spikes_of_any_angle_end() {
    for angle in [60.0, 30.0, 5.0, 1.0, 0.1] {
        for kind in [DomainKind::Wedge, DomainKind::Spike] {
            if kind == DomainKind::Spike && angle >= 45.0 {
                continue; // It would be none.
            }
            let shape = Shape { angle: Some(angle), ..Shape::default() };
            let domain = generate_domain(kind, &shape).expect("a domain");
            for refiner in [Refiner::new(), Refiner::new().max_volume(1e-3)] {
                let refined = refine(&domain, &refiner);
                assert_named(&refined, &format!("{kind:?} of {angle} degrees"));
            }
        }
    }
}

/// The unit cube, and in it a turned square plate at a height over the floor; with a depth, a box.
fn plate(height: f64, depth: f64) -> Domain {
    let vertices = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    let mut domain = Domain { vertices, ..Domain::default() };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    domain.facets.extend(faces.map(|f| Facet::polygon(&f, 0)));
    // Turned by a rational angle: 3-4-5.
    let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]: [f64; 2]| {
        [0.5 + 0.25 * (0.8 * x - 0.6 * y), 0.5 + 0.25 * (0.6 * x + 0.8 * y)]
    });
    domain.vertices.extend(square.map(|[x, y]| [x, y, height]));
    domain.facets.push(Facet::polygon(&[8, 9, 10, 11], 0));
    if depth > 0.0 {
        domain.vertices.extend(square.map(|[x, y]| [x, y, height + depth]));
        for k in 0..4 {
            let next = (k + 1) % 4;
            domain.facets.push(Facet::polygon(&[8 + k, 8 + next, 12 + next, 12 + k], 0));
        }
        domain.facets.push(Facet::polygon(&[12, 13, 14, 15], 0));
        domain.holes.push([0.5, 0.5, height + depth / 2.0]);
    }
    domain
}

#[test]
fn facets_near_each_other_end_and_are_named() {
    for height in [1e-7, 1e-6, 1e-5] {
        for depth in [0.0, 0.25] {
            let refined = refine(&plate(height, depth), &Refiner::new());
            let name = format!("a plate {height:e} over the floor, {depth:e} thick");
            assert_named(&refined, &name);
            let near = |e: &ltbw::refine::Excuse| matches!(e.reason, Reason::NearFacet { .. });
            assert!(refined.excuses.iter().any(near), "{name}");
        }
    }
    // Far enough apart it is no special case: everything is met.
    let refined = refine(&plate(0.02, 0.0), &Refiner::new());
    assert_eq!(refined.outcome, RefineOutcome::Met);
    // A small feature is not a wide one: it is met, too.
    let mut small = plate(0.5, 0.0);
    for v in &mut small.vertices[8..] {
        *v = v.map(|c| 0.5 + (c - 0.5) * 1e-5);
    }
    assert_eq!(refine(&small, &Refiner::new()).outcome, RefineOutcome::Met);
}

#[test]
fn near_coplanar_facets_are_features_below_the_lattice() {
    let domain = plate(1e-9, 0.25);
    let error = domain.prepare(&PrepareOptions::default()).expect_err("below the lattice");
    assert!(matches!(error, PrepareError::BelowLattice { .. }), "{error}");
}

#[test]
fn bounds_out_of_reach_are_errors_or_use_up_the_budget() {
    let ready = plate(0.5, 0.25).prepare(&PrepareOptions::default()).expect("a sound domain");
    let refine = |refiner: Refiner<'_>| refiner.refine(&ready.domain, &ready.lattice);
    for refiner in [Refiner::new().radius_edge(0.99), Refiner::new().max_volume(1e-40)] {
        let error = refine(refiner).expect_err("no such mesh");
        assert!(matches!(error, RefineError::Bound { .. }), "{error}");
    }
    // Within the lattice, beyond patience.
    for refiner in [Refiner::new().radius_edge(1.0), Refiner::new().max_volume(1e-12)] {
        let refined = refine(refiner.max_points(20_000)).expect("a mesh");
        assert_eq!(refined.outcome, RefineOutcome::Budget);
        // A round that would exceed it is not begun, and none doubles the mesh.
        assert!((10_000..=20_000).contains(&points(&refined)), "{}", points(&refined));
        assert!(refined.excuses.iter().any(|e| e.reason == Reason::Budget));
    }
    // One point is too few for the boundary: what is missing is listed. Or it is there at once.
    let refined = refine(Refiner::new().max_points(1)).expect("a mesh");
    match refined.outcome {
        RefineOutcome::Unrecovered => {
            assert!(refined.lost.iter().all(|(_, reason)| *reason == Reason::Budget));
            assert!(!refined.lost.is_empty() && refined.num_tets() == 0);
        }
        outcome => assert_eq!(outcome, RefineOutcome::Budget),
    }
}
