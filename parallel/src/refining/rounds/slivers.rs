//! Slivers: when all bounds are met, and nothing was refused, the tetrahedra with small dihedral
//! angles are candidates, each with the point that serves it best.
//!
//! Points are tried one after the other, by the rules of the engine (`Tries`). Where the closure of
//! one is all here that takes no message. Else it is a probe as others are, which reserves nothing;
//! the best one is probed once more, and reserves its cavity. A point is inserted only if no other
//! one is in its closure. Whatever part of a closure is another worker's is told whole: the corners
//! and regions of its walls make the new tetrahedra.

use super::candidate::{Outcome, Waits, What};
use super::here::Here;
use super::ranked::{Own, places_of};
use super::reserved::Whose;
use super::source::{Rounds, Stage};
use super::stages::along_curve;
use super::tried::{Best, Now, Sliver, Slivers};
use super::way::{Begin, Entry, WayEnd, walk_way};
use crate::protocol::{Directory, Rules, Walk};
use crate::refining::domain::DomainMesh;
use crate::refining::news::{PartEnd, bits, point};
use ltbw_core::topology::{INFINITE, TetId};
use ltbw_domain::quality::LeastAngles;
use ltbw_refine::{
    BoundaryItem, Carrier, Collected, Rank, RankLead, SliverRuling, Tries, Try, Watch, middle,
};

/// The subface that a way has ended at, if it did.
fn barrier(end: PartEnd) -> Option<BoundaryItem> {
    match end {
        PartEnd::Blocked(item) => Some(item.item()),
        PartEnd::Found | PartEnd::Outside | PartEnd::Vertex => None,
    }
}

/// The tetrahedra of a worker that are of the domain, by their smallest dihedral angle.
fn least_angles(mesh: &DomainMesh<'_>) -> LeastAngles {
    let (tets, mut sum) = (mesh.inner.tets(), LeastAngles::default());
    for (t, _) in tets.tets() {
        let v = tets.vertices(t);
        if mesh.region(t) != 0 && !v.contains(&INFINITE) {
            sum.add(v.map(|v| mesh.point(v)).each_ref());
        }
    }
    sum
}

impl<C: Rules> Rounds<C> {
    /// Was anything refused, as far as this worker knows? Then slivers come after other late steps.
    pub(super) fn has_refused(&self) -> bool {
        self.keys.may_have_over() || !self.demands.refused.all.is_empty()
    }

    /// All bounds are met, and nothing was refused: slivers are looked for, once.
    pub(super) fn begin_slivers(&mut self, mesh: &mut DomainMesh<'_>) {
        let tets = mesh.inner.tets();
        let all = self.keys.thin(mesh).into_iter().map(|t| (t, tets.vertices(t)));
        let is_sliver =
            |&(t, v): &Own| mesh.complex.is_sliver(v.map(|v| mesh.corner(v)), mesh.region(t));
        self.slivers.list = Some(all.filter(is_sliver).collect());
        self.slivers.before = mesh.complex.counts_angles().then(|| least_angles(mesh));
        self.choose_slivers(mesh);
    }

    /// A round of slivers begins. It has no turns: all points are alone, and who is before others
    /// in a closure is a function of that closure.
    pub(super) fn choose_slivers(&mut self, mesh: &mut DomainMesh<'_>) {
        self.stage = Stage::Choosing;
        self.choice.fits = 0;
        self.choice.has_boundary = false;
        (self.choice.foremost, self.choice.entered, self.choice.fates) = (None, None, None);
        mesh.begin_round();
        let Slivers { list, all, served, .. } = &mut self.slivers;
        served.clear();
        let own = list.iter().flatten().copied().filter(|&(t, v)| mesh.has(t, v));
        let begin = |own: Own| {
            let tries = Tries::of(own.1.map(|v| mesh.point(v)))?;
            Some(Sliver {
                own,
                tries,
                now: Now::Inside,
                items: Vec::new(),
                blocked: None,
                best: None,
            })
        };
        *all = own.filter_map(begin).collect();
        let places: Vec<_> = all.iter().map(|sliver| mesh.point(sliver.own.1[0])).collect();
        for n in along_curve(places.into_iter()) {
            let rank = Rank::of_sliver(places_of::<C>(mesh, self.slivers.all[n].own.1));
            let k = self.add_sliver_probe(n, rank);
            self.choice.to_launch.push_back(k);
        }
    }

