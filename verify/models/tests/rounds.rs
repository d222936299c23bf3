//! Known-bad variants of the rules of rounds (that of the second wave is in `variants.rs`): workers
//! that break one of them make another mesh than the engine with one mesh, or none, on some of the
//! domains and networks; workers that keep all make the engine's on every one.
#![cfg(not(any(loom, shuttle)))]

use ltbw::MeshHash;
use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::Layout;
use ltbw::protocol::{Config, Correct, Rules};
use ltbw::refine::{Refined, Refiner};
use ltbw::refining::{Ending, Plan, simulate_rounds_as};
use ltbw::simulate::{Network, Options};
use ltbw_generate::layers::stack;
use ltbw_generate::plates::{Plates, plates};
use ltbw_generate::{DomainKind, Shape, generate_domain, surfaces};
use ltbw_models::report::row;
use ltbw_models::variants::{Defect, KnownBad};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Processors and latency in nanoseconds of the runs.
const RUNS: [(u32, u64); 5] = [(2, 1_000), (3, 30_000), (8, 1_000), (16, 30_000), (40, 1_000)];

/// Runs with more processors, so that little is anyone's own.
const MANY: [(u32, u64); 3] = [(48, 1_000), (64, 1_000), (80, 1_000)];

/// A domain and the engine's mesh of it.
struct Case {
    ready: Prepared,
    refiner: Refiner<'static>,
    expected: MeshHash,
    /// Points that rounds inserted.
    points: u64,
    patience: Patience,
}

/// The most events, and the longest time without a point: rounds without one are many where much is
/// refused, and each takes some latencies.
#[derive(Clone, Copy)]
struct Patience {
    events: u64,
    nanos: u64,
    latencies: u64,
}

/// Where nothing is refused.
const SHORT: Patience = Patience { events: 1_000_000, nanos: 4_000_000, latencies: 500 };
const LONG: Patience = Patience { events: 4_000_000, nanos: 20_000_000, latencies: 4_000 };

impl Case {
    fn new(
        engine: &Refined,
        ready: Prepared,
        refiner: Refiner<'static>,
        patience: Patience,
    ) -> Self {
        let (expected, points) = (hash(engine), engine.stats.round_points);
        Self { ready, refiner, expected, points, patience }
    }
}

fn hash(refined: &Refined) -> MeshHash {
    refined.mesh().hash().expect("a hash")
}

fn case(kind: DomainKind, volume: f64) -> Case {
    case_of(kind, Refiner::new().max_volume(volume).start(1))
}

