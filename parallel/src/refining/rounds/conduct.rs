//! The messages of the conductor.

use super::contest::Contest;
use super::source::Rounds;
use crate::protocol::{Rules, WorkerId};
use crate::refining::domain::DomainMesh;
use crate::refining::news::{DomainNews, Entrant, Report};

impl<C: Rules> Rounds<C> {
    /// The conductor hears of a worker's entrants. When all have told the contest begins, or where
    /// there are no turns all hear which of theirs are probed.
    pub(super) fn take_entrants(
        &mut self,
        mesh: &DomainMesh<'_>,
        from: WorkerId,
        entrants: Vec<Entrant>,
    ) {
        let told = &mut self.conductor.told;
        told.resize(self.workers as usize, None);
        told[from.index()] = Some(entrants);
        if told.iter().all(Option::is_some) {
            let told = std::mem::take(told).into_iter().flatten().collect();
            let contest = Contest::of(told);
            if !self.has_turns(mesh) {
                return self.tell_leaders(&contest);
            }
            self.conductor.contest = contest;
            self.conduct();
        }
    }

    /// The conductor hears what a probe has found.
    pub(super) fn take_report(&mut self, from: WorkerId, report: Report) {
        self.conductor.contest.take(from, report);
        if self.conductor.contest.awaited == 0 {
            self.conduct();
        }
    }

    /// Has the next wave launched, or tells all what becomes of their candidates.
    fn conduct(&mut self) {
        // Ends: each wave has a rank at least.
        while let Some(launched) = self.conductor.contest.next_wave() {
            let mut launched: Vec<_> = launched.into_iter().collect();
            launched.sort_unstable_by_key(|own| own.0);
            for (home, numbers) in launched {
                self.send(home, DomainNews::Launch(numbers));
            }
            if self.conductor.contest.awaited > 0 {
                return;
            }
        }
        let fates = self.conductor.contest.fates();
        self.conductor.contest = Contest::default();
        for (home, fates) in (0..).map(WorkerId::new).zip(fates) {
            self.send(home, DomainNews::Fates(fates));
        }
    }
}
