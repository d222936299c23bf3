//! Random runs: one seed is one run.

use crate::random::Rng;
use crate::system::{Choice, System};
use crate::variants::Variant;
use ltbw::protocol::WorkerId;

/// The end of a random run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Everything was inserted, and right.
    Done,
    /// Nothing could happen any more.
    Deadlock,
    /// No end in sight.
    Endless,
    /// Something was wrong.
    Fault(&'static str),
}

/// Runs `system` by choices drawn from `seed`, one worker possibly slower than the others, for
/// `limit` steps at most; returns how it ended and after which choices.
pub fn run<C: Variant>(system: &System<C>, seed: u64, limit: usize) -> (Outcome, Vec<Choice>) {
    let mut rng = Rng(seed);
    let mut state = system.initial();
    let mut way = Vec::new();
    let slow = WorkerId::at(rng.below(2 * system.world.workers() as usize));
    while way.len() < limit {
        let choices = system.choices(&state);
        if choices.is_empty() {
            let outcome = match state.fault {
                Some(what) => Outcome::Fault(what),
                None if system.is_final(&state) => Outcome::Done,
                None => Outcome::Deadlock,
            };
            return (outcome, way);
        }
        let mut choice = choices[rng.below(choices.len())];
        if matches!(choice, Choice::Deliver(_, at, _) | Choice::Work(at) if at == slow)
            || matches!(choice, Choice::Cancel(_)) && !rng.once_in(16)
        {
            choice = choices[rng.below(choices.len())];
        }
        state = system.after(&state, choice);
        way.push(choice);
    }
    (Outcome::Endless, way)
}
