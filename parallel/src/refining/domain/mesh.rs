//! One worker's submesh of a domain: that of points, with the carriers of its vertices and the
//! regions of its tetrahedra.
//!
//! The verdict on a point falls at its home, when the whole closure is locked: `fill`. A point that
//! is not to be inserted ends there, too: its patches change nothing, but for the boundary item
//! that goes first, which one of them brings to the owner of a tetrahedron at it.

use super::carriers::Carriers;
use super::chosen::{AtOnce, Notes, Slots, insert_chosen};
use super::values::{
    Asked, BoundVertex, DomainCargo, DomainPatch, DomainPiece, DomainPoint, End, ItemKey,
};
use crate::mesh::{LocalMesh, Piece, VertexName};
use crate::protocol::{
    BlockId, Correct, Costs, Directory, Found, Handle, Insert, Name, Neighbour, Part, Rules,
    Submesh, SubmeshError, Ticket, Walk, WorkerId,
};
use crate::refining::news::DomainNews;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_core::{expect, prefetch};
use ltbw_exact::Point;
use ltbw_refine::{Carrier, Complex, Corner};
use rustc_hash::FxHashSet;
use std::cell::{Cell, RefCell};
use std::sync::Arc;

/// A submesh of a domain.
#[derive(Debug)]
pub struct DomainMesh<'c> {
    pub(crate) inner: LocalMesh,
    pub(crate) complex: Arc<Complex<'c>>,
    /// Work done outside the inner submesh.
    extra: Costs,
    /// Steps on straight ways.
    way_steps: Cell<u64>,
    me: WorkerId,
    carriers: Carriers,
    slots: Slots,
    /// The boundary item that goes first, by the last patch, until it is taken.
    asked: Cell<Option<Asked>>,
    /// The end of the last operation whose home is here.
    end: Option<End>,
    /// The way in which the last point was inserted, or given up, at once, if it was.
    at_once: AtOnce,
    /// The regions of a star.
    star: Vec<u32>,
    /// Scratch: pieces that the inner submesh has found.
    pieces: Vec<Piece>,
    /// Boundary items that cannot be split, as far as this worker has tried.
    pub(super) refused: RefCell<FxHashSet<ItemKey>>,
    /// Does no block move?
    is_fixed: bool,
}

impl<'c> DomainMesh<'c> {
    /// A submesh whose vertices, given by name, and tetrahedra have these carriers and regions.
    pub(crate) fn new(
        inner: LocalMesh,
        complex: Arc<Complex<'c>>,
        me: WorkerId,
        carrier: impl Fn(VertexName) -> Carrier,
        region: impl Fn(TetId) -> u32,
    ) -> Self {
        let numbers = 1..=inner.num_vertices();
        let carriers = Carriers::of(numbers.map(|v| carrier(inner.name(VertexId::at(v)))));
        let mut slots = Slots::default();
        for (t, _) in inner.tets().tets().filter(|(_, v)| v[3] != INFINITE) {
            slots.put(t, region(t));
        }
        Self {
            inner,
            complex,
            extra: Costs::default(),
            way_steps: Cell::default(),
            me,
            carriers,
            slots,
            asked: Cell::default(),
            end: None,
            at_once: AtOnce::No,
            star: Vec::new(),
            pieces: Vec::new(),
            refused: RefCell::default(),
            is_fixed: true,
        }
    }

    /// Takes memory for about this many tetrahedra. A hint.
    pub(crate) fn expect_tets(&mut self, tets: usize) {
        self.inner.expect_tets(tets);
        expect(&mut self.slots.regions, tets);
        self.carriers.expect_tets(tets);
    }

    /// Lets blocks move.
    pub(crate) fn let_blocks_move(&mut self) {
        self.is_fixed = false;
    }

    /// Enters the carriers of vertices on the boundary.
    fn enter_carriers(&mut self, bound: Vec<BoundVertex>) {
        for (name, carrier) in bound {
            if let Some(v) = self.inner.number(name) {
                self.carriers.set(v, carrier);
            }
        }
    }

