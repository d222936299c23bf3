//! The choice of a round: candidates, probes, and the kill rule.
//!
//! Boundary items come before tetrahedra. Where only few are left, the tetrahedra go on in the same
//! round, away from them: else many rounds would have a few points each.
//!
//! Of tetrahedra the candidates are probed on the mesh at the start of the round, in any order, or
//! at patches in waves: one is dropped if a candidate with a larger key has it in its cavity. Where
//! cavities only overlap, both points are taken. A boundary item whose cavity meets that of one
//! with a larger key waits for the next round, unless both points are on one segment, or in one
//! facet and the cavity there has not this subface.

use super::demands::Ready;
use super::{CHECK_EVERY, Class, Look, Rounds};
use crate::complex::carrier::Carrier;
use crate::mesh::item::Item;
use crate::rules::turns::{Contender, Held, next_wave};
use ltbw_core::topology::TetId;
use rayon::prelude::*;
use std::cmp::Reverse;

/// Tetrahedra are split in one round with boundary items where they were at least this number for
/// each of these, when last counted.
const BESIDE: usize = if cfg!(test) { 1 } else { 32 };
/// Candidates that are worth more than one thread.
const MANY: usize = if cfg!(test) { 4 } else { 512 };

/// Are tetrahedra split in one round with this number of boundary items? `counted` of them came
/// before all around them when last counted.
#[doc(hidden)]
pub fn are_joined(items: usize, counted: usize) -> bool {
    items * BESIDE <= counted
}

impl Rounds<'_, '_> {
    /// Chooses the candidates of a class that are to be inserted; `true` if the work is cancelled.
    pub(super) fn choose(&mut self, class: Class, look: Look<'_>) -> bool {
        self.choice.clear();
        match class {
            Class::Slivers => self.choose_slivers(look),
            Class::Tets => {
                self.reserved.start(self.front.leaders.len(), 0);
                self.choose_tets(look)
            }
            Class::Boundary => {
                let ready = self.ready();
                // At patches points are alone in their closures.
                let joined = !self.in_waves && are_joined(ready.len(), self.front.counted);
                if joined {
                    self.find_foremost();
                }
                let tets = if joined { self.front.leaders.len() } else { 0 };
                self.reserved.start(ready.len() + tets, ready.len());
                self.probe_boundary(&ready, look) || joined && self.choose_tets(look)
            }
        }
    }

    /// Probes the leaders among the foremost tetrahedra, then takes those that are killed by none.
    /// Their ranks follow those of boundary items.
    fn choose_tets(&mut self, look: Look<'_>) -> bool {
        let (ranks, order) = self.ranks();
        let others = self.choice.candidates.len();
        self.check_blocks();
        let of_tets = self.reserved.of_tets();
        let (start, all) = (of_tets.start as usize, of_tets.end as usize);
        let (mut first, mut wave) = (start, ranks.len());
        if self.in_waves {
            wave = next_wave(0, all);
        }
        while first < all {
            let has = |k: u32| (first..first + wave).contains(&(ranks[k as usize] as usize));
            // Of the first wave nobody knows yet whether it is killed.
            let is_first = first == start;
            let is_alive =
                |k: u32| is_first || !self.reserved.has_rival(self.leader(k).t, ranks[k as usize]);
            let own = order.iter().copied().filter(|&k| has(k));
            let list: Vec<u32> = own.filter(|&k| is_alive(k)).collect();
            for (k, list) in list.chunks(CHECK_EVERY * self.threads).enumerate() {
                if (first, k) != (start, 0) && look(self.own.state.mesh.num_vertices()) {
                    return true;
                }
                let batches = self.probe_tets(list, &ranks);
                batches.into_iter().for_each(|batch| self.take_batch(batch));
            }
            first += wave;
            wave = next_wave(wave, all);
        }
        if self.reserved.has_alone() {
            self.choose_in_turns();
            self.conclude();
            self.refuse_blocked();
            return false;
        }
        let (this, count) = (&*self, self.choice.candidates.len());
        let is_chosen = |k: usize| this.choice.candidates[k].fits && this.survives(k);
        let chosen: Vec<usize> = match this.threads > 1 && count - others >= MANY {
            true => (others..count).into_par_iter().filter(|&k| is_chosen(k)).collect(),
            false => (others..count).filter(|&k| is_chosen(k)).collect(),
        };
        self.choice.chosen.extend(chosen);
        self.conclude();
        self.refuse_blocked();
        false
    }

