//! The home's side of an operation: from the walk to the commit or the setback.

use super::conduct::Conduct;
use super::directory::WorkerId;
use super::owner::{Waiter, Want};
use super::submesh::{Insert, Source, Submesh, Walk};
use super::table::Table;
use super::worker::{Action, Note, Worker};
use super::{Attempt, Closure, Handle, Message, Name, Rule, Ticket};
use std::collections::BTreeSet;

/// An operation at its home.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Op<S: Submesh> {
    pub(super) point: S::Point,
    pub(super) attempt: Attempt,
    pub(super) phase: Phase,
    /// Workers asked in this attempt, with the number of `Expand` not answered yet.
    asked: Table<WorkerId, u32>,
    /// Every handle asked for in this attempt, and whom.
    whereabouts: Table<Name, WorkerId>,
    /// The tetrahedra granted, by owner.
    parts: Table<WorkerId, Vec<S::Piece>>,
    /// The cavity's vertices, when it is complete and what touches it is collected.
    around: Vec<u32>,
    /// Workers whose denial was not lifted yet.
    parked: BTreeSet<WorkerId>,
}

/// Where an operation is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Phase {
    /// It can start (again).
    Ready,
    /// Its walk waits.
    Walking,
    /// It collects its closure.
    Expanding,
    /// Set back: so many releases are not acknowledged yet.
    Releasing(u32),
    /// Set back, and waiting for its backoff to end.
    Backoff,
}

impl<S: Submesh> Op<S> {
    /// A new operation in the memory of one that has ended.
    fn renew(mut self: Box<Self>, point: S::Point, attempt: Attempt, phase: Phase) -> Box<Self> {
        let Self { asked, whereabouts, parts, around, parked, .. } = &mut *self;
        asked.clear();
        whereabouts.clear();
        parts.clear();
        around.clear();
        parked.clear();
        (self.point, self.attempt, self.phase) = (point, attempt, phase);
        self
    }

    fn new(point: S::Point, attempt: Attempt, phase: Phase) -> Box<Self> {
        Box::new(Self {
            point,
            attempt,
            phase,
            asked: Table::default(),
            whereabouts: Table::default(),
            parts: Table::default(),
            around: Vec::new(),
            parked: BTreeSet::new(),
        })
    }

    /// A copy; deriving `Clone` would ask for it of the submesh.
    fn copy(&self) -> Box<Self> {
        Box::new(Self {
            point: self.point.clone(),
            attempt: self.attempt,
            phase: self.phase,
            asked: self.asked.clone(),
            whereabouts: self.whereabouts.clone(),
            parts: self.parts.clone(),
            around: self.around.clone(),
            parked: self.parked.clone(),
        })
    }

    fn is_collecting(&self, attempt: Attempt) -> bool {
        self.attempt == attempt && self.phase == Phase::Expanding
    }
}

impl<S: Submesh, Q: Source<S>, C: Conduct> Worker<S, Q, C> {
    /// Walks to the point; inserts it at once if nothing is in the way, else begins an operation.
    pub(super) fn start(
        &mut self,
        ticket: Option<Ticket>,
        attempt: Attempt,
        point: S::Point,
        from: Option<Name>,
        out: &mut Vec<Action<S>>,
    ) {
        match self.mesh.walk(&point, from) {
            Walk::Duplicate(_) => {
                self.source.let_go(&point);
                out.push(Action::Note(Note::Known));
            }
            Walk::At(seed) => match self.insert(&point, seed) {
                Insert::Done => {
                    self.source.inserted(&self.mesh, &point);
                    out.push(Action::Note(Note::Local));
                }
                // What it would hold while it waits would be in others' way, and an older one would
                // set it back. The paper's rule knows no waiting.
                Insert::Locked(t) if self.config.rule != Rule::Paper => {
                    self.wait_outside(ticket, attempt, point, t);
                }
                // The run has failed.
                Insert::Full => {}
                Insert::Blocked | Insert::Locked(_) => {
                    let ticket = ticket.unwrap_or_else(|| self.ticket());
                    self.begin(ticket, attempt, point, seed, out);
                }
            },
            Walk::Locked(t) => self.wait_outside(ticket, attempt, point, t),
            Walk::Exits(at) => {
                let ticket = ticket.unwrap_or_else(|| self.ticket());
                self.walk_out(ticket, attempt, point, at, out);
            }
            Walk::NoTets => {
                let ticket = ticket.unwrap_or_else(|| self.ticket());
                let next = (self.id() + 1) % self.config.workers;
                self.source.let_go(&point);
                self.send(next, Message::Walk { ticket, attempt, point, at: None }, out);
            }
        }
    }

    /// Inserts a point at once if nothing of its closure is in the way.
    fn insert(&mut self, point: &S::Point, seed: S::Tet) -> Insert<S::Tet> {
        let in_the_way = match self.config.closure {
            Closure::Face => None,
            Closure::Vertex => self.mesh.in_the_way(point, seed),
        };
        in_the_way.unwrap_or_else(|| self.mesh.insert(point, seed, &self.directory))
    }

