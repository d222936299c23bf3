//! Tetrahedra at input angles so small that no refinement gives them the shape that is asked for.
//!
//! *Tips*: two subsegments at a corner, at an angle t with 2B sin t < 1, make a triangle whose
//! circumradius is more than B times the side between their far ends. So has every tetrahedron on
//! it, and cutting the subsegments, at whatever distance, leaves a smaller tip at the corner.
//!
//! *Collars*: next to a segment where two facets meet at a dihedral angle d with 4B sin(d/2) < 1,
//! the facets are nearer to each other than the bound allows tetrahedra with an edge along the
//! segment, and points on the facets leave a thinner collar of tetrahedra with vertices on the two
//! facets alone.
//!
//! Two subsegments that leave a corner at a small angle, long beside their distance, displace each
//! other: they are split together. Where they make a tip, no subsegment is cut at all if the side
//! of the tip would then be shorter than the limit allows: if one were, the others could not
//! follow, and what lies between them would be worse than the tip was.
//!
//! Such a tetrahedron that is over its bound of shape only is excused at once, with the corner or
//! segment for a reason. Before, it was split for some levels, each of which left as many excused.

use crate::complex::angles::Angles;
use crate::complex::carrier::{Carrier, Corner};
use crate::complex::measure::circumcircle;
use crate::complex::plc::Plc;
use crate::mesh::bounds::Bounds;
use crate::mesh::item::Item;
use crate::mesh::state::State;
use crate::outcome::Reason;
use crate::queue::split::Refinement;
use crate::table::edge;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_domain::vector::distance2;

/// The vertices of a tetrahedron but for one.
const REST: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];

impl Refinement<'_> {
    /// The corner or segment because of which splitting tetrahedron `t`, with its vertices in any
    /// order, is no help, if it is over its bound of shape only. Of several the order says which.
    pub(crate) fn beyond_help(&self, t: TetId, v: [VertexId; 4]) -> Option<Reason> {
        let bounds = self.bounds.as_ref()?;
        let reason = self.state.asks_for_shape(v, bounds)?;
        (!bounds.is_large(&self.state, t)).then_some(reason)
    }
}

impl State {
    /// The corner or segment of the domain that asks for the shape of a tetrahedron with these
    /// corners, in any order, if one does: it is on a tip or in a collar.
    pub(crate) fn asks_for_shape(&self, v: [VertexId; 4], bounds: &Bounds<'_>) -> Option<Reason> {
        let corners = self.cornered(v);
        let of = |[j, k]: [usize; 2]| self.segments.get(&edge(v[j], v[k])).copied();
        self.angles.beyond_help(&self.plc, &corners, of, bounds)
    }

    /// The small angle at which a subsegment is, or that it and others displace each other.
    pub(crate) fn reason_in_circle(&self, item: Item) -> Reason {
        let has = |corner: u32| self.has_corner(item, corner);
        let reason = match item {
            Item::Segment(s) => {
                self.segments.get(&s).and_then(|&s| self.angles.reason_on_segment(s, &has))
            }
            _ => None,
        };
        reason.unwrap_or_else(|| self.interlocked(item))
    }

    /// Some vertices, each with where it lives.
    pub(crate) fn cornered(&self, v: [VertexId; 4]) -> [Corner; 4] {
        v.map(|v| self.corner(v))
    }

    /// The segment in whose collar a tetrahedron is for this bound on its shape.
    pub(crate) fn collar(&self, v: [VertexId; 4], bound: f64) -> Option<Reason> {
        self.angles.collar(&self.plc, &self.cornered(v), bound)
    }
}

impl Angles {
    /// The corner or segment because of which splitting a tetrahedron with these corners is no
    /// help, if it is over its bound of shape only; `of` tells the segment of an edge that is a
    /// subsegment. Of several the order says which.
    pub(crate) fn beyond_help(
        &self,
        plc: &Plc,
        corners: &[Corner; 4],
        of: impl Fn([usize; 2]) -> Option<u32>,
        bounds: &Bounds<'_>,
    ) -> Option<Reason> {
        if self.is_empty() {
            return None;
        }
        let bound = bounds.ratio?.value();
        self.tip(corners, of, bound).or_else(|| self.collar(plc, corners, bound))
    }

    /// The corner at which a tetrahedron is on a tip for this bound on its shape: two edges there
    /// are subsegments at an angle too small for it, and their far ends no farther apart than they
    /// are long.
    fn tip(
        &self,
        corners: &[Corner; 4],
        of: impl Fn([usize; 2]) -> Option<u32>,
        bound: f64,
    ) -> Option<Reason> {
        let is_tip = |apex: usize, corner: u32, ends: [usize; 2]| {
            let [Some(s), Some(r)] = ends.map(|end| of([apex, end])) else { return false };
            if s == r || !self.is_tip(s, r, corner) {
                return false;
            }
            let [o, a, b] = [apex, ends[0], ends[1]].map(|k| corners[k].point);
            let side = distance2(&a, &b);
            side <= distance2(&o, &a).min(distance2(&o, &b))
                && circumcircle(&a, &b, &o).1 > bound * bound * side
        };
        (0..4).find_map(|k| {
            let Carrier::Corner(corner) = corners[k].carrier else { return None };
            let [a, b, c] = REST[k];
            let pairs = [[a, b], [b, c], [c, a]];
            let reason = Reason::SmallFaceAngle { corner };
            pairs.into_iter().any(|pair| is_tip(k, corner, pair)).then_some(reason)
        })
    }

    /// The segment in whose collar a tetrahedron is for this bound on its shape: all its vertices
    /// are on two facets that meet there, some on each alone, and some on the segment.
    pub(crate) fn collar(&self, plc: &Plc, corners: &[Corner; 4], bound: f64) -> Option<Reason> {
        let limit = 1.0 / (16.0 * bound * bound);
        let is_in = |[f, g]: [u32; 2]| {
            let sides = corners.map(|own| [f, g].map(|f| plc.lies_on(own.carrier, f)));
            sides.iter().all(|side| *side != [false, false])
                && sides.contains(&[true, false])
                && sides.contains(&[false, true])
                && sides.contains(&[true, true])
        };
        corners.iter().find_map(|own| {
            let segments = match &own.carrier {
                Carrier::Segment(s, _) => std::slice::from_ref(s),
                Carrier::Corner(c) => plc.segments_at[*c as usize].as_slice(),
                Carrier::Facet(_) | Carrier::Free => return None,
            };
            let found = segments.iter().find(|s| self.wedges(**s, limit).any(is_in));
            found.map(|s| Reason::SmallDihedral { segment: plc.segments[*s as usize].ends })
        })
    }
}
