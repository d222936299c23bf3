//! Points on segments and facets, with whole parameters: each lies exactly on its carrier.
//!
//! Everything is in fine steps: a corner at grid position A is at A·2^27; a point of a segment from
//! A to B at A·2^27 + t·(B - A) with 0 <= t <= 2^27; a point of a facet with the corners O, A, B at
//! O·2^27 + i·(A - O) + j·(B - O) with any integers i, j. Grid positions are at most 2^26, so that
//! all coordinates are integers of at most 2^53, exact as `f64`.
//!
//! A rounded ideal point will do, so parameters get as few bits as the tolerance allows: points
//! that are mirror images then round alike and stay mirror images.

use ltbw_domain::lattice::{INPUT_BITS, PARAMETER_BITS};
use ltbw_domain::vector::{cross, dot};
use ltbw_exact::Point;

/// Fine steps in a step of the grid, and the largest parameter of a segment.
pub(crate) const UNIT: i64 = 1 << PARAMETER_BITS;

/// Largest coordinate in fine steps.
const LARGEST: i128 = 1 << (INPUT_BITS + PARAMETER_BITS);

/// The position of an input vertex, in steps of the grid.
pub(crate) type Grid = [i64; 3];

/// Where a vertex lives.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Carrier {
    /// It is an input vertex.
    Corner(u32),
    /// On a segment, at a parameter.
    Segment(u32, i64),
    /// On a facet.
    Facet(u32),
    /// Inside a region.
    Free,
}

impl Carrier {
    /// Are two new points of the boundary on one segment, or in one facet?
    pub fn is_with(self, other: Self) -> bool {
        match (self, other) {
            (Self::Segment(s, _), Self::Segment(r, _)) => s == r,
            (Self::Facet(f), Self::Facet(g)) => f == g,
            _ => false,
        }
    }
}

/// A point at which a segment is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Cut {
    pub(crate) segment: u32,
    pub(crate) parameter: i64,
}

impl Cut {
    pub(crate) fn carrier(self) -> Carrier {
        Carrier::Segment(self.segment, self.parameter)
    }
}

/// A corner in fine steps.
pub(crate) fn corner_point(a: &Grid) -> Point {
    a.map(|c| (c * UNIT) as f64)
}

/// The power of two at or below `x`, at least 1; for parameters, which are below 2^62.
fn power_below(x: f64) -> i64 {
    if x < 1.0 {
        return 1;
    }
    let exponent = ((x.to_bits() >> 52) as i64 - 1023).min(40);
    1 << exponent
}

/// `x` rounded to a multiple of `quantum`; ties away from zero, so that mirror images round alike.
fn round_to(x: f64, quantum: i64) -> i64 {
    (x / quantum as f64).round() as i64 * quantum
}

/// The line of a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) from: Grid,
    pub(crate) to: Grid,
}

impl Line {
    /// The point at a parameter between 0 and [`UNIT`].
    pub(crate) fn point(&self, t: i64) -> Point {
        // At most 2^26 · 2^27 at the ends, and the point lies between them.
        [0, 1, 2].map(|k| {
            let d = i128::from(self.to[k] - self.from[k]);
            (i128::from(self.from[k]) * i128::from(UNIT) + i128::from(t) * d) as f64
        })
    }

    /// The length of one step of the parameter, in fine steps.
    pub(crate) fn step_length(&self) -> f64 {
        let d = [0, 1, 2].map(|k| (self.to[k] - self.from[k]) as f64);
        dot(&d, &d).sqrt()
    }

    /// A parameter of few bits strictly between `low` and `high`, near their middle; `None` if
    /// there is none.
    pub(crate) fn middle(low: i64, high: i64) -> Option<i64> {
        let near = (high - low) as f64 / 512.0;
        Self::near((low + high) as f64 / 2.0, near, low, high)
    }

    /// A parameter of few bits strictly between `low` and `high`, within `tolerance` (or one
    /// step) of `t`.
    pub(crate) fn near(t: f64, tolerance: f64, low: i64, high: i64) -> Option<i64> {
        let t = round_to(t, power_below(tolerance));
        let t = t.clamp(low + 1, high - 1);
        (low < t && t < high).then_some(t)
    }
}

/// The plane of a facet: three of its corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    origin: Grid,
    u: Grid,
    v: Grid,
    /// u·u, u·v, v·v and u·u v·v - (u·v)², rounded.
    gram: [f64; 4],
}

