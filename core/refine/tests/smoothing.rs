//! Smoothing: vertices inside move, and the mesh is a better one by the same rules.

use crate::given_points::{judged_within, plc_of, prepared, with_points};
use ltbw_domain::Prepared;
use ltbw_domain::quality::Quality;
use ltbw_generate::scattered::scattered;
use ltbw_generate::surfaces::torus;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_refine::{InsertOrder, RefineError, RefineOutcome, Refined, Refiner};
use ltbw_verify::Limits;

fn domain(kind: DomainKind) -> Prepared {
    prepared(&generate_domain(kind, &Shape::default()).expect("a domain"))
}

fn hash(refined: &Refined) -> String {
    refined.mesh().hash().expect("a hash").to_string()
}

fn quality(refined: &Refined) -> Quality {
    let mesh = refined.inside();
    Quality::of(&mesh.points, &mesh.tets).expect("tetrahedra")
}

#[test]
fn smoothed_meshes_meet_their_bounds_and_have_larger_angles() {
    for (kind, volume) in [
        (DomainKind::CubeOctahedron, 3e-4),
        (DomainKind::CubeInCube, 3e-4),
        (DomainKind::TwoMaterial, 1e-3),
        (DomainKind::Tee, 1e-3),
        (DomainKind::Gear, 1e-3),
    ] {
        let ready = domain(kind);
        let refiner = Refiner::new().max_volume(volume);
        let refine = |sweeps| {
            let refined = refiner.smooth(sweeps).refine(&ready.domain, &ready.lattice);
            refined.expect("a mesh")
        };
        let meshes = [0, 1, 2].map(refine);
        let counts = meshes.each_ref().map(|m| (m.mesh().num_vertices(), m.outcome));
        assert!(counts.iter().all(|own| *own == counts[0]), "{kind:?}: {counts:?}");
        assert!(meshes[0].stats.moved == 0 && meshes[1].stats.moved > 0, "{kind:?}");
        assert!(meshes[2].stats.moved > meshes[1].stats.moved, "{kind:?}");
        let limits =
            Limits { radius_edge: Some(2.0), max_volume: Some(volume), ..Limits::default() };
        for refined in &meshes[1..] {
            let found = judged_within(refined, &plc_of(&ready.domain), &limits);
            assert!(found.passed(), "{kind:?}: {:?}", found.findings.first());
        }
        // The least angle does not fall, and those below 15 degrees become few.
        let of = meshes.each_ref().map(quality);
        let least = of.each_ref().map(|own| own.dihedral.least.value);
        let small = of.each_ref().map(|own| own.dihedral.counts[..3].iter().sum::<u64>());
        assert!(least[1] >= least[0] && least[2] >= least[1], "{kind:?}: {least:?}");
        assert!(small[0] > 2 * small[1] && small[1] >= small[2], "{kind:?}: {small:?}");
    }
}

#[test]
fn a_smoothed_mesh_depends_on_no_order() {
    let ready = domain(DomainKind::CubeInCube);
    let refiner = Refiner::new().max_volume(1e-3).start(64).smooth(2);
    let mut hashes = Vec::new();
    for order in [InsertOrder::Forwards, InsertOrder::Backwards, InsertOrder::Random(5)] {
        let refined = refiner.insert_order(order).refine(&ready.domain, &ready.lattice);
        hashes.push(hash(&refined.expect("a mesh")));
    }
    let alone = refiner.one_thread().refine(&ready.domain, &ready.lattice).expect("a mesh");
    hashes.push(hash(&alone));
    assert!(hashes.iter().all(|own| *own == hashes[0]), "{hashes:?}");
}

#[test]
fn given_points_stay_where_they_are() {
    let domain = generate_domain(DomainKind::Tee, &Shape::default()).expect("a domain");
    let ready = with_points(DomainKind::Tee, scattered(&domain, 9, 40).all());
    let refiner = Refiner::new().max_volume(1e-2).smooth(2);
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    assert!(refined.stats.moved > 0);
    let found = judged_within(&refined, &plc_of(&ready.domain), &Limits::default());
    assert!(found.passed(), "{:?}", found.findings.first());
    let (points, first) = (refined.mesh().points(), ready.domain.vertices.len());
    assert_eq!(points[first..first + ready.domain.points.len()], ready.domain.points[..]);
}

#[test]
fn patches_stay_covered_and_lengths_are_kept() {
    let ready = prepared(&torus(12));
    let field = |p: ltbw_core::Point| 0.05 + 0.1 * p[0].abs();
    for tolerance in [0.0, 1e-6] {
        let refiner = Refiner::new().flat_tolerance(tolerance).sizing(&field).smooth(1);
        let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        assert!(refined.stats.moved > 0);
        assert!(matches!(refined.outcome, RefineOutcome::Met | RefineOutcome::Excused));
        let plc = ltbw_verify::Plc {
            flat_tolerance: refined.stats.flat_tolerance,
            ..plc_of(&ready.domain)
        };
        let found = judged_within(&refined, &plc, &Limits::default());
        assert!(found.passed(), "{tolerance}: {:?}", found.findings.first());
    }
}

#[test]
fn more_sweeps_than_there_may_be_are_refused() {
    let ready = domain(DomainKind::Tee);
    let refined = Refiner::new().smooth(17).refine(&ready.domain, &ready.lattice);
    assert!(matches!(refined, Err(RefineError::Bound { name: "smooth", .. })), "{refined:?}");
}
