//! Domains with patches within a tolerance, refined in rounds by workers that share no mesh: points
//! there have turns, which one worker gives. The mesh is that of one thread.

use crate::refining_rounds::one_mesh;
use ltbw::domain::{Domain, PrepareOptions, Prepared};
use ltbw::refine::{Refiner, usual_tolerance};
use ltbw::refining::Ending;
use ltbw_generate::surfaces::{globe, prism, ramp, shell, single, star, torus, turned};
use ltbw_generate::{DomainKind, Shape, generate_domain};

/// A domain on its lattice, and the tolerance that its patches are flat within.
pub(crate) fn surface(domain: &Domain) -> (Prepared, f64) {
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("a sound domain");
    let tolerance = usual_tolerance(domain, &ready.domain);
    (ready, tolerance.max(5e-7))
}

#[test]
fn surfaces_with_patches_have_the_engines_mesh_on_any_number_of_workers() {
    let solid = |kind| turned(&generate_domain(kind, &Shape::default()).expect("a shape"));
    let mut done = 0;
    for (name, domain, volume) in [
        ("a torus", single(torus(10)), 1e-3),
        ("a torus, turned", turned(&single(torus(10))), 3e-4),
        ("a torus of larger tetrahedra", single(torus(12)), 1e-2),
        ("a shell, turned", single(turned(&shell(0.1))), 3e-4),
        ("a globe", single(globe(12, 12, 0.0, 1)), 3e-4),
        ("a prism", single(prism(12, 1e-7, 1)), 3e-4),
        ("a tee, turned", solid(DomainKind::Tee), 1e-3),
        ("a cube in a cube, turned", solid(DomainKind::CubeInCube), 1e-3),
    ] {
        let (ready, tolerance) = surface(&domain);
        let refiner = Refiner::new().flat_tolerance(tolerance).max_volume(volume).start(64);
        let patches = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh").stats.patches;
        let ending = one_mesh(name, &refiner, &ready);
        println!("{name}: {patches} patches, {ending:?}");
        done += usize::from(patches > 0 && ending == Ok(Ending::Done));
    }
    assert!(done >= 7, "{done} of the domains with patches were refined by workers to the end");
}

/// Points at patches have turns there, and much is refused, which all know before the next round.
/// Subfaces of stars come to bar many at once, which all know, too.
#[test]
fn patches_beside_sharp_edges_have_the_engines_mesh_on_any_number_of_workers() {
    let (mut done, mut excused) = (0, 0);
    let stars = (3..9).map(|k| (format!("a star of {k}"), star(k, 1e-8, u64::from(k))));
    let heights = [0.1, 0.2, 0.3, 0.35];
    let ramps = (2..).zip(heights);
    let ramps = ramps.map(|(k, h)| (format!("a ramp of {h}"), ramp(k, h, 1e-8, u64::from(k))));
    for (name, domain) in stars.chain(ramps) {
        let (ready, tolerance) = surface(&domain);
        let refiner = Refiner::new().flat_tolerance(tolerance).max_volume(3e-4).start(64);
        let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        let ending = one_mesh(&name, &refiner, &ready);
        let (patches, left) = (engine.stats.patches, engine.excuses.len());
        println!("{name}: {patches} patches, {left} excused, {ending:?}");
        assert!(patches > 0, "{name}");
        if ending == Ok(Ending::Done) {
            (done, excused) = (done + 1, excused + left);
        }
    }
    assert!(done >= 9 && excused > 0, "{done} refined by workers to the end, {excused} excused");
}
