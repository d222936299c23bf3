//! Every known-bad variant is caught, and the correct protocol passes where it is caught. The
//! mailbox's variants are in `tests/mailbox.rs` (loom).
#![cfg(not(any(loom, shuttle)))]

use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Config, Correct, Rules};
use ltbw::refine::Refiner;
use ltbw::refining::{Plan, RefineError, simulate_domain_as};
use ltbw::simulate::{MeshError, Network, Options, RandomMigrations, SimulationError, simulate_as};
use ltbw::{Builder, MeshHash, PointSet};
use ltbw_generate::{DomainKind, PointKind, Shape, generate, generate_domain};
use ltbw_models::graph::{Graph, Limits};
use ltbw_models::random::world;
use ltbw_models::report::row;
use ltbw_models::runs::{Outcome, run};
use ltbw_models::system::System;
use ltbw_models::variants::{Defect, KnownBad};
use ltbw_models::world::World;
use ltbw_models::worlds;

/// The way in which a variant shows itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Caught {
    Deadlock,
    Fault(&'static str),
}

/// A defect is caught in `world` as `expected`, at the nearest state; the correct protocol is not.
fn caught(defect: Defect, world: World, expected: Caught) {
    let sound = System::<Correct>::new(world.clone());
    let sound = Graph::explore(&sound, Limits { states: 1_000_000, first_fault: true });
    assert!(sound.complete && sound.faults.is_empty() && sound.deadlocks.is_empty());

    let system = System::<KnownBad>::new(world.clone());
    let limits = Limits { states: 1_000_000, first_fault: true };
    let graph = defect.planted(|| Graph::explore(&system, limits));
    let (state, found) = match (graph.faults.first(), graph.deadlocks.first()) {
        (Some(&(state, what)), _) => (state, Caught::Fault(what)),
        (None, Some(&state)) => (state, Caught::Deadlock),
        (None, None) => panic!("{} is not caught in {}", defect.title(), world.name),
    };
    assert_eq!(found, expected, "{}", defect.title());
    let outcome = format!("caught: {found:?} after {} steps", graph.way(state).len());
    let bounds = format!("{}, {}", world.name, world.rule);
    row(
        &format!("known bad: {}", defect.title()),
        &bounds,
        &format!("{} states", graph.states()),
        &outcome,
    );
}

#[test]
fn closure_ring_not_locked() {
    caught(Defect::BareCavity, worlds::three_on_all(), Caught::Fault("P9 is broken"));
}

#[test]
fn rollback_leaks_a_lock() {
    caught(Defect::LeakyRollback, worlds::same_two(), Caught::Fault("P5 is broken"));
}

#[test]
fn rollback_forgets_the_queue() {
    caught(Defect::ForgetfulRollback, worlds::same_two(), Caught::Fault("P7 is broken"));
}

#[test]
fn naive_regrant() {
    caught(Defect::NaiveRegrant, worlds::three_on_all(), Caught::Fault("P7 is broken"));
}

#[test]
fn new_wants_above_the_one_waited_for() {
    caught(Defect::LostPlace, worlds::asked_again(), Caught::Fault("P7 is broken"));
}

#[test]
fn restart_before_the_releases_are_acknowledged() {
    caught(Defect::HastyRestart, worlds::there_and_back(), Caught::Fault("P8 is broken"));
}

#[test]
fn wound_after_commit_obeyed() {
    let fault = Caught::Fault("P8 is broken");
    caught(Defect::LateWound, worlds::three_on_all(), fault);
}

#[test]
fn safra_without_blackening() {
    caught(Defect::WhiteSafra, worlds::one_far_point(), Caught::Fault("stopped too early"));
}

#[test]
fn migration_by_an_idle_worker() {
    caught(Defect::IdleMigration, worlds::token_move(), Caught::Fault("stopped too early"));
}

#[test]
fn missing_forward_pointer() {
    let (lost, wrong) = ("P9 is broken", "the mesh is wrong at the end");
    caught(Defect::NoForwarding, worlds::swap(), Caught::Fault(lost));
    caught(Defect::NoForwarding, worlds::slots_again(), Caught::Fault(wrong));
}

#[test]
fn waiters_not_moved() {
    caught(Defect::LeftWaiters, worlds::late_elsewhere(), Caught::Deadlock);
}

#[test]
fn stale_interface_handle() {
    let links = Caught::Fault("P9 is broken");
    caught(Defect::StaleInterface, worlds::same_two(), links);
}

#[test]
fn reused_slot_without_generation() {
    let twice = Caught::Fault("P2 is broken");
    caught(Defect::ReusedName, worlds::slots_again(), twice);
}

#[test]
fn cancelled_worker_takes_in_moved_points() {
    let fault = Caught::Fault("a cancelled worker has points");
    caught(Defect::RestlessCancel, worlds::cancels_with_a_move(), fault);
}

/// The variant of barriers that the model of two rounds alone catches: a commit is under way, and
/// the counts fit by chance.
#[test]
fn one_wave_ends_a_round() {
    let early = Caught::Fault("an operation while a worker chooses");
    caught(Defect::OneWave, worlds::rounds_on_three(), early);
}

