//! One worker's submesh: [`LocalMesh`] is [`Submesh`] over the exact kernel's
//! [`ltbw_core::submesh`].
//!
//! | module | what it holds |
//! |---|---|
//! | `wire` | the values that submeshes send each other |
//! | `name` | names of vertices |
//! | `vertices` | a submesh's vertices: their numbers here and their names |
//! | `blocks` | ownership: the block of a vertex and of a tetrahedron |
//! | `around` | the vertex closure of a cavity |
//! | `corners` | the corners of a cavity, each once |
//! | `piece` | the owner's side: what is in conflict, locked at once and described |
//! | `fill` | the home's retriangulation of a cavity, as one patch per owner |
//! | `apply` | patches, and tetrahedra that move |
//! | `start`, `redeal` | vertices along the curve, and workers ready to run; other cuts later |
//! | `coarse` | the coarse mesh, distributed |
//! | `gather`, `share` | the submeshes, put together; as values that travel |
//! | `inspect`, `probe` | what checkers see; a submesh as one that keeps more of it sees it |
//! | `point_queue` | the points to insert, on many cursors |
//!
//! Invariant P1: a tetrahedron with a far neighbour has a name, and keeps it until it is removed:
//! a message that names it may be under way even when no neighbour is far any more.

mod apply;
mod around;
mod blocks;
mod coarse;
mod corners;
mod fill;
mod gather;
mod inspect;
mod name;
mod piece;
mod point_queue;
pub(crate) mod probe;
pub(crate) mod redeal;
#[cfg(feature = "wire")]
pub mod share;
pub(crate) mod start;
mod vertices;
mod wire;

pub use blocks::Blocks;
#[cfg(feature = "domains")]
pub(crate) use blocks::{Mark, Weight};
pub use gather::{GatherError, Gathered, gather};
pub use name::{Place, VertexName, given, made};
pub use point_queue::PointQueue;
pub(crate) use probe::Again;
pub(crate) use start::Wanted;
pub use start::{Layout, Ownership, Prepared, Ready, Redeal, SharedInput};
#[cfg(feature = "wire")]
pub(crate) use start::{Sample, Sampled, Stretch};
pub use wire::{At, Lead, Link, Moving, NewTet, Patch, Piece, Relink, Side, To, WireVertex};

use crate::protocol::{
    BlockId, Costs, Directory, Found, Handle, Insert, Name, Neighbour, NoNews, Part, Rules,
    Submesh, SubmeshError, Ticket, Walk, WorkerId, invariant,
};
use around::finite;
use ltbw_core::search::Search;
use ltbw_core::submesh::{self as kernel, MeshParams, Work};
use ltbw_core::topology::{INFINITE, TetId, VertexId, tet_of};
use name::NOWHERE;
use rustc_hash::FxHashMap;
use vertices::Vertices;

/// The kernel's view of a submesh. Tetrahedra that others know are tagged with their names.
pub(crate) type Tets = kernel::Submesh<Ticket, Name, Handle>;

/// The tetrahedra of one worker, with names for those that others know.
#[derive(Debug)]
pub struct LocalMesh {
    tets: Tets,
    vertices: Vertices,
    blocks: Blocks,
    /// The ownership of tetrahedra, if not by blocks.
    fixed: Option<Fixed>,
    me: WorkerId,
    names: FxHashMap<Name, TetId>,
    /// Names given so far.
    named: u32,
    /// The places of points that were located but could not be inserted at once.
    located: FxHashMap<VertexName, TetId>,
    /// New tetrahedra of blocks that have moved, by block.
    strays: FxHashMap<BlockId, Vec<TetId>>,
    /// Points that were vertices already: name of the point, and of the vertex.
    duplicates: Vec<(VertexName, VertexName)>,
    /// Why the submesh has failed: it changes nothing any more.
    error: Option<SubmeshError>,
    reported: (u64, u64, u64),
    scratch: fill::Scratch,
    closure: kernel::Closure,
    search: Search,
    /// New tetrahedra of a patch or of a block, and the vertices of a patch.
    star: Vec<TetId>,
    rim: Vec<VertexId>,
}

/// The number of a worker's last name for a tetrahedron.
const LAST_NAME: u32 = u32::MAX >> 1;

/// Ownership that is no function of a tetrahedron's vertices: all that a worker has belongs to its
/// first block.
#[derive(Clone, Copy, Debug)]
struct Fixed {
    ownership: Ownership,
    /// Blocks of every worker.
    each: u32,
}

impl Fixed {
    /// The block that all of `worker` belongs to.
    fn block_of(self, worker: WorkerId) -> BlockId {
        BlockId::new(worker.number() * self.each)
    }

