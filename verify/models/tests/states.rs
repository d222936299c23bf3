//! Every state of small worlds: safety, no deadlock, and liveness under weak fairness.
//!
//! Bounds: 2 to 4 workers, 1 to 3 cavities, 2 moves of blocks, one cancel per worker; every order
//! of deliveries and local work. Exhaustive within them.
#![cfg(not(any(loom, shuttle)))]

use ltbw::protocol::{Correct, Rule};
use ltbw_models::graph::{Components, Graph, Limits, tell};
use ltbw_models::report::{is_deep, row};
use ltbw_models::system::System;
use ltbw_models::world::{Network, World};
use ltbw_models::worlds;
use stateright::{Checker, Model};

fn bounds(world: &World) -> String {
    let moves = if world.moves.is_empty() {
        String::new()
    } else {
        format!(", {} moves", world.moves.len())
    };
    let order = match world.network {
        Network::Fifo => "fifo",
        Network::Unordered => "any order",
    };
    let (workers, points) = (world.workers(), world.all_points().count());
    format!("{workers} workers, {points} points{moves}, {order}, {}", world.rule)
}

fn explored(graph: &Graph, components: &Components) -> String {
    let (states, transitions) = (graph.states(), graph.transitions());
    let Components { cyclic, fair, .. } = components;
    let cap = if graph.complete { "" } else { " (not all)" };
    format!(
        "{states} states{cap}, {transitions} transitions, {cyclic} cyclic components, {fair} fair"
    )
}

/// Explores a world under the correct protocol.
fn explore(world: &World, states: usize) -> (Graph, Components) {
    let system = System::<Correct>::new(world.clone());
    let graph = Graph::explore(&system, Limits { states, first_fault: true });
    if let Some(&(state, what)) = graph.faults.first() {
        panic!("{}, {}: {what}\n{}", world.name, world.rule, tell(&system, &graph.way(state)));
    }
    if let Some(&state) = graph.deadlocks.first() {
        panic!("{}, {}: deadlock\n{}", world.name, world.rule, tell(&system, &graph.way(state)));
    }
    let components = graph.components();
    (graph, components)
}

/// Everything is explored, safe, ends, and shows what it must.
fn holds(world: &World) {
    let (graph, components) = explore(world, 3_000_000);
    if let Some(state) = components.example {
        let system = System::<Correct>::new(world.clone());
        panic!("{}: livelock\n{}", world.name, tell(&system, &graph.way(state)));
    }
    assert!(graph.complete, "{}: too large", world.name);
    for witness in &world.witnesses {
        assert!(graph.witnesses.contains(witness), "{}: never {}", world.name, witness.name());
    }
    row(world.name, &bounds(world), &explored(&graph, &components), "safe and live");
}

#[test]
fn wound_wait_is_safe_and_live() {
    worlds::contests().iter().for_each(holds);
}

/// The paper's rule: safe, never stuck, and not live in any contest. A backoff may end at any
/// time; what is shown is that its end times decide, not that a random choice fails.
#[test]
fn the_paper_s_rule_livelocks() {
    for world in worlds::contests().into_iter().filter(|w| is_deep() || w.name != "3-cycle") {
        let world = world.rule(Rule::Paper);
        let (graph, components) = explore(&world, 300_000);
        assert!(components.fair > 0, "{}: no livelock", world.name);
        row(world.name, &bounds(&world), &explored(&graph, &components), "safe, livelock found");
    }
}

#[test]
fn moves_tokens_and_cancels_are_safe_and_live() {
    worlds::journeys().iter().for_each(holds);
}

#[test]
#[ignore = "minutes: cargo xtask model-check runs it"]
fn larger_worlds_are_safe_and_live() {
    worlds::larger().iter().for_each(holds);
}

/// Cycles that need an unfair network are there, and are told from livelocks.
#[test]
fn unfair_cycles_are_no_livelocks() {
    let (_, components) = explore(&worlds::there_and_back(), 10_000);
    assert!(components.cyclic > 0 && components.fair == 0, "{components:?}");
}

/// Known bad: without order on the channels an abort overtakes the expand that it is about.
#[test]
fn channels_without_order_are_unsafe() {
    let world = worlds::same_two().network(Network::Unordered);
    let system = System::<Correct>::new(world.clone());
    let graph = Graph::explore(&system, Limits { states: 100_000, first_fault: true });
    let state = graph.deadlocks.first().or(graph.faults.first().map(|(state, _)| state));
    let way = graph.way(*state.expect("caught"));
    let outcome = format!("caught after {} steps", way.len());
    row("known bad: no order", &bounds(&world), &format!("{} states", graph.states()), &outcome);
}

/// stateright, with code of its own, finds the same number of states, no fault, no deadlock, and
/// all witnesses.
#[test]
fn stateright_agrees() {
    let worlds = worlds::contests().into_iter().chain(worlds::journeys());
    for world in worlds.filter(|w| is_deep() || w.name != "3-cycle" && w.name != "cancels") {
        let (graph, _) = explore(&world, 1_000_000);
        let checker = System::<Correct>::new(world.clone()).checker().spawn_bfs().join();
        checker.assert_properties();
        assert_eq!(checker.unique_state_count(), graph.states(), "{}", world.name);
        let properties = 3 + world.witnesses.len();
        let explored = format!("{} states, {properties} properties", checker.unique_state_count());
        row(&format!("stateright: {}", world.name), &bounds(&world), &explored, "hold");
    }
}

/// The coordinates make the patterns that the names promise.
#[test]
fn cavities_have_the_stated_patterns() {
    assert_eq!(worlds::same_two().cavities(), [[0, 1], [0, 1]]);
    assert_eq!(worlds::two_on_three().cavities(), [[1, 2, 0], [1, 2, 0]]);
    assert_eq!(worlds::three_cycle().cavities(), [[0, 1, 0], [1, 1, 2], [2, 2, 0]]);
    assert_eq!(worlds::three_rings().cavities(), [[0, 1], [1, 2], [2, 0]]);
    assert_eq!(worlds::three_on_two().cavities(), [[0, 1, 0]; 3]);
    assert_eq!(worlds::three_on_all().cavities(), [[1, 2, 0]; 3]);
    assert_eq!(worlds::asked_again().cavities(), [vec![1, 0, 2], vec![2], vec![3]]);
}