    /// Chooses among the candidates of a round in which some have to be alone, the foremost first:
    /// the slots are reserved anew, by those alone that no earlier one of these has killed. Else
    /// whole chains would wait, each one for the next.
    fn choose_in_turns(&mut self) {
        self.reserved.start_again();
        let mut turns: Vec<usize> = (0..self.choice.candidates.len()).collect();
        turns.sort_unstable_by_key(|&k| self.choice.candidates[k].rank);
        for k in turns {
            let own = &self.choice.candidates[k];
            // One that asks for others keeps its place free.
            let stays = match own.item {
                Item::Tet(t, _) if !own.fits => !self.reserved.has_rival(t, own.rank),
                _ => self.survives(k),
            };
            if stays {
                self.reserve(k);
            }
            if stays && self.choice.candidates[k].fits {
                self.choice.chosen.push(k);
            }
        }
        self.choice.chosen.sort_unstable();
    }

    /// The pending items that wait for none, subsegments first, then by their keys.
    fn ready(&self) -> Vec<Ready> {
        let state = &self.own.state;
        let ready = self.demands.ready().map(|own| {
            let (key, place) = (state.key_of(own.item), state.place_of(own.item));
            let is_subface = matches!(own.item, Item::Subface(_));
            ((is_subface, Reverse(key), place), own)
        });
        let mut items: Vec<_> = ready.collect();
        items.sort_unstable_by_key(|own| own.0);
        items.into_iter().map(|(_, own)| own).collect()
    }

    /// Writes the last candidate into the slots of its cavity, where none before it is.
    pub(super) fn reserve_last(&mut self) {
        if let Some(k) = self.choice.candidates.len().checked_sub(1) {
            self.reserve(k);
        }
    }

    pub(super) fn reserve(&mut self, k: usize) {
        let candidate = &self.choice.candidates[k];
        self.reserved.reserve(candidate.rank, self.choice.cavity_of(candidate), true);
    }

    /// Is a candidate killed by none before it, and loses no item together with others?
    pub(super) fn survives(&self, k: usize) -> bool {
        let own = &self.choice.candidates[k];
        if matches!(own.item, Item::Tet(t, _) if self.reserved.has_rival(t, own.rank)) {
            return false;
        }
        let contender = Contender {
            rank: own.rank as usize,
            tet: None,
            carrier: own.place.carrier,
            watch: own.watch.as_ref(),
            is_alone: own.alone,
        };
        let cavity = self.choice.cavity_of(own);
        let closure = || cavity.iter().flat_map(|&t| self.neighbours(t).into_iter().chain([t]));
        let is_crowded = || contender.is_crowded(self, closure);
        let waits = contender.waits(self, closure);
        #[cfg(test)]
        assert!(
            waits == self.waits_by_the_mesh(own) || own.watch.is_none() && is_crowded(),
            "rules (b) to (d) for {own:?}"
        );
        !waits && !is_crowded()
    }
}

impl Held for Rounds<'_, '_> {
    type Tet = TetId;

    #[inline(always)]
    fn holder(&self, t: TetId) -> Option<usize> {
        self.reserved.holder(t)
    }

    fn is_alone(&self, rank: usize) -> bool {
        self.reserved.is_alone(rank)
    }

    fn has_alone(&self) -> bool {
        self.reserved.has_alone()
    }

    fn of_boundary(&self) -> usize {
        self.reserved.of_boundary().end as usize
    }

    /// Boundary items have the first ranks, in the order of the candidates.
    fn carrier(&self, rank: usize) -> Carrier {
        self.choice.candidates[rank].place.carrier
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Workers and the engine ask this alike: at the edge another answer is another mesh.
    #[test]
    fn tetrahedra_join_boundary_items_from_the_exact_number_on() {
        for items in [1, 2, 1000] {
            assert!(are_joined(items, items * BESIDE), "{items}");
            assert!(!are_joined(items, items * BESIDE - 1), "{items}");
        }
    }
}
