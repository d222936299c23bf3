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
//! Cost: about n log n, unless many pieces meet along one edge, or many large ones that have a
//! vertex in common are cut by as many others.

use super::complex::{Complex, Piece, Shape};
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

/// Lists of pieces, ascending, such that every two pieces of different facets that meet are in one
/// of them; and the number of pieces in all boxes that were looked at.
#[derive(Debug, Default)]
pub(super) struct Parted {
    pub(super) lists: Vec<Vec<u32>>,
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
    let parting = Parting { complex, pieces };
    let mut all = Listed::default();
    (0..pieces.len() as u32).for_each(|n| parting.push(n, &mut all));
    parting.cut(all, None, Vain::default(), 0)
}

struct Parting<'c> {
    complex: &'c Complex<'c>,
    pieces: &'c [Piece],
}

/// The pieces in a box, ascending.
#[derive(Default)]
struct Listed {
    list: Vec<u32>,
    /// The last of them that are of one facet.
    alike: usize,
    pairs: u64,
}

impl Listed {
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
}

impl Default for Vain {
    fn default() -> Self {
        Self { left: 1.0, copies: 1.0, looks: 0.0, on_cube: false }
    }
}

impl Vain {
    /// After a cut by which `count` pieces with `pairs` pairs came to these lists.
    fn after(mut self, count: usize, pairs: u64, lists: &[Listed; 2]) -> Self {
        let [one, other] = lists;
        self.left *= (one.pairs + other.pairs) as f64 / pairs as f64;
        self.looks += self.copies;
        self.copies *= ((one.paired() + other.paired()) as f64 / count as f64).max(1.0);
        if self.left <= 0.5 { Self { on_cube: self.on_cube, ..Self::default() } } else { self }
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
        let is_alike =
            to.list.last().is_some_and(|&last| facet(n).is_some() && facet(last) == facet(n));
        to.alike = if is_alike { to.alike + 1 } else { 1 };
        to.list.push(n);
        to.pairs += (to.list.len() - to.alike) as u64;
    }

