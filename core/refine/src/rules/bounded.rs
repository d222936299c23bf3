//! Closures whose boundary can be told: one in a mesh, by marks and tables, and one of which values
//! are known, by the carriers of its vertices.

use super::choice::NOWHERE;
use super::complex::Complex;
use super::surveyed::Surveyed;
use crate::complex::angles::Angles;
use crate::complex::carrier::Carrier;
use crate::complex::plc::Plc;
use crate::mesh::item::{Item, has_corner};
use crate::mesh::marks::{ENDS, Word, edge_bit, face_bit};
use crate::mesh::state::{FACE, State};
use crate::outcome::Reason;
use crate::table::triangle;
use ltbw_core::search::Search;
use ltbw_core::topology::{INFINITE, TetId, VertexId, tet_of};
use ltbw_exact::Point;

/// A closure, with what of the boundary is in it.
pub(crate) trait Bounded {
    /// A tetrahedron of it.
    type Tet: Copy + Ord;

    /// The boundary of the domain.
    fn plc(&self) -> &Plc;

    /// It as one of a mesh, if all of that is here.
    fn here(&self) -> Option<InMesh<'_>>;

    /// The mesh that it is in, if all of that is here.
    fn state(&self) -> Option<&State> {
        self.here().map(|own| own.state)
    }

    /// The tetrahedra in conflict with the point.
    fn cavity(&self) -> impl Iterator<Item = Self::Tet>;

    /// Is a tetrahedron in conflict with the point?
    fn is_in(&self, t: Self::Tet) -> bool;

    /// The vertices of a tetrahedron, positively oriented; the one at infinity, and one that is
    /// not told, is [`INFINITE`].
    fn vertices(&self, t: Self::Tet) -> [VertexId; 4];

    /// The coordinates of a vertex.
    fn at(&self, v: VertexId) -> Point;

    /// Where a vertex lives that is not the one at infinity.
    fn carrier(&self, v: VertexId) -> Carrier;

    /// The region of a tetrahedron: its label, where there are patches.
    fn region(&self, t: Self::Tet) -> u32;

    /// The tetrahedron beyond a face; it need not be told where fewer than two corners of the face
    /// are on the boundary, unless there are patches.
    fn beyond(&self, t: Self::Tet, slot: usize) -> Option<Self::Tet>;

    /// The faces of the cavity, each as a slot of the tetrahedron inside.
    fn walls(&self) -> impl Iterator<Item = (Self::Tet, usize)> {
        let is_wall =
            |t: Self::Tet, slot: usize| self.beyond(t, slot).is_none_or(|other| !self.is_in(other));
        let slots = move |t| (0..4).filter(move |&slot| is_wall(t, slot)).map(move |k| (t, k));
        self.cavity().flat_map(slots)
    }

    /// The faces and edges of a tetrahedron that may be on the boundary, as bits of its word.
    fn marks(&self, t: Self::Tet) -> Word;

    /// The facet of a subface, given as the face of a tetrahedron opposite a slot.
    fn facet_at(&self, t: Self::Tet, slot: usize) -> Option<u32>;

    /// The facet of a pending subface, where these are in a table.
    fn pending_facet(&self, key: [VertexId; 3]) -> Option<u32>;

    /// The segment of a subsegment.
    fn segment(&self, key: [VertexId; 2]) -> Option<u32>;

    /// No walk around an edge in the cavity is longer.
    fn most_steps(&self) -> usize;

    /// The small angles of the domain.
    fn angles(&self) -> &Angles;

    /// Is an item of a segment or facet at a small angle with a point on `carrier`, so that the
    /// point may not ask for it?
    fn is_related(&self, carrier: Carrier, item: Item, of: u32) -> bool {
        let has = |corner: u32| has_corner(item, corner, |v| self.carrier(v));
        match item {
            Item::Segment(_) => {
                carrier != Carrier::Free
                    && self.angles().related_segment(carrier, of, &has).is_some()
            }
            _ => self.angles().related(self.plc(), carrier, of, &has).is_some(),
        }
    }

