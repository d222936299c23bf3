//! After the insertions: which tetrahedra are over their bounds, with which keys.

use super::Rounds;
use super::foremost::Bad;
use crate::refine::RefineError;
use crate::refine::item::Item;
use crate::refine::key::{key, order_key, sorted};
use crate::refine::marks::{ENDS, FACES};
use crate::refine::measure::Shape;
use crate::refine::outcome::Reason;
use crate::refine::record::Refusal;
use crate::refine::table::{Set, edge};
use ltbw_core::topology::TetId;
use rayon::prelude::*;

/// Tetrahedra that one thread looks at at a time.
const SHARE: usize = if cfg!(test) { 5 } else { 512 };

/// A tetrahedron over its bounds.
enum Over {
    /// It has a key.
    Bad(TetId, u64),
    /// Points cannot help it.
    Refused(Item, Reason),
}

/// The most times that refusals at patches are forgotten.
const RETRIES: usize = 4;

impl Rounds<'_, '_> {
    /// Notes the slots that the last insertion, or joint step, has written.
    pub(super) fn note_created(&mut self) {
        let slots = self.own.state.mesh.topology().slots();
        self.reserved.resize(slots, 0);
        let written = self.written();
        for &t in &self.own.inserted.created {
            let reserved = &mut self.reserved[t.index()];
            if *reserved != written {
                *reserved = written;
                self.created.push(t);
            }
        }
    }

    /// The entry of slots that the insertions since the last look have written: it is larger than
    /// those of candidates, and than those written before.
    pub(super) fn written(&self) -> u32 {
        self.free + self.count + 1 + self.batch
    }

    /// Looks at the tetrahedra made since the last look, as long as they are in the cache.
    pub(super) fn look_at_created(&mut self) {
        self.keys.resize(self.own.state.mesh.topology().slots(), 0);
        self.stamps.resize(self.keys.len(), 0);
        let mut created = std::mem::take(&mut self.created);
        self.looks += 1;
        for &t in &created {
            self.write_key(t, 0, self.looks);
        }
        let first = self.bad.len();
        self.look_at(&created);
        // Several threads look for them together in the next round.
        if self.threads == 1 || created.len() < 2 * SHARE {
            self.find_witnesses(first);
        }
        created.clear();
        self.created = created;
        self.batch += 1;
    }

    /// Gives those of some tetrahedra that are over their bounds their keys; those that points
    /// cannot help are refused at once.
    fn look_at(&mut self, tets: &[TetId]) {
        let this = &*self;
        if this.threads > 1 && tets.len() >= 2 * SHARE {
            let over = |list: &[TetId]| -> Vec<Over> {
                list.iter().filter_map(|&t| this.over_at(t)).collect()
            };
            let found: Vec<Vec<Over>> = tets.par_chunks(SHARE).map(over).collect();
            found.into_iter().flatten().for_each(|over| self.take_over(over));
        } else {
            for &t in tets {
                if let Some(over) = self.over_at(t) {
                    self.take_over(over);
                }
            }
        }
    }

    fn take_over(&mut self, over: Over) {
        match over {
            Over::Bad(t, key) => {
                self.keys[t.index()] = key;
                self.bad.push(Bad::new(t, self.looks));
            }
            Over::Refused(item, reason) => {
                self.own.record.refused.insert(item, Refusal::final_for(reason));
            }
        }
    }

    /// Ends a round.
    pub(super) fn settle(&mut self) {
        self.look_at_created();
        let Self { own, keys, stamps, looks, .. } = self;
        let state = &own.state;
        for &t in state.mesh.topology().free_slots() {
            (keys[t.index()], stamps[t.index()]) = (0, *looks);
        }
        // Items that are gone are asked for no more.
        self.pending.retain(|item, _| match item {
            Item::Segment(s) => state.segments.contains_key(s),
            Item::Subface(s) => state.subfaces.contains_key(s),
            Item::Tet(..) => false,
        });
    }

    /// Writes the entries of a slot, from this look on.
    pub(super) fn write_key(&mut self, t: TetId, key: u64, look: u32) {
        (self.keys[t.index()], self.stamps[t.index()]) = (key, look);
    }

    /// Looks at all tetrahedra.
    pub(super) fn look_at_all(&mut self) {
        let slots = self.own.state.mesh.topology().slots();
        (self.keys, self.stamps) = (vec![0; slots], vec![0; slots]);
        self.reserved.resize(slots, 0);
        self.bad.clear();
        let all: Vec<TetId> = self.own.state.mesh.tet_ids().collect();
        self.look_at(&all);
    }

    /// The tetrahedron in slot `t`, if it is over its bounds and was not refused before.
    fn over_at(&self, t: TetId) -> Option<Over> {
        let state = &self.own.state;
        let tet = state.mesh.topology().at(t);
        let over = |b: &crate::refine::bounds::Bounds<'_>| b.is_over(state, t);
        if tet.is_free() || tet.is_ghost() || !self.own.bounds.as_ref().is_some_and(over) {
            return None;
        }
        let v = tet.vertices();
        if self.own.record.refused.contains_key(&Item::Tet(t, v)) {
            return None;
        }
        if !state.angles.is_empty() {
            let mut by_place = v;
            by_place.sort_unstable_by_key(|&v| order_key(&state.at(v)));
            if let Some(reason) = self.own.beyond_help(t, by_place) {
                return Some(Over::Refused(Item::Tet(t, v), reason));
            }
        }
        let corners = sorted(v.map(|v| state.at(v)));
        let [a, b, c, d] = &corners;
        let key = key(Shape::of([a, b, c, d]).radius2(), &corners);
        Some(Over::Bad(t, key))
    }

    /// A second chance for what was refused at patches, when nothing else is left to do: a point
    /// that would have torn one may fit by now. `false` if there is none, or nothing has changed
    /// since, or often enough.
    pub(super) fn retry(&mut self) -> bool {
        let points = self.own.inserted.points.total();
        if self.retried.len() == RETRIES || self.retried.last() == Some(&points) {
            return false;
        }
        let (state, record) = (&self.own.state, &mut self.own.record);
        let is_torn = |item: &Item| match item {
            Item::Segment(s) => state.segments.get(s).is_some_and(|&s| {
                state.plc.segments[s as usize].facets.iter().any(|&f| state.is_patch(f))
            }),
            Item::Subface(s) => state.subfaces.get(s).is_some_and(|&f| state.is_patch(f)),
            Item::Tet(..) => false,
        };
        let before = record.refused.len();
        record.refused.retain(|item, own| own.reason != Reason::Rounding || !is_torn(item));
        if record.refused.len() == before {
            return false;
        }
        self.retried.push(points);
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
        let is_left =
            |&t: &TetId| self.keys[t.index()] != 0 && !state.mesh.topology().at(t).is_free();
        let left = self.bad.iter().map(|bad| bad.t).filter(is_left);
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
        let state = &self.own.state;
        let (mut faces, mut edges) = (0, Set::default());
        for (t, tet) in state.mesh.topology().iter() {
            let (word, v) = (state.marks.of(t), tet.vertices());
            faces += (word & FACES).count_ones() as usize;
            for (k, [i, j]) in ENDS.into_iter().enumerate() {
                if word >> (4 + k) & 1 == 1 {
                    edges.insert(edge(v[i], v[j]));
                }
            }
        }
        let whole = faces == 2 * state.subfaces.len() && edges.len() == state.segments.len();
        match whole {
            true => Ok(()),
            false => Err(RefineError::Invariant { what: "the mesh has all of the boundary" }),
        }
    }
}
