//! The insertion of a round: unconditional, in any order.

use super::{Candidate, Class, InsertOrder, Rounds};
use crate::refine::RefineError;
use crate::refine::carrier::Carrier;
use crate::refine::facet::{Change, Seed};
use crate::refine::item::Item;
use crate::refine::state::{Place, State};
use crate::refine::verdict::Filling;
use ltbw_core::cavity::Open;
use ltbw_core::order::hilbert;
use ltbw_core::random::Random;

/// A round of fewer points is not sorted along a curve.
const FEW: usize = 16;

impl Rounds<'_, '_> {
    /// Inserts the chosen candidates.
    ///
    /// # Errors
    /// A point that takes an item out of the mesh, or that lies at a vertex: the choice is wrong.
    pub(super) fn insert(&mut self, class: Class, chosen: &[usize]) -> Result<(), RefineError> {
        if chosen.is_empty() {
            return Ok(());
        }
        self.stats.rounds[class as usize] += 1;
        self.stats.widest = self.stats.widest.max(chosen.len() as u64);
        self.stats.round_points += chosen.len() as u64;
        for k in self.in_order(chosen) {
            let Candidate { item, place, .. } = self.candidates[k].clone();
            self.insert_one(item, place)?;
            self.pending.remove(&item);
            self.own.record.limits.remove(&item);
        }
        if !self.own.state.is_complete() {
            return Err(RefineError::Invariant { what: "no round loses an item of the boundary" });
        }
        Ok(())
    }

    fn insert_one(&mut self, item: Item, place: Place) -> Result<(), RefineError> {
        let own = &mut *self.own;
        let place = Place { from: own.state.start_near(place.from), ..place };
        let on_boundary = place.carrier != Carrier::Free;
        let open = match on_boundary {
            true => own.state.begin_and_look(&place, &mut Open),
            false => own.state.begin(&place, &mut Open),
        };
        let open = open.map_err(|_| RefineError::Invariant { what: "chosen points are new" })?;
        let filling = match on_boundary {
            true => open.owner().filling(item, &place),
            false => Some(Filling::default()),
        };
        let seen = RefineError::Invariant { what: "a point on a facet sees its planar cavity" };
        let filling = filling.ok_or(seen)?;
        own.inserted.fill(open, &place, &filling, None, &mut self.nothing);
        self.created.extend_from_slice(&own.inserted.created);
        Ok(())
    }

    fn in_order(&self, chosen: &[usize]) -> Vec<usize> {
        let mut order = chosen.to_vec();
        match self.order {
            InsertOrder::Forwards => {}
            InsertOrder::Backwards => order.reverse(),
            InsertOrder::Random(seed) => {
                let rounds = self.stats.rounds.iter().sum::<u64>();
                Random::new(seed.wrapping_mul(1 << 20).wrapping_add(rounds)).shuffle(&mut order);
            }
            InsertOrder::Hilbert if chosen.len() < FEW => {}
            InsertOrder::Hilbert => {
                let points: Vec<_> = chosen.iter().map(|&k| self.candidates[k].place.p).collect();
                order = hilbert(&points).into_iter().map(|k| chosen[k as usize]).collect();
            }
        }
        order
    }
}

impl State {
    /// The changes that come with a chosen boundary point whose cavity is open: of each facet it
    /// lies on, the subfaces inside the cavity go. `None` if it does not see all of their rim.
    fn filling(&self, item: Item, place: &Place) -> Option<Filling> {
        let (split, seed) = match item {
            Item::Segment(ends) => (Some((ends, *self.segments.get(&ends)?)), Seed::Along(ends)),
            Item::Subface(s) => (None, Seed::At(s)),
            Item::Tet(..) => return None,
        };
        let mut changes = Vec::new();
        for facet in self.facets_of(place.carrier) {
            let own = self.touched.inner.iter().filter(|(_, g)| *g == facet);
            let removed: Vec<_> = own.map(|(s, _)| *s).collect();
            let rim = self.rim(facet, &removed, &place.p, seed)?;
            changes.push(Change { removed, rim, ..Change::of(facet) });
        }
        let lost = self.losses(split.map(|(ends, _)| ends), &changes);
        Some(Filling { split, changes, lost })
    }
}
