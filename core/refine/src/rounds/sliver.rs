//! Slivers in rounds: when all bounds are met, the tetrahedra with tiny dihedral angles are
//! candidates, each with the first point that serves it in the mesh at the start of the round.
//!
//! A point is inserted only where no other one is, so that its tetrahedra are those looked at, and
//! no sliver follows from another.

use super::{CHECK_EVERY, Candidate, Look, Rounds};
use crate::complex::carrier::{Carrier, free_point};
use crate::complex::measure::{RatioBound, Shape};
use crate::late::sliver::{REACH, TRIES, in_unit_ball};
use crate::mesh::item::Item;
use crate::mesh::key::sorted;
use crate::mesh::state::Place;
use crate::rules::aim::TOLERANCE;
use crate::rules::verdict::Verdict;
use crate::rules::walk::Way;
use ltbw_core::topology::{TetId, VertexId};

/// A sliver, and the points that are left to be tried for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sliver {
    t: TetId,
    v: [VertexId; 4],
    tries: u32,
    seed: u64,
}

impl Rounds<'_, '_> {
    /// Is any sliver left? They are looked for once, when all bounds are met.
    pub(super) fn has_slivers(&mut self) -> bool {
        if self.late.slivers.is_none() {
            let own = |(t, v)| Sliver { t, v, tries: TRIES, seed: 1 };
            self.late.slivers = Some(self.own.slivers().into_iter().map(own).collect());
        }
        self.late.slivers.as_ref().is_some_and(|slivers| !slivers.is_empty())
    }

    fn ratio(&self) -> Option<RatioBound> {
        self.own.bounds.as_ref().and_then(|bounds| bounds.ratio)
    }

    /// Chooses points for slivers; `true` if the work is cancelled. A sliver is looked at again as
    /// long as others are in the way of its point.
    pub(super) fn choose_slivers(&mut self, look: Look<'_>) -> bool {
        let mut slivers = self.late.slivers.take().unwrap_or_default();
        slivers.retain(|own| self.own.state.is_live(own.t, own.v));
        self.reserved.start(slivers.len(), 0);
        let (mut rank, mut cancelled) = (0, false);
        // Tries are no searches for points that are needed.
        let searches = self.stats.searches;
        slivers.retain_mut(|own| {
            if rank as usize % CHECK_EVERY == CHECK_EVERY - 1 {
                cancelled |= look(self.own.state.mesh.num_vertices());
            }
            rank += 1;
            cancelled || self.probe_sliver(own, rank - 1)
        });
        self.late.slivers = Some(slivers);
        self.stats.searches = searches;
        let stats = std::mem::take(&mut self.prober.search.stats);
        self.own.state.mesh.add_stats(stats);
        if cancelled {
            return true;
        }
        for k in 0..self.choice.candidates.len() {
            if self.survives(k) {
                self.choice.chosen.push(k);
            }
        }
        false
    }

    /// Proposes points for a sliver until one serves; `false` if none does.
    fn probe_sliver(&mut self, own: &mut Sliver, rank: u32) -> bool {
        let Some(ratio) = self.ratio() else { return false };
        let corners = sorted(own.v.map(|v| self.own.state.at(v)));
        let [a, b, c, d] = &corners;
        let shape = Shape::of([a, b, c, d]);
        let radius = shape.radius();
        let Some(centre) = shape.circumcentre(d) else { return false };
        while let Some(left) = own.tries.checked_sub(1) {
            let mut seed = own.seed;
            let offset = in_unit_ball(&mut seed);
            let target = [0, 1, 2].map(|k| centre[k] + REACH * radius * offset[k]);
            if let Some(p) = free_point(&target, radius * TOLERANCE)
                && let Way::Arrived(from) = self.own.state.way(own.t, &p)
            {
                let place = Place { p, carrier: Carrier::Free, from };
                if let Ok(seen) = self.prober.see(&self.own.state, &place, |_| false)
                    && let judge = seen.judge(&self.own.record)
                    && let Verdict::Fill(filling) = judge.on_tet(own.t, &place)
                    && judge.makes_no_sliver(&p, &ratio)
                {
                    let (item, watch) =
                        (Item::Tet(own.t, own.v), seen.survey.watch_in_tet(&seen.closure));
                    let cavity = self.choice.add_cavity(seen.tets);
                    let (fits, alone) = (true, true);
                    let own = Candidate { item, rank, fits, watch, alone, place, cavity, filling };
                    self.choice.candidates.push(own);
                    self.reserved.note_alone(rank, alone);
                    self.reserve_last();
                    return true;
                }
            }
            (own.tries, own.seed) = (left, seed);
        }
        false
    }
}