    /// The vertices of the whole mesh.
    fn num_vertices(&self) -> usize;

    /// The reason why a boundary item of the closure cannot be split that no point serves.
    fn unserved(&self, item: Item) -> Reason;

    /// Items that wait to be split, where these are in a table: all whose balls hold a point, and
    /// maybe others.
    fn pending(&self, p: &Point) -> impl Iterator<Item = Item>;
}

/// A closure in a mesh that is all here: the open cavity, or what a search has found.
#[derive(Clone, Copy)]
pub(crate) struct InMesh<'s> {
    pub(crate) state: &'s State,
    pub(crate) found: Option<&'s Search>,
}

impl<'s> InMesh<'s> {
    /// The open cavity.
    pub(crate) fn open(state: &'s State) -> Self {
        Self { state, found: None }
    }

    /// The cavity that a search has found.
    pub(crate) fn found(state: &'s State, search: &'s Search) -> Self {
        Self { state, found: Some(search) }
    }
}

impl Bounded for InMesh<'_> {
    type Tet = TetId;

    fn plc(&self) -> &Plc {
        &self.state.plc
    }

    fn here(&self) -> Option<InMesh<'_>> {
        Some(*self)
    }

    fn cavity(&self) -> impl Iterator<Item = TetId> {
        match self.found {
            None => self.state.mesh.cavity().tets(),
            Some(search) => search.tets().iter().copied(),
        }
    }

    fn is_in(&self, t: TetId) -> bool {
        match self.found {
            None => self.state.mesh.topology().at(t).is_marked(),
            Some(search) => search.has(t),
        }
    }

    fn vertices(&self, t: TetId) -> [VertexId; 4] {
        self.state.vertices(t)
    }

    fn at(&self, v: VertexId) -> Point {
        self.state.at(v)
    }

    fn beyond(&self, t: TetId, slot: usize) -> Option<TetId> {
        Some(tet_of(self.state.mesh.topology().at(t).neighbours()[slot]))
    }

    fn carrier(&self, v: VertexId) -> Carrier {
        self.state.carriers[v.index()]
    }

    fn region(&self, t: TetId) -> u32 {
        self.state.marks.region(t)
    }

    fn marks(&self, t: TetId) -> Word {
        self.state.marks.of(t)
    }

    fn facet_at(&self, t: TetId, slot: usize) -> Option<u32> {
        if self.state.marks.of(t) & face_bit(slot) == 0 {
            return None;
        }
        let [a, b, c] = FACE[slot].map(|k| self.state.vertices(t)[k]);
        self.state.subfaces.get(&triangle(a, b, c)).copied()
    }

    fn pending_facet(&self, key: [VertexId; 3]) -> Option<u32> {
        self.state.subfaces.get(&key).copied()
    }

    fn segment(&self, key: [VertexId; 2]) -> Option<u32> {
        self.state.segments.get(&key).copied()
    }

    fn most_steps(&self) -> usize {
        self.state.mesh.topology().slots()
    }

    fn angles(&self) -> &Angles {
        &self.state.angles
    }

    fn num_vertices(&self) -> usize {
        self.state.num_vertices()
    }

    fn unserved(&self, item: Item) -> Reason {
        self.state.unserved(item)
    }

    fn pending(&self, p: &Point) -> impl Iterator<Item = Item> {
        self.state.encroachment.near(p)
    }
}

/// The edges and faces between some slots of a tetrahedron, by the bits of these.
const BETWEEN: [Word; 16] = {
    let mut words = [0; 16];
    let mut slots = 0;
    while slots < 16 {
        let mut k = 0;
        while k < ENDS.len() {
            let [i, j] = ENDS[k];
            if slots >> i & 1 == 1 && slots >> j & 1 == 1 {
                words[slots] |= edge_bit(i, j);
            }
            k += 1;
        }
        let mut slot = 0;
        while slot < 4 {
            if slots | 1 << slot == 15 {
                words[slots] |= 1 << slot;
            }
            slot += 1;
        }
        slots += 1;
    }
    words
};

