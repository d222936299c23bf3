//! Slivers: tetrahedra with tiny dihedral angles, which bounds on their shape allow.
//!
//! When all bounds are met, a point is looked for whose cavity has the sliver and whose own
//! tetrahedra meet the bound and have no such angle. So no sliver follows from another, and the
//! number of tries is bounded. Where none serves the sliver stays.

use super::carrier::{Carrier, free_point};
use super::item::{Item, Work};
use super::key::sorted;
use super::measure::{RatioBound, Shape, has_large_dihedrals, has_small_dihedral};
use super::outcome::Reason;
use super::split::{Proposal, Refinement, TOLERANCE};
use super::state::{Place, State};
use super::verdict::{Judge, Verdict};
use super::walk::Way;
use ltbw_core::cavity::Admission;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;
use rayon::prelude::*;

/// Tetrahedra that one thread looks at at a time, at least.
const SHARE: usize = if cfg!(test) { 5 } else { 4096 };

/// Points tried for a sliver.
pub(crate) const TRIES: u32 = 32;

/// They are within this part of the circumradius of the circumcentre.
pub(crate) const REACH: f64 = 0.75;

/// A tetrahedron with a tiny dihedral angle.
pub(crate) type Thin = (TetId, [VertexId; 4]);

impl Refinement<'_> {
    /// Splits slivers in the regions, in the order of their coordinates, with `most` points.
    /// Returns those that are left.
    pub(crate) fn split_slivers<W: Work, A: Admission>(
        &mut self,
        most: u64,
        work: &mut W,
        admission: &mut A,
    ) -> Vec<Thin> {
        let ratio = self.bounds.as_ref().and_then(|bounds| bounds.ratio);
        let Some(ratio) = ratio else { return Vec::new() };
        let mut slivers = self.slivers();
        for &(t, v) in &slivers {
            if self.inserted.points.total() >= most {
                break;
            }
            self.split_sliver(t, v, ratio, work, admission);
        }
        // No point makes one.
        slivers.retain(|&(t, v)| self.state.is_live(t, v));
        slivers
    }

    /// The slivers in the order of their coordinates; none without a bound of shape.
    pub(crate) fn slivers(&self) -> Vec<Thin> {
        let state = &self.state;
        if self.bounds.as_ref().is_none_or(|bounds| bounds.ratio.is_none()) {
            return Vec::new();
        }
        let all: Vec<TetId> = state.mesh.tet_ids().collect();
        let all = all.par_iter().with_min_len(SHARE).filter(|&&t| state.is_sliver(t));
        self.sorted(all.map(|&t| (t, state.vertices(t))).collect())
    }

    /// The slivers, in the same order, where all are among these.
    pub(crate) fn slivers_among(&self, mut tets: Vec<Thin>) -> Vec<Thin> {
        tets.retain(|&(t, v)| self.state.is_live(t, v) && self.state.is_sliver(t));
        let slivers = self.sorted(tets);
        debug_assert_eq!(slivers, self.slivers(), "all slivers are known");
        slivers
    }

    /// The tetrahedra that the last insertion has made.
    pub(crate) fn created(&self) -> impl Iterator<Item = Thin> + '_ {
        let all = self.inserted.created.iter().map(|&t| (t, self.state.vertices(t)));
        all.filter(|(_, v)| v[3] != INFINITE)
    }

    fn sorted(&self, mut tets: Vec<Thin>) -> Vec<Thin> {
        tets.sort_by_cached_key(|&(t, v)| self.state.place_of(Item::Tet(t, v)));
        tets
    }

    fn split_sliver<W: Work, A: Admission>(
        &mut self,
        t: TetId,
        v: [VertexId; 4],
        ratio: RatioBound,
        work: &mut W,
        admission: &mut A,
    ) {
        let corners = v.map(|v| self.state.at(v));
        let [a, b, c, d] = &corners;
        let shape = Shape::of([a, b, c, d]);
        let radius = shape.radius();
        let Some(centre) = shape.circumcentre(d) else { return };
        let mut seed = 1;
        for _ in 0..TRIES {
            if !self.state.is_live(t, v) {
                return;
            }
            let offset = in_unit_ball(&mut seed);
            let target = [0, 1, 2].map(|k| centre[k] + REACH * radius * offset[k]);
            let Some(p) = free_point(&target, radius * TOLERANCE) else { continue };
            let Way::Arrived(from) = self.state.way(t, &p) else { continue };
            let place = Place { p, carrier: Carrier::Free, from };
            let verdict = |judge: Judge<'_>| match judge.on_tet(t, &place.p) {
                Verdict::Fill(filling) if judge.makes_no_sliver(&p, &ratio) => {
                    Verdict::Fill(filling)
                }
                _ => Verdict::Refuse(Reason::Rounding),
            };
            if let Proposal::Inserted | Proposal::SetBack(_) =
                self.propose(&place, work, admission, verdict)
            {
                return;
            }
        }
    }
}

impl Judge<'_> {
    /// Would the tetrahedra of the point of the open cavity meet the bound, without tiny angles?
    pub(crate) fn makes_no_sliver(&self, p: &Point, ratio: &RatioBound) -> bool {
        self.state.mesh.cavity().faces().all(|face| {
            if face.contains(&INFINITE) {
                return false;
            }
            let [a, b, c] = face.map(|v| self.state.at(v));
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
