//! Which block a vertex and a tetrahedron belong to.

use super::name::{NO_PLACE, Place, VertexName, given};
use crate::protocol::BlockId;
use ltbw_core::order::Curve;
use ltbw_exact::Point;
use std::sync::Arc;

/// The blocks of a mesh: pieces of a Hilbert curve through its vertices.
///
/// Given vertices are numbered along the curve, so that a block is a range of numbers. Cuts lie
/// between points, at no fixed depth of the curve: a cluster is cut as evenly as anything. A vertex
/// that is made on the way belongs where its coordinates lie along the curve, at the depth of one
/// key: a function of the coordinates and of the cuts, which all workers have.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// First vertex of each block, and one past the last vertex of all.
    starts: Arc<[Place]>,
    /// Blocks by vertices, in 2^-32: blocks are nearly even, so that this guesses a block; 0 if
    /// they are not.
    density: u64,
    /// The curve, and the key on it of each block's first vertex; ascending.
    cuts: Option<(Curve, Arc<[u64]>)>,
}

/// A weight at a place along the curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Mark {
    pub(crate) key: u64,
    pub(crate) weight: u64,
}

/// A place, and its weight.
pub(crate) type Weight = (Point, u64);

impl Blocks {
    /// Cuts vertices 1 to `vertices` into `blocks` blocks of nearly equal size.
    pub fn even(vertices: u32, blocks: u32) -> Self {
        let (n, k) = (u64::from(vertices), u64::from(blocks.max(1)));
        let density = (k << 32) / n.max(1);
        let starts = (0..=k).map(|b| 1 + (b * n / k) as Place).collect();
        Self { starts, density, cuts: None }
    }

    /// Cuts a curve, along which `points` are numbered, into `blocks` blocks with about equal parts
    /// of the weights of some places.
    pub(crate) fn weighted(
        curve: Curve,
        points: &[Point],
        weights: &[Weight],
        blocks: u32,
    ) -> Self {
        let mark = |(p, weight): &Weight| Mark { key: curve.key(p), weight: *weight };
        let mut keyed: Vec<Mark> = weights.iter().map(mark).collect();
        keyed.sort_unstable();
        Self::by_keys(curve, points, &keyed, blocks)
    }

    /// As [`Blocks::weighted`], by the keys of places, ascending.
    fn by_keys(curve: Curve, points: &[Point], keyed: &[Mark], blocks: u32) -> Self {
        let blocks = blocks.max(1) as usize;
        let all: u128 = keyed.iter().map(|own| u128::from(own.weight)).sum();
        let (mut cuts, mut sum) = (vec![0], 0);
        for &Mark { key, weight } in keyed {
            sum += u128::from(weight);
            // A block ends where its share is reached.
            while cuts.len() < blocks && sum * blocks as u128 >= cuts.len() as u128 * all {
                cuts.push(key + 1);
            }
        }
        cuts.resize(blocks, u64::MAX);
        let first = |&cut: &u64| 1 + points.partition_point(|p| curve.key(p) < cut) as Place;
        let starts = cuts.iter().map(first).chain([1 + points.len() as Place]).collect();
        Self { starts, density: 0, cuts: Some((curve, cuts.into())) }
    }

    /// As many blocks by other cuts of the curve, along which `points` are numbered, by the weights
    /// at some keys, ascending. `None` if there is no curve.
    pub(crate) fn recut(&self, points: &[Point], keyed: &[Mark]) -> Option<Self> {
        let (curve, _) = self.cuts.as_ref()?;
        Some(Self::by_keys(*curve, points, keyed, self.len() as u32))
    }

    /// The key of a place along the curve; 0 if there is none.
    pub(crate) fn key(&self, p: &Point) -> u64 {
        self.cuts.as_ref().map_or(0, |(curve, _)| curve.key(p))
    }

    /// These blocks, for vertices to come, too: `points` are those given, along `curve`.
    pub(super) fn along(self, curve: Curve, points: &[Point]) -> Self {
        let last = points.len().saturating_sub(1);
        let first = |&start: &Place| points.get((start as usize - 1).min(last));
        let key = |start| first(start).map_or(0, |p| curve.key(p));
        let mut keys: Vec<u64> = self.starts[..self.starts.len() - 1].iter().map(key).collect();
        // Clusters are sorted again: inside one cell the keys are equal, and never fall.
        keys.sort_unstable();
        Self { cuts: Some((curve, keys.into())), ..self }
    }

    /// The block of a finite vertex by its name, at `p`.
    #[inline]
    pub(super) fn of_name(&self, name: VertexName, p: &Point) -> BlockId {
        given(name).map_or_else(|| self.of_point(p), |place| self.of_vertex(place))
    }

