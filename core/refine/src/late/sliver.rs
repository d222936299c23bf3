//! Slivers: tetrahedra with small dihedral angles, which bounds on their shape allow.
//!
//! When all bounds are met, a point is looked for whose cavity has the sliver and whose own
//! tetrahedra meet the bounds and have no such angle: inside, near the circumcentre, or on the
//! boundary beside it. So no sliver follows from another, and the number of tries is bounded. Where
//! none serves the sliver stays.

use super::star::Made;
use crate::complex::carrier::{Carrier, free_point};
use crate::complex::dihedral::{DihedralBound, sharpest};
use crate::complex::measure::Shape;
use crate::mesh::bounds::Bounds;
use crate::mesh::facet::Change;
use crate::mesh::item::Item;
use crate::mesh::key::sorted;
use crate::mesh::number::in_order;
use crate::mesh::state::{Place, State};
use crate::outcome::{Reason, Sliver};
use crate::queue::split::Refinement;
use crate::rules::aim::TOLERANCE;
use crate::rules::verdict::Judge;
use crate::rules::walk::Way;
use crate::thin::Thin;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_domain::quality::TetQuality;
use ltbw_exact::Point;

/// Points inside that are tried for a sliver, within a part of the circumradius of the
/// circumcentre: fewer of a small part, then more of a larger one.
pub(crate) const REGIONS: [(u32, f64); 2] = [(16, 0.5), (32, 0.9)];

/// A circumsphere.
pub(crate) struct Ball {
    pub(crate) centre: Point,
    pub(crate) radius: f64,
}

impl Refinement<'_> {
    /// The slivers that a point may serve, in the order of their coordinates: none in a collar,
    /// where the domain asks for small angles.
    pub(crate) fn slivers(&mut self) -> Vec<Thin> {
        let (state, thin) = (&self.state, &mut self.inserted.thin.tets);
        let Some(bounds) = &self.bounds else { return Vec::new() };
        if bounds.dihedral.is_none() {
            return Vec::new();
        }
        thin.retain(|&(t, v)| state.is_live(t, v));
        let is_open = |t: TetId, v| state.is_sliver(t, bounds) && !state.is_in_collar(v, bounds);
        let mut slivers: Vec<Thin> = thin.iter().copied().filter(|&(t, v)| is_open(t, v)).collect();
        slivers.sort_by_cached_key(|&(t, v)| state.place_of(Item::Tet(t, v)));
        slivers.dedup();
        debug_assert!(
            state.mesh.tet_ids().filter(|&t| is_open(t, state.vertices(t))).count()
                == slivers.len(),
            "all slivers are in the list"
        );
        slivers
    }
}

/// The terms on which a point is taken for a sliver.
pub(crate) struct Terms {
    /// Its tetrahedra have no smaller dihedral angle.
    pub(crate) dihedral: DihedralBound,
    /// They keep all bounds. Else those that do not are split by the rounds that follow.
    pub(crate) keeps_bounds: bool,
}

impl Judge<'_> {
    /// The sharpest angle among the tetrahedra that a point makes with these changes, as the square
    /// of its cosine; `None` if one is not as the terms ask for.
    pub(crate) fn sharpest_of_star(
        &self,
        place: &Place,
        changes: &[Change],
        bounds: &Bounds<'_>,
        terms: &Terms,
    ) -> Option<f64> {
        let &Terms { dihedral, keeps_bounds } = terms;
        let mut most = 0.0f64;
        for Made { corners, region } in self.closure.star(place, changes) {
            let own = corners.each_ref();
            if dihedral.is_missed(own) || keeps_bounds && bounds.are_over(own, region) {
                return None;
            }
            most = most.max(sharpest(sorted(corners).each_ref()));
        }
        Some(most)
    }
}

impl State {
    /// The slivers of a list that may have others, and has all, in the order of their numbers.
    pub(crate) fn slivers_among(&self, thin: Vec<Thin>, bounds: &Bounds<'_>) -> Vec<Sliver> {
        let is_left = |&(t, v): &Thin| self.is_live(t, v) && self.is_sliver(t, bounds);
        let mut left: Vec<Thin> = thin.into_iter().filter(is_left).collect();
        left.sort_by_cached_key(|&(t, _)| self.mesh.tet(t).map(in_order));
        left.dedup();
        let named = |v| Some(self.reason_near(v)).filter(|reason| *reason != Reason::Rounding);
        let near = |v| self.asks_for_shape(v, bounds).or_else(|| named(v));
        let sliver = |(tet, v)| Sliver { tet, angle: self.least_angle(v), near: near(v) };
        left.into_iter().map(sliver).collect()
    }

    /// The smallest dihedral angle of a tetrahedron in degrees, rounded in an order that is always
    /// the same.
    pub(crate) fn least_angle(&self, v: [VertexId; 4]) -> f64 {
        TetQuality::of(sorted(v.map(|v| self.at(v))).each_ref()).least_dihedral()
    }

    fn is_in_collar(&self, v: [VertexId; 4], bounds: &Bounds<'_>) -> bool {
        bounds.ratio.is_some_and(|bound| self.collar(v, bound.value()).is_some())
    }

    /// Is a tetrahedron in a region, and has it a dihedral angle below the bound?
    pub(crate) fn is_sliver(&self, t: TetId, bounds: &Bounds<'_>) -> bool {
        let Some(dihedral) = bounds.dihedral.filter(|_| self.marks.region(t) != 0) else {
            return false;
        };
        let v = self.vertices(t);
        dihedral.is_missed(v.map(|v| self.at(v)).each_ref())
    }

    /// The circumsphere of a tetrahedron, rounded in an order that is always the same.
    pub(crate) fn ball_of(&self, t: TetId) -> Option<Ball> {
        let corners = sorted(self.vertices(t).map(|v| self.at(v)));
        let [a, b, c, d] = &corners;
        let shape = Shape::of([a, b, c, d]);
        Some(Ball { centre: shape.circumcentre(d)?, radius: shape.radius() })
    }

    /// The places inside that are tried for a sliver, in their order, each with the way there.
    pub(crate) fn places_for(&self, t: TetId, ball: &Ball) -> impl Iterator<Item = Place> {
        let Ball { centre, radius } = *ball;
        let mut seed = 1;
        let all = REGIONS.into_iter().flat_map(|(tries, part)| (0..tries).map(move |_| part));
        all.filter_map(move |part| {
            let offset = in_unit_ball(&mut seed);
            let target = [0, 1, 2].map(|k| centre[k] + part * radius * offset[k]);
            let p = free_point(&target, radius * TOLERANCE)?;
            let Way::Arrived(from) = self.way(t, &p) else { return None };
            Some(Place { p, carrier: Carrier::Free, from })
        })
    }
}

/// The next point of a sequence in the unit ball, the same everywhere.
pub(crate) fn in_unit_ball(seed: &mut u64) -> Point {
    let mut next = || {
        *seed =
            seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 32) as f64 / f64::from(1u32 << 31) - 1.0
    };
    let mut point = [0.0; 3];
    // Half of the cube is in the ball; a point outside is shortened in the end.
    for _ in 0..16 {
        point = [next(), next(), next()];
        if point.iter().map(|c| c * c).sum::<f64>() <= 1.0 {
            return point;
        }
    }
    point.map(|c| 0.5 * c)
}
