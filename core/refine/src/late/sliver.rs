//! Slivers: tetrahedra with tiny dihedral angles, which bounds on their shape allow.
//!
//! When all bounds are met, a point is looked for whose cavity has the sliver and whose own
//! tetrahedra meet the bound and have no such angle. So no sliver follows from another, and the
//! number of tries is bounded. Where none serves the sliver stays.

use crate::complex::measure::{RatioBound, has_large_dihedrals, has_small_dihedral};
use crate::mesh::item::Item;
use crate::mesh::key::sorted;
use crate::mesh::state::State;
use crate::queue::split::Refinement;
use crate::rules::bounded::Bounded;
use crate::rules::verdict::Judge;
use crate::rules::way::FACES;
use crate::thin::Thin;
use ltbw_core::topology::{INFINITE, TetId};
use ltbw_exact::Point;

/// Points tried for a sliver.
pub(crate) const TRIES: u32 = 32;

/// They are within this part of the circumradius of the circumcentre.
pub(crate) const REACH: f64 = 0.75;

impl Refinement<'_> {
    /// The slivers in the order of their coordinates; none without a bound of shape.
    pub(crate) fn slivers(&mut self) -> Vec<Thin> {
        let (state, thin) = (&self.state, &mut self.inserted.thin.tets);
        if self.bounds.as_ref().is_none_or(|bounds| bounds.ratio.is_none()) {
            return Vec::new();
        }
        thin.retain(|&(t, v)| state.is_live(t, v));
        let mut slivers: Vec<Thin> =
            thin.iter().copied().filter(|&(t, _)| state.is_sliver(t)).collect();
        slivers.sort_by_cached_key(|&(t, v)| state.place_of(Item::Tet(t, v)));
        slivers.dedup();
        debug_assert!(
            state.mesh.tet_ids().filter(|&t| state.is_sliver(t)).count() == slivers.len(),
            "all slivers are in the list"
        );
        slivers
    }
}

impl Judge<'_> {
    /// Would the tetrahedra of the point meet the bound, without tiny angles?
    pub(crate) fn makes_no_sliver(&self, p: &Point, ratio: &RatioBound) -> bool {
        let state = self.closure.state;
        self.closure.walls().all(|(t, slot)| {
            let face = FACES[slot].map(|k| state.vertices(t)[k]);
            if face.contains(&INFINITE) {
                return false;
            }
            let [a, b, c] = face.map(|v| state.at(v));
            // The angles are rounded, in an order that is the same for all orders of the face.
            let [d, e, f] = &sorted([a, b, c]);
            !has_small_dihedral([d, e, f, p]) && !ratio.exceeded([&a, &b, &c, p])
        })
    }
}

impl State {
    /// Is a tetrahedron in a region, no dust, and has it a tiny dihedral angle?
    pub(crate) fn is_sliver(&self, t: TetId) -> bool {
        if self.marks.region(t) == 0 {
            return false;
        }
        let v = self.vertices(t);
        let corners = v.map(|v| self.at(v));
        if has_large_dihedrals(corners.each_ref()) {
            return false;
        }
        has_small_dihedral(sorted(corners).each_ref()) && !self.is_flat(v)
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