    /// The owner of the star of a point of block `block` that `home` inserts.
    fn owner_of_new(self, block: BlockId, home: WorkerId) -> WorkerId {
        match self.ownership {
            Ownership::Creator => home,
            _ => WorkerId::new(block.number() / self.each),
        }
    }
}

impl LocalMesh {
    /// A submesh without tetrahedra, whose worker is to insert the given vertices `own`.
    pub fn new(
        me: WorkerId,
        params: &MeshParams,
        blocks: Blocks,
        own: std::ops::Range<Place>,
    ) -> Self {
        Self {
            // A vacant slot names vertex 1, which must exist.
            tets: Tets::new(&params.vertices(own.len().max(1))),
            vertices: Vertices::new(blocks.clone(), me, own),
            blocks,
            fixed: None,
            me,
            names: FxHashMap::default(),
            named: 0,
            located: FxHashMap::default(),
            strays: FxHashMap::default(),
            duplicates: Vec::new(),
            error: None,
            reported: (0, 0, 0),
            scratch: fill::Scratch::default(),
            closure: kernel::Closure::default(),
            search: Search::default(),
            star: Vec::new(),
            rim: Vec::new(),
        }
    }

    /// The tetrahedra with their locks.
    pub fn tets(&self) -> &kernel::Submesh<Ticket, Name, Handle> {
        &self.tets
    }

    /// The name of a vertex here by its number in [`LocalMesh::tets`].
    pub fn name(&self, v: VertexId) -> VertexName {
        self.vertices.name(v)
    }

    /// The finite tetrahedra of given vertices alone, by their places along the curve.
    pub(crate) fn given_tets(&self) -> impl Iterator<Item = [Place; 4]> + '_ {
        self.tets.tets().filter(|(_, v)| v[3] != INFINITE).filter_map(|(_, v)| {
            let [a, b, c, d] = v.map(|v| given(self.vertices.name(v)));
            Some([a?, b?, c?, d?])
        })
    }

    /// Number of vertices that have a number here: those of the own stretch, and all that came.
    pub fn num_vertices(&self) -> usize {
        self.vertices.next().index() - 1
    }

    /// Number of tetrahedra, ghosts included.
    pub fn num_tets(&self) -> usize {
        self.tets.tets().count()
    }

    /// Notes from now on which interface faces change; all that there are count as new.
    pub(crate) fn watch_far_faces(&mut self) {
        self.tets.watch_far_faces();
    }

    /// Adds the places of those that have changed since the last call to a list.
    pub(crate) fn take_changed_far_faces(&mut self, list: &mut Vec<u32>) {
        self.tets.take_changed_far_faces(list);
    }

    /// Number of interface faces.
    pub fn num_interface_faces(&self) -> usize {
        self.tets.topology().iter().filter(|(_, tet)| tet.is_far_face()).count()
    }

    /// A tetrahedron here that belongs to another worker; a sound submesh has none, for those that
    /// change their owner are on their way.
    ///
    /// With ownership by blocks its block tells. With ownership by the newest vertex a tetrahedron
    /// of this worker has at least one vertex of this worker; a creator cannot be told.
    pub fn misplaced(&self, directory: &Directory) -> Option<TetId> {
        let block = |v: VertexId| self.vertices.block(v);
        let is_mine = |v: [VertexId; 4]| match self.fixed {
            None => directory.is_mine(self.block_with(v)),
            Some(Fixed { ownership: Ownership::Creator, .. }) => true,
            Some(_) => v.iter().any(|&v| v != INFINITE && directory.is_mine(block(v))),
        };
        self.tets.tets().find(|&(_, v)| !is_mine(v)).map(|(t, _)| t)
    }

    pub(crate) fn block_of(&self, t: TetId) -> BlockId {
        self.block_with(self.tets.vertices(t))
    }

    /// The block of a tetrahedron here with vertices `v`.
    fn block_with(&self, v: [VertexId; 4]) -> BlockId {
        self.fixed.map_or_else(|| block_of_tet(&self.vertices, v), |fixed| fixed.block_of(self.me))
    }

    /// The block of a vertex that may be none here.
    fn block_of_vertex(&self, vertex: &WireVertex) -> BlockId {
        if let Some(place) = given(vertex.name) {
            return self.blocks.of_vertex(place);
        }
        match self.vertices.number(vertex.name) {
            Some(INFINITE) => BlockId::default(),
            Some(v) => self.vertices.block(v),
            None => self.blocks.of_name(vertex.name, &vertex.point()),
        }
    }

    /// Says that there is no room for more tetrahedra: the run fails.
    fn fail_for_room(&mut self) {
        self.error = Some(self.no_room());
    }

    fn no_room(&self) -> SubmeshError {
        SubmeshError::NoRoom { limit: self.tets.max_tets() }
    }

    /// A name that was never given. Those of a step are fewer than there are beyond the last.
    fn fresh_name(&mut self) -> Name {
        self.named += 1;
        if self.named > LAST_NAME {
            self.error.get_or_insert(SubmeshError::NoNames { limit: LAST_NAME });
        }
        Name { by: self.me, number: self.named }
    }

    /// Goes on as if it had given nearly all names.
    #[cfg(test)]
    pub(crate) fn use_up_names(&mut self, left: u32) {
        self.named = LAST_NAME - left;
    }

    fn set_name(&mut self, t: TetId, name: Name) {
        self.names.insert(name, t);
        let before = self.tets.tag_of(t);
        let is_one = before.is_none_or(|n| n == name);
        invariant!(P2, is_one, "tetrahedron {t} has names {before:?} and {name:?}");
        self.tets.tag(t, name);
    }

    /// Removes a tetrahedron and its name.
    fn remove(&mut self, t: TetId) {
        if let Some(name) = self.tets.remove(t) {
            self.names.remove(&name);
        }
    }

    /// Forgets the names of tetrahedra that an insertion removed.
    fn forget_removed(&mut self) {
        for name in self.tets.take_removed_tags() {
            self.names.remove(&name);
        }
    }

    /// The name of `t`, a new one if it has none.
    fn ensure_name(&mut self, t: TetId) -> Name {
        match self.tets.tag_of(t) {
            Some(name) => name,
            None => {
                let name = self.fresh_name();
                self.set_name(t, name);
                name
            }
        }
    }

    fn wire_vertex(&self, v: VertexId) -> WireVertex {
        wire_vertex(&self.tets, &self.vertices, v)
    }

    /// The vertex at a place of the own stretch of the curve.
    fn vertex_at(&self, place: Place) -> WireVertex {
        self.wire_vertex(self.vertices.numbers_of(place..place).start)
    }

    fn wire_vertices(&self, t: TetId) -> [WireVertex; 4] {
        self.tets.vertices(t).map(|v| self.wire_vertex(v))
    }

    /// The neighbour in slot `u` beside a tetrahedron.
    #[inline]
    fn neighbour(&self, u: TetId) -> Neighbour<TetId> {
        self.tets.far(u).map_or(Neighbour::Near(u), Neighbour::Far)
    }
}

