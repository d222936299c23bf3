//! Which block a vertex and a tetrahedron belong to.

use crate::protocol::BlockId;
use ltbw_core::topology::{INFINITE, VertexId};
use std::sync::Arc;

/// The blocks of a mesh: pieces of a Hilbert curve through its vertices.
///
/// Vertices are numbered along the curve, so that a block is a range of numbers. Cuts lie between
/// points, at no fixed depth of the curve: a cluster is cut as evenly as anything.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Blocks {
    /// First vertex of each block, and one past the last vertex of all.
    starts: Arc<[VertexId]>,
}

impl Blocks {
    /// Cuts vertices 1 to `vertices` into `blocks` blocks of nearly equal size.
    pub fn even(vertices: u32, blocks: BlockId) -> Self {
        let (n, k) = (u64::from(vertices), u64::from(blocks.max(1)));
        Self { starts: (0..=k).map(|b| 1 + (b * n / k) as VertexId).collect() }
    }

    /// Number of blocks.
    pub fn len(&self) -> BlockId {
        (self.starts.len() - 1) as BlockId
    }

    /// Is there no block? Never.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The vertices of `block`.
    pub fn vertices(&self, block: BlockId) -> std::ops::Range<VertexId> {
        self.starts[block as usize]..self.starts[block as usize + 1]
    }

    /// The block of a finite vertex.
    #[inline]
    pub fn of_vertex(&self, v: VertexId) -> BlockId {
        let block = self.starts.partition_point(|&start| start <= v);
        (block.saturating_sub(1) as BlockId).min(self.len() - 1)
    }

    /// The block of a tetrahedron: that of most of its finite vertices; of equals, the smallest.
    #[inline]
    pub fn of_tet(&self, v: [VertexId; 4]) -> BlockId {
        let finite = if v[3] == INFINITE { 3 } else { 4 };
        let mut blocks = [BlockId::MAX; 4];
        for (block, &v) in blocks.iter_mut().zip(&v[..finite]) {
            *block = self.of_vertex(v);
        }
        let blocks = &mut blocks[..finite];
        blocks.sort_unstable();
        let (mut best, mut most) = (blocks[0], 0);
        for run in blocks.chunk_by(|a, b| a == b) {
            if run.len() > most {
                (best, most) = (run[0], run.len());
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_ranges_and_majorities() {
        let blocks = Blocks::even(10, 4);
        assert_eq!(blocks.len(), 4);
        let of: Vec<u32> = (1..=10).map(|v| blocks.of_vertex(v)).collect();
        assert_eq!(of, [0, 0, 1, 1, 1, 2, 2, 3, 3, 3]);
        for (v, &block) in (1..).zip(&of) {
            assert!(blocks.vertices(block).contains(&v));
        }
        assert_eq!(blocks.of_tet([1, 4, 5, 9]), 1);
        assert_eq!(blocks.of_tet([9, 8, 1, 2]), 0, "two and two: the smaller block");
        assert_eq!(blocks.of_tet([9, 1, 4, 6]), 0, "four different ones");
        assert_eq!(blocks.of_tet([9, 8, 1, INFINITE]), 3);
    }

    #[test]
    fn more_blocks_than_vertices() {
        let blocks = Blocks::even(3, 8);
        for v in 1..=3 {
            assert!(blocks.vertices(blocks.of_vertex(v)).contains(&v));
        }
        assert_eq!((0..8).map(|b| blocks.vertices(b).len()).sum::<usize>(), 3);
    }
}
