//! The crossings of a line segment with the triangles of a complex, in order, exactly.

use super::complex::{Complex, Piece, Shape};
use super::contact::sides_of;
use super::exact::Along;
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, orient3d};
use rstar::{AABB, RTree, SelectionFunction};

/// A crossing of a triangle.
#[derive(Debug, Clone)]
pub(super) struct Hit {
    /// The triangle.
    pub(super) triangle: u32,
    /// Is the near side the one to which its normal points?
    pub(super) from_front: bool,
    /// The place on the segment.
    pub(super) along: Along,
}

impl Hit {
    /// The side of the triangle that the segment comes from.
    pub(super) fn near(&self) -> u32 {
        2 * self.triangle + u32::from(!self.from_front)
    }

    /// The side that it leaves to.
    pub(super) fn far(&self) -> u32 {
        2 * self.triangle + u32::from(self.from_front)
    }
}

/// The segment meets an edge, or ends on a triangle: its crossings have no order. Another one,
/// slightly different, will do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Degenerate;

/// The crossings of the segment with all triangles, in the order from its first end.
pub(super) fn cast(
    complex: &Complex<'_>,
    index: &RTree<Piece>,
    from: &Point,
    to: &Point,
) -> Result<Vec<Hit>, Degenerate> {
    let mut hits = Vec::new();
    for piece in index.locate_with_selection_function(Near { from, to }) {
        let Shape::Triangle(t) = complex.shape(piece.number) else { continue };
        let corners = t.map(|v| &complex.points[v as usize]);
        let side = |p: &Point| orient3d(corners[0], corners[1], corners[2], p);
        let (near, far) = (side(from), side(to));
        if near == far && !near.is_zero() {
            continue;
        }
        let past = sides_of(t).map(|[a, b]| {
            orient3d(from, to, &complex.points[a as usize], &complex.points[b as usize])
        });
        if past.contains(&Sign::Positive) && past.contains(&Sign::Negative) {
            continue;
        }
        if near.is_zero() || far.is_zero() || past.contains(&Sign::Zero) {
            return Err(Degenerate);
        }
        let along = Along::new(from, to, corners);
        hits.push(Hit { triangle: piece.number, from_front: near.is_positive(), along });
    }
    hits.sort_by(|a, b| a.along.cmp(&b.along));
    Ok(hits)
}

/// Chooses the boxes that a segment may meet: all that it does meet, and few others.
struct Near<'a> {
    from: &'a Point,
    to: &'a Point,
}

impl Near<'_> {
    /// Does the segment meet the box? Axis by axis, in fractions of its length. Each fraction
    /// has a relative error of at most 4 · 2^-53; the slack is more than twice that.
    fn meets(&self, envelope: &AABB<Point>) -> bool {
        const SLACK: f64 = 1e-14;
        let (low, high) = (envelope.lower(), envelope.upper());
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for k in 0..3 {
            let step = self.to[k] - self.from[k];
            if step == 0.0 {
                if self.from[k] < low[k] || self.from[k] > high[k] {
                    return false;
                }
                continue;
            }
            let (a, b) = ((low[k] - self.from[k]) / step, (high[k] - self.from[k]) / step);
            let (a, b) = (a.min(b), a.max(b));
            enter = enter.max(a - SLACK * a.abs());
            leave = leave.min(b + SLACK * b.abs());
        }
        enter <= leave
    }
}

impl SelectionFunction<Piece> for Near<'_> {
    fn should_unpack_parent(&self, envelope: &AABB<Point>) -> bool {
        self.meets(envelope)
    }

    fn should_unpack_leaf(&self, leaf: &Piece) -> bool {
        self.meets(&rstar::RTreeObject::envelope(leaf))
    }
}
