//! Workers over a small mesh, run event by event, for `protocol/` and `interleavings/`.

use crate::letters::{self, Written};
use crate::quiet::quietly;
use ltbw::balance::Workload;
use ltbw::protocol::{
    Action, BlockId, Correct, Event, Message, Rule, Source, Ticket, Worker, WorkerId,
};
use ltbw_models::variants::Variant;
use ltbw_tests::families::Rng;
use serde_json::{Value, json};
use std::collections::{BTreeMap, VecDeque};

/// The start of a run: workers with their cells and points.
pub trait Start: Clone {
    /// The mesh of workers that obey C.
    type Mesh<C: Variant>: Written + Clone;
    /// Their points.
    type Points<C: Variant>: Source<Self::Mesh<C>> + Workload + Clone;

    /// The workers.
    fn workers<C: Variant>(&self) -> Vec<Node<Self, C>>;

    /// The operation of the kit, and the start as its cases have it.
    fn json(&self) -> (&'static str, Value);

    /// The conflict rule.
    fn rule(&self) -> Rule;

    /// Tests the mesh at the end of a correct run.
    ///
    /// # Panics
    /// If it is not the right one.
    fn certify(&self, workers: &[Node<Self, Correct>]);
}

/// A worker.
pub type Node<T, C> = Worker<<T as Start>::Mesh<C>, <T as Start>::Points<C>, C>;
/// A message.
pub type Mail<T, C> = Message<<T as Start>::Mesh<C>>;
/// The actions of a step.
pub type Actions<T, C> = Vec<Action<<T as Start>::Mesh<C>>>;

/// The next event of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // as in `Event`
pub enum Turn {
    Work(WorkerId),
    /// The first message under way on this pair arrives.
    Deliver {
        from: WorkerId,
        to: WorkerId,
    },
    Migrate {
        worker: WorkerId,
        block: BlockId,
        to: WorkerId,
    },
    Retry(WorkerId, Ticket),
    Cancel(WorkerId),
}

impl Turn {
    /// As the kit's cases have it.
    #[must_use]
    pub fn json(self) -> Value {
        match self {
            Self::Work(w) => json!({"worker": w, "event": "work"}),
            Self::Deliver { from, to } => json!({"worker": to, "event": "deliver", "from": from}),
            Self::Migrate { worker, block, to } => {
                json!({"worker": worker, "event": "migrate", "block": block, "to": to})
            }
            Self::Retry(w, ticket) => {
                json!({"worker": w, "event": "retry", "ticket": letters::ticket(ticket)})
            }
            Self::Cancel(w) => json!({"worker": w, "event": "cancel"}),
        }
    }

    /// The worker to which it happens.
    #[must_use]
    pub fn worker(self) -> WorkerId {
        match self {
            Self::Deliver { to: w, .. }
            | Self::Migrate { worker: w, .. }
            | Self::Work(w)
            | Self::Retry(w, _)
            | Self::Cancel(w) => w,
        }
    }
}

/// Workers and the messages between them.
#[derive(Clone)]
pub struct World<T: Start, C: Variant> {
    /// The workers.
    pub workers: Vec<Node<T, C>>,
    /// Messages under way, by sender and receiver.
    pub channels: BTreeMap<(WorkerId, WorkerId), VecDeque<Mail<T, C>>>,
    resting: Vec<(WorkerId, Ticket)>,
}

impl<T: Start, C: Variant> World<T, C> {
    /// The world at the start.
    pub fn new(start: &T) -> Self {
        Self { workers: start.workers(), channels: BTreeMap::new(), resting: Vec::new() }
    }

    /// The actions of a turn; `None` if there is no such message or operation, or if a step of a
    /// known-bad variant breaks an invariant: its run ends there.
    pub fn turn(&mut self, turn: Turn) -> Option<Actions<T, C>> {
        let worker = turn.worker();
        let event = match turn {
            Turn::Work(_) => Event::Work,
            Turn::Deliver { from, to } => {
                let message = self.channels.get_mut(&(from, to))?.pop_front()?;
                Event::Message { from, message }
            }
            Turn::Migrate { block, to, .. } => Event::Migrate { block, to },
            Turn::Retry(w, ticket) => {
                let at = self.resting.iter().position(|&rest| rest == (w, ticket))?;
                self.resting.swap_remove(at);
                Event::Retry(ticket)
            }
            Turn::Cancel(_) => Event::Cancel,
        };
        let mut out = Vec::new();
        let node = &mut self.workers[worker.index()];
        quietly(|| node.step(event, &mut out))?;
        for action in &out {
            match action {
                Action::Send { to, message } => {
                    self.channels.entry((worker, *to)).or_default().push_back(message.clone());
                }
                Action::Backoff { ticket, .. } => self.resting.push((worker, *ticket)),
                Action::Note(_) => {}
            }
        }
        Some(out)
    }

