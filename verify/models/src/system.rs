//! All states of a world: workers, messages under way, timers. Every transition is one call of the
//! real [`Worker::step`](ltbw::protocol::Worker::step).

use crate::hull::{Hull, Letter};
use crate::variants::Variant;
use crate::world::{Network, Node, Points, World};
use ltbw::balance::Workload;
use ltbw::check::{Between, UnderWay};
use ltbw::protocol::{
    Action, Attempt, BlockId, Broken, Event, Message, Name, Note, Rule, Submesh, Ticket, WorkerId,
    message_of,
};
use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;
use std::hash::{Hash, Hasher};
use std::marker::PhantomData;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// A 64-bit hash with fixed keys.
pub fn fingerprint(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// Something large that is shared between states, hashed once.
#[derive(Clone, Debug)]
pub struct Shared<T> {
    value: Arc<T>,
    hash: u64,
}

impl<T: Hash> Shared<T> {
    fn new(value: T) -> Self {
        let hash = fingerprint(&value);
        Self { value: Arc::new(value), hash }
    }
}

impl<T> std::ops::Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T: PartialEq> PartialEq for Shared<T> {
    fn eq(&self, other: &Self) -> bool {
        self.hash == other.hash && self.value == other.value
    }
}

impl<T> Hash for Shared<T> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.hash);
    }
}

/// A state of the whole system.
#[derive(Clone, Debug, PartialEq, Hash)]
pub struct State<C: Variant> {
    /// The workers.
    pub nodes: Vec<Shared<Node<C>>>,
    /// Messages under way, by sender and receiver; the first was sent first.
    pub channels: BTreeMap<(WorkerId, WorkerId), Vec<Shared<Letter<C>>>>,
    /// Operations whose backoff may end.
    pub backoffs: BTreeSet<(WorkerId, Ticket)>,
    /// Moves of blocks that have happened.
    pub moved: usize,
    /// Workers that were cancelled.
    pub cancelled: BTreeSet<WorkerId>,
    /// Operations that have committed.
    pub committed: BTreeSet<Ticket>,
    /// Requests that have waited for a lock and neither got it nor ended since: worker, cell and
    /// operation. In the correct protocol these are the requests that wait.
    pub claims: BTreeSet<Claim>,
    /// The fault, if there is one.
    pub fault: Option<&'static str>,
}

/// Something that can happen next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Choice {
    /// The message at this place of a channel arrives.
    Deliver(WorkerId, WorkerId, usize),
    /// A worker does a unit of local work.
    Work(WorkerId),
    /// A backoff ends.
    Retry(WorkerId, Ticket),
    /// The next move of a block.
    Move,
    /// A worker is cancelled.
    Cancel(WorkerId),
}

/// A world and the rules of its workers.
#[derive(Clone, Debug)]
pub struct System<C> {
    /// The world.
    pub world: World,
    rules: PhantomData<C>,
}

impl<C: Variant> System<C> {
    /// `world` with workers that obey `C`.
    pub fn new(world: World) -> Self {
        Self { world, rules: PhantomData }
    }

    /// The state at the start.
    pub fn initial(&self) -> State<C> {
        State {
            nodes: self.world.nodes().into_iter().map(Shared::new).collect(),
            channels: BTreeMap::new(),
            backoffs: BTreeSet::new(),
            moved: 0,
            cancelled: BTreeSet::new(),
            committed: BTreeSet::new(),
            claims: BTreeSet::new(),
            fault: None,
        }
    }

    /// Everything that can happen in `state`. Nothing happens after a fault or at the end.
    pub fn choices(&self, state: &State<C>) -> Vec<Choice> {
        let mut choices = Vec::new();
        if state.fault.is_some() || self.is_final(state) {
            return choices;
        }
        for (&(from, to), letters) in &state.channels {
            let places = match self.world.network {
                Network::Fifo => 1,
                Network::Unordered => letters.len(),
            };
            choices.extend((0..places).map(|place| Choice::Deliver(from, to, place)));
        }
        for (id, node) in state.nodes.iter().enumerate() {
            // A passive worker has nothing to do but to speak in a wave.
            if node.has_work() && (self.world.termination || !node.is_passive()) {
                choices.push(Choice::Work(WorkerId::at(id)));
            }
        }
        choices.extend(state.backoffs.iter().map(|&(w, ticket)| Choice::Retry(w, ticket)));
        choices.extend(self.next_move(state).map(|_| Choice::Move));
        if self.world.cancels {
            let may = |w: &WorkerId| !state.cancelled.contains(w);
            choices.extend(WorkerId::below(self.world.workers()).filter(may).map(Choice::Cancel));
        }
        choices
    }

