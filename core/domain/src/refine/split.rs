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
use super::state::{FACE, State};
use super::table::{Map, edge, triangle};
use super::walk::Way;
use ltbw_core::cavity::{Admission, Setback};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;

/// A point may be this part of the radius away from the ideal one.
const TOLERANCE: f64 = 1.0 / 1000.0;

/// The end of a transaction.
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

    /// May a proposal that allows edges down to `limit` try again?
    fn allows(&self, limit: Option<f64>) -> bool {
        limit.zip(self.limit).is_some_and(|(new, old)| new < 0.99 * old)
    }
}

/// Where to insert a point.
struct Place {
    p: Point,
    carrier: Carrier,
    /// Where the walk starts.
    from: TetId,
}

/// Points inserted, by what they are on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Points {
    pub(crate) segments: u64,
    pub(crate) facets: u64,
    pub(crate) free: u64,
}

impl Points {
    fn count(&mut self, carrier: Carrier) {
        match carrier {
            Carrier::Segment(..) => self.segments += 1,
            Carrier::Facet(_) => self.facets += 1,
            Carrier::Free | Carrier::Corner(_) => self.free += 1,
        }
    }

    pub(crate) fn total(self) -> u64 {
        self.segments + self.facets + self.free
    }
}

/// The refinement: state, bounds, and what was refused.
pub(crate) struct Refinement<'a> {
    pub(crate) state: State,
    /// `None` while the boundary is recovered: no tetrahedron is looked at then.
    pub(crate) bounds: Option<Bounds<'a>>,
    pub(crate) refused: Map<Item, Refusal>,
    /// Proposed items near small angles: the shortest edge that splitting them may make.
    limits: Map<Item, f64>,
    /// Boundary items that wait for another one, since the last insertion.
    pub(crate) waits: Map<Item, Item>,
    /// Points inserted.
    pub(crate) points: Points,
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
            limits: Map::default(),
            waits: Map::default(),
            points: Points::default(),
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
        let step = self.rule(item, work, admission);
        match step {
            Step::Refused(reason) => {
                let limit = self.limits.remove(&item);
                self.refused.insert(item, Refusal { reason, limit });
                // A refused item no longer waits; only a missing one keeps its place.
                let missing = match item {
                    Item::Segment(s) => self.state.missing_segments.contains(&s),
                    Item::Subface(s) => self.state.missing.contains(&s),
                    Item::Tet(..) => false,
                };
                if !missing {
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

    /// The rule for an item, whatever came of it before.
    pub(crate) fn rule<W: Work, A: Admission>(
        &mut self,
        item: Item,
        work: &mut W,
        admission: &mut A,
    ) -> Step {
        match item {
            Item::Segment(s) => self.split_segment(s, work, admission),
            Item::Subface(s) => self.split_subface(s, work, admission),
            Item::Tet(t, v) => self.split_tet(t, v, work, admission),
        }
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
        let lost = self.state.losses(Some(ends), &changes);
        if let Some(step) = self.spare(item, place.carrier, &lost, work, admission) {
            return step;
        }
        self.insert(&place, Some((ends, s)), &changes, &lost, work);
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
                let first = self.state.touched.hits();
                return self.defer(item, first, limit, work, admission);
            }
            if let Some(change) = self.state.plan(f, &p, Seed::At(corners))
                && change.removed.contains(&corners)
            {
                let changes = [change];
                let lost = self.state.losses(None, &changes);
                if let Some(step) = self.spare(item, place.carrier, &lost, work, admission) {
                    return step;
                }
                self.insert(&place, None, &changes, &lost, work);
                return Step::Inserted;
            }
            let between = self.state.segment_between(corners, f, &p);
            self.state.mesh.set_back();
            if let Some(segment) = between {
                let limit = self.limits.get(&item).copied();
                return self.defer(item, vec![Item::Segment(segment)], limit, work, admission);
            }
        }
        Step::Refused(reason.unwrap_or(Reason::Rounding))
    }

    /// Rule 3: a tetrahedron is split near its circumcentre, unless a subface is on the way there,
    /// or the point encroaches a subsegment or subface or would take one out of the mesh.
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
        let reason = self.state.reason_near(v);
        let radius = shape.radius();
        if radius < self.floor {
            return Step::Refused(Reason::Floor);
        }
        for tolerance in [radius * TOLERANCE, 1.0] {
            let Some(centre) = shape.circumcentre(&d) else { break };
            // A flat tetrahedron may have its centre outside the box: the way there still counts.
            let proposed = free_point(&centre, tolerance);
            let p = proposed.unwrap_or(centre);
            let grain = |own: &Self| own.bounds.as_ref().map(|b| b.grain(&own.state, t, &shape));
            let from = match self.state.way(t, &p) {
                Way::Arrived(from) if proposed.is_some() => from,
                Way::Blocked(subface) => {
                    let limit = grain(self);
                    return self.defer(item, vec![Item::Subface(subface)], limit, work, admission);
                }
                Way::Arrived(_) | Way::Outside => continue,
            };
            let place = Place { p, carrier: Carrier::Free, from };
            match self.open(&place, admission) {
                Ok(()) => {}
                Err(Step::Refused(_)) => continue,
                Err(step) => return step,
            }
            let mut first = self.state.touched.hits();
            if first.is_empty() {
                first = self.state.losses(None, &[]);
            }
            let kills = self.state.mesh.topology().at(t).is_marked();
            if kills && first.is_empty() {
                self.insert(&place, None, &[], &[], work);
                return Step::Inserted;
            }
            self.state.mesh.set_back();
            if !first.is_empty() {
                let limit = grain(self);
                return self.defer(item, first, limit, work, admission);
            }
        }
        // Of a tetrahedron that is flat but for rounding, a side on the boundary is split.
        let word = self.state.marks.of(t);
        let sides = (0..4).filter(|&slot| word & face_bit(slot) != 0).map(|slot| {
            let [a, b, c] = FACE[slot].map(|k| v[k]);
            Item::Subface(triangle(a, b, c))
        });
        let sides: Vec<Item> = sides.collect();
        if sides.is_empty() {
            return Step::Refused(reason);
        }
        let limit = self.bounds.as_ref().map(|b| b.grain(&self.state, t, &shape));
        self.defer(item, sides, limit, work, admission)
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

    /// Sets back a boundary point that would take out of the mesh what is not its own to split;
    /// `None` if there is no such thing, or while the boundary is recovered, when what is lost is
    /// split in its turn.
    ///
    /// Afterwards the boundary is complete, and stays so: what would be lost is split first, or,
    /// where that would take this item out of the mesh, with it. If it may not be split, or is at a
    /// small angle with the point's own carrier, the point is refused.
    fn spare<W: Work, A: Admission>(
        &mut self,
        item: Item,
        carrier: Carrier,
        lost: &[Item],
        work: &mut W,
        admission: &mut A,
    ) -> Option<Step> {
        if lost.is_empty() || self.bounds.is_none() {
            return None;
        }
        let related = lost.iter().find_map(|&other| self.state.relation(carrier, other));
        if related.is_none() && self.state.journal.is_some() {
            return None;
        }
        self.state.mesh.set_back();
        if let Some(reason) = related {
            return Some(Step::Refused(reason));
        }
        let limit = self.limits.get(&item).copied();
        for other in lost {
            if let Some(refusal) = self.refused.get(other).filter(|r| !r.allows(limit)) {
                return Some(Step::Refused(refusal.reason));
            }
        }
        Some(self.defer(item, lost.to_vec(), limit, work, admission))
    }

    /// Puts one of the items `all` before `item`, which waits for it. Near small angles, splitting
    /// it may make no edge shorter than `limit`.
    ///
    /// If all were refused, so is this one, for the same reason, unless it allows shorter edges
    /// than before. Items that wait for each other in a circle are split jointly.
    fn defer<W: Work, A: Admission>(
        &mut self,
        item: Item,
        all: Vec<Item>,
        limit: Option<f64>,
        work: &mut W,
        admission: &mut A,
    ) -> Step {
        let mut reason = match item {
            Item::Tet(_, v) => self.state.reason_near(v),
            _ => Reason::Rounding,
        };
        for first in all {
            if let Some(refusal) = self.refused.get(&first) {
                if !refusal.allows(limit) {
                    if refusal.reason != Reason::Rounding {
                        reason = refusal.reason;
                    }
                    continue;
                }
                self.refused.remove(&first);
            }
            if self.waits_for(first, item) {
                reason = Reason::Interlocked;
                if self.bounds.is_none() || self.state.journal.is_some() {
                    continue;
                }
                match self.split_jointly(first, work, admission) {
                    Step::Refused(why) => {
                        self.refused.insert(first, Refusal::final_for(why));
                        continue;
                    }
                    Step::SetBack(setback) => return Step::SetBack(setback),
                    _ => {
                        work.put(item, 1.0);
                        return Step::Deferred;
                    }
                }
            }
            if !matches!(item, Item::Tet(..)) {
                self.waits.insert(item, first);
            }
            if let Some(limit) = limit {
                self.limits.insert(first, limit);
            }
            self.state.enter(first);
            work.put_behind(item, first);
            return Step::Deferred;
        }
        Step::Refused(reason)
    }

    /// Does `first` wait for `item`, or for something that does?
    fn waits_for(&self, first: Item, item: Item) -> bool {
        let mut next = first;
        // No circle is ever closed, so no item is passed twice.
        for _ in 0..=self.waits.len() {
            if next == item {
                return true;
            }
            let Some(&then) = self.waits.get(&next) else { return false };
            next = then;
        }
        true
    }

    /// Fills the open cavity and brings marks, tables and work up to date.
    fn insert<W: Work>(
        &mut self,
        place: &Place,
        split: Option<([VertexId; 2], u32)>,
        changes: &[Change],
        lost: &[Item],
        work: &mut W,
    ) {
        self.waits.clear();
        let state = &mut self.state;
        state.marks.gather(&state.mesh);
        let p = match &mut state.journal {
            None => state.mesh.fill(place.p, self.next_number),
            Some(journal) => {
                let (p, undo) = state.mesh.fill_for_now(place.p, self.next_number);
                let words = undo.cavity().map(|t| state.marks.of(t)).collect();
                journal.insertions.push((undo, words));
                p
            }
        };
        self.next_number += 1;
        self.points.count(place.carrier);
        state.carriers.push(place.carrier);
        state.marks.pass_on(&state.mesh);
        self.created.clear();
        self.created.extend_from_slice(state.mesh.cavity().star().tets);
        let on_boundary = place.carrier != Carrier::Free;
        if on_boundary {
            self.update_boundary(p, split, changes, lost, work);
        }
        if let Some(bounds) = &self.bounds {
            for &t in &self.created {
                let v = self.state.vertices(t);
                if v[3] == INFINITE {
                    continue;
                }
                if let Some(journal) = &mut self.state.journal {
                    journal.created.push((t, v));
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
        lost: &[Item],
        work: &mut W,
    ) {
        if let Some((ends, _)) = split {
            self.state.remove_segment(ends);
        }
        for s in changes.iter().flat_map(|change| &change.removed) {
            self.state.remove_subface(*s);
        }
        for item in lost {
            self.state.miss(*item, work);
        }
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

    /// Enters the subsegment from the new vertex `p` to `a`; marks it if the star has it.
    fn add_segment<W: Work>(&mut self, [a, p]: [VertexId; 2], s: u32, work: &mut W) {
        let key = edge(a, p);
        self.state.add_segment(key, s);
        let mut present = false;
        for &t in &self.created {
            let v = self.state.vertices(t);
            let Some(slot) = (1..4).find(|&k| v[k] == a) else { continue };
            present = true;
            self.state.marks.set(t, edge_bit(0, slot));
        }
        if !present {
            self.state.miss(Item::Segment(key), work);
        }
    }

    /// Enters the subface from the new vertex `p` to the edge `ab`; marks it if the star has it.
    fn add_subface<W: Work>(&mut self, [p, a, b]: [VertexId; 3], f: u32, work: &mut W) {
        let key = triangle(p, a, b);
        self.state.add_subface(key, f);
        let mut present = false;
        for &t in &self.created {
            let v = self.state.vertices(t);
            let (Some(i), Some(j)) = ((1..4).find(|&k| v[k] == a), (1..4).find(|&k| v[k] == b))
            else {
                continue;
            };
            present = true;
            self.state.marks.set(t, face_bit(6 - i - j));
        }
        if !present {
            self.state.miss(Item::Subface(key), work);
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

    /// Does vertex `v` of segment `s` lie at a corner where another segment leaves at less than
    /// 60°?
    fn is_sharp(&self, v: VertexId, s: u32) -> bool {
        let Carrier::Corner(c) = self.carriers[v as usize] else { return false };
        let mine = direction(&self.plc, s, c);
        let others = self.plc.segments_at[c as usize].iter().filter(|&&other| other != s);
        others.into_iter().any(|&other| is_sharp(&mine, &direction(&self.plc, other, c)))
    }
}