    /// Cuts the box of some pieces. Ends: `depth` has a bound.
    fn cut(&self, all: Listed, within: Option<Bounds>, vain: Vain, depth: u32) -> Parted {
        let Listed { list, pairs, .. } = all;
        let count = list.len();
        let mut parted = Parted { lists: Vec::new(), steps: count as u64 };
        if pairs == 0 {
            return parted;
        }
        let others = 2.0 * pairs as f64 / count as f64;
        let is_cut = others > FEW && depth < DEPTH;
        let around = (is_cut && !vain.on_cube).then(|| self.around_vertex(&list));
        if let Some(faces) = around.flatten() {
            drop(list);
            for (face, bounds) in faces {
                let vain = Vain { on_cube: true, ..Vain::default() };
                parted.add(self.cut(face, Some(bounds), vain, depth + 1));
            }
            return parted;
        }
        let is_cut = is_cut && vain.looks < LOOKS.min(others / 4.0);
        let bounds = self.taken(&list, within);
        let best = is_cut.then(|| self.best_halves(&list, pairs, bounds));
        let Some(best) = best.flatten() else {
            parted.lists.push(list);
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

    /// The pieces at each face of a cube around the vertex that all pieces have in common, if there
    /// is one. `None` too if rounding might matter there.
    fn around_vertex(&self, list: &[u32]) -> Option<Vec<(Listed, Bounds)>> {
        let has = |n: u32, v: u32| match self.complex.shape(n) {
            Shape::Triangle(t) => t.contains(&v),
            Shape::Edge(e) => e.contains(&v),
            Shape::Vertex(w) => w == v,
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
            let (mut on, around) = (Listed::default(), Around::new(bounds));
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
    fn best_halves(&self, list: &[u32], pairs: u64, bounds: Bounds) -> Option<Halves> {
        let mut axes = [0, 1, 2];
        let length = |k: usize| bounds[1][k] / 2.0 - bounds[0][k] / 2.0;
        axes.sort_by(|&i, &j| length(j).total_cmp(&length(i)));
        let mut best: Option<(f64, Halves)> = None;
        for axis in axes {
            let Some(halves) = self.halves(list, bounds, axis) else { continue };
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
    fn halves(&self, list: &[u32], bounds: Bounds, axis: usize) -> Option<Halves> {
        let [low, high] = bounds;
        let middle = low[axis] / 2.0 + high[axis] / 2.0;
        if !(low[axis] < middle && middle < high[axis]) {
            return None;
        }
        let mut halves = Halves { bounds: [bounds; 2], ..Halves::default() };
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
mod tests {
    use super::*;
    use crate::check::{DomainReport, Findings, pairs};
    use crate::{CheckOptions, DefectKind, Domain, Facet};

    /// A comb with teeth of length 1 on a back as high as the teeth are wide: facets of very many
    /// corners, whose triangles run along all of the back.
    fn comb(teeth: u32) -> Domain {
        let mut ring = Vec::new();
        for k in 0..teeth {
            let corners = [[0, 0], [0, 1], [1, 1], [1, 0]];
            ring.extend(corners.map(|[x, y]| [f64::from(2 * k + x), f64::from(y)]));
        }
        let end = f64::from(2 * teeth);
        ring.extend([[end, 0.0], [end, -1.0], [0.0, -1.0]]);
        let mut domain = Domain::default();
        let count = ring.len() as u32;
        for z in [0.0, 1.0] {
            domain.vertices.extend(ring.iter().map(|&[x, y]| [x, y, z]));
        }
        let front: Vec<u32> = (0..count).collect();
        let back: Vec<u32> = (count..2 * count).collect();
        domain.facets = vec![Facet::polygon(&front, 0), Facet::polygon(&back, 0)];
        domain.facets.extend((0..count).map(|k| {
            let next = (k + 1) % count;
            Facet::polygon(&[k, next, next + count, k + count], 0)
        }));
        domain
    }

    /// A box with faces of `size`² squares of two triangles.
    fn plate(size: u32) -> Domain {
        let mut domain = Domain::default();
        let at = |x: u32, y: u32| y * (size + 1) + x;
        let count = (size + 1) * (size + 1);
        for z in [0.0, 1.0] {
            let points = (0..count).map(|k| [k % (size + 1), k / (size + 1)].map(f64::from));
            domain.vertices.extend(points.map(|[x, y]| [x, y, z]));
        }
        for (x, y) in (0..size * size).map(|k| (k % size, k / size)) {
            for up in [0, count] {
                let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
                domain.facets.push(Facet::polygon(&[a, b, c].map(|v| v + up), 0));
                domain.facets.push(Facet::polygon(&[a, c, d].map(|v| v + up), 0));
            }
        }
        for k in 0..size {
            let ends = [
                [at(k, 0), at(k + 1, 0)],
                [at(k, size), at(k + 1, size)],
                [at(0, k), at(0, k + 1)],
                [at(size, k), at(size, k + 1)],
            ];
            let side = |[a, b]: [u32; 2]| Facet::polygon(&[a, b, b + count, a + count], 0);
            domain.facets.extend(ends.map(side));
        }
        domain
    }

    /// Two cones over a polygon: very many triangles at either apex.
    fn bipyramid(count: u32) -> Domain {
        let mut domain = Domain::default();
        domain.vertices.extend([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]);
        for k in 0..count {
            // A square with many corners along each side, bent outwards.
            let t = f64::from(4 * k / count) + f64::from(k % (count / 4)) / f64::from(count / 4);
            let s = 2.0 * t.fract() - 1.0;
            let out = 2.0 - s * s;
            let [x, y] = [[s, -out], [out, s], [-s, out], [-out, -s]][t as usize];
            domain.vertices.push([x, y, 0.0]);
        }
        for k in 0..count {
            let (a, b) = (2 + k, 2 + (k + 1) % count);
            domain.facets.push(Facet::polygon(&[0, a, b], 0));
            domain.facets.push(Facet::polygon(&[1, b, a], 0));
        }
        domain
    }

    /// A domain of a size.
    type Make = fn(u32) -> Domain;

    fn report(domain: &Domain) -> DomainReport {
        domain.check(&CheckOptions::default()).expect("a report")
    }

    fn complex(domain: &Domain) -> Complex<'_> {
        let mut findings = Findings {
            defects: Default::default(),
            counts: Default::default(),
            listed: 0,
            errors: Vec::new(),
        };
        Complex::new(domain, &mut findings)
    }

    #[test]
    fn each_piece_takes_few_steps_of_many() {
        let makes: [(Make, u32); 3] = [(comb, 1 << 8), (plate, 1 << 4), (bipyramid, 1 << 10)];
        for (make, size) in makes {
            let steps = [1, 2, 4].map(|times| {
                let domain = make(size * times);
                assert!(report(&domain).passed());
                let complex = complex(&domain);
                let pieces = complex.pieces();
                let parted = part(&complex, &pieces);
                let pairs = pairs::compared(&complex, &parted.lists);
                [parted.steps, pairs].map(|n| n as f64 / pieces.len() as f64)
            });
            for pair in steps.windows(2) {
                // For each piece a logarithm of steps, and no more pairs than before.
                assert!(pair[1][0] < 1.3 * pair[0][0] + 4.0, "{steps:?}");
                assert!(pair[1][1] < 1.3 * pair[0][1] + 1.0, "{steps:?}");
            }
        }
    }

    #[test]
    fn what_crosses_a_facet_of_many_corners_is_found() {
        let mut domain = comb(64);
        // A needle through the middle of a tooth, one beside it, and one along the back.
        let needles = [([20.5, 0.5, -1.0], 1), ([21.5, 0.5, -1.0], 0), ([100.5, -0.5, -1.0], 1)];
        for (at, crossings) in needles {
            let before = domain.clone();
            let first = domain.vertices.len() as u32;
            domain.vertices.extend([at, [at[0], at[1], 0.5], [at[0] + 0.125, at[1], 0.5]]);
            domain.facets.push(Facet::polygon(&[first, first + 1, first + 2], 0));
            assert_eq!(report(&domain).count(DefectKind::Intersection), crossings, "{at:?}");
            domain = before;
        }
    }
}