    /// The state to which `choice` leads.
    pub fn after(&self, state: &State<C>, choice: Choice) -> State<C> {
        let mut next = state.clone();
        let (at, event) = self.event(&mut next, choice);
        let before = next.nodes[at.index()].value.clone();
        let mut node = (*before).clone();
        let mut actions = Vec::new();
        let step = AssertUnwindSafe(|| node.step(event, &mut actions));
        if let Err(panic) = catch_unwind(step) {
            next.fault = Some(fault_of(&message_of(&*panic)));
            return next;
        }
        if let Some(what) = node.mesh().broken {
            next.fault = Some(what);
        }
        if let Some(what) = claim(&mut next.claims, at, &before, &node) {
            next.fault = next.fault.or(Some(what));
        }
        if !self.world.termination {
            node.forget_counts();
        }
        next.nodes[at.index()] = Shared::new(node);
        for action in actions {
            self.carry_out(&mut next, at, action);
        }
        if self.world.rule != Rule::WoundWait {
            fold(&mut next);
        }
        next.fault = next.fault.or_else(|| self.fault(&next));
        next
    }

    /// The next move of a block that is allowed now.
    pub fn next_move(&self, state: &State<C>) -> Option<Migration> {
        let &(block, to) = self.world.moves.get(state.moved)?;
        let from = WorkerId::at(state.nodes.iter().position(|node| node.can_migrate(block))?);
        (from != to).then_some(Migration { from, block, to })
    }

    /// Takes the event of `choice` out of the state.
    fn event(&self, state: &mut State<C>, choice: Choice) -> (WorkerId, Event<Hull<C>>) {
        match choice {
            Choice::Deliver(from, to, place) => {
                let letters = state.channels.entry((from, to)).or_default();
                let message = (*letters.remove(place).value).clone();
                if letters.is_empty() {
                    state.channels.remove(&(from, to));
                }
                (to, Event::Message { from, message })
            }
            Choice::Work(at) => (at, Event::Work),
            Choice::Retry(at, ticket) => {
                state.backoffs.remove(&(at, ticket));
                (at, Event::Retry(ticket))
            }
            Choice::Move => {
                let Migration { from, block, to } = self.next_move(state).unwrap_or_default();
                state.moved += 1;
                (from, Event::Migrate { block, to })
            }
            Choice::Cancel(at) => {
                state.cancelled.insert(at);
                (at, Event::Cancel)
            }
        }
    }

    fn carry_out(&self, state: &mut State<C>, at: WorkerId, action: Action<Hull<C>>) {
        match action {
            Action::Send { to, message } => {
                let letters = state.channels.entry((at, to)).or_default();
                letters.push(Shared::new(message));
                if self.world.network == Network::Unordered {
                    letters.sort_by_key(|letter| letter.hash);
                }
            }
            // The time is not modelled: a backoff may end at any moment.
            Action::Backoff { ticket, .. } => {
                state.backoffs.insert((at, ticket));
            }
            Action::Note(Note::Committed { ticket, .. }) => {
                if !state.committed.insert(ticket) {
                    state.fault = Some("an operation commits twice");
                }
            }
            Action::Note(Note::SetBack { ticket, .. }) if state.committed.contains(&ticket) => {
                state.fault = Some("a committed operation is set back");
            }
            Action::Note(_) => {}
        }
    }

    /// Is there nothing left to do?
    pub fn is_final(&self, state: &State<C>) -> bool {
        if self.world.termination {
            return state.channels.is_empty() && state.nodes.iter().all(|n| n.is_stopped());
        }
        state.channels.is_empty() && state.nodes.iter().all(|node| node.is_passive())
    }

    /// The state as the checks of the invariants see it.
    fn between<'a>(&self, state: &'a State<C>) -> Between<'a, Hull<C>, Points, C> {
        let letters = state.channels.iter().flat_map(|(&(from, to), letters)| {
            letters.iter().map(move |letter| UnderWay { from, to, message: &**letter })
        });
        let between = Between::new(state.nodes.iter().map(|node| &**node), letters);
        if self.world.termination { between } else { between.without_counts() }
    }

    /// The fault of `state`, if it has one.
    fn fault(&self, state: &State<C>) -> Option<&'static str> {
        if state.nodes.iter().any(|node| node.is_stopped()) {
            let basic = state.channels.values().flatten().any(|letter| letter.is_basic());
            if basic || !state.nodes.iter().all(|node| node.is_quiescent()) {
                return Some("stopped too early");
            }
        }
        let has_points = |&at: &WorkerId| {
            state.nodes.get(at.index()).is_some_and(|node| node.source().left() > 0)
        };
        if state.cancelled.iter().any(has_points) {
            return Some("a cancelled worker has points");
        }
        if state.nodes.iter().any(|node| node.source().is_choosing()) && has_operations(state) {
            return Some("an operation while a worker chooses");
        }
        if let Err(broken) = self.between(state).check() {
            return Some(NAMES[broken.invariant as usize - 1]);
        }
        if !self.is_final(state) {
            return None;
        }
        if !state.backoffs.is_empty() {
            return Some("a backoff is left at the end");
        }
        let nodes: Vec<&Node<C>> = state.nodes.iter().map(|node| &**node).collect();
        self.world.fault_at_end(&nodes, !state.cancelled.is_empty())
    }
}

