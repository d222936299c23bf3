//! After the insertions: which tetrahedra are over their bounds, with which keys.

use super::Rounds;
use super::ranked::Bad;
use crate::RefineError;
use crate::mesh::item::Item;
use crate::mesh::key::{key_of_tet, order_key};
use crate::mesh::marks::{ENDS, FACES};
use crate::outcome::Reason;
use crate::rules::record::Refusal;
use crate::table::{Set, edge};
use crate::thin::{Thin, ThinTets};
use ltbw_core::topology::{Tet, TetId};
use rayon::prelude::*;

/// Tetrahedra that one thread looks at at a time.
const SHARE: usize = if cfg!(test) { 5 } else { 512 };

/// The most times that refusals for rounding are forgotten.
const RETRIES: usize = 4;

/// Lists for the tetrahedra over their bounds, those of them that points cannot help, and those
/// that may have tiny dihedral angles.
type Found<'f> = (&'f mut Vec<Bad>, &'f mut Vec<(Item, Reason)>, &'f mut Vec<Thin>);

impl Rounds<'_, '_> {
    /// Notes the slots that the last insertion, or joint step, has written.
    pub(super) fn note_created(&mut self) {
        let slots = self.own.state.mesh.topology().slots();
        self.reserved.grow(slots);
        for &t in &self.own.inserted.created {
            if self.reserved.note_written(t, 0) {
                self.created.push(t);
                // These are written when the tetrahedron is looked at.
                self.keys.prefetch_all(t);
            }
        }
    }

    /// Looks at the tetrahedra made since the last look, as long as they are in the cache.
    pub(super) fn look_at_created(&mut self) {
        self.keys.grow(self.own.state.mesh.topology().slots());
        let mut created = std::mem::take(&mut self.created);
        self.keys.begin_look();
        created.iter().for_each(|&t| self.keys.touch(t));
        let first = self.keys.count();
        self.look_at(&created);
        // Several threads look for them together in the next round.
        if self.threads == 1 || created.len() < 2 * SHARE {
            self.keys.find_witnesses(&self.own.state, first);
        }
        created.clear();
        self.created = created;
        self.reserved.pass_looks(1);
    }

    /// Gives those of some tetrahedra that are over their bounds their keys; those that points
    /// cannot help are refused at once.
    pub(super) fn look_at(&mut self, tets: &[TetId]) {
        let mut thin = std::mem::take(&mut self.own.inserted.thin.tets);
        let (mut bad, mut refused) = (self.keys.take(), Vec::new());
        let this = &*self;
        if this.threads > 1 && tets.len() >= 2 * SHARE {
            let look = |list: &[TetId]| {
                let (mut bad, mut refused, mut thin) = (Vec::new(), Vec::new(), Vec::new());
                this.look_at_list(list, (&mut bad, &mut refused, &mut thin));
                (bad, refused, thin)
            };
            let found: Vec<_> = tets.par_chunks(SHARE).map(look).collect();
            for (own_bad, own_refused, own_thin) in found {
                bad.extend(own_bad);
                refused.extend(own_refused);
                thin.extend(own_thin);
            }
        } else {
            this.look_at_list(tets, (&mut bad, &mut refused, &mut thin));
        }
        self.keys.put(bad);
        self.own.inserted.thin.tets = thin;
        let refused = refused.into_iter().map(|(item, why)| (item, Refusal::final_for(why)));
        self.own.record.refused.extend(refused);
    }

    /// Ends a round.
    pub(super) fn settle(&mut self) {
        self.look_at_created();
        self.own.inserted.thin.forget_old(|(t, v)| self.own.state.is_live(t, v));
        self.check_names(|t| self.reserved.is_written(t));
        let state = &self.own.state;
        for &t in state.mesh.topology().free_slots() {
            self.keys.forget(t);
        }
        // Items that are gone are asked for no more, and their refusals forgotten.
        let is_there = |item: &Item| match item {
            Item::Segment(s) => state.segments.contains_key(s),
            Item::Subface(s) => state.subfaces.contains_key(s),
            Item::Tet(..) => false,
        };
        self.demands.pending.retain(|item, _| is_there(item));
        let is_tet = |item: &Item| matches!(item, Item::Tet(..));
        self.own.record.refused.retain(|item, _| is_tet(item) || is_there(item));
        self.keys.count_looks_anew();
    }

    /// In debug builds: are marks and tables what the carriers tell, at some tetrahedra?
    fn check_names(&self, is_looked_at: impl Fn(TetId) -> bool) {
        if let Some(names) = &self.names {
            let state = &self.own.state;
            let mut all = state.mesh.topology().iter().map(|(t, _)| t);
            let other = all.find(|&t| is_looked_at(t) && names.differ(state, t));
            assert!(other.is_none(), "the boundary at {other:?} is not what its carriers tell");
        }
    }

