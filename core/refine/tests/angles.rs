//! Smallest dihedral angles before slivers are split, and after.

use crate::given_points::prepared;
use ltbw_domain::Prepared;
use ltbw_domain::quality::Quality;
use ltbw_generate::surfaces::{single, torus};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_refine::{RefineOutcome, Refined, Refiner};

fn refine(refiner: &Refiner<'_>, ready: &Prepared) -> Refined {
    refiner.refine(&ready.domain, &ready.lattice).expect("a mesh")
}

fn quality(refined: &Refined) -> Quality {
    let mesh = refined.inside();
    Quality::of(&mesh.points, &mesh.tets).expect("tetrahedra")
}

#[test]
fn angles_before_are_those_of_a_mesh_whose_slivers_stay() {
    for (kind, volume) in [
        (DomainKind::CubeOctahedron, 3e-4),
        (DomainKind::TwoMaterial, 1e-3),
        (DomainKind::Tee, 1e-3),
    ] {
        let ready = prepared(&generate_domain(kind, &Shape::default()).expect("a domain"));
        let refiner = Refiner::new().max_volume(volume);
        let unasked = refine(&refiner, &ready);
        assert_eq!(unasked.stats.before_slivers, None, "{kind:?}");
        let own = refine(&refiner.count_angles(), &ready);
        assert_eq!(own.mesh().hash().ok(), unasked.mesh().hash().ok(), "{kind:?}");
        let before = own.stats.before_slivers.expect("angles are counted");
        let plain = refine(&refiner.count_angles().min_dihedral(0.0), &ready);
        assert_eq!((plain.stats.before_slivers, plain.outcome), (None, RefineOutcome::Met));
        assert_eq!(before, quality(&plain).least_angles, "{kind:?}");
        let after = quality(&own).least_angles;
        assert_eq!(after.counts().iter().sum::<u64>(), own.num_tets() as u64);
        assert_eq!(after.below(8.0), own.slivers.len() as u64, "{kind:?}");
        assert!(before.below(8.0) > 10 + 10 * after.below(8.0), "{kind:?}: {before:?}");
        assert!(before.least() < after.least(), "{kind:?}");
    }
}

#[test]
fn angles_are_counted_by_one_thread_as_by_several() {
    let ready = prepared(&single(torus(12)));
    let refiner = Refiner::new().max_volume(1e-3).flat_tolerance(1e-7).start(64).count_angles();
    let several = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
    let several = several.install(|| refine(&refiner, &ready));
    let one = refine(&refiner.one_thread(), &ready);
    assert!(one.stats.before_slivers.is_some());
    assert_eq!(one.stats.before_slivers, several.stats.before_slivers);
    // A run that ends before slivers are looked for has not counted.
    let ended = refine(&refiner.max_points(50), &ready);
    assert_eq!((ended.outcome, ended.stats.before_slivers), (RefineOutcome::Budget, None));
}
