//! The three rules, each a transaction on one cavity: split a subsegment, a subface, a tetrahedron.
//!
//! A transaction is idempotent: if its item is gone it does nothing. It decides on the closure of
//! its point and the registry alone. It ends with the point inserted; or with nothing changed and
//! other items put before it (*deferred*); or with a reason why its item cannot be split.

use super::angles::{direction, is_sharp};
use super::bounds::Bounds;
use super::carrier::{Carrier, Line, distance2, free_point};
use super::facet::{Change, Seed};
use super::item::{Item, Work};
use super::marks::{edge_bit, face_bit};
use super::measure::{Shape, circumcircle};
use super::outcome::Reason;
use super::state::State;
use super::table::{Map, edge, triangle};
use ltbw_core::cavity::{Admission, Setback};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;

/// A point may be this part of the radius away from the ideal one.
const TOLERANCE: f64 = 1.0 / 1000.0;

/// How a transaction ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    /// A vertex was inserted.
    Inserted,
    /// The item is gone.
    Gone,
    /// Other items come first.
    Deferred,
    /// The item cannot be split.
    Refused(Reason),
    /// The admission refused a tetrahedron, or the mesh is full.
    SetBack(Setback),
}

/// Why an item was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Refusal {
    pub(crate) reason: Reason,
    /// The shortest edge that was allowed; a proposal that allows shorter ones may try again.
    limit: Option<f64>,
}

impl Refusal {
    /// A refusal for good.
    pub(crate) fn final_for(reason: Reason) -> Self {
        Self { reason, limit: None }
    }
}

/// Where to insert a point.
struct Place {
    p: Point,
    carrier: Carrier,
    /// Where the walk starts.
    from: TetId,
}

/// The refinement: state, bounds, and what was refused.
pub(crate) struct Refinement<'a> {
    pub(crate) state: State,
    /// `None` while the boundary is recovered: no tetrahedron is looked at then.
    pub(crate) bounds: Option<Bounds<'a>>,
    pub(crate) refused: Map<Item, Refusal>,
    /// Tetrahedra made while a subface was missing: their region is not certain.
    pub(crate) dirty: Vec<(TetId, [VertexId; 4])>,
    /// Proposed items near small angles: the shortest edge that splitting them may make.
    limits: Map<Item, f64>,
    /// Shortest edge that may be made, in fine steps.
    pub(crate) floor: f64,
    /// Number of the next vertex.
    pub(crate) next_number: u32,
    /// New tetrahedra of the last insertion.
    created: Vec<TetId>,
}

impl<'a> Refinement<'a> {
    pub(crate) fn new(state: State, next_number: u32, floor: f64) -> Self {
        Self {
            state,
            bounds: None,
            refused: Map::default(),
            dirty: Vec::new(),
            limits: Map::default(),
            floor,
            next_number,
            created: Vec::new(),
        }
    }

    /// Carries out the rule for an item.
    pub(crate) fn split<W: Work, A: Admission>(
        &mut self,
        item: Item,
        work: &mut W,
        admission: &mut A,
    ) -> Step {
        let step = match item {
            Item::Segment(s) => self.split_segment(s, work, admission),
            Item::Subface(s) => self.split_subface(s, work, admission),
            Item::Tet(t, v) => self.split_tet(t, v, work, admission),
        };
        match step {
            Step::Refused(reason) => {
                let limit = self.limits.remove(&item);
                self.refused.insert(item, Refusal { reason, limit });
                // A refused item no longer waits; only a missing one keeps its place.
                if !matches!(item, Item::Subface(s) if self.state.missing.contains(&s)) {
                    self.state.registry.remove(item);
                }
            }
            Step::Inserted | Step::Gone if !matches!(item, Item::Tet(..)) => {
                self.state.registry.remove(item);
                self.limits.remove(&item);
            }
            _ => {}
        }
        step
    }

