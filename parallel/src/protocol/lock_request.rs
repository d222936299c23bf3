//! Lock requests: the owner's side. Locks, tests and grants, one request for each operation that
//! has a part of its closure here.
//!
//! `docs/protocol.md`, *The owner*, is the table of states and events that this file follows, with
//! the pseudocode of `advance`, `grant`, `release` and `wake`.

use super::directory::{BlockId, WorkerId};
use super::invariant::invariant;
use super::operation::Operation;
use super::rules::Rules;
use super::submesh::{Found, Neighbour, Source, Submesh};
use super::variants::Rule;
use super::worker::{Action, Note, Worker};
use super::{Attempt, Handle, Message, Name, Ticket};
use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};

/// A tetrahedron to lock and test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Want<T> {
    Tet(T),
    Seed(Handle),
}

/// The walk or request that waits for a tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Waiter {
    /// The walk of an operation at home here.
    Walk(Ticket),
    /// A request.
    Request(Ticket),
}

/// One operation's part of its closure here. It keeps its locks while it waits.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Request<S: Submesh> {
    pub(super) home: WorkerId,
    pub(super) attempt: Attempt,
    pub(super) point: S::Point,
    /// A stack: the last one is looked at next, or waited for.
    pub(super) wants: Vec<Want<S::Tet>>,
    /// All tetrahedra locked.
    pub(super) held: Vec<S::Tet>,
    /// Tetrahedra in conflict, since the last grant, that were locked one by one ...
    pub(super) cavity: Vec<S::Tet>,
    /// ... and those locked at once.
    pub(super) pieces: Vec<S::Piece>,
    /// Far neighbours of those, or of all that is held when what touches the cavity is wanted.
    pub(super) foreign: Vec<Handle>,
    /// Seeds whose block is not here any more.
    pub(super) bounced: Vec<Handle>,
    /// `Expand` not answered yet.
    pub(super) owed: u32,
    /// The cavity's vertices, under the vertex closure: what touches them is to be locked.
    pub(super) around: Vec<u32>,
    /// Waiting, or denied: an event has to come first.
    pub(super) stalled: bool,
    /// Its home was told that an older operation waits for it.
    pub(super) wounded: bool,
}

/// The locks of one worker: their requests, and what waits for them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Locks<S: Submesh> {
    /// Closures of which a part is here.
    pub(super) requests: BTreeMap<Ticket, Box<Request<S>>>,
    /// Walks and requests that wait for a locked tetrahedron.
    pub(super) waiting: BTreeMap<S::Tet, Vec<Waiter>>,
    /// Walks and requests that wait for a tetrahedron that is not installed yet.
    pub(super) absent: BTreeMap<Name, Vec<Waiter>>,
}

impl<S: Submesh> Locks<S> {
    pub(super) fn new() -> Self {
        Self { requests: BTreeMap::new(), waiting: BTreeMap::new(), absent: BTreeMap::new() }
    }

    /// Is nothing locked, wanted or awaited?
    pub(super) fn is_empty(&self) -> bool {
        self.requests.is_empty() && self.waiting.is_empty() && self.absent.is_empty()
    }
}

impl<S: Submesh> Request<S> {
    pub(super) fn new(home: WorkerId, attempt: Attempt, point: S::Point) -> Box<Self> {
        Box::new(Self {
            home,
            attempt,
            point,
            // A typical closure.
            wants: Vec::with_capacity(64),
            held: Vec::with_capacity(64),
            cavity: Vec::with_capacity(32),
            pieces: Vec::new(),
            foreign: Vec::with_capacity(16),
            bounced: Vec::new(),
            owed: 0,
            around: Vec::new(),
            stalled: false,
            wounded: false,
        })
    }

    /// A new request in the memory of one that has ended.
    pub(super) fn renew(
        mut self: Box<Self>,
        home: WorkerId,
        attempt: Attempt,
        point: S::Point,
    ) -> Box<Self> {
        let Self { wants, held, cavity, pieces, foreign, bounced, around, .. } = &mut *self;
        around.clear();
        wants.clear();
        held.clear();
        cavity.clear();
        pieces.clear();
        foreign.clear();
        bounced.clear();
        (self.home, self.attempt, self.point) = (home, attempt, point);
        (self.owed, self.stalled, self.wounded) = (0, false, false);
        self
    }

