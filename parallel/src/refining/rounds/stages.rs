//! The stages of a round, one after the other, and the barriers between them.
//!
//! ```text
//! count     barrier: which items there are to split; all decide alike what this round splits
//! look      if tetrahedra: new ones get their ranks; two exchanges with the workers beside
//! choose    who is foremost, if tetrahedra are split; probes find closures and reserve cavities
//! chosen    barrier: all cavities are reserved
//! decide    owners tell of rivals; each home decides alone for its own
//! insert    the protocol inserts what is chosen; barrier when nothing seems to be under way
//! ```
//!
//! Where the mesh is read, up to the second barrier, it stays as it is. From there on others may
//! insert already, so that decisions rest on what was read before. All barriers are waves that are
//! repeated until the counts say that nothing is on its way: of one kind of messages, which nobody
//! sends any more once he has said so, one wave with equal counts will do; operations lead to
//! others, so it takes two waves that are equal, the one that ends the insertion and the one that
//! counts.

use super::candidate::{Probe, What};
use super::demands::Settled;
use super::figures::Ending;
use super::keys::Foremost;
use super::source::{Rounds, Stage};
use super::tree::{MOST, SENT, Step, TAKEN, is_quiet};
use crate::protocol::{Directory, Rules, Standing, WorkerId};
use crate::refining::domain::DomainMesh;
use crate::refining::news::{DomainNews, KeysTold, SUMS, Sums};
use ltbw_core::order::{Curve, bounding_box};
use ltbw_exact::Point;
use ltbw_refine::{BoundaryItem, are_joined};

// The places of sums.
const FOREMOST: usize = 2;
const IRREGULAR: usize = MOST;
const OPEN: usize = 4;
const CANDIDATES: usize = 5;
const CANCELLED: usize = 5;
const READY: usize = 6;
const WAITING: usize = 7;
const CHOSEN: [usize; 3] = [6, 7, 8];
const FOLLOWERS: usize = 0;
const NEWS: usize = 9;
const REFUSED: usize = 9;

/// The numbers of values along a Hilbert curve through their places. (Nothing is done on other
/// threads: these have workers of their own.)
pub(super) fn along_curve(places: impl Iterator<Item = Point>) -> impl Iterator<Item = usize> {
    let places: Vec<Point> = places.collect();
    let (low, high) = bounding_box(&places);
    Curve::of_box(low, high).order(&places).into_iter().map(|k| k as usize)
}

/// Of sums, the numbers of messages about operations.
fn operations(sums: Sums) -> Sums {
    let mut own = [0; SUMS];
    (own[SENT], own[TAKEN]) = (sums[SENT], sums[TAKEN]);
    own
}

impl<C: Rules> Rounds<C> {
    /// Looks at some of the tetrahedra made since the last look, `most` of them at most.
    pub(super) fn look_at_created(&mut self, mesh: &mut DomainMesh<'_>, most: usize) {
        let first = self.created.len().saturating_sub(most);
        self.keys.look_at::<C>(mesh, &self.created[first..]);
        mesh.count_looks((self.created.len() - first) as u64);
        self.created.truncate(first);
    }

    /// Looks at the new tetrahedra; the first exchange begins.
    pub(super) fn look(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory) {
        self.look_at_created(mesh, usize::MAX);
        self.keys.start(mesh);
        if self.keys.own.count_looks_anew() {
            // They are as of looks of before.
            self.ahead.clear();
        }
        mesh.count_steps(self.keys.news() as u64 / 8);
        self.begin_exchange(mesh, directory, 0);
    }

    fn begin_exchange(&mut self, mesh: &DomainMesh<'_>, directory: &Directory, second: u32) {
        self.stage = Stage::Exchanging(second);
        self.exchange.number += 1;
        let told = match second {
            0 => self.keys.ranks_told::<C>(mesh, directory),
            _ => self.keys.behind_told::<C>(mesh, directory),
        };
        self.exchange.awaited = told.keys().copied().collect();
        for (to, keys) in told {
            self.send(to, DomainNews::Keys { exchange: self.exchange.number, keys });
        }
        for (from, exchange, keys) in std::mem::take(&mut self.exchange.early) {
            self.take_keys(mesh, from, exchange, keys);
        }
    }

    pub(super) fn take_keys(
        &mut self,
        mesh: &DomainMesh<'_>,
        from: WorkerId,
        exchange: u64,
        keys: KeysTold,
    ) {
        match self.stage {
            // R20.
            Stage::Exchanging(_) if exchange == self.exchange.number || !C::numbers_exchanges() => {
                self.keys.hear(mesh, keys);
                self.exchange.awaited.remove(&from);
            }
            _ => self.exchange.early.push((from, exchange, keys)),
        }
    }