/// A vertex that a submesh knows, with its coordinates.
fn wire_vertex(tets: &Tets, vertices: &Vertices, v: VertexId) -> WireVertex {
    if v == INFINITE {
        WireVertex { name: NOWHERE, bits: [0; 3] }
    } else {
        WireVertex::new(vertices.name(v), tets.point(v))
    }
}

/// The block of a tetrahedron with vertices `v`.
#[inline]
fn block_of_tet(vertices: &Vertices, v: [VertexId; 4]) -> BlockId {
    let [a, b, c] = [v[0], v[1], v[2]].map(|v| vertices.block(v));
    blocks::prevailing([a, b, c], (v[3] != INFINITE).then(|| vertices.block(v[3])))
}

impl Submesh for LocalMesh {
    type Tet = TetId;
    type Point = WireVertex;
    type Piece = Piece;
    type Patch = Patch;
    type Cargo = Vec<Moving>;
    type News = NoNews;

    fn walk(&mut self, point: &WireVertex, from: Option<Name>) -> Walk<TetId> {
        let named = from.and_then(|name| self.names.get(&name).copied());
        let start = named.or_else(|| self.located.remove(&point.name));
        let v = self.vertices.number(point.name).unwrap_or(INFINITE);
        let walk = self.tets.walk(v, &point.point(), start);
        match walk {
            Walk::Locked(t) => _ = self.located.insert(point.name, t),
            Walk::Duplicate(v) => self.duplicates.push((point.name, self.vertices.name(v))),
            Walk::At(_) | Walk::Exits(_) | Walk::NoTets => {}
        }
        walk
    }

