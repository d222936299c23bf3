//! The protocol's view of a mesh and of a supply of points. It never sees a coordinate.

use super::news::Standing;
use super::{BlockId, Directory, Handle, Name, Rules, Ticket, WorkerId};
pub use ltbw_core::submesh::Insert;
use std::fmt::Debug;
use std::hash::Hash;

/// A worker, and what it has described of a cavity.
pub type Part<P> = (WorkerId, Vec<P>);

/// A face neighbour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Neighbour<T> {
    /// A tetrahedron of the same worker.
    Near(T),
    /// A tetrahedron of another worker.
    Far(Handle),
}

/// The end of a point location: `T` is the local handle of a tetrahedron.
pub type Walk<T> = ltbw_core::submesh::Walk<T, Handle>;

/// Why a submesh could not do what it was asked for. It has changed nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum SubmeshError {
    /// The submesh has no room for more tetrahedra.
    #[error("a submesh would exceed {limit} tetrahedra, hull ghosts and interface faces included")]
    NoRoom {
        /// The most that it may have.
        limit: usize,
    },
    /// The worker has given as many tetrahedra names as there are.
    #[error("a worker has named {limit} tetrahedra, and there are no more names")]
    NoNames {
        /// The number of names.
        limit: u32,
    },
    /// A message names something by a number that is none here: the worker that sent it does not
    /// obey the protocol.
    #[error("a message names {what} {number}, which is not there")]
    Unknown {
        /// The kind of thing that it numbers.
        what: &'static str,
        /// The number.
        number: u32,
    },
}

/// Work done in a submesh, for cost models.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Costs {
    /// Tetrahedra passed by walks.
    pub walk_steps: u64,
    /// Conflict tests.
    pub tests: u64,
    /// Tetrahedra created.
    pub created: u64,
    /// Tetrahedra looked at for their bounds.
    pub looks: u64,
}

/// Where what [`Submesh::lock_all`] finds is appended.
#[derive(Debug)]
pub struct Found<'a, S: Submesh> {
    /// All tetrahedra that it locks.
    pub held: &'a mut Vec<S::Tet>,
    /// The tetrahedra in conflict, as [`Submesh::pieces`] would describe them.
    pub pieces: &'a mut Vec<S::Piece>,
    /// The far neighbours of those.
    pub foreign: &'a mut Vec<Handle>,
}

/// The tetrahedra of one worker. Local handles (`Tet`) of locked tetrahedra are stable.
pub trait Submesh: Sized {
    /// Local handle of a tetrahedron.
    type Tet: Copy + Eq + Ord + Hash + Debug;
    /// A point to insert.
    type Point: Clone + Eq + Hash + Debug;
    /// A tetrahedron in conflict, or some of them, as their owner describes them to the home.
    type Piece: Clone + Eq + Hash + Debug;
    /// The changes that a filled cavity brings to one worker's submesh.
    type Patch: Clone + Eq + Hash + Debug;
    /// Tetrahedra that change their owner.
    type Cargo: Clone + Eq + Hash + Debug;
    /// The news that its sources tell each other.
    type News: Clone + Eq + Hash + Debug;

    /// Walks towards `point`, from the named tetrahedron if it is there. Never enters a locked
    /// tetrahedron.
    fn walk(&mut self, point: &Self::Point, from: Option<Name>) -> Walk<Self::Tet>;

    /// Inserts `point`, which conflicts with `seed`, if the closure and all new tetrahedra are
    /// this worker's and no tetrahedron of the closure is locked. Else changes nothing.
    fn insert(
        &mut self,
        point: &Self::Point,
        seed: Self::Tet,
        directory: &Directory,
    ) -> Insert<Self::Tet>;

    /// Forgets what it has kept of a point that is not to be inserted, or that is a vertex.
    fn forget(&mut self, point: &Self::Point) {
        let _ = point;
    }

    /// The tetrahedron of this name, if it is here.
    fn resolve(&self, name: Name) -> Option<Self::Tet>;

