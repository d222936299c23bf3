//! The way from a tetrahedron to a point that is proposed for it, and what follows from probes that
//! end without one.

use super::foremost::Foremost;
use super::{Asked, Conclusion, Pending, Rounds};
use crate::complex::measure::Shape;
use crate::mesh::item::Item;
use crate::mesh::limit::Limit;
use crate::mesh::state::Place;
use crate::outcome::Reason;
use crate::rules::aim::{ATTEMPTS, Aim};
use crate::rules::record::first_of;
use crate::rules::walk::Way;
use ltbw_core::topology::TetId;

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
        reason: Reason,
    ) -> Result<Item, Reason> {
        first_of(items, |item| self.own.record.bars(item, limit), reason)
    }
}
