//! The points that are proposed for what is to be split, by values.

use super::choice::{BoundaryItem, Corner};
use super::complex::Complex;
use crate::complex::carrier::Carrier;
use crate::complex::measure::Shape;
use crate::mesh::key::sorted;
use crate::mesh::limit::Limit;
use crate::mesh::state::FACE;
use crate::rules::aim::Aim;
use ltbw_exact::Point;

/// The part of the largest volume that tetrahedra have on average: that of the paper's problems.
const USUAL_VOLUME: f64 = 0.55;

impl Complex<'_> {
    /// The point that splits a tetrahedron, at the given attempt.
    pub fn aim_at_tet(&self, corners: [Point; 4], attempt: usize) -> Aim {
        let corners = sorted(corners);
        let [a, b, c, d] = &corners;
        let shape = Shape::of([a, b, c, d]);
        self.aims().tet(shape.radius(), shape.circumcentre(d), attempt)
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

    /// The edges that splitting a tetrahedron of a region may lead to.
    pub fn limit_of_tet(&self, corners: [Point; 4], region: u32) -> Limit {
        let corners = sorted(corners);
        let [a, b, c, d] = &corners;
        let all = [a, b, c, d];
        self.bounds().limit_in(all, region, &Shape::of(all), self.angles())
    }

    /// The point that splits a boundary item, at the given attempt.
    pub fn aim_at_item(&self, item: &BoundaryItem, attempt: usize) -> Aim {
        if let [a, b] = item.corners() {
            return self.aims().subsegment(item.of(), [*a, *b], attempt);
        }
        self.aims().subface(item.of(), item.points(), attempt)
    }

    /// The sides of a tetrahedron that are on the boundary, the first one by coordinates first.
    /// `labels` tells its region and that beyond the face opposite a slot, if it is known.
    pub fn sides_of(
        &self,
        tet: [Corner; 4],
        labels: impl Fn(usize) -> Option<[u32; 2]>,
    ) -> Vec<BoundaryItem> {
        let side = |slot: usize| self.side_of(&tet, slot, || labels(slot));
        let mut sides: Vec<BoundaryItem> = (0..4).filter_map(side).collect();
        sides.sort_by_cached_key(BoundaryItem::place);
        sides
    }

    /// The subface opposite a slot of a tetrahedron, which is positively oriented, if there is one;
    /// `labels` tells the region of the tetrahedron and that beyond, if it is known.
    pub fn side_of(
        &self,
        tet: &[Corner; 4],
        slot: usize,
        labels: impl FnOnce() -> Option<[u32; 2]>,
    ) -> Option<BoundaryItem> {
        let face = FACE[slot].map(|k| tet[k]);
        if face.iter().any(|corner| corner.carrier == Carrier::Free) {
            return None;
        }
        let of = self.facet(face).or_else(|| self.patch(face, slot, labels))?;
        Some(BoundaryItem::new(&face, of))
    }
}
