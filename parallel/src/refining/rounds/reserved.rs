//! The values that say who has reserved a tetrahedron.

use ltbw_core::topology::VertexId;
use ltbw_domain::refine::{Carrier, Lead, Rank};

/// Values by slot that are all forgotten at once.
#[derive(Debug, Default)]
pub(super) struct Marks {
    /// The values plus `base`; what is less is forgotten.
    pub(super) all: Vec<u32>,
    base: u32,
    /// More than all of them.
    end: u32,
}

/// The largest base: there is room for as many values beyond.
const LARGEST: u32 = u32::MAX / 2;

impl Marks {
    /// Forgets all; there is room for numbers below `room`.
    pub(super) fn clear(&mut self, room: usize) {
        if self.all.len() < room {
            self.all.resize(room, 0);
        }
        if self.end > LARGEST {
            self.all.fill(0);
            self.end = 0;
        }
        self.base = self.end.max(1);
        self.end = self.base;
    }

    pub(super) fn get(&self, place: usize) -> Option<u32> {
        self.all.get(place)?.checked_sub(self.base)
    }

    /// Marks a place, which may be marked already, with a value of at most `u32::MAX / 2`.
    pub(super) fn set(&mut self, place: usize, value: u32) {
        let entry = self.base + value;
        self.all[place] = entry;
        self.end = self.end.max(entry + 1);
    }

    /// Marks a place, if it is not; was it not?
    pub(super) fn mark(&mut self, place: usize, value: u32) -> bool {
        let is_new = self.all[place] < self.base;
        if is_new {
            self.set(place, value);
        }
        is_new
    }
}

/// A candidate's rank, of which the leading part is at hand.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LazyRank {
    pub(super) lead: Lead,
    whole: Whole,
}

#[derive(Clone, Debug, PartialEq)]
enum Whole {
    /// That of a tetrahedron here: its vertices never change.
    OfTet([VertexId; 4]),
    Told(Box<Rank>),
}

impl LazyRank {
    /// That of a tetrahedron here with these vertices.
    pub(super) fn of_tet(lead: Lead, v: [VertexId; 4]) -> Self {
        Self { lead, whole: Whole::OfTet(v) }
    }

    pub(super) fn told(rank: Rank) -> Self {
        Self { lead: rank.lead(), whole: Whole::Told(Box::new(rank)) }
    }

    /// The whole rank; `of_tet` tells that of a tetrahedron.
    pub(super) fn whole(&self, of_tet: impl Fn([VertexId; 4]) -> Rank) -> Rank {
        match &self.whole {
            Whole::OfTet(v) => of_tet(*v),
            Whole::Told(rank) => **rank,
        }
    }
}

/// Candidates that have reserved something, by their numbers.
#[derive(Debug, Default)]
pub(super) struct Holders {
    /// The leading parts of their ranks, which nearly always decide.
    pub(super) leads: Vec<Lead>,
    pub(super) all: Vec<(LazyRank, Carrier)>,
}

impl Holders {
    pub(super) fn clear(&mut self) {
        self.leads.clear();
        self.all.clear();
    }

    /// Adds one.
    pub(super) fn push(&mut self, rank: LazyRank, carrier: Carrier) {
        self.leads.push(rank.lead);
        self.all.push((rank, carrier));
    }

    /// The number of the next one.
    pub(super) fn next(&self) -> u32 {
        self.leads.len() as u32
    }

    /// Does a holder come before a candidate of this rank? `of_tet` tells that of a tetrahedron.
    pub(super) fn is_before(
        &self,
        number: u32,
        rank: &LazyRank,
        of_tet: impl Fn([VertexId; 4]) -> Rank,
    ) -> bool {
        let own = self.leads[number as usize];
        if own != rank.lead {
            return own < rank.lead;
        }
        self.all[number as usize].0.whole(&of_tet) < rank.whole(&of_tet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_forgotten_at_once() {
        let mut own = Marks::default();
        own.clear(3);
        assert_eq!([0, 1, 2, 3].map(|k| own.get(k)), [None; 4]);
        own.set(0, 7);
        assert!(own.mark(1, 0) && !own.mark(1, 5));
        assert_eq!([0, 1, 2].map(|k| own.get(k)), [Some(7), Some(0), None]);
        own.clear(4);
        assert_eq!([0, 1, 2, 3].map(|k| own.get(k)), [None; 4]);
        own.set(3, LARGEST - 1);
        assert_eq!(own.get(3), Some(LARGEST - 1));
        // No room is left beyond: all begins again.
        own.clear(4);
        own.set(2, 1);
        assert_eq!([0, 1, 2, 3].map(|k| own.get(k)), [None, None, Some(1), None]);
    }
}
