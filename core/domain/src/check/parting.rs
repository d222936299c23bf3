//! Which pieces may meet: space is cut in halves until few pieces are left in each box, or pieces
//! of one facet only.
//!
//! A piece is in a box if it may meet it, not only if its own box does: long thin triangles, of
//! which a facet with many corners has many, lie across each other's boxes. Of the three ways to
//! halve a box the one with the fewest pairs of pieces in its halves is taken. Boxes are compared
//! exactly; triangles and boxes with a slack far above all rounding: no two pieces that meet
//! are parted. Cost: about n log n, unless many pieces of different facets meet in one point.

use super::complex::{Complex, Piece};
use ltbw_exact::Point;

/// Pieces in a box that is not cut.
const FEW: usize = 12;

/// Cuts one after the other that leave nearly as many pairs, after which a box is not cut.
const IN_VAIN: u32 = 4;

/// Cuts one in the other; a box of doubles is a point after fewer than 2^12 of them.
const DEPTH: u32 = 512;

/// Pieces from which on the halves are looked at by two threads.
const SHARED: usize = 1 << 13;

/// Part of the largest product that rounded sums may be off by: fewer than 16 roundings of 2^-53.
const SLACK: f64 = 1.0 / (1u64 << 40) as f64;

/// A box: its lowest and its highest corner.
type Bounds = [Point; 2];

/// Lists of pieces, ascending, such that every two pieces of different facets that meet are in one
/// of them; and the number of pieces in all boxes that were looked at.
#[derive(Debug, Default)]
pub(super) struct Parted {
    pub(super) lists: Vec<Vec<u32>>,
    pub(super) steps: u64,
}

/// Parts the pieces of a complex.
pub(super) fn part(complex: &Complex<'_>, pieces: &[Piece]) -> Parted {
    let parting = Parting { complex, pieces };
    let all: Vec<u32> = (0..pieces.len() as u32).collect();
    parting.cut(all, None, 0, 0)
}

struct Parting<'c> {
    complex: &'c Complex<'c>,
    pieces: &'c [Piece],
}

/// A way to halve a box.
#[derive(Default)]
struct Halves {
    lists: [Vec<u32>; 2],
    bounds: [Bounds; 2],
    /// About twice the number of pairs.
    pairs: f64,
}

