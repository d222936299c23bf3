//! Joint steps: boundary items whose points would take each other out of the mesh are split
//! together.
//!
//! On a thin plate, and where long segments run side by side, one item waits for the next and the
//! last for the first. Such items are split one after the other as while the boundary is recovered:
//! what is lost is split in its turn. If nothing is missing afterwards the step is done; else all
//! of it is taken back, and the item that asked for it is refused.

use super::split::{Refinement, Step};
use crate::mesh::item::{Item, Queues};
use crate::mesh::journal::Journal;
use crate::mesh::limit::Limit;
use crate::mesh::state::State;
use crate::outcome::Reason;
use crate::rules::record::{Refusal, TIP_SHARE};
use ltbw_core::cavity::Setback;
use ltbw_core::topology::TetId;

/// The most transactions of a joint step, and of one whose subfaces are split opposite to its
/// points.
const MOST: [usize; 2] = [256, 1024];

impl Refinement<'_> {
    /// Splits the foremost item of a circle jointly, or refuses it. Says whether points were
    /// inserted.
    ///
    /// # Errors
    /// The mesh is full, or does not tell enough: it is as before.
    pub(crate) fn part_circle(&mut self, item: Item, work: &mut Queues) -> Result<bool, Setback> {
        let limit = self.record.limits.get(&item).copied();
        let step = self.split_jointly(item, work);
        match step {
            Step::SetBack(setback) => return Err(setback),
            Step::Refused(reason) => {
                self.record.refused.insert(item, Refusal { reason, limit });
            }
            Step::Inserted | Step::Gone | Step::Deferred => {}
        }
        self.record.limits.remove(&item);
        Ok(step == Step::Inserted)
    }

    /// Splits `item` and all that is lost by it; the mesh is as before if that fails. If it
    /// cannot be done with subfaces split near their centres it is tried once more, with their
    /// points opposite to those that took them.
    pub(crate) fn split_jointly(&mut self, item: Item, work: &mut Queues) -> Step {
        let mut step = Step::Gone;
        for is_opposite in [false, true] {
            step = self.step_jointly(item, is_opposite, work);
            if !matches!(step, Step::Refused(Reason::Interlocked { .. })) {
                break;
            }
        }
        step
    }

    fn step_jointly(&mut self, item: Item, is_opposite: bool, work: &mut Queues) -> Step {
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
            match self.rule(next, &mut own) {
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
            // One that ends early may leave items that nobody is to split any more. (At the start
            // others may wait for them.)
            if self.state.by_place {
                journal.entered.iter().for_each(|&item| self.state.encroachment.remove(item));
            }
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

#[cfg(test)]
mod tests {
    use super::MOST;
    use crate::Refiner;
    use crate::complex::carrier::Carrier;
    use crate::mesh::item::{Item, Queues};
    use crate::mesh::limit::Limit;
    use crate::mesh::marks::Word;
    use crate::mesh::state::State;
    use crate::outcome::Reason;
    use crate::queue::split::Step;
    use crate::run::Run;
    use ltbw_core::invariants::check_all;
    use ltbw_core::topology::{TetId, VertexId};
    use ltbw_domain::{Domain, Facet, PrepareOptions, Prepared};

    /// The thickness of a layer.
    const THICKNESS: f64 = 1.0 / 16.0;

    /// Layers on a unit square.
    fn stack(layers: u32) -> Prepared {
        let mut domain = Domain::default();
        let mut facet = |corners: [u32; 4]| domain.facets.push(Facet::polygon(&corners, 0));
        for k in (0..=layers).map(|k| 4 * k) {
            facet([k, k + 1, k + 2, k + 3]);
            for side in 0..if k > 0 { 4 } else { 0 } {
                let next = (side + 1) % 4;
                facet([k - 4 + side, k - 4 + next, k + next, k + side]);
            }
        }
        for z in (0..=layers).map(|k| THICKNESS * f64::from(k)) {
            let corners = [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
            domain.vertices.extend(corners);
        }
        domain.prepare(&PrepareOptions::default()).expect("a sound domain")
    }

    /// A refinement of such layers after some transactions.
    fn begun(ready: &Prepared, layers: u32, turns: usize) -> Run<'static> {
        let refiner = Refiner::new().max_volume(THICKNESS * f64::from(layers) / 100.0);
        let found = refiner.recovered(&ready.domain, &ready.lattice);
        let (mut run, _) = found.expect("a mesh with its boundary");
        for _ in 0..turns {
            assert!(turn(&mut run), "nothing is left to do");
        }
        run
    }

    /// One transaction; `false` if nothing is left to do.
    fn turn(run: &mut Run<'_>) -> bool {
        let next = run.work.next_boundary().or_else(|| run.work.next_tet());
        next.is_some_and(|item| run.step(item).is_ok())
    }

    /// Tries to split an item jointly.
    fn step(run: &mut Run<'_>, item: Item, is_opposite: bool, most: usize) -> Step {
        let own = &mut run.refinement;
        own.joint_most = most;
        own.step_jointly(item, is_opposite, &mut Queues::default())
    }

    fn items(state: &State) -> Vec<Item> {
        let mut all: Vec<Item> = state.segments.keys().map(|&s| Item::Segment(s)).collect();
        all.extend(state.subfaces.keys().map(|&s| Item::Subface(s)));
        state.sort(&mut all);
        all
    }

    /// The tetrahedra with their marks.
    fn picture(state: &State) -> Vec<(TetId, [VertexId; 4], Word)> {
        let all = state.mesh.tet_ids();
        all.map(|t| (t, state.vertices(t), state.marks.of(t))).collect()
    }

    /// The smallest stack has long segments side by side, which displace each other: no transaction
    /// splits one alone, and they are split together.
    #[test]
    fn segments_side_by_side_are_split_together_or_not_at_all() {
        let ready = stack(2);
        let all = items(&begun(&ready, 2, 0).refinement.state);
        let mut together = 0;
        for item in all {
            let Item::Segment(ends) = item else { continue };
            let mut run = begun(&ready, 2, 0);
            let before = picture(&run.refinement.state);
            let alone = step(&mut run, item, false, 1);
            if alone == Step::Inserted {
                continue;
            }
            let state = &run.refinement.state;
            let Step::Refused(Reason::Interlocked { at }) = alone else { panic!("{alone:?}") };
            let [a, b] = ends.map(|v| state.at(v));
            assert_eq!(at.point(), [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0 * state.fine_step));
            assert!(picture(state) == before && state.is_complete(), "it is not taken back");
            let vertices = state.mesh.num_vertices();
            assert_eq!(step(&mut run, item, false, usize::MAX), Step::Inserted);
            let state = &run.refinement.state;
            assert!(state.mesh.num_vertices() > vertices + 1 && state.is_complete());
            check_all(&state.mesh).expect("invariants of the mesh");
            together += 1;
        }
        assert!(together > 0, "each was split alone");
    }

    /// In three layers there comes an item whose circle has no end near the centres of what it
    /// loses: all of that is taken back, limits included, and points straight across are few.
    #[test]
    fn what_has_no_end_near_its_centres_is_split_opposite() {
        let ready = stack(3);
        let mut run = begun(&ready, 3, 0);
        // Its turns are as many as a whole refinement has.
        let is_long = |run: &mut Run<'_>| {
            let before = run.refinement.record.joint_transactions;
            assert!(turn(run), "no joint step was tried twice");
            run.refinement.record.joint_transactions > before + MOST[0]
        };
        let turns = (0..1000).position(|_| is_long(&mut run)).expect("a step tried twice");
        let mut run = begun(&ready, 3, turns);
        let mut found = 0;
        for item in items(&run.refinement.state) {
            run.refinement.record.limits.insert(item, Limit::all(1e9));
            let (before, limits) =
                (picture(&run.refinement.state), run.refinement.record.limits.clone());
            let first = step(&mut run, item, false, usize::MAX);
            if first == Step::Inserted {
                run = begun(&ready, 3, turns);
                continue;
            }
            for (is_opposite, most) in [(false, usize::MAX), (true, 1)] {
                let end = step(&mut run, item, is_opposite, most);
                assert!(matches!(end, Step::Refused(Reason::Interlocked { .. })), "{end:?}");
                assert!(picture(&run.refinement.state) == before, "it is not taken back");
                assert!(run.refinement.record.limits == limits, "other limits");
            }
            let vertices = run.refinement.state.mesh.num_vertices();
            assert_eq!(step(&mut run, item, true, usize::MAX), Step::Inserted);
            let state = &run.refinement.state;
            assert!(state.is_complete());
            check_all(&state.mesh).expect("invariants of the mesh");
            let all = (1..state.mesh.num_vertices() + 1).map(VertexId::at);
            for v in all.clone().skip(vertices) {
                let p = state.at(v);
                let is_across = |q: VertexId| state.at(q)[..2] == p[..2];
                assert!(matches!(state.carriers[v.index()], Carrier::Facet(_)), "{p:?}");
                assert!(
                    all.clone().any(|q| q != v && is_across(q)),
                    "nothing is across from {p:?}"
                );
            }
            found += 1;
            run = begun(&ready, 3, turns);
        }
        assert!(found > 0);
    }
}
