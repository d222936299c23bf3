//! The choice of a round: candidates, probes, and the kill rule.
//!
//! A candidate is dropped if one with a larger key has its tetrahedron or subface in its cavity:
//! where cavities only overlap, both points are taken.

use super::{Class, Rounds};
use crate::refine::item::Item;
use ltbw_core::topology::{TetId, tet_of};

impl Rounds<'_, '_> {
    /// The candidates of a class that are to be inserted.
    pub(super) fn choose(&mut self, class: Class) -> Vec<usize> {
        for &t in &self.cavities {
            self.reserved[t as usize] = 0;
        }
        self.candidates.clear();
        self.cavities.clear();
        match class {
            Class::Tets => {
                let own = self.bad.iter().copied();
                let foremost: Vec<TetId> = own.filter(|&t| self.is_foremost(t)).collect();
                foremost.into_iter().for_each(|t| self.probe_tet(t));
            }
            Class::Segments | Class::Subfaces => {
                let ready = self.pending.iter().filter(|(_, pending)| self.is_ready(pending));
                let items: Vec<_> = ready.map(|(&item, pending)| (item, pending.near)).collect();
                for (item, near) in items {
                    match item {
                        Item::Segment(s) if class == Class::Segments => self.probe_segment(s, near),
                        Item::Subface(s) if class == Class::Subfaces => self.probe_subface(s, near),
                        _ => {}
                    }
                }
            }
        }
        let all = 0..self.candidates.len();
        all.filter(|&k| self.candidates[k].fits && self.survives(k)).collect()
    }

    /// Does a tetrahedron come before all its face neighbours?
    fn is_foremost(&self, t: TetId) -> bool {
        let own = self.keys[t as usize];
        self.own.state.mesh.topology().at(t).neighbours().into_iter().map(tet_of).all(|other| {
            let key = self.keys[other as usize];
            key < own || key == own && self.place(t) > self.place(other)
        })
    }

    fn place(&self, t: TetId) -> impl Ord {
        self.own.state.place_of(Item::Tet(t, self.own.state.vertices(t)))
    }

    /// Does candidate `j` come before candidate `k`?
    pub(super) fn beats(&self, j: usize, k: usize) -> bool {
        let [a, b] = [j, k].map(|k| &self.candidates[k]);
        let place = |item| self.own.state.place_of(item);
        a.key > b.key || a.key == b.key && place(a.item) > place(b.item)
    }

    /// Writes candidate `k` into the slots of its cavity.
    pub(super) fn reserve(&mut self, k: usize) {
        for at in self.candidates[k].cavity.clone() {
            let t = self.cavities[at] as usize;
            let before = self.reserved[t];
            if before == 0 || self.beats(k, before as usize - 1) {
                self.reserved[t] = k as u32 + 1;
            }
        }
    }

    /// The candidate before `k` that has slot `t` in its cavity, if any.
    pub(super) fn rival(&self, k: usize, t: TetId) -> Option<usize> {
        let foremost = (self.reserved[t as usize] as usize).checked_sub(1)?;
        (foremost != k && self.beats(foremost, k)).then_some(foremost)
    }

    /// Is candidate `k` killed by none before it, and loses no item together with others?
    fn survives(&self, k: usize) -> bool {
        match self.candidates[k].item {
            Item::Tet(t, _) => self.rival(k, t).is_none() && !self.loses_jointly(k),
            Item::Segment(_) => self.is_apart(k) && !self.loses_jointly(k),
            Item::Subface(s) => {
                let is_killed = || {
                    let tets = self.tets_at(k, s);
                    !tets.is_empty() && tets.iter().all(|&t| self.rival(k, t).is_some())
                };
                self.is_apart(k) && !is_killed() && !self.loses_jointly(k)
            }
        }
    }
}
