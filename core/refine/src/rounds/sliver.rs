//! Slivers in rounds: when all bounds are met, the tetrahedra with small dihedral angles are
//! candidates, each with the point that serves it best in the mesh at the start of the round.
//!
//! A point is inserted only where no other one is, so that its tetrahedra are those looked at, and
//! no sliver follows from another.

use super::batch::{Prober, Seen};
use super::{CHECK_EVERY, Candidate, Look, Rounds};
use crate::mesh::item::Item;
use crate::mesh::state::Place;
use crate::rules::aim::TOLERANCE;
use crate::rules::verdict::{Filling, Verdict};
use crate::thin::Thin;
use ltbw_core::PredicateStats;
use ltbw_core::topology::TetId;
use rayon::prelude::*;

/// Points that serve a sliver, of which the best is taken.
const ENOUGH: usize = 4;
/// Points tried on each boundary item beside it.
const BESIDE: usize = 8;
/// Slivers that a thread looks at at a time; fewer are not worth another thread.
const BATCH: usize = if cfg!(test) { 3 } else { 16 };

/// The point that serves a sliver best.
struct Served {
    /// The boundary item that it splits, or the sliver.
    item: Item,
    place: Place,
    cavity: Vec<TetId>,
    filling: Filling,
    /// The square of the cosine of its sharpest angle.
    cos2: f64,
}

impl Rounds<'_, '_> {
    /// Is any sliver left? They are looked for once, when all bounds are met.
    pub(super) fn has_slivers(&mut self) -> bool {
        if self.late.slivers.is_none() {
            self.late.slivers = Some(self.own.slivers());
        }
        self.late.slivers.as_ref().is_some_and(|slivers| !slivers.is_empty())
    }

    /// Chooses points for slivers; `true` if the work is cancelled. A sliver is looked at again as
    /// long as others are in the way of its point.
    pub(super) fn choose_slivers(&mut self, look: Look<'_>) -> bool {
        let mut slivers = self.late.slivers.take().unwrap_or_default();
        slivers.retain(|&(t, v)| self.own.state.is_live(t, v));
        self.reserved.start(slivers.len(), 0);
        let vertices = self.own.state.mesh.num_vertices();
        let mut left = Vec::new();
        for (k, list) in slivers.chunks(CHECK_EVERY).enumerate() {
            if k > 0 && look(vertices) {
                self.late.slivers = Some(slivers);
                return true;
            }
            for (&sliver, served) in list.iter().zip(self.serve_slivers(list)) {
                if let Some(served) = served {
                    self.take_served(served, left.len() as u32);
                    left.push(sliver);
                }
            }
        }
        self.late.slivers = Some(left);
        let stats = std::mem::take(&mut self.prober.search.stats);
        self.own.state.mesh.add_stats(stats);
        for k in 0..self.choice.candidates.len() {
            if self.survives(k) {
                self.choice.chosen.push(k);
            }
        }
        false
    }

    /// The best points for some slivers, in their order.
    fn serve_slivers(&mut self, list: &[Thin]) -> Vec<Option<Served>> {
        let mut own = std::mem::take(&mut self.prober);
        let this = &*self;
        let serve = |prober: &mut Prober, list: &[Thin]| {
            let served: Vec<_> = list.iter().map(|&(t, _)| this.serve(t, prober)).collect();
            (served, std::mem::take(&mut prober.search.stats))
        };
        let batches: Vec<(Vec<Option<Served>>, PredicateStats)> =
            match self.threads > 1 && list.len() >= 2 * BATCH {
                true => list.par_chunks(BATCH).map_init(Prober::default, serve).collect(),
                false => vec![serve(&mut own, list)],
            };
        self.prober = own;
        let mut all = Vec::with_capacity(list.len());
        for (served, stats) in batches {
            self.own.state.mesh.add_stats(stats);
            all.extend(served);
        }
        all
    }

    fn take_served(&mut self, served: Served, rank: u32) {
        let Served { item, place, cavity, filling, .. } = served;
        let cavity = self.choice.add_cavity(&cavity);
        // One that is alone has nobody to watch.
        let (fits, watch, alone) = (true, None, true);
        let own = Candidate { item, rank, fits, watch, alone, place, cavity, filling };
        self.choice.candidates.push(own);
        self.reserved.note_alone(rank, alone);
        self.reserve_last();
    }

