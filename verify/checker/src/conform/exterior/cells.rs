//! The cells between pieces.

use super::super::whole::Whole;
use super::cast::{Hit, cast};
use super::hom::Hom;
use super::pieces::{Piece, undirected};
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;

/// The most times that a segment is cast anew when it meets an edge.
const TRIES: u64 = 64;

/// A piece at an edge: the edge, the piece, and whether the piece's edge runs from the edge's
/// smaller vertex to the larger.
type Wing = ([u32; 2], usize, bool);

/// Sides of pieces, `2k` in front and `2k + 1` behind piece `k`, united into cells.
pub(super) struct Cells {
    root: Vec<usize>,
    wings: Vec<Wing>,
    /// A side of the outside, and sides of cells with hole points.
    empty: Vec<usize>,
    /// Of each side whether its cell is exterior.
    is_exterior: Vec<bool>,
}

fn find(root: &mut [usize], mut x: usize) -> usize {
    // Halves the path: every turn goes to a smaller number.
    while root[x] != x {
        root[x] = root[root[x]];
        x = root[x];
    }
    x
}

fn unite(root: &mut [usize], x: usize, y: usize) {
    let (x, y) = (find(root, x), find(root, y));
    root[x.max(y)] = x.min(y);
}

/// The side of a wing that lies ahead, counterclockwise around the edge seen against it.
fn ahead(&(_, piece, along): &Wing) -> usize {
    2 * piece + usize::from(!along)
}

impl Cells {
    /// The cells up to shells inside each other.
    pub(super) fn new(pieces: &[Piece], corners: &[Whole]) -> Self {
        let mut wings: Vec<Wing> = Vec::new();
        for (k, piece) in pieces.iter().enumerate() {
            wings.extend(piece.rim.iter().map(|&half| {
                let (edge, along) = undirected(half);
                (edge, k, along)
            }));
        }
        wings.sort_unstable();
        let mut root: Vec<usize> = (0..2 * pieces.len()).collect();
        for group in wings.chunk_by(|a, b| a.0 == b.0) {
            let sorted;
            let around = match group {
                [_] | [_, _] => group,
                _ => {
                    sorted = around(group, pieces, corners);
                    &sorted
                }
            };
            for (i, wing) in around.iter().enumerate() {
                let next = &around[(i + 1) % around.len()];
                unite(&mut root, ahead(wing), ahead(next) ^ 1);
            }
        }
        Self { root, wings, empty: Vec::new(), is_exterior: Vec::new() }
    }

    fn groups(&self) -> impl Iterator<Item = &[Wing]> {
        self.wings.chunk_by(|a, b| a.0 == b.0)
    }

    /// Are there two pieces at every edge?
    pub(super) fn is_closed(&self) -> bool {
        self.groups().all(|group| group.len() == 2)
    }

    /// Does a vertex of the domain lie inside an edge of one piece only? Then the domain is not
    /// sound: what seems open there may be closed.
    pub(super) fn has_vertex_on_open_edge(&self, corners: &[Whole]) -> bool {
        let open: Vec<[u32; 2]> =
            self.groups().filter(|group| group.len() == 1).map(|group| group[0].0).collect();
        if open.is_empty() {
            return false;
        }
        let mut order: Vec<&Whole> = corners.iter().collect();
        order.sort_unstable();
        open.into_iter().any(|[a, b]| {
            let (a, b) = (&corners[a as usize], &corners[b as usize]);
            let (low, high) = (a[0].min(b[0]), a[0].max(b[0]));
            let start = order.partition_point(|p| p[0] < low);
            let slab = order[start..].iter().take_while(|p| p[0] <= high);
            slab.into_iter()
                .any(|p| *p != a && *p != b && super::super::place::along(*a, *b, **p).is_some())
        })
    }

    /// Joins the cells of shells inside each other; `false` if a shell cannot be placed.
    pub(super) fn join(&mut self, pieces: &[Piece], corners: &[Whole]) -> bool {
        let mut shell: Vec<usize> = (0..pieces.len()).collect();
        for group in self.wings.chunk_by(|a, b| a.0 == b.0) {
            group.iter().for_each(|wing| unite(&mut shell, group[0].1, wing.1));
        }
        for first in 0..pieces.len() {
            if find(&mut shell, first) != first {
                continue;
            }
            let tries = (0..TRIES).map(|attempt| {
                let to = inner_point(&pieces[first], corners, attempt)?;
                let hits = cast(pieces, corners, &far(corners, attempt), &to, Some(first))?;
                hits.last().is_some_and(|hit| hit.near() / 2 == first).then_some(hits)
            });
            let Some(hits) = tries.into_iter().flatten().next() else { return false };
            self.empty.push(hits[0].near());
            for pair in hits.windows(2) {
                unite(&mut self.root, pair[0].far(), pair[1].near());
            }
        }
        true
    }

    /// The side that a point on no piece sees; `Err` if that is not found, `Ok(None)` if it sees
    /// none.
    fn side(pieces: &[Piece], corners: &[Whole], p: &Hom) -> Result<Option<usize>, ()> {
        let mut tries =
            (0..TRIES).filter_map(|attempt| cast(pieces, corners, &far(corners, attempt), p, None));
        let hits = tries.next().ok_or(())?;
        Ok(hits.last().map(Hit::far))
    }

    /// Finds the exterior: the outside, and the cells of these points of holes.
    pub(super) fn empty(&mut self, pieces: &[Piece], corners: &[Whole], holes: &[Hom]) {
        for p in holes {
            self.empty.extend(Self::side(pieces, corners, p).ok().flatten());
        }
        let mut is_empty = vec![false; self.root.len()];
        for &side in &self.empty {
            is_empty[find(&mut self.root, side)] = true;
        }
        let sides = 0..self.root.len();
        self.is_exterior = sides.map(|side| is_empty[find(&mut self.root, side)]).collect();
    }

