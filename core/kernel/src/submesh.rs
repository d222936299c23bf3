//! The tetrahedra of one worker of the parallel kernel, with their locks.
//!
//! Vertices have numbers of the submesh's own, 1 to n, dense in the order in which it meets them:
//! first those that it is to insert, along the curve, then what comes from others or is made on the
//! way. The names that vertices have elsewhere are the caller's. Where a neighbour belongs to
//! another submesh there stands a *far face*: a slot whose only neighbour is the tetrahedron in
//! front of it, with a *far handle* that means something to the caller.
//!
//! A tetrahedron can be *locked* for a holder: no walk enters it and no cavity takes it. A lock
//! takes the cached sphere away, so that unlocked tetrahedra are tested as fast as in a whole mesh:
//! what no sphere decides is looked at more closely, and then the lock or the far face is seen. For
//! the same reason a tetrahedron that the caller must hear of when it goes ([`Submesh::tag`]) never
//! has a sphere. Geometry knows of all this only that slots are tagged, and whom `locate`
//! bars.
//!
//! Numbers that come from outside are compared before they are used: a method that is given one of
//! no tetrahedron, face or vertex here panics. What is inside stays inside (I7): a link leads to a
//! slot, and a slot without a tetrahedron has no sphere, so that no walk and no cavity enters it,
//! even where the caller has not linked yet what it has made.

mod access;
mod assemble;
mod edit;
mod far;
mod insert;
mod lock;
mod lock_table;
mod params;
mod star;
mod walk;

pub use crate::mesh::Assembly;
pub use assemble::{AssembleError, Beyond, Numbered, Numbers, assemble};
pub use insert::Earlier;
pub use lock::Closure;
pub use params::{Extent, MeshParams};
pub use star::StarTet;

use crate::cavity::{Cavity, Conflict};
use crate::geometry::Geometry;
use crate::topology::{FaceId, INFINITE, TetId, Topology, VertexId};
use far::FarTable;
use lock_table::LockTable;
use ltbw_exact::Point;
use std::ops::Range;

/// Places of a submesh with a hint each: a power of two.
const PLACES: usize = 4096;
/// The number of these places for the submesh's own vertices at the start.
const OWN_PLACES: usize = 1024;

/// The work that a submesh has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Steps of walks.
    pub walk_steps: u64,
    /// Conflict tests.
    pub tests: u64,
    /// Tetrahedra made.
    pub made: u64,
}

/// The outcome of point location. `T` is a tetrahedron, `F` a far handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Walk<T, F> {
    /// An unlocked tetrahedron in conflict with the point.
    At(T),
    /// The walk leaves the submesh, to what lies beyond a far face.
    Exits(F),
    /// The walk met a locked tetrahedron.
    Locked(T),
    /// This vertex has the same coordinates: there is nothing to insert.
    Duplicate(VertexId),
    /// The submesh has no tetrahedron.
    NoTets,
}

/// The outcome of an insertion at once. `T` is a tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Insert<T> {
    /// The point is a vertex.
    Done,
    /// This tetrahedron of the closure is locked. Nothing has changed.
    Locked(T),
    /// No tetrahedron of the closure here is locked, but the closure or the new tetrahedra are in
    /// part another submesh's. Nothing has changed.
    Blocked,
    /// There is no room for the new tetrahedra. Nothing has changed.
    Full,
}

/// Which new tetrahedra of a local insertion would be the submesh's own.
#[derive(Clone, Copy, Debug)]
pub enum Owns<F> {
    /// All: none is looked at.
    All,
    /// None: the point is not inserted, but locks are met.
    None,
    /// Tetrahedra of own vertices alone, and otherwise those of whose vertices this is true.
    By(F),
}

/// The number of vertices of a range.
fn length(range: &Range<VertexId>) -> usize {
    (range.start.index()..range.end.index()).len()
}

/// The tetrahedra of one worker. `H` names the holder of a locked tetrahedron, `T` is the tag of a
/// tagged one, `F` says what lies beyond a far face.
#[derive(Debug)]
pub struct Submesh<H, T, F> {
    topology: Topology,
    geometry: Geometry,
    cavity: Cavity,
    /// Seed and point of the cavity in `cavity`, if that was blocked and is, with its boundary
    /// faces, what would be found now: whatever links, makes, removes, closes or opens a
    /// tetrahedron ends that.
    blocked: Option<(TetId, Point)>,
    /// Tetrahedra that are locked, or that the caller must hear of when an insertion removes them.
    locks: LockTable<H, T>,
    /// The far handles that the far faces stand for.
    far: FarTable<F>,
    own: Range<VertexId>,
    /// There are vertices outside the own range.
    others: bool,
    /// Labels of the tagged ones that the last insertion removed.
    removed_tags: Vec<T>,
    /// Where walks may start: tetrahedra made lately, the last one first.
    hints: [TetId; 8],
    /// The vertex inserted last.
    last: VertexId,
    /// A tetrahedron by place: vertices with near numbers are near each other.
    places: Vec<TetId>,
    /// Vertices of a place.
    grain: u32,
    /// Steps of walks so far.
    steps: u64,
    /// Tetrahedra made so far.
    made: u64,
}