impl Parting<'_> {
    /// The part of a box that the boxes of its pieces take.
    fn taken(&self, list: &[u32], within: Option<Bounds>) -> Bounds {
        let none = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let all = list.iter().fold(none, |[low, high], &n| {
            let piece = &self.pieces[n as usize];
            [
                [0, 1, 2].map(|k| piece.low[k].min(low[k])),
                [0, 1, 2].map(|k| piece.high[k].max(high[k])),
            ]
        });
        let Some([low, high]) = within else { return all };
        [
            [0, 1, 2].map(|k: usize| all[0][k].max(low[k])),
            [0, 1, 2].map(|k: usize| all[1][k].min(high[k])),
        ]
    }

    /// Are all pieces of one facet?
    fn is_one_facet(&self, list: &[u32]) -> bool {
        let facet = |n: &u32| self.complex.facet_of.get(*n as usize);
        list.first().is_none_or(|first| {
            facet(first).is_some() && list.iter().all(|n| facet(n) == facet(first))
        })
    }

    /// Cuts the box of some pieces. Ends: `depth` has a bound.
    fn cut(&self, list: Vec<u32>, within: Option<Bounds>, depth: u32, in_vain: u32) -> Parted {
        let count = list.len();
        let mut parted = Parted { lists: Vec::new(), steps: count as u64 };
        if count < 2 || self.is_one_facet(&list) {
            return parted;
        }
        let bounds = self.taken(&list, within);
        let halves = (0..3).filter_map(|axis| self.halves(&list, bounds, axis));
        let best = halves.min_by(|a, b| a.pairs.total_cmp(&b.pairs));
        let Some(best) = best.filter(|_| count > FEW && depth < DEPTH && in_vain < IN_VAIN) else {
            parted.lists.push(list);
            return parted;
        };
        let in_vain = match best.pairs > 0.8 * (count as f64 * count as f64) {
            true => in_vain + 1,
            false => 0,
        };
        drop(list);
        let [left, right] = best.lists;
        let [low, high] = best.bounds;
        let go = |list: Vec<u32>, bounds: Bounds| self.cut(list, Some(bounds), depth + 1, in_vain);
        let parts = match count < SHARED {
            true => (go(left, low), go(right, high)),
            false => rayon::join(|| go(left, low), || go(right, high)),
        };
        for part in [parts.0, parts.1] {
            parted.lists.extend(part.lists);
            parted.steps += part.steps;
        }
        parted
    }

    /// The pieces in the halves of a box; `None` if it has none along this axis.
    fn halves(&self, list: &[u32], bounds: Bounds, axis: usize) -> Option<Halves> {
        let [low, high] = bounds;
        let middle = low[axis] / 2.0 + high[axis] / 2.0;
        if !(low[axis] < middle && middle < high[axis]) {
            return None;
        }
        let mut halves = Halves { bounds: [bounds; 2], ..Halves::default() };
        halves.bounds[0][1][axis] = middle;
        halves.bounds[1][0][axis] = middle;
        for &n in list {
            let piece = &self.pieces[n as usize];
            let on = [piece.low[axis] <= middle, piece.high[axis] >= middle];
            for side in (0..2).filter(|&side| on[side]) {
                if !on[1 - side] || self.may_meet(n, &halves.bounds[side]) {
                    halves.lists[side].push(n);
                }
            }
        }
        let pairs = |list: &Vec<u32>| match self.is_one_facet(list) {
            true => 0.0,
            false => list.len() as f64 * list.len() as f64,
        };
        halves.pairs = halves.lists.iter().map(pairs).sum();
        Some(halves)
    }

    /// May a piece meet a box? No if a plane parts them that is normal to an axis, to the piece, or
    /// to a side of it and an axis.
    fn may_meet(&self, number: u32, [low, high]: &Bounds) -> bool {
        let piece = &self.pieces[number as usize];
        if (0..3).any(|k| piece.low[k] > high[k] || piece.high[k] < low[k]) {
            return false;
        }
        let (corners, count) = self.complex.corners(number);
        let corners = &corners[..count];
        let middle = [0, 1, 2].map(|k: usize| low[k] / 2.0 + high[k] / 2.0);
        let half = [0, 1, 2].map(|k: usize| high[k] / 2.0 - low[k] / 2.0);
        let all = corners.iter().copied().chain([low, high]).flatten();
        let reach = all.fold(0.0, |m: f64, c| m.max(c.abs()));
        let minus = |p: &Point, q: &Point| [0, 1, 2].map(|k: usize| p[k] - q[k]);
        let parts = |n: Point, size: f64| {
            let heights = corners.iter().map(|p| minus(p, &middle));
            let heights = heights.map(|v| n[0] * v[0] + n[1] * v[1] + n[2] * v[2]);
            let (least, most) =
                heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
            let own: f64 = (0..3).map(|k| n[k].abs() * half[k]).sum();
            let own = own + SLACK * size * reach;
            least > own || most < -own
        };
        let largest = |v: &Point| v.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let sides = (0..count).map(|k| minus(corners[(k + 1) % count], corners[k]));
        let mut normals = sides.flat_map(|e| {
            let size = largest(&e);
            let across = [[0.0, e[2], -e[1]], [-e[2], 0.0, e[0]], [e[1], -e[0], 0.0]];
            across.map(|n| (n, size))
        });
        if normals.any(|(n, size)| parts(n, size)) {
            return false;
        }
        let [a, b, c] = corners else { return true };
        let (u, v) = (minus(b, a), minus(c, a));
        let n = [0, 1, 2].map(|k: usize| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            u[i] * v[j] - u[j] * v[i]
        });
        !parts(n, largest(&u) * largest(&v))
    }
}