    fn add_sliver_probe(&mut self, n: usize, rank: Rank) -> u32 {
        let (t, v) = self.slivers.all[n].own;
        let k = self.add_probe(What::Tet(t, v), RankLead::of_sliver(), 0);
        self.choice.probes[k as usize].sliver = Some(Box::new((n, rank)));
        k
    }

    /// The number of the sliver of a probe.
    fn sliver_of(&self, k: u32) -> Option<usize> {
        self.choice.probes[k as usize].sliver.as_ref().map(|own| own.0)
    }

    /// Goes on with the tries for a probe's sliver, up to one that others have to help with.
    pub(super) fn try_on(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let Some(n) = self.sliver_of(k) else { return };
        // Ends: the number of tries is bounded.
        loop {
            let sliver = &mut self.slivers.all[n];
            let (now, to, carrier) = match mesh.complex.next_try(&mut sliver.tries) {
                Try::Inside(p) => (Now::Inside, p, Carrier::Free),
                Try::Look(Some(p)) => (Now::Looking, p, Carrier::Free),
                Try::Look(None) => {
                    sliver.now = Now::Looking;
                    match self.end_way(mesh, k, n, None) {
                        true => continue,
                        false => return self.ask_beyond(mesh, directory, k),
                    }
                }
                Try::Beside { item, point, carrier, gives_way } => {
                    (Now::Beside { item, gives_way }, point, carrier)
                }
                Try::Over => return self.take_best(mesh, directory, k),
            };
            sliver.now = now;
            let probe = &mut self.choice.probes[k as usize];
            (probe.to, probe.carrier, probe.may) = (bits(&to), carrier, now != Now::Looking);
            match self.try_here(mesh, k, n) {
                Some(true) => {}
                Some(false) => return self.ask_beyond(mesh, directory, k),
                None => return self.ask_others(mesh, directory, k),
            }
        }
    }

    /// Tries the point of a probe if all of its closure is here; `None` if it is not, `false` if
    /// others have to tell what is beside the sliver.
    fn try_here(&mut self, mesh: &mut DomainMesh<'_>, k: u32, n: usize) -> Option<bool> {
        let Sliver { own: (t, v), now, .. } = self.slivers.all[n];
        let (to, may) = {
            let probe = &self.choice.probes[k as usize];
            (probe.to, probe.may)
        };
        let seed = match now {
            Now::Inside | Now::Looking => {
                let start = bits(&middle(v.map(|v| mesh.point(v))));
                match walk_way(mesh, Entry { t, by: None }, &start, &to, may) {
                    WayEnd::At(seed) => seed,
                    WayEnd::Far(_) => return None,
                    WayEnd::Not(end) => {
                        return Some(self.end_way(mesh, k, n, barrier(end)));
                    }
                }
            }
            Now::Beside { .. } | Now::Taken => match mesh.seek(&point(&to), Some(t)) {
                Walk::At(seed) | Walk::Locked(seed) => seed,
                Walk::Duplicate(_) => return Some(true),
                Walk::Exits(_) | Walk::NoTets => return None,
            },
        };
        let cavity = mesh.cavity_of(seed, &point(&to))?.to_vec();
        if now == Now::Taken {
            self.served.enter_found(self.id(k), &cavity);
            self.take_here(mesh, k, n);
        } else {
            let ruling = self.rule_on_try(mesh, k, n, &cavity);
            self.take_ruling(k, n, ruling);
        }
        Some(true)
    }

