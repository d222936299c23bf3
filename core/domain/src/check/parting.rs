//! Which pieces may meet: space is cut in halves until few pieces are left in each box, or pieces
//! of one facet only.
//!
//! A piece is in a box if it may meet it, not only if its own box does: long thin triangles, of
//! which a facet with many corners has many, lie across each other's boxes. Of the three ways to
//! halve a box the one with the fewest pairs and pieces in its halves is taken, a pair being two
//! pieces of different facets. A box is not cut if its pairs are few beside its pieces, however
//! many these are, or if cuts cost more than they part. Boxes are compared exactly; triangles and
//! boxes with a slack far above all rounding: no two pieces that meet are parted.
//!
//! Pieces that have a vertex in common lie in one box however small it is. But if two of them meet
//! elsewhere, then along a ray from the vertex, so also on the faces of a cube around it that all
//! sides opposite to the vertex are outside of. So these faces are parted instead.
//!
//! Where a large facet has many of the pieces it is taken out first (`large.rs`): what is not sure
//! to have no contact with it is parted from its triangles, and all others from each other. The
//! long thin triangles of a facet with many corners meet each other's boxes, but hardly anything
//! meets its plane elsewhere than where both draw it.
//!
//! Cost: about n log n, unless many pieces meet along one edge, or many large ones that have a
//! vertex in common are cut by as many others.

use super::complex::{Complex, Piece, Shape};
use super::large::Large;
use crate::vector::{cross, dominant, dot, minus};
use ltbw_exact::Point;

/// Pieces of other facets for each piece, on average, in a box that is not cut.
const FEW: f64 = 48.0;

/// The most looks at each piece of a box, in cuts one in the other, for half of its pairs to fall
/// away. No more looks are worth it than there are others for each piece, either.
const LOOKS: f64 = 32.0;

/// The cost of a cut (see [`Halves::cost`]) below which no other one is tried: about half of the
/// pairs are left, and few pieces are in both halves.
const LITTLE: f64 = 0.6;

/// Times that a list has to be shorter than one out of which a large facet could not be taken, for
/// that to be tried again.
const AGAIN: usize = 4;

/// Cuts one in the other; a box of doubles is a point after fewer than 2^12 of them.
const DEPTH: u32 = 512;

/// Pieces from which on the halves are looked at by two threads.
const SHARED: usize = 1 << 13;

/// Part of the largest product that rounded sums may be off by: fewer than 16 roundings of 2^-53.
const SLACK: f64 = 1.0 / (1u64 << 40) as f64;

/// Part of the largest coordinate above which half the side of a cube is far above all rounding.
const ROUGH: f64 = 1.0 / (1u64 << 30) as f64;

/// A box: its lowest and its highest corner.
type Bounds = [Point; 2];

/// A box, and what the test of each piece asks of it.
struct Around {
    bounds: Bounds,
    middle: Point,
    /// Half of its sides.
    half: Point,
    /// Its largest coordinate.
    reach: f64,
}

impl Around {
    fn new(bounds: Bounds) -> Self {
        let [low, high] = bounds;
        let middle = [0, 1, 2].map(|k: usize| low[k] / 2.0 + high[k] / 2.0);
        let half = [0, 1, 2].map(|k: usize| high[k] / 2.0 - low[k] / 2.0);
        let reach = low.iter().chain(&high).fold(0.0, |m: f64, c| m.max(c.abs()));
        Self { bounds, middle, half, reach }
    }
}

/// Pieces that may meet, ascending.
#[derive(Debug)]
pub(super) struct Together {
    pub(super) list: Vec<u32>,
    /// The facet of which one of each two is a piece, if it is about that facet alone.
    pub(super) own: Option<u32>,
}

/// Lists of pieces such that every two pieces of different facets that meet are in one of them;
/// and the number of pieces in all boxes that were looked at.
#[derive(Debug, Default)]
pub(super) struct Parted {
    pub(super) lists: Vec<Together>,
    pub(super) steps: u64,
}

impl Parted {
    fn add(&mut self, part: Parted) {
        self.lists.extend(part.lists);
        self.steps += part.steps;
    }
}

/// Parts the pieces of a complex.
pub(super) fn part(complex: &Complex<'_>, pieces: &[Piece]) -> Parted {
    let parting = Parting { complex, pieces, large: Large::new(complex) };
    let mut all = Listed::default();
    (0..pieces.len() as u32).for_each(|n| parting.push(n, &mut all));
    parting.cut(all, None, Vain::default(), 0)
}