    /// All workers beside have told their keys: the next stage begins.
    pub(super) fn end_exchange(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        second: u32,
    ) {
        if second == 0 {
            return self.begin_exchange(mesh, directory, 1);
        }
        self.begin_to_choose(mesh, true);
    }

    /// Is this worker ready for the barrier of its stage?
    pub(super) fn is_ready_for_barrier(&self, standing: Standing) -> bool {
        match self.stage {
            Stage::Counting => standing.is_passive,
            Stage::Choosing => {
                // The conductor has to have said who is probed, and in turns what becomes of all.
                let is_told =
                    !matches!(self.choice.fates, Some(None)) && self.choice.entered.is_none();
                is_told && self.choice.open == 0 && self.choice.to_launch.is_empty()
            }
            Stage::Inserting => standing.is_passive && self.points.chosen.is_empty(),
            Stage::Looking
            | Stage::Exchanging(_)
            | Stage::Parting
            | Stage::Deciding
            | Stage::Over => false,
        }
    }

    /// Says what this worker adds at the barrier for which it is ready.
    pub(super) fn put(&mut self, mesh: &DomainMesh<'_>, standing: Standing) {
        if self.stage == Stage::Counting {
            // Others may search for the next choice before this worker hears that all have counted.
            self.served.clear(mesh);
            self.choice.probes.clear();
        }
        let step = self.waves.tree.put(self.sums(standing));
        self.take_step(step);
    }

    /// The sums that this worker adds at the barrier for which it is ready.
    fn sums(&self, standing: Standing) -> Sums {
        let mut sums = [0; SUMS];
        match self.stage {
            Stage::Counting => {
                let ready = self.demands.ready();
                sums[SENT] = standing.sent as i64;
                sums[TAKEN] = standing.received as i64;
                sums[READY] = ready as i64;
                sums[WAITING] = (self.demands.pending.len() - ready) as i64;
                sums[OPEN] = self.counts.releases;
                sums[CANCELLED] = i64::from(self.is_cancelled);
            }
            Stage::Choosing => {
                sums[CANDIDATES] = self.choice.fits;
                sums[FOLLOWERS] = self.barriers.followers.len() as i64;
                sums[FOREMOST] = self.choice.foremost.unwrap_or(0);
                sums[OPEN] = self.counts.notes;
                sums[IRREGULAR] = i64::from(self.is_irregular);
                sums[REFUSED] = i64::from(self.has_refused());
            }
            Stage::Inserting => {
                sums[SENT] = standing.sent as i64;
                sums[TAKEN] = standing.received as i64;
                sums[OPEN] = self.counts.asks;
                for (place, count) in CHOSEN.into_iter().zip(self.points.by_class) {
                    sums[place] = count;
                }
                sums[NEWS] = self.demands.asked.len() as i64 + self.demands.refused.count;
                sums[FOREMOST] = self.choice.foremost.unwrap_or(0);
                sums[MOST] = self.points.by_class.iter().sum();
            }
            Stage::Looking
            | Stage::Exchanging(_)
            | Stage::Parting
            | Stage::Deciding
            | Stage::Over => {}
        }
        sums
    }

    pub(super) fn take_step(&mut self, step: Option<Step>) {
        match step {
            None => {}
            Some(Step::Up(to, sums)) => self.send(to, DomainNews::Up(sums)),
            Some(Step::Done(sums)) => self.pass_on(sums),
        }
    }

    /// A barrier is over, with these sums. The rest is thought about when others have been told.
    pub(super) fn pass_on(&mut self, sums: Sums) {
        self.waves.tree.release();
        for to in self.waves.tree.below() {
            self.send(to, DomainNews::Down(sums));
        }
        self.figures.barriers += 1;
        self.waves.passed = Some(sums);
    }

    /// Goes on after a barrier.
    pub(super) fn go_on(&mut self, mesh: &mut DomainMesh<'_>, sums: Sums) {
        let before = self.waves.before.replace(sums);
        match self.stage {
            // Something was still under way: once more.
            _ if sums[OPEN] != 0 => {}
            // R19.
            Stage::Counting => {
                if is_quiet::<C>(before.map(operations), &operations(sums)) {
                    self.decide_what(mesh, &sums);
                }
            }
            Stage::Choosing => self.end_choice(mesh, &sums),
            Stage::Inserting => {
                if sums[SENT] == sums[TAKEN] {
                    self.settle(&sums);
                }
            }
            Stage::Looking
            | Stage::Exchanging(_)
            | Stage::Parting
            | Stage::Deciding
            | Stage::Over => {}
        }
        if !matches!(self.stage, Stage::Inserting | Stage::Counting) {
            self.waves.before = None;
        }
    }

