//! The home's side of a choice in turns: it tells the conductor who there is and what probes have
//! found, and carries out what he decides.

use super::candidate::{Outcome, Turn, Waits, What};
use super::contest::CONDUCTOR;
use super::ranked::rank_of;
use super::source::{Rounds, Stage};
use crate::protocol::Rules;
use crate::refining::domain::DomainMesh;
use crate::refining::news::{DomainNews, Entrant, Fate, Owned, Report, Reported};
use ltbw_core::topology::{TetId, tet_of};
use std::collections::BTreeSet;

/// The tetrahedra of a closure: those in conflict, and those around them.
#[derive(Debug, Default)]
struct Parts {
    cavity: Vec<Owned>,
    ring: Vec<Owned>,
}

impl<C: Rules> Rounds<C> {
    /// Is the choice of this round one in turns?
    pub(super) fn has_turns(&self, mesh: &DomainMesh<'_>) -> bool {
        mesh.complex.has_patches()
    }

    /// This round's probes are made, and none is launched yet: tells the conductor of them.
    pub(super) fn enter(&mut self, mesh: &DomainMesh<'_>) {
        let mut entrants = Vec::with_capacity(self.choice.probes.len());
        for (number, probe) in (0..).zip(&mut self.choice.probes) {
            probe.turn = Some(Box::new(Turn { number, passed: Vec::new() }));
            let (tet, group) = match probe.what {
                What::Tet(t, v) => (Some(t), mesh.complex.group_of(v.map(|v| mesh.point(v)))),
                What::Item(_) => (None, None),
            };
            let rank = probe.rank().whole(|v| rank_of::<C>(mesh, v));
            entrants.push(Entrant { rank, tet, group });
        }
        self.choice.open = 0;
        self.choice.to_launch.clear();
        self.choice.current = (0..entrants.len() as u32).collect();
        self.choice.fates = Some(None);
        self.send(CONDUCTOR, DomainNews::Entrants(entrants));
    }

    /// The conductor has these probed. Their numbers are along a curve.
    pub(super) fn take_launch(&mut self, mut numbers: Vec<u32>) {
        numbers.sort_unstable();
        if let Some(entered) = self.choice.entered.take() {
            return self.probe_leaders(&entered, &numbers);
        }
        self.choice.open += numbers.len();
        self.choice.to_launch.extend(numbers);
    }

    /// The tetrahedra of a probe's closure, if it was searched.
    fn parts(&self, mesh: &DomainMesh<'_>, k: u32) -> Parts {
        let probe = &self.choice.probes[k as usize];
        let own = |tet: TetId| Owned { owner: self.me, tet };
        let inside = self.served.cavity_at(&self.served.inside(self.id(k)));
        if !inside.is_empty() {
            let is_in: BTreeSet<TetId> = inside.iter().copied().collect();
            let tets = mesh.inner.tets();
            let around = inside.iter().flat_map(|&t| tets.neighbours(t).map(tet_of));
            let ring: BTreeSet<TetId> = around.filter(|t| !is_in.contains(t)).collect();
            return Parts {
                cavity: inside.iter().copied().map(own).collect(),
                ring: ring.into_iter().map(own).collect(),
            };
        }
        let mut parts = Parts::default();
        for told in probe.told.iter().filter(|_| probe.was_searched) {
            for (&(_, is_in), &tet) in told.closure.tets.iter().zip(&told.tets) {
                if is_in { &mut parts.cavity } else { &mut parts.ring }.push(tet);
            }
        }
        parts
    }

    /// An attempt for a boundary item has found no point that does: those that were taken before it
    /// bar it there, too.
    pub(super) fn pass(&mut self, mesh: &DomainMesh<'_>, k: u32) {
        if self.choice.probes[k as usize].turn.is_none() {
            return;
        }
        let Parts { cavity, ring } = self.parts(mesh, k);
        let probe = &mut self.choice.probes[k as usize];
        if let (What::Item(_), Some(turn)) = (&probe.what, &mut probe.turn) {
            turn.passed.extend(cavity);
            turn.passed.extend(ring);
        }
    }

    /// The next attempt takes the turn of one. If it has no point, those that were taken before bar
    /// the item by where the point of this one lives.
    pub(super) fn pass_turn_on(&mut self, from: u32, to: u32) {
        let Some(turn) = self.choice.probes[from as usize].turn.take() else { return };
        self.choice.current[turn.number as usize] = to;
        let carrier = self.choice.probes[from as usize].carrier;
        let next = &mut self.choice.probes[to as usize];
        next.turn = Some(turn);
        // R36.
        if C::keeps_carrier() {
            next.carrier = carrier;
        }
    }

    /// A probe has ended: tells the conductor what it has found.
    pub(super) fn report(&mut self, mesh: &DomainMesh<'_>, k: u32) {
        if self.choice.probes[k as usize].turn.is_none() {
            return;
        }
        let Parts { cavity, ring } = self.parts(mesh, k);
        let me = self.me;
        let probe = &mut self.choice.probes[k as usize];
        let Some(turn) = &mut probe.turn else { return };
        let verdict = match &probe.outcome {
            Outcome::Open | Outcome::Dropped => Reported::Nothing,
            Outcome::Asks(..) => Reported::Asks,
            Outcome::Refused(_) => Reported::Refused,
            Outcome::Fits(filled) => Reported::Fits { is_alone: filled.is_alone },
        };
        let watch = probe.waits.take().map(|waits| match (*waits, &probe.told) {
            (Waits::Here(watch, _), _) => watch.named(|tet| Owned { owner: me, tet }),
            (Waits::Told(watch), Some(told)) => watch.named(|place| told.tets[place]),
            (Waits::Told(watch), None) => {
                watch.named(|_| Owned { owner: me, tet: TetId::default() })
            }
        });
        let report = Report {
            number: turn.number,
            verdict,
            carrier: probe.carrier,
            passed: std::mem::take(&mut turn.passed),
            cavity,
            ring,
            watch,
        };
        self.send(CONDUCTOR, DomainNews::Report(report));
    }

    /// Carries out what the conductor has decided.
    pub(super) fn carry_out_fates(&mut self, mesh: &mut DomainMesh<'_>) {
        self.stage = Stage::Deciding;
        self.choice.open = 0;
        let fates = self.choice.fates.take().flatten().unwrap_or_default();
        for (number, fate) in fates.into_iter().enumerate() {
            let k = self.choice.current[number];
            match fate {
                Fate::Stands => self.carry_out(mesh, k),
                Fate::Barred => self.choice.probes[k as usize].was_searched = false,
                Fate::Falls | Fate::Follows => {}
            }
        }
        self.refuse_followers(mesh);
    }
}
