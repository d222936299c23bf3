//! Ways through the whole mesh, and through a facet.

use crate::mesh::marks::face_bit;
use crate::mesh::state::State;
use crate::rules::way::{self, Across, FACES, Heading, Stop, View, middle, walk};
use crate::table::{sides, triangle};
use ltbw_core::topology::{TetId, VertexId, slot_of, tet_of};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, coplanar_orient, orient3d};
use std::convert::Infallible;

/// Where a way ends in a whole mesh: a subface may bar it, and nobody else has a part of it.
pub(crate) type Way = way::Way<[VertexId; 3], Infallible>;

impl View for State {
    type Item = [VertexId; 3];
    type Far = Infallible;

    fn most_steps(&self) -> usize {
        self.mesh.topology().slots()
    }

    fn vertices(&self, t: TetId) -> [VertexId; 4] {
        self.mesh.topology().at(t).vertices()
    }

    fn point(&self, v: VertexId) -> Point {
        self.at(v)
    }

    fn barrier(&self, t: TetId, v: [VertexId; 4], slot: usize) -> Option<[VertexId; 3]> {
        let [a, b, c] = FACES[slot].map(|k| v[k]);
        (self.marks.of(t) & face_bit(slot) != 0).then(|| triangle(a, b, c))
    }

    fn across(&self, t: TetId, slot: usize) -> Across<Infallible> {
        let next = self.mesh.topology().at(t).neighbours()[slot];
        Across::Here(Stop { t: tet_of(next), entry: Some(slot_of(next)) })
    }
}

impl State {
    /// Walks from the middle of tetrahedron `start` straight to `p`, up to the first subface.
    pub(crate) fn way(&self, start: TetId, p: &Point) -> Way {
        self.way_to(start, p, true)
    }

    /// Walks as [`State::way`] does to a point that may be inserted, or not.
    pub(crate) fn way_to(&self, start: TetId, p: &Point, may: bool) -> Way {
        let from = middle(self.vertices(start).map(|v| self.at(v)));
        walk(self, Stop { t: start, entry: None }, &Heading { from, to: *p, may }).end
    }

    /// A tetrahedron, or ghost, that holds `p`: where a walk from `start` ends that nothing bars.
    pub(crate) fn holder(&self, start: TetId, p: &Point) -> Option<TetId> {
        let topology = self.mesh.topology();
        let (mut t, mut entry) = (start, 4);
        if topology.at(t).is_ghost() {
            t = tet_of(topology.at(t).neighbours()[3]);
        }
        // In a Delaunay mesh such a walk visits no tetrahedron twice; the bound only guards it.
        for _ in 0..=topology.slots() {
            let tet = topology.at(t);
            let v = tet.vertices();
            let is_beyond = |slot: &usize| {
                let [a, b, c] = FACES[*slot].map(|k| self.at(v[k]));
                *slot != entry && orient3d(&a, &b, &c, p) == Sign::Negative
            };
            let Some(slot) = (0..4).filter(|_| !tet.is_ghost()).find(is_beyond) else {
                return Some(t);
            };
            let next = tet.neighbours()[slot];
            (t, entry) = (tet_of(next), slot_of(next));
        }
        None
    }

    /// The first subsegment on a way from subface `s` of facet `f` to `p` in its plane, through the
    /// facet's triangulation, whether the mesh has its triangles or not.
    pub(crate) fn segment_on_way(
        &self,
        s: [VertexId; 3],
        f: u32,
        p: &Point,
    ) -> Option<[VertexId; 2]> {
        let at_edge = self.at_edge.as_ref()?;
        let (mut t, mut entry) = (s, None);
        // Every triangle is passed once in a Delaunay triangulation; the bound only guards it.
        for _ in 0..=self.subfaces.len() {
            let beyond = |&(side, opposite): &([VertexId; 2], VertexId)| {
                let [a, b] = side.map(|v| self.at(v));
                let inner = coplanar_orient(&a, &b, &self.at(opposite));
                Some(side) != entry && coplanar_orient(&a, &b, p) == -inner
            };
            let (side, _) = sides(t).into_iter().find(beyond)?;
            if self.segments.contains_key(&side) {
                return Some(side);
            }
            let others = at_edge.get(&side)?;
            t = *others.iter().find(|o| **o != t && self.subfaces.get(*o) == Some(&f))?;
            entry = Some(side);
        }
        None
    }
}
