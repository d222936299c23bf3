//! The real loop and step over the real mailbox on 8 to 16 threads, under shuttle: random
//! schedules, and schedules with few but well placed preemptions (PCT). Statistical, sequentially
//! consistent.
#![cfg(shuttle)]

use ltbw::balance::Balance;
use ltbw::protocol::Correct;
use ltbw_models::random::world_of;
use ltbw_models::report::{caught, is_deep, row};
use ltbw_models::threads::{Seen, run};
use ltbw_models::variants::{Defect, KnownBad};
use ltbw_models::world::World;
use shuttle::scheduler::{PctScheduler, RandomScheduler};
use shuttle::{Config, Runner};
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

/// Schedules of each world and scheduler.
const SCHEDULES: usize = 100;

/// Events that must happen.
const WITNESSES: [Seen; 6] =
    [Seen::Sleep, Seen::Batch, Seen::SetBack, Seen::Wait, Seen::Move, Seen::Ask];

/// Random worlds of 8 to 16 workers, without cancels: no thread could tell the others.
fn worlds() -> Vec<World> {
    let seeds = if is_deep() { 450 } else { 45 };
    let world = |seed| World { cancels: false, ..world_of(seed, 8 + seed as usize % 9) };
    (0..seeds).map(world).collect()
}

fn explore(name: &str, check: impl Fn(Box<dyn Fn() + Send + Sync>, u64)) {
    let seen = Arc::new(Mutex::new(BTreeSet::new()));
    let given = Arc::new(AtomicUsize::new(0));
    let worlds = worlds();
    let points: usize = worlds.iter().map(|world| world.all_points().count()).sum();
    let rounds = worlds.iter().filter(|world| world.second.is_some()).count();
    assert!(rounds > worlds.len() / 5, "few worlds with two rounds: {rounds}");
    for (seed, world) in (0_u64..).zip(&worlds) {
        // In every second world blocks move only because workers run out of points.
        let mut world = world.clone();
        let balance = seed.is_multiple_of(2).then(|| {
            world.moves.clear();
            Balance { low: 1, ask: 2, again: 1 }
        });
        let (record, given) = (seen.clone(), given.clone());
        let model = move || {
            let outcome = run::<Correct>(&world, balance);
            if balance.is_some() && outcome.contains(&Seen::Move) {
                given.fetch_add(1, Ordering::Relaxed);
            }
            record.lock().expect("no panic while locked").extend(outcome);
        };
        check(Box::new(model), seed);
    }
    let seen = seen.lock().expect("no panic while locked");
    for witness in WITNESSES {
        assert!(seen.contains(&witness), "never {witness:?}");
    }
    let given = given.load(Ordering::Relaxed);
    assert!(given > 0, "no block was ever given to a worker that asked");
    let all = worlds.len();
    let bounds = format!("8 to 16 threads, {all} worlds ({rounds} of two rounds), {points} points");
    let explored =
        format!("{} schedules, blocks given in {given}, seen: {seen:?}", SCHEDULES * all);
    row(name, &bounds, &explored, "all ends right");
}

#[test]
fn random_schedules() {
    explore("shuttle: random", |model, seed| {
        let scheduler = RandomScheduler::new_from_seed(seed, SCHEDULES);
        Runner::new(scheduler, Config::new()).run(model);
    });
}

#[test]
fn schedules_with_few_preemptions() {
    explore("shuttle: PCT, depth 3", |model, seed| {
        let scheduler = PctScheduler::new_from_seed(seed, 3, SCHEDULES);
        Runner::new(scheduler, Config::new()).run(model);
    });
}

/// Known bad.
#[test]
fn a_lost_wake_up_is_caught() {
    let world = World { cancels: false, ..world_of(1, 8) };
    let said = caught(|| {
        let scheduler = RandomScheduler::new_from_seed(1, 2_000);
        let runner = Runner::new(scheduler, Config::new());
        Defect::LostWakeUp.planted(|| runner.run(move || drop(run::<KnownBad>(&world, None))));
    });
    assert!(said.contains("deadlock"), "{said}");
    row("known bad: lost wake-up", "shuttle, 8 threads", "until it fails", "caught: deadlock");
}