    /// Its state, for people.
    pub(super) fn describe(&self) -> String {
        let Self { home, attempt, wants, held, owed, stalled, .. } = self;
        let (wants, held) = (wants.len(), held.len());
        format!(
            "home {home}, attempt {attempt}, {wants} wanted, {held} held, {owed} owed, \
             stalled: {stalled}"
        )
    }
}

impl<S: Submesh, Q: Source<S>, C: Rules> Worker<S, Q, C> {
    /// `Expand`: adds to the request of `ticket`, or makes one.
    pub(super) fn request(
        &mut self,
        home: WorkerId,
        ticket: Ticket,
        attempt: Attempt,
        point: S::Point,
        (wants, around): (impl IntoIterator<Item = Want<S::Tet>>, Vec<u32>),
        out: &mut Vec<Action<S>>,
    ) {
        let spare = &mut self.spare.requests;
        let request = self.locks.requests.entry(ticket).or_insert_with(|| match spare.pop() {
            Some(ended) => ended.renew(home, attempt, point),
            None => Request::new(home, attempt, point),
        });
        invariant!(
            P8,
            request.home == home && request.attempt == attempt,
            "{home} asks for attempt {attempt} of {ticket:?}; here is {}",
            request.describe()
        );
        // R5: a stalled request waits for the last of its wants, and keeps its place in that queue.
        let first = request.wants.pop_if(|_| C::KEEPS_PLACE && request.stalled);
        request.wants.extend(wants);
        request.wants.extend(first);
        request.owed += 1;
        let is_stalled = request.stalled;
        if !around.is_empty() {
            self.widen(ticket, around);
        }
        if !is_stalled {
            self.advance(ticket, out);
        }
    }

    /// Locks and tests until nothing is wanted or something is in the way. Ends: every tetrahedron
    /// is locked once, and each adds at most four to what is wanted (with the vertex closure, the
    /// cavity and its ring once more).
    pub(super) fn advance(&mut self, ticket: Ticket, out: &mut Vec<Action<S>>) {
        let Some(mut request) = self.locks.requests.remove(&ticket) else {
            invariant!(P7, "a request of {ticket:?} is woken and gone")
        };
        request.stalled = false;
        // A search at once that meets a lock changes nothing. Then the rest is locked one by one,
        // and so it is when the request goes on: else every wake-up would search in vain.
        // (It locks the ring, R1.)
        let mut at_once = C::LOCKS_RING && request.held.is_empty();
        while let Some(want) = request.wants.pop() {
            let t = match want {
                Want::Tet(t) => t,
                Want::Seed(seed) if !self.directory.is_mine(seed.block) => {
                    // R10
                    if C::FORWARDS {
                        request.bounced.push(seed);
                    }
                    continue;
                }
                Want::Seed(seed) => match self.mesh.resolve(seed.name) {
                    Some(t) => t,
                    // R14
                    None if !C::AWAITS_INSTALLATION => continue,
                    None => {
                        let queue = self.locks.absent.entry(seed.name).or_default();
                        queue.push(Waiter::Request(ticket));
                        request.wants.push(want);
                        request.stalled = true;
                        break;
                    }
                },
            };
            match self.mesh.holder(t) {
                Some(holder) if holder == ticket => {}
                Some(holder) => {
                    request.wants.push(want);
                    request.stalled = true;
                    self.conflict(ticket, &request, t, holder, out);
                    break;
                }
                None => {
                    at_once = at_once && self.take_all(ticket, &mut request, t);
                    if !at_once {
                        self.take(ticket, &mut request, t);
                    }
                }
            }
        }
        if !request.stalled {
            self.grant(ticket, &mut request, out);
        }
        self.locks.requests.insert(ticket, request);
    }

    /// Locks and tests all that follows from a tetrahedron that is free, if all of it is free.
    fn take_all(&mut self, ticket: Ticket, request: &mut Request<S>, t: S::Tet) -> bool {
        let Request { point, held, pieces, foreign, around, .. } = request;
        around.is_empty()
            && self.mesh.lock_all(t, point, ticket, &mut Found { held, pieces, foreign })
    }

