//! The reservations of a round.

use crate::refining::flags::Flags;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_core::{expect, prefetch};
use ltbw_refine::{Carrier, Rank, RankLead, Rival};

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

    /// Marks a place with 0, if it is not marked; was it not?
    pub(super) fn mark(&mut self, place: usize) -> bool {
        let is_new = self.all[place] < self.base;
        if is_new {
            self.set(place, 0);
        }
        is_new
    }
}

/// A candidate's rank, of which the leading part is at hand.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LazyRank {
    pub(super) lead: RankLead,
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
    pub(super) fn of_tet(lead: RankLead, v: [VertexId; 4]) -> Self {
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

/// The candidate that reserves: its rank, and where its point lives.
#[derive(Clone, Debug)]
pub(super) struct Whose {
    pub(super) rank: LazyRank,
    pub(super) carrier: Carrier,
}

/// The tetrahedra that the candidates of a round have reserved. The foremost candidate with one in
/// its cavity holds it.
#[derive(Debug, Default)]
pub(super) struct Reservations {
    /// By slot: the number of its holder.
    held: Marks,
    /// By number: the leading parts of ranks, which nearly always decide.
    leads: Vec<RankLead>,
    /// By number: the candidates.
    all: Vec<Whose>,
    /// Slots that boundary items have reserved. Other candidates may hold them by now.
    by_boundary: Flags,
}

impl Reservations {
    /// Takes memory for about this many tetrahedra. A hint.
    pub(super) fn expect_tets(&mut self, tets: usize) {
        expect(&mut self.held.all, tets);
    }

    /// Asks the processor to fetch what is known of a tetrahedron. A hint.
    pub(super) fn prefetch(&self, t: TetId) {
        prefetch(self.held.all.as_ptr().wrapping_add(t.index()));
    }

    /// Forgets all; there are this many slots.
    pub(super) fn clear(&mut self, slots: usize) {
        self.held.clear(slots);
        self.leads.clear();
        self.all.clear();
        self.by_boundary.clear();
    }

    /// Reserves a candidate's cavity; returns its number. `of_tet` tells the rank of a tetrahedron.
    pub(super) fn reserve(
        &mut self,
        cavity: impl Iterator<Item = TetId>,
        whose: Whose,
        of_tet: impl Fn([VertexId; 4]) -> Rank,
    ) -> u32 {
        let (number, lead) = (self.leads.len() as u32, whose.rank.lead);
        let is_boundary = lead.is_boundary();
        self.leads.push(lead);
        self.all.push(whose);
        for t in cavity {
            let other = self.held.get(t.index());
            if other.is_none_or(|other| !self.is_before(other, number, &of_tet)) {
                self.held.set(t.index(), number);
                if is_boundary {
                    self.by_boundary.set(t.index(), true);
                }
            }
        }
        number
    }

    /// Does one holder come before another one?
    fn is_before(&self, one: u32, other: u32, of_tet: impl Fn([VertexId; 4]) -> Rank) -> bool {
        one != other && self.precedes(one, &self.all[other as usize].rank, of_tet)
    }

    fn precedes(
        &self,
        number: u32,
        rank: &LazyRank,
        of_tet: impl Fn([VertexId; 4]) -> Rank,
    ) -> bool {
        let own = self.leads[number as usize];
        if own != rank.lead {
            return own < rank.lead;
        }
        self.all[number as usize].rank.whole(&of_tet) < rank.whole(&of_tet)
    }

    /// The leading part of the rank of a tetrahedron's holder, if that comes before a candidate of
    /// this rank; `own` is the number of the candidate, if it has one.
    pub(super) fn before(
        &self,
        t: TetId,
        own: Option<u32>,
        rank: &LazyRank,
        of_tet: impl Fn([VertexId; 4]) -> Rank,
    ) -> Option<RankLead> {
        let holder = self.held.get(t.index()).filter(|holder| Some(*holder) != own)?;
        self.precedes(holder, rank, of_tet).then(|| self.leads[holder as usize])
    }

    /// The rival of a holder that a tetrahedron has.
    pub(super) fn rival(
        &self,
        t: TetId,
        own: u32,
        of_tet: impl Fn([VertexId; 4]) -> Rank,
    ) -> Rival {
        let Some(other) = self.held.get(t.index()) else { return Rival::default() };
        if !self.is_before(other, own, of_tet) {
            return Rival::default();
        }
        let [at, carrier] = [other, own].map(|number| self.all[number as usize].carrier);
        let is_boundary = self.leads[other as usize].is_boundary();
        Rival { is_there: true, is_boundary, is_apart: !at.is_with(carrier) }
    }

    /// May a boundary item hold a tetrahedron?
    pub(super) fn may_be_boundary(&self, t: TetId) -> bool {
        self.by_boundary.has(t.index())
    }
}

/// A candidate inside.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct InnerCandidate {
    /// Its rank.
    pub rank: Rank,
    /// Its own slot.
    pub own: TetId,
    /// The cavity of its point.
    pub cavity: Vec<TetId>,
}