    /// Asks the processor to fetch a tetrahedron, and its region.
    pub(crate) fn prefetch(&self, t: TetId) {
        self.inner.tets().prefetch(t);
        prefetch(self.slots.regions.as_ptr().wrapping_add(t.index()));
    }

    /// The worker whose submesh it is.
    pub(crate) fn me(&self) -> WorkerId {
        self.me
    }

    /// Is there still this tetrahedron, given by its slot and vertices?
    pub(crate) fn has(&self, t: TetId, v: [VertexId; 4]) -> bool {
        let tets = self.inner.tets();
        tets.is_live(t) && tets.vertices(t) == v
    }

    /// The region of a tetrahedron.
    pub(crate) fn region(&self, t: TetId) -> u32 {
        self.slots.region(t)
    }

    /// Gives a tetrahedron another region.
    pub(crate) fn set_region(&mut self, t: TetId, region: u32) {
        self.slots.put(t, region);
    }

    /// The regions of all slots, which this submesh has no more.
    pub(crate) fn take_regions(&mut self) -> Vec<u32> {
        let mut regions = std::mem::take(&mut self.slots.regions);
        regions.resize(self.inner.tets().topology().slots(), 0);
        regions
    }

    /// A round begins: its choice finds cavities in the mesh as it is.
    pub(crate) fn begin_round(&mut self) {
        self.slots.begin_round();
    }

    /// Remembers the cavity that the choice has found for a point, which is inserted next.
    pub(crate) fn remember(&self, name: VertexName, cavity: &[TetId]) {
        self.slots.remember(name, cavity);
    }

    pub(crate) fn carrier(&self, v: VertexId) -> Carrier {
        self.carriers.at(v)
    }

    pub(super) fn set_carrier(&mut self, v: VertexId, carrier: Carrier) {
        self.carriers.set(v, carrier);
    }

    /// Is a vertex on the boundary?
    pub(crate) fn is_bound(&self, v: VertexId) -> bool {
        self.carriers.is_bound(v)
    }

    /// A vertex, as it is told to others.
    pub(crate) fn corner(&self, v: VertexId) -> Corner {
        Corner { point: self.point(v), carrier: self.carrier(v) }
    }

    pub(crate) fn point(&self, v: VertexId) -> Point {
        self.inner.tets().point(v)
    }

    /// Is a tetrahedron in conflict with a point?
    pub(crate) fn conflicts(&mut self, t: TetId, p: &Point) -> bool {
        self.inner.conflicts(t, p)
    }

    /// The cavity of a point, from a tetrahedron in conflict with it on, if its whole closure is
    /// here and unlocked.
    pub(crate) fn cavity_of(&mut self, seed: TetId, p: &Point) -> Option<&[TetId]> {
        self.inner.cavity_of(seed, p)
    }

    /// Looks for a tetrahedron in conflict with a point, from one of this submesh on.
    pub(crate) fn seek(&mut self, p: &Point, from: Option<TetId>) -> Walk<TetId> {
        self.inner.seek(p, from)
    }

    /// Counts steps of a walk outside the inner submesh.
    pub(crate) fn count_steps(&mut self, steps: u64) {
        self.extra.walk_steps += steps;
    }

    /// Counts steps on a straight way.
    pub(super) fn count_way(&self, steps: u64) {
        self.way_steps.set(self.way_steps.get() + steps);
    }

    /// Counts tetrahedra that were looked at for their bounds.
    pub(crate) fn count_looks(&mut self, looks: u64) {
        self.extra.looks += looks;
    }

    /// Takes the boundary item that the last patch has brought.
    pub(super) fn take_asked(&self) -> Option<Asked> {
        self.asked.take()
    }

    pub(super) fn end(&self) -> Option<End> {
        self.end
    }

    /// Notes that a boundary item cannot be split.
    pub(super) fn refuse(&self, key: ItemKey) {
        self.refused.borrow_mut().insert(key);
    }

    /// Was a boundary item found that it cannot be split?
    pub(super) fn is_refused(&self, key: &ItemKey) -> bool {
        self.refused.borrow().contains(key)
    }
}