#[test]
fn decided_before_all_is_reserved() {
    let early = Caught::Fault("an operation while a worker chooses");
    caught(Defect::NoBarrier, worlds::rounds_on_two(), early);
}

#[test]
fn expand_before_installation_not_held() {
    let lost = Caught::Fault("a ring cell is not here");
    caught(Defect::ImpatientExpand, worlds::late_installation(), lost);
}

/// The real mesh on simulated processors while blocks move. The network takes 10 µs: 20 ms without
/// an insertion, while some worker has work, are a wait for ever.
fn in_a_storm<C: Rules>(set: &PointSet, layout: &Layout, seed: u64) -> Result<MeshHash, MeshError> {
    let storm = Some(RandomMigrations { every: 20_000 });
    let options = Options { seed, storm, patience: 20_000_000, ..Options::default() };
    let meshed = simulate_as::<C>(set, layout, Config::new(layout.workers), &options)?;
    Ok(meshed.gathered.mesh.hash().expect("a hash"))
}

/// The abstract mesh has nothing that a worker takes for its own without asking; the real one has.
#[test]
fn block_that_left_taken_for_ones_own() {
    let (points, workers, seeds) = (3000, 3, 8);
    let set = PointSet::new(generate(PointKind::Clusters, points, 2)).expect("finite points");
    let expected = Builder::new().build(&set).expect("a mesh").mesh.hash().expect("a hash");
    let layout = Layout { blocks_per_worker: 48, ..Layout::new(points, workers) };
    let mut stuck = 0;
    for seed in 0..seeds {
        assert_eq!(in_a_storm::<Correct>(&set, &layout, seed), Ok(expected), "seed {seed}");
        match Defect::KeptHome.planted(|| in_a_storm::<KnownBad>(&set, &layout, seed)) {
            Err(MeshError::Simulation(SimulationError::NoProgress { .. })) => stuck += 1,
            other => assert_eq!(other, Ok(expected), "seed {seed}"),
        }
    }
    assert!(stuck > 0, "{} is not caught", Defect::KeptHome.title());
    let model = format!("known bad: {}", Defect::KeptHome.title());
    let bounds = format!("{points} points, {workers} processors, blocks move");
    let outcome = format!("caught: no progress in {stuck}");
    row(&model, &bounds, &format!("{seeds} simulated runs"), &outcome);
}

/// The points that 12 processors with 300 µs between them make of the paper's cube and octahedron,
/// with the number of events; `Err` if they need more than `most`.
fn refined<C: Rules>(ready: &Prepared, most: u64) -> Result<(usize, u64), RefineError> {
    let plan = |points| {
        let layout = Layout { ownership: Ownership::Newest, ..Layout::new(points, 12) };
        Plan { layout, config: Config { window: 32, ..Config::new(12) } }
    };
    let network = Network { latency: 300_000, ..Network::default() };
    let options = Options { network, max_events: most, ..Options::default() };
    let refiner = Refiner::new().max_volume(1e-4).start(0);
    let (domain, lattice) = (&ready.domain, &ready.lattice);
    let run = simulate_domain_as::<C>(&refiner, domain, lattice, plan, &options)?;
    Ok((run.refined.mesh().num_vertices(), run.events))
}

/// The point of a tetrahedron that is gone takes apart what others have locked, or lies next to a
/// vertex: a worker fails, or the run does not end.
#[test]
fn point_inserted_though_its_item_is_gone() {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let (points, events) = refined::<Correct>(&ready, 5_000_000).expect("a run ends");
    let found = match Defect::Obstinate.planted(|| refined::<KnownBad>(&ready, 4 * events)) {
        Err(RefineError::Simulation(error)) => error.to_string(),
        other => panic!("not caught: {other:?}"),
    };
    let model = format!("known bad: {}", Defect::Obstinate.title());
    let bounds = format!("a domain of {points} points refined by 12 processors");
    row(&model, &bounds, "1 simulated run", &format!("caught: {found}"));
}

/// Defects that random runs find.
const HUNTED: [Defect; 13] = [
    Defect::LostPlace,
    Defect::BareCavity,
    Defect::LeakyRollback,
    Defect::ForgetfulRollback,
    Defect::NaiveRegrant,
    Defect::HastyRestart,
    Defect::LateWound,
    Defect::WhiteSafra,
    Defect::NoForwarding,
    Defect::StaleInterface,
    Defect::ReusedName,
    Defect::ImpatientExpand,
    Defect::RestlessCancel,
];

/// Random runs find the variants too: what they say about sizes that cannot be explored is worth
/// something.
#[test]
fn random_runs_catch_the_variants() {
    let mut seeds = Vec::new();
    for defect in HUNTED {
        let is_wrong = |seed: u64| {
            let system = System::<KnownBad>::new(world(seed));
            run(&system, seed, 20_000).0 != Outcome::Done
        };
        let seed = defect.planted(|| (0..5_000).find(|&seed| is_wrong(seed)));
        let title = defect.title();
        let seed = seed.unwrap_or_else(|| panic!("{title}: no random run catches it"));
        seeds.push(format!("{title} {}", seed + 1));
    }
    println!("seeds needed: {}", seeds.join(", "));
}
