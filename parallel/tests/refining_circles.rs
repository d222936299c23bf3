//! Boundary items that wait for each other, split by one worker that is lent what lies around; and
//! rounds with circles and blocks that end early.

use crate::refining_rounds::{options, same, simulated};
use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::Layout;
use ltbw::protocol::Config;
use ltbw::refine::{RefineOutcome, Refined, Refiner};
use ltbw::refining::{Ending, Plan, rounds_on_threads, simulate_rounds};
use ltbw::simulate::Options;
use ltbw::threads::Parallel;
use ltbw::{Builder, CancelToken, Point, PointSet, invariants};
use ltbw_generate::layers::stack;
use ltbw_generate::surfaces::star;
use std::sync::atomic::{AtomicU32, Ordering};

/// Plates on each other, which have circles, with the volume of all.
fn plates(base: [f64; 2], layers: &[u32], regions: bool) -> (Prepared, f64) {
    let thicknesses: Vec<f64> = layers.iter().map(|&t| f64::from(t) / 64.0).collect();
    let domain = stack(base, &thicknesses, regions);
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    (ready, base[0] * base[1] * thicknesses.iter().sum::<f64>())
}

/// A star with patches, of which some subfaces come to bar many.
fn barred() -> (Prepared, Refiner<'static>) {
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let ready = star(5, 1e-8, 5).prepare(&options).expect("a sound domain");
    (ready, Refiner::new().flat_tolerance(5e-7).max_volume(3e-4).start(64))
}

fn engine(refiner: &Refiner<'_>, ready: &Prepared) -> Refined {
    refiner.refine(&ready.domain, &ready.lattice).expect("a mesh")
}

/// One mesh, for any number of workers and any latency; no worker hands the whole mesh over.
#[test]
fn circles_are_split_by_workers_as_by_the_engine() {
    let cases: [([f64; 2], &[u32], bool); 5] = [
        ([3.0, 2.0], &[42, 6, 4], false),
        ([3.0, 2.0], &[42, 6, 4], true),
        ([1.0, 1.0], &[29, 1, 3], true),
        ([2.0, 2.0], &[49; 7], false),
        ([1.0, 1.0], &[52, 54, 19, 27, 38, 22, 30, 55], true),
    ];
    let mut phases = 0;
    for (base, layers, regions) in cases {
        let (ready, volume) = plates(base, layers, regions);
        for parts in [500.0, 5000.0] {
            // Slivers are given back once, where late steps come before.
            let refiner = Refiner::new().max_volume(volume / parts).min_dihedral(0.0).start(0);
            let alone = engine(&refiner, &ready);
            for of in [(1, 1_000), (2, 100_000), (5, 1_000), (17, 30_000)] {
                let run = simulated(&refiner, &ready, of);
                let name = format!("{base:?} {layers:?}, volume / {parts}, {of:?}");
                same(&name, &run.refined, &alone);
                assert_eq!(run.figures.parted, alone.stats.joint_phases, "{name}");
                assert_eq!(run.figures.ended, 1, "{name}: {:?}", run.ending);
            }
            phases += alone.stats.joint_phases;
        }
    }
    println!("{phases} times circles were split");
    assert!(phases > 10, "{phases}");
}

