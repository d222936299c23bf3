//! Domains with patches within a tolerance, refined in rounds by workers that share no mesh: points
//! there have turns, which one worker gives. The mesh is that of one thread.

use crate::refining_rounds::{one_mesh, simulated_by};
use ltbw::domain::{Domain, PrepareOptions, Prepared};
use ltbw::protocol::{Correct, Rules};
use ltbw::refine::{Refiner, usual_tolerance};
use ltbw::refining::{Ending, SimulatedRounds};
use ltbw_generate::surfaces::{globe, prism, shell, single, torus, turned};
use ltbw_generate::{DomainKind, Shape, generate_domain};

/// A domain on its lattice, and the tolerance that its patches are flat within.
fn surface(domain: &Domain) -> (Prepared, f64) {
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
    assert!(done >= 3, "{done} of the domains with patches were refined by workers to the end");
}

/// Points that change patches without the regions of new tetrahedra: the boundary is torn.
struct Unlabelled;

impl Rules for Unlabelled {
    const LABELS_WALLS: bool = false;
}

/// Runs on processors and latencies that keep to these rules: how many do not end with the points
/// and the mesh of those that keep to all.
fn wrong_runs<C: Rules>(domain: &Domain, volume: f64) -> usize {
    let (ready, tolerance) = surface(domain);
    let refiner = Refiner::new().flat_tolerance(tolerance).max_volume(volume).start(64);
    let hash = |run: &SimulatedRounds| run.refined.mesh().hash().expect("a hash");
    let runs = [(1, 0), (2, 1_000), (8, 30_000)].into_iter();
    let is_wrong = |of: &(u32, u64)| {
        let right = simulated_by::<Correct>(&refiner, &ready, *of).expect("a run ends");
        assert_eq!(right.ending, Ok(Ending::Done));
        simulated_by::<C>(&refiner, &ready, *of).map_or(true, |run| {
            hash(&run) != hash(&right) || run.figures.points != right.figures.points
        })
    };
    runs.filter(is_wrong).count()
}

#[test]
fn a_broken_rule_about_patches_is_caught() {
    assert!(wrong_runs::<Unlabelled>(&single(torus(10)), 1e-3) > 0, "R28");
}