    /// Rule 1: a subsegment is split near its middle.
    fn split_segment<W: Work, A: Admission>(
        &mut self,
        ends: [VertexId; 2],
        work: &mut W,
        admission: &mut A,
    ) -> Step {
        let item = Item::Segment(ends);
        let Some(&s) = self.state.segments.get(&ends) else { return Step::Gone };
        if let Some(refusal) = self.refused.get(&item) {
            return Step::Refused(refusal.reason);
        }
        let Some(t) = self.state.split_parameter(ends, s) else {
            return Step::Refused(Reason::Floor);
        };
        let p = self.state.plc.segments[s as usize].line.point(t);
        let [a, b] = ends.map(|v| self.state.at(v));
        if distance2(&a, &p).min(distance2(&b, &p)) < self.floor * self.floor {
            return Step::Refused(Reason::Floor);
        }
        let place = Place { p, carrier: Carrier::Segment(s, t), from: self.state.mesh.hint() };
        match self.open(&place, admission) {
            Ok(()) => {}
            Err(step) => return step,
        }
        let reason = self.state.angles.segment_reason.get(&s).copied();
        if let Some(reason) = reason.filter(|_| self.is_too_near(item, &p)) {
            self.state.mesh.set_back();
            return Step::Refused(reason);
        }
        let mut changes = Vec::new();
        for f in self.state.facets_of(place.carrier) {
            match self.state.plan(f, &p, Seed::Along(ends)) {
                Some(change) => changes.push(change),
                None => {
                    self.state.mesh.set_back();
                    return Step::Refused(reason.unwrap_or(Reason::Rounding));
                }
            }
        }
        self.insert(&place, Some((ends, s)), &changes, work);
        Step::Inserted
    }

    /// Rule 2: a subface is split near its circumcentre, unless that encroaches a subsegment.
    fn split_subface<W: Work, A: Admission>(
        &mut self,
        corners: [VertexId; 3],
        work: &mut W,
        admission: &mut A,
    ) -> Step {
        let item = Item::Subface(corners);
        let Some(&f) = self.state.subfaces.get(&corners) else { return Step::Gone };
        if let Some(refusal) = self.refused.get(&item) {
            return Step::Refused(refusal.reason);
        }
        let [a, b, c] = corners.map(|v| self.state.at(v));
        let (centre, square) = circumcircle(&a, &b, &c);
        if square < self.floor * self.floor {
            return Step::Refused(Reason::Floor);
        }
        let reason = self.state.angles.facet_reason.get(&f).copied();
        for tolerance in [square.sqrt() * TOLERANCE, 1.0] {
            let plane = self.state.plc.facets[f as usize].plane;
            let Some(p) = plane.near(&centre, tolerance) else { continue };
            let place = Place { p, carrier: Carrier::Facet(f), from: self.state.mesh.hint() };
            match self.open(&place, admission) {
                Ok(()) => {}
                Err(Step::Refused(_)) => continue,
                Err(step) => return step,
            }
            if let Some(reason) = reason.filter(|_| self.is_too_near(item, &p)) {
                self.state.mesh.set_back();
                return Step::Refused(reason);
            }
            if !self.state.touched.hit_segments.is_empty() {
                self.state.mesh.set_back();
                let limit = self.limits.get(&item).copied();
                return self.defer(item, limit, work);
            }
            if let Some(change) = self.state.plan(f, &p, Seed::At(corners))
                && change.removed.contains(&corners)
            {
                self.insert(&place, None, &[change], work);
                return Step::Inserted;
            }
            self.state.mesh.set_back();
        }
        Step::Refused(reason.unwrap_or(Reason::Rounding))
    }