    /// Waits for a locked tetrahedron without a lock of its own, then walks on.
    fn wait_outside(
        &mut self,
        ticket: Option<Ticket>,
        attempt: Attempt,
        point: S::Point,
        t: S::Tet,
    ) {
        let ticket = ticket.unwrap_or_else(|| self.ticket());
        self.ops.insert(ticket, Op::new(point, attempt, Phase::Walking));
        self.waiting.entry(t).or_default().push(Waiter::Walk(ticket));
    }

    /// The walk leaves through an interface face.
    fn walk_out(
        &mut self,
        ticket: Ticket,
        attempt: Attempt,
        point: S::Point,
        at: Handle,
        out: &mut Vec<Action<S>>,
    ) {
        let owner = self.directory.owner(at.block);
        if owner != self.id() {
            self.source.let_go(&point);
            self.send(owner, Message::Walk { ticket, attempt, point, at: Some(at) }, out);
            return;
        }
        // The tetrahedron is on its way here.
        self.ops.insert(ticket, Op::new(point, attempt, Phase::Walking));
        self.absent.entry(at.name).or_default().push(Waiter::Walk(ticket));
    }

    /// A walk comes in. A block that has moved is walked after.
    pub(super) fn walk_in(
        &mut self,
        ticket: Ticket,
        attempt: Attempt,
        point: S::Point,
        at: Option<Handle>,
        out: &mut Vec<Action<S>>,
    ) {
        if let Some(handle) = at
            && !self.directory.is_mine(handle.block)
        {
            if C::FORWARDS {
                self.walk_out(ticket, attempt, point, handle, out);
            }
            return;
        }
        self.start(Some(ticket), attempt, point, at.map(|handle| handle.name), out);
    }

    /// Begins to collect the closure, from a tetrahedron of its own.
    fn begin(
        &mut self,
        ticket: Ticket,
        attempt: Attempt,
        point: S::Point,
        seed: S::Tet,
        out: &mut Vec<Action<S>>,
    ) {
        let me = self.id();
        out.push(Action::Note(Note::Began(ticket)));
        let phase = Phase::Expanding;
        let mut op = match self.spare.ops.pop() {
            Some(ended) => ended.renew(point.clone(), attempt, phase),
            None => Op::new(point.clone(), attempt, phase),
        };
        op.asked.insert_new(me, || 1);
        self.ops.insert(ticket, op);
        self.request(me, ticket, attempt, point, ([Want::Tet(seed)], Vec::new()), out);
    }

    /// An owner has locked and tested all that it was asked for.
    #[allow(clippy::too_many_arguments)] // the fields of the message
    pub(super) fn granted(
        &mut self,
        from: WorkerId,
        ticket: Ticket,
        attempt: Attempt,
        answers: u32,
        pieces: Vec<S::Piece>,
        (foreign, bounced): (Vec<Handle>, Vec<Handle>),
        out: &mut Vec<Action<S>>,
    ) {
        let Some(op) = self.ops.get_mut(&ticket).filter(|op| op.is_collecting(attempt)) else {
            return;
        };
        let part = op.parts.entry(from, Vec::new);
        if part.is_empty() {
            *part = pieces;
        } else {
            part.extend(pieces);
        }
        if let Some(open) = op.asked.get_mut(from) {
            *open = open.saturating_sub(answers);
        }
        let mut seeds: Table<WorkerId, Vec<Handle>> = Table::default();
        let far = foreign.len() + bounced.len();
        op.whereabouts.reserve(far);
        // Several faces of one tetrahedron may be among the foreign ones: it is asked for once.
        // A bounced one is asked for again, perhaps of the same worker: the block may be back.
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
        let complete = op.asked.values().all(|&open| open == 0);
        if complete && self.config.closure == Closure::Vertex && op.around.is_empty() {
            self.surround(ticket, out);
            return;
        }
        let (point, around) = (op.point.clone(), op.around.clone());
        for (owner, seeds) in seeds.into_entries() {
            let (point, around) = (point.clone(), around.clone());
            self.send(owner, Message::Expand { ticket, attempt, point, seeds, around }, out);
        }
        if complete {
            self.fill(ticket, out);
        }
    }

    /// The cavity is complete: all that touches it is asked for, too.
    fn surround(&mut self, ticket: Ticket, out: &mut Vec<Action<S>>) {
        let Some(op) = self.ops.get_mut(&ticket) else { return };
        op.around = S::corners(op.parts.entries());
        if op.around.is_empty() {
            self.fill(ticket, out);
            return;
        }
        let asked: Vec<WorkerId> = op.asked.keys().collect();
        for &worker in &asked {
            *op.asked.entry(worker, || 0) += 1;
        }
        let (attempt, point, around) = (op.attempt, op.point.clone(), op.around.clone());
        for worker in asked {
            let (point, around) = (point.clone(), around.clone());
            let seeds = Vec::new();
            self.send(worker, Message::Expand { ticket, attempt, point, seeds, around }, out);
        }
    }

