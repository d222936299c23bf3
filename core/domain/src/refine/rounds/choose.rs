//! The choice of a round: candidates, probes, and the kill rule.
//!
//! A tetrahedron is dropped if a candidate with a larger key has it in its cavity: where cavities
//! only overlap, both points are taken. Boundary items are taken one after the other, the largest
//! key first; one whose cavity meets that of a point taken before waits for the next round, unless
//! both points are on one segment, or in one facet and the cavity there has not this subface.

use super::{Class, Rounds};
use crate::refine::carrier::distance2;
use crate::refine::item::Item;
use crate::refine::key::{key, sorted};
use crate::refine::measure::circumcircle;
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
                let mut foremost: Vec<TetId> = own.filter(|&t| self.is_foremost(t)).collect();
                foremost.sort_by(|&a, &b| self.order(a, b));
                for t in foremost {
                    if self.reserved[t as usize] == 0 {
                        self.probe_tet(t);
                    }
                }
                let all = 0..self.candidates.len();
                all.filter(|&k| self.candidates[k].fits && self.survives(k)).collect()
            }
            Class::Segments => {
                for (item, near) in self.ready() {
                    if let Item::Segment(s) = item {
                        self.probe_segment(s, near);
                    }
                }
                (0..self.candidates.len()).collect()
            }
            Class::Subfaces => {
                for (item, near) in self.ready() {
                    if let Item::Subface(s) = item {
                        self.probe_subface(s, near);
                    }
                }
                (0..self.candidates.len()).collect()
            }
        }
    }

    /// The pending items that wait for none, the foremost first, each with a slot near it.
    fn ready(&self) -> Vec<(Item, TetId)> {
        let state = &self.own.state;
        let ready = self.pending.iter().filter(|(_, pending)| self.is_ready(pending));
        let mut items: Vec<_> = ready
            .map(|(&item, pending)| {
                let (key, place) = (self.key_of(item), state.place_of(item));
                (std::cmp::Reverse((key, place)), item, pending.near)
            })
            .collect();
        items.sort_unstable_by_key(|own| own.0);
        items.into_iter().map(|(_, item, near)| (item, near)).collect()
    }

    /// The key of a boundary item.
    fn key_of(&self, item: Item) -> u64 {
        let state = &self.own.state;
        match item {
            Item::Segment(s) => {
                let [a, b] = sorted(s.map(|v| state.at(v)));
                key(distance2(&a, &b), &[a, b])
            }
            Item::Subface(s) => {
                let corners = sorted(s.map(|v| state.at(v)));
                let [a, b, c] = &corners;
                key(circumcircle(a, b, c).1, &corners)
            }
            Item::Tet(t, _) => self.keys[t as usize],
        }
    }

    /// Does a tetrahedron come before all its face neighbours?
    fn is_foremost(&self, t: TetId) -> bool {
        let own = self.keys[t as usize];
        self.own.state.mesh.topology().at(t).neighbours().into_iter().map(tet_of).all(|other| {
            let key = self.keys[other as usize];
            key < own || key == own && self.place(t) > self.place(other)
        })
    }

    /// The order in which tetrahedra are probed: the largest key first.
    fn order(&self, a: TetId, b: TetId) -> std::cmp::Ordering {
        let keys = self.keys[b as usize].cmp(&self.keys[a as usize]);
        keys.then_with(|| self.place(b).cmp(&self.place(a)))
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
    pub(super) fn survives(&self, k: usize) -> bool {
        let is_killed = match self.candidates[k].item {
            Item::Tet(t, _) => self.rival(k, t).is_some(),
            Item::Segment(_) => false,
            Item::Subface(s) => self.tets_at(k, s).iter().all(|&t| self.rival(k, t).is_some()),
        };
        !is_killed && !self.loses_jointly(k)
    }
}