/// The numbers of those candidates inside that no candidate before them kills: the rule alone, for
/// ports.
#[doc(hidden)]
pub fn unkilled(candidates: &[InnerCandidate]) -> Vec<usize> {
    let mut reservations = Reservations::default();
    let slots = candidates.iter().flat_map(|one| one.cavity.iter().chain([&one.own]));
    reservations.clear(slots.map(|t| t.index() + 1).max().unwrap_or(0));
    // All ranks are told: none is that of a tetrahedron here.
    let of_tet = |_| candidates[0].rank;
    let ranks: Vec<LazyRank> = candidates.iter().map(|one| LazyRank::told(one.rank)).collect();
    for (one, rank) in candidates.iter().zip(&ranks) {
        let whose = Whose { rank: rank.clone(), carrier: Carrier::Free };
        reservations.reserve(one.cavity.iter().copied(), whose, of_tet);
    }
    let dies = |&k: &usize| {
        reservations.before(candidates[k].own, Some(k as u32), &ranks[k], of_tet).is_some()
    };
    (0..candidates.len()).filter(|k| !dies(k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_refine::{BoundaryItem, Corner};

    /// A boundary item takes slots that a tetrahedron's candidate holds, and that nobody does.
    #[test]
    fn boundary_items_are_known_wherever_they_hold() {
        let corner = |x, k| Corner { point: [x, 0.0, 0.0], carrier: Carrier::Corner(k) };
        let item = BoundaryItem::new(&[corner(0.0, 0), corner(4.0, 1)], 0).rank();
        let tet = Rank::of_tet([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let of_tet = |_| tet;
        let reserve = |all: &mut Reservations, slots: [u32; 2], rank| {
            let whose = Whose { rank: LazyRank::told(rank), carrier: Carrier::Free };
            all.reserve(slots.into_iter().map(TetId::new), whose, of_tet)
        };
        for first in [item, tet] {
            let mut all = Reservations::default();
            all.clear(4);
            let second = if first == item { tet } else { item };
            let slots = |rank| if rank == item { [1, 2] } else { [0, 1] };
            let numbers = [first, second].map(|rank| (rank, reserve(&mut all, slots(rank), rank)));
            let known = [0, 1, 2, 3].map(|t| all.may_be_boundary(TetId::new(t)));
            assert_eq!(known, [false, true, true, false], "the item is first: {}", first == item);
            let own = numbers.iter().find(|own| own.0 == tet).expect("the tetrahedron's").1;
            let rival = all.rival(TetId::new(1), own, of_tet);
            assert!(rival.is_there && rival.is_boundary && rival.is_apart);
        }
    }

    #[test]
    fn marks_are_forgotten_at_once() {
        let mut own = Marks::default();
        own.clear(3);
        assert_eq!([0, 1, 2, 3].map(|k| own.get(k)), [None; 4]);
        own.set(0, 7);
        assert!(own.mark(1) && !own.mark(1));
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
