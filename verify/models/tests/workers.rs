//! The real loop of a worker and the real step over the real mailbox, on 2 threads under loom:
//! every interleaving with at most the given number of preemptions.
#![cfg(loom)]

use ltbw::protocol::Correct;
use ltbw_models::report::{caught, is_deep, row};
use ltbw_models::threads::{Seen, run};
use ltbw_models::variants::{Defect, KnownBad, Variant};
use ltbw_models::world::World;
use ltbw_models::worlds;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

/// Runs `world` with at most `preemptions`; returns what happened in some execution, and how many
/// executions there were.
fn explore<C: Variant>(world: World, preemptions: usize) -> (BTreeSet<Seen>, usize) {
    let seen = Arc::new(Mutex::new((BTreeSet::new(), 0)));
    let record = seen.clone();
    let mut builder = loom::model::Builder::new();
    builder.preemption_bound = Some(preemptions);
    builder.max_branches = 20_000;
    builder.check(move || {
        let outcome = run::<C>(&world, None);
        let mut record = record.lock().expect("no panic while locked");
        record.0.extend(outcome);
        record.1 += 1;
    });
    let seen = seen.lock().expect("no panic while locked");
    (seen.0.clone(), seen.1)
}

fn holds(world: World, preemptions: usize, least: usize, witnesses: &[Seen]) {
    let name = world.name;
    let bounds =
        format!("2 threads, {} points, {preemptions} preemptions", world.all_points().count());
    let (seen, executions) = explore::<Correct>(world, preemptions);
    let explored = format!("{executions} executions, seen: {seen:?}");
    for witness in witnesses {
        assert!(seen.contains(witness), "never {witness:?}: {explored}");
    }
    assert!(executions >= least, "{explored}");
    row(&format!("loom: workers, {name}"), &bounds, &explored, "all ends right");
}

/// The tiny combined model: one cavity at both workers.
#[test]
fn one_cavity() {
    let preemptions = if is_deep() { 5 } else { 3 };
    holds(worlds::one_on_two(), preemptions, 1_000, &[Seen::Sleep]);
}

/// Two cavities that both workers contest.
#[test]
fn two_cavities() {
    let preemptions = if is_deep() { 5 } else { 3 };
    let witnesses = [Seen::Sleep, Seen::Wait, Seen::SetBack];
    holds(worlds::token_same_two(), preemptions, 2_500, &witnesses);
}

/// Two rounds, each with questions, a barrier, points, and a barrier in two waves.
#[test]
fn two_rounds() {
    let preemptions = if is_deep() { 4 } else { 2 };
    holds(worlds::rounds_on_two(), preemptions, 500, &[Seen::Sleep, Seen::Batch]);
}

/// Known bad: a worker sleeps for ever, because a wake-up was lost or because a lock was leaked.
fn hangs(defect: Defect, world: World) {
    let bounds = format!("loom, 2 threads, {}", world.name);
    let said = caught(|| drop(defect.planted(|| explore::<KnownBad>(world, 2))));
    assert!(said.contains("deadlock"), "{}: {said}", defect.title());
    row(&format!("known bad: {}", defect.title()), &bounds, "until it fails", "caught: deadlock");
}

#[test]
fn a_lost_wake_up_hangs_the_workers() {
    hangs(Defect::LostWakeUp, worlds::one_on_two());
}

#[test]
fn a_leaked_lock_hangs_the_workers() {
    hangs(Defect::LeakyRollback, worlds::token_same_two());
}