    /// Is a piece exterior on both sides?
    pub(super) fn is_outer(&self, piece: usize) -> bool {
        self.is_exterior[2 * piece] && self.is_exterior[2 * piece + 1]
    }

    /// Is a point in the exterior, and on no piece?
    pub(super) fn holds_outside(&self, pieces: &[Piece], corners: &[Whole], p: &Hom) -> bool {
        match Self::side(pieces, corners, p) {
            Ok(side) => side.is_none_or(|side| self.is_exterior[side]),
            Err(()) => false,
        }
    }
}

fn minus(p: &Whole, q: &Whole) -> Whole {
    [0, 1, 2].map(|k| p[k] - q[k])
}

fn cross(p: &[BigInt; 3], q: &[BigInt; 3]) -> [BigInt; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &p[i] * &q[j] - &p[j] * &q[i])
}

fn dot(p: &[BigInt; 3], q: &[BigInt; 3]) -> BigInt {
    p.iter().zip(q).map(|(x, y)| x * y).sum()
}

/// The wings at an edge, counterclockwise around it from the first one.
fn around(group: &[Wing], pieces: &[Piece], corners: &[Whole]) -> Vec<Wing> {
    let [a, b] = group[0].0.map(|v| &corners[v as usize]);
    let axis = minus(b, a).map(BigInt::from);
    // The direction into the piece is to the left of its edge.
    let into = |&(_, piece, along): &Wing| {
        let left = cross(&pieces[piece].normal.map(BigInt::from), &axis);
        if along { left } else { left.map(|c| -c) }
    };
    let mut list: Vec<([BigInt; 3], Wing)> = group.iter().map(|wing| (into(wing), *wing)).collect();
    let first = list[0].0.clone();
    let turn = |p: &[BigInt; 3], q: &[BigInt; 3]| dot(&cross(p, q), &axis).sign();
    // Less than half a turn from the first one, exactly half, or more.
    let half = |d: &[BigInt; 3]| match turn(&first, d) {
        Sign::Plus => 1,
        Sign::Minus => 3,
        Sign::NoSign => 2 * u8::from(dot(&first, d).sign() == Sign::Minus),
    };
    list.sort_by(|(p, _), (q, _)| {
        half(p).cmp(&half(q)).then_with(|| match turn(p, q) {
            Sign::Plus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Minus => Ordering::Greater,
        })
    });
    list.into_iter().map(|(_, wing)| wing).collect()
}

/// The next of a sequence of numbers that looks random: a multiplicative congruence.
fn random(state: &mut u64) -> i128 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    i128::from(*state >> 44)
}

/// A point outside the box of all corners, not the same at every try.
fn far(corners: &[Whole], attempt: u64) -> Whole {
    let mut state = attempt;
    let mut side = |k: usize| {
        let all = || corners.iter().map(|p| p[k]);
        let (low, high) = (all().min().unwrap_or(0), all().max().unwrap_or(0));
        let size = (high - low).max(1 << 20);
        // Below 2^20: one to two sizes away.
        let away = size + (size >> 20) * random(&mut state);
        if random(&mut state) & 1 == 0 { high + away } else { low - away }
    };
    [side(0), side(1), side(2)]
}

/// A point inside a piece, not the same at every try: on a line across it, between the first two
/// crossings.
fn inner_point(piece: &Piece, corners: &[Whole], attempt: u64) -> Option<Hom> {
    let mut state = attempt.wrapping_add(1 << 32);
    let [x, y] = piece.axes;
    let at = |v: u32| &corners[v as usize];
    let slanted: Vec<[u32; 2]> =
        piece.rim.iter().copied().filter(|&[a, b]| at(a)[y] != at(b)[y]).collect();
    let [a, b] = *slanted.get(random(&mut state) as usize % slanted.len().max(1))?;
    // The level is between the ends of an edge, over 2^20.
    let (w, part) = (BigInt::from(1 << 20), random(&mut state));
    let level = &w * at(a)[y] + BigInt::from(at(b)[y] - at(a)[y]) * part;
    let mut crossings: Vec<[BigInt; 2]> = Vec::new();
    for [a, b] in slanted {
        let (a, b) = if at(a)[y] < at(b)[y] { (at(a), at(b)) } else { (at(b), at(a)) };
        if &w * a[y] <= level && level < &w * b[y] {
            // Over w times the height of the edge.
            let height = BigInt::from(b[y] - a[y]);
            let along = BigInt::from(b[x] - a[x]) * (&level - &w * a[y]);
            crossings.push([&w * &height * a[x] + along, &w * height]);
        }
    }
    crossings.sort_by(|p, q| (&p[0] * &q[1]).cmp(&(&q[0] * &p[1])));
    let [p, q, ..] = &crossings[..] else { return None };
    // Half-way; then up to the plane.
    let (u, scale): (BigInt, BigInt) = (&p[0] * &q[1] + &q[0] * &p[1], 2 * &p[1] * &q[1]);
    // The scale is a multiple of w.
    let v: BigInt = &level * &scale / &w;
    let axis = 3 - x - y;
    let n = piece.normal;
    let height = dot(&n.map(BigInt::from), &at(piece.origin).map(BigInt::from)) * &scale;
    let third = height - &u * n[x] - &v * n[y];
    let mut point = Hom { x: [0, 1, 2].map(|_| BigInt::ZERO), w: scale * n[axis] };
    point.x[x] = u * n[axis];
    point.x[y] = v * n[axis];
    point.x[axis] = third;
    Some(point)
}
