//! Operations: the home's side, from the walk to the commit or the setback.
//!
//! `docs/protocol.md`, *The home*, is the table of states and events that this file follows, with
//! the pseudocode of `start`, `granted` and `fill`.

use super::config::Rule;
use super::directory::WorkerId;
use super::invariant::invariant;
use super::rules::Rules;
use super::state::{Asker, Granted, Operation, Phase, Start, Waiter, Want};
use super::submesh::{Insert, Item, Source, Submesh, Walk};
use super::table::Table;
use super::worker::{Action, Note, Worker};
use super::{Attempt, Handle, Message, Name, Ticket};

impl<S: Submesh, Q: Source<S>, C: Rules> Worker<S, Q, C> {
    /// The operation that a message is about, which must be in this attempt.
    pub(super) fn operation(&mut self, ticket: Ticket, attempt: Attempt) -> &mut Operation<S> {
        match self.operations.all.get_mut(&ticket) {
            Some(op) if op.attempt == attempt => op,
            Some(op) => {
                invariant!(P8, "a message of attempt {attempt} for {ticket:?} in {}", op.attempt)
            }
            None => invariant!(P8, "a message of attempt {attempt} for {ticket:?}, which is gone"),
        }
    }

    /// Takes up the oldest operation that can start; `false` if there is none.
    pub(super) fn start_ready(&mut self) -> bool {
        let Some(ticket) = self.operations.ready.pop_first() else { return false };
        let Some(op) = self.operations.all.remove(&ticket) else {
            invariant!(P8, "{ticket:?} is ready and gone")
        };
        invariant!(P8, op.phase == Phase::Ready, "{ticket:?} starts in {:?}", op.phase);
        self.start(Start { ticket: Some(ticket), attempt: op.attempt, point: op.point }, None);
        true
    }

    /// Walks to the point, or begins at its item; inserts it at once if nothing is in the way, else
    /// begins an operation.
    pub(super) fn start(&mut self, start: Start<S>, from: Option<Name>) {
        let point = &start.point;
        let walk = match self.source.item(&self.mesh, point) {
            Item::Free => self.mesh.walk(point, from),
            Item::At(t) if self.mesh.holder(t).is_some() => Walk::Locked(t),
            Item::At(t) if self.mesh.in_conflict(t, point) => Walk::At(t),
            // R18
            Item::At(_) | Item::Gone if !C::lets_go() => self.mesh.walk(point, from),
            Item::At(_) | Item::Gone => {
                self.mesh.forget(point);
                self.source.released(point);
                self.out.push(Action::Note(Note::Gone));
                return;
            }
        };
        match walk {
            Walk::Duplicate(_) => {
                self.source.released(point);
                self.out.push(Action::Note(Note::Duplicate));
            }
            Walk::At(seed) => match self.insert(point, seed) {
                Insert::Done => {
                    self.source.inserted(&self.mesh, point);
                    if Q::WATCHES {
                        // No walk has taken the place of one that began at its item.
                        self.mesh.forget(point);
                        self.source.created(&self.mesh, self.mesh.made_at_once());
                    }
                    self.out.push(Action::Note(Note::Local));
                }
                // Locks that it would hold while it waits would be in others' way, and an older
                // one would set it back. The paper's rule knows no waiting.
                Insert::Locked(t) if self.config.rule != Rule::Paper => self.wait_outside(start, t),
                // The run has failed.
                Insert::Full => {}
                Insert::Blocked | Insert::Locked(_) => self.begin(start, seed),
            },
            Walk::Locked(t) => self.wait_outside(start, t),
            Walk::Exits(at) => self.walk_out(start, at),
            Walk::NoTets => {
                let next = WorkerId::new((self.id().number() + 1) % self.config.workers);
                self.send_walk(next, start, None);
            }
        }
    }

    /// Inserts a point at once if nothing of its closure is in the way.
    fn insert(&mut self, point: &S::Point, seed: S::Tet) -> Insert<S::Tet> {
        let in_the_way = self.in_the_way(point, seed);
        in_the_way.unwrap_or_else(|| self.mesh.insert(point, seed, &self.directory))
    }

    /// Enters an operation: it is at home nowhere else, and was not here.
    fn enter(&mut self, ticket: Ticket, op: Box<Operation<S>>) {
        let before = self.operations.all.insert(ticket, op);
        invariant!(P8, before.is_none(), "{ticket:?} starts while it is at home here");
    }

    /// Enters an operation whose walk waits.
    fn enter_walking(&mut self, start: Start<S>) -> Waiter {
        let ticket = start.ticket.unwrap_or_else(|| self.ticket());
        self.enter(ticket, Operation::new(start.point, start.attempt, Phase::Walking));
        Waiter::Walk(ticket)
    }

