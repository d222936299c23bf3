//! Verdicts on proposed points, by a survey of the closure and the record alone: for a mesh that is
//! all here, the cavity open or found, and for a closure of which values are known.

use super::bounded::{Bounded, InMesh};
use super::record::Record;
use crate::complex::carrier::Carrier;
use crate::mesh::facet::Change;
use crate::mesh::item::Item;
use crate::mesh::key::{place_of, sort_largest_first};
use crate::mesh::marks::face_bit;
use crate::mesh::state::{FACE, Place, State};
use crate::mesh::survey::Survey;
use crate::outcome::Reason;
use crate::table::{Set, sides, triangle};
use ltbw_core::topology::{TetId, VertexId};
use ltbw_exact::Point;

/// Joint steps at small angles are begun while there were no more transactions in joint steps than
/// this number for each vertex; a part takes up to one.
const JOINT: usize = 4;

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
pub(crate) struct Judge<'s, B: Bounded = InMesh<'s>> {
    pub(crate) closure: B,
    pub(crate) survey: &'s Survey<B::Tet>,
    pub(crate) record: &'s Record,
    /// Is the boundary still being recovered?
    pub(crate) recovers: bool,
}

impl<'s> Judge<'s> {
    /// The grounds of a verdict on the point whose cavity is open, when nothing is missing.
    pub(crate) fn on_open(state: &'s State, record: &'s Record) -> Self {
        Self::new(InMesh::open(state), &state.survey, record)
    }
}

impl<'s, B: Bounded> Judge<'s, B> {
    /// The grounds of a verdict when nothing is missing.
    pub(crate) fn new(closure: B, survey: &'s Survey<B::Tet>, record: &'s Record) -> Self {
        Self { closure, survey, record, recovers: false }
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
        let item = Item::Segment(ends);
        let angles = self.closure.angles();
        let reason = angles.reason_on_segment(s, &|corner| self.has_corner(item, corner));
        if let Some(reason) = reason.filter(|_| self.is_too_near(item, place)) {
            return Verdict::Refuse(reason);
        }
        let refuse =
            || Verdict::Refuse(angles.reason_of_segment(s).unwrap_or_else(|| self.unserved(item)));
        let Some(changes) = self.planned(place, item) else { return refuse() };
        let Some(changes) = self.with_patches(place, Some(ends), changes) else { return refuse() };
        let lost = self.losses(Some(ends), &changes);
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
        let item = Item::Subface(corners);
        let has = |corner: u32| self.has_corner(item, corner);
        let reason = self.closure.angles().reason_on_facet(f, &has);
        if let Some(reason) = reason.filter(|_| self.is_too_near(item, place)) {
            return Verdict::Refuse(reason);
        }
        if !self.survey.hit_segments.is_empty() {
            return Verdict::Defer(self.hits());
        }
        let changes = match self.is_planned(f) {
            _ if !is_on => None,
            true => self.planned(place, item).map(|mut changes| {
                // A patch that would be torn is not changed.
                let patches = self.plan_patches(place, None, &changes);
                changes.extend(patches.into_iter().flatten());
                changes
            }),
            false => self.with_patches(place, None, Vec::new()),
        };
        if let Some(changes) = changes
            && changes.iter().any(|change| change.removed.contains(&corners))
        {
            let lost = self.losses(None, &changes);
            return self.spare(item, place, Filling { split: None, changes, lost });
        }
        match self.segment_between(corners, f, &place.p) {
            Some(segment) => Verdict::Defer(vec![Item::Segment(segment)]),
            None => Verdict::Useless,
        }
    }

    /// On a point in a hole of a patch, if it `is_on` the patch.
    pub(crate) fn on_hole(&self, is_on: bool) -> Verdict {
        let hits = &self.survey.hit_segments;
        if !hits.is_empty() {
            return Verdict::Defer(hits.iter().map(|&s| Item::Segment(s)).collect());
        }
        match is_on {
            true => {
                let lost = self.losses(None, &[]);
                Verdict::Fill(Filling { lost, ..Filling::default() })
            }
            false => Verdict::Useless,
        }
    }

    /// On a point that is to split tetrahedron `t`.
    pub(crate) fn on_tet(&self, t: B::Tet, place: &Place) -> Verdict {
        match self.on_free(place) {
            Verdict::Fill(_) if !self.closure.is_in(t) => Verdict::Useless,
            verdict => verdict,
        }
    }