    /// The verdict on a try whose closure is all here.
    fn rule_on_try(
        &self,
        mesh: &DomainMesh<'_>,
        k: u32,
        n: usize,
        cavity: &[TetId],
    ) -> SliverRuling {
        let (probe, sliver) = (&self.choice.probes[k as usize], &self.slivers.all[n]);
        let here = Here::of(mesh, cavity);
        let has_sliver = cavity.contains(&sliver.own.0);
        probe.survey(mesh, &here).rule_on_sliver(sliver.on(), has_sliver)
    }

    /// A way has ended before its point, at a subface or elsewhere. If it was that to the sliver's
    /// centre, what is beside the sliver is looked for: `false` if others have to tell.
    fn end_way(
        &mut self,
        mesh: &DomainMesh<'_>,
        k: u32,
        n: usize,
        blocked: Option<BoundaryItem>,
    ) -> bool {
        let sliver = &mut self.slivers.all[n];
        if sliver.now != Now::Looking {
            return true;
        }
        sliver.blocked = blocked;
        let (t, v) = sliver.own;
        let Some(sides) = self.choice.probes[k as usize].sides(mesh, t, v) else {
            return false;
        };
        self.look_beside(mesh, n, sides);
        true
    }

    /// Finds the boundary items beside a sliver, of which these are its sides, with one on the way
    /// to its centre.
    pub(super) fn look_beside(
        &mut self,
        mesh: &DomainMesh<'_>,
        n: usize,
        mut faces: Vec<BoundaryItem>,
    ) {
        let sliver = &mut self.slivers.all[n];
        let corners = sliver.own.1.map(|v| mesh.corner(v));
        faces.extend(sliver.blocked.take());
        let barred_by = std::mem::take(&mut sliver.items);
        sliver.items = mesh.complex.items_beside(corners, faces, barred_by);
        sliver.tries.beside(sliver.items.clone());
    }

    fn take_ruling(&mut self, k: u32, n: usize, ruling: SliverRuling) {
        let (probe, sliver) = (&self.choice.probes[k as usize], &mut self.slivers.all[n]);
        match ruling {
            SliverRuling::Serves { filled, sharpest } => {
                if sliver.tries.take(sharpest) {
                    sliver.best = Some(Best { to: probe.to, carrier: probe.carrier, filled });
                }
            }
            SliverRuling::Barred(items) => sliver.items.extend(items),
            SliverRuling::Fails => {}
        }
    }

    /// A probe that nobody knows of yet takes the place of one of which others have a part.
    pub(super) fn anew(&mut self, k: u32) -> u32 {
        let probe = &self.choice.probes[k as usize];
        let (to, carrier, may) = (probe.to, probe.carrier, probe.may);
        let is_new = probe.told.is_none() && self.served.part(self.id(k)).is_none();
        let Some(own) = probe.sliver.as_deref().filter(|_| !is_new) else { return k };
        let next = self.add_sliver_probe(own.0, own.1);
        self.conclude(k, Outcome::Dropped);
        let probe = &mut self.choice.probes[next as usize];
        (probe.to, probe.carrier, probe.may) = (to, carrier, may);
        next
    }

    /// The closure of a probe's point is not all here: others tell of their parts.
    fn ask_others(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let k = self.anew(k);
        let Some(n) = self.sliver_of(k) else { return };
        let Sliver { own: (t, v), now, .. } = self.slivers.all[n];
        let probe = &mut self.choice.probes[k as usize];
        probe.open = 1;
        let may = probe.may;
        let own = &self.seeker(k);
        match now {
            Now::Inside | Now::Looking => {
                let start = bits(&middle(v.map(|v| mesh.point(v))));
                self.go(mesh, directory, own, Entry { t, by: None }, Begin { start, may });
            }
            Now::Beside { .. } | Now::Taken => self.seek(mesh, directory, own, Some(t)),
        }
    }

