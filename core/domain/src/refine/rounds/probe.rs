//! Probes: the cavity of a proposed point is opened, looked at and set back. A probe writes its
//! candidate into all slots of its cavity, whatever the verdict, so that what is written is a
//! function of the mesh.

use super::{Asked, Candidate, Pending, Rounds};
use crate::refine::carrier::{Carrier, distance2, free_point};
use crate::refine::item::Item;
use crate::refine::key::{key, order_key, sorted};
use crate::refine::measure::{Shape, circumcircle};
use crate::refine::outcome::Reason;
use crate::refine::split::TOLERANCE;
use crate::refine::state::Place;
use crate::refine::verdict::{Judge, Verdict};
use crate::refine::walk::Way;
use ltbw_core::cavity::Open;
use ltbw_core::topology::{TetId, VertexId};

impl Rounds<'_, '_> {
    /// Proposes a point for a subsegment.
    pub(super) fn probe_segment(&mut self, ends: [VertexId; 2], near: TetId) {
        let (item, state) = (Item::Segment(ends), &self.own.state);
        let Some(&s) = state.segments.get(&ends) else {
            self.pending.remove(&item);
            return;
        };
        let corners = sorted(ends.map(|v| state.at(v)));
        let key = key(distance2(&corners[0], &corners[1]), &corners);
        let Some(t) = state.split_parameter(ends, s) else {
            return self.refuse(item, Reason::Floor);
        };
        let p = state.plc.segments[s as usize].line.point(t);
        let nearest = corners.iter().map(|c| distance2(c, &p)).fold(f64::INFINITY, f64::min);
        if nearest < self.own.floor * self.own.floor {
            return self.refuse(item, Reason::Floor);
        }
        let place = Place { p, carrier: Carrier::Segment(s, t), from: near };
        match self.probe(item, key, &place, |judge| judge.on_segment(ends, s, &place)) {
            Some(Verdict::Fill(_)) => {}
            Some(Verdict::Defer(first)) => self.wait(item, first, near),
            Some(Verdict::Refuse(reason)) => self.refuse(item, reason),
            Some(Verdict::Useless) | None => self.refuse(item, Reason::Rounding),
        }
    }

    /// Proposes a point for a subface.
    pub(super) fn probe_subface(&mut self, corners: [VertexId; 3], near: TetId) {
        let (item, state) = (Item::Subface(corners), &self.own.state);
        let Some(&f) = state.subfaces.get(&corners) else {
            self.pending.remove(&item);
            return;
        };
        let points = sorted(corners.map(|v| state.at(v)));
        let (centre, square) = circumcircle(&points[0], &points[1], &points[2]);
        if square < self.own.floor * self.own.floor {
            return self.refuse(item, Reason::Floor);
        }
        let key = key(square, &points);
        let plane = state.plc.facets[f as usize].plane;
        let reason = state.angles.facet_reason.get(&f).copied();
        for tolerance in [square.sqrt() * TOLERANCE, 1.0] {
            let Some(p) = plane.near(&centre, tolerance) else { continue };
            let place = Place { p, carrier: Carrier::Facet(f), from: near };
            match self.probe(item, key, &place, |judge| judge.on_subface(corners, f, &place)) {
                Some(Verdict::Fill(_)) => return,
                Some(Verdict::Defer(first)) => return self.wait(item, first, near),
                Some(Verdict::Refuse(reason)) => return self.refuse(item, reason),
                Some(Verdict::Useless) | None => {}
            }
        }
        self.refuse(item, reason.unwrap_or(Reason::Rounding));
    }

