//! Workers on threads: the real mailbox and the real step, under loom or shuttle.
//!
//! The loop is that of the thread runtime, in the same order: take, answer, work, flush, sleep.
//! It has no clock: no rule with a backoff runs here.

use crate::hull::{Hull, Letter};
use crate::museum::Exhibit;
use crate::world::{Node, World};
use ltbw::mailbox::{Endpoint, connect_as};
use ltbw::protocol::{Action, Event, Note};
use std::collections::BTreeSet;

/// A failed model unwinds threads that are asleep, when its locks are gone already: endpoints,
/// which would lock in their destructor, are leaked then.
pub use std::mem::ManuallyDrop as Kept;

#[cfg(loom)]
use loom::thread;
#[cfg(shuttle)]
use shuttle::thread;

/// Units of local work between two looks at the mailbox.
const BURST: usize = 2;

/// Rounds of a worker's loop after which it lets the others run.
const PATIENCE: u32 = 64;

/// What happened in a run.
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
}

/// Runs a worker until it is stopped.
fn work<C: Exhibit>(
    mut node: Node<C>,
    end: Endpoint<Letter<C>, C>,
    moves: &[(u32, u32)],
) -> (Node<C>, BTreeSet<Seen>) {
    let mut end = Kept::new(end);
    let mut seen = BTreeSet::new();
    let (mut inbox, mut actions) = (Vec::new(), Vec::new());
    let mut moves = moves.iter().copied().peekable();
    let mut rounds = 0;
    // Ends: the protocol does, if every thread runs at last. PCT by itself starves threads of low
    // priority while the token or a walk goes round among the others.
    while !node.is_stopped() {
        rounds += 1;
        if rounds % PATIENCE == 0 {
            thread::yield_now();
        }
        let heard = end.try_take(&mut inbox);
        if heard > 1 {
            seen.insert(Seen::Batch);
        }
        let mut events: Vec<Event<Hull<C>>> =
            inbox.drain(..).map(|(from, message)| Event::Message { from, message }).collect();
        if let Some((block, to)) = moves.next_if(|&(block, _)| node.can_migrate(block)) {
            events.push(Event::Migrate { block, to });
        }
        let mut worked = false;
        for event in events {
            step(&mut node, event, &mut end, &mut actions, &mut seen);
        }
        for _ in 0..BURST {
            if node.has_work() {
                worked = true;
                step(&mut node, Event::Work, &mut end, &mut actions, &mut seen);
            }
        }
        end.flush();
        if heard == 0 && !worked && !node.is_stopped() {
            seen.insert(Seen::Sleep);
            end.wait();
        }
    }
    drop(Kept::into_inner(end));
    (node, seen)
}

fn step<C: Exhibit>(
    node: &mut Node<C>,
    event: Event<Hull<C>>,
    end: &mut Endpoint<Letter<C>, C>,
    actions: &mut Vec<Action<Hull<C>>>,
    seen: &mut BTreeSet<Seen>,
) {
    node.step(event, actions);
    for action in actions.drain(..) {
        match action {
            Action::Send { to, message } => end.send(to, message),
            Action::Note(Note::SetBack { .. }) => drop(seen.insert(Seen::SetBack)),
            Action::Note(Note::Waits(_)) => drop(seen.insert(Seen::Wait)),
            Action::Note(Note::Migrated(_)) => drop(seen.insert(Seen::Move)),
            Action::Note(_) | Action::Backoff { .. } => {}
        }
    }
}

/// Runs `world`, one thread per worker, and checks its end. Worker 0 runs on the caller's thread.
///
/// # Panics
/// If the end is wrong, naming what is.
pub fn run<C: Exhibit>(world: &World) -> BTreeSet<Seen> {
    let ends = connect_as::<Letter<C>, C>(world.workers());
    let mut pairs = world.nodes::<C>().into_iter().zip(ends);
    let first = pairs.next();
    let others: Vec<_> = pairs
        .map(|(node, end)| {
            let moves = world.moves.clone();
            thread::spawn(move || work(node, end, &moves))
        })
        .collect();
    let mut done: Vec<_> =
        first.map(|(node, end)| work(node, end, &world.moves)).into_iter().collect();
    done.extend(others.into_iter().map(|thread| thread.join().expect("workers do not panic")));
    let nodes: Vec<&Node<C>> = done.iter().map(|(node, _)| node).collect();
    if let Some(what) = world.fault_at_end(&nodes, false) {
        panic!("{what}");
    }
    done.into_iter().flat_map(|(_, seen)| seen).collect()
}