    /// The operation that has locked `t`.
    fn holder(&self, t: Self::Tet) -> Option<Ticket>;

    /// Locks or unlocks `t`.
    fn set_holder(&mut self, t: Self::Tet, holder: Option<Ticket>);

    /// Locks `t` for an operation whose point it is in conflict with or not. [`Submesh::pieces`]
    /// may leave out what leads from one tetrahedron in conflict to another.
    fn lock(&mut self, t: Self::Tet, holder: Ticket, in_conflict: bool) {
        let _ = in_conflict;
        self.set_holder(t, Some(holder));
    }

    /// Locks `seed`, which is not locked, and at once all that the loop over single tetrahedra
    /// would lock from there: the tetrahedra in conflict with `point` that are connected to it
    /// here, and the neighbours of these. Changes nothing and returns `false` if one of them is
    /// locked by another operation, or if the submesh has no such way.
    ///
    /// It describes what is in conflict before the grant: that is sound only where
    /// [`Submesh::is_block_locked`] counts locked neighbours, too, so that what lies beside a
    /// locked tetrahedron stays and keeps its name.
    fn lock_all(
        &mut self,
        seed: Self::Tet,
        point: &Self::Point,
        holder: Ticket,
        found: &mut Found<'_, Self>,
    ) -> bool {
        let _ = (seed, point, holder, found);
        false
    }

    /// Is `t` in conflict with `point`?
    fn in_conflict(&mut self, t: Self::Tet, point: &Self::Point) -> bool;

    /// Calls `f` with every face neighbour of `t`.
    fn neighbours(&self, t: Self::Tet, f: impl FnMut(Neighbour<Self::Tet>));

    /// The finite vertices of a cavity, ascending; none if the submesh knows the face closure only.
    fn corners(parts: &[Part<Self::Piece>]) -> Vec<u64> {
        let _ = parts;
        Vec::new()
    }

    /// Calls `f` with every neighbour of `t` across a face that has one of these vertices. The star
    /// of a vertex is connected through such faces.
    fn neighbours_around(
        &self,
        t: Self::Tet,
        corners: &[u64],
        f: impl FnMut(Neighbour<Self::Tet>),
    ) {
        let _ = (t, corners, f);
    }

    /// The obstacle in the vertex closure of a local insertion: something locked
    /// ([`Insert::Locked`]), or another worker's part ([`Insert::Blocked`]).
    fn in_the_way(&mut self, point: &Self::Point, seed: Self::Tet) -> Option<Insert<Self::Tet>> {
        let _ = (point, seed);
        None
    }

    /// Describes tetrahedra to a home: they are in conflict, and all of them and of their
    /// neighbours here are locked by one operation.
    fn pieces(&mut self, tets: &[Self::Tet]) -> Vec<Self::Piece>;

    /// The point of a piece's or patch's operation replaces the cavity made of `parts`: what
    /// changes, by worker. `whereabouts` has, for every handle met, the worker that has locked it.
    fn fill(
        &mut self,
        point: &Self::Point,
        parts: &[Part<Self::Piece>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, Self::Patch)>;

    /// Applies a patch. Pushes the names of new tetrahedra to `made`, and the blocks of those that
    /// are not this worker's any more to `strays`.
    fn apply<C: Rules>(
        &mut self,
        patch: Self::Patch,
        directory: &Directory,
        made: &mut Vec<Name>,
        strays: &mut Vec<BlockId>,
    );

    /// Is any tetrahedron of `block` locked? A submesh whose pieces have names for their neighbours
    /// counts a locked neighbour of one, too: else home and owner might name it twice.
    fn is_block_locked(&self, block: BlockId) -> bool;

    /// Removes and returns all tetrahedra of `block`, none of which is locked. Calls `moved` with
    /// every local handle that a neighbour had and that stops to be one, and its far handle.
    fn extract<C: Rules>(
        &mut self,
        block: BlockId,
        moved: &mut dyn FnMut(Self::Tet, Handle),
    ) -> Self::Cargo;

    /// Installs extracted tetrahedra. Pushes their names to `made`.
    fn adopt(&mut self, cargo: Self::Cargo, made: &mut Vec<Name>);

    /// The tetrahedra that the last insertion at once has made.
    fn made_at_once(&self) -> &[Self::Tet] {
        &[]
    }

    /// The tetrahedra that the last patch or the last ones extracted elsewhere have brought here.
    fn installed(&self) -> &[Self::Tet] {
        &[]
    }

    /// Why the submesh has failed, if it has. It changes nothing any more, and the run fails.
    fn error(&self) -> Option<SubmeshError> {
        None
    }

    /// The work done since the last call.
    fn take_costs(&mut self) -> Costs {
        Costs::default()
    }
}

/// The item of a point: what it is inserted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Item<T> {
    /// None: the point is inserted for its own sake, wherever it lies.
    Free,
    /// A tetrahedron of this worker that is to go. If it is in conflict with the point, the
    /// operation begins there, without a walk.
    At(T),
    /// The item that it was to be inserted for is gone.
    Gone,
}