    /// Locks and tests a tetrahedron that is free.
    fn take(&mut self, ticket: Ticket, request: &mut Request<S>, t: S::Tet) {
        if !request.around.is_empty() {
            self.lock_around(ticket, request, t);
            return;
        }
        let in_conflict = self.mesh.in_conflict(t, &request.point);
        // R1
        if in_conflict || C::LOCKS_RING {
            self.mesh.lock(t, ticket, in_conflict);
            request.held.push(t);
        }
        if in_conflict {
            request.cavity.push(t);
            let Request { wants, foreign, .. } = request;
            self.mesh.neighbours(t, |n| want(n, wants, foreign));
        }
    }

    fn grant(&mut self, ticket: Ticket, request: &mut Request<S>, out: &mut Vec<Action<S>>) {
        let mut pieces = std::mem::take(&mut request.pieces);
        pieces.extend(self.mesh.pieces(&request.cavity));
        request.cavity.clear();
        let bounced = std::mem::take(&mut request.bounced);
        let mut blocks: Vec<BlockId> = bounced.iter().map(|h| h.block).collect();
        blocks.sort_unstable();
        blocks.dedup();
        let news = |b| (b, self.directory.owner(b), self.directory.epoch(b));
        let message = Message::Grant {
            ticket,
            attempt: request.attempt,
            answers: std::mem::take(&mut request.owed),
            pieces,
            foreign: request.foreign.drain(..).collect(),
            bounced,
            moved: blocks.into_iter().map(news).collect(),
        };
        self.send(request.home, message, out);
    }

    /// `request` has met tetrahedron `t`, locked by `holder`: it waits, and if it is older the
    /// holder's home is told, once for each of the holder's attempts.
    fn conflict(
        &mut self,
        ticket: Ticket,
        request: &Request<S>,
        t: S::Tet,
        holder: Ticket,
        out: &mut Vec<Action<S>>,
    ) {
        if self.config.rule == Rule::Paper {
            self.deny(ticket, request, out);
            return;
        }
        out.push(Action::Note(Note::Waits(ticket)));
        self.locks.waiting.entry(t).or_default().push(Waiter::Request(ticket));
        let Some(other) = self.locks.requests.get_mut(&holder) else {
            invariant!(P5, "{t:?} is locked by {holder:?}, which has no request here")
        };
        if ticket < holder && !std::mem::replace(&mut other.wounded, true) {
            let (home, attempt) = (other.home, other.attempt);
            self.send(home, Message::Wound { ticket: holder, attempt }, out);
        }
    }

    /// `Abort`: the operation is set back.
    pub(super) fn abort(
        &mut self,
        from: WorkerId,
        ticket: Ticket,
        attempt: Attempt,
        out: &mut Vec<Action<S>>,
    ) {
        let mut request = match self.locks.requests.remove(&ticket) {
            Some(request) if request.attempt == attempt => request,
            Some(request) => invariant!(
                P8,
                "attempt {attempt} of {ticket:?} is aborted; here is {}",
                request.describe()
            ),
            None => invariant!(P8, "{ticket:?} is aborted, which has no request here"),
        };
        let me = Waiter::Request(ticket);
        forget(&mut self.locks.waiting, me);
        forget(&mut self.locks.absent, me);
        // R2
        if !C::RELEASES_ALL {
            request.held.pop();
        }
        let woken = self.unlock(&request.held);
        // R3
        if C::WAKES_ON_ABORT {
            self.wake(woken, out);
        }
        self.spare.put(request);
        self.send(from, Message::Aborted { ticket, attempt }, out);
    }

