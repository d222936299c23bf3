//! The values that say who has reserved a tetrahedron.

use ltbw_domain::refine::{Carrier, Rank};
use std::cmp::{Ordering, Reverse};

/// Values by slot or vertex that are all forgotten at once.
#[derive(Debug, Default)]
pub(super) struct Marks {
    /// The time of each, and the value.
    pub(super) all: Vec<(u32, u32)>,
    now: u32,
}

impl Marks {
    /// Forgets all; there is room for numbers below `room`.
    pub(super) fn clear(&mut self, room: usize) {
        if self.all.len() < room {
            self.all.resize(room, (0, 0));
        }
        match self.now.checked_add(1) {
            Some(now) => self.now = now,
            None => {
                self.all.fill((0, 0));
                self.now = 1;
            }
        }
    }

    pub(super) fn get(&self, place: usize) -> Option<u32> {
        let &(time, value) = self.all.get(place)?;
        (time == self.now).then_some(value)
    }

    /// Marks a place, which may be marked already.
    pub(super) fn set(&mut self, place: usize, value: u32) {
        self.all[place] = (self.now, value);
    }

    /// Marks a place, if it is not; was it not?
    pub(super) fn mark(&mut self, place: usize, value: u32) -> bool {
        let is_new = self.all[place].0 != self.now;
        if is_new {
            self.set(place, value);
        }
        is_new
    }
}

/// Candidates that have reserved something, by their numbers.
#[derive(Debug, Default)]
pub(super) struct Holders {
    /// The leading parts of their ranks, which most comparisons need alone.
    pub(super) leads: Vec<Lead>,
    pub(super) all: Vec<(Rank, Carrier)>,
}

/// The leading part of a rank: the smaller one comes first.
pub(super) type Lead = (bool, Reverse<u64>);

/// The leading part of a rank.
fn lead(rank: &Rank) -> Lead {
    (!rank.is_boundary(), Reverse(rank.key()))
}

impl Holders {
    pub(super) fn clear(&mut self) {
        self.leads.clear();
        self.all.clear();
    }

    /// Adds one; returns its number.
    pub(super) fn push(&mut self, rank: Rank, carrier: Carrier) -> u32 {
        self.leads.push(lead(&rank));
        self.all.push((rank, carrier));
        self.leads.len() as u32 - 1
    }

    /// The order of a holder, given by its number, and a candidate of this rank.
    pub(super) fn compare(&self, number: u32, rank: &Rank) -> Ordering {
        let (own, other) = (self.leads[number as usize], lead(rank));
        // Among boundary items classes come before keys.
        match own.0 == other.0 && (!own.0 || own.1 == other.1) {
            true => self.all[number as usize].0.cmp(rank),
            false => own.cmp(&other),
        }
    }

    /// Does a holder come before a candidate of this rank?
    pub(super) fn is_before(&self, number: u32, rank: &Rank) -> bool {
        self.compare(number, rank).is_lt()
    }
}