    /// The events that can happen.
    #[must_use]
    pub fn choices(&self) -> Vec<Turn> {
        let open = self.channels.iter().filter(|(_, queue)| !queue.is_empty());
        let deliver = open.map(|(&(from, to), _)| Turn::Deliver { from, to });
        let busy = self.workers.iter().filter(|w| w.has_work()).map(|w| Turn::Work(w.id()));
        let retry = self.resting.iter().map(|&(w, ticket)| Turn::Retry(w, ticket));
        deliver.chain(busy).chain(retry).collect()
    }

    /// One of these events, or in place of it a move of a block, a cancel.
    pub fn draw(&self, moves: &mut u64, cancels: bool, random: &mut Rng) -> Option<Turn> {
        let choices = self.choices();
        let turn = *choices.get(random.below(choices.len().max(1) as u64) as usize)?;
        let workers = self.workers.len() as u64;
        let mut worker = || WorkerId::at(random.below(workers) as usize);
        let pair = [worker(), worker()];
        if *moves > 0 && random.below(6) == 0 {
            *moves -= 1;
            let blocks = self.workers[0].directory().blocks();
            let block = BlockId::at(random.below(blocks.len() as u64) as usize);
            return Some(Turn::Migrate { worker: pair[0], block, to: pair[1] });
        }
        Some(if cancels && random.below(16) == 0 { Turn::Cancel(pair[0]) } else { turn })
    }

    /// The state: cells by worker, and which workers have stopped.
    fn state(&self) -> Value {
        let cells: Vec<_> = self.workers.iter().map(|w| w.mesh().cells()).collect();
        let stopped: Vec<bool> = self.workers.iter().map(Worker::is_stopped).collect();
        json!({"cells": cells, "stopped": stopped})
    }
}

/// A run: what happened, the actions of each turn, the state after it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    pub(super) turns: Vec<Turn>,
    pub(super) steps: Vec<Value>,
    pub(super) state: Value,
}

/// The actions of a step as the kit has them.
fn written<T: Start, C: Variant>(actions: &Actions<T, C>) -> Value {
    actions.iter().filter_map(letters::action).collect()
}

/// Replays `turns` under the rules C, as far as it goes.
pub(super) fn replay<T: Start, C: Variant>(start: &T, turns: &[Turn]) -> Run {
    let mut world = World::<T, C>::new(start);
    let mut steps = Vec::new();
    for &turn in turns {
        let Some(actions) = world.turn(turn) else { break };
        steps.push(written::<T, C>(&actions));
    }
    Run { turns: turns[..steps.len()].to_vec(), steps, state: world.state() }
}

/// Events that may happen in a run beside messages.
#[derive(Clone, Copy, Default)]
pub(super) struct Chances {
    /// The number of blocks that may move.
    pub(super) moves: u64,
    /// May workers be cancelled?
    pub(super) cancels: bool,
}

/// A run of the correct protocol that begins with these turns and goes on at random; `None` if it
/// has more than `longest` events.
pub(super) fn play<T: Start>(
    start: &T,
    first: &[Turn],
    Chances { mut moves, cancels }: Chances,
    longest: usize,
    random: &mut Rng,
) -> Option<Run> {
    let mut world = World::<T, Correct>::new(start);
    let (mut turns, mut steps) = (Vec::new(), Vec::new());
    for k in 0..longest {
        let turn = first.get(k).copied();
        let Some(turn) = turn.or_else(|| world.draw(&mut moves, cancels, random)) else {
            assert!(world.workers.iter().all(|w| w.is_stopped() && w.is_quiescent()));
            if !turns.iter().any(|turn| matches!(turn, Turn::Cancel(_))) {
                start.certify(&world.workers);
            }
            return Some(Run { turns, steps, state: world.state() });
        };
        let actions = world.turn(turn)?;
        turns.push(turn);
        steps.push(written::<T, Correct>(&actions));
    }
    None
}

/// The run goes on by the first choice each time, to the end.
pub(super) fn to_the_end<T: Start>(start: &T, mut turns: Vec<Turn>) -> Run {
    let mut world = World::<T, Correct>::new(start);
    for &turn in &turns {
        world.turn(turn);
    }
    // Ends: the first choice is a delivery where there is one, and every run of the protocol ends.
    while let Some(&turn) = world.choices().first() {
        world.turn(turn);
        turns.push(turn);
    }
    replay::<T, Correct>(start, &turns)
}

/// The first step at which two runs of the same turns differ.
pub(super) fn differs(sound: &Run, broken: &Run) -> Option<usize> {
    let pairs = sound.steps.iter().zip(&broken.steps);
    let first = pairs.take_while(|(a, b)| a == b).count();
    (first < sound.steps.len() || sound.state != broken.state).then_some(first)
}
