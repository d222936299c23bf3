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
    /// Blocks by vertices, in 2^-32: blocks are nearly even, so that this guesses a block.
    density: u64,
}

impl Blocks {
    /// Cuts vertices 1 to `vertices` into `blocks` blocks of nearly equal size.
    pub fn even(vertices: u32, blocks: BlockId) -> Self {
        let (n, k) = (u64::from(vertices), u64::from(blocks.max(1)));
        let density = (k << 32) / n.max(1);
        Self { starts: (0..=k).map(|b| 1 + (b * n / k) as VertexId).collect(), density }
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
        let last = self.starts.len() - 2;
        let guess = (u64::from(v.saturating_sub(1)) * self.density) >> 32;
        let mut block = (guess as usize).min(last);
        // A few steps at most: the guess is off by rounding, or by empty blocks.
        while block < last && self.starts[block + 1] <= v {
            block += 1;
        }
        while block > 0 && self.starts[block] > v {
            block -= 1;
        }
        block as BlockId
    }

    /// The block of a tetrahedron: that of most of its finite vertices; of equals, the smallest.
    #[inline]
    pub fn of_tet(&self, v: [VertexId; 4]) -> BlockId {
        let first = self.of_vertex(v[0]);
        let range = self.vertices(first);
        // Most tetrahedra lie in one block.
        if v[1..].iter().all(|w| range.contains(w)) {
            return first;
        }
        let [b, c] = [self.of_vertex(v[1]), self.of_vertex(v[2])];
        let d = (v[3] != INFINITE).then(|| self.of_vertex(v[3]));
        prevailing([first, b, c], d)
    }
}

/// The block of a tetrahedron by those of its vertices; a ghost has three.
#[inline]
pub(super) fn prevailing([a, b, c]: [BlockId; 3], d: Option<BlockId>) -> BlockId {
    match d {
        Some(d) => majority(a, b, c, d),
        None if a == b || a == c => a,
        None if b == c => b,
        None => a.min(b).min(c),
    }
}

/// The most frequent of four numbers; of equally frequent ones, the least.
#[inline]
fn majority(a: BlockId, b: BlockId, c: BlockId, d: BlockId) -> BlockId {
    // A pair, and perhaps the pair of the other two; else all differ.
    let pair = |same: BlockId, x: BlockId, y: BlockId| if x == y { same.min(x) } else { same };
    match () {
        () if a == b && (a == c || a == d) => a,
        () if c == d && (c == a || c == b) => c,
        () if a == b => pair(a, c, d),
        () if a == c => pair(a, b, d),
        () if a == d => pair(a, b, c),
        () if b == c || b == d => b,
        () if c == d => c,
        () => a.min(b).min(c).min(d),
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
    fn the_majority_of_four_is_that_of_the_definition() {
        for n in 0..256 {
            let blocks = [0, 2, 4, 6].map(|shift| n >> shift & 3);
            let count = |block: u32| blocks.iter().filter(|&&other| other == block).count();
            let [a, b, c, d] = blocks;
            let expected = (0..4).min_by_key(|&block| (4 - count(block), block));
            assert_eq!(Some(majority(a, b, c, d)), expected, "{blocks:?}");
        }
    }

    #[test]
    fn every_vertex_lies_in_its_block() {
        for (n, k) in [(1, 1), (1, 9), (7, 3), (1000, 7), (97, 96), (97, 98), (100_003, 1024)] {
            let blocks = Blocks::even(n, k);
            for v in 1..=n {
                assert!(blocks.vertices(blocks.of_vertex(v)).contains(&v), "{v} of {n} in {k}");
            }
        }
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