impl<H: Copy + Eq, T: Copy, F: Copy> Submesh<H, T, F> {
    /// A submesh without tetrahedra.
    pub fn new(params: &MeshParams) -> Self {
        let MeshParams { low, high, wide, step, vertices, max_tets } = *params;
        let mut topology = Topology::default();
        topology.set_limit(max_tets);
        Self {
            topology,
            geometry: Geometry::submesh(low, high, wide, step, vertices),
            cavity: Cavity::for_vertices(vertices + 1),
            blocked: None,
            locks: LockTable::new(),
            far: FarTable::new(),
            own: INFINITE..INFINITE,
            others: true,
            removed_tags: Vec::new(),
            hints: [TetId::default(); 8],
            last: INFINITE,
            places: vec![TetId::new(u32::MAX); PLACES],
            grain: 1,
            steps: 0,
            made: 0,
        }
    }

    /// Reserves room for `tets` tetrahedra. A hint.
    pub fn reserve(&mut self, tets: usize) {
        debug_assert!(self.topology.is_empty());
        let limit = self.topology.limit();
        self.topology = Topology::with_capacity(tets.min(limit));
        self.topology.set_limit(limit);
        self.geometry.reserve_sphere_capacity(tets.min(limit));
    }

    /// Takes memory for about this many tetrahedra and vertices, on huge pages where there are any:
    /// it is not written to before they come, and arrays do not move as they grow. A hint.
    pub fn expect(&mut self, tets: usize, vertices: usize) {
        self.topology.expect(tets.min(self.topology.limit()));
        self.geometry.expect(vertices, tets.min(self.topology.limit()));
        self.cavity.reserve_vertices(vertices);
    }

    /// The largest number of tetrahedra that the submesh may have, hull ghosts and far faces
    /// included.
    pub fn max_tets(&self) -> usize {
        self.topology.limit()
    }

    /// Is there room for `tets` more tetrahedra and far faces?
    pub fn has_room(&self, tets: usize) -> bool {
        self.topology.reserve(tets).is_ok()
    }

    /// Says which vertices are the submesh's own: a tetrahedron with no other vertex belongs to it.
    pub fn set_own_range(&mut self, own: Range<VertexId>) {
        self.others =
            own.start > VertexId::new(1) || own.end.index() < self.geometry.points().len();
        self.grain = (length(&own) / OWN_PLACES + 1) as u32;
        self.own = own;
        let tets: Vec<(TetId, [VertexId; 4])> = self.tets().collect();
        for (t, v) in tets {
            self.cache_sphere(t);
            self.hint(t, v);
        }
    }

    /// Says that the vertices of `range` are not the submesh's own any more. What lies on the
    /// smaller side of them is not, either: the submesh's own vertices stay one range.
    pub fn leave_range(&mut self, range: Range<VertexId>) {
        let Range { start, end } = self.own;
        let below = start..range.start.clamp(start, end);
        let above = range.end.clamp(start, end)..end;
        self.own = if length(&below) < length(&above) { above } else { below };
        self.others = true;
    }