    /// Makes room for all slots.
    pub(super) fn make_room(&mut self) {
        let slots = self.own.state.mesh.topology().slots();
        self.keys.grow(slots);
        self.reserved.grow(slots);
    }

    /// Looks at all tetrahedra.
    pub(super) fn look_at_all(&mut self) {
        self.make_room();
        self.keys.clear();
        self.own.inserted.thin = ThinTets::default();
        let all: Vec<TetId> = self.own.state.mesh.tet_ids().collect();
        self.look_at(&all);
    }

    /// Gives slots their keys, which are 0 but for those with a tetrahedron over its bounds that
    /// was not refused before.
    fn look_at_list(&self, tets: &[TetId], (bad, refused, thin): Found<'_>) {
        tets.iter().for_each(|&t| self.keys.set(t, 0));
        let state = &self.own.state;
        let topology = state.mesh.topology();
        let Some(bounds) = &self.own.bounds else { return };
        let taken = tets.iter().copied().filter(|&t| !topology.at(t).is_free());
        for (t, v) in bounds.over_of(state, taken, thin) {
            if self.own.record.refused.contains_key(&Item::Tet(t, v)) {
                continue;
            }
            if !state.angles.is_empty() {
                let mut by_place = v;
                by_place.sort_unstable_by_key(|&v| order_key(&state.at(v)));
                if let Some(reason) = self.own.beyond_help(t, by_place) {
                    refused.push((Item::Tet(t, v), reason));
                    continue;
                }
            }
            self.keys.set(t, key_of_tet(v.map(|v| state.at(v))));
            bad.push(self.keys.entry(t));
        }
    }

    /// A second chance for boundary items that no point served, when nothing else is left to do:
    /// one that would have torn a patch may fit by now. `false` if there is none, or nothing has
    /// changed since, or often enough.
    pub(super) fn retry(&mut self) -> bool {
        let points = self.own.inserted.points.total();
        if self.late.retried.len() == RETRIES || self.late.retried.last() == Some(&points) {
            return false;
        }
        let (state, record) = (&self.own.state, &mut self.own.record);
        let before = record.refused.len();
        record.refused.retain(|item, own| !own.reason.is_vague() || matches!(item, Item::Tet(..)));
        if record.refused.len() == before {
            return false;
        }
        self.late.retried.push(points);
        let mut tets = Vec::new();
        record.refused.retain(|&item, _| match item {
            Item::Tet(t, v) if state.is_live(t, v) => {
                tets.push(t);
                false
            }
            _ => true,
        });
        tets.sort_unstable();
        self.look_at(&tets);
        true
    }

    /// The tetrahedra over their bounds: those that were refused, and those not yet split.
    pub(super) fn over(&self) -> Vec<TetId> {
        let state = &self.own.state;
        let refused = self.own.record.refused.keys().filter_map(|&item| match item {
            Item::Tet(t, v) => state.is_live(t, v).then_some(t),
            _ => None,
        });
        let is_left = |&t: &TetId| self.keys.at(t) != 0 && !state.mesh.topology().at(t).is_free();
        let left = self.keys.entries().filter(is_left);
        let mut over: Vec<TetId> = refused.chain(left).collect();
        over.sort_unstable();
        over.dedup();
        over
    }

    /// Checks that the mesh has every subsegment and subface.
    ///
    /// # Errors
    /// One is missing: a round has lost it.
    pub(super) fn check_complete(&self) -> Result<(), RefineError> {
        self.check_names(|_| true);
        let state = &self.own.state;
        let count = |(mut faces, mut edges): (usize, Vec<_>), (t, tet): (TetId, &Tet)| {
            let (word, v) = (state.marks.of(t), tet.vertices());
            faces += (word & FACES).count_ones() as usize;
            let marked = ENDS.into_iter().enumerate().filter(|(k, _)| word >> (4 + k) & 1 == 1);
            edges.extend(marked.map(|(_, [i, j])| edge(v[i], v[j])));
            (faces, edges)
        };
        let all: Vec<_> = match self.threads > 1 {
            true => state.mesh.topology().par_iter().fold(Default::default, count).collect(),
            false => vec![state.mesh.topology().iter().fold(Default::default(), count)],
        };
        let faces: usize = all.iter().map(|own| own.0).sum();
        let edges: Set<_> = all.into_iter().flat_map(|own| own.1).collect();
        let whole = faces == 2 * state.subfaces.len() && edges.len() == state.segments.len();
        match whole {
            true => Ok(()),
            false => Err(RefineError::Invariant { what: "the mesh has all of the boundary" }),
        }
    }
}
