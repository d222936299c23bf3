//! The combinatorial mesh: tetrahedra, their neighbours, free slots. It never sees a coordinate.
//!
//! A tetrahedron is 32 bytes: four vertices and four neighbour handles. Vertex 0 is the vertex at
//! infinity; a tetrahedron that has it is a *ghost* and stands for a hull facet. The invariants
//! (numbered in `docs/invariants.md`):
//!
//! * I1: neighbour `i` is opposite vertex `i`, and neighbourhood is mutual.
//! * I2: the vertex at infinity is only ever in the last slot.
//! * I3: a free slot begins with the vertex at infinity twice and is in the free list once.
//! * I4: outside an insertion no tetrahedron is marked.
//! * I7: every link leads to a slot, and every vertex of a slot is one of the mesh, also where the
//!   slot is vacant: whatever follows links stays inside the arrays.

use crate::arena::{Arena, zeroable};
use rayon::prelude::*;

crate::ids! {
    /// Index of a tetrahedron's slot.
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    TetId,
    /// Kernel number of a vertex: 0 is the vertex at infinity, the others count from 1.
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    VertexId
}

zeroable!(VertexId { 0: number });

/// A face seen from one of its tetrahedra, as the slot of the vertex opposite: in four bytes.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct FaceId(u32);

zeroable!(FaceId { 0: number });

impl FaceId {
    /// The face of tetrahedron `tet`, at most [`MAX_TETS`], opposite the vertex in `slot`.
    #[inline(always)]
    pub const fn new(tet: TetId, slot: usize) -> Self {
        debug_assert!(tet.index() <= MAX_TETS && slot < 4);
        Self(tet.number() << 2 | slot as u32)
    }
}

/// The vertex at infinity.
pub const INFINITE: VertexId = VertexId::new(0);
/// The vertices of a free slot. No tetrahedron begins with the vertex at infinity (I2), and all of
/// these exist: to look at them is harmless (I7).
const FREE: [VertexId; 4] = [INFINITE; 4];
/// The vertices of a far face: vacant like a free slot, and another one.
const FAR_FACE: [VertexId; 4] = [INFINITE, VertexId::new(1), INFINITE, INFINITE];
/// Tetrahedra that one thread looks at at a time, at least.
const SHARE: usize = 4096;
/// Bit of the last vertex that marks a tetrahedron of the cavity in work.
const MARK: u32 = 1 << 31;
/// Largest number of slots: a face handle is a `u32`.
pub const MAX_TETS: usize = (1 << 30) - 1;

/// One tetrahedron: vertices, and the faces of its neighbours opposite each vertex.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(32))]
pub struct Tet {
    v: [VertexId; 4],
    n: [FaceId; 4],
}

zeroable!(Tet { v: v, n: n });

impl Tet {
    /// The vertices, unmarked.
    #[inline(always)]
    pub fn vertices(&self) -> [VertexId; 4] {
        [self.v[0], self.v[1], self.v[2], VertexId(self.v[3].0 & !MARK)]
    }

    /// The neighbouring faces: `neighbours()[i]` lies opposite vertex `i`.
    #[inline(always)]
    pub fn neighbours(&self) -> [FaceId; 4] {
        self.n
    }

    /// Is this a ghost, a tetrahedron with the vertex at infinity?
    #[inline(always)]
    pub fn is_ghost(&self) -> bool {
        self.v[3].0 & !MARK == INFINITE.0
    }

    /// Is this slot free?
    #[inline(always)]
    pub fn is_free(&self) -> bool {
        self.is_vacant() && self.v[1] == FREE[1]
    }

    /// Is there no tetrahedron in this slot? It is free then, or a far face.
    #[inline(always)]
    pub fn is_vacant(&self) -> bool {
        self.v[0] == INFINITE
    }

    /// Is this slot a far face: the far side of an interface face? Only parts of a mesh have them.
    #[inline(always)]
    pub fn is_far_face(&self) -> bool {
        self.is_vacant() && self.v[1] == FAR_FACE[1]
    }

    /// Is it in the cavity in work?
    #[inline(always)]
    pub fn is_marked(&self) -> bool {
        self.v[3].0 & MARK != 0
    }
}

/// The tetrahedron of a face handle.
#[inline(always)]
pub fn tet_of(face: FaceId) -> TetId {
    TetId::new(face.0 >> 2)
}