    /// Proposes a point for a tetrahedron.
    pub(super) fn probe_tet(&mut self, t: TetId) {
        let state = &self.own.state;
        let mut v = state.vertices(t);
        let item = Item::Tet(t, v);
        v.sort_unstable_by_key(|&v| order_key(&state.at(v)));
        let [a, b, c, d] = v.map(|v| state.at(v));
        let shape = Shape::of([&a, &b, &c, &d]);
        let radius = shape.radius();
        if radius < self.own.floor {
            return self.refuse(item, Reason::Floor);
        }
        let limit = self.own.bounds.as_ref().map(|b| b.grain(state, t, &shape));
        for tolerance in [radius * TOLERANCE, 1.0] {
            let Some(centre) = shape.circumcentre(&d) else { break };
            let proposed = free_point(&centre, tolerance);
            let p = proposed.unwrap_or(centre);
            let from = match self.own.state.way(t, &p) {
                Way::Arrived(from) if proposed.is_some() => from,
                Way::Blocked(subface) => return self.ask(t, v, &[Item::Subface(subface)], limit),
                Way::Arrived(_) | Way::Outside => continue,
            };
            let place = Place { p, carrier: Carrier::Free, from };
            let key = self.keys[t as usize];
            match self.probe(item, key, &place, |judge| judge.on_tet(t)) {
                Some(Verdict::Fill(_)) => return,
                Some(Verdict::Defer(first)) => return self.ask(t, v, &first, limit),
                Some(Verdict::Refuse(reason)) => return self.refuse(item, reason),
                Some(Verdict::Useless) | None => {}
            }
        }
        let mut sides = self.own.state.boundary_sides(t);
        self.own.state.sort(&mut sides);
        self.ask(t, v, &sides, limit);
    }

    /// Opens the cavity of a place, takes the verdict and sets the cavity back. A point that serves
    /// its item becomes a candidate, and reserves its cavity. `None` if a vertex is at the place.
    fn probe(
        &mut self,
        item: Item,
        key: u64,
        place: &Place,
        verdict: impl FnOnce(Judge<'_>) -> Verdict,
    ) -> Option<Verdict> {
        self.stats.searches += 1;
        let first = self.cavities.len();
        let place = Place { from: self.own.state.start_near(place.from), ..*place };
        let open = self.own.state.begin_and_look(&place, &mut Open).ok()?;
        let verdict =
            verdict(Judge { state: open.owner(), record: &self.own.record, recovers: false });
        let fits = matches!(verdict, Verdict::Fill(_));
        if fits || matches!(verdict, Verdict::Defer(_)) {
            self.cavities.extend(open.tets());
        }
        drop(open);
        let cavity = first..self.cavities.len();
        if !cavity.is_empty() {
            let place = Place { from: self.cavities[first], ..place };
            let own = Candidate { item, key, place, cavity: cavity.clone(), fits };
            self.candidates.push(own);
            self.reserve(self.candidates.len() - 1);
        }
        Some(verdict)
    }

    fn refuse(&mut self, item: Item, reason: Reason) {
        self.refusals.push((item, reason));
    }

    /// A boundary item waits for others, unless all of them were refused.
    fn wait(&mut self, item: Item, first: Vec<Item>, near: TetId) {
        let limit = self.own.record.limits.get(&item).copied();
        match self.first_of(&first, limit, Reason::Rounding) {
            Ok(first) => {
                self.asked.push(Asked { item: first, limit, near });
                self.waits.push((item, Pending { first: Some(first), near }));
            }
            Err(reason) => self.refuse(item, reason),
        }
    }

    /// A tetrahedron asks for boundary items to be split, unless all of them were refused.
    fn ask(&mut self, t: TetId, v: [VertexId; 4], first: &[Item], limit: Option<f64>) {
        let reason = self.own.state.reason_near(v);
        match self.first_of(first, limit, reason) {
            Ok(item) => self.asked.push(Asked { item, limit, near: t }),
            Err(reason) => self.refuse(Item::Tet(t, self.own.state.vertices(t)), reason),
        }
    }

    /// The first of some items that may be split under a limit; else the reason why none may.
    fn first_of(
        &self,
        items: &[Item],
        limit: Option<f64>,
        mut reason: Reason,
    ) -> Result<Item, Reason> {
        for item in items {
            match self.own.record.bars(item, limit) {
                None => return Ok(*item),
                Some(why) if why != Reason::Rounding => reason = why,
                Some(_) => {}
            }
        }
        Err(reason)
    }
}
