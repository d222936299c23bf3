//! Planes between things, and on which side of one a point is, exactly.

use crate::mesh::Point;
use crate::predicates::{Tally, orient3d};

/// A plane.
#[derive(Debug, Clone, Copy)]
pub(super) enum Plane<'a> {
    /// All points with this coordinate on this axis.
    Axis(usize, f64),
    /// Through three points. If they are on one line, every point is on it.
    Through([&'a Point; 3]),
}

impl Plane<'_> {
    /// The side of a point: 1, -1, or 0 on the plane.
    pub(super) fn side(&self, p: &Point, tally: &mut Tally) -> i8 {
        match *self {
            Self::Axis(k, at) => {
                tally.filter += 1;
                i8::from(p[k] > at) - i8::from(p[k] < at)
            }
            Self::Through([a, b, c]) => orient3d([a, b, c, p], tally),
        }
    }
}
