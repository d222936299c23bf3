//! Slivers split by workers in rounds: where nothing was refused they go on with these when all
//! bounds are met, inside, on the boundary and on patches, by the engine's rules. The mesh is that
//! of one thread.

use crate::refining_rounds::{one_mesh, prepared};
use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::refine::Refiner;
use ltbw::refining::{Ending, rounds_on_threads};
use ltbw::threads::Parallel;
use ltbw_generate::surfaces::{prism, shell, single, torus, turned};
use ltbw_generate::{DomainKind, Shape};

/// The points that rounds of slivers make, and those of all rounds that are left to the engine by
/// three workers.
fn points(refiner: &Refiner<'_>, ready: &Prepared) -> [u64; 2] {
    let whole = (&ready.domain, &ready.lattice);
    let engine = refiner.refine(whole.0, whole.1).expect("a mesh");
    let slivers = engine.rounds.iter().filter(|round| round.class == "slivers");
    let slivers = slivers.map(|round| round.points as u64).sum();
    assert!(engine.stats.before_slivers.is_some_and(|own| slivers == 0 || own.below(12.0) > 0));
    let run = rounds_on_threads(refiner, whole, &Parallel::new(3)).expect("a run ends");
    [slivers, run.refined.stats.round_points - run.figures.points]
}

#[test]
fn workers_split_slivers() {
    let mut all = 0;
    for (kind, volume, degrees) in [
        (DomainKind::CubeOctahedron, 3e-4, 12.0),
        (DomainKind::CubeInCube, 1e-3, 12.0),
        (DomainKind::Tee, 3e-4, 8.0),
        (DomainKind::Gear, 4e-4, 12.0),
        (DomainKind::TwoMaterial, 5e-4, 12.0),
        (DomainKind::LBlock, 1e-3, 10.0),
    ] {
        let ready = prepared(kind, &Shape::default());
        let refiner =
            Refiner::new().max_volume(volume).min_dihedral(degrees).start(64).count_angles();
        let name = format!("{kind:?}, {degrees} degrees");
        let [slivers, left] = points(&refiner, &ready);
        println!("{name}: {slivers} points for slivers, {left} left to the engine");
        assert_eq!(one_mesh(&name, &refiner, &ready), Ok(Ending::Done), "{name}");
        assert!(slivers > 5 && left <= slivers / 5, "{name}: {left} of {slivers}");
        all += slivers;
    }
    assert!(all > 200, "{all} points");
}

/// Points for slivers at patches change these, and bring along what does not follow from a closure.
#[test]
fn workers_split_slivers_at_patches() {
    let (mut all, mut left) = (0, 0);
    for (name, domain, volume) in [
        ("a torus", single(torus(10)), 1e-3),
        ("a torus, turned", turned(&single(torus(12))), 3e-4),
        ("a shell, turned", single(turned(&shell(0.1))), 3e-4),
        ("a prism", single(prism(12, 1e-7, 1)), 3e-4),
    ] {
        let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
        let ready = domain.prepare(&options).expect("a sound domain");
        let refiner = Refiner::new().flat_tolerance(5e-7).max_volume(volume);
        let refiner = refiner.min_dihedral(12.0).start(64).count_angles();
        let own = points(&refiner, &ready);
        println!("{name}: {} points for slivers, {} left to the engine", own[0], own[1]);
        (all, left) = (all + own[0], left + own[1]);
        println!("{name}: {:?}", one_mesh(name, &refiner, &ready));
    }
    assert!(all > 50 && left <= all / 8, "{left} of {all} points left to the engine");
}

/// Where something was refused late steps come before, which take the whole mesh; then the engine
/// leaves slivers to the workers.
#[test]
fn workers_split_slivers_after_relief() {
    let mut all = [0; 2];
    for (kind, angle, volume) in [
        (DomainKind::Wedge, 5.0, 1e-4),
        (DomainKind::Wedge, 15.0, 3e-5),
        (DomainKind::Spike, 15.0, 1e-3),
        (DomainKind::Spike, 5.0, 5e-4),
    ] {
        let ready = prepared(kind, &Shape { angle: Some(angle), ..Shape::default() });
        let refiner = Refiner::new().max_volume(volume).min_dihedral(12.0).start(64).count_angles();
        let name = format!("{kind:?} of {angle} degrees");
        let [slivers, left] = points(&refiner, &ready);
        println!("{name}: {slivers} points for slivers, {left} left to the engine");
        assert!(one_mesh(&name, &refiner, &ready).is_ok(), "{name}");
        // Vertices are moved when slivers are split, and not before.
        let name = format!("{name}, smoothed");
        assert!(one_mesh(&name, &refiner.smooth(3), &ready).is_ok(), "{name}");
        all = [all[0] + slivers, all[1] + left];
    }
    assert!(all[0] > 50 && all[1] < all[0] / 4, "{all:?}");
}

/// A budget that rounds of slivers might exceed is the engine's.
#[test]
fn a_budget_that_slivers_use_up_leaves_the_engines_mesh() {
    let ready = prepared(DomainKind::CubeOctahedron, &Shape::default());
    let refiner = Refiner::new().max_volume(1e-3).min_dihedral(12.0).start(64).count_angles();
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let stats = engine.stats;
    let all = stats.segment_points + stats.facet_points + stats.free_points;
    let slivers = engine.rounds.iter().filter(|round| round.class == "slivers");
    let slivers: u64 = slivers.map(|round| round.points as u64).sum();
    assert!(slivers > 10, "{slivers}");
    for most in (all - slivers..all).step_by(3) {
        let refiner = refiner.max_points(most);
        assert!(one_mesh(&format!("{most} points"), &refiner, &ready).is_ok());
    }
}
