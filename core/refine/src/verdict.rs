//! Verdicts on proposed points: read-only looks at the state with the point's cavity open.

use super::carrier::Carrier;
use super::facet::{Change, Seed};
use super::item::Item;
use super::limit::Limit;
use super::marks::face_bit;
use super::outcome::Reason;
use super::record::Record;
use super::state::{FACE, Place, State, Touched};
use super::table::triangle;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;

/// Joint steps at small angles are begun while there were no more transactions in joint steps than
/// this number for each vertex; a part takes up to one.
const JOINT: usize = 4;

/// The part of its limit down to which the side of a tip may be made: more than one half, so that
/// a tip with a side of the limit's length is not halved for what is beside it.
const TIP_SIDE: f64 = 0.75;

/// The part of its limit that an edge has to have where no joint step halves limits: edges between
/// shells of one size differ in their last bits only, and these decide nothing. (Rounds only.)
const SLACK: f64 = 0.99;

/// The changes of the boundary that come with a point.
#[derive(Debug, Default)]
pub(crate) struct Filling {
    /// The subsegment that it splits, with its segment.
    pub(crate) split: Option<([VertexId; 2], u32)>,
    /// The changes of the facets that it lies on.
    pub(crate) changes: Vec<Change>,
    /// Items that it takes out of the mesh: while the boundary is recovered, and in joint steps.
    pub(crate) lost: Vec<Item>,
}

/// The verdict on a proposed point.
#[derive(Debug)]
pub(crate) enum Verdict {
    /// It may be inserted.
    Fill(Filling),
    /// One of these items comes first.
    Defer(Vec<Item>),
    /// Its item cannot be split.
    Refuse(Reason),
    /// It does not do what it was made for; another one may.
    Useless,
}

/// The grounds of a verdict.
pub(crate) struct Judge<'s> {
    pub(crate) state: &'s State,
    pub(crate) record: &'s Record,
    /// Is the boundary still being recovered?
    pub(crate) recovers: bool,
    /// The boundary in the cavity of the point.
    pub(crate) touched: &'s Touched,
    /// The tetrahedra of this cavity, if it is not open.
    pub(crate) found: Option<&'s [TetId]>,
}

impl<'s> Judge<'s> {
    /// The grounds of a verdict on the point whose cavity is open in the state, when nothing is
    /// missing.
    pub(crate) fn on_open(state: &'s State, record: &'s Record) -> Self {
        Self { state, record, recovers: false, touched: &state.touched, found: None }
    }

    /// On a point that is to split a boundary item; one of a facet is on it if it `is_on`.
    pub(crate) fn on_boundary(&self, item: Item, place: &Place, is_on: bool) -> Verdict {
        match (item, place.carrier) {
            (Item::Segment(ends), Carrier::Segment(s, _)) => self.on_segment(ends, s, place),
            (Item::Subface(corners), Carrier::Facet(f)) => {
                self.on_subface(corners, f, place, is_on)
            }
            _ => Verdict::Useless,
        }
    }

    /// On a point that is to split a subsegment of segment `s`.
    pub(crate) fn on_segment(&self, ends: [VertexId; 2], s: u32, place: &Place) -> Verdict {
        let (state, item) = (self.state, Item::Segment(ends));
        let has = |corner: u32| state.has_corner(item, corner);
        let reason = state.angles.reason_on_segment(s, &has);
        if let Some(reason) = reason.filter(|_| self.is_too_near(item, place)) {
            return Verdict::Refuse(reason);
        }
        let reason = state.angles.reason_of_segment(s);
        let mut changes = Vec::new();
        for f in state.facets_of(place.carrier).into_iter().filter(|&f| state.is_planned(f)) {
            match state.plan(self.touched, f, &place.p, Seed::Along(ends)) {
                Some(change) => changes.push(change),
                None => return Verdict::Refuse(reason.unwrap_or_else(|| state.unserved(item))),
            }
        }
        match state.plan_patches(self.touched, &place.p, place.carrier, Some(ends), &changes) {
            Some(patches) => changes.extend(patches),
            None => return Verdict::Refuse(reason.unwrap_or_else(|| state.unserved(item))),
        }
        let lost = state.losses_in(self.touched, Some(ends), &changes);
        self.spare(item, place, Filling { split: Some((ends, s)), changes, lost })
    }

    /// On a point that is to split a subface of facet `f`, if it `is_on` it.
    pub(crate) fn on_subface(
        &self,
        corners: [VertexId; 3],
        f: u32,
        place: &Place,
        is_on: bool,
    ) -> Verdict {
        let (state, item) = (self.state, Item::Subface(corners));
        let has = |corner: u32| state.has_corner(item, corner);
        let reason = state.angles.reason_on_facet(f, &has);
        if let Some(reason) = reason.filter(|_| self.is_too_near(item, place)) {
            return Verdict::Refuse(reason);
        }
        if !self.touched.hit_segments.is_empty() {
            return Verdict::Defer(state.hits_in(self.touched));
        }
        let changes = match state.is_planned(f) {
            _ if !is_on => None,
            true => state.plan(self.touched, f, &place.p, Seed::At(corners)).map(|change| {
                let mut changes = vec![change];
                let patches =
                    state.plan_patches(self.touched, &place.p, place.carrier, None, &changes);
                changes.extend(patches.into_iter().flatten());
                changes
            }),
            false => state.plan_patches(self.touched, &place.p, place.carrier, None, &[]),
        };
        if let Some(changes) = changes
            && changes.iter().any(|change| change.removed.contains(&corners))
        {
            let lost = state.losses_in(self.touched, None, &changes);
            return self.spare(item, place, Filling { split: None, changes, lost });
        }
        match state.segment_between(self.touched, corners, f, &place.p) {
            Some(segment) => Verdict::Defer(vec![Item::Segment(segment)]),
            None => Verdict::Useless,
        }
    }

