//! The points that are proposed for what is to be split, and the way to them, by values.

use super::carrier::{Carrier, free_point};
use super::choice::{Aim, BoundaryItem, Corner};
use super::complex::{Complex, TOLERANCES};
use super::key::sorted;
use super::measure::Shape;
use super::state::FACE;
use super::walk::{exit, middle};
use ltbw_exact::Point;

/// The part of the largest volume that tetrahedra have on average: that of the paper's problems.
const USUAL_VOLUME: f64 = 0.55;

impl Complex<'_> {
    /// The point that splits a tetrahedron, at the given attempt.
    pub fn aim_at_tet(&self, corners: [Point; 4], attempt: usize) -> Aim {
        let corners = sorted(corners);
        let [a, b, c, d] = &corners;
        let shape = Shape::of([a, b, c, d]);
        let radius = shape.radius();
        if radius < self.floor() {
            return Aim::Refused;
        }
        let (Some(part), Some(centre)) = (TOLERANCES.get(attempt), shape.circumcentre(d)) else {
            return Aim::Exhausted;
        };
        let proposed = free_point(&centre, part.map_or(1.0, |part| part * radius));
        let (point, may) = (proposed.unwrap_or(centre), proposed.is_some());
        Aim::At { point, carrier: Carrier::Free, may }
    }

    /// About the number of tetrahedra that a tetrahedron of a region will be split into: its volume
    /// over what theirs are on average, or one.
    pub fn predicted(&self, corners: [Point; 4], region: u32) -> f64 {
        if region == 0 {
            return 0.0;
        }
        let [a, b, c, d] = &corners;
        let shape = Shape::of([a, b, c, d]);
        let bound = self.bounds().volume_at([a, b, c, d], region);
        (shape.det.abs() / 6.0 / (USUAL_VOLUME * bound)).max(1.0)
    }

    /// The shortest edge that splitting a tetrahedron of a region may lead to.
    pub fn limit_of_tet(&self, corners: [Point; 4], region: u32) -> f64 {
        let corners = sorted(corners);
        let [a, b, c, d] = &corners;
        let all = [a, b, c, d];
        self.bounds().limit_in(all, region, &Shape::of(all)).least
    }

    /// The point that splits a boundary item, at the given attempt.
    pub fn aim_at_item(&self, item: &BoundaryItem, attempt: usize) -> Aim {
        if let [a, b] = item.corners() {
            let ends = [a, b].map(|end| (end.carrier, end.point));
            let place = (attempt == 0).then(|| self.point_of_segment(item.of(), ends)).flatten();
            return place.map_or(Aim::Refused, |(point, carrier)| Aim::At {
                point,
                carrier,
                may: true,
            });
        }
        let points = item.points();
        if attempt >= TOLERANCES.len() || !self.is_large(&points) {
            return Aim::Refused;
        }
        match self.point_of_subface(item.of(), points, attempt) {
            Some((point, carrier)) => Aim::At { point, carrier, may: true },
            None => Aim::Skip,
        }
    }

    /// The sides of a tetrahedron that are on the boundary, the first one by coordinates first.
    pub fn sides_of(&self, tet: [Corner; 4]) -> Vec<BoundaryItem> {
        let mut sides: Vec<BoundaryItem> = Vec::new();
        for face in FACE {
            sides.extend(self.item_at(face.map(|slot| tet[slot])));
        }
        sides.sort_by_cached_key(BoundaryItem::place);
        sides
    }

    /// The subface with these corners, if they are those of one.
    pub fn item_at(&self, corners: [Corner; 3]) -> Option<BoundaryItem> {
        let of = self.facet(corners.map(|corner| (corner.carrier, corner.point)))?;
        Some(BoundaryItem::new(&corners, of))
    }
}

/// The face through which the straight way from the middle of a tetrahedron to `p` leaves another
/// one with these corners, by the slot opposite; `None` if that holds `p`. `entry`: the slot of the
/// face that it came in by. All points are in fine steps.
#[doc(hidden)]
pub fn way_out(
    corners: [Point; 4],
    entry: Option<usize>,
    from: &Point,
    p: &Point,
) -> Option<usize> {
    exit(&corners, entry.unwrap_or(4), from, p)
}

/// The middle of a tetrahedron, where a way begins.
#[doc(hidden)]
pub fn way_start(corners: [Point; 4]) -> Point {
    middle(corners)
}
