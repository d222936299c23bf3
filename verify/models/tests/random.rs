//! Random runs of random worlds: up to 6 workers, 18 blocks, 14 cavities, 7 moves. Statistical.
#![cfg(not(any(loom, shuttle)))]

use ltbw::protocol::Correct;
use ltbw_models::graph::tell;
use ltbw_models::random::world;
use ltbw_models::report::{is_deep, row};
use ltbw_models::runs::{Outcome, run};
use ltbw_models::system::System;

#[test]
fn random_runs_end_with_the_right_mesh() {
    let seeds = if is_deep() { 200_000 } else { 10_000 };
    let (mut steps, mut longest, mut points, mut rounds) = (0, 0, 0, 0);
    for seed in 0..seeds {
        let system = System::<Correct>::new(world(seed));
        let (outcome, way) = run(&system, seed, 100_000);
        if outcome != Outcome::Done {
            let end = &way[..way.len().min(2_000)];
            panic!("seed {seed}: {outcome:?}\n{:?}\n{}", system.world, tell(&system, end));
        }
        steps += way.len();
        longest = longest.max(way.len());
        points += system.world.all_points().count();
        rounds += u64::from(system.world.second.is_some());
    }
    assert!(steps as u64 > 50 * seeds, "worlds are too small: {steps} steps");
    assert!(rounds > seeds / 5, "few worlds with two rounds: {rounds}");
    let explored = format!(
        "{seeds} runs ({rounds} of two rounds), {points} points, {steps} steps, longest {longest}"
    );
    row("random worlds", "up to 6 workers, 14 cavities, 7 moves", &explored, "all right");
}
