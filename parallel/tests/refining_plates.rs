//! Thin plates in a box of another material: patches that separate two regions, with boundary items
//! that wait for each other in circles. The mesh is that of one thread.

use crate::refining_rounds::{same, simulated};
use ltbw::domain::PrepareOptions;
use ltbw::refine::Refiner;
use ltbw::refining::rounds_on_threads;
use ltbw::threads::Parallel;
use ltbw_generate::plates::{Plates, plates};

/// In the first, the dust of a circle's points has looked farther than the closures of these: the
/// conductor that splits the circle on what it was lent must not be content with that. In the last
/// an item is refused for which no point does, beside those of its own facet that come before.
#[test]
fn circles_at_patches_between_regions_are_split_by_workers_as_by_the_engine() {
    for (seed, start) in [(125, 64), (118, 0), (149, 0), (119, 0)] {
        let Plates { domain, volume } = plates(seed);
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let refiner =
            Refiner::new().max_volume(volume / 200.0).min_dihedral(0.0).flat_tolerance(1e-6);
        let refiner = refiner.start(start);
        let alone = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        let (circles, patches) = (alone.stats.joint_phases, alone.stats.patches);
        assert!(circles > 0 && patches > 0, "{seed}: {circles} circles, {patches} patches");
        for of in [(2, 100_000), (3, 1_000)] {
            let run = simulated(&refiner, &ready, of);
            same(&format!("{seed}, {of:?}"), &run.refined, &alone);
            assert!(run.figures.parted > 0, "{seed}, {of:?}: {:?}", run.ending);
        }
        for workers in [2, 3] {
            let whole = (&ready.domain, &ready.lattice);
            let run = rounds_on_threads(&refiner, whole, &Parallel::new(workers));
            let run = run.expect("a run ends");
            same(&format!("{seed}, {workers} workers"), &run.refined, &alone);
            assert!(run.figures.parted > 0, "{seed}, {workers} workers: {:?}", run.ending);
        }
        println!("{seed}: {circles} times circles, {patches} patches");
    }
}

/// As many as `LTBW_CASES` says, or a few, some of them finer.
#[test]
fn plates_at_random_are_refined_by_workers_as_by_the_engine() {
    let cases = std::env::var("LTBW_CASES").map_or(4, |text| text.parse().expect("a number"));
    let mut parted = 0;
    for seed in 20..20 + cases {
        let Plates { domain, volume } = plates(seed);
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let parts = if seed % 5 == 3 { 1000.0 } else { 200.0 };
        let refiner = Refiner::new().max_volume(volume / parts).flat_tolerance(1e-6).start(0);
        let alone = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        let whole = (&ready.domain, &ready.lattice);
        let run = rounds_on_threads(&refiner, whole, &Parallel::new(2)).expect("a run ends");
        same(&format!("{seed}"), &run.refined, &alone);
        parted += run.figures.parted;
    }
    assert!(parted > 0, "no circles");
}