struct Parting<'c> {
    complex: &'c Complex<'c>,
    pieces: &'c [Piece],
    large: Large<'c>,
}

/// The pieces in a box, ascending.
#[derive(Default)]
struct Listed {
    list: Vec<u32>,
    /// The facet of which one of each pair is a piece, if it is about that facet alone.
    own: Option<u32>,
    /// The last pieces that are of one facet; all that are of this facet.
    alike: usize,
    pairs: u64,
}

impl Listed {
    fn about(own: Option<u32>) -> Self {
        Self { own, ..Self::default() }
    }

    /// The pieces that are looked at again.
    fn paired(&self) -> usize {
        if self.pairs > 0 { self.list.len() } else { 0 }
    }
}

/// The cuts, one in the other, since half of the pairs have fallen away.
#[derive(Clone, Copy)]
struct Vain {
    /// The part of the pairs that is left.
    left: f64,
    /// The number of lists that a piece is in, on average.
    copies: f64,
    /// The number of looks at each piece.
    looks: f64,
    /// Is the box on a cube around a vertex?
    on_cube: bool,
    /// The pieces of the last list out of which a large facet could not be taken.
    stuck: usize,
}

impl Default for Vain {
    fn default() -> Self {
        Self { left: 1.0, copies: 1.0, looks: 0.0, on_cube: false, stuck: usize::MAX }
    }
}

impl Vain {
    /// After a cut by which `count` pieces with `pairs` pairs came to these lists.
    fn after(mut self, count: usize, pairs: u64, lists: &[Listed; 2]) -> Self {
        let [one, other] = lists;
        self.left *= (one.pairs + other.pairs) as f64 / pairs as f64;
        self.looks += self.copies;
        self.copies *= ((one.paired() + other.paired()) as f64 / count as f64).max(1.0);
        let Self { on_cube, stuck, .. } = self;
        if self.left <= 0.5 { Self { on_cube, stuck, ..Self::default() } } else { self }
    }
}

/// A way to halve a box.
#[derive(Default)]
struct Halves {
    lists: [Listed; 2],
    bounds: [Bounds; 2],
}

impl Halves {
    /// The pairs that are left times the pieces that have one, in parts of what they were: pieces
    /// in both halves cost, too.
    fn cost(&self, count: usize, pairs: u64) -> f64 {
        let [one, other] = &self.lists;
        let left = (one.pairs + other.pairs) as f64 / pairs as f64;
        left * (one.paired() + other.paired()) as f64 / count as f64
    }
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

    /// Adds a piece, of a higher number than all in a list.
    fn push(&self, n: u32, to: &mut Listed) {
        let facet = |n: u32| self.complex.facet_of.get(n as usize);
        let count = to.list.len();
        if to.own.is_some() {
            let is_own = facet(n) == to.own.as_ref();
            to.pairs += if is_own { count - to.alike } else { to.alike } as u64;
            to.alike += usize::from(is_own);
        } else {
            let is_alike =
                to.list.last().is_some_and(|&last| facet(n).is_some() && facet(last) == facet(n));
            to.alike = if is_alike { to.alike + 1 } else { 1 };
            to.pairs += (count + 1 - to.alike) as u64;
        }
        to.list.push(n);
    }