    /// On a point in a hole of a patch, if it `is_on` the patch.
    pub(crate) fn on_hole(&self, is_on: bool) -> Verdict {
        let hits = &self.touched.hit_segments;
        if !hits.is_empty() {
            return Verdict::Defer(hits.iter().map(|&s| Item::Segment(s)).collect());
        }
        match is_on {
            true => {
                let lost = self.state.losses_in(self.touched, None, &[]);
                Verdict::Fill(Filling { lost, ..Filling::default() })
            }
            false => Verdict::Useless,
        }
    }

    /// On a point that is to split tetrahedron `t`.
    pub(crate) fn on_tet(&self, t: TetId, p: &Point) -> Verdict {
        let state = self.state;
        let mut first = state.hits_in(self.touched);
        let mut changes = Vec::new();
        if first.is_empty() {
            let patches = state.plan_patches(self.touched, p, Carrier::Free, None, &[]);
            changes = patches.unwrap_or_default();
            first = state.losses_in(self.touched, None, &changes);
        }
        match first.is_empty() {
            false => Verdict::Defer(first),
            true if state.mesh.topology().at(t).is_marked() => {
                Verdict::Fill(Filling { changes, ..Filling::default() })
            }
            true => Verdict::Useless,
        }
    }

    /// Would the point make an edge shorter than what `item` is limited to? The vertex nearest to a
    /// new point is always on the rim of its cavity, as are all of the cavity.
    fn is_too_near(&self, item: Item, place: &Place) -> bool {
        let p = &place.p;
        let Some(limit) = self.limit_of(item) else { return false };
        let is_slack = self.state.by_place && self.record.limits.contains_key(&item);
        let slack = if is_slack { SLACK } else { 1.0 };
        let is_near = |v: VertexId, least: f64| {
            v != INFINITE && distance2(&self.state.at(v), p) < least * least
        };
        let is_tip = || match item {
            Item::Segment(ends) => {
                self.state.tip_side(ends, p).is_some_and(|side| side < TIP_SIDE * limit.least)
            }
            _ => false,
        };
        if !is_tip() && !self.any_around(|v| is_near(v, slack * limit.least)) {
            return false;
        }
        let Some(along) = limit.along else { return true };
        let facets = self.state.facets_of(place.carrier);
        self.any_around(|v| is_near(v, slack * along) && !self.state.is_across(v, item, &facets))
    }

    /// The edges that splitting an item may make: its own limit, or that of the joint step.
    fn limit_of(&self, item: Item) -> Option<Limit> {
        self.record.limits.get(&item).copied().or(self.state.joint_limit())
    }

    /// Is there such a vertex on the rim of the point's cavity?
    fn any_around(&self, is: impl FnMut(VertexId) -> bool) -> bool {
        match self.found {
            None => self.state.mesh.cavity().faces().flatten().any(is),
            Some(tets) => tets.iter().flat_map(|&t| self.state.vertices(t)).any(is),
        }
    }

    /// The verdict on a boundary point that takes the items `lost` out of the mesh. While the
    /// boundary is recovered they are split in their turn.
    ///
    /// Afterwards the boundary is complete, and stays so: what would be lost is split first, or,
    /// where that would take this item out of the mesh, with it. If it may not be split, or is at a
    /// small angle with the point's own carrier, the point is refused, but where a subsegment is
    /// split and both are at one corner, or for the sake of size.
    fn spare(&self, item: Item, place: &Place, filling: Filling) -> Verdict {
        let lost = &filling.lost;
        if lost.is_empty() || self.recovers {
            return Verdict::Fill(filling);
        }
        let limit = self.limit_of(item);
        let sized = limit.is_some_and(|limit| limit.along.is_some());
        let related = |&other: &Item| {
            let reason = self.state.relation(place.carrier, other)?;
            let spent = self.record.joint_transactions;
            let may = spent <= JOINT * self.state.mesh.num_vertices();
            let together = may && self.state.go_together(item, other, reason, sized);
            (!together).then_some(reason)
        };
        if let Some(reason) = lost.iter().find_map(related) {
            return Verdict::Refuse(reason);
        }
        if self.state.journal.is_some() {
            return Verdict::Fill(filling);
        }
        match lost.iter().find_map(|other| self.record.bars(other, limit)) {
            Some(reason) => Verdict::Refuse(reason),
            None => Verdict::Defer(filling.lost),
        }
    }
}

impl State {
    /// The sides of a tetrahedron that are on the boundary.
    pub(crate) fn boundary_sides(&self, t: TetId) -> Vec<Item> {
        let (word, v) = (self.marks.of(t), self.vertices(t));
        let sides = (0..4).filter(|&slot| word & face_bit(slot) != 0).map(|slot| {
            let [a, b, c] = FACE[slot].map(|k| v[k]);
            Item::Subface(triangle(a, b, c))
        });
        sides.collect()
    }
}