    fn insert(&mut self, point: &WireVertex, seed: TetId, directory: &Directory) -> Insert<TetId> {
        self.insert_seeing(point, seed, None::<Again<'_, fn(TetId) -> bool>>, directory, |_, _| {})
    }

    fn forget(&mut self, point: &WireVertex) {
        self.located.remove(&point.name);
    }

    fn resolve(&self, name: Name) -> Option<TetId> {
        self.names.get(&name).copied()
    }

    fn holder(&self, t: TetId) -> Option<Ticket> {
        self.tets.holder(t)
    }

    fn set_holder(&mut self, t: TetId, holder: Option<Ticket>) {
        match holder {
            Some(ticket) => self.tets.lock(t, ticket, false),
            None => self.tets.unlock(t),
        }
    }

    fn lock(&mut self, t: TetId, holder: Ticket, in_conflict: bool) {
        self.tets.lock(t, holder, in_conflict);
    }

    fn in_conflict(&mut self, t: TetId, point: &WireVertex) -> bool {
        self.tets.in_conflict(t, &point.point())
    }

    fn neighbours(&self, t: TetId, mut f: impl FnMut(Neighbour<TetId>)) {
        let around = self.tets.neighbours(t).map(tet_of);
        around.into_iter().for_each(|u| self.tets.prefetch(u));
        around.into_iter().for_each(|u| f(self.neighbour(u)));
    }

    fn corners(parts: &[Part<Piece>]) -> Vec<u64> {
        let pieces = parts.iter().flat_map(|(_, pieces)| pieces);
        finite(pieces.flat_map(|p| p.vertices.iter().map(|vertex| vertex.name)).collect())
    }

    fn neighbours_around(&self, t: TetId, corners: &[u64], mut f: impl FnMut(Neighbour<TetId>)) {
        self.around(t, corners).for_each(|u| f(self.neighbour(u)));
    }

    fn in_the_way(&mut self, point: &WireVertex, seed: TetId) -> Option<Insert<TetId>> {
        let way = self.vertex_closure(point, seed);
        if way.is_some() {
            self.located.insert(point.name, seed);
        }
        way
    }

    fn lock_all(
        &mut self,
        seed: TetId,
        point: &WireVertex,
        holder: Ticket,
        found: &mut Found<'_, Self>,
    ) -> bool {
        let mut closure = std::mem::take(&mut self.closure);
        let all = self.tets.lock_closure(seed, &point.point(), holder, &mut closure);
        if all {
            found.held.extend_from_slice(&closure.locked);
            let outer = closure.boundary.iter().map(|&(_, outer)| tet_of(outer));
            found.foreign.extend(outer.filter_map(|t| self.tets.far(t)));
            if closure.inside > 0 {
                found.pieces.push(self.describe_closure(&closure));
            }
        }
        self.closure = closure;
        all
    }

    fn pieces(&mut self, tets: &[TetId]) -> Vec<Piece> {
        if tets.is_empty() { Vec::new() } else { vec![self.describe(tets)] }
    }

    fn fill(
        &mut self,
        point: &WireVertex,
        parts: &[Part<Piece>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, Patch)> {
        self.fill_cavity(point, parts, whereabouts, directory)
    }

    fn apply<C: Rules>(
        &mut self,
        patch: Patch,
        directory: &Directory,
        made: &mut Vec<Name>,
        strays: &mut Vec<BlockId>,
    ) {
        // R12
        self.apply_patch(patch, directory, C::relinks_interface(), made, strays);
    }

    fn is_block_locked(&self, block: BlockId) -> bool {
        // A locked neighbour outside the block counts, too. Its home may be about to name it; if
        // moving the block gave it a name as well, it would have two.
        // What is not owned by blocks does not move at all.
        self.fixed.is_some()
            || self.tets.locked().any(|t| {
                let around = self.tets.neighbours(t).map(tet_of);
                let near = around.into_iter().filter(|&u| self.tets.is_live(u));
                near.chain([t]).any(|t| self.block_of(t) == block)
            })
    }

    fn extract<C: Rules>(
        &mut self,
        block: BlockId,
        moved: &mut dyn FnMut(TetId, Handle),
    ) -> Vec<Moving> {
        // R16
        self.extract_block(block, C::leaves_blocks(), moved, |_| {})
    }

    fn adopt(&mut self, cargo: Vec<Moving>, made: &mut Vec<Name>) {
        self.adopt_all(cargo, made);
    }

    fn made_at_once(&self) -> &[TetId] {
        self.tets.made_at_once()
    }

    fn installed(&self) -> &[TetId] {
        &self.star
    }

    #[inline]
    fn error(&self) -> Option<SubmeshError> {
        self.error
    }

    fn take_costs(&mut self) -> Costs {
        let Work { walk_steps, tests, made: created } = self.tets.work();
        let before = std::mem::replace(&mut self.reported, (walk_steps, tests, created));
        Costs {
            walk_steps: walk_steps - before.0,
            tests: tests - before.1,
            created: created - before.2,
            looks: 0,
        }
    }
}
