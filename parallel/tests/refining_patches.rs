//! Domains with patches within a tolerance, refined in rounds by workers that share no mesh: points
//! there have turns, which one worker gives. The mesh is that of one thread.

use crate::refining_rounds::one_mesh;
use ltbw::domain::{Domain, PrepareOptions, Prepared};
use ltbw::refine::{Refiner, usual_tolerance};
use ltbw::refining::Ending;
use ltbw_generate::surfaces::{globe, prism, shell, single, torus, turned};

fn surface(domain: &Domain) -> (Prepared, f64) {
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("a sound domain");
    let tolerance = usual_tolerance(domain, &ready.domain);
    (ready, tolerance.max(5e-7))
}

#[test]
fn surfaces_with_patches_have_the_engines_mesh_on_any_number_of_workers() {
    let mut by_workers = 0;
    for (name, domain, volume) in [
        ("a torus", single(torus(10)), 1e-3),
        ("a torus, turned", turned(&single(torus(10))), 3e-4),
        ("a shell, turned", single(turned(&shell(0.1))), 3e-4),
        ("a globe", single(globe(12, 12, 0.0, 1)), 3e-4),
        ("a prism", single(prism(12, 1e-7, 1)), 3e-4),
    ] {
        let (ready, tolerance) = surface(&domain);
        let refiner = Refiner::new().flat_tolerance(tolerance).max_volume(volume).start(64);
        let ending = one_mesh(name, &refiner, &ready);
        println!("{name}: {ending:?}");
        by_workers += usize::from(ending == Ok(Ending::Done));
    }
    assert!(by_workers >= 3, "{by_workers}");
}
