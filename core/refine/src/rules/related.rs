//! Small angles in verdicts: which points are too near for the limit of their item, and which items
//! may be split together although they are related. Functions of the closure, the carriers of its
//! vertices and the record alone.

use super::bounded::Bounded;
use super::verdict::Judge;
use crate::complex::carrier::Carrier;
use crate::mesh::item::{Item, has_corner};
use crate::mesh::limit::Limit;
use crate::mesh::state::{Place, State};
use crate::outcome::Reason;
use ltbw_core::topology::{INFINITE, VertexId};
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;

/// The part of its limit down to which the side of a tip may be made: more than one half, so that
/// a tip with a side of the limit's length is not halved for what is beside it.
const TIP_SIDE: f64 = 0.75;

/// The part of its limit that an edge has to have where no joint step halves limits: edges between
/// shells of one size differ in their last bits only, and these decide nothing. (Rounds only.)
const SLACK: f64 = 0.99;

impl<B: Bounded> Judge<'_, B> {
    pub(super) fn has_corner(&self, item: Item, corner: u32) -> bool {
        has_corner(item, corner, |v| self.closure.carrier(v))
    }

    /// Would the point make an edge shorter than what `item` is limited to? The vertex nearest to a
    /// new point is always on the rim of its cavity, as are all of the cavity.
    pub(super) fn is_too_near(&self, item: Item, place: &Place) -> bool {
        let (p, Some(limit)) = (&place.p, self.limit_of(item)) else { return false };
        let by_place = self.closure.state().is_none_or(|state| state.by_place);
        let is_slack = by_place && self.record.limits.contains_key(&item);
        let slack = if is_slack { SLACK } else { 1.0 };
        let is_near = |v: VertexId, least: f64| {
            v != INFINITE && distance2(&self.closure.at(v), p) < least * least
        };
        let is_tip = || match item {
            Item::Segment(ends) => {
                self.tip_side(ends, p).is_some_and(|side| side < TIP_SIDE * limit.least)
            }
            _ => false,
        };
        if !is_tip() && !self.any_around(|v| is_near(v, slack * limit.least)) {
            return false;
        }
        let Some(along) = limit.along else { return true };
        let facets = self.closure.plc().facets_of(&place.carrier);
        self.any_around(|v| is_near(v, slack * along) && !self.is_across(v, item, facets))
    }

    /// The edges that splitting an item may make: its own limit, or that of the joint step.
    pub(super) fn limit_of(&self, item: Item) -> Option<Limit> {
        let joint = || self.closure.state().and_then(State::joint_limit);
        self.record.limits.get(&item).copied().or_else(joint)
    }

    /// Is there such a vertex on the rim of the point's cavity?
    fn any_around(&self, is: impl FnMut(VertexId) -> bool) -> bool {
        self.closure.cavity().flat_map(|t| self.closure.vertices(t)).any(is)
    }

    /// The side of the tip that a point of a subsegment makes at a corner with a tip too sharp for
    /// the bound on shapes, if all segments are cut there at its distance from the corner.
    fn tip_side(&self, ends: [VertexId; 2], p: &Point) -> Option<f64> {
        let s = self.closure.segment(ends)?;
        let side = |end: VertexId| {
            let Carrier::Corner(corner) = self.closure.carrier(end) else { return None };
            let half = self.closure.angles().sharpest(self.closure.plc(), s, corner)?;
            Some(2.0 * half * distance2(&self.closure.at(end), p).sqrt())
        };
        ends.into_iter().filter_map(side).reduce(f64::min)
    }

    /// Is a vertex across a small angle from a boundary item on these facets: on a facet at a small
    /// dihedral angle with one of them, and not on that one, or on a segment that makes a tip with
    /// the item?
    fn is_across(&self, v: VertexId, item: Item, facets: &[u32]) -> bool {
        let (plc, angles) = (self.closure.plc(), self.closure.angles());
        let carrier = self.closure.carrier(v);
        if let Item::Segment(ends) = item
            && let Some(s) = self.closure.segment(ends)
        {
            let segments = match &carrier {
                Carrier::Segment(r, _) => std::slice::from_ref(r),
                Carrier::Corner(c) => plc.segments_at[*c as usize].as_slice(),
                Carrier::Facet(_) | Carrier::Free => &[],
            };
            let is_tip = |end: VertexId| match self.closure.carrier(end) {
                Carrier::Corner(corner) => {
                    segments.iter().any(|&r| r != s && angles.is_tip(s, r, corner))
                }
                _ => false,
            };
            if ends.into_iter().any(|end| end != v && is_tip(end)) {
                return true;
            }
        }
        let others = plc.facets_of(&carrier);
        let across = |f: u32, g: u32| !facets.contains(&g) && angles.hinge(f, g).is_some();
        facets.iter().any(|&f| !plc.lies_on(carrier, f) && others.iter().any(|&g| across(f, g)))
    }

    /// May a point of `item` take `other` out of the mesh, although they are related for this
    /// reason? A subsegment and what else is at its corner may be split together, and, of what is
    /// too large, both sides of a small angle.
    pub(super) fn go_together(&self, item: Item, other: Item, reason: Reason, sized: bool) -> bool {
        let is_at = |corner| self.has_corner(item, corner) && self.has_corner(other, corner);
        match reason {
            Reason::SmallDihedral { .. } => sized,
            Reason::SmallFaceAngle { corner } => {
                sized || matches!(item, Item::Segment(_)) && is_at(corner)
            }
            _ => false,
        }
    }

    /// Why a point on `carrier` may not ask for a boundary item in its cavity to be split, if it
    /// may not: they are at a small angle with each other, or too near.
    pub(super) fn relation(&self, carrier: Carrier, item: Item) -> Option<Reason> {
        let (plc, angles) = (self.closure.plc(), self.closure.angles());
        let has = |corner: u32| self.has_corner(item, corner);
        let of_facet = |f: u32| angles.related(plc, carrier, f, &has);
        match item {
            Item::Segment(s) => {
                let of = self.closure.segment(s)?;
                let own = angles.related_segment(carrier, of, &has);
                let facets = &plc.segments[of as usize].facets;
                own.or_else(|| facets.iter().find_map(|&f| of_facet(f)))
            }
            Item::Subface(s) => {
                of_facet(self.survey.faces.iter().find(|face| face.key == s)?.facet)
            }
            Item::Tet(..) => None,
        }
    }
}