/// Where points to insert come from: the paper's field `Fd` of points, or its list `LB` of bad
/// elements when the mesh is refined.
pub trait Source<S: Submesh> {
    /// Does it want to hear of tetrahedra?
    const WATCHES: bool = false;

    /// The next point.
    fn next(&mut self, mesh: &S) -> Option<S::Point>;

    /// Are there no more points now?
    fn is_empty(&self) -> bool;

    /// Would [`Source::next`] give one? There may be points that should wait for others.
    fn is_ready(&self) -> bool {
        !self.is_empty()
    }

    /// The item of a point that it has given, looked at whenever the point's operation starts. From
    /// there to the commit the item is locked.
    fn item(&self, mesh: &S, point: &S::Point) -> Item<S::Tet> {
        let _ = (mesh, point);
        Item::Free
    }

    /// Tetrahedra have appeared at this worker: made here, or come from others. Some may have left
    /// again. Called if it [`Source::WATCHES`].
    fn created(&mut self, mesh: &S, tets: &[S::Tet]) {
        let _ = (mesh, tets);
    }

    /// `point` has left for another worker, was a vertex already, or its item is gone.
    fn released(&mut self, point: &S::Point) {
        let _ = point;
    }

    /// `point` is a vertex now; the tetrahedra around it are of this worker in part.
    fn inserted(&mut self, mesh: &S, point: &S::Point);

    /// Takes out the points of `block`, which moves away.
    fn remove_block(&mut self, mesh: &S, block: BlockId) -> Vec<S::Point>;

    /// Takes in points of a block that has moved here.
    fn add(&mut self, block: BlockId, points: Vec<S::Point>);

    /// Does it look at the counts of its worker's [`Standing`]?
    fn counts(&self) -> bool {
        false
    }

    /// Is there something to do beside giving points?
    fn has_thoughts(&self, standing: Standing) -> bool {
        let _ = standing;
        false
    }

    /// Does some of that.
    fn think(&mut self, mesh: &mut S, directory: &Directory, standing: Standing) {
        let _ = (mesh, directory, standing);
    }

    /// Takes what the source of worker `from` tells.
    fn hear(&mut self, mesh: &mut S, directory: &Directory, from: WorkerId, news: S::News) {
        let _ = (mesh, directory, from, news);
    }

    /// The next thing to tell another source, or itself.
    fn tell(&mut self) -> Option<(WorkerId, S::News)> {
        None
    }

    /// The kinds of news of which none may be under way, to anybody, while this source is as it is:
    /// it has passed the barrier before which they are taken, and nobody sends the next ones before
    /// it has said its word (P12).
    fn excluded(&self) -> &'static [&'static str] {
        &[]
    }

    /// Its state, for people who look at a run that makes no progress.
    fn describe(&self) -> String {
        if self.is_empty() { "no points left" } else { "points left" }.to_owned()
    }

    /// Drops all points: the run is cancelled. A block that moves away afterwards takes none along.
    fn clear(&mut self);
}
