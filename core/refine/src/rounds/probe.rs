//! Probes: the cavity of a proposed point is opened, looked at and set back. A probe for a
//! tetrahedron runs to its end and writes its candidate into all slots of its cavity, unless it is
//! refused, so that the slots are a function of the mesh; of boundary items only those that are
//! taken write theirs.

use super::foremost::Foremost;
use super::{Asked, Candidate, Choice, Conclusion, Pending, Rounds};
use crate::complex::carrier::Carrier;
use crate::complex::measure::Shape;
use crate::mesh::item::Item;
use crate::mesh::limit::Limit;
use crate::mesh::state::Place;
use crate::outcome::Reason;
use crate::rules::aim::{ATTEMPTS, Aim};
use crate::rules::bounded::InMesh;
use crate::rules::verdict::{Filling, Judge, Verdict};
use crate::rules::walk::Way;
use ltbw_core::cavity::{AdmitAll, Role};
use ltbw_core::mesh::At;
use ltbw_core::topology::TetId;

/// The result of a probe.
pub(super) enum Probe {
    /// The point may be inserted.
    Fits,
    /// One taken before is in its way.
    Barred,
    Defers(Vec<Item>),
    Refuses(Reason),
    /// Another point may serve.
    Useless,
}

/// The result of an attempt for a tetrahedron, before a cavity is looked for.
pub(super) enum Approach {
    /// A point may be inserted here.
    At(Place),
    /// None at this attempt.
    Elsewhere,
    /// Nothing is left to be tried.
    Ends(Conclusion),
}

impl Rounds<'_, '_> {
    /// The place that is proposed for a tetrahedron at an attempt, and the way to it. The last
    /// attempt ends.
    pub(super) fn approach(&self, own: &Foremost, rank: u32, attempt: usize) -> Approach {
        let (t, state, aims, radius) =
            (own.t, &self.own.state, self.own.aims(), own.shape.radius());
        let refuse = |reason| Approach::Ends(Conclusion { t, rank, verdict: Err(reason) });
        if aims.is_short(radius) {
            return refuse(Reason::Floor);
        }
        let aim = (attempt < ATTEMPTS).then(|| aims.tet(radius, own.centre, attempt));
        let Some(Aim::At { point: p, carrier, may }) = aim else {
            let mut sides = state.boundary_sides(t);
            state.sort(&mut sides);
            return Approach::Ends(self.conclusion(own, rank, &sides));
        };
        let from = match state.way_to(t, &p, may) {
            Way::Arrived(from) => from,
            Way::Blocked(s) => {
                return Approach::Ends(self.conclusion(own, rank, &[Item::Subface(s)]));
            }
            Way::Outside => return Approach::Elsewhere,
        };
        match self.blocked(&p, own) {
            Some(reason) => refuse(reason),
            None => Approach::At(Place { p, carrier, from }),
        }
    }

    /// The conclusion for a tetrahedron before which one of some items has to be split.
    pub(super) fn conclusion(&self, own: &Foremost, rank: u32, first: &[Item]) -> Conclusion {
        let limit = self.limit(own.t, &own.shape);
        let reason = self.own.state.reason_near(own.corners);
        let verdict = self.first_of(first, limit, reason);
        let verdict = verdict.map(|item| Asked { item, limit, near: own.t });
        Conclusion { t: own.t, rank, verdict }
    }

    /// Proposes a point for a tetrahedron near a patch, the leader of a group, of this rank: what
    /// its labels would be, the open cavity tells.
    pub(super) fn probe_tet(&mut self, own: &Foremost, rank: u32) {
        let t = own.t;
        let item = Item::Tet(t, self.own.state.vertices(t));
        for attempt in 0..=ATTEMPTS {
            let place = match self.approach(own, rank, attempt) {
                Approach::At(place) => place,
                Approach::Elsewhere => continue,
                Approach::Ends(conclusion) => return self.demands.conclusions.push(conclusion),
            };
            match self.probe((item, rank), &place, |judge| judge.on_tet(t, &place)) {
                Probe::Fits => {
                    self.note_alone();
                    return self.reserve_last();
                }
                Probe::Defers(first) => {
                    let conclusion = self.conclusion(own, rank, &first);
                    // One that is refused is in nobody's way.
                    match conclusion.verdict {
                        Ok(_) => self.reserve_last(),
                        Err(_) => self.note_blocks(self.limit(t, &own.shape)),
                    }
                    return self.demands.conclusions.push(conclusion);
                }
                Probe::Refuses(_) | Probe::Barred | Probe::Useless => {}
            }
        }
    }