    /// Rule 3: a tetrahedron is split near its circumcentre, unless that encroaches a subsegment or
    /// a subface.
    fn split_tet<W: Work, A: Admission>(
        &mut self,
        t: TetId,
        v: [VertexId; 4],
        work: &mut W,
        admission: &mut A,
    ) -> Step {
        if !self.state.is_live(t, v) {
            return Step::Gone;
        }
        let item = Item::Tet(t, v);
        let [a, b, c, d] = v.map(|v| self.state.at(v));
        let shape = Shape::of([&a, &b, &c, &d]);
        let mut reason = self.state.reason_near(v);
        let Some(centre) = shape.circumcentre(&d) else {
            return Step::Refused(reason);
        };
        let radius = shape.radius();
        if radius < self.floor {
            return Step::Refused(Reason::Floor);
        }
        for tolerance in [radius * TOLERANCE, 1.0] {
            let Some(p) = free_point(&centre, tolerance) else { continue };
            let place = Place { p, carrier: Carrier::Free, from: t };
            match self.open(&place, admission) {
                Ok(()) => {}
                Err(Step::Refused(_)) => continue,
                Err(step) => return step,
            }
            let touched = &self.state.touched;
            if !touched.hit_segments.is_empty() || !touched.hit_subfaces.is_empty() {
                self.state.mesh.set_back();
                let limit = self.bounds.as_ref().map(|b| b.grain(&self.state, t, &shape));
                return self.defer(item, limit, work);
            }
            let kills = self.state.mesh.topology().at(t).is_marked();
            if kills && touched.inner.is_empty() {
                self.insert(&place, None, &[], work);
                return Step::Inserted;
            }
            // The cavity reaches across a facet near a small angle.
            let mut crossed = touched.inner.iter();
            let known = crossed.find_map(|(_, f)| self.state.angles.facet_reason.get(f));
            reason = known.copied().unwrap_or(reason);
            self.state.mesh.set_back();
        }
        Step::Refused(reason)
    }

    /// Opens the cavity of a place and looks at the boundary in it.
    fn open<A: Admission>(&mut self, place: &Place, admission: &mut A) -> Result<(), Step> {
        match self.state.mesh.open(place.p, place.from, admission) {
            Ok(None) => {}
            // There is a vertex already: the point fell together with it.
            Ok(Some(_)) => return Err(Step::Refused(Reason::Rounding)),
            Err(setback) => return Err(Step::SetBack(setback)),
        }
        self.state.touch(&place.p, place.carrier);
        Ok(())
    }

    /// Would the point of the open cavity make an edge shorter than what `item` is limited to?
    /// The vertex nearest to a new point is always on the rim of its cavity.
    fn is_too_near(&self, item: Item, p: &Point) -> bool {
        let Some(&limit) = self.limits.get(&item) else { return false };
        let mut rim = self.state.mesh.cavity().walls().flat_map(|(v, _)| v);
        rim.any(|v| v != INFINITE && distance2(&self.state.at(v), p) < limit * limit)
    }

    /// Puts the item that the last proposed point encroached before `item`, which waits. Near small
    /// angles, splitting it may make no edge shorter than `limit`.
    ///
    /// If that item was refused, so is this one, for the same reason, unless it allows shorter edges
    /// than before.
    fn defer<W: Work>(&mut self, item: Item, limit: Option<f64>, work: &mut W) -> Step {
        let touched = &self.state.touched;
        let segments = touched.hit_segments.iter().map(|&s| Item::Segment(s));
        let subfaces = touched.hit_subfaces.iter().map(|&s| Item::Subface(s));
        let all: Vec<Item> = match touched.hit_segments.is_empty() {
            true => subfaces.collect(),
            false => segments.collect(),
        };
        let mut reason = match item {
            Item::Tet(_, v) => self.state.reason_near(v),
            _ => Reason::Rounding,
        };
        for first in all {
            if let Some(refusal) = self.refused.get(&first) {
                let again = limit.zip(refusal.limit).is_some_and(|(new, old)| new < 0.99 * old);
                if !again {
                    if refusal.reason != Reason::Rounding {
                        reason = refusal.reason;
                    }
                    continue;
                }
                self.refused.remove(&first);
            }
            if let Some(limit) = limit {
                self.limits.insert(first, limit);
            }
            self.state.pend(first, work);
            work.put_back(item);
            return Step::Deferred;
        }
        Step::Refused(reason)
    }

