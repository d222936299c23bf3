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

use crate::complex::carrier::Carrier;
use crate::complex::measure::circumcircle;
use crate::mesh::item::Item;
use crate::mesh::state::State;
use crate::outcome::Reason;
use crate::queue::split::Refinement;
use crate::table::edge;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;

/// The vertices of a tetrahedron but for one.
const REST: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];

impl Refinement<'_> {
    /// The corner or segment because of which splitting tetrahedron `t`, with its vertices in any
    /// order, is no help, if it is over its bound of shape only. Of several the order says which.
    pub(crate) fn beyond_help(&self, t: TetId, v: [VertexId; 4]) -> Option<Reason> {
        if self.state.angles.is_empty() {
            return None;
        }
        let bounds = self.bounds.as_ref()?;
        let bound = bounds.ratio?.value();
        let reason = self.state.tip(v, bound).or_else(|| self.state.collar(v, bound))?;
        (!bounds.is_large(&self.state, t)).then_some(reason)
    }
}

impl State {
    /// The side of the tip that a point of a subsegment makes at a corner with a tip too sharp for
    /// the bound on shapes, if all segments are cut there at its distance from the corner.
    pub(crate) fn tip_side(&self, ends: [VertexId; 2], p: &Point) -> Option<f64> {
        let s = *self.segments.get(&ends)?;
        let side = |end: VertexId| {
            let Carrier::Corner(corner) = self.carriers[end.index()] else { return None };
            let half = self.angles.sharpest(&self.plc, s, corner)?;
            Some(2.0 * half * distance2(&self.at(end), p).sqrt())
        };
        ends.into_iter().filter_map(side).reduce(f64::min)
    }

    /// May a point of `item` take `other` out of the mesh, although they are related for this
    /// reason? A subsegment and what else is at its corner may be split together, and, of what is
    /// too large, both sides of a small angle.
    pub(crate) fn go_together(&self, item: Item, other: Item, reason: Reason, sized: bool) -> bool {
        let is_at = |corner| self.has_corner(item, corner) && self.has_corner(other, corner);
        match reason {
            Reason::SmallDihedral { .. } => sized,
            Reason::SmallFaceAngle { corner } => {
                sized || matches!(item, Item::Segment(_)) && is_at(corner)
            }
            _ => false,
        }
    }

    /// Is a vertex across a small angle from a boundary item on these facets: on a facet at a small
    /// dihedral angle with one of them, and not on that one, or on a segment that makes a tip with
    /// the item?
    pub(crate) fn is_across(&self, v: VertexId, item: Item, facets: &[u32]) -> bool {
        let carrier = self.carriers[v.index()];
        if let Item::Segment(ends) = item
            && let Some(&s) = self.segments.get(&ends)
        {
            let segments = match &carrier {
                Carrier::Segment(r, _) => std::slice::from_ref(r),
                Carrier::Corner(c) => self.plc.segments_at[*c as usize].as_slice(),
                Carrier::Facet(_) | Carrier::Free => &[],
            };
            let is_tip = |end: VertexId| match self.carriers[end.index()] {
                Carrier::Corner(corner) => {
                    segments.iter().any(|&r| r != s && self.angles.is_tip(s, r, corner))
                }
                _ => false,
            };
            if ends.into_iter().any(|end| end != v && is_tip(end)) {
                return true;
            }
        }
        let others = self.plc.facets_of(&carrier);
        let across = |f: u32, g: u32| !facets.contains(&g) && self.angles.hinge(f, g).is_some();
        facets.iter().any(|&f| !self.lies_on(carrier, f) && others.iter().any(|&g| across(f, g)))
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

    /// The corner at which a tetrahedron is on a tip for this bound on its shape.
    pub(crate) fn tip(&self, v: [VertexId; 4], bound: f64) -> Option<Reason> {
        (0..4).find_map(|k| {
            let Carrier::Corner(corner) = self.carriers[v[k].index()] else { return None };
            let reason = Reason::SmallFaceAngle { corner };
            let [a, b, c] = REST[k].map(|k| v[k]);
            let pairs = [[a, b], [b, c], [c, a]];
            pairs.iter().any(|&pair| self.is_tip(v[k], corner, pair, bound)).then_some(reason)
        })
    }

    /// Are two vertices the far ends of subsegments at a corner with an angle too small for this
    /// bound, and no farther apart than the subsegments are long?
    fn is_tip(&self, apex: VertexId, corner: u32, ends: [VertexId; 2], bound: f64) -> bool {
        let of = |end: VertexId| self.segments.get(&edge(apex, end)).copied();
        let [Some(s), Some(r)] = ends.map(of) else { return false };
        if s == r || !self.angles.is_tip(s, r, corner) {
            return false;
        }
        let (o, [a, b]) = (self.at(apex), ends.map(|v| self.at(v)));
        let side = distance2(&a, &b);
        side <= distance2(&o, &a).min(distance2(&o, &b))
            && circumcircle(&a, &b, &o).1 > bound * bound * side
    }

    /// The segment in whose collar a tetrahedron is for this bound on its shape: all its vertices
    /// are on two facets that meet there, some on each alone, and some on the segment.
    pub(crate) fn collar(&self, v: [VertexId; 4], bound: f64) -> Option<Reason> {
        let limit = 1.0 / (16.0 * bound * bound);
        let on = |f: u32, v: &VertexId| self.lies_on(self.carriers[v.index()], f);
        let is_in = |[f, g]: [u32; 2]| {
            let sides = v.map(|v| [on(f, &v), on(g, &v)]);
            sides.iter().all(|side| *side != [false, false])
                && sides.contains(&[true, false])
                && sides.contains(&[false, true])
                && sides.contains(&[true, true])
        };
        v.iter().find_map(|&w| {
            let segments = match &self.carriers[w.index()] {
                Carrier::Segment(s, _) => std::slice::from_ref(s),
                Carrier::Corner(c) => self.plc.segments_at[*c as usize].as_slice(),
                Carrier::Facet(_) | Carrier::Free => return None,
            };
            let found = segments.iter().find(|s| self.angles.wedges(**s, limit).any(is_in));
            found.map(|s| Reason::SmallDihedral { segment: self.plc.segments[*s as usize].ends })
        })
    }
}
