//! Points of one facet across from those of another one: turned about a segment, or straight.
//!
//! Facets at a small dihedral angle θ are nearer to each other than their subfaces are wide: what
//! splits one takes the other's subfaces out of the mesh. If that is split at the place that lies
//! opposite, the point p' across is in none of the balls of its new subfaces: it is farther from
//! the centre m of each than the point p of its own facet at the same place and the same distance d
//! from the segment, |p' - m|² = |p - m|² + 2 d e (1 - cos θ), where m is at the distance e on the
//! facet's side of the segment. Any other place would make edges along the facet as short as those
//! across.

use crate::complex::carrier::{Carrier, corner_point};
use crate::complex::measure::circumcircle;
use crate::mesh::key::sorted;
use crate::mesh::state::{Place, State};
use ltbw_core::topology::VertexId;
use ltbw_domain::vector::{distance2, dot, minus};
use ltbw_exact::Point;

/// The part of the square of its radius up to which a point is inside a circle. The vertices of a
/// subface, which are on it but for rounding, may be opposite to points, too.
const INSIDE: f64 = 1.0 - 1e-3;

impl State {
    /// The place at which a subface of facet `f` that a joint step has lost is split: in its circle
    /// and opposite to a point of this step on a facet at a small dihedral angle with `f`. Only for
    /// tetrahedra that are too large.
    pub(crate) fn turned(&self, corners: [VertexId; 3], f: u32) -> Option<Place> {
        let journal = self.journal.as_ref()?;
        journal.limit?.along?;
        let [a, b, c] = sorted(corners.map(|v| self.at(v)));
        let (centre, square) = circumcircle(&a, &b, &c);
        let turned = |(p, carrier): &(Point, Carrier)| {
            if self.lies_on(*carrier, f) {
                return None;
            }
            let found = self.plc.facets_of(carrier).iter().find_map(|&g| self.turn_into(p, g, f));
            found.filter(|p| distance2(p, &centre) < INSIDE * square)
        };
        let target = journal.points.iter().rev().find_map(turned)?;
        self.place_at(f, &target, 1.0)
    }

    /// The place at which a subface of facet `f` that a joint step has lost is split, if that is to
    /// be opposite to the points of others: straight across from the last one in its ball.
    ///
    /// Where facets are side by side the points of one are then those of the next, and what one has
    /// for subfaces is in the mesh together with what the next has: a circle through three of its
    /// vertices that is empty in its own plane is the largest circle of its ball, which has a
    /// smaller one in the plane beside it.
    pub(crate) fn opposite(&self, corners: [VertexId; 3], f: u32) -> Option<Place> {
        let journal = self.journal.as_ref().filter(|journal| journal.is_opposite)?;
        let [a, b, c] = sorted(corners.map(|v| self.at(v)));
        let (centre, square) = circumcircle(&a, &b, &c);
        let is_across = |(p, carrier): &&(Point, Carrier)| {
            !self.lies_on(*carrier, f) && distance2(p, &centre) < INSIDE * square
        };
        let (target, _) = journal.points.iter().rev().find(is_across)?;
        self.place_at(f, target, 1.0)
    }

    /// A point of facet `g`, turned about the segment at which it meets facet `f` at a small angle
    /// into the plane of that one.
    fn turn_into(&self, p: &Point, g: u32, f: u32) -> Option<Point> {
        let hinge = self.angles.hinge(f, g)?.map(|c| corner_point(&self.plc.corners[c as usize]));
        turned_about(hinge, p, &self.plc.facets[f as usize].plane.normal())
    }
}

/// A point turned about a line, on which two points are given, into the plane with this normal that
/// has the line, the shorter way; `None` if it is on the line or straight above the plane.
fn turned_about([start, end]: [Point; 2], p: &Point, normal: &Point) -> Option<Point> {
    let along = minus(&end, &start);
    let arm = minus(p, &start);
    let part = dot(&arm, &along) / dot(&along, &along);
    let foot = [0, 1, 2].map(|k| start[k] + part * along[k]);
    let arm = minus(p, &foot);
    let off = dot(&arm, normal) / dot(normal, normal);
    let inner = [0, 1, 2].map(|k| arm[k] - off * normal[k]);
    let stretch = (dot(&arm, &arm) / dot(&inner, &inner)).sqrt();
    let turned = [0, 1, 2].map(|k| foot[k] + stretch * inner[k]);
    turned.iter().all(|c| c.is_finite()).then_some(turned)
}

#[cfg(test)]
mod tests {
    use super::turned_about;
    use ltbw_domain::vector::{distance2, dot};

    #[test]
    fn a_point_keeps_its_place_along_the_line_and_its_distance() {
        let hinge = [[4.0, -2.0, 8.0], [4.0, -2.0, 72.0]];
        for degrees in [-20.0_f64, -1.0, 0.5, 10.0] {
            // The plane turned by this angle from that of y = -2; the point is on this one.
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let normal = [-sine, cosine, 0.0];
            for p in [[20.0, -2.0, 40.0], [-30.0, -2.0, 90.0]] {
                let q = turned_about(hinge, &p, &normal).expect("a place");
                let across = [q[0] - 4.0, q[1] + 2.0, q[2] - 8.0];
                assert!(dot(&across, &normal).abs() < 1e-12, "{degrees}");
                assert!((q[2] - p[2]).abs() < 1e-12, "{degrees}");
                let foot = [4.0, -2.0, p[2]];
                assert!((distance2(&q, &foot) - distance2(&p, &foot)).abs() < 1e-9, "{degrees}");
                assert!((q[0] - 4.0) * (p[0] - 4.0) > 0.0, "the shorter way: {degrees}");
            }
        }
        assert_eq!(turned_about(hinge, &hinge[0], &[0.0, 1.0, 0.0]), None);
    }
}
