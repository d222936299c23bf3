//! The state of a worker's operations and lock requests, without the steps that change it.

use super::submesh::{Neighbour, Submesh};
use super::table::Table;
use super::{Attempt, BlockId, Handle, Name, Ticket, WorkerId};
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{Hash, Hasher};

/// An operation at its home.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Operation<S: Submesh> {
    pub(crate) point: S::Point,
    pub(crate) attempt: Attempt,
    pub(crate) phase: Phase,
    /// Workers asked in this attempt, with the number of `Expand` not answered yet.
    pub(crate) asked: Table<WorkerId, u32>,
    /// Every handle asked for in this attempt, and whom.
    pub(crate) whereabouts: Table<Name, WorkerId>,
    /// The tetrahedra granted, by owner.
    pub(crate) parts: Table<WorkerId, Vec<S::Piece>>,
    /// The cavity's vertices, under the vertex closure and when the cavity is complete.
    pub(crate) around: Vec<u64>,
}

/// A point whose walk starts or goes on, and its operation.
pub(crate) struct Start<S: Submesh> {
    /// `None` until the point is found to need an operation.
    pub(crate) ticket: Option<Ticket>,
    pub(crate) attempt: Attempt,
    pub(crate) point: S::Point,
}

/// Where an operation is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Phase {
    /// It can start (again).
    Ready,
    /// Its walk waits.
    Walking,
    /// It collects its closure.
    Expanding,
    /// It is set back, and this number of releases is not acknowledged yet.
    Releasing(u32),
    /// It is set back, and waits for its backoff to end (the paper's rule).
    Backoff,
}

/// The operations at home at one worker.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Operations<S: Submesh> {
    pub(crate) all: BTreeMap<Ticket, Box<Operation<S>>>,
    /// Operations that can start (again): the paper's QL.
    pub(crate) ready: BTreeSet<Ticket>,
}

impl<S: Submesh> Operations<S> {
    pub(crate) fn new() -> Self {
        Self { all: BTreeMap::new(), ready: BTreeSet::new() }
    }
}

/// The content of a `Grant`, but for its ticket and attempt.
pub(crate) struct Granted<S: Submesh> {
    pub(crate) answers: u32,
    pub(crate) pieces: Vec<S::Piece>,
    pub(crate) foreign: Vec<Handle>,
    pub(crate) bounced: Vec<Handle>,
    pub(crate) moved: Vec<(BlockId, WorkerId, u32)>,
}

impl<S: Submesh> Operation<S> {
    /// A new operation in the memory of one that has ended.
    pub(crate) fn renew(
        mut self: Box<Self>,
        point: S::Point,
        attempt: Attempt,
        phase: Phase,
    ) -> Box<Self> {
        let Self { asked, whereabouts, parts, around, .. } = &mut *self;
        asked.clear();
        whereabouts.clear();
        parts.clear();
        around.clear();
        (self.point, self.attempt, self.phase) = (point, attempt, phase);
        self
    }

    pub(crate) fn new(point: S::Point, attempt: Attempt, phase: Phase) -> Box<Self> {
        Box::new(Self {
            point,
            attempt,
            phase,
            asked: Table::default(),
            whereabouts: Table::default(),
            parts: Table::default(),
            around: Vec::new(),
        })
    }
}

/// A tetrahedron to lock and test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Want<T> {
    Tet(T),
    Seed(Handle),
}

/// The walk or request that waits for a tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Waiter {
    /// The walk of an operation at home here.
    Walk(Ticket),
    /// A request.
    Request(Ticket),
}

