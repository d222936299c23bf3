//! The parts of cavities as they travel: what the submesh of points tells of them, with carriers,
//! regions and boundary items.

use super::mesh::DomainMesh;
use super::values::{DomainPiece, ItemKey, Marked, Regions, segment_key, subface_key};
use crate::mesh::Piece;
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{TetId, VertexId};
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::smallvec;

/// The slots of the edges of a tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

impl DomainMesh<'_> {
    /// Do vertices `v` of a tetrahedron in conflict with a point have boundary items?
    fn mark(&self, t: TetId, v: [VertexId; 4], edges: &mut FxHashSet<ItemKey>) -> Vec<Marked> {
        let is_on = v.map(|v| self.is_bound(v));
        if is_on.iter().filter(|on| **on).count() < 2 {
            return Vec::new();
        }
        let carriers = v.map(|v| self.carrier(v));
        let name = |k: usize| self.inner.name(v[k]);
        let mut found = Vec::new();
        let refused = self.refused.borrow();
        let mut add = |key: ItemKey, of: u32| {
            found.push(Marked { key, of, tet: t, is_refused: refused.contains(&key) });
        };
        for [i, j] in EDGES.into_iter().filter(|edge| edge.iter().all(|&k| is_on[k])) {
            if let Some(s) = self.complex.segment([carriers[i], carriers[j]]) {
                let key = segment_key([name(i), name(j)]);
                if edges.insert(key) {
                    add(key, s);
                }
            }
        }
        for face in OTHERS.into_iter().filter(|face| face.iter().all(|&k| is_on[k])) {
            if let Some(f) = self.complex.facet(face.map(|k| (carriers[k], self.point(v[k])))) {
                add(subface_key(face.map(name)), f);
            }
        }
        found
    }

    /// Adds to a piece what the boundary and the regions are there.
    pub(super) fn describe(&self, piece: Piece) -> DomainPiece {
        let (mut marked, mut edges) = (Vec::new(), FxHashSet::default());
        let mut on = Vec::new();
        for &t in &piece.tets {
            let v = self.inner.tets().vertices(t);
            if on.is_empty() && v.iter().any(|&v| self.is_bound(v)) {
                on.reserve(4 * piece.tets.len());
            }
            on.extend(v.into_iter().filter(|&v| self.is_bound(v)));
            marked.extend(self.mark(t, v, &mut edges));
        }
        on.sort_unstable();
        on.dedup();
        let bound = on.into_iter().map(|v| (self.inner.name(v), self.carrier(v))).collect();
        let first = piece.tets.first().map_or(0, |&t| self.region(t));
        let mut regions: Regions = smallvec![first];
        if piece.tets.iter().any(|&t| self.region(t) != first) {
            let faces = piece.tets.iter().flat_map(|&t| {
                let names = self.inner.tets().vertices(t).map(|v| self.inner.name(v));
                OTHERS.map(|face| (subface_key(face.map(|k| names[k])), self.region(t)))
            });
            // A face between two of them is none of the sides.
            let faces: FxHashMap<ItemKey, u32> = faces.collect();
            let key = |v: [u32; 3]| subface_key(v.map(|k| piece.vertices[k as usize].name));
            let of = |v| faces.get(&key(v)).copied().unwrap_or_default();
            regions = piece.sides.iter().map(|side| of(side.v)).collect();
        }
        DomainPiece { piece, bound, regions, marked }
    }
}