    /// Fills the open cavity and brings marks, tables and work up to date.
    fn insert<W: Work>(
        &mut self,
        place: &Place,
        split: Option<([VertexId; 2], u32)>,
        changes: &[Change],
        work: &mut W,
    ) {
        let state = &mut self.state;
        state.marks.gather(&state.mesh);
        let p = state.mesh.fill(place.p, self.next_number);
        self.next_number += 1;
        state.carriers.push(place.carrier);
        state.marks.pass_on(&state.mesh);
        self.created.clear();
        self.created.extend_from_slice(state.mesh.cavity().star().tets);
        let on_boundary = place.carrier != Carrier::Free;
        if on_boundary || !state.touched.edges.is_empty() || !state.touched.inner.is_empty() {
            self.update_boundary(p, split, changes, work);
        }
        let uncertain = !self.state.missing.is_empty() || !self.dirty.is_empty();
        if let Some(bounds) = &self.bounds {
            for &t in &self.created {
                let v = self.state.vertices(t);
                if v[3] == INFINITE {
                    continue;
                }
                // What replaces tetrahedra of uncertain region is uncertain, too, even when it
                // brings the last missing subface back.
                if uncertain {
                    self.dirty.push((t, v));
                } else if let Some(weight) = bounds.excess(&self.state, t) {
                    work.put(Item::Tet(t, v), weight);
                }
            }
        }
    }

    /// After the filling: old boundary items that are lost or encroached, and the new ones.
    fn update_boundary<W: Work>(
        &mut self,
        p: VertexId,
        split: Option<([VertexId; 2], u32)>,
        changes: &[Change],
        work: &mut W,
    ) {
        if let Some((ends, _)) = split {
            self.state.segments.remove(&ends);
        }
        for change in changes {
            for s in &change.removed {
                self.state.subfaces.remove(s);
                self.state.missing.remove(s);
                self.state.registry.remove(Item::Subface(*s));
            }
        }
        let touched = std::mem::take(&mut self.state.touched);
        // Subfaces inside the cavity that stay in their facet's triangulation are lost.
        for (s, _) in &touched.inner {
            if self.state.subfaces.contains_key(s) {
                self.lift_limit(Item::Subface(*s));
                self.state.miss(*s, work);
            }
        }
        let walls: Vec<[VertexId; 3]> = self.state.mesh.cavity().walls().map(|w| w.0).collect();
        for s in &touched.edges {
            let stays = walls.iter().any(|w| w.contains(&s[0]) && w.contains(&s[1]));
            if !stays && self.state.segments.contains_key(s) {
                self.lift_limit(Item::Segment(*s));
                self.state.pend(Item::Segment(*s), work);
            }
        }
        for s in &touched.hit_segments {
            if self.state.segments.contains_key(s) {
                self.state.pend(Item::Segment(*s), work);
            }
        }
        for s in &touched.hit_subfaces {
            if self.state.subfaces.contains_key(s) {
                self.state.pend(Item::Subface(*s), work);
            }
        }
        self.state.touched = touched;
        if let Some((ends, s)) = split {
            for end in ends {
                self.add_segment([end, p], s, work);
            }
        }
        for change in changes {
            for &[a, b] in &change.rim {
                self.add_subface([p, a, b], change.facet, work);
            }
        }
    }

    /// A lost item has to be split, whatever a proposal was limited to when it was there.
    fn lift_limit(&mut self, item: Item) {
        self.limits.remove(&item);
        if self.refused.get(&item).is_some_and(|refusal| refusal.limit.is_some()) {
            self.refused.remove(&item);
        }
    }

