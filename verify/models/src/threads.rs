//! Workers on threads: the real mailbox, the real loop and the real step, under loom or shuttle.
//!
//! The [`RuntimeHooks`] alone are of the models: they have no clock (a backoff is over at once, and
//! no rule with one runs here), orders the moves of the world, and notes what happens.

use crate::hull::Hull;
use crate::variants::Variant;
use crate::world::{Node, Points, World};
use ltbw::balance::Balance;
use ltbw::mailbox::{Endpoint, Received, connect_as};
use ltbw::metrics::Nanos;
use ltbw::protocol::{Action, Attempt, BlockId, Event, Note, WorkerId};
use ltbw::threads::{Ended, Loop, RuntimeHooks};
use ltbw::transport::{Mail, Transport};
use std::collections::BTreeSet;
use std::time::Duration;

/// A failed model unwinds threads that are asleep, when its locks are gone already: endpoints,
/// which would lock in their destructor, are leaked then.
pub use std::mem::ManuallyDrop as Kept;

#[cfg(loom)]
use loom::thread;
#[cfg(shuttle)]
use shuttle::thread;

/// Rounds of a worker's loop after which it lets the others run.
const PATIENCE: u32 = 64;

/// An event of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Seen {
    /// A worker slept, or tried to.
    Sleep,
    /// One look at the mailbox found two messages or more.
    Batch,
    /// An operation was set back.
    SetBack,
    /// A request waited for a lock.
    Wait,
    /// A block was given away.
    Move,
    /// A worker asked for blocks.
    Ask,
}

/// The way of a worker, see [`Kept`].
struct Way<C: Variant>(Kept<Endpoint<Mail<Hull<C>>, C>>);

impl<C: Variant> Transport<Mail<Hull<C>>> for Way<C> {
    fn send(&mut self, to: WorkerId, mail: Mail<Hull<C>>) {
        Transport::send(&mut *self.0, to, mail);
    }

    fn flush(&mut self) {
        Transport::flush(&mut *self.0);
    }

    fn take(&mut self, into: &mut Vec<Received<Mail<Hull<C>>>>) {
        Transport::take(&mut *self.0, into);
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        Transport::wait(&mut *self.0, timeout);
    }

    fn failed(&self) -> Option<WorkerId> {
        Transport::failed(&*self.0)
    }

    fn fail(&mut self) {
        Transport::fail(&mut *self.0);
    }
}

/// A worker's hooks.
struct Notes {
    seen: BTreeSet<Seen>,
    /// Moves to order, the next one last.
    moves: Vec<(BlockId, WorkerId)>,
    rounds: u32,
}

impl<C: Variant> RuntimeHooks<Hull<C>> for Notes {
    const BURST: usize = 2;

    fn now(&mut self) -> Nanos {
        0
    }

    fn until(&mut self, _: Nanos) -> Option<Duration> {
        None
    }

    fn backoff(&mut self, _: Attempt) -> Nanos {
        0
    }

    fn order(&mut self, may_move: impl Fn(BlockId) -> bool) -> Option<Event<Hull<C>>> {
        let (block, to) = self.moves.pop_if(|&mut (block, _)| may_move(block))?;
        Some(Event::Migrate { block, to })
    }

    fn poll_interval(&self) -> Option<Duration> {
        None
    }

    fn polled(&mut self, found: usize) {
        if found > 1 {
            self.seen.insert(Seen::Batch);
        }
        // PCT by itself starves threads of low priority while waves or a walk go round
        // among the others.
        self.rounds += 1;
        if self.rounds.is_multiple_of(PATIENCE) {
            thread::yield_now();
        }
    }

    fn ended(&mut self, actions: &[Action<Hull<C>>]) {
        for action in actions {
            let seen = match action {
                Action::Note(Note::SetBack { .. }) => Seen::SetBack,
                Action::Note(Note::Waits(_)) => Seen::Wait,
                Action::Note(Note::Migrated(_)) => Seen::Move,
                _ => continue,
            };
            self.seen.insert(seen);
        }
    }

    fn sent(&mut self, asked: usize) {
        if asked > 0 {
            self.seen.insert(Seen::Ask);
        }
    }

    fn sleeps(&mut self) {
        self.seen.insert(Seen::Sleep);
    }
}

type Worked<C> = Loop<Hull<C>, Points, C, Way<C>, Notes>;

/// Runs a worker until it is stopped.
fn work<C: Variant>(worker: Worked<C>) -> (Node<C>, BTreeSet<Seen>) {
    // Nobody fails here: a panic ends the model.
    let Ok(Ended { node, way, hooks }) = worker.run() else { panic!("a worker failed") };
    drop(Kept::into_inner(way.0));
    (node, hooks.seen)
}

/// Runs `world`, one thread per worker, and checks its end. Worker 0 runs on the caller's thread.
/// With a `balance` workers that run out of points ask others for blocks.
///
/// # Panics
/// If the end is wrong, naming what is.
pub fn run<C: Variant>(world: &World, balance: Option<Balance>) -> BTreeSet<Seen> {
    let ends = connect_as::<Mail<Hull<C>>, C>(world.workers());
    let moves: Vec<_> = world.moves.iter().rev().copied().collect();
    let mut loops = world.nodes::<C>().into_iter().zip(ends).map(|(node, end)| {
        let notes = Notes { seen: BTreeSet::new(), moves: moves.clone(), rounds: 0 };
        Worked::new(node, world.workers(), Way(Kept::new(end)), notes, balance)
    });
    let first = loops.next();
    let others: Vec<_> = loops.map(|worker| thread::spawn(move || work(worker))).collect();
    let mut done: Vec<_> = first.map(work).into_iter().collect();
    done.extend(others.into_iter().map(|thread| thread.join().expect("workers do not panic")));
    let nodes: Vec<&Node<C>> = done.iter().map(|(node, _)| node).collect();
    if let Some(what) = world.fault_at_end(&nodes, false) {
        panic!("{what}");
    }
    done.into_iter().flat_map(|(_, seen)| seen).collect()
}