/// Is an operation under way?
fn has_operations<C: Variant>(state: &State<C>) -> bool {
    let is_of_operation = |letter: &Shared<Letter<C>>| letter.ticket().is_some();
    state.nodes.iter().any(|node| !node.standing().is_passive)
        || state.channels.values().flatten().any(is_of_operation)
}

/// The fault that a broken invariant is.
const NAMES: [&str; 12] = [
    "P1 is broken",
    "P2 is broken",
    "P3 is broken",
    "P4 is broken",
    "P5 is broken",
    "P6 is broken",
    "P7 is broken",
    "P8 is broken",
    "P9 is broken",
    "P10 is broken",
    "P11 is broken",
    "P12 is broken",
];

/// The fault of a step that has panicked.
fn fault_of(message: &str) -> &'static str {
    let broken = Broken::from_message(message);
    broken.map_or("a step panics", |broken| NAMES[broken.invariant as usize - 1])
}

/// A block that moves from one worker to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Migration {
    /// The worker that gives it.
    pub from: WorkerId,
    /// The block.
    pub block: BlockId,
    /// The worker that gets it.
    pub to: WorkerId,
}

/// A request at a worker waits for the lock of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Claim {
    /// The worker.
    pub worker: WorkerId,
    /// The cell.
    pub name: Name,
    /// The request.
    pub ticket: Ticket,
}

/// Theorem 2 rests on this: a lock for which a request waits goes to that request, or to an older
/// one, unless the request ends first. Updates the claims at worker `at` after a step, and returns
/// what is wrong.
fn claim<C: Variant>(
    claims: &mut BTreeSet<Claim>,
    at: WorkerId,
    before: &Node<C>,
    after: &Node<C>,
) -> Option<&'static str> {
    let mut overtaken = false;
    claims.retain(|&Claim { worker, name, ticket }| {
        if worker != at {
            return true;
        }
        // A cell that is gone is waited for by nobody; its slot may be used again.
        let Some(t) = after.mesh().resolve(name) else { return false };
        let holder = after.mesh().holder(t);
        let was_here = before.mesh().resolve(name) == Some(t);
        let is_new = was_here && holder != before.mesh().holder(t);
        overtaken |= is_new && holder.is_some_and(|h| h > ticket) && after.has_request(ticket);
        after.has_request(ticket) && holder != Some(ticket)
    });
    after.visit_waiting(&mut |t, ticket| {
        claims.extend(after.mesh().name_of(t).map(|name| Claim { worker: at, name, ticket }));
    });
    overtaken.then_some("a younger operation takes a lock that an older one waits for")
}

/// Folds states that differ only in how often operations were set back: shifts the attempts of
/// every ticket so that the smallest in the state is 0. That changes no behaviour, see
/// [`Worker::visit_attempts`](ltbw::protocol::Worker::visit_attempts). Under wound-wait no fold is
/// needed: its state graphs are finite as they are.
fn fold<C: Variant>(state: &mut State<C>) {
    let mut least: BTreeMap<Ticket, Attempt> = BTreeMap::new();
    let mut note = |ticket: Ticket, attempt: &mut Attempt| {
        let least = least.entry(ticket).or_insert(*attempt);
        *least = (*least).min(*attempt);
    };
    let mut nodes: Vec<Node<C>> = state.nodes.iter().map(|node| (**node).clone()).collect();
    let letters = state.channels.values().flatten();
    let mut letters: Vec<Letter<C>> = letters.map(|letter| (**letter).clone()).collect();
    nodes.iter_mut().for_each(|node| node.visit_attempts(&mut note));
    for (ticket, attempt) in letters.iter_mut().filter_map(Message::attempt_mut) {
        note(ticket, attempt);
    }
    if least.values().all(|&attempt| attempt == Attempt::default()) {
        return;
    }
    let mut shift = |ticket: Ticket, attempt: &mut Attempt| {
        let least = least.get(&ticket).copied().unwrap_or_default();
        *attempt = Attempt::new(attempt.number() - least.number());
    };
    nodes.iter_mut().for_each(|node| node.visit_attempts(&mut shift));
    for (ticket, attempt) in letters.iter_mut().filter_map(Message::attempt_mut) {
        shift(ticket, attempt);
    }
    state.nodes = nodes.into_iter().map(Shared::new).collect();
    for (letter, old) in letters.into_iter().zip(state.channels.values_mut().flatten()) {
        *old = Shared::new(letter);
    }
}