/// The slot, in its tetrahedron, of the vertex opposite a face.
#[inline(always)]
pub fn slot_of(face: FaceId) -> usize {
    (face.0 & 3) as usize
}

/// All tetrahedra of a mesh, ghosts included.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topology {
    tets: Arena<Tet>,
    /// Free slots, last in first out.
    free: Vec<TetId>,
    ghosts: usize,
    /// Most slots that there may be.
    limit: usize,
}

impl Default for Topology {
    fn default() -> Self {
        Self::with_capacity(0)
    }
}

/// The slot limit is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Full;

impl Topology {
    pub(crate) fn with_capacity(tets: usize) -> Self {
        let (tets, free) = (Arena::with_capacity(tets), Vec::new());
        Self { tets, free, ghosts: 0, limit: MAX_TETS }
    }

    /// Sets how many slots there may be at most; more than [`MAX_TETS`] there never are.
    pub(crate) fn set_limit(&mut self, limit: usize) {
        self.limit = limit.min(MAX_TETS);
    }

    /// The largest number of slots that there may be.
    pub(crate) fn limit(&self) -> usize {
        self.limit
    }

    /// The tetrahedron in slot `t`, which may be a free slot; `None` if there is no such slot.
    pub fn get(&self, t: TetId) -> Option<&Tet> {
        self.tets.all().get(t.index())
    }

    /// The tetrahedron in slot `t`, which may be a free slot.
    ///
    /// # Panics
    /// If there is no such slot, as indexing a slice does.
    #[inline(always)]
    pub fn at(&self, t: TetId) -> &Tet {
        &self.tets.all()[t.index()]
    }

    /// The tetrahedron in slot `t`, which must exist (I7).
    #[inline(always)]
    pub(crate) fn tet(&self, t: TetId) -> &Tet {
        self.tets.at(t)
    }

    /// Asks the processor to fetch tetrahedron `t`.
    #[doc(hidden)]
    #[inline(always)]
    pub fn prefetch(&self, t: TetId) {
        self.tets.prefetch(t);
    }

    /// Number of slots, free ones included.
    pub fn slots(&self) -> usize {
        self.tets.all().len()
    }

    /// Number of tetrahedra, ghosts included.
    pub fn len(&self) -> usize {
        self.tets.all().len() - self.free.len()
    }

    /// Is there no tetrahedron?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of ghosts: the hull facets.
    pub fn ghosts(&self) -> usize {
        self.ghosts
    }

    /// The free slots.
    pub fn free_slots(&self) -> &[TetId] {
        &self.free
    }