    /// Cuts the box of some pieces. Ends: `depth` has a bound.
    fn cut(&self, all: Listed, within: Option<Bounds>, mut vain: Vain, depth: u32) -> Parted {
        let Listed { list, own, pairs, .. } = all;
        let count = list.len();
        let mut parted = Parted { lists: Vec::new(), steps: count as u64 };
        if pairs == 0 {
            return parted;
        }
        let others = 2.0 * pairs as f64 / count as f64;
        let is_cut = others > FEW && depth < DEPTH;
        if is_cut
            && own.is_none()
            && count <= vain.stuck / AGAIN
            && let Some((f, places)) = self.large.foremost(&list)
        {
            parted.steps += count as u64;
            match self.taken_out(f, places, &list) {
                Some(lists) => {
                    drop(list);
                    for part in lists {
                        parted.add(self.cut(
                            part,
                            within,
                            Vain { on_cube: vain.on_cube, ..Vain::default() },
                            depth + 1,
                        ));
                    }
                    return parted;
                }
                None => vain.stuck = count,
            }
        }
        let around = (is_cut && !vain.on_cube).then(|| self.around_vertex(&list, own));
        if let Some(faces) = around.flatten() {
            drop(list);
            for (face, bounds) in faces {
                let vain = Vain { on_cube: true, stuck: vain.stuck, ..Vain::default() };
                parted.add(self.cut(face, Some(bounds), vain, depth + 1));
            }
            return parted;
        }
        let is_cut = is_cut && vain.looks < LOOKS.min(others / 4.0);
        let bounds = self.taken(&list, within);
        let best = is_cut.then(|| self.best_halves(&list, own, pairs, bounds));
        let Some(best) = best.flatten() else {
            parted.lists.push(Together { list, own });
            return parted;
        };
        drop(list);
        let Halves { lists, bounds: [low, high] } = best;
        let vain = vain.after(count, pairs, &lists);
        let [left, right] = lists;
        let go = |half: Listed, bounds: Bounds| self.cut(half, Some(bounds), vain, depth + 1);
        let parts = match count < SHARED {
            true => (go(left, low), go(right, high)),
            false => rayon::join(|| go(left, low), || go(right, high)),
        };
        parted.add(parts.0);
        parted.add(parts.1);
        parted
    }

    /// The pieces of a large facet with all that is not sure to have no contact with it, and all
    /// other pieces; `None` if that does not part half of them from it.
    fn taken_out(&self, f: u32, [first, end]: [usize; 2], list: &[u32]) -> Option<[Listed; 2]> {
        let others = || list[..first].iter().chain(&list[end..]);
        let near: Vec<u32> = others().copied().filter(|&n| !self.large.is_apart(f, n)).collect();
        if 2 * near.len() > list.len() - (end - first) {
            return None;
        }
        let (mut about, mut rest) = (Listed::about(Some(f)), Listed::default());
        let (below, above) = near.split_at(near.partition_point(|&n| n < list[first]));
        let own = below.iter().chain(&list[first..end]).chain(above);
        own.for_each(|&n| self.push(n, &mut about));
        others().for_each(|&n| self.push(n, &mut rest));
        Some([about, rest])
    }

    /// The pieces at each face of a cube around the vertex that all pieces have in common, if there
    /// is one. `None` too if rounding might matter there.
    fn around_vertex(&self, list: &[u32], own: Option<u32>) -> Option<Vec<(Listed, Bounds)>> {
        let has = |n: u32, v: u32| match self.complex.shape(n) {
            Shape::Triangle(t) => t.contains(&v),
            Shape::Edge(e) => e.contains(&v),
        };
        let Shape::Triangle(first) = self.complex.shape(*list.first()?) else { return None };
        let v = first.into_iter().find(|&v| list.iter().all(|&n| has(n, v)))?;
        let p = &self.complex.points[v as usize];
        let half = list.iter().map(|&n| self.clearance(n, p)).fold(f64::INFINITY, f64::min) / 4.0;
        let reach = list.iter().flat_map(|&n| self.complex.corners(n).0).flatten();
        let reach = reach.fold(0.0, |m: f64, c| m.max(c.abs()));
        if !(half > reach * ROUGH && half.is_finite()) {
            return None;
        }
        let cube = [p.map(|c| c - half), p.map(|c| c + half)];
        let faces = (0..3).flat_map(|axis| [0, 1].map(|side| (axis, side)));
        let face = |(axis, side): (usize, usize)| {
            let mut bounds = cube;
            bounds[1 - side][axis] = cube[side][axis];
            let (mut on, around) = (Listed::about(own), Around::new(bounds));
            let met = list.iter().filter(|&&n| self.may_meet(n, &around));
            met.for_each(|&n| self.push(n, &mut on));
            (on, bounds)
        };
        Some(faces.map(face).collect())
    }

    /// Rounded, the distance of a corner of a piece from the side opposite.
    fn clearance(&self, number: u32, p: &Point) -> f64 {
        let corners = self.complex.corners(number).0;
        let mut ends = corners.into_iter().filter(|q| *q != p);
        let (Some(a), b) = (ends.next(), ends.next()) else { return f64::INFINITY };
        let b = b.unwrap_or(a);
        let (along, to) = (minus(b, a), minus(p, a));
        let t = (dot(&along, &to) / dot(&along, &along)).clamp(0.0, 1.0);
        let t = if t.is_nan() { 0.0 } else { t };
        let away = [0, 1, 2].map(|k: usize| to[k] - t * along[k]);
        dot(&away, &away).sqrt()
    }

