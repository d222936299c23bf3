//! The three rules, each a transaction on one cavity: split a subsegment, a subface, a tetrahedron.
//!
//! A transaction is idempotent: if its item is gone it does nothing. It decides on the closure of
//! its point and the registry alone. It ends with the point inserted; or with nothing changed and
//! other items put before it (*deferred*); or with a reason why its item cannot be split.

use super::bounds::Bounds;
use super::carrier::{Carrier, Line, distance2, dot, free_point, minus};
use super::facet::{Change, Seed};
use super::item::{Item, Work};
use super::marks::{edge_bit, face_bit};
use super::measure::{Shape, circumcircle};
use super::outcome::Reason;
use super::state::State;
use super::table::{Map, edge, triangle};
use crate::Point;
use crate::cavity::{Admission, Setback};
use crate::topology::{INFINITE, TetId, VertexId};

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
    pub(crate) refused: Map<Item, Reason>,
    /// Tetrahedra made while a subface was missing: their region is not certain.
    pub(crate) dirty: Vec<(TetId, [VertexId; 4])>,
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
                self.refused.insert(item, reason);
                // A refused item no longer waits; only a missing one keeps its place.
                if !matches!(item, Item::Subface(s) if self.state.missing.contains(&s)) {
                    self.state.registry.remove(item);
                }
            }
            Step::Inserted | Step::Gone if !matches!(item, Item::Tet(..)) => {
                self.state.registry.remove(item);
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
        if let Some(&reason) = self.refused.get(&item) {
            return Step::Refused(reason);
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
        let mut changes = Vec::new();
        for f in self.state.facets_of(place.carrier) {
            match self.state.plan(f, &p, Seed::Along(ends)) {
                Some(change) => changes.push(change),
                None => {
                    self.state.mesh.set_back();
                    return Step::Refused(Reason::Rounding);
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
        if let Some(&reason) = self.refused.get(&item) {
            return Step::Refused(reason);
        }
        let [a, b, c] = corners.map(|v| self.state.at(v));
        let (centre, square) = circumcircle(&a, &b, &c);
        if square < self.floor * self.floor {
            return Step::Refused(Reason::Floor);
        }
        for tolerance in [square.sqrt() * TOLERANCE, 1.0] {
            let plane = self.state.plc.facets[f as usize].plane;
            let Some(p) = plane.near(&centre, tolerance) else { continue };
            let place = Place { p, carrier: Carrier::Facet(f), from: self.state.mesh.hint() };
            match self.open(&place, admission) {
                Ok(()) => {}
                Err(Step::Refused(_)) => continue,
                Err(step) => return step,
            }
            if !self.state.touched.hit_segments.is_empty() {
                self.state.mesh.set_back();
                return self.defer(item, work);
            }
            if let Some(change) = self.state.plan(f, &p, Seed::At(corners))
                && change.removed.contains(&corners)
            {
                self.insert(&place, None, &[change], work);
                return Step::Inserted;
            }
            self.state.mesh.set_back();
        }
        Step::Refused(Reason::Rounding)
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
        let Some(centre) = shape.circumcentre(&d) else {
            return Step::Refused(Reason::Rounding);
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
                return self.defer(item, work);
            }
            let kills = self.state.mesh.topology().tet(t).is_marked();
            if kills && touched.inner.is_empty() {
                self.insert(&place, None, &[], work);
                return Step::Inserted;
            }
            self.state.mesh.set_back();
        }
        Step::Refused(Reason::Rounding)
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

    /// Puts the item that the last proposed point encroached before `item`, which waits.
    ///
    /// If that item was refused, so is this one, for the same reason.
    fn defer<W: Work>(&mut self, item: Item, work: &mut W) -> Step {
        let touched = &self.state.touched;
        let segments = touched.hit_segments.iter().map(|&s| Item::Segment(s));
        let subfaces = touched.hit_subfaces.iter().map(|&s| Item::Subface(s));
        let all: Vec<Item> = match touched.hit_segments.is_empty() {
            true => subfaces.collect(),
            false => segments.collect(),
        };
        let mut reason = Reason::Rounding;
        for first in all {
            match self.refused.get(&first) {
                Some(&why) => reason = why,
                None => {
                    self.state.pend(first, work);
                    work.put_back(item);
                    return Step::Deferred;
                }
            }
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
        if let Some(bounds) = &self.bounds {
            for &t in &self.created {
                let v = self.state.vertices(t);
                if v[3] == INFINITE {
                    continue;
                }
                if !self.state.missing.is_empty() {
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
                self.state.miss(*s, work);
            }
        }
        let walls: Vec<[VertexId; 3]> = self.state.mesh.cavity().walls().map(|w| w.0).collect();
        for s in &touched.edges {
            let stays = walls.iter().any(|w| w.contains(&s[0]) && w.contains(&s[1]));
            if !stays && self.state.segments.contains_key(s) {
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
            encroached |= v.iter().any(|&w| self.state.vertex_encroaches_segment(key, w));
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
            let (Some(i), Some(j)) =
                ((1..4).find(|&k| v[k] == a), (1..4).find(|&k| v[k] == b))
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
        let (sharp_low, sharp_high) = if flip { (sharp[1], sharp[0]) } else { (sharp[0], sharp[1]) };
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

    /// Does vertex `v` of segment `s` lie at a corner where another segment leaves at less than 60°?
    fn is_sharp(&self, v: VertexId, s: u32) -> bool {
        let Carrier::Corner(c) = self.carriers[v as usize] else { return false };
        let from = self.plc.corners[c as usize];
        let direction = |s: u32| {
            let segment = &self.plc.segments[s as usize];
            let far = segment.ends[usize::from(segment.ends[0] == c)];
            let d = self.plc.corners[far as usize];
            minus(&d.map(|x| x as f64), &from.map(|x| x as f64))
        };
        let mine = direction(s);
        self.plc.segments_at[c as usize].iter().any(|&other| {
            if other == s {
                return false;
            }
            let theirs = direction(other);
            let product = dot(&mine, &theirs);
            // cos² > 1/4; 60° itself is in order.
            let limit = 0.25 * (1.0 + 1e-9) * dot(&mine, &mine) * dot(&theirs, &theirs);
            product > 0.0 && product * product > limit
        })
    }
}
