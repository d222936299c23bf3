//! The parts of cavities as they travel: what the submesh of points tells of them, with carriers,
//! regions and the tetrahedra at which something may be boundary.

use super::mesh::DomainMesh;
use super::values::{DomainPiece, ItemKey, NearTet, Regions, segment_key, subface_key};
use crate::mesh::{Piece, VertexName};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_refine::{Carrier, NOWHERE};
use rustc_hash::FxHashMap;
use smallvec::smallvec;

/// The slots of the edges of a tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// May something of a tetrahedron be boundary? A subface has three corners there, an edge of which
/// no face is one is a subsegment or nothing.
pub(crate) fn is_near(mesh: &DomainMesh<'_>, t: TetId) -> bool {
    let corners = mesh.inner.tets().vertices(t);
    let is_bound = corners.map(|v| mesh.is_bound(v));
    match is_bound.iter().filter(|is| **is).count() {
        0 | 1 => false,
        2 => {
            let mut ends = corners.into_iter().zip(is_bound).filter(|own| own.1);
            let mut end = || ends.next().map_or(Carrier::Free, |(v, _)| mesh.carrier(v));
            mesh.complex.segment([end(), end()]).is_some()
        }
        _ => true,
    }
}

/// Is splitting a tetrahedron over its bounds no help?
pub(crate) fn is_beyond_help(mesh: &DomainMesh<'_>, t: TetId) -> bool {
    let corners = || mesh.inner.tets().vertices(t).map(|v| mesh.corner(v));
    mesh.complex.has_angles() && mesh.complex.is_beyond_help(corners(), mesh.region(t))
}

impl DomainMesh<'_> {
    /// The tetrahedra of a piece at which something may be boundary.
    fn near_of(&self, piece: &Piece) -> Vec<NearTet> {
        let near: Vec<TetId> = piece.tets.iter().copied().filter(|&t| is_near(self, t)).collect();
        if near.is_empty() {
            return Vec::new();
        }
        // A cavity has no vertex inside: each is at a side.
        let names = piece.vertices.iter().map(|vertex| vertex.name);
        let places: FxHashMap<VertexName, u32> = names.zip(0..).collect();
        let place = |v: VertexId| match v {
            INFINITE => NOWHERE,
            v => places.get(&self.inner.name(v)).copied().unwrap_or(NOWHERE),
        };
        let all = near.into_iter();
        all.map(|tet| NearTet { v: self.inner.tets().vertices(tet).map(place), tet }).collect()
    }

    /// The boundary items at some tetrahedra that cannot be split, as far as this worker has tried.
    fn refused_at(&self, near: &[NearTet]) -> Vec<ItemKey> {
        let refused = self.refused.borrow();
        if refused.is_empty() {
            return Vec::new();
        }
        let keys = near.iter().flat_map(|own| {
            let names = self.inner.tets().vertices(own.tet).map(|v| self.inner.name(v));
            let edges = EDGES.map(|edge| segment_key(edge.map(|k| names[k])));
            edges.into_iter().chain(OTHERS.map(|face| subface_key(face.map(|k| names[k]))))
        });
        let mut found: Vec<ItemKey> = keys.filter(|key| refused.contains(key)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Adds to a piece what the boundary and the regions are there.
    pub(super) fn describe(&self, piece: Piece) -> DomainPiece {
        let mut on = Vec::new();
        for &t in &piece.tets {
            let v = self.inner.tets().vertices(t);
            if on.is_empty() && v.iter().any(|&v| self.is_bound(v)) {
                on.reserve(4 * piece.tets.len());
            }
            on.extend(v.into_iter().filter(|&v| self.is_bound(v)));
        }
        on.sort_unstable();
        on.dedup();
        // Only with two vertices on the boundary something may be boundary.
        let near = if on.len() > 1 { self.near_of(&piece) } else { Vec::new() };
        let refused = self.refused_at(&near);
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
        DomainPiece { piece, bound, regions, near, refused }
    }
}
