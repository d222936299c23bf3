//! Aims: the points that are proposed for what is to be split, one attempt after the other.
//!
//! The ideal place is the middle of a subsegment, the centre of a subface's circle or of a
//! tetrahedron's sphere. Vertices are on a lattice, or on what they split: the first aim may be off
//! by a part of the radius, so that its coordinates are short, the second by a step.

use crate::complex::angles::{direction, is_sharp};
use crate::complex::carrier::{Carrier, Corner, Line, UNIT, free_point, within_box};
use crate::complex::measure::circumcircle;
use crate::complex::plc::Plc;
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;

/// A point may be this part of the radius away from the ideal one.
pub(crate) const TOLERANCE: f64 = 1.0 / 1000.0;

/// The most aims for one thing.
pub(crate) const ATTEMPTS: usize = 2;

/// The next point to propose for something.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// This one. One that may not be inserted shows only what is on the way there.
    At {
        /// The point.
        point: Point,
        /// Where it lives.
        carrier: Carrier,
        /// May it be inserted?
        may: bool,
    },
    /// None at this attempt.
    Skip,
    /// No attempt is left.
    Exhausted,
    /// It is too small to be split.
    Refused,
}

/// The circumcircle of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circle {
    pub(crate) centre: Point,
    /// The square of its radius.
    pub(crate) square: f64,
}

impl Circle {
    /// The circle through three corners, whose order its rounding depends on: callers whose mesh is
    /// a function of places give them sorted.
    pub(crate) fn of([a, b, c]: &[Point; 3]) -> Self {
        let (centre, square) = circumcircle(a, b, c);
        Self { centre, square }
    }
}

/// The ground of aims, beside the corners of what is to be split.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aims<'p> {
    pub(crate) plc: &'p Plc,
    /// The least distance between a new vertex and the ends of what it splits, and the least radius
    /// that is split.
    pub(crate) floor: f64,
}

/// The distance that the aim of an attempt may be off, where the radius is this.
fn tolerance(radius: f64, attempt: usize) -> Option<f64> {
    let all: [f64; ATTEMPTS] = [radius * TOLERANCE, 1.0];
    all.get(attempt).copied()
}

/// The aim of an attempt for a tetrahedron with this circumradius and circumcentre, whatever its
/// size. The centre may be outside the box, where no point can be: the way there still counts.
pub(crate) fn at_centre(radius: f64, centre: Option<Point>, attempt: usize) -> Aim {
    let (Some(tolerance), Some(centre)) = (tolerance(radius, attempt), centre) else {
        return Aim::Exhausted;
    };
    let proposed = free_point(&centre, tolerance);
    let (point, may) = (proposed.unwrap_or(centre), proposed.is_some());
    Aim::At { point, carrier: Carrier::Free, may }
}