    /// The halves of least cost, or the first ones of little cost; the longest side is tried first.
    fn best_halves(
        &self,
        list: &[u32],
        own: Option<u32>,
        pairs: u64,
        bounds: Bounds,
    ) -> Option<Halves> {
        let mut axes = [0, 1, 2];
        let length = |k: usize| bounds[1][k] / 2.0 - bounds[0][k] / 2.0;
        axes.sort_by(|&i, &j| length(j).total_cmp(&length(i)));
        let mut best: Option<(f64, Halves)> = None;
        for axis in axes {
            let Some(halves) = self.halves(list, own, bounds, axis) else { continue };
            let cost = halves.cost(list.len(), pairs);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, halves));
            }
            if cost < LITTLE {
                break;
            }
        }
        best.map(|(_, halves)| halves)
    }

    /// The pieces in the halves of a box; `None` if it has none along this axis.
    fn halves(
        &self,
        list: &[u32],
        own: Option<u32>,
        bounds: Bounds,
        axis: usize,
    ) -> Option<Halves> {
        let [low, high] = bounds;
        let middle = low[axis] / 2.0 + high[axis] / 2.0;
        if !(low[axis] < middle && middle < high[axis]) {
            return None;
        }
        let lists = [own, own].map(Listed::about);
        let mut halves = Halves { lists, bounds: [bounds; 2] };
        halves.bounds[0][1][axis] = middle;
        halves.bounds[1][0][axis] = middle;
        let around = halves.bounds.map(Around::new);
        for &n in list {
            let piece = &self.pieces[n as usize];
            let on = [piece.low[axis] <= middle, piece.high[axis] >= middle];
            for side in (0..2).filter(|&side| on[side]) {
                if !on[1 - side] || self.may_meet(n, &around[side]) {
                    self.push(n, &mut halves.lists[side]);
                }
            }
        }
        Some(halves)
    }

    /// May a piece meet a box? No if a plane parts them that is normal to an axis, to the piece, or
    /// to a side of the piece and an axis.
    fn may_meet(&self, number: u32, around: &Around) -> bool {
        let piece = &self.pieces[number as usize];
        let Around { bounds: [low, high], middle, half, reach } = around;
        if (0..3).any(|k| piece.low[k] > high[k] || piece.high[k] < low[k]) {
            return false;
        }
        // Sides of length 0, which all but triangles have, part nothing.
        let corners = self.complex.corners(number).0;
        let own = |m: f64, k: usize| m.max(piece.low[k].abs()).max(piece.high[k].abs());
        let slack = SLACK * (0..3).fold(*reach, own);
        let at = corners.map(|p| [0, 1, 2].map(|k: usize| p[k] - middle[k]));
        let sides = [[0, 1], [1, 2], [2, 0]];
        let sides = sides.map(|[a, b]| [0, 1, 2].map(|k: usize| corners[b][k] - corners[a][k]));
        let size = sides.map(|e: Point| e[0].abs().max(e[1].abs()).max(e[2].abs()));
        let n = cross(&sides[0], &sides[1]);
        let spread = n.map(f64::abs);
        if dot(&n, &at[0]).abs() > dot(&spread, half) + slack * size[0] * size[1] {
            return false;
        }
        // The plane to which a piece is closest comes first: there it is seen at its widest, and a
        // long thin triangle is parted from most boxes beside it.
        let flat = dominant(&n);
        (0..3).all(|turn| {
            let (i, j) = ((flat + turn + 1) % 3, (flat + turn + 2) % 3);
            sides.iter().enumerate().all(|(k, e)| {
                let height = |p: &Point| p[i] * e[j] - p[j] * e[i];
                // Both ends of the side are at one height.
                let (one, other) = (height(&at[k]), height(&at[(k + 2) % 3]));
                let own = e[j].abs() * half[i] + e[i].abs() * half[j] + slack * size[k];
                !(one.min(other) > own || one.max(other) < -own)
            })
        })
    }
}

#[cfg(test)]
mod tests;