    /// The tetrahedra, far faces and free slots included.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The tetrahedra with their vertices, ghosts included.
    pub fn tets(&self) -> impl Iterator<Item = (TetId, [VertexId; 4])> + '_ {
        let real = self.topology.iter().filter(|(_, tet)| !tet.is_far_face());
        real.map(|(t, tet)| (t, tet.vertices()))
    }

    /// Is `t` a tetrahedron of this submesh?
    pub fn is_live(&self, t: TetId) -> bool {
        self.topology.get(t).is_some_and(|tet| !tet.is_vacant())
    }

    /// Is `v` a finite vertex here?
    pub fn is_vertex(&self, v: VertexId) -> bool {
        v != INFINITE && v.index() < self.geometry.points().len()
    }

    #[inline]
    #[track_caller]
    fn expect_slot(&self, t: TetId) {
        assert!(t.index() < self.topology.slots(), "there is no slot {t}");
    }

    #[inline]
    #[track_caller]
    fn expect_live(&self, t: TetId) {
        assert!(self.is_live(t), "there is no tetrahedron {t}");
    }

    #[inline]
    #[track_caller]
    fn expect_vertex(&self, v: VertexId) {
        assert!(v.index() < self.geometry.points().len(), "there is no vertex {v}");
    }

    /// The vertices of `t`; the vertex at infinity, 0, is only ever the last.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn vertices(&self, t: TetId) -> [VertexId; 4] {
        self.expect_slot(t);
        self.topology.tet(t).vertices()
    }

    /// The faces on the other sides of those of `t`, by the slot of the vertex opposite.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn neighbours(&self, t: TetId) -> [FaceId; 4] {
        self.expect_slot(t);
        self.topology.tet(t).neighbours()
    }

    /// Asks the processor to fetch tetrahedron `t`.
    #[inline]
    pub fn prefetch(&self, t: TetId) {
        self.topology.prefetch(t);
        self.geometry.prefetch_sphere(t);
    }

    /// The coordinates of vertex `v`.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[inline]
    pub fn point(&self, v: VertexId) -> Point {
        self.expect_vertex(v);
        *self.geometry.point(v)
    }

    /// The far face that far face `t` stands for; `None` if `t` is no far face.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn far(&self, t: TetId) -> Option<F> {
        self.expect_slot(t);
        self.far.get(self.geometry.sphere(t))
    }

    /// The place of far face `t`, by which changes are told; `None` if it is no far face.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn far_place(&self, t: TetId) -> Option<u32> {
        self.expect_slot(t);
        FarTable::<F>::place(self.geometry.sphere(t))
    }

    /// The far face at a place: its slot, the face before it and its far handle. `None` if there is
    /// none.
    pub fn far_at(&self, place: u32) -> Option<(TetId, FaceId, F)> {
        let (t, far) = self.far.at(place)?;
        Some((t, self.topology.tet(t).neighbours()[0], far))
    }

    /// Notes from now on the places at which far faces come, go or get another far handle. All that
    /// there are count as new.
    pub fn watch_far_faces(&mut self) {
        self.far.watch();
    }

    /// Adds the places noted since the last call to a list; one may be there more than once.
    pub fn take_changed_far_faces(&mut self, list: &mut Vec<u32>) {
        self.far.take_changed(list);
    }

    /// The work done so far.
    pub fn work(&self) -> Work {
        Work { walk_steps: self.steps, tests: self.predicates().insphere_calls, made: self.made }
    }

    /// Tags `t`: should an insertion remove it, its tag is among [`Submesh::take_removed_tags`]
    /// then.
    ///
    /// # Panics
    /// If there is no such tetrahedron.
    pub fn tag(&mut self, t: TetId, tag: T) {
        self.expect_live(t);
        let mut sphere = self.geometry.sphere(t);
        self.locks.entry(t, &mut sphere).tag = Some(tag);
        self.geometry.set_sphere(t, sphere);
    }

    /// The tag of `t`, if it is tagged.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn tag_of(&self, t: TetId) -> Option<T> {
        self.expect_slot(t);
        self.locks.get(self.geometry.sphere(t))?.tag
    }

    /// Takes the tag of `t` away and returns it.
    ///
    /// # Panics
    /// If there is no such slot.
    pub fn untag(&mut self, t: TetId) -> Option<T> {
        self.expect_slot(t);
        untag(&mut self.locks, &mut self.geometry, t)
    }

    /// Is tetrahedron `t` in conflict with `p`?
    ///
    /// # Panics
    /// If there is no such tetrahedron.
    pub fn in_conflict(&mut self, t: TetId, p: &Point) -> bool {
        self.expect_live(t);
        self.geometry.stats.insphere_calls += 1;
        let sphere = self.geometry.sphere(t);
        let sphere = self.locks.get(sphere).map_or(sphere, |entry| entry.sphere);
        if let Some(sign) = self.geometry.side(sphere, p) {
            return sign.is_positive();
        }
        let mut conflict = self.geometry.conflict_of(p);
        conflict.in_conflict(&self.topology, t)
    }

    /// The holder of the locked tetrahedron `t`; `None` if it is unlocked.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn holder(&self, t: TetId) -> Option<H> {
        self.lock_of(t).map(|(holder, _)| holder)
    }

    /// The locked tetrahedra.
    pub fn locked(&self) -> impl Iterator<Item = TetId> + '_ {
        self.locks.locked()
    }

    /// Locks `t`, which is unlocked, as a tetrahedron of the holder's cavity (`inside`) or not.
    ///
    /// # Panics
    /// If there is no such tetrahedron.
    pub fn lock(&mut self, t: TetId, holder: H, inside: bool) {
        self.expect_live(t);
        self.blocked = None;
        let mut sphere = self.geometry.sphere(t);
        self.locks.entry(t, &mut sphere).lock = Some((holder, inside));
        self.geometry.set_sphere(t, sphere);
    }

    /// The holder of the locked tetrahedron `t`, and whether as one of its cavity; `None` if it is
    /// unlocked.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn lock_of(&self, t: TetId) -> Option<(H, bool)> {
        self.expect_slot(t);
        self.locks.get(self.geometry.sphere(t))?.lock
    }

    fn is_locked(&self, t: TetId) -> bool {
        self.locks.is_locked(self.geometry.sphere(t))
    }

    /// Unlocks `t`; nothing happens if it is unlocked.
    ///
    /// # Panics
    /// If there is no such slot.
    pub fn unlock(&mut self, t: TetId) {
        self.expect_slot(t);
        self.blocked = None;
        let mut sphere = self.geometry.sphere(t);
        self.locks.unlock(&mut sphere);
        self.geometry.set_sphere(t, sphere);
    }
}

/// Takes the tag of `t` away.
fn untag<H: Copy, T: Copy>(
    locks: &mut LockTable<H, T>,
    geometry: &mut Geometry,
    t: TetId,
) -> Option<T> {
    let mut sphere = geometry.sphere(t);
    let tag = locks.untag(&mut sphere);
    geometry.set_sphere(t, sphere);
    tag
}