impl Aims<'_> {
    /// The aim for a tetrahedron with this circumradius and circumcentre.
    pub(crate) fn tet(&self, radius: f64, centre: Option<Point>, attempt: usize) -> Aim {
        match self.is_short(radius) {
            true => Aim::Refused,
            false => at_centre(radius, centre, attempt),
        }
    }

    /// Is a tetrahedron with this circumradius too small to be split? One without a circumradius
    /// that is a number is not: its sides may be split.
    pub(crate) fn is_short(&self, radius: f64) -> bool {
        radius < self.floor
    }

    /// Is a squared length below the floor?
    pub(crate) fn is_below(&self, square: f64) -> bool {
        square < self.floor * self.floor
    }

    /// The aim for a subsegment of segment `s`, given by its ends.
    pub(crate) fn subsegment(&self, s: u32, ends: [Corner; 2], attempt: usize) -> Aim {
        if attempt > 0 {
            return Aim::Exhausted;
        }
        let Some(t) = self.plc.split_parameter(ends.map(|end| end.carrier), s) else {
            return Aim::Refused;
        };
        let point = self.plc.segments[s as usize].line.point(t);
        let is_near = |end: Corner| self.is_below(distance2(&end.point, &point));
        match ends.into_iter().any(is_near) {
            true => Aim::Refused,
            false => Aim::At { point, carrier: Carrier::Segment(s, t), may: true },
        }
    }

    /// The aim for a subface of facet `f`.
    pub(crate) fn subface(&self, f: u32, corners: [Point; 3], attempt: usize) -> Aim {
        self.triangle(f, corners, Circle::of(&corners), attempt)
    }

    /// The aim for a triangle on facet `f`, or for one that it lacks, with this circle.
    pub(crate) fn triangle(
        &self,
        f: u32,
        corners: [Point; 3],
        circle: Circle,
        attempt: usize,
    ) -> Aim {
        let Circle { centre, square } = circle;
        if self.is_below(square) {
            return Aim::Refused;
        }
        // A centre outside the box: a point on the way there takes its place.
        let middle = [0, 1, 2].map(|k| corners.iter().map(|c| c[k] / 3.0).sum());
        let target = within_box(&middle, &centre);
        let square = if target == centre { square } else { distance2(&middle, &target) };
        let Some(tolerance) = tolerance(square.sqrt(), attempt) else { return Aim::Exhausted };
        match self.plc.place_on(f, &target, tolerance) {
            Some((point, may)) => Aim::At { point, carrier: Carrier::Facet(f), may },
            None => Aim::Skip,
        }
    }
}

impl Plc {
    /// A point near `target` on facet `f`, and `true`; or, if a patch has no polygon there, the
    /// place itself, where no point may be inserted.
    pub(crate) fn place_on(&self, f: u32, target: &Point, tolerance: f64) -> Option<(Point, bool)> {
        let facet = &self.facets[f as usize];
        let Some(patch) = &facet.patch else {
            return facet.plane.near(target, tolerance).map(|p| (p, true));
        };
        let on = patch.place(target, tolerance).map(|p| (p, true));
        on.or_else(|| free_point(target, 1.0).map(|p| (p, false)))
    }

    /// The parameter at which a subsegment of segment `s` with ends on these carriers is split: its
    /// middle, or, at a corner where another segment leaves at a small angle, a distance from it
    /// that is a power of two, so that the points of both are equally far from the corner. `None`
    /// if it is too short.
    pub(crate) fn split_parameter(&self, ends: [Carrier; 2], s: u32) -> Option<i64> {
        let [mut low, mut high] = ends.map(|end| self.parameter(end, s));
        let sharp = ends.map(|end| self.is_sharp(end, s));
        let flip = low > high;
        if flip {
            std::mem::swap(&mut low, &mut high);
        }
        let (sharp_low, sharp_high) =
            if flip { (sharp[1], sharp[0]) } else { (sharp[0], sharp[1]) };
        if sharp_low == sharp_high {
            return Line::middle(low, high);
        }
        let step_length = self.segments[s as usize].line.step_length();
        let length = (high - low) as f64 * step_length;
        // The power of two between a third and two thirds of the length.
        let third = length / 3.0;
        let mut shell = f64::from_bits(third.to_bits() & 0x7ff0_0000_0000_0000);
        while shell < third {
            shell *= 2.0;
        }
        let steps = shell / step_length;
        let t = if sharp_low { low as f64 + steps } else { high as f64 - steps };
        Line::near(t, 1.0, low, high)
    }

    /// The parameter of a vertex on segment `s`, on which it lies.
    pub(crate) fn parameter(&self, carrier: Carrier, s: u32) -> i64 {
        match carrier {
            Carrier::Segment(_, t) => t,
            Carrier::Corner(c) if c == self.segments[s as usize].ends[1] => UNIT,
            _ => 0,
        }
    }

    /// Does a vertex of segment `s` lie at a corner where another segment leaves at less than 60°?
    fn is_sharp(&self, carrier: Carrier, s: u32) -> bool {
        let Carrier::Corner(c) = carrier else { return false };
        let mine = direction(self, s, c);
        let others = self.segments_at[c as usize].iter().filter(|&&other| other != s);
        others.into_iter().any(|&other| is_sharp(&mine, &direction(self, other, c)))
    }
}