    /// The whole closure is locked: the commit point.
    fn fill(&mut self, ticket: Ticket, out: &mut Vec<Action<S>>) {
        let Some(mut op) = self.ops.remove(&ticket) else { return };
        if !C::IGNORES_LATE_WOUND {
            self.late.insert(ticket, op.copy());
        }
        let Op { point, attempt, asked, whereabouts, parts, .. } = &*op;
        let find = |name: Name| whereabouts.get(name).copied();
        let mut patches = self.mesh.fill(point, parts.entries(), &find, &self.directory);
        let (setbacks, parts) = (*attempt, asked.len() as u32);
        out.push(Action::Note(Note::Committed { ticket, setbacks, parts }));
        for to in asked.keys() {
            let patch = patches.iter().position(|&(worker, _)| worker == to);
            let patch = patch.map(|place| patches.swap_remove(place).1);
            self.send(to, Message::Commit { ticket, patch }, out);
        }
        patches.sort_unstable_by_key(|&(to, _)| to);
        for (to, patch) in patches {
            self.send(to, Message::Commit { ticket, patch: Some(patch) }, out);
        }
        op.parts.clear();
        self.spare.put_op(op);
    }

    /// An older operation waits for a lock of this one.
    pub(super) fn wounded(&mut self, ticket: Ticket, attempt: Attempt, out: &mut Vec<Action<S>>) {
        if let Some(op) = self.late.remove(&ticket) {
            self.ops.insert(ticket, op);
        }
        if self.ops.get(&ticket).is_some_and(|op| op.is_collecting(attempt)) {
            self.set_back(ticket, out);
        }
    }

    /// A request was denied.
    pub(super) fn denied(
        &mut self,
        from: WorkerId,
        ticket: Ticket,
        attempt: Attempt,
        out: &mut Vec<Action<S>>,
    ) {
        let Some(op) = self.ops.get_mut(&ticket).filter(|op| op.attempt == attempt) else {
            return;
        };
        if self.config.rule == Rule::WaitDie {
            op.parked.insert(from);
        }
        if op.is_collecting(attempt) {
            self.set_back(ticket, out);
        }
    }

    /// The holder that was in the way has released its locks.
    pub(super) fn unparked(
        &mut self,
        from: WorkerId,
        ticket: Ticket,
        attempt: Attempt,
        out: &mut Vec<Action<S>>,
    ) {
        if let Some(op) = self.ops.get_mut(&ticket).filter(|op| op.attempt == attempt) {
            op.parked.remove(&from);
            self.start_again(ticket, out);
        }
    }

    /// The setback: every lock of the attempt is given back.
    fn set_back(&mut self, ticket: Ticket, out: &mut Vec<Action<S>>) {
        let Some(op) = self.ops.get_mut(&ticket) else { return };
        let asked = std::mem::take(&mut op.asked);
        op.whereabouts.clear();
        op.parts.clear();
        op.around.clear();
        let attempt = op.attempt;
        op.phase = Phase::Releasing(if C::AWAITS_RELEASES { asked.len() as u32 } else { 0 });
        out.push(Action::Note(Note::SetBack { ticket, attempt: attempt + 1 }));
        for to in asked.keys() {
            self.send(to, Message::Abort { ticket, attempt }, out);
        }
        self.start_again(ticket, out);
    }

    /// A release is acknowledged.
    pub(super) fn aborted(&mut self, ticket: Ticket, attempt: Attempt, out: &mut Vec<Action<S>>) {
        if let Some(op) = self.ops.get_mut(&ticket).filter(|op| op.attempt == attempt)
            && let Phase::Releasing(open) = &mut op.phase
        {
            *open = open.saturating_sub(1);
            self.start_again(ticket, out);
        }
    }

    /// Starts again if all locks are released and nobody is in the way.
    fn start_again(&mut self, ticket: Ticket, out: &mut Vec<Action<S>>) {
        let paper = self.config.rule == Rule::Paper;
        let Some(op) = self.ops.get_mut(&ticket) else { return };
        if op.phase != Phase::Releasing(0) || !op.parked.is_empty() {
            return;
        }
        op.attempt += 1;
        if paper {
            op.phase = Phase::Backoff;
            out.push(Action::Backoff { ticket, attempt: op.attempt });
        } else {
            self.make_ready(ticket);
        }
    }

    /// The backoff is over.
    pub(super) fn retry(&mut self, ticket: Ticket) {
        if self.ops.get(&ticket).is_some_and(|op| op.phase == Phase::Backoff) {
            self.make_ready(ticket);
        }
    }

    /// The operation can start.
    pub(super) fn make_ready(&mut self, ticket: Ticket) {
        if let Some(op) = self.ops.get_mut(&ticket) {
            op.phase = Phase::Ready;
            self.ready.insert(ticket);
        }
    }
}