    /// Waits for a locked tetrahedron without a lock of its own, then walks on.
    fn wait_outside(&mut self, start: Start<S>, t: S::Tet) {
        let waiter = self.enter_walking(start);
        self.locks.waiting.entry(t).or_default().push(waiter);
    }

    /// The walk leaves through an interface face.
    fn walk_out(&mut self, start: Start<S>, at: Handle) {
        let owner = self.directory.owner(at.block);
        if owner != self.id() {
            self.send_walk(owner, start, Some(at));
            return;
        }
        // The tetrahedron is on its way here.
        let waiter = self.enter_walking(start);
        self.locks.absent.entry(at.name).or_default().push(waiter);
    }

    /// Another worker goes on with the walk, and becomes the operation's home.
    fn send_walk(&mut self, to: WorkerId, start: Start<S>, at: Option<Handle>) {
        let ticket = start.ticket.unwrap_or_else(|| self.ticket());
        let Start { attempt, point, .. } = start;
        self.source.released(&point);
        self.send(to, Message::Walk { ticket, attempt, point, at });
    }

    /// A walk comes in. A block that has moved is walked after (R10).
    pub(super) fn walk_in(&mut self, start: Start<S>, at: Option<Handle>) {
        let Some(ticket) = start.ticket else { invariant!(P8, "a walk without a ticket") };
        let is_here = self.operations.all.contains_key(&ticket);
        invariant!(P8, !is_here, "{ticket:?} walks in while it is at home here");
        if let Some(handle) = at
            && !self.directory.is_mine(handle.block)
        {
            if C::forwards() {
                self.walk_out(start, handle);
            }
            return;
        }
        self.start(start, at.map(|handle| handle.name));
    }

    /// Begins to collect the closure, from a tetrahedron of its own.
    fn begin(&mut self, start: Start<S>, seed: S::Tet) {
        let ticket = start.ticket.unwrap_or_else(|| self.ticket());
        let Start { attempt, point, .. } = start;
        let me = self.id();
        self.out.push(Action::Note(Note::Began(ticket)));
        let phase = Phase::Expanding;
        let mut op = match self.spare.operations.pop() {
            Some(ended) => ended.renew(point.clone(), attempt, phase),
            None => Operation::new(point.clone(), attempt, phase),
        };
        op.asked.insert_new(me, || 1);
        self.enter(ticket, op);
        let asker = Asker { home: me, attempt, point };
        self.request(ticket, asker, [Want::Tet(seed)], Vec::new());
    }

    /// An owner has locked and tested all that it was asked for.
    pub(super) fn granted(
        &mut self,
        from: WorkerId,
        ticket: Ticket,
        attempt: Attempt,
        granted: Granted<S>,
    ) {
        let Granted { answers, pieces, foreign, bounced, moved } = granted;
        for (block, owner, epoch) in moved {
            self.directory.learn(block, owner, epoch);
        }
        let op = self.operation(ticket, attempt);
        if op.phase != Phase::Expanding {
            // It was sent before the `Abort` arrived there.
            let releasing = matches!(op.phase, Phase::Releasing(_));
            invariant!(P8, releasing, "a grant for {ticket:?} in {:?}", op.phase);
            return;
        }
        let part = op.parts.entry(from, Vec::new);
        match part.is_empty() {
            true => *part = pieces,
            false => part.extend(pieces),
        }
        match op.asked.get_mut(from).map(|open| (open.checked_sub(answers), open)) {
            Some((Some(left), open)) => *open = left,
            _ => invariant!(P8, "{from} answers {answers} for {ticket:?}, which are too many"),
        }
        let seeds = self.seeds_of(ticket, foreign, bounced);
        let op = self.operation(ticket, attempt);
        let complete = op.asked.values().all(|&open| open == 0);
        if complete {
            if !self.surround(ticket) {
                self.fill(ticket);
            }
            return;
        }
        let (point, around) = (op.point.clone(), op.around.clone());
        for (owner, seeds) in seeds.into_entries() {
            let (point, around) = (point.clone(), around.clone());
            self.send(owner, Message::Expand { ticket, attempt, point, seeds, around });
        }
    }

