//! The choice of a round: candidates, probes, and the kill rule.
//!
//! A tetrahedron is dropped if a candidate with a larger key has it in its cavity: where cavities
//! only overlap, both points are taken. Boundary items are taken one after the other, the largest
//! key first; one whose cavity meets that of a point taken before waits for the next round, unless
//! both points are on one segment, or in one facet and the cavity there has not this subface.

use super::{CHECK_EVERY, Class, Look, Rounds};
use crate::refine::carrier::distance2;
use crate::refine::item::Item;
use crate::refine::key::{key, sorted};
use crate::refine::measure::circumcircle;
use ltbw_core::topology::{TetId, tet_of};

impl Rounds<'_, '_> {
    /// Chooses the candidates of a class that are to be inserted; `true` if the work is cancelled.
    pub(super) fn choose(&mut self, class: Class, look: Look<'_>) -> bool {
        for &t in &self.cavities {
            self.reserved[t as usize] = 0;
        }
        self.candidates.clear();
        self.chosen.clear();
        self.blocks.clear();
        self.cavities.clear();
        if class == Class::Tets {
            self.choices += 1;
            let foremost = std::mem::take(&mut self.foremost);
            for (k, &(_, t)) in foremost.iter().enumerate() {
                if k % CHECK_EVERY == CHECK_EVERY - 1 && look(self.own.state.mesh.num_vertices()) {
                    return true;
                }
                if self.reserved[t as usize] == 0 {
                    self.probe_tet(t);
                }
            }
            self.foremost = foremost;
            return false;
        }
        for (item, near) in self.ready() {
            match item {
                Item::Segment(s) if class == Class::Segments => self.probe_segment(s, near),
                Item::Subface(s) if class == Class::Subfaces => self.probe_subface(s, near),
                _ => {}
            }
        }
        false
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

    /// Finds the tetrahedra over their bounds that come before all their face neighbours, the
    /// largest key first; forgets those that are gone.
    pub(super) fn find_foremost(&mut self) {
        let mut bad = std::mem::take(&mut self.bad);
        let mut foremost = std::mem::take(&mut self.foremost);
        foremost.clear();
        let topology = self.own.state.mesh.topology();
        bad.retain(|&(own, t)| {
            let tet = topology.at(t);
            if self.keys[t as usize] != own || tet.is_free() {
                return false;
            }
            let is_first = tet.neighbours().into_iter().map(tet_of).all(|other| {
                let key = self.keys[other as usize];
                key < own || key == own && self.place(t) > self.place(other)
            });
            if is_first {
                foremost.push((own, t));
            }
            true
        });
        foremost.sort_unstable_by(|&(j, a), &(k, b)| {
            k.cmp(&j).then_with(|| self.place(b).cmp(&self.place(a)))
        });
        (self.bad, self.foremost) = (bad, foremost);
    }

    fn place(&self, t: TetId) -> impl Ord {
        self.own.state.place_of(Item::Tet(t, self.own.state.vertices(t)))
    }

    /// Takes the last candidate, whose cavity is its own from now on, where none before it has it.
    pub(super) fn take(&mut self) {
        self.chosen.push(self.candidates.len() - 1);
        self.reserve(0);
    }

    /// Writes the last candidate, with `bits`, into the slots of its cavity.
    pub(super) fn reserve(&mut self, bits: u32) {
        let Some(candidate) = self.candidates.last() else { return };
        let own = self.candidates.len() as u32 | bits;
        for &t in &self.cavities[candidate.cavity.clone()] {
            // Candidates come in turns: the one that is there already is before this one.
            let reserved = &mut self.reserved[t as usize];
            *reserved = if *reserved == 0 { own } else { *reserved };
        }
    }

    /// Does a candidate before the last one have slot `t` in its cavity?
    pub(super) fn has_rival(&self, t: TetId) -> bool {
        self.reserved[t as usize] != 0
    }

    /// Is the last candidate killed by none before it, and loses no item together with others?
    pub(super) fn survives(&self) -> bool {
        let Some(own) = self.candidates.last() else { return false };
        let is_killed = match own.item {
            Item::Subface(s) => self.tets_at(own, s).iter().all(|&t| self.has_rival(t)),
            Item::Tet(..) | Item::Segment(_) => false,
        };
        // Only what is marked can be lost.
        let loses = self.own.state.touched.is_marked && self.loses_jointly(own);
        !(is_killed || loses)
    }
}