impl Plane {
    /// The plane through three positions that are not collinear.
    pub(crate) fn through(origin: Grid, a: Grid, b: Grid) -> Self {
        let u = [0, 1, 2].map(|k| a[k] - origin[k]);
        let v = [0, 1, 2].map(|k| b[k] - origin[k]);
        let (x, y) = (u.map(|c| c as f64), v.map(|c| c as f64));
        let n = cross(&x, &y);
        Self { origin, u, v, gram: [dot(&x, &x), dot(&x, &y), dot(&y, &y), dot(&n, &n)] }
    }

    /// A vector normal to the plane, rounded: u × v in steps of the grid.
    pub(crate) fn normal(&self) -> Point {
        cross(&self.u.map(|c| c as f64), &self.v.map(|c| c as f64))
    }

    /// The point of few bits on the plane's lattice within about `tolerance` (or one step of the
    /// lattice) of the projection of `target`, all in fine steps; `None` outside the box.
    pub(crate) fn near(&self, target: &Point, tolerance: f64) -> Option<Point> {
        let w: Point = [0, 1, 2].map(|k| target[k] - (self.origin[k] * UNIT) as f64);
        let [uu, uv, vv, gram] = self.gram;
        let (wu, wv) = (dot(&w, &self.u.map(|c| c as f64)), dot(&w, &self.v.map(|c| c as f64)));
        let i = round_to((vv * wu - uv * wv) / gram, power_below(tolerance / uu.sqrt()));
        let j = round_to((uu * wv - uv * wu) / gram, power_below(tolerance / vv.sqrt()));
        self.point(i, j)
    }

    /// The point of few bits near the one of the plane that `target` is projected to along an axis,
    /// which is not in the plane.
    pub(crate) fn near_along(&self, axis: usize, target: &Point, tolerance: f64) -> Option<Point> {
        let flat = |g: &Grid| [g[(axis + 1) % 3] as f64, g[(axis + 2) % 3] as f64];
        let (o, u, v) = (flat(&self.origin), flat(&self.u), flat(&self.v));
        let w = [0, 1].map(|k| target[(axis + 1 + k) % 3] - o[k] * UNIT as f64);
        let turn = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let [uu, _, vv, _] = self.gram;
        let i = round_to(turn(w, v) / turn(u, v), power_below(tolerance / uu.sqrt()));
        let j = round_to(turn(u, w) / turn(u, v), power_below(tolerance / vv.sqrt()));
        self.point(i, j)
    }

    /// The point with parameters i and j; `None` outside the box.
    pub(crate) fn point(&self, i: i64, j: i64) -> Option<Point> {
        let mut p = [0.0; 3];
        for (k, coordinate) in p.iter_mut().enumerate() {
            // Differences are at most 2^27, parameters of i64: below 2^92.
            let c = i128::from(self.origin[k]) * i128::from(UNIT)
                + i128::from(i) * i128::from(self.u[k])
                + i128::from(j) * i128::from(self.v[k]);
            if c.abs() > LARGEST {
                return None;
            }
            *coordinate = c as f64;
        }
        Some(p)
    }
}

/// The point of few bits within about `tolerance` (or one fine step) of `target`; `None` outside
/// the box.
pub(crate) fn free_point(target: &Point, tolerance: f64) -> Option<Point> {
    let quantum = power_below(tolerance);
    let p = target.map(|c| (c / quantum as f64).round() * quantum as f64 + 0.0);
    p.iter().all(|c| c.abs() <= LARGEST as f64).then_some(p)
}

/// The point on the way from `from` to `target` that is within the box, with a margin, and nearest
/// to `target`; `target` itself if that is in the box.
pub(crate) fn within_box(from: &Point, target: &Point) -> Point {
    let largest = LARGEST as f64;
    let part = |k: usize| {
        let way = target[k] - from[k];
        let end = (0.99 * largest).copysign(way);
        if target[k].abs() <= largest { 1.0 } else { ((end - from[k]) / way).max(0.0) }
    };
    let part = (0..3).map(part).fold(1.0, f64::min);
    let inside = [0, 1, 2].map(|k| from[k] + part * (target[k] - from[k]));
    if part < 1.0 && inside.iter().all(|c| c.is_finite()) { inside } else { *target }
}