    /// The handles to ask for, by the workers to be asked. Several faces of one tetrahedron may be
    /// among the foreign ones: it is asked for once. A bounced one is asked for again, perhaps of
    /// the same worker: the block may be back.
    fn seeds_of(
        &mut self,
        ticket: Ticket,
        foreign: Vec<Handle>,
        bounced: Vec<Handle>,
    ) -> Table<WorkerId, Vec<Handle>> {
        let mut seeds: Table<WorkerId, Vec<Handle>> = Table::default();
        let Some(op) = self.operations.all.get_mut(&ticket) else {
            invariant!(P8, "{ticket:?} is granted and gone")
        };
        let far = foreign.len() + bounced.len();
        op.whereabouts.reserve(far);
        for handle in foreign {
            let owner = self.directory.owner(handle.block);
            if op.whereabouts.insert_new(handle.name, || owner) {
                seeds.entry(owner, || Vec::with_capacity(far)).push(handle);
            }
        }
        for handle in bounced {
            let owner = self.directory.owner(handle.block);
            *op.whereabouts.entry(handle.name, || owner) = owner;
            seeds.entry(owner, Vec::new).push(handle);
        }
        for owner in seeds.keys() {
            *op.asked.entry(owner, || 0) += 1;
        }
        seeds
    }

    /// The whole closure is locked: the commit point.
    fn fill(&mut self, ticket: Ticket) {
        let Some(mut op) = self.operations.all.remove(&ticket) else {
            invariant!(P8, "{ticket:?} commits and is gone")
        };
        let Operation { point, attempt, asked, whereabouts, parts, .. } = &*op;
        let find = |name: Name| whereabouts.get(name).copied();
        let mut patches = self.mesh.fill(point, parts.entries(), &find, &self.directory);
        let (setbacks, parts) = (*attempt, asked.len() as u32);
        self.out.push(Action::Note(Note::Committed { ticket, setbacks, parts }));
        for to in asked.keys() {
            let patch = patches.iter().position(|&(worker, _)| worker == to);
            let patch = patch.map(|place| patches.swap_remove(place).1);
            self.send(to, Message::Commit { ticket, patch });
        }
        patches.sort_unstable_by_key(|&(to, _)| to);
        for (to, patch) in patches {
            self.send(to, Message::Commit { ticket, patch: Some(patch) });
        }
        op.parts.clear();
        self.spare.put_operation(op);
    }

    /// An older operation waits for a lock of this one. R7: after the commit point, and in any
    /// state but this one, the lock is released in any case.
    pub(super) fn wounded(&mut self, ticket: Ticket, attempt: Attempt) {
        let obeys = match self.operations.all.get(&ticket) {
            Some(op) => op.attempt == attempt && op.phase == Phase::Expanding,
            None => !C::ignores_late_wound(),
        };
        if obeys {
            self.set_back(ticket);
        }
    }

    /// The setback: every lock of the attempt is given back.
    pub(super) fn set_back(&mut self, ticket: Ticket) {
        let Some(op) = self.operations.all.get_mut(&ticket) else {
            invariant!(P8, "{ticket:?} is set back and gone")
        };
        let asked = std::mem::take(&mut op.asked);
        op.whereabouts.clear();
        op.parts.clear();
        op.around.clear();
        let attempt = op.attempt;
        // R6
        op.phase = Phase::Releasing(if C::awaits_releases() { asked.len() as u32 } else { 0 });
        self.out.push(Action::Note(Note::SetBack { ticket, attempt: attempt.next() }));
        for to in asked.keys() {
            self.send(to, Message::Abort { ticket, attempt });
        }
        if !C::awaits_releases() {
            self.start_again(ticket);
        }
    }

    /// A release is acknowledged.
    pub(super) fn aborted(&mut self, ticket: Ticket, attempt: Attempt) {
        match &mut self.operation(ticket, attempt).phase {
            Phase::Releasing(open) if *open > 0 => {
                *open -= 1;
                self.start_again(ticket);
            }
            phase => invariant!(P8, "a release of {ticket:?} is acknowledged in {phase:?}"),
        }
    }

    /// Starts again if all locks are released.
    fn start_again(&mut self, ticket: Ticket) {
        let paper = self.config.rule == Rule::Paper;
        let Some(op) = self.operations.all.get_mut(&ticket) else {
            invariant!(P8, "{ticket:?} starts again and is gone")
        };
        if op.phase != Phase::Releasing(0) {
            return;
        }
        op.attempt = op.attempt.next();
        if paper {
            op.phase = Phase::Backoff;
            self.out.push(Action::Backoff { ticket, attempt: op.attempt });
        } else {
            self.make_ready(ticket);
        }
    }

    /// The operation can start.
    pub(super) fn make_ready(&mut self, ticket: Ticket) {
        let Some(op) = self.operations.all.get_mut(&ticket) else {
            invariant!(P7, "{ticket:?} was waited for and is gone")
        };
        op.phase = Phase::Ready;
        self.operations.ready.insert(ticket);
    }
}