    /// `Commit`: the cavity is replaced and its closure unlocked.
    pub(super) fn commit(
        &mut self,
        ticket: Ticket,
        patch: Option<S::Patch>,
        out: &mut Vec<Action<S>>,
    ) {
        let request = self.locks.requests.remove(&ticket);
        let mut woken = match &request {
            Some(request) => self.unlock(&request.held),
            None => Vec::new(),
        };
        if let Some(request) = &request {
            let whole = request.wants.is_empty() && request.owed == 0;
            invariant!(P8, whole, "{ticket:?} commits; here is {}", request.describe());
        } else {
            invariant!(P8, patch.is_some(), "{ticket:?} commits, and has nothing here");
        }
        if let Some(patch) = patch {
            let (made, mut strays) = (&mut self.spare.made, Vec::new());
            made.clear();
            self.mesh.apply::<C>(patch, &self.directory, made, &mut strays);
            if !self.locks.absent.is_empty() {
                let awaited = made.iter().filter_map(|name| self.locks.absent.remove(name));
                woken.extend(awaited.flatten());
            }
            strays.sort_unstable();
            strays.dedup();
            for block in strays {
                self.send_stray(block, out);
            }
        }
        if let Some(request) = request {
            if request.home == self.id() {
                self.source.inserted(&self.mesh, &request.point);
            }
            self.spare.put(request);
        }
        self.wake(woken, out);
    }

    /// Unlocks tetrahedra; returns who waits for them (R4: everybody).
    fn unlock(&mut self, held: &[S::Tet]) -> Vec<Waiter> {
        let mut woken = Vec::new();
        for &t in held {
            self.mesh.set_holder(t, None);
            if self.locks.waiting.is_empty() {
                continue;
            }
            let Some(queue) = self.locks.waiting.get_mut(&t) else { continue };
            if C::REGRANT_ASKS_ALL {
                woken.append(queue);
            } else if let Some(first) = (0..queue.len()).min_by_key(|&k| queue[k]) {
                woken.push(queue.swap_remove(first));
            }
            if queue.is_empty() {
                self.locks.waiting.remove(&t);
            }
        }
        woken
    }

    /// Waiting walks and requests go on, the oldest first.
    pub(super) fn wake(&mut self, mut woken: Vec<Waiter>, out: &mut Vec<Action<S>>) {
        woken.sort_unstable_by_key(|waiter| match waiter {
            Waiter::Walk(ticket) | Waiter::Request(ticket) => *ticket,
        });
        for waiter in woken {
            match waiter {
                Waiter::Walk(ticket) => self.make_ready(ticket),
                Waiter::Request(ticket) => self.advance(ticket, out),
            }
        }
    }
}

/// Wants a neighbour of a locked tetrahedron.
pub(super) fn want<T>(
    neighbour: Neighbour<T>,
    wants: &mut Vec<Want<T>>,
    foreign: &mut Vec<Handle>,
) {
    match neighbour {
        Neighbour::Near(u) => wants.push(Want::Tet(u)),
        Neighbour::Far(handle) => foreign.push(handle),
    }
}

/// The memory of what has ended. It is no part of a worker's state: two workers that differ only in
/// it are the same.
#[derive(Debug)]
pub(super) struct Spare<S: Submesh> {
    requests: Vec<Box<Request<S>>>,
    pub(super) operations: Vec<Box<Operation<S>>>,
    /// Names of tetrahedra that a patch has made.
    made: Vec<Name>,
}

impl<S: Submesh> Spare<S> {
    /// The number of each that is kept at most.
    const MOST: usize = 64;

    pub(super) fn new() -> Self {
        Self { requests: Vec::new(), operations: Vec::new(), made: Vec::new() }
    }

    fn put(&mut self, request: Box<Request<S>>) {
        Self::keep(&mut self.requests, request);
    }

    pub(super) fn put_operation(&mut self, op: Box<Operation<S>>) {
        Self::keep(&mut self.operations, op);
    }

    fn keep<T>(ended: &mut Vec<T>, one: T) {
        if ended.len() < Self::MOST {
            ended.push(one);
        }
    }
}

impl<S: Submesh> Clone for Spare<S> {
    fn clone(&self) -> Self {
        Self::new()
    }
}

impl<S: Submesh> PartialEq for Spare<S> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<S: Submesh> Eq for Spare<S> {}

impl<S: Submesh> Hash for Spare<S> {
    fn hash<H: Hasher>(&self, _: &mut H) {}
}

/// Removes `waiter` from all queues.
fn forget<K: Ord + Copy>(queues: &mut BTreeMap<K, Vec<Waiter>>, waiter: Waiter) {
    queues.retain(|_, queue| {
        queue.retain(|&w| w != waiter);
        !queue.is_empty()
    });
}
