//! Probes: the cavity of a proposed point is opened, looked at and set back. A probe for a
//! tetrahedron writes its candidate into all slots of its cavity, whatever the verdict, so that the
//! slots are a function of the mesh; of boundary items only those that are taken write theirs.

use super::conflict::is_same;
use super::{Asked, Candidate, DEFERS, Pending, Rounds};
use crate::refine::carrier::{Carrier, distance2, free_point};
use crate::refine::item::Item;
use crate::refine::key::{order_key, sorted};
use crate::refine::measure::{Shape, circumcircle};
use crate::refine::outcome::Reason;
use crate::refine::split::{TOLERANCE, aim};
use crate::refine::state::Place;
use crate::refine::verdict::{Filling, Judge, Verdict};
use crate::refine::walk::Way;
use ltbw_core::cavity::Role;
use ltbw_core::mesh::At;
use ltbw_core::topology::{TetId, VertexId};

/// See [`Rounds::goes_on`].
const PATIENCE: u64 = 32;

/// The result of a probe.
enum Probe {
    /// The point may be inserted.
    Fits,
    /// One taken before is in its way.
    Barred,
    Defers(Vec<Item>),
    Refuses(Reason),
    /// Another point may serve.
    Useless,
}

impl Rounds<'_, '_> {
    /// Proposes a point for a subsegment.
    pub(super) fn probe_segment(&mut self, ends: [VertexId; 2], near: TetId) {
        let (item, state) = (Item::Segment(ends), &self.own.state);
        let Some(&s) = state.segments.get(&ends) else {
            self.pending.remove(&item);
            return;
        };
        let corners = sorted(ends.map(|v| state.at(v)));
        let Some(t) = state.split_parameter(ends, s) else {
            return self.refuse(item, Reason::Floor);
        };
        let p = state.plc.segments[s as usize].line.point(t);
        let nearest = corners.iter().map(|c| distance2(c, &p)).fold(f64::INFINITY, f64::min);
        if nearest < self.own.floor * self.own.floor {
            return self.refuse(item, Reason::Floor);
        }
        let place = Place { p, carrier: Carrier::Segment(s, t), from: near };
        match self.probe(item, &place, |judge| judge.on_segment(ends, s, &place)) {
            Probe::Fits => self.take_or_drop(),
            Probe::Barred => {}
            Probe::Defers(first) => self.wait(item, first, near),
            Probe::Refuses(reason) => self.refuse(item, reason),
            Probe::Useless => self.refuse(item, Reason::Rounding),
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
        let plane = state.plc.facets[f as usize].plane;
        let reason = state.angles.reason_of_facet(f);
        let (centre, radius) = aim(points, &centre, square);
        for tolerance in [radius * TOLERANCE, 1.0] {
            let Some(p) = plane.near(&centre, tolerance) else { continue };
            let place = Place { p, carrier: Carrier::Facet(f), from: near };
            let verdict = |judge: Judge<'_>| judge.on_subface(corners, f, &place, true);
            match self.probe(item, &place, verdict) {
                Probe::Fits => return self.take_or_drop(),
                Probe::Barred => return,
                Probe::Defers(first) => return self.wait(item, first, near),
                Probe::Refuses(reason) => return self.refuse(item, reason),
                Probe::Useless => {}
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
        let limit =
            |own: &Self| own.own.bounds.as_ref().map(|b| b.grain(&own.own.state, t, &shape));
        for tolerance in [radius * TOLERANCE, 1.0] {
            let Some(centre) = shape.circumcentre(&d) else { break };
            let proposed = free_point(&centre, tolerance);
            let p = proposed.unwrap_or(centre);
            let from = match self.own.state.way(t, &p) {
                Way::Arrived(from) if proposed.is_some() => from,
                Way::Blocked(subface) => {
                    let limit = limit(self);
                    self.ask(t, v, &[Item::Subface(subface)], limit);
                    return;
                }
                Way::Arrived(_) | Way::Outside => continue,
            };
            if let Some(reason) = self.blocked(&p, v) {
                return self.refuse(item, reason);
            }
            let place = Place { p, carrier: Carrier::Free, from };
            match self.probe(item, &place, |judge| judge.on_tet(t, &place.p)) {
                Probe::Fits if self.survives() => return self.take(),
                Probe::Fits => return self.reserve(0),
                Probe::Defers(first) => {
                    let limit = limit(self);
                    // One that is refused is in nobody's way.
                    match self.ask(t, v, &first, limit) {
                        true => self.reserve(DEFERS),
                        false => self.note_blocks(limit),
                    }
                    return;
                }
                Probe::Refuses(reason) => return self.refuse(item, reason),
                Probe::Barred => return,
                Probe::Useless => {}
            }
        }
        let mut sides = self.own.state.boundary_sides(t);
        self.own.state.sort(&mut sides);
        let limit = limit(self);
        self.ask(t, v, &sides, limit);
    }

    /// Opens the cavity of a place, takes the verdict and sets the cavity back. A point that serves
    /// its item becomes a candidate.
    fn probe(
        &mut self,
        item: Item,
        place: &Place,
        verdict: impl FnOnce(Judge<'_>) -> Verdict,
    ) -> Probe {
        let goes_on = match item {
            Item::Tet(t, _) => self.goes_on(t),
            _ => false,
        };
        let Self { own, reserved, candidates, cavities, stats, .. } = self;
        let state = &mut own.state;
        let place = Place { from: state.start_near(place.from), ..*place };
        let first = cavities.len();
        stats.searches += 1;
        // Rule (d): boundary points keep apart. Free points keep out of the cavities of those that
        // ask for an item: it is likely to be in their way, too.
        let is_free = place.carrier == Carrier::Free;
        let mut admission = |t: TetId, role: Role| {
            let other = reserved[t as usize];
            match is_free {
                true => other & DEFERS == 0 || role == Role::Ring || goes_on,
                false if other == 0 => true,
                false => is_same(candidates[other as usize - 1].place.carrier, place.carrier),
            }
        };
        let open = match state.begin_and_look(&place, &mut admission) {
            Ok(open) => open,
            Err(At::Vertex(_)) => return Probe::Useless,
            Err(At::SetBack(_)) => {
                stats.searches -= 1;
                stats.barred += 1;
                return Probe::Barred;
            }
        };
        let verdict = verdict(Judge { state: open.owner(), record: &own.record, recovers: false });
        let (probe, filling) = match verdict {
            Verdict::Fill(filling) => (Probe::Fits, filling),
            Verdict::Defer(first) if is_free => (Probe::Defers(first), Filling::default()),
            Verdict::Defer(first) => return Probe::Defers(first),
            Verdict::Refuse(reason) => return Probe::Refuses(reason),
            Verdict::Useless => return Probe::Useless,
        };
        cavities.extend(open.tets());
        let place = Place { from: cavities[first], ..place };
        candidates.push(Candidate { item, place, cavity: first..cavities.len(), filling });
        probe
    }

    /// Is this one of the choices in which the probe of a tetrahedron goes on into cavities of
    /// those that defer? Each has one in [`PATIENCE`]: else thousands that defer in one place would
    /// wait for each other, one a round.
    fn goes_on(&self, t: TetId) -> bool {
        (self.keys[t as usize] >> 8).wrapping_add(self.choices).is_multiple_of(PATIENCE)
    }

    /// Takes the last candidate, unless one taken before it is in its way.
    fn take_or_drop(&mut self) {
        if self.survives() {
            self.take();
        } else if let Some(last) = self.candidates.pop() {
            self.cavities.truncate(last.cavity.start);
        }
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

    /// A tetrahedron asks for boundary items to be split; `false` if all of them were refused, and
    /// it is in its turn.
    fn ask(&mut self, t: TetId, v: [VertexId; 4], first: &[Item], limit: Option<f64>) -> bool {
        let reason = self.own.state.reason_near(v);
        match self.first_of(first, limit, reason) {
            Ok(item) => {
                self.asked.push(Asked { item, limit, near: t });
                true
            }
            Err(reason) => {
                self.refuse(Item::Tet(t, self.own.state.vertices(t)), reason);
                false
            }
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
