//! The triangulation of a facet, kept up to date without a two-dimensional mesh.
//!
//! For a point p of facet f, a subface of f is in f's planar cavity of p exactly if both its
//! tetrahedra are in the cavity of p: the perturbed circumsphere of a tetrahedron on the subface
//! meets the plane in the subface's perturbed circumcircle. So the planar cavity is the subfaces of
//! f inside the cavity, and those missing subfaces of f whose perturbed circle holds p, as far
//! as they can be reached from where p is without crossing a subsegment. (Subsegments that wait for
//! their repair make f's triangulation a constrained Delaunay one for a while.) p joined to the rim
//! of the planar cavity are the new subfaces.

use super::bounded::Bounded;
use super::verdict::Judge;
use crate::complex::measure::in_equatorial_ball;
use crate::mesh::facet::{Change, Sides};
use crate::mesh::item::Item;
use crate::mesh::state::Place;
use crate::table::sides;
use ltbw_core::topology::VertexId;
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, perturb};

impl<B: Bounded> Judge<'_, B> {
    /// Is facet `f` one whose triangulation is kept?
    pub(crate) fn is_planned(&self, f: u32) -> bool {
        self.closure.state().map_or(!self.is_patch(f), |state| state.is_planned(f))
    }

    /// Is facet `f` a patch?
    pub(crate) fn is_patch(&self, f: u32) -> bool {
        self.closure.plc().is_patch(f)
    }

    /// The turn of three points on facet `f`; of a patch, in the projection.
    pub(crate) fn turn(&self, f: u32, corners: [&Point; 3]) -> Sign {
        self.closure.plc().turn_on(f, corners)
    }

    /// The changes that a point on `item` makes to the triangulations of the facets that it lies
    /// on, if these are kept; `None` if it does not see the whole rim of one.
    pub(crate) fn planned(&self, place: &Place, item: Item) -> Option<Vec<Change>> {
        let facets = self.closure.plc().facets_of(&place.carrier).iter();
        let kept = facets.filter(|&&f| self.is_planned(f));
        kept.map(|&f| self.plan(f, &place.p, item)).collect()
    }

    /// The change that `p` makes to the triangulation of facet `f`; `None` if `p` does not see its
    /// whole rim, which means that it lies elsewhere.
    fn plan(&self, f: u32, p: &Point, item: Item) -> Option<Change> {
        let mut candidates: Vec<[VertexId; 3]> = self.inner_of(f);
        if let Some(state) = self.closure.state() {
            let missing = state.missing_near(f, p).into_iter();
            candidates.extend(missing.filter(|s| self.conflicts(f, *s, p, item)));
        }
        // At the subfaces along the subsegment that is split, or at the subface that is.
        let starts = |k: &usize| match item {
            Item::Segment([a, b]) => candidates[*k].contains(&a) && candidates[*k].contains(&b),
            Item::Subface(own) => candidates[*k] == own,
            Item::Tet(..) => false,
        };
        let starts = (0..candidates.len()).filter(starts).collect();
        let closed = |side| self.closure.segment(side).is_some();
        let list = Sides::of(&candidates).reached(&candidates, starts, closed);
        let removed: Vec<[VertexId; 3]> = list.iter().map(|&k| candidates[k]).collect();
        self.rim(f, &removed, p, item).map(|rim| Change { removed, rim, ..Change::of(f) })
    }

    /// The subfaces of facet `f` inside the cavity.
    pub(crate) fn inner_of(&self, f: u32) -> Vec<[VertexId; 3]> {
        let own = self.survey.inner().filter(|face| face.facet == f);
        own.map(|face| face.key).collect()
    }

    /// Is `p` in the perturbed circle of a missing subface, or on its edge that is split?
    fn conflicts(&self, f: u32, s: [VertexId; 3], p: &Point, item: Item) -> bool {
        if let Item::Segment([x, y]) = item
            && s.contains(&x)
            && s.contains(&y)
        {
            return true;
        }
        let [a, b, c] = s.map(|v| self.closure.at(v));
        match self.is_patch(f) {
            true => in_equatorial_ball(&a, &b, &c, p),
            false => perturb::side_of_circle(&a, &b, &c, p) == Sign::Positive,
        }
    }

    /// The edges of the removed subfaces that border on nothing removed, but for the one that is
    /// split; `None` if `p` is not strictly on the inner side of each.
    pub(crate) fn rim(
        &self,
        f: u32,
        removed: &[[VertexId; 3]],
        p: &Point,
        item: Item,
    ) -> Option<Vec<[VertexId; 2]>> {
        let mut rim = Vec::new();
        let all = Sides::of(removed);
        for s in removed {
            for (side, opposite) in sides(*s) {
                let split = item == Item::Segment(side);
                let shared = all.at(side).nth(1).is_some();
                // Across a subsegment both subfaces may go, but the subsegment stays.
                if split || shared && self.closure.segment(side).is_none() {
                    continue;
                }
                let [a, b] = side.map(|v| self.closure.at(v));
                let inner = self.turn(f, [&a, &b, &self.closure.at(opposite)]);
                if self.turn(f, [&a, &b, p]) != inner {
                    return None;
                }
                rim.push(side);
            }
        }
        Some(rim)
    }

    /// The changes to other facets, and with them those to patches.
    pub(crate) fn with_patches(
        &self,
        place: &Place,
        split: Option<[VertexId; 2]>,
        mut others: Vec<Change>,
    ) -> Option<Vec<Change>> {
        let patches = self.plan_patches(place, split, &others)?;
        others.extend(patches);
        Some(others)
    }
}