    /// The block of the place where `p` lies on the curve.
    pub(crate) fn of_point(&self, p: &Point) -> BlockId {
        let Some((curve, keys)) = self.cuts.as_ref().filter(|(_, keys)| keys.len() > 1) else {
            return BlockId::default();
        };
        let key = curve.key(p);
        BlockId::at(keys.partition_point(|&first| first <= key).max(1) - 1)
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Is there no block? Never.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One past the last vertex that was given.
    pub(super) fn end(&self) -> Place {
        self.starts[self.starts.len() - 1]
    }

    /// The vertices of `block`.
    pub fn vertices(&self, block: BlockId) -> std::ops::Range<Place> {
        self.starts[block.index()]..self.starts[block.index() + 1]
    }

    /// The vertices of some blocks that follow one another, given by their numbers.
    pub(crate) fn stretch(&self, blocks: std::ops::Range<u32>) -> std::ops::Range<Place> {
        self.starts[blocks.start as usize]..self.starts[blocks.end as usize]
    }

    /// The block of a finite vertex.
    #[inline]
    pub fn of_vertex(&self, v: Place) -> BlockId {
        let last = self.starts.len() - 2;
        if self.density == 0 {
            return BlockId::at(
                self.starts[..=last].partition_point(|&first| first <= v).max(1) - 1,
            );
        }
        let guess = (u64::from(v.saturating_sub(1)) * self.density) >> 32;
        let mut block = (guess as usize).min(last);
        // A few steps at most: the guess is off by rounding, or by empty blocks.
        while block < last && self.starts[block + 1] <= v {
            block += 1;
        }
        while block > 0 && self.starts[block] > v {
            block -= 1;
        }
        BlockId::at(block)
    }

    /// The block of a tetrahedron: that of most of its finite vertices; of equals, the smallest.
    #[inline]
    pub fn of_tet(&self, v: [Place; 4]) -> BlockId {
        let first = self.of_vertex(v[0]);
        let range = self.vertices(first);
        // Most tetrahedra lie in one block.
        if v[1..].iter().all(|w| range.contains(w)) {
            return first;
        }
        let [b, c] = [self.of_vertex(v[1]), self.of_vertex(v[2])];
        let d = (v[3] != NO_PLACE).then(|| self.of_vertex(v[3]));
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

/// The block of a tetrahedron by those of its vertices, with the vertex at infinity, which has
/// none, anywhere.
pub(super) fn prevailing_of(mut blocks: [Option<BlockId>; 4]) -> BlockId {
    if let Some(place) = blocks.iter().position(Option::is_none) {
        blocks.swap(place, 3);
    }
    let [a, b, c, d] = blocks;
    prevailing([a, b, c].map(Option::unwrap_or_default), d)
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
    use super::super::name::made;
    use super::*;
    use crate::protocol::WorkerId;
    use ltbw_core::order::hilbert;
    use ltbw_core::submesh::MeshParams;
    use ltbw_exact::Mode;
    use ltbw_generate::{PointKind, generate};

    #[test]
    fn blocks_are_ranges_and_majorities() {
        let blocks = Blocks::even(10, 4);
        assert_eq!(blocks.len(), 4);
        let of: Vec<u32> = (1..=10).map(|v| blocks.of_vertex(v).number()).collect();
        assert_eq!(of, [0, 0, 1, 1, 1, 2, 2, 3, 3, 3]);
        for (v, &block) in (1..).zip(&of) {
            assert!(blocks.vertices(BlockId::new(block)).contains(&v));
        }
        assert_eq!(blocks.of_tet([1, 4, 5, 9]), BlockId::new(1));
        assert_eq!(
            blocks.of_tet([9, 8, 1, 2]),
            BlockId::default(),
            "two and two: the smaller block"
        );
        assert_eq!(blocks.of_tet([9, 1, 4, 6]), BlockId::default(), "four different ones");
        assert_eq!(blocks.of_tet([9, 8, 1, NO_PLACE]), BlockId::new(3));
    }

    #[test]
    fn the_majority_of_four_is_that_of_the_definition() {
        for n in 0..256 {
            let blocks = [0, 2, 4, 6].map(|shift| BlockId::new(n >> shift & 3));
            let count = |block: BlockId| blocks.iter().filter(|&&other| other == block).count();
            let [a, b, c, d] = blocks;
            let expected = BlockId::below(4).min_by_key(|&block| (4 - count(block), block));
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

    /// Names do not matter where no two points share a cell: coordinates tell the same.
    #[test]
    fn a_vertex_made_at_a_given_place_belongs_to_the_same_block() {
        let points = generate(PointKind::Uniform, 3000, 1);
        let order = hilbert(&points);
        let sorted: Vec<Point> = order.iter().map(|&i| points[i as usize]).collect();
        let curve = || {
            let (low, high) = MeshParams::of(&sorted, Mode::Normal).bounds();
            Curve::of_box(low, high)
        };
        for count in [1, 2, 7, 64, 3000] {
            let blocks = Blocks::even(3000, count).along(curve(), &sorted);
            for (place, p) in (1u32..).zip(&sorted) {
                let made = blocks.of_name(made(WorkerId::default(), place), p);
                assert_eq!(made, blocks.of_name(place.into(), p), "{place} of {count}");
            }
            for outside in [[-9.0; 3], [9.0; 3]] {
                assert!(blocks.of_point(&outside) < BlockId::new(count));
            }
        }
    }

    #[test]
    fn more_blocks_than_vertices() {
        let blocks = Blocks::even(3, 8);
        for v in 1..=3 {
            assert!(blocks.vertices(blocks.of_vertex(v)).contains(&v));
        }
        assert_eq!(BlockId::below(8).map(|b| blocks.vertices(b).len()).sum::<usize>(), 3);
    }
}
