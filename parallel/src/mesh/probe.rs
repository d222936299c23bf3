//! The view of a submesh for one that keeps more of its vertices and tetrahedra.

use super::{LocalMesh, VertexName, WireVertex};
use crate::protocol::Insert;
use ltbw_core::submesh::Owns;
use ltbw_core::topology::{TetId, VertexId};

impl LocalMesh {
    /// The number here of a vertex; `None` if it has none.
    pub(crate) fn number(&self, name: VertexName) -> Option<VertexId> {
        self.vertices.number(name)
    }

    /// The obstacle in the way of a point that is not to be inserted at once: something locked,
    /// or nothing but that. The cavity found is kept for the lock.
    pub(crate) fn probe(&mut self, point: &WireVertex, seed: TetId) -> Insert<TetId> {
        // The number is not used: no star is its submesh's own.
        let number = VertexId::new(1);
        self.tets.insert(number, &point.point(), seed, Owns::None::<fn([VertexId; 4]) -> bool>)
    }

    /// The finite vertices of a cavity that is described by some pieces.
    pub(crate) fn names_of(vertices: impl Iterator<Item = VertexName>) -> Vec<u64> {
        super::finite(vertices.collect())
    }
}
