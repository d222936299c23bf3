//! Where vertices live, and points that are rounded there: see [`ltbw_domain::straight`].

pub(crate) use ltbw_domain::straight::{Grid, Line, Plane, UNIT, corner_point};
use ltbw_domain::straight::{LARGEST, power_below};
use ltbw_exact::Point;

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

/// A vertex.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Corner {
    /// Its coordinates.
    pub point: Point,
    /// Where it lives.
    pub carrier: Carrier,
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
