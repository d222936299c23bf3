//! Work that processors without rounds leave alone: boundary items that nobody asks for, those that
//! take each other out, and cavities behind the boundary.

use crate::refining_patches::surface;
use ltbw::domain::Prepared;
use ltbw::mesh::Layout;
use ltbw::protocol::Config;
use ltbw::refine::{RefineOutcome, Refiner};
use ltbw::refining::{Plan, SimulatedDomain, domain_on_threads, simulate_domain};
use ltbw::simulate::Options;
use ltbw::threads::Parallel;
use ltbw_generate::surfaces::{plate, prism};
use ltbw_generate::{DomainKind, Shape, generate_domain};

fn simulated(refiner: &Refiner<'_>, ready: &Prepared, processors: u32) -> SimulatedDomain {
    let config = Config { window: 16, ..Config::new(processors) };
    let plan = |points| Plan { layout: Layout::new(points, processors), config };
    let run = simulate_domain(refiner, &ready.domain, &ready.lattice, &plan, &Options::default());
    run.expect("a run ends")
}

/// Domains that are done where rounds would begin have the tetrahedra of rounds. On many of them
/// boundary items would take each other out, if somebody asked for them.
#[test]
fn what_nobody_asks_for_is_not_split() {
    for (corners, noise, seed) in [(6, 1e-2, 3), (6, 1e-4, 2), (8, 1e-6, 0), (8, 1e-2, 0)] {
        let name = format!("prism of {corners}, {noise:e}, {seed}");
        let (ready, tolerance) = surface(&prism(corners, noise, seed));
        let refiner = Refiner::new().flat_tolerance(tolerance);
        let whole = (&ready.domain, &ready.lattice);
        let rounds = refiner.refine(whole.0, whole.1).expect("a mesh");
        let run = simulated(&refiner, &ready, 4);
        assert_eq!(run.refined.num_tets(), rounds.num_tets(), "{name}");
        let run = domain_on_threads(&refiner, whole.0, whole.1, &Parallel::new(2)).expect("a mesh");
        assert_eq!(run.refined.num_tets(), rounds.num_tets(), "{name} on threads");
    }
}

/// Items that take each other out are given up before long, and the engine splits them.
#[test]
fn circles_are_left_to_the_engine_before_long() {
    let domain = generate_domain(DomainKind::Gear, &Shape::default()).expect("a shape");
    let (ready, _) = surface(&domain);
    let refiner = Refiner::new().max_volume(4e-4).start(0);
    for processors in [1, 4, 16] {
        let run = simulated(&refiner, &ready, processors);
        assert_eq!(run.refined.outcome, RefineOutcome::Met, "on {processors}");
        let [items, _] = run.splits.refused;
        assert!(items > 10 && run.splits.deferred < 5_000, "{processors}: {:?}", run.splits);
    }
}

/// The centres of flat tetrahedra are far beyond the boundary, and half of the hull is in their
/// cavities: these are not opened.
#[test]
fn no_cavity_is_opened_behind_the_boundary() {
    let (ready, _) = surface(&plate(8, 0.1));
    let refiner = Refiner::new().flat_tolerance(0.0).start(256);
    let run = simulated(&refiner, &ready, 2);
    assert_eq!(run.refined.outcome, RefineOutcome::Met);
    let (splits, remote) = (run.splits, run.summary.cavities.interface_all());
    let inserted: u64 = splits.inserted.iter().sum();
    println!("{splits:?}, {remote} at interfaces");
    assert!(inserted > 300 && remote * 4 < inserted + splits.deferred, "{splits:?}, {remote}");
}
