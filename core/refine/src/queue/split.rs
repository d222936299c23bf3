//! The three rules, each a transaction on one cavity: split a subsegment, a subface, a tetrahedron.
//!
//! A transaction is idempotent: if its item is gone it does nothing. It opens the cavity of a
//! proposed point, takes the verdict on it (`verdict`: by the closure of the point and the
//! encroachment index alone), and ends with the point inserted; or with nothing changed and other
//! items put before it (*deferred*); or with a reason why its item cannot be split.

use crate::complex::carrier::Carrier;
use crate::complex::measure::Shape;
use crate::fill::Inserted;
use crate::mesh::bounds::Bounds;
use crate::mesh::item::{Item, Queues};
use crate::mesh::key::{order_key, sorted};
use crate::mesh::state::{Place, State};
use crate::outcome::Reason;
use crate::patches::layer::Hole;
use crate::rules::aim::{ATTEMPTS, Aim, Aims, Circle};
use crate::rules::record::{Record, Refusal};
use crate::rules::verdict::{Judge, Verdict};
use crate::rules::walk::Way;
use ltbw_core::cavity::Setback;
use ltbw_core::mesh::At;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_exact::Point;

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
    /// The mesh is full.
    SetBack(Setback),
}

/// The end of one proposal for an item.
pub(crate) enum Proposal {
    Inserted,
    Deferred(Vec<Item>),
    Refused(Reason),
    /// The point did not serve.
    Useless,
    SetBack(Setback),
}

/// The ends of proposals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends {
    /// Shortest edge that may be made, in fine steps.
    pub(crate) floor: f64,
    /// The most transactions of a joint step, if they are fewer than usual.
    pub(crate) joint_most: usize,
    /// The sweeps in which vertices inside are moved in the end.
    pub(crate) sweeps: u32,
}

/// The refinement: state, bounds, and what came of earlier proposals.
pub(crate) struct Refinement<'a> {
    pub(crate) state: State,
    /// `None` while the boundary is recovered: no tetrahedron is looked at then.
    pub(crate) bounds: Option<Bounds<'a>>,
    pub(crate) record: Record,
    pub(crate) inserted: Inserted,
    /// The ends of proposals.
    pub(crate) floor: f64,
    pub(crate) joint_most: usize,
    /// The sweeps in which vertices inside are moved in the end.
    pub(crate) sweeps: u32,
}

impl<'a> Refinement<'a> {
    pub(crate) fn new(state: State, next_number: u32, ends: Ends) -> Self {
        let (inserted, Ends { floor, joint_most, .. }) = (Inserted::from(next_number), ends);
        let record = Record::default();
        Self { state, bounds: None, record, inserted, floor, joint_most, sweeps: ends.sweeps }
    }

