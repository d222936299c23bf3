//! Joint steps: boundary items whose points would take each other out of the mesh are split
//! together.
//!
//! On a thin plate, and where long segments run side by side, one item waits for the next and the
//! last for the first. Such items are split one after the other as while the boundary is recovered:
//! what is lost is split in its turn. If nothing is missing afterwards the step is done; else all
//! of it is taken back, and the item that asked for it is refused.

use super::item::{Item, Queues, Work};
use super::journal::Journal;
use super::limit::Limit;
use super::outcome::Reason;
use super::record::TIP_SHARE;
use super::split::{Refinement, Step};
use super::state::State;
use ltbw_core::cavity::Admission;
use ltbw_core::topology::TetId;

/// The most transactions of a joint step, and of one whose subfaces are split opposite to its
/// points.
const MOST: [usize; 2] = [256, 1024];

impl Refinement<'_> {
    /// Splits `item` and all that is lost by it; the mesh is as before if that fails. If it
    /// cannot be done with subfaces split near their centres it is tried once more, with their
    /// points opposite to those that took them.
    pub(crate) fn split_jointly<W: Work, A: Admission>(
        &mut self,
        item: Item,
        work: &mut W,
        admission: &mut A,
    ) -> Step {
        let mut step = Step::Gone;
        for is_opposite in [false, true] {
            step = self.step_jointly(item, is_opposite, work, admission);
            if !matches!(step, Step::Refused(Reason::Interlocked { .. })) {
                break;
            }
        }
        step
    }

    fn step_jointly<W: Work, A: Admission>(
        &mut self,
        item: Item,
        is_opposite: bool,
        work: &mut W,
        admission: &mut A,
    ) -> Step {
        let limit = self.record.limits.get(&item).map(|limit| limit.times(TIP_SHARE));
        self.state.journal = Some(Journal { limit, is_opposite, ..Journal::default() });
        let before = self.inserted.points;
        let mut own = Queues::default();
        own.put(item, 1.0);
        let (mut failed, mut is_drained) = (None, false);
        self.record.waits.clear();
        for _ in 0..MOST[usize::from(is_opposite)].min(self.joint_most) {
            self.record.joint_transactions += 1;
            let next = match self.state.by_place {
                true => own.next_by_place(|item| self.state.place_of(item)),
                false => own.next_boundary(),
            };
            let Some(next) = next else {
                is_drained = true;
                break;
            };
            match self.rule(next, &mut own, admission) {
                Step::Inserted | Step::Gone => self.state.encroachment.remove(next),
                Step::Deferred => {}
                step @ (Step::Refused(_) | Step::SetBack(_)) => {
                    failed = Some(step);
                    break;
                }
            }
        }
        let Some(mut journal) = self.state.journal.take() else { return Step::Gone };
        self.record.restore_limits(std::mem::take(&mut journal.limits));
        // A step that ends early without a point has come to nothing: not to be tried for ever.
        let is_step = is_drained || !journal.insertions.is_empty();
        let complete = failed.is_none() && is_step && self.state.is_complete();
        let live = journal.created.iter().filter(|&&(t, v)| self.state.is_live(t, v));
        let live: Vec<TetId> = live.map(|&(t, _)| t).collect();
        if complete && self.state.relabel(&journal) && self.state.is_labelled(live) {
            self.state.settle_dust(journal.created.iter().map(|&(t, _)| t));
            // Slots of ghosts, too: a tetrahedron may have been there.
            let written = journal.insertions.iter().flat_map(|(undo, _)| undo.created());
            self.inserted.created = written.collect();
            if let Some(bounds) = &self.bounds {
                let live = journal.created.iter().filter(|&&(t, v)| self.state.is_live(t, v));
                let live = live.map(|&(t, _)| t);
                for (t, v) in bounds.over_of(&self.state, live, &mut self.inserted.thin.tets) {
                    work.put(Item::Tet(t, v), bounds.excess_of(&self.state, t));
                }
            }
            return Step::Inserted;
        }
        self.inserted.next_number -= journal.insertions.len() as u32;
        self.inserted.points = before;
        self.record.waits.clear();
        self.state.take_back(journal);
        match failed {
            Some(Step::Refused(reason)) if !reason.is_vague() => Step::Refused(reason),
            Some(Step::Refused(_)) | None => Step::Refused(self.state.interlocked(item)),
            Some(step) => step,
        }
    }
}

impl State {
    /// The edges that the joint step under way may make, if there is one and it is limited.
    pub(crate) fn joint_limit(&self) -> Option<Limit> {
        self.journal.as_ref().and_then(|journal| journal.limit)
    }

    /// Takes back all of a joint step.
    fn take_back(&mut self, journal: Journal) {
        for (key, before) in journal.segments.into_iter().rev() {
            match before {
                Some(s) => self.segments.insert(key, s),
                None => self.segments.remove(&key),
            };
        }
        for (key, before) in journal.subfaces.into_iter().rev() {
            match before {
                Some(f) => self.subfaces.insert(key, f),
                None => self.subfaces.remove(&key),
            };
        }
        for (undo, words) in journal.insertions.iter().rev() {
            self.mesh.take_back(undo);
            self.carriers.pop();
            undo.cavity().zip(words).for_each(|(t, &word)| self.marks.restore(t, word));
        }
        // Nothing was missing before.
        self.missing.clear();
        self.missing_segments.clear();
        journal.entered.into_iter().for_each(|item| self.encroachment.remove(item));
    }
}