    /// On a point inside, whatever it is to split.
    pub(crate) fn on_free(&self, place: &Place) -> Verdict {
        let mut first = self.hits();
        let mut changes = Vec::new();
        if first.is_empty() {
            changes = self.plan_patches(place, None, &[]).unwrap_or_default();
            first = self.losses(None, &changes);
        }
        match first.is_empty() {
            false => Verdict::Defer(first),
            true => Verdict::Fill(Filling { changes, ..Filling::default() }),
        }
    }

    /// The items that the point encroaches.
    pub(crate) fn hits(&self) -> Vec<Item> {
        self.in_order(self.survey.hits())
    }

    /// The boundary items that the point would take out of the mesh, of those in its cavity, but
    /// for those that it splits: the subsegment `split`, and what `changes` remove.
    pub(crate) fn losses(&self, split: Option<[VertexId; 2]>, changes: &[Change]) -> Vec<Item> {
        let removed: Set<&[VertexId; 3]> = changes.iter().flat_map(|c| &c.removed).collect();
        let faces = self.survey.inner().filter(|face| !removed.contains(&face.key));
        let edges = self.survey.edges.iter();
        let edges = edges.filter(|edge| edge.is_inner && Some(edge.key) != split);
        let faces = faces.map(|face| Item::Subface(face.key));
        self.in_order(faces.chain(edges.map(|edge| Item::Segment(edge.key))).collect())
    }

    /// Items, the largest first where that is the order.
    fn in_order(&self, mut items: Vec<Item>) -> Vec<Item> {
        if self.closure.state().is_none_or(|state| state.by_place) {
            sort_largest_first(&mut items, |v| self.closure.at(v));
        }
        items
    }

    /// The subsegment of facet `f` between its subface `s` and a point `p` of its plane, that `s`
    /// does not see.
    fn segment_between(&self, s: [VertexId; 3], f: u32, p: &Point) -> Option<[VertexId; 2]> {
        let state = self.closure.state();
        if let Some(state) = state.filter(|state| state.at_edge.is_some()) {
            return state.segment_on_way(s, f, p);
        }
        let place = |&side: &[VertexId; 2]| place_of(Item::Segment(side), |v| self.closure.at(v));
        // A missing subface is in no cavity, but its own sides may be what is between.
        let beyond = |&(side, opposite): &([VertexId; 2], VertexId)| {
            let [a, b] = side.map(|v| self.closure.at(v));
            let inner = self.turn(f, [&a, &b, &self.closure.at(opposite)]);
            self.closure.segment(side).is_some() && self.turn(f, [&a, &b, p]) != inner
        };
        let own = sides(s).into_iter().filter(beyond).map(|(side, _)| side);
        if let Some(side) = own.min_by_key(place) {
            return Some(side);
        }
        // The cavity is star-shaped from `p` and has the subface: what is between them is in it.
        let separates = |[x, y]: [VertexId; 2]| {
            let [x, y] = [x, y].map(|v| self.closure.at(v));
            let corners = s.map(|v| self.closure.at(v));
            let mine = self.turn(f, [&x, &y, p]);
            let theirs = corners.map(|v| self.turn(f, [&x, &y, &v]));
            let between = !mine.is_zero() && theirs.contains(&-mine) && !theirs.contains(&mine);
            let crosses = corners.iter().any(|v| {
                let [left, right] = [x, y].map(|end| self.turn(f, [v, p, &end]));
                !left.is_zero() && left == -right
            });
            between && crosses
        };
        let plc = self.closure.plc();
        let on_facet = |segment: u32| plc.segments[segment as usize].facets.contains(&f);
        let edges = self.survey.edges.iter().filter(|edge| on_facet(edge.segment));
        edges.map(|edge| edge.key).filter(|&key| separates(key)).min_by_key(place)
    }

    /// The reason why an item cannot be split that no point serves.
    fn unserved(&self, item: Item) -> Reason {
        self.closure.unserved(item)
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
            let reason = self.relation(place.carrier, other)?;
            let may = self.record.joint_transactions <= JOINT * self.closure.num_vertices();
            let together = may && self.go_together(item, other, reason, sized);
            (!together).then_some(reason)
        };
        let relates = self.closure.angles().relates();
        if relates && let Some(reason) = lost.iter().find_map(related) {
            return Verdict::Refuse(reason);
        }
        if self.closure.state().is_some_and(|state| state.journal.is_some()) {
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