    /// Enters the subsegment from the new vertex `p` to `a`; marks it if the star has it.
    fn add_segment<W: Work>(&mut self, [a, p]: [VertexId; 2], s: u32, work: &mut W) {
        let key = edge(a, p);
        self.state.segments.insert(key, s);
        let (mut present, mut encroached) = (false, false);
        for &t in &self.created {
            let v = self.state.vertices(t);
            let Some(slot) = (1..4).find(|&k| v[k] == a) else { continue };
            present = true;
            self.state.marks.set(t, edge_bit(0, slot));
            encroached |= v.iter().any(|&w| self.state.vertex_encroaches_segment(key, s, w));
        }
        if !present || encroached {
            self.state.pend(Item::Segment(key), work);
        }
    }

    /// Enters the subface from the new vertex `p` to the edge `ab`; marks it if the star has it.
    fn add_subface<W: Work>(&mut self, [p, a, b]: [VertexId; 3], f: u32, work: &mut W) {
        let key = triangle(p, a, b);
        self.state.subfaces.insert(key, f);
        let (mut present, mut encroached) = (false, false);
        for &t in &self.created {
            let v = self.state.vertices(t);
            let (Some(i), Some(j)) = ((1..4).find(|&k| v[k] == a), (1..4).find(|&k| v[k] == b))
            else {
                continue;
            };
            let apex = 6 - i - j;
            present = true;
            self.state.marks.set(t, face_bit(apex));
            encroached |= self.state.vertex_encroaches_subface(key, f, v[apex]);
        }
        if !present {
            self.state.miss(key, work);
        } else if encroached {
            self.state.pend(Item::Subface(key), work);
        }
    }
}

impl State {
    /// The parameter at which a subsegment of segment `s` is split: its middle, or, at a corner
    /// where another segment leaves at a small angle, a distance from it that is a power of two, so
    /// that the points of both are equally far from the corner. `None` if it is too short.
    fn split_parameter(&self, ends: [VertexId; 2], s: u32) -> Option<i64> {
        let [mut low, mut high] = ends.map(|v| self.parameter(v, s));
        let sharp = ends.map(|v| self.is_sharp(v, s));
        let flip = low > high;
        if flip {
            std::mem::swap(&mut low, &mut high);
        }
        let (sharp_low, sharp_high) =
            if flip { (sharp[1], sharp[0]) } else { (sharp[0], sharp[1]) };
        if sharp_low == sharp_high {
            return Line::middle(low, high);
        }
        let pace = self.plc.segments[s as usize].line.pace();
        let length = (high - low) as f64 * pace;
        // The power of two between a third and two thirds of the length.
        let third = length / 3.0;
        let mut shell = f64::from_bits(third.to_bits() & 0x7ff0_0000_0000_0000);
        while shell < third {
            shell *= 2.0;
        }
        let steps = shell / pace;
        let t = if sharp_low { low as f64 + steps } else { high as f64 - steps };
        Line::near(t, 1.0, low, high)
    }

    /// The small angle that a tetrahedron is at, if any of its vertices is on something at one.
    fn reason_near(&self, v: [VertexId; 4]) -> Reason {
        let facets = |f: &u32| self.angles.facet_reason.get(f);
        let reasons = v.into_iter().find_map(|v| match self.carriers[v as usize] {
            Carrier::Segment(s, _) => self.angles.segment_reason.get(&s),
            Carrier::Corner(c) => self.plc.facets_at[c as usize].iter().find_map(facets),
            Carrier::Facet(f) => facets(&f),
            Carrier::Free => None,
        });
        reasons.copied().unwrap_or(Reason::Rounding)
    }

    /// Does vertex `v` of segment `s` lie at a corner where another segment leaves at less than 60°?
    fn is_sharp(&self, v: VertexId, s: u32) -> bool {
        let Carrier::Corner(c) = self.carriers[v as usize] else { return false };
        let mine = direction(&self.plc, s, c);
        let others = self.plc.segments_at[c as usize].iter().filter(|&&other| other != s);
        others.into_iter().any(|&other| is_sharp(&mine, &direction(&self.plc, other, c)))
    }
}