    /// A try that others have helped with has ended without a closure.
    pub(super) fn end_try(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        k: u32,
        end: PartEnd,
    ) {
        let Some(n) = self.sliver_of(k) else { return };
        if self.slivers.all[n].now == Now::Taken {
            // The best point was found before, in this mesh.
            return self.give_up(mesh, k);
        }
        match self.end_way(mesh, k, n, barrier(end)) {
            true => self.try_on(mesh, directory, k),
            false => self.ask_beyond(mesh, directory, k),
        }
    }

    /// All of a try's closure is known, with what others have told: the verdict.
    pub(super) fn judge_try(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let Some(n) = self.sliver_of(k) else { return };
        let (id, is_taken) = (self.id(k), self.slivers.all[n].now == Now::Taken);
        // The way may have come back, to where all is here.
        let inside = self.served.inside(id);
        if !inside.is_empty() {
            if is_taken {
                return self.take_here(mesh, k, n);
            }
            let cavity = self.served.cavity_at(&inside).to_vec();
            let ruling = self.rule_on_try(mesh, k, n, &cavity);
            self.take_ruling(k, n, ruling);
        } else {
            self.complete(mesh, k);
            let probe = &self.choice.probes[k as usize];
            let Some(told) = &probe.told else { return self.give_up(mesh, k) };
            if is_taken {
                let all = Watch::over((0..told.closure.tets.len()).collect());
                self.take_place(mesh, k, n, Waits::Told(all));
                // R23.
                if C::hears_of_rivals() {
                    self.want_rivals(k);
                }
                return;
            }
            let sliver = &self.slivers.all[n];
            let has_sliver = self.served.cavity(id).any(|t| t == sliver.own.0);
            let closure = Collected::of(&told.closure);
            let ruling = probe.survey(mesh, &closure).rule_on_sliver(sliver.on(), has_sliver);
            self.take_ruling(k, n, ruling);
        }
        self.drop_parts(k);
        self.try_on(mesh, directory, k);
    }

    /// Nothing is left to try: takes the best point, if one serves.
    fn take_best(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let Some(n) = self.sliver_of(k) else { return };
        let Some(best) = &self.slivers.all[n].best else {
            return self.conclude(k, Outcome::Dropped);
        };
        let (to, carrier) = (best.to, best.carrier);
        let k = self.anew(k);
        let probe = &mut self.choice.probes[k as usize];
        (probe.to, probe.carrier, probe.may) = (to, carrier, true);
        self.slivers.all[n].now = Now::Taken;
        match self.try_here(mesh, k, n) {
            None => self.ask_others(mesh, directory, k),
            // It was found before, in this mesh.
            Some(_) if self.choice.probes[k as usize].outcome == Outcome::Open => {
                self.give_up(mesh, k);
            }
            Some(_) => {}
        }
    }

    /// All of the closure of the best point is here.
    fn take_here(&mut self, mesh: &DomainMesh<'_>, k: u32, n: usize) {
        let closure = self.served.list_closure(mesh, self.id(k));
        let closure = Watch::over(self.served.cavity_at(&closure).to_vec());
        self.take_place(mesh, k, n, Waits::Here(closure, 0..0));
    }

    /// The best point of a probe's sliver is a candidate: it reserves its cavity.
    fn take_place(&mut self, mesh: &DomainMesh<'_>, k: u32, n: usize, waits: Waits) {
        let sliver = &mut self.slivers.all[n];
        let Some(Best { filled, .. }) = sliver.best.take() else { return };
        self.slivers.served.push(sliver.own);
        self.choice.fits += 1;
        let (id, probe) = (self.id(k), &mut self.choice.probes[k as usize]);
        probe.waits = Some(Box::new(waits));
        let whose = Whose { rank: probe.rank(), carrier: probe.carrier };
        self.served.reserve_own::<C>(mesh, id, whose);
        self.conclude(k, Outcome::Fits(filled));
    }
}