/// Cancelled at any time the processors end, with something that the engine can go on with: its
/// mesh is the same.
#[test]
fn rounds_with_circles_and_blocks_that_are_cancelled_end() {
    let (plates, volume) = plates([1.0, 1.0], &[29, 1, 3], true);
    let on_plates = Refiner::new().max_volume(volume / 5000.0).start(0);
    let (star, on_star) = barred();
    for (name, ready, refiner) in [("plates", &plates, on_plates), ("a star", &star, on_star)] {
        let alone = engine(&refiner, ready);
        let plan = |points| Plan { layout: Layout::new(points, 5), config: Config::new(5) };
        let whole = (&ready.domain, &ready.lattice);
        let run = |cancel| {
            let options = Options { cancel, ..options(10_000) };
            simulate_rounds(&refiner, whole.0, whole.1, &plan, &options)
        };
        let all = run(None).expect("a run ends");
        let makespan = all.summary.expect("rounds").makespan;
        let mut cancelled = 0;
        for part in 0..20 {
            let own = run(Some(makespan * (2 * part + 1) / 40));
            let own = own.unwrap_or_else(|error| panic!("{name}, {part} of 20: {error}"));
            same(&format!("{name}, {part} of 20"), &own.refined, &alone);
            cancelled += usize::from(own.ending == Ok(Ending::Cancelled));
        }
        println!("{name}: {cancelled} of 20 runs were cancelled in rounds");
        assert!(cancelled >= 10, "{name}: {cancelled}");
    }
}

/// A token that is set while workers are in the midst of their rounds leaves a sound mesh that says
/// so.
#[test]
fn workers_that_are_stopped_among_circles_and_blocks_leave_a_sound_mesh() {
    let (plates, volume) = plates([1.0, 1.0], &[29, 1, 3], true);
    let on_plates = Refiner::new().max_volume(volume / 5000.0).start(0);
    let (star, on_star) = barred();
    for (name, ready, refiner) in [("plates", &plates, on_plates), ("a star", &star, on_star)] {
        let asked = AtomicU32::new(0);
        let count = |_: Point| {
            asked.fetch_add(1, Ordering::Relaxed);
            1.0
        };
        engine(&refiner.sizing(&count), ready);
        let all = asked.into_inner();
        let mut cancelled = 0;
        for part in 1..8 {
            let (token, asked) = (CancelToken::new(), AtomicU32::new(0));
            let sizes = |_: Point| {
                if asked.fetch_add(1, Ordering::Relaxed) == all / 8 * part {
                    token.cancel();
                }
                1.0
            };
            let refiner = refiner.sizing(&sizes).cancel(&token);
            let whole = (&ready.domain, &ready.lattice);
            let Ok(run) = rounds_on_threads(&refiner, whole, &Parallel::new(3).cancel(&token))
            else {
                continue;
            };
            let mesh = run.refined.mesh();
            invariants::check_all(mesh).unwrap_or_else(|defect| panic!("{name}: {defect}"));
            if run.refined.outcome != RefineOutcome::Cancelled {
                continue;
            }
            cancelled += 1;
            let points: Vec<Point> = mesh.vertices().map(|(_, p)| p).collect();
            let anew = Builder::new().build(&PointSet::new(points).expect("finite"));
            let anew = anew.expect("a mesh").mesh;
            assert_eq!(mesh.hash(), anew.hash(), "{name}, {part} of 8");
        }
        println!("{name}: {cancelled} of 7 runs were stopped");
        assert!(cancelled >= 3, "{name}: {cancelled}");
    }
}

/// A budget ends rounds before the one that would exceed it, whatever was split before.
#[test]
fn a_budget_among_circles_and_blocks_leaves_the_engines_partial_mesh() {
    let (plates, volume) = plates([1.0, 1.0], &[29, 1, 3], true);
    let on_plates = Refiner::new().max_volume(volume / 5000.0).start(0);
    let (star, on_star) = barred();
    for (name, ready, refiner) in [("plates", &plates, on_plates), ("a star", &star, on_star)] {
        let stats = engine(&refiner, ready).stats;
        let all = stats.segment_points + stats.facet_points + stats.free_points;
        let mut cut = 0;
        for part in 1..16 {
            let refiner = refiner.max_points(all * part / 16);
            let alone = engine(&refiner, ready);
            let run = simulated(&refiner, ready, (4, 2_000));
            same(&format!("{name}, {part} of 16"), &run.refined, &alone);
            cut += usize::from(run.ending == Ok(Ending::Budget));
        }
        println!("{name}: {cut} of 15 runs ended for the budget");
        assert!(cut >= 5, "{name}: {cut}");
    }
}