    /// All reservations are known: the round is decided on, unless it is not to be carried out.
    /// One that is not counts no candidates, for the engine chooses it once more.
    fn end_choice(&mut self, mesh: &mut DomainMesh<'_>, sums: &Sums) {
        let is_done = self.is_done(sums);
        if sums[IRREGULAR] > 0 {
            return self.end(Ending::Irregular);
        }
        if !is_done && self.budget.total + sums[CANDIDATES] > self.budget.most {
            return self.end(Ending::Budget);
        }
        self.count(sums);
        match (is_done, self.slivers.has_begun()) {
            // Late steps come before where anything was refused: they are the engine's.
            (true, false) if sums[REFUSED] == 0 && mesh.complex.splits_slivers() => {
                return self.begin_slivers(mesh);
            }
            (true, begun) => {
                if begun {
                    self.slivers.end();
                }
                return self.end(Ending::Done);
            }
            (false, _) => {}
        }
        if self.begins_second(mesh, sums[FOLLOWERS]) {
            return;
        }
        self.slivers.carry_out();
        self.begin_to_decide(mesh);
        self.end_decisions();
    }

    /// All know how many candidates this round has among the tetrahedra, if it looked for them.
    fn count(&mut self, sums: &Sums) {
        if self.choice.foremost.is_some() {
            self.budget.counted = sums[FOREMOST];
        }
    }

    /// All know how many foremost tetrahedra there are in this round, or how many slivers that a
    /// point serves: is nothing left?
    fn is_done(&self, sums: &Sums) -> bool {
        match self.slivers.has_begun() {
            true => sums[CANDIDATES] == 0,
            false => !self.choice.has_boundary && sums[FOREMOST] == 0,
        }
    }

    /// All know what there is to split, and nothing of the round before is under way.
    fn decide_what(&mut self, mesh: &mut DomainMesh<'_>, sums: &Sums) {
        self.label_parted(mesh);
        let has_boundary = sums[READY] > 0;
        let has_tets = match has_boundary {
            // At patches points are alone in their closures.
            true if self.has_turns(mesh) => false,
            true => are_joined(sums[READY] as usize, self.budget.counted as usize),
            false => true,
        };
        if sums[CANCELLED] > 0 {
            return self.stop(mesh, Ending::Cancelled);
        }
        if !has_boundary && sums[WAITING] > 0 {
            // Of those that circles make the regions are told later.
            self.look_at_created(mesh, usize::MAX);
            return self.enter_circles();
        }
        if self.slivers.has_begun() {
            self.look_at_created(mesh, usize::MAX);
            return self.choose_slivers(mesh);
        }
        // All count the rounds alike.
        if self.border.is_some_and(|border| self.figures.rounds[0] >= border) {
            return self.stop(mesh, Ending::Border);
        }
        if self.pace.is_due(self.figures.rounds[0], self.vertices()) {
            return self.stop(mesh, Ending::Redeal);
        }
        self.choice.has_boundary = has_boundary;
        match has_tets {
            true => self.stage = Stage::Looking,
            // Nobody asks who is foremost: new tetrahedra are looked at later.
            false => self.begin_to_choose(mesh, false),
        }
    }

    /// Stops between two rounds, with all tetrahedra looked at. What has changed at interface faces
    /// is for the next exchange: the rounds may go on.
    fn stop(&mut self, mesh: &mut DomainMesh<'_>, ending: Ending) {
        self.look_at_created(mesh, usize::MAX);
        self.end(ending);
    }

    /// This round's probes are made, those for tetrahedra if it `splits` such.
    fn begin_to_choose(&mut self, mesh: &mut DomainMesh<'_>, splits: bool) {
        self.stage = Stage::Choosing;
        self.choice.fits = 0;
        mesh.begin_round();
        let has_boundary = self.choice.has_boundary;
        let ready: Vec<BoundaryItem> = self
            .demands
            .pending
            .values()
            .filter(|own| has_boundary && own.first.is_none())
            .map(|own| own.item)
            .collect();
        // Along a curve, so that what is near is looked at, and inserted, together.
        for k in along_curve(ready.iter().map(|item| item.corners()[0].point)) {
            let item = ready[k];
            let k = self.add_probe(What::Item(Box::new(item)), item.rank().lead(), 0);
            self.choice.to_launch.push_back(k);
        }
        (self.choice.foremost, self.choice.entered) = (None, None);
        if splits {
            self.check_blocks();
            self.add_foremost(mesh);
        }
        if self.has_turns(mesh) {
            self.enter(mesh);
        }
    }

