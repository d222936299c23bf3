//! Domains with small angles and features near each other, refined in rounds by workers that share
//! no mesh: the mesh is that of one thread, and workers have made most of it.

use crate::refining_rounds::{one_mesh, prepared};
use ltbw::domain::Prepared;
use ltbw::refine::Refiner;
use ltbw::refining::{Ending, rounds_on_threads};
use ltbw::threads::Parallel;
use ltbw_generate::{DomainKind, Shape};

fn angled(kind: DomainKind, angle: f64) -> Prepared {
    prepared(kind, &Shape { angle: Some(angle), ..Shape::default() })
}

/// The part of the points made in rounds that workers have inserted.
fn share(refiner: &Refiner<'_>, ready: &Prepared) -> f64 {
    let whole = (&ready.domain, &ready.lattice);
    let run = rounds_on_threads(refiner, whole, &Parallel::new(3)).expect("a run ends");
    run.figures.points as f64 / run.refined.stats.round_points.max(1) as f64
}

#[test]
fn domains_with_small_angles_have_the_engines_mesh_on_any_number_of_workers() {
    for (kind, angle, volume) in [
        (DomainKind::Wedge, 5.0, 1e-4),
        (DomainKind::Wedge, 15.0, 1e-4),
        (DomainKind::Spike, 5.0, 1e-3),
        (DomainKind::Spike, 15.0, 1e-3),
    ] {
        let ready = angled(kind, angle);
        for start in [0, 64] {
            let refiner = Refiner::new().max_volume(volume).start(start);
            let name = format!("{kind:?} of {angle} degrees, from {start} on");
            let ending = one_mesh(&name, &refiner, &ready);
            let share = share(&refiner, &ready);
            println!("{name}: {ending:?}, {share:.2} of the points by workers");
            assert_eq!(ending, Ok(Ending::Done), "{name}");
            assert!(share > 0.9, "{name}: {share} of the points by workers");
        }
    }
}