fn case_of(kind: DomainKind, refiner: Refiner<'static>) -> Case {
    let domain = generate_domain(kind, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    Case::new(&engine, ready, refiner, SHORT)
}

/// A torus with patches.
fn patched_case() -> Case {
    let domain = surfaces::single(surfaces::torus(10));
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("a sound domain");
    let refiner = Refiner::new().flat_tolerance(5e-7).max_volume(3e-4).start(64);
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    Case::new(&engine, ready, refiner, LONG)
}

/// A domain with a small angle, where much is refused.
fn angled_case(kind: DomainKind, angle: f64, volume: f64) -> Case {
    let shape = Shape { angle: Some(angle), ..Shape::default() };
    let domain = generate_domain(kind, &shape).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(volume).start(64);
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    Case::new(&engine, ready, refiner, LONG)
}

const KINDS: [(DomainKind, f64); 4] = [
    (DomainKind::CubeOctahedron, 2e-3),
    (DomainKind::CubeInCube, 2e-3),
    (DomainKind::Tee, 2e-3),
    (DomainKind::Gear, 1e-3),
];

fn cases() -> Vec<Case> {
    KINDS.into_iter().map(|(kind, volume)| case(kind, volume)).collect()
}

/// The end of a run: the engine's mesh, or something that shows that it is not sound.
fn run<C: Rules>(case: &Case, (processors, latency): (u32, u64)) -> Result<(), String> {
    let network = Network { latency, ..Network::default() };
    let Patience { events: max_events, nanos, latencies } = case.patience;
    let patience = nanos + latencies * latency;
    let options = Options { network, max_events, patience, ..Options::default() };
    let plan =
        |points| Plan { layout: Layout::new(points, processors), config: Config::new(processors) };
    let (domain, lattice) = (&case.ready.domain, &case.ready.lattice);
    match simulate_rounds_as::<C>(&case.refiner, domain, lattice, plan, &options) {
        Ok(run) if hash(&run.refined) != case.expected => Err("another mesh".to_owned()),
        // Of two points in one place one is as good as both: the mesh does not show it.
        Ok(run) if run.refined.stats.round_points != case.points => Err("other points".to_owned()),
        Ok(run) if run.ending != Ok(Ending::Done) => Err(format!("it ends: {:?}", run.ending)),
        Ok(_) => Ok(()),
        Err(error) => {
            let text = error.to_string();
            Err(text.split(" at ").next().unwrap_or_default().to_owned())
        }
    }
}

/// Runs in which a defect is caught: more of them show nothing new.
const ENOUGH: usize = 3;

/// A defect is caught in some run, and the correct protocol in none.
fn caught(defect: Defect, all: &[Case]) {
    caught_in(&RUNS, defect, all);
}

/// As [`caught`], with these processors and latencies.
fn caught_in(with: &[(u32, u64)], defect: Defect, all: &[Case]) {
    let (mut runs, mut outcomes) = (0, Vec::new());
    for case in all {
        for &of in with {
            if outcomes.len() == ENOUGH {
                break;
            }
            runs += 1;
            // The engine that takes over may find a promise broken.
            let planted = || defect.planted(|| run::<KnownBad>(case, of));
            let outcome = catch_unwind(AssertUnwindSafe(planted));
            outcomes.extend(outcome.unwrap_or_else(|_| Err("a broken promise".to_owned())).err());
        }
    }
    assert!(!outcomes.is_empty(), "{}: {} is not caught", defect.rule(), defect.title());
    let mut kinds = outcomes.clone();
    kinds.sort_unstable();
    kinds.dedup();
    let outcome = format!("caught in {}: {}", outcomes.len(), kinds.join("; "));
    let model = format!("known bad: {}", defect.title());
    let (first, last) = (with.first().map_or(0, |of| of.0), with.last().map_or(0, |of| of.0));
    let domains = format!("domains in rounds: {}, {first} to {last} processors", all.len());
    row(&model, &domains, &format!("{runs} runs"), &outcome);
}

#[test]
fn rounds_that_keep_all_rules_make_the_engines_mesh() {
    for case in &cases() {
        for of in RUNS {
            assert_eq!(run::<Correct>(case, of), Ok(()), "{of:?}");
        }
    }
    // One processor has nobody to wait for, but where slivers come after all else.
    for (kind, volume) in KINDS {
        let refiner = Refiner::new().max_volume(volume).min_dihedral(0.0).start(1);
        let case = &case_of(kind, refiner);
        let alone = Defect::NoBarrier.planted(|| run::<KnownBad>(case, (1, 1_000)));
        assert_eq!(alone, Ok(()));
    }
}

// Tests of their own for what takes long: processors of the machine share them. The domains are
// those on which the test above finds nothing.

#[test]
fn exchanges_with_a_broken_rule_are_caught() {
    let all = cases();
    caught(Defect::NamelessKeys, &all);
    caught(Defect::NoBarrier, &all);
    caught(Defect::KeyByName, &all);
}

#[test]
fn reservations_with_a_broken_rule_are_caught() {
    let all = cases();
    caught(Defect::DeafHome, &all);
    caught(Defect::StaleReservation, &all);
    caught(Defect::HastyProbe, &all);
}

/// Most of its runs do not end.
#[test]
fn equal_keys_are_caught() {
    caught(Defect::EqualKeys, &[case(KINDS[1].0, KINDS[1].1)]);
}

/// Of little is much found ahead.
#[test]
fn cavities_found_ahead_with_a_broken_rule_are_caught() {
    let fine = [case(DomainKind::CubeOctahedron, 7e-5)];
    for of in RUNS {
        assert_eq!(run::<Correct>(&fine[0], of), Ok(()), "{of:?}");
    }
    caught(Defect::RashChoice, &fine);
}

#[test]
fn labels_at_patches_with_a_broken_rule_are_caught() {
    let patched = [patched_case()];
    for of in RUNS {
        assert_eq!(run::<Correct>(&patched[0], of), Ok(()), "{of:?}");
    }
    caught(Defect::Unlabelled, &patched);
}

#[test]
fn refusals_with_a_broken_rule_are_caught() {
    let all = [
        angled_case(DomainKind::Wedge, 15.0, 3e-5),
        angled_case(DomainKind::Wedge, 5.0, 3e-5),
        angled_case(DomainKind::Spike, 15.0, 1e-3),
    ];
    for case in &all {
        for of in RUNS {
            assert_eq!(run::<Correct>(case, of), Ok(()), "{of:?}");
        }
    }
    caught(Defect::SilentKeeper, &all[..1]);
}

/// A ramp of sheets at a small angle, of which no facets are taken for one.
fn ramp_case() -> Case {
    let domain = surfaces::ramp(4, 0.05, 1e-8, 1);
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("a sound domain");
    let refiner = Refiner::new().flat_tolerance(0.0).max_volume(3e-4).start(64);
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    Case::new(&engine, ready, refiner, LONG)
}

/// A star with patches, of which some subfaces come to bar many tetrahedra.
fn star_case(arms: u32) -> Case {
    let domain = surfaces::star(arms, 1e-8, u64::from(arms));
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("a sound domain");
    let refiner = Refiner::new().flat_tolerance(5e-7).max_volume(3e-4).start(64);
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    Case::new(&engine, ready, refiner, LONG)
}

#[test]
fn blocks_with_a_broken_rule_are_caught() {
    let with = [(2, 1_000), (8, 1_000), (3, 30_000), (8, 30_000), (2, 100_000), (5, 100_000)];
    let all: Vec<Case> = (3..9).map(star_case).collect();
    for case in &all {
        for of in with {
            assert_eq!(run::<Correct>(case, of), Ok(()), "{of:?}");
        }
    }
    caught_in(&with, Defect::OwnBlocks, &all);
    caught_in(&with, Defect::LastingBlock, &all);
}

/// Two tetrahedra of one group are two workers' where parts are small.
#[test]
fn leaders_and_ranks_with_a_broken_rule_are_caught() {
    let all = [ramp_case()];
    for of in RUNS.into_iter().chain(MANY) {
        assert_eq!(run::<Correct>(&all[0], of), Ok(()), "{of:?}");
    }
    caught_in(&MANY, Defect::OwnLeader, &all);
    caught(Defect::LastingRank, &all);
}

/// Plates on each other, whose items wait for each other.
fn plates_case(base: [f64; 2], layers: &[u32], regions: bool) -> Case {
    let thicknesses: Vec<f64> = layers.iter().map(|&t| f64::from(t) / 64.0).collect();
    let domain = stack(base, &thicknesses, regions);
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let volume = base[0] * base[1] * thicknesses.iter().sum::<f64>();
    let refiner = Refiner::new().max_volume(volume / 5000.0).start(0);
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    assert!(engine.stats.joint_phases > 0, "no circles");
    Case::new(&engine, ready, refiner, LONG)
}

#[test]
fn circles_with_a_broken_rule_are_caught() {
    let all = [
        plates_case([3.0, 2.0], &[42, 6, 4], true),
        plates_case([1.0, 1.0], &[29, 1, 3], true),
        plates_case([1.0, 1.0], &[52, 54, 19, 27, 38, 22, 30, 55], true),
    ];
    for case in &all {
        for of in RUNS {
            assert_eq!(run::<Correct>(case, of), Ok(()), "{of:?}");
        }
    }
    caught(Defect::StingyLender, &all);
    caught(Defect::LeakyCircle, &all);
}

/// Plates in a box, all with patches: an item is refused for which no point does.
fn boxed_case(seed: u64, parts: f64) -> Case {
    let Plates { domain, volume } = plates(seed);
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(volume / parts).min_dihedral(0.0);
    let refiner = refiner.flat_tolerance(1e-6).start(0);
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    Case::new(&engine, ready, refiner, LONG)
}

#[test]
fn turns_with_a_broken_rule_are_caught() {
    let all = [boxed_case(119, 200.0)];
    for case in &all {
        for of in RUNS {
            assert_eq!(run::<Correct>(case, of), Ok(()), "{of:?}");
        }
    }
    caught(Defect::Nowhere, &all);
}