    /// Asks for the boundary items that the probed tetrahedra wait for, and refuses those that none
    /// may be split for. One that is killed waits for what becomes of its place.
    pub(super) fn conclude(&mut self) {
        for Conclusion { t, rank, verdict } in std::mem::take(&mut self.demands.conclusions) {
            if self.reserved.has_rival(t, rank) {
                continue;
            }
            match verdict {
                Ok(asked) => self.demands.asked.push(asked),
                Err(reason) => self.refuse(Item::Tet(t, self.own.state.vertices(t)), reason),
            }
        }
    }

    /// The edges that splitting a tetrahedron may lead to.
    pub(super) fn limit(&self, t: TetId, shape: &Shape) -> Option<Limit> {
        let own = &self.own;
        let parts = &own.record.parts;
        let item = || Item::Tet(t, own.state.vertices(t));
        let part = if parts.is_empty() { None } else { parts.get(&item()).copied() };
        own.bounds.as_ref().map(|b| b.limit(&own.state, t, shape).times(part.unwrap_or(1.0)))
    }

    /// Opens the cavity of a place, takes the verdict and sets the cavity back. A point that serves
    /// its item becomes a candidate.
    pub(super) fn probe(
        &mut self,
        (item, rank): (Item, u32),
        place: &Place,
        verdict: impl FnOnce(Judge<'_>) -> Verdict,
    ) -> Probe {
        let Self { own, reserved, choice, stats, .. } = self;
        let Choice { candidates, cavities, .. } = choice;
        let state = &mut own.state;
        let place = Place { from: state.start_near(place.from), ..*place };
        let first = cavities.len();
        stats.searches += 1;
        let is_free = place.carrier == Carrier::Free;
        let open = match is_free {
            true => state.begin_and_look(&place, &mut AdmitAll),
            // Rule (d): boundary points keep apart.
            false => state.begin_and_look(&place, &mut |t: TetId, _: Role| {
                let before = reserved.holder(t).map(|other| candidates[other].place.carrier);
                before.is_none_or(|carrier| carrier.is_with(place.carrier))
            }),
        };
        let open = match open {
            Ok(open) => open,
            Err(At::Vertex(_)) => return Probe::Useless,
            Err(At::SetBack(_)) => {
                stats.searches -= 1;
                stats.barred += 1;
                return Probe::Barred;
            }
        };
        let verdict = verdict(Judge::on_open(open.owner(), &own.record));
        let (probe, filling) = match verdict {
            Verdict::Fill(filling) => (Probe::Fits, filling),
            Verdict::Defer(first) if is_free => (Probe::Defers(first), Filling::default()),
            Verdict::Defer(first) => return Probe::Defers(first),
            Verdict::Refuse(reason) => return Probe::Refuses(reason),
            Verdict::Useless | Verdict::AtPatch => return Probe::Useless,
        };
        cavities.extend(open.tets());
        let place = Place { from: cavities[first], ..place };
        let cavity = first..cavities.len();
        let (fits, state) = (matches!(probe, Probe::Fits), open.owner());
        let (closure, survey) = (InMesh::open(state), &state.survey);
        let watch = match is_free {
            true => survey.watch_in_tet(&closure),
            false => Some(survey.watch_at_item(&closure, Some(item), place.carrier)),
        };
        // Labels at a patch are a function of the mesh as long as one point at a time changes it.
        let is_patch = |f: u32| state.is_patch(f);
        let alone = filling.changes.iter().any(|change| is_patch(change.facet));
        candidates.push(Candidate { item, rank, fits, watch, alone, place, cavity, filling });
        probe
    }

    /// Takes the last candidate, unless one taken before it is in its way.
    pub(super) fn take_or_drop(&mut self) {
        self.note_alone();
        if self.survives(self.choice.candidates.len() - 1) {
            self.take();
        } else if let Some(last) = self.choice.candidates.pop() {
            self.choice.cavities.truncate(last.cavity.start);
        }
    }

    pub(super) fn refuse(&mut self, item: Item, reason: Reason) {
        self.demands.refusals.push((item, reason));
    }

    /// A boundary item waits for others, unless all of them were refused.
    pub(super) fn wait(&mut self, item: Item, first: Vec<Item>, near: TetId) {
        let limit = self.own.record.limits.get(&item).copied();
        match self.first_of(&first, limit, Reason::Rounding) {
            Ok(first) => {
                self.demands.asked.push(Asked { item: first, limit, near });
                self.demands.waits.push((item, Pending { first: Some(first), near }));
            }
            Err(reason) => self.refuse(item, reason),
        }
    }

    /// The first of some items that may be split under a limit; else the reason why none may.
    pub(super) fn first_of(
        &self,
        items: &[Item],
        limit: Option<Limit>,
        mut reason: Reason,
    ) -> Result<Item, Reason> {
        for item in items {
            match self.own.record.bars(item, limit) {
                None => return Ok(*item),
                Some(why) => reason = reason.after(why),
            }
        }
        Err(reason)
    }
}