    /// The best of the first points that serve a sliver: inside, else on the boundary, where items
    /// are beside it or keep points inside away; there at last in the balls of other items.
    fn serve(&self, t: TetId, prober: &mut Prober) -> Option<Served> {
        let state = &self.own.state;
        let ball = state.ball_of(t)?;
        let (mut best, mut barred_by) = (Best::default(), Vec::new());
        for place in state.places_for(t, &ball) {
            best.take(self.try_inside(t, place, prober, &mut barred_by));
            if best.is_enough() {
                break;
            }
        }
        if best.served.is_some() {
            return best.served;
        }
        let tolerance = ball.radius * TOLERANCE;
        let mut items = barred_by;
        items.extend(state.beside(t, &ball.centre, tolerance));
        state.sort(&mut items);
        items.dedup();
        for gives_way in [true, false] {
            let mut seed = 1;
            for &item in &items {
                for k in 0..BESIDE {
                    let place = state.place_beside(item, k, &mut seed, t, tolerance);
                    let Some(place) = place else { continue };
                    let Some(from) = state.holder(t, &place.p) else { continue };
                    let trial = Trial { item, place: Place { from, ..place }, gives_way };
                    best.take(self.try_on_boundary(t, trial, prober));
                    if best.is_enough() {
                        return best.served;
                    }
                }
            }
            if best.served.is_some() {
                break;
            }
        }
        best.served
    }

    /// A point inside for a sliver, if it serves; else `barred_by` is told of the items that keep
    /// it away.
    fn try_inside(
        &self,
        t: TetId,
        place: Place,
        prober: &mut Prober,
        barred_by: &mut Vec<Item>,
    ) -> Option<Served> {
        let seen = prober.see(&self.own.state, &place, |_| false).ok()?;
        let filling = match seen.judge(&self.own.record).on_tet(t, &place) {
            Verdict::Fill(filling) => filling,
            Verdict::Defer(items) => {
                barred_by.extend(items);
                return None;
            }
            Verdict::Useless | Verdict::Refuse(_) => return None,
        };
        let item = Item::Tet(t, self.own.state.vertices(t));
        self.served(&seen, item, place, filling)
    }

    /// A point on the boundary for a sliver, if it serves.
    fn try_on_boundary(&self, t: TetId, trial: Trial, prober: &mut Prober) -> Option<Served> {
        let Trial { item, place, gives_way } = trial;
        let seen = prober.see(&self.own.state, &place, |_| false).ok()?;
        if !seen.tets.contains(&t) {
            return None;
        }
        let judge = seen.judge(&self.own.record);
        let filling = judge.filling_beside(Some(item), &place, |_| !gives_way)?;
        self.served(&seen, item, place, filling)
    }

    /// A point with what comes with it, if its tetrahedra are as they have to be.
    fn served(
        &self,
        seen: &Seen<'_>,
        item: Item,
        place: Place,
        filling: Filling,
    ) -> Option<Served> {
        let judge = seen.judge(&self.own.record);
        let bounds = self.own.bounds.as_ref()?;
        let cos2 = judge.sharpest_of_star(&place, &filling.changes, bounds, &self.terms()?)?;
        Some(Served { item, place, cavity: seen.tets.to_vec(), filling, cos2 })
    }
}

/// A point that is tried on a boundary item.
struct Trial {
    item: Item,
    place: Place,
    /// May it lie in no ball of another item?
    gives_way: bool,
}

/// The best point so far.
#[derive(Default)]
struct Best {
    served: Option<Served>,
    count: usize,
}

impl Best {
    fn take(&mut self, served: Option<Served>) {
        let Some(served) = served else { return };
        self.count += 1;
        if self.served.as_ref().is_none_or(|best| served.cos2 < best.cos2) {
            self.served = Some(served);
        }
    }

    fn is_enough(&self) -> bool {
        self.count == ENOUGH
    }
}