/// A closure of which values are known. A vertex has the number after the one that it has there.
#[derive(Debug)]
pub(crate) struct ByValues<'c, R> {
    pub(crate) complex: &'c Complex<'c>,
    pub(crate) closure: &'c R,
    /// The vertices of the whole mesh.
    pub(crate) num_vertices: usize,
}

impl<R> Clone for ByValues<'_, R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R> Copy for ByValues<'_, R> {}

/// The vertex of a number there.
fn vertex(number: u32) -> VertexId {
    match number {
        NOWHERE => INFINITE,
        number => VertexId::new(number + 1),
    }
}

impl<R: Surveyed> ByValues<'_, R> {
    /// A vertex's corner there.
    pub(crate) fn corner(&self, v: VertexId) -> crate::Corner {
        self.closure.corner(v.number() - 1)
    }
}

impl<R: Surveyed> Bounded for ByValues<'_, R> {
    type Tet = R::Tet;

    fn plc(&self) -> &Plc {
        self.complex.plc()
    }

    fn here(&self) -> Option<InMesh<'_>> {
        None
    }

    fn cavity(&self) -> impl Iterator<Item = R::Tet> {
        self.closure.cavity()
    }

    fn is_in(&self, t: R::Tet) -> bool {
        self.closure.is_in(t)
    }

    fn vertices(&self, t: R::Tet) -> [VertexId; 4] {
        self.closure.vertices(t).map(vertex)
    }

    fn at(&self, v: VertexId) -> Point {
        self.corner(v).point
    }

    fn carrier(&self, v: VertexId) -> Carrier {
        self.corner(v).carrier
    }

    fn region(&self, t: R::Tet) -> u32 {
        self.closure.region(t)
    }

    fn beyond(&self, t: R::Tet, slot: usize) -> Option<R::Tet> {
        self.closure.beyond(t, slot)
    }

    /// The faces whose corners are on the boundary, and the subsegments.
    fn marks(&self, t: R::Tet) -> Word {
        let bound = self.closure.bound(t);
        let mut word = BETWEEN[(0..4).map(|k| usize::from(bound[k]) << k).sum::<usize>()];
        if word == 0 {
            return 0;
        }
        let v = self.vertices(t);
        let carrier = |k: usize| if bound[k] { self.carrier(v[k]) } else { Carrier::Free };
        let carriers = [0, 1, 2, 3].map(carrier);
        for [i, j] in ENDS {
            let bit = edge_bit(i, j);
            if word & bit != 0 && self.complex.segment([carriers[i], carriers[j]]).is_none() {
                word ^= bit;
            }
        }
        word
    }

    fn facet_at(&self, t: R::Tet, slot: usize) -> Option<u32> {
        let v = self.vertices(t);
        let face = FACE[slot].map(|k| v[k]);
        if face.contains(&INFINITE) {
            return None;
        }
        let corners = face.map(|v| self.corner(v));
        let label = |t: R::Tet| self.closure.region(t);
        let beyond = || Some([label(t), label(self.beyond(t, slot)?)]);
        self.complex.facet(corners).or_else(|| self.complex.patch(corners, slot, beyond))
    }

    fn pending_facet(&self, _: [VertexId; 3]) -> Option<u32> {
        None
    }

    fn segment(&self, key: [VertexId; 2]) -> Option<u32> {
        self.complex.segment(key.map(|v| self.corner(v).carrier))
    }

    fn most_steps(&self) -> usize {
        self.closure.cavity().count()
    }

    fn angles(&self) -> &Angles {
        self.complex.angles()
    }

    fn num_vertices(&self) -> usize {
        self.num_vertices
    }

    fn unserved(&self, item: Item) -> Reason {
        self.complex.unserved(item, |v| self.at(v))
    }

    fn pending(&self, _: &Point) -> impl Iterator<Item = Item> {
        std::iter::empty()
    }
}
