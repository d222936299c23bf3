//! The insertion of a round: unconditional, in any order.

use super::{CHECK_EVERY, Candidate, Choice, Class, InsertOrder, Look, Rounds};
use crate::RefineError;
use crate::complex::carrier::Carrier;
use crate::mesh::facet::Change;
use crate::mesh::item::Item;
use crate::mesh::state::Place;
use crate::rules::bounded::Bounded;
use crate::rules::verdict::{Filling, Judge};
use ltbw_core::order::hilbert;
use ltbw_core::random::Random;
use ltbw_core::topology::{TetId, VertexId};

/// A round of fewer points is not sorted along a curve.
const FEW: usize = 16;
/// Insertions between two looks at the new tetrahedra, which are in the cache then: of one thread
/// in its own, of several in the one that they share.
const BATCH: usize = 32;
const LARGE_BATCH: usize = if cfg!(test) { 6 } else { 512 };
/// Insertions whose new tetrahedra are worth more than one thread.
const MANY: usize = if cfg!(test) { 4 } else { 256 };

impl Rounds<'_, '_> {
    /// Inserts the chosen candidates; `true` if the work is cancelled, and some are left. The mesh
    /// is a sound one then, too, but a function of the time.
    ///
    /// # Errors
    /// A point that takes an item out of the mesh, or that lies at a vertex: the choice is wrong.
    pub(super) fn insert(&mut self, class: Class, look: Look<'_>) -> Result<bool, RefineError> {
        if self.choice.chosen.is_empty() {
            return Ok(false);
        }
        self.count_round();
        let order = self.in_order(class);
        // The boundary comes first, but in the orders of tests.
        let inner = order.iter().position(|&k| self.is_inner(k)).unwrap_or(order.len());
        let (boundary, tets) = order.split_at(inner);
        let mut count = 0;
        for (list, before) in [(boundary, 0), (tets, boundary.len())] {
            if count < before || before > 0 && look(self.own.state.mesh.num_vertices()) {
                break;
            }
            let is_wide = class != Class::Slivers && list.len() >= MANY;
            count += match is_wide && self.may_use_lanes(list) {
                true => {
                    self.look_at_created();
                    self.insert_in_lanes(list, look)?
                }
                false => self.insert_each(list, look)?,
            };
        }
        self.stats.round_points += count as u64;
        if !self.own.state.is_complete() {
            return Err(RefineError::Invariant { what: "no round loses an item of the boundary" });
        }
        Ok(count < order.len())
    }

    /// Is a candidate's item inside?
    pub(super) fn is_inner(&self, k: usize) -> bool {
        matches!(self.choice.candidates[k].item, Item::Tet(..))
    }

    /// Counts a round that inserts the chosen candidates.
    fn count_round(&mut self) {
        let mut has = [0; 3];
        for &k in &self.choice.chosen {
            has[match self.choice.candidates[k].item {
                Item::Segment(_) => 0,
                Item::Subface(_) => 1,
                Item::Tet(..) => 2,
            }] = 1;
        }
        self.stats.rounds += 1;
        self.stats.rounds_with = [0, 1, 2].map(|k| self.stats.rounds_with[k] + has[k]);
        self.stats.widest = self.stats.widest.max(self.choice.chosen.len() as u64);
    }

    /// Inserts candidates one after the other; returns their number, which is less than all if the
    /// work is cancelled.
    fn insert_each(&mut self, order: &[usize], look: Look<'_>) -> Result<usize, RefineError> {
        let batch = if self.threads == 1 || order.len() < MANY { BATCH } else { LARGE_BATCH };
        for done in 0..order.len() {
            if done % batch == batch - 1 {
                self.look_at_created();
            }
            if done % CHECK_EVERY == CHECK_EVERY - 1 && look(self.own.state.mesh.num_vertices()) {
                return Ok(done);
            }
            self.fetch(&order[(done + 1).min(order.len())..]);
            self.insert_one(order[done], None)?;
        }
        Ok(order.len())
    }