    /// The ground of aims.
    pub(crate) fn aims(&self) -> Aims<'_> {
        Aims { plc: &self.state.plc, floor: self.floor }
    }

    /// The aim for a boundary item, by the coordinates of its corners; `None` if it is gone.
    pub(crate) fn aim_at(&self, item: Item, attempt: usize) -> Option<Aim> {
        self.aim_on(self.aims(), item, attempt)
    }

    /// The aim for a boundary item on this ground.
    pub(crate) fn aim_on(&self, aims: Aims<'_>, item: Item, attempt: usize) -> Option<Aim> {
        let state = &self.state;
        match item {
            Item::Segment(ends) => {
                let ends_at = ends.map(|v| state.corner(v));
                state.segments.get(&ends).map(|&s| aims.subsegment(s, ends_at, attempt))
            }
            Item::Subface(corners) => {
                let points = sorted(corners.map(|v| state.at(v)));
                state.subfaces.get(&corners).map(|&f| aims.subface(f, points, attempt))
            }
            Item::Tet(..) => None,
        }
    }

    /// Carries out the rule for an item.
    pub(crate) fn split(&mut self, item: Item, work: &mut Queues) -> Step {
        let step = self.rule(item, work);
        match step {
            Step::Refused(reason) => {
                let limit = self.record.limits.remove(&item);
                self.record.refused.insert(item, Refusal { reason, limit });
                // A refused item no longer waits; only a missing one keeps its place.
                let missing = match item {
                    Item::Segment(s) => self.state.missing_segments.contains(&s),
                    Item::Subface(s) => self.state.missing.contains(&s),
                    Item::Tet(..) => false,
                };
                if !missing {
                    self.state.encroachment.remove(item);
                }
            }
            Step::Inserted | Step::Gone if !matches!(item, Item::Tet(..)) => {
                self.state.encroachment.remove(item);
                self.record.limits.remove(&item);
            }
            _ => {}
        }
        step
    }

    /// The rule for an item, whatever came of it before.
    pub(crate) fn rule(&mut self, item: Item, work: &mut Queues) -> Step {
        match item {
            Item::Segment(s) => self.split_segment(s, work),
            Item::Subface(s) => self.split_subface(s, work),
            Item::Tet(t, v) => self.split_tet(t, v, work),
        }
    }

    /// The reason why a boundary item was refused. A joint step of the rounds that allows shorter
    /// edges than the proposal that was refused may try again.
    fn bars(&self, item: &Item) -> Option<Reason> {
        let limit = self.state.joint_limit().filter(|_| self.state.by_place);
        self.record.bars(item, limit)
    }

    /// Rule 1: a subsegment is split near its middle.
    fn split_segment(&mut self, ends: [VertexId; 2], work: &mut Queues) -> Step {
        let item = Item::Segment(ends);
        let Some(&s) = self.state.segments.get(&ends) else { return Step::Gone };
        if let Some(reason) = self.bars(&item) {
            return Step::Refused(reason);
        }
        let Some(Aim::At { point: p, carrier, .. }) = self.aim_at(item, 0) else {
            return Step::Refused(Reason::Floor);
        };
        let place = Place { p, carrier, from: self.state.mesh.hint() };
        match self.propose(&place, work, |judge| judge.on_segment(ends, s, &place)) {
            Proposal::Inserted => Step::Inserted,
            Proposal::Deferred(first) => {
                let limit = self.record.limits.get(&item).copied();
                self.defer(item, first, limit, work)
            }
            Proposal::Refused(reason) => Step::Refused(reason),
            Proposal::Useless => Step::Refused(self.state.unserved(item)),
            Proposal::SetBack(setback) => Step::SetBack(setback),
        }
    }

    /// Rule 2: a subface is split near its circumcentre, unless that encroaches a subsegment.
    fn split_subface(&mut self, corners: [VertexId; 3], work: &mut Queues) -> Step {
        let item = Item::Subface(corners);
        let Some(&f) = self.state.subfaces.get(&corners) else { return Step::Gone };
        if let Some(reason) = self.bars(&item) {
            return Step::Refused(reason);
        }
        let mut points = corners.map(|v| self.state.at(v));
        // At the start the order of the vertices is that of the mesh, which is the same each time.
        if self.state.by_place {
            points = sorted(points);
        }
        let circle = Circle::of(&points);
        if self.aims().is_below(circle.square) {
            return Step::Refused(Reason::Floor);
        }
        let across = self.state.turned(corners, f).or_else(|| self.state.opposite(corners, f));
        if let Some(step) = self.split_subface_at(corners, f, across, work) {
            return step;
        }
        for attempt in 0..ATTEMPTS {
            let aim = self.aims().triangle(f, points, circle, attempt);
            let Aim::At { point: p, carrier, may: is_on } = aim else { continue };
            let place = Place { p, carrier, from: self.state.mesh.hint() };
            let verdict = |judge: Judge<'_>| judge.on_subface(corners, f, &place, is_on);
            match self.propose(&place, work, verdict) {
                Proposal::Inserted => return Step::Inserted,
                Proposal::Deferred(first) => {
                    let arc = self.bounds.is_none().then(|| self.state.arc(corners, f, &first));
                    let arc = arc.flatten();
                    if let Some(step) = self.split_subface_at(corners, f, arc, work) {
                        return step;
                    }
                    let limit = self.record.limits.get(&item).copied();
                    return self.defer(item, first, limit, work);
                }
                Proposal::Refused(reason) => return Step::Refused(reason),
                Proposal::Useless => {}
                Proposal::SetBack(setback) => return Step::SetBack(setback),
            }
        }
        let reason = self.state.angles.reason_of_facet(f);
        Step::Refused(reason.unwrap_or_else(|| self.state.unserved(item)))
    }

    /// Splits a subface at a place other than its circumcentre, if there is one and it serves.
    fn split_subface_at(
        &mut self,
        corners: [VertexId; 3],
        f: u32,
        place: Option<Place>,
        work: &mut Queues,
    ) -> Option<Step> {
        let place = place?;
        let verdict = |judge: Judge<'_>| judge.on_subface(corners, f, &place, true);
        match self.propose(&place, work, verdict) {
            Proposal::Inserted => Some(Step::Inserted),
            Proposal::SetBack(setback) => Some(Step::SetBack(setback)),
            _ => None,
        }
    }

    /// Rule 2 for a triangle that a patch lacks, while the boundary is recovered: inserts a point
    /// near its centre, or splits the subsegment that is in the way.
    pub(crate) fn fill_hole(&mut self, hole: &Hole, work: &mut Queues) -> Step {
        if let Some(segment) = hole.between {
            return self.split(Item::Segment(segment), work);
        }
        let corners = hole.corners.map(|v| self.state.at(v));
        let circle = Circle { centre: hole.centre, square: hole.square() };
        for attempt in 0..ATTEMPTS {
            let (p, carrier, is_on) =
                match self.aims().triangle(hole.facet, corners, circle, attempt) {
                    Aim::At { point, carrier, may } => (point, carrier, may),
                    Aim::Refused => return Step::Refused(Reason::Floor),
                    Aim::Skip | Aim::Exhausted => continue,
                };
            let place = Place { p, carrier, from: self.state.mesh.hint() };
            match self.propose(&place, work, |judge| judge.on_hole(is_on)) {
                Proposal::Inserted => return Step::Inserted,
                Proposal::Deferred(first) => {
                    let Some(&first) = first.first() else { continue };
                    return self.split(first, work);
                }
                Proposal::Refused(reason) => return Step::Refused(reason),
                Proposal::Useless => {}
                Proposal::SetBack(setback) => return Step::SetBack(setback),
            }
        }
        Step::Refused(Reason::Rounding)
    }

    /// Rule 3: a tetrahedron is split near its circumcentre, unless a subface is on the way there,
    /// or the point encroaches a subsegment or subface or would take one out of the mesh.
    fn split_tet(&mut self, t: TetId, v: [VertexId; 4], work: &mut Queues) -> Step {
        if !self.state.is_live(t, v) {
            return Step::Gone;
        }
        let item = Item::Tet(t, v);
        let [a, b, c, d] = v.map(|v| self.state.at(v));
        let shape = Shape::of([&a, &b, &c, &d]);
        let (radius, centre) = (shape.radius(), shape.circumcentre(&d));
        if self.aims().is_short(radius) {
            return Step::Refused(Reason::Floor);
        }
        if let Some(reason) = self.beyond_help(t, v) {
            return Step::Refused(reason);
        }
        let part = self.record.parts.get(&item).copied().unwrap_or(1.0);
        let limit =
            |own: &Self| own.bounds.as_ref().map(|b| b.limit(&own.state, t, &shape).times(part));
        for attempt in 0..ATTEMPTS {
            let aim = self.aims().tet(radius, centre, attempt);
            let Aim::At { point: p, carrier, may } = aim else { break };
            let from = match self.state.way_to(t, &p, may) {
                Way::Arrived(from) => from,
                Way::Blocked(subface) => {
                    let limit = limit(self);
                    return self.defer(item, vec![Item::Subface(subface)], limit, work);
                }
                Way::Outside => continue,
            };
            let place = Place { p, carrier, from };
            match self.propose(&place, work, |judge| judge.on_tet(t, &place)) {
                Proposal::Inserted => return Step::Inserted,
                Proposal::Deferred(first) => {
                    let limit = limit(self);
                    return self.defer(item, first, limit, work);
                }
                Proposal::Refused(reason) => return Step::Refused(reason),
                Proposal::Useless => {}
                Proposal::SetBack(setback) => return Step::SetBack(setback),
            }
        }
        // Of a tetrahedron that is flat but for rounding, a side on the boundary is split.
        let sides = self.state.boundary_sides(t);
        if sides.is_empty() {
            return Step::Refused(self.state.reason_near(v));
        }
        let limit = limit(self);
        self.defer(item, sides, limit, work)
    }

    /// Opens the cavity of a place and fills it if that is the verdict; else all is as before.
    pub(crate) fn propose(
        &mut self,
        place: &Place,
        work: &mut Queues,
        verdict: impl FnOnce(Judge<'_>) -> Verdict,
    ) -> Proposal {
        let open = match self.state.begin_and_look(place) {
            Ok(open) => open,
            // The point fell together with a vertex.
            Err(At::Vertex(_)) => return Proposal::Useless,
            Err(At::SetBack(setback)) => return Proposal::SetBack(setback),
        };
        let recovers = self.bounds.is_none();
        let judge = Judge::on_open(open.owner(), &self.record);
        match verdict(Judge { recovers, ..judge }) {
            Verdict::Fill(filling) => {
                self.inserted.fill(open, place, &filling, self.bounds.as_ref(), work);
                self.record.waits.clear();
                Proposal::Inserted
            }
            Verdict::Defer(first) => Proposal::Deferred(first),
            Verdict::Refuse(reason) => Proposal::Refused(reason),
            Verdict::Useless => Proposal::Useless,
        }
    }
}

impl State {
    /// The place of a new point near `target` on facet `f`, if there is one.
    pub(crate) fn place_at(&self, f: u32, target: &Point, tolerance: f64) -> Option<Place> {
        let (p, is_on) = self.plc.place_on(f, target, tolerance)?;
        is_on.then(|| Place { p, carrier: Carrier::Facet(f), from: self.mesh.hint() })
    }

    /// The small angle that a tetrahedron is at, if any of its vertices is on something at one.
    pub(crate) fn reason_near(&self, mut v: [VertexId; 4]) -> Reason {
        if !self.angles.relates() {
            return Reason::Rounding;
        }
        if self.by_place {
            v.sort_by_key(|&v| order_key(&self.at(v)));
        }
        self.angles.reason_near(&self.plc, v.map(|v| self.carriers[v.index()]))
    }
}