/// One operation's part of its closure here. It keeps its locks while it waits.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Request<S: Submesh> {
    pub(crate) home: WorkerId,
    pub(crate) attempt: Attempt,
    pub(crate) point: S::Point,
    /// A stack: the last one is looked at next, or waited for.
    pub(crate) wants: Vec<Want<S::Tet>>,
    /// All tetrahedra locked.
    pub(crate) held: Vec<S::Tet>,
    /// Tetrahedra in conflict, since the last grant, that were locked one by one ...
    pub(crate) cavity: Vec<S::Tet>,
    /// ... and those locked at once.
    pub(crate) pieces: Vec<S::Piece>,
    /// Far neighbours of those, or of all that is held when what touches the cavity is wanted.
    pub(crate) foreign: Vec<Handle>,
    /// Seeds whose block is not here any more.
    pub(crate) bounced: Vec<Handle>,
    /// `Expand` not answered yet.
    pub(crate) owed: u32,
    /// The cavity's vertices, under the vertex closure: what touches them is to be locked.
    pub(crate) around: Vec<u64>,
    /// Waiting, or denied: an event has to come first.
    pub(crate) stalled: bool,
    /// Its home was told that an older operation waits for it.
    pub(crate) wounded: bool,
}

/// The locks of one worker: their requests, and what waits for them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Locks<S: Submesh> {
    /// Closures of which a part is here.
    pub(crate) requests: BTreeMap<Ticket, Box<Request<S>>>,
    /// Walks and requests that wait for a locked tetrahedron.
    pub(crate) waiting: BTreeMap<S::Tet, Vec<Waiter>>,
    /// Walks and requests that wait for a tetrahedron that is not installed yet.
    pub(crate) absent: BTreeMap<Name, Vec<Waiter>>,
}

impl<S: Submesh> Locks<S> {
    pub(crate) fn new() -> Self {
        Self { requests: BTreeMap::new(), waiting: BTreeMap::new(), absent: BTreeMap::new() }
    }

    /// Is nothing locked, wanted or awaited?
    pub(crate) fn is_empty(&self) -> bool {
        self.requests.is_empty() && self.waiting.is_empty() && self.absent.is_empty()
    }
}

/// The attempt of an operation that asks for locks.
pub(crate) struct Asker<P> {
    pub(crate) home: WorkerId,
    pub(crate) attempt: Attempt,
    pub(crate) point: P,
}

impl<S: Submesh> Request<S> {
    pub(crate) fn new(asker: Asker<S::Point>) -> Box<Self> {
        let Asker { home, attempt, point } = asker;
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
    pub(crate) fn renew(mut self: Box<Self>, asker: Asker<S::Point>) -> Box<Self> {
        let Self { wants, held, cavity, pieces, foreign, bounced, around, .. } = &mut *self;
        around.clear();
        wants.clear();
        held.clear();
        cavity.clear();
        pieces.clear();
        foreign.clear();
        bounced.clear();
        (self.home, self.attempt, self.point) = (asker.home, asker.attempt, asker.point);
        (self.owed, self.stalled, self.wounded) = (0, false, false);
        self
    }

    /// Its state, for people.
    pub(crate) fn describe(&self) -> String {
        let Self { home, attempt, wants, held, owed, stalled, .. } = self;
        let (wants, held) = (wants.len(), held.len());
        format!(
            "home {home}, attempt {attempt}, {wants} wanted, {held} held, {owed} owed, \
             stalled: {stalled}"
        )
    }
}

/// Wants a neighbour of a locked tetrahedron.
pub(crate) fn want<T>(
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
pub(crate) struct Spare<S: Submesh> {
    pub(super) requests: Vec<Box<Request<S>>>,
    pub(crate) operations: Vec<Box<Operation<S>>>,
    /// Names of tetrahedra that a patch has made.
    pub(super) made: Vec<Name>,
}

impl<S: Submesh> Spare<S> {
    /// The number of each that is kept at most.
    const MOST: usize = 64;

    pub(crate) fn new() -> Self {
        Self { requests: Vec::new(), operations: Vec::new(), made: Vec::new() }
    }

    pub(super) fn put(&mut self, request: Box<Request<S>>) {
        Self::keep(&mut self.requests, request);
    }

    pub(crate) fn put_operation(&mut self, op: Box<Operation<S>>) {
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