    /// Asks the processor to fetch the cavities of the next candidates. A hint.
    fn fetch(&self, next: &[usize]) {
        let state = &self.own.state;
        let cavity = |k: usize| self.choice.cavity(k);
        if let Some(&k) = next.get(1) {
            for &t in cavity(k) {
                state.mesh.prefetch(t);
                state.marks.prefetch(t);
                self.reserved.prefetch(t);
            }
        }
        // The next cavity is in the cache by now: its neighbours are fetched.
        if let Some(&k) = next.first() {
            for &t in cavity(k) {
                for beside in self.neighbours(t) {
                    state.mesh.prefetch(beside);
                    self.reserved.prefetch(beside);
                }
            }
        }
    }

    /// Inserts candidate `k`: into the cavity that its probe has found, if the round has changed
    /// nothing there, else into the one that is found now. Its vertex is `v` if that was made
    /// before.
    pub(super) fn insert_one(&mut self, k: usize, v: Option<VertexId>) -> Result<(), RefineError> {
        let Self { own, choice, reserved, nothing, .. } = self;
        let Choice { candidates, cavities, .. } = choice;
        let Candidate { item, alone, ref place, ref cavity, ref mut filling, .. } = candidates[k];
        let state = &mut own.state;
        let changed = |t: TetId| reserved.is_written(t);
        let open = state.begin_again(place, &cavities[cavity.clone()], &changed);
        let (mut open, is_same) =
            open.map_err(|_| RefineError::Invariant { what: "chosen points are new" })?;
        if alone && !is_same {
            return Err(RefineError::Invariant { what: "a point is alone where it has to be" });
        }
        let mut filling = std::mem::take(filling);
        if !is_same && place.carrier != Carrier::Free {
            open.owner_mut().look(place);
            let judge = Judge::on_open(open.owner(), &own.record);
            let seen = RefineError::Invariant { what: "a point on a facet sees its planar cavity" };
            filling = judge.filling(item, place).ok_or(seen)?;
        }
        match v {
            None => own.inserted.fill(open, place, &filling, None, nothing),
            Some(v) => {
                own.inserted.fill_vertex(open, v, &filling, nothing);
            }
        }
        self.note_created();
        self.demands.remove(&item);
        self.own.record.limits.remove(&item);
        Ok(())
    }

    fn in_order(&self, class: Class) -> Vec<usize> {
        let mut order = self.choice.chosen.clone();
        match self.order {
            InsertOrder::Forwards => {}
            InsertOrder::Backwards => order.reverse(),
            InsertOrder::Random(seed) => {
                let rounds = self.stats.rounds;
                Random::new(seed.wrapping_mul(1 << 20).wrapping_add(rounds)).shuffle(&mut order);
            }
            InsertOrder::Nth(mut n) => {
                // The digits of n, with as many values as there are places left.
                for at in 0..order.len() {
                    let left = order.len() - at;
                    let next = at + (n % left as u64) as usize;
                    n /= left as u64;
                    order[at..=next].rotate_right(1);
                }
            }
            InsertOrder::Hilbert => {
                // Tetrahedra are probed along the curve.
                let is_sorted = |&k: &usize| class != Class::Slivers && self.is_inner(k);
                let end = order.iter().position(is_sorted).unwrap_or(order.len());
                let first = &mut order[..end];
                if first.len() >= FEW {
                    let points: Vec<_> =
                        first.iter().map(|&k| self.choice.candidates[k].place.p).collect();
                    let sorted: Vec<usize> =
                        hilbert(&points).into_iter().map(|k| first[k as usize]).collect();
                    first.copy_from_slice(&sorted);
                }
            }
        }
        order
    }
}

impl Judge<'_> {
    /// The changes that come with a chosen boundary point whose cavity is open: of each facet it
    /// lies on, the subfaces inside the cavity go. `None` if it does not see all of their rim.
    fn filling(&self, item: Item, place: &Place) -> Option<Filling> {
        let split = match item {
            Item::Segment(ends) => Some((ends, self.closure.segment(ends)?)),
            Item::Subface(_) => None,
            Item::Tet(..) => return None,
        };
        let mut changes = Vec::new();
        for &facet in self.closure.plc().facets_of(&place.carrier) {
            let removed = self.inner_of(facet);
            let rim = self.rim(facet, &removed, &place.p, item)?;
            changes.push(Change { removed, rim, ..Change::of(facet) });
        }
        let lost = self.losses(split.map(|(ends, _)| ends), &changes);
        Some(Filling { split, changes, lost })
    }
}
