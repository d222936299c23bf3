//! Points on segments and facets, with whole parameters: each lies exactly on its carrier.
//!
//! Everything is in fine steps: a corner at grid position A is at A·2^27; a point of a segment from
//! A to B at A·2^27 + t·(B - A) with 0 <= t <= 2^27; a point of a facet with the corners O, A, B at
//! O·2^27 + i·(A - O) + j·(B - O) with any integers i, j. Grid positions are at most 2^26, so that
//! all coordinates are integers of at most 2^53, exact as `f64`.
//!
//! A rounded ideal point will do, so parameters get as few bits as the tolerance allows: points
//! that are mirror images then round alike and stay mirror images.

use crate::lattice::{INPUT_BITS, PARAMETER_BITS};
use crate::vector::{cross, dot};
use ltbw_exact::Point;

/// Fine steps in a step of the grid, and the largest parameter of a segment.
pub const UNIT: i64 = 1 << PARAMETER_BITS;

/// Largest coordinate in fine steps.
pub const LARGEST: i128 = 1 << (INPUT_BITS + PARAMETER_BITS);

/// The position of an input vertex, in steps of the grid.
pub type Grid = [i64; 3];

/// A corner in fine steps.
pub fn corner_point(a: &Grid) -> Point {
    a.map(|c| (c * UNIT) as f64)
}

/// The power of two at or below `x`, at least 1; for parameters, which are below 2^62.
pub fn power_below(x: f64) -> i64 {
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
pub struct Line {
    /// One end.
    pub from: Grid,
    /// The other one.
    pub to: Grid,
}

impl Line {
    /// The point at a parameter between 0 and [`UNIT`].
    pub fn point(&self, t: i64) -> Point {
        // At most 2^26 · 2^27 at the ends, and the point lies between them.
        [0, 1, 2].map(|k| {
            let d = i128::from(self.to[k] - self.from[k]);
            (i128::from(self.from[k]) * i128::from(UNIT) + i128::from(t) * d) as f64
        })
    }

    /// The parameter of a point, in fine steps, if it lies on the line, between the ends.
    pub fn parameter(&self, p: &Point) -> Option<i64> {
        let along = [0, 1, 2].map(|k| self.to[k] - self.from[k]);
        let axis = (0..3).max_by_key(|&k| along[k].abs())?;
        // Whole and below 2^55.
        let way = p[axis] as i64 - self.from[axis] * UNIT;
        let t = way.checked_div(along[axis])?;
        (0 < t && t < UNIT && self.point(t) == *p).then_some(t)
    }

    /// The length of one step of the parameter, in fine steps.
    pub fn step_length(&self) -> f64 {
        let d = [0, 1, 2].map(|k| (self.to[k] - self.from[k]) as f64);
        dot(&d, &d).sqrt()
    }

    /// A parameter of few bits strictly between `low` and `high`, near their middle; `None` if
    /// there is none.
    pub fn middle(low: i64, high: i64) -> Option<i64> {
        let near = (high - low) as f64 / 512.0;
        Self::near((low + high) as f64 / 2.0, near, low, high)
    }

    /// A parameter of few bits strictly between `low` and `high`, within `tolerance` (or one
    /// step) of `t`.
    pub fn near(t: f64, tolerance: f64, low: i64, high: i64) -> Option<i64> {
        let t = round_to(t, power_below(tolerance));
        let t = t.clamp(low + 1, high - 1);
        (low < t && t < high).then_some(t)
    }
}

/// The plane of a facet: three of its corners.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    origin: Grid,
    u: Grid,
    v: Grid,
    /// u·u, u·v, v·v and u·u v·v - (u·v)², rounded.
    gram: [f64; 4],
}

impl Plane {
    /// The plane through three positions that are not collinear.
    pub fn through(origin: Grid, a: Grid, b: Grid) -> Self {
        let u = [0, 1, 2].map(|k| a[k] - origin[k]);
        let v = [0, 1, 2].map(|k| b[k] - origin[k]);
        let (x, y) = (u.map(|c| c as f64), v.map(|c| c as f64));
        let n = cross(&x, &y);
        Self { origin, u, v, gram: [dot(&x, &x), dot(&x, &y), dot(&y, &y), dot(&n, &n)] }
    }

    /// A vector normal to the plane, rounded: u × v in steps of the grid.
    pub fn normal(&self) -> Point {
        cross(&self.u.map(|c| c as f64), &self.v.map(|c| c as f64))
    }

    /// The point of few bits on the plane's lattice within about `tolerance` (or one step of the
    /// lattice) of the projection of `target`, all in fine steps; `None` outside the box.
    pub fn near(&self, target: &Point, tolerance: f64) -> Option<Point> {
        let w: Point = [0, 1, 2].map(|k| target[k] - (self.origin[k] * UNIT) as f64);
        let [uu, uv, vv, gram] = self.gram;
        let (wu, wv) = (dot(&w, &self.u.map(|c| c as f64)), dot(&w, &self.v.map(|c| c as f64)));
        let i = round_to((vv * wu - uv * wv) / gram, power_below(tolerance / uu.sqrt()));
        let j = round_to((uu * wv - uv * wu) / gram, power_below(tolerance / vv.sqrt()));
        self.point(i, j)
    }

    /// The point of few bits near the one of the plane that `target` is projected to along an axis,
    /// which is not in the plane.
    pub fn near_along(&self, axis: usize, target: &Point, tolerance: f64) -> Option<Point> {
        let flat = |g: &Grid| [g[(axis + 1) % 3] as f64, g[(axis + 2) % 3] as f64];
        let (o, u, v) = (flat(&self.origin), flat(&self.u), flat(&self.v));
        let w = [0, 1].map(|k| target[(axis + 1 + k) % 3] - o[k] * UNIT as f64);
        let turn = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let [uu, _, vv, _] = self.gram;
        let i = round_to(turn(w, v) / turn(u, v), power_below(tolerance / uu.sqrt()));
        let j = round_to(turn(u, w) / turn(u, v), power_below(tolerance / vv.sqrt()));
        self.point(i, j)
    }

    /// Is a point, in fine steps, exactly in the plane?
    pub fn holds(&self, p: &Point) -> bool {
        let [u, v] = [self.u, self.v].map(|w| w.map(i128::from));
        let w = [0, 1, 2].map(|k| p[k] as i128 - i128::from(self.origin[k]) * i128::from(UNIT));
        // Entries of the normal are below 2^56, those of the way below 2^55.
        let n = |k: usize| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        (0..3).map(|k| n(k) * w[k]).sum::<i128>() == 0
    }

    /// The point with parameters i and j; `None` outside the box.
    pub fn point(&self, i: i64, j: i64) -> Option<Point> {
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