impl Submesh for DomainMesh<'_> {
    type Tet = TetId;
    type Point = DomainPoint;
    type Piece = DomainPiece;
    type Patch = DomainPatch;
    type Cargo = DomainCargo;
    type News = DomainNews;

    /// No walk: a point of the boundary begins at its tetrahedron although that is locked. It waits
    /// for the lock as an operation, whose age counts, and not outside.
    fn walk(&mut self, point: &DomainPoint, from: Option<Name>) -> Walk<TetId> {
        match point.is_chosen {
            true => self.inner.walk(&point.vertex, from),
            false => Walk::At(point.seed),
        }
    }

    /// If nothing of the closure is locked or another worker's, the verdict falls at once.
    fn insert(&mut self, point: &DomainPoint, seed: TetId, directory: &Directory) -> Insert<TetId> {
        self.at_once = AtOnce::No;
        if point.is_chosen {
            let Self { inner, carriers, slots, star, .. } = self;
            self.at_once = AtOnce::Filled;
            let notes = Notes { carriers, slots, star };
            return insert_chosen(inner, notes, point, seed, directory);
        }
        let waits = point.carrier != Carrier::Free;
        if waits && self.inner.holder(seed).is_some() {
            return Insert::Blocked;
        }
        match self.inner.probe(&point.vertex, seed) {
            Insert::Blocked => {}
            Insert::Locked(_) if waits => return Insert::Blocked,
            other => return other,
        }
        let (mut held, mut foreign, mut pieces) = (Vec::new(), Vec::new(), Vec::new());
        let mut found = Found { held: &mut held, foreign: &mut foreign, pieces: &mut pieces };
        let nobody = Ticket { clock: 0, worker: self.me, sequence: 0 };
        let all = self.lock_all(seed, point, nobody, &mut found);
        let parts = [(self.me, pieces)];
        let done = match all && foreign.is_empty() {
            true => self.decide(point, &parts, &|_| None, directory),
            false => Vec::new(),
        };
        held.iter().for_each(|&t| self.inner.set_holder(t, None));
        let mut done = done.into_iter();
        // New tetrahedra may belong to others even here.
        let (Some((worker, patch)), None) = (done.next(), done.next()) else {
            return Insert::Blocked;
        };
        if worker != self.me {
            return Insert::Blocked;
        }
        self.at_once = AtOnce::Patched;
        // Nothing gets a name, and all is this worker's by the directory of this very step.
        let mut strays = Vec::new();
        self.apply::<Correct>(patch, directory, &mut Vec::new(), &mut strays);
        debug_assert!(strays.is_empty());
        Insert::Done
    }

    fn forget(&mut self, point: &DomainPoint) {
        self.inner.forget(&point.vertex);
    }

    fn resolve(&self, name: Name) -> Option<TetId> {
        self.inner.resolve(name)
    }

    fn holder(&self, t: TetId) -> Option<Ticket> {
        self.inner.holder(t)
    }

    fn set_holder(&mut self, t: TetId, holder: Option<Ticket>) {
        self.inner.set_holder(t, holder);
    }

    fn lock(&mut self, t: TetId, holder: Ticket, in_conflict: bool) {
        self.inner.lock(t, holder, in_conflict);
    }

    fn in_conflict(&mut self, t: TetId, point: &DomainPoint) -> bool {
        self.inner.in_conflict(t, &point.vertex)
    }

    fn neighbours(&self, t: TetId, f: impl FnMut(Neighbour<TetId>)) {
        self.inner.neighbours(t, f);
    }

    fn corners(parts: &[Part<DomainPiece>]) -> Vec<u64> {
        let pieces = parts.iter().flat_map(|(_, pieces)| pieces);
        LocalMesh::names_of(pieces.flat_map(|own| own.piece.vertices.iter().map(|v| v.name)))
    }

    fn neighbours_around(&self, t: TetId, corners: &[u64], f: impl FnMut(Neighbour<TetId>)) {
        self.inner.neighbours_around(t, corners, f);
    }

    fn in_the_way(&mut self, point: &DomainPoint, seed: TetId) -> Option<Insert<TetId>> {
        let waits = point.carrier != Carrier::Free && !point.is_chosen;
        if waits { Some(Insert::Blocked) } else { self.inner.in_the_way(&point.vertex, seed) }
    }

    fn lock_all(
        &mut self,
        seed: TetId,
        point: &DomainPoint,
        holder: Ticket,
        found: &mut Found<'_, Self>,
    ) -> bool {
        // It may have been removed while the operation waited for its lock: nothing is found.
        if !self.inner.tets().is_live(seed) {
            return true;
        }
        let Found { held, foreign, pieces } = found;
        let mut own = std::mem::take(&mut self.pieces);
        let mut inner = Found { held, foreign, pieces: &mut own };
        let all = self.inner.lock_all(seed, &point.vertex, holder, &mut inner);
        pieces.extend(own.drain(..).map(|piece| self.describe(piece)));
        self.pieces = own;
        all
    }

    fn pieces(&mut self, tets: &[TetId]) -> Vec<DomainPiece> {
        let own = self.inner.pieces(tets);
        own.into_iter().map(|piece| self.describe(piece)).collect()
    }

    fn fill(
        &mut self,
        point: &DomainPoint,
        parts: &[Part<DomainPiece>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, DomainPatch)> {
        self.decide(point, parts, whereabouts, directory)
    }

    fn apply<C: Rules>(
        &mut self,
        patch: DomainPatch,
        directory: &Directory,
        made: &mut Vec<Name>,
        strays: &mut Vec<BlockId>,
    ) {
        let DomainPatch { patch, bound, regions, first, end } = patch;
        self.inner.apply::<C>(patch, directory, made, strays);
        self.asked.set(first);
        self.end = end;
        if self.inner.error().is_some() {
            return;
        }
        self.enter_carriers(bound);
        for (k, &t) in self.inner.installed().iter().enumerate() {
            let ghost = self.inner.tets().vertices(t)[3] == INFINITE;
            let region = regions.get(k).or(regions.first()).copied().unwrap_or_default();
            self.slots.put(t, if ghost { 0 } else { region });
        }
    }

    fn is_block_locked(&self, block: BlockId) -> bool {
        self.is_fixed || self.inner.is_block_locked(block)
    }

    fn extract<C: Rules>(
        &mut self,
        block: BlockId,
        moved: &mut dyn FnMut(TetId, Handle),
    ) -> DomainCargo {
        let Self { inner, slots, carriers, .. } = self;
        let mut regions = Vec::new();
        let each = |t: TetId| regions.push(slots.region(t));
        // R16.
        let tets = inner.extract_block(block, C::leaves_blocks(), moved, each);
        let numbers = tets.iter().flat_map(|own| own.v).filter_map(|own| inner.number(own.name));
        let mut on: Vec<VertexId> = numbers.filter(|&v| carriers.is_bound(v)).collect();
        on.sort_unstable();
        on.dedup();
        let bound = on.into_iter().map(|v| (inner.name(v), carriers.at(v))).collect();
        DomainCargo { tets, bound, regions }
    }

    fn adopt(&mut self, cargo: DomainCargo, made: &mut Vec<Name>) {
        let DomainCargo { tets, bound, regions } = cargo;
        self.inner.adopt(tets, made);
        self.asked.set(None);
        if self.inner.error().is_some() {
            return;
        }
        self.enter_carriers(bound);
        for (&t, region) in self.inner.installed().iter().zip(regions) {
            self.slots.put(t, region);
        }
    }

    fn made_at_once(&self) -> &[TetId] {
        match self.at_once {
            AtOnce::No => &[],
            AtOnce::Filled => self.inner.made_at_once(),
            AtOnce::Patched => self.inner.installed(),
        }
    }

    fn installed(&self) -> &[TetId] {
        self.inner.installed()
    }

    fn error(&self) -> Option<SubmeshError> {
        self.inner.error()
    }

    fn take_costs(&mut self) -> Costs {
        let Costs { walk_steps, looks, .. } = std::mem::take(&mut self.extra);
        let walk_steps = walk_steps + self.way_steps.take();
        let inner = self.inner.take_costs();
        Costs { walk_steps: inner.walk_steps + walk_steps, looks: inner.looks + looks, ..inner }
    }
}