    /// Bytes of memory that the arrays hold.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.tets.all()) + self.free.capacity() * size_of::<TetId>()
    }

    /// The used slots, ascending.
    pub fn iter(&self) -> impl Iterator<Item = (TetId, &Tet)> + '_ {
        (0..).map(TetId::new).zip(self.tets.all()).filter(|(_, t)| !t.is_free())
    }

    /// The finite tetrahedra, ascending. (The last vertex of a vacant slot is at infinity, too.)
    pub fn finite(&self) -> impl Iterator<Item = (TetId, &Tet)> + '_ {
        (0..).map(TetId::new).zip(self.tets.all()).filter(|(_, t)| !t.is_ghost())
    }

    /// All slots that are not free, ascending, on all threads.
    #[doc(hidden)]
    pub fn par_iter(&self) -> impl ParallelIterator<Item = (TetId, &Tet)> + '_ {
        let all = self.tets.all().par_iter().with_min_len(SHARE).enumerate();
        all.map(|(k, t)| (TetId::at(k), t)).filter(|(_, t)| !t.is_free())
    }

    #[inline(always)]
    pub(crate) fn mark(&mut self, t: TetId) {
        self.tets.at_mut(t).v[3].0 |= MARK;
    }

    #[inline(always)]
    pub(crate) fn mark_if(&mut self, t: TetId, yes: bool) {
        self.tets.at_mut(t).v[3].0 |= u32::from(yes) << 31;
    }

    #[inline(always)]
    pub(crate) fn unmark(&mut self, t: TetId) {
        self.tets.at_mut(t).v[3].0 &= !MARK;
    }

    /// Makes sure that `count` slots can be taken.
    pub(crate) fn reserve(&self, count: usize) -> Result<(), Full> {
        let fresh = count.saturating_sub(self.free.len());
        if self.tets.all().len() + fresh > self.limit { Err(Full) } else { Ok(()) }
    }

    /// Takes memory for this many tetrahedra. A hint.
    pub(crate) fn expect(&mut self, tets: usize) {
        self.tets.expect(tets);
    }

    /// The number of slots when `count` are free, as far as the limit allows.
    pub(crate) fn slots_with(&self, count: usize) -> usize {
        let (slots, missing) = (self.slots(), count.saturating_sub(self.free.len()));
        (slots + missing).min(self.limit).max(slots)
    }

    /// Makes sure that there are `count` free slots, as far as the limit allows.
    pub(crate) fn make_free(&mut self, count: usize) {
        let (slots, all) = (self.slots(), self.slots_with(count));
        self.tets.grow(all, Tet { v: FREE, n: [FaceId::default(); 4] });
        self.free.extend((slots..all).rev().map(TetId::at));
    }

    /// These tetrahedra under another name, for one of several threads, with free slots of its
    /// own and no room for others. Its ghosts are counted from zero, modulo 2^64.
    ///
    /// # Safety
    /// As of [`Arena::alias`].
    #[allow(unsafe_code)]
    pub(crate) unsafe fn alias(&mut self, free: Vec<TetId>) -> Self {
        // SAFETY: as promised.
        Self { tets: unsafe { self.tets.alias() }, free, ghosts: 0, limit: 0 }
    }

    /// Gives the free slots away.
    pub(crate) fn take_free(&mut self) -> Vec<TetId> {
        std::mem::take(&mut self.free)
    }

    /// Takes over from an alias what it has left.
    pub(crate) fn rejoin(&mut self, alias: Self) {
        self.free.extend(alias.free);
        self.ghosts = self.ghosts.wrapping_add(alias.ghosts);
    }

    /// Takes a slot: the last freed one, else a fresh one at the end.
    pub(crate) fn take(&mut self) -> TetId {
        self.free.pop().unwrap_or_else(|| {
            self.tets.push(Tet { v: FREE, n: [FaceId::default(); 4] });
            TetId::at(self.tets.all().len() - 1)
        })
    }

    /// Frees slot `t`.
    pub(crate) fn release(&mut self, t: TetId) {
        self.tets.at_mut(t).v = FREE;
        self.free.push(t);
    }

    /// Writes a tetrahedron, and links the neighbour opposite its first vertex back to it.
    #[inline(always)]
    pub(crate) fn put(&mut self, t: TetId, v: [VertexId; 4], n: [FaceId; 4]) {
        *self.tets.at_mut(t) = Tet { v, n };
        self.tets.at_mut(tet_of(n[0])).n[slot_of(n[0])] = FaceId::new(t, 0);
    }

    /// Says what lies beyond `face`, without the other direction.
    pub(crate) fn point_to(&mut self, face: FaceId, beyond: FaceId) {
        self.tets.at_mut(tet_of(face)).n[slot_of(face)] = beyond;
    }

    /// Makes two faces each other's neighbour.
    #[inline(always)]
    pub(crate) fn link(&mut self, a: FaceId, b: FaceId) {
        self.tets.at_mut(tet_of(a)).n[slot_of(a)] = b;
        self.tets.at_mut(tet_of(b)).n[slot_of(b)] = a;
    }

    /// Writes a tetrahedron, without the other direction of its links; ghosts are counted.
    #[inline]
    pub(crate) fn write(&mut self, t: TetId, v: [VertexId; 4], n: [FaceId; 4]) {
        *self.tets.at_mut(t) = Tet { v, n };
        self.ghosts += usize::from(v[3] == INFINITE);
    }

    /// Frees the slot of a tetrahedron or far face; ghosts are counted.
    pub(crate) fn erase(&mut self, t: TetId) {
        self.ghosts -= usize::from(self.tet(t).is_ghost() && !self.tet(t).is_vacant());
        self.release(t);
    }

    /// Appends the slots of `other`, with its links changed to match and its vertices renamed;
    /// returns their offset. `None` if there would be too many.
    pub(crate) fn append(
        &mut self,
        other: Self,
        names: impl Fn([VertexId; 4]) -> [VertexId; 4] + Sync,
    ) -> Option<usize> {
        let (offset, slots) = (self.slots(), other.slots());
        if offset + slots > self.limit {
            return None;
        }
        let shifted = |t: TetId| TetId::at(t.index() + offset);
        let shift = |face| FaceId::new(shifted(tet_of(face)), slot_of(face));
        self.free.extend(other.free.iter().copied().map(shifted));
        self.ghosts += other.ghosts;
        self.tets.append(other.tets, slots, |tet| {
            let n = if tet.is_free() { tet.n } else { tet.n.map(shift) };
            Tet { v: names(tet.v), n }
        });
        Some(offset)
    }

    /// One look at all slots: by vertex, of which there are `count` finite ones, whether a
    /// tetrahedron has it; and the far faces, ascending.
    pub(crate) fn survey(&self, count: usize) -> (Vec<bool>, Vec<TetId>) {
        let tets = self.tets.all();
        let size = tets.len().div_ceil(rayon::current_num_threads()).max(1);
        let of_chunk = |(number, chunk): (usize, &[Tet])| {
            let (mut used, mut far_faces) = (vec![false; count + 1], Vec::new());
            for (t, tet) in (number * size..).zip(chunk).filter(|(_, tet)| !tet.is_free()) {
                if tet.is_far_face() {
                    far_faces.push(TetId::at(t));
                    continue;
                }
                for v in tet.vertices() {
                    used[v.index()] = true;
                }
            }
            (used, far_faces)
        };
        let join = |mut one: (Vec<bool>, Vec<TetId>), other: (Vec<bool>, Vec<TetId>)| {
            one.0.iter_mut().zip(other.0).for_each(|(used, other)| *used |= other);
            one.1.extend(other.1);
            one
        };
        let all = tets.par_chunks(size).enumerate().map(of_chunk).reduce_with(join);
        all.unwrap_or_else(|| (vec![false; count + 1], Vec::new()))
    }

    /// Renames every vertex of every tetrahedron.
    pub(crate) fn rename(&mut self, name: impl Fn(VertexId) -> VertexId) {
        for tet in self.tets.all_mut().iter_mut().filter(|tet| !tet.is_free()) {
            tet.v = tet.v.map(&name);
        }
    }

    /// Renames the vertices of every slot that has one above `highest`.
    pub(crate) fn rename_above(
        &mut self,
        highest: VertexId,
        names: impl Fn([VertexId; 4]) -> [VertexId; 4] + Sync,
    ) {
        let chunks = self.tets.all_mut().par_chunks_mut(1 << 14);
        chunks.for_each(|chunk| {
            for tet in chunk {
                if tet.v.iter().any(|&v| v > highest) {
                    tet.v = names(tet.v);
                }
            }
        });
    }

    /// Makes slot `t` a far face, neighbour of `face`.
    pub(crate) fn put_far_face(&mut self, t: TetId, face: FaceId) {
        *self.tets.at_mut(t) = Tet { v: FAR_FACE, n: [face; 4] };
        self.tets.at_mut(tet_of(face)).n[slot_of(face)] = FaceId::new(t, 0);
    }

    pub(crate) fn add_ghosts(&mut self, change: isize) {
        self.ghosts = self.ghosts.wrapping_add_signed(change);
    }

    /// Builds the first tetrahedron `v`, positively oriented, and its four ghosts.
    pub(crate) fn start(&mut self, v: [VertexId; 4]) {
        debug_assert!(self.tets.all().is_empty());
        // Opposite vertex i stands v with v[i] at infinity, seen from outside: an odd
        // permutation that brings the vertex at infinity to the last slot.
        let cells = [
            v,
            [v[3], v[1], v[2], INFINITE],
            [v[0], v[3], v[2], INFINITE],
            [v[0], v[1], v[3], INFINITE],
            [v[1], v[0], v[2], INFINITE],
        ];
        for v in cells {
            self.tets.push(Tet { v, n: [FaceId::default(); 4] });
        }
        self.ghosts = 4;
        let same = |a: [VertexId; 4], i: usize, b: [VertexId; 4], j: usize| {
            (0..4).filter(|&k| k != i).all(|k| (0..4).any(|l| l != j && a[k] == b[l]))
        };
        for a in 0..5 {
            for b in 0..a {
                for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
                    if same(cells[a], i, cells[b], j) {
                        self.link(FaceId::new(TetId::at(a), i), FaceId::new(TetId::at(b), j));
                    }
                }
            }
        }
    }
}