    /// The tetrahedra that come before all around them are to be probed.
    fn add_foremost(&mut self, mesh: &DomainMesh<'_>) {
        let foremost = self.keys.foremost::<C>(mesh);
        if self.has_leaders(mesh) {
            return self.enter_foremost(mesh, foremost);
        }
        self.choice.foremost = Some(foremost.iter().map(Vec::len).sum::<usize>() as i64);
        // Candidates at interface faces come first: others are waited for there.
        for list in &foremost {
            for k in along_curve(list.iter().map(|own| own.at)) {
                let Foremost { t, v, lead, .. } = list[k];
                let k = self.add_probe(What::Tet(t, v), lead, 0);
                self.choice.to_launch.push_back(k);
            }
        }
        self.keys.take_back(foremost);
    }

    /// If all is decided, insertion begins.
    pub(super) fn end_decisions(&mut self) {
        if self.stage == Stage::Deciding && self.choice.open == 0 {
            let is_counted = |probe: &&Probe| probe.was_searched && probe.sliver.is_none();
            for probe in self.choice.probes.iter().filter(is_counted) {
                self.figures.searches += 1;
                self.figures.ahead += u64::from(probe.is_ahead);
            }
            if self.choice.foremost.is_some() {
                self.ahead.clear();
            }
            self.begin_to_insert();
        }
    }

    /// The points of this worker are chosen: they are inserted.
    pub(super) fn begin_to_insert(&mut self) {
        self.points.starts.clear();
        self.points.starts.extend(self.points.chosen.iter().map(|own| own.start));
        // Names follow one another.
        self.points.first = self.points.chosen.front().map_or(0, |own| own.point.name());
        (self.stage, self.waves.before) = (Stage::Inserting, None);
    }

    /// Nothing of a round seems to be under way: what was asked for, is gone or refused is known.
    /// Whether the last points are in the next wave tells, if it counts as many messages.
    fn settle(&mut self, sums: &Sums) {
        let chosen = CHOSEN.map(|place| sums[place]);
        let all: i64 = chosen.iter().sum();
        self.budget.total += all;
        let figures = &mut self.figures;
        if all > 0 {
            figures.rounds[0] += 1;
            for (k, count) in chosen.into_iter().enumerate() {
                figures.rounds[k + 1] += u64::from(count > 0);
            }
            figures.widest = figures.widest.max(all as u64);
            figures.points += all as u64;
        }
        self.pace.count(sums[MOST] as u64, all as u64);
        self.points.by_class = [0; 3];
        let Settled { waited, refused } = self.demands.settle();
        for (keeper, waiter) in waited {
            self.counts.releases += 1;
            self.send(keeper, DomainNews::Release(waiter));
        }
        self.tell_refusals(&refused);
        self.tell_touched();
        self.demands.release();
        self.stage = Stage::Counting;
        // R21: one that has not waited for the others is told now.
        if !C::awaits_reservations() {
            self.count(sums);
            if self.is_done(sums) {
                return self.end(Ending::Done);
            }
        }
        // Every round inserts a point, asks for something or refuses it; of a circle one item is
        // split or refused.
        if all == 0 && sums[NEWS] == 0 && !self.circles.are_inserted() {
            self.end(Ending::Irregular);
        }
    }

    /// Where it is, and what it waits for.
    pub(super) fn progress(&self) -> String {
        let (waves, has_put) = (self.figures.barriers, self.waves.tree.has_put());
        format!(
            "{:?} after {} exchanges and {waves} barriers, {}; awaits keys of {:?}; \
             {} probes open, {} to launch, {} points to give, {} items, {:?}",
            self.stage,
            self.exchange.number,
            if has_put { "waits at a barrier" } else { "at no barrier" },
            self.exchange.awaited,
            self.choice.open,
            self.choice.to_launch.len(),
            self.points.chosen.len(),
            self.demands.pending.len(),
            self.counts,
        )
    }

    pub(super) fn end(&mut self, ending: Ending) {
        self.ending = Some(ending);
        self.stage = Stage::Over;
        self.choice.to_launch.clear();
    }
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests;
