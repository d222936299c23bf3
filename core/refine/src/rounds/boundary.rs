//! Probes of boundary items: where each is to be split, and the verdict on that point, on the mesh
//! at the start of the round. All threads look at them, in any order; one waits if another with a
//! larger key is in its way, whatever becomes of that. At patches one thread looks at each in its
//! turn, with the cavity open, and one waits for those that were taken before.

use super::batch::Prober;
use super::probe::Probe;
use super::{CHECK_EVERY, Candidate, Look, Rounds};
use crate::mesh::item::Item;
use crate::mesh::state::Place;
use crate::outcome::Reason;
use crate::rules::aim::{ATTEMPTS, Aim};
use crate::rules::bounded::InMesh;
use crate::rules::verdict::{Judge, Verdict};
use crate::rules::watch::Watch;
use ltbw_core::PredicateStats;
use ltbw_core::topology::{INFINITE, TetId};
use rayon::prelude::*;
use std::ops::Range;

/// Items that a thread looks at at a time; fewer are not worth another thread.
const BATCH: usize = if cfg!(test) { 3 } else { 16 };
/// Candidates that are worth more than one thread.
const MANY: usize = if cfg!(test) { 4 } else { 256 };

/// Where a boundary item is to be split.
enum Proposed {
    /// Nowhere: it is split already.
    Gone,
    Refused(Reason),
    /// Nowhere this time.
    Useless,
    /// Here. A point for a subface is on its facet, or was moved off it: `false`.
    At(Place, bool),
}

/// The outcome of a look at a boundary item.
#[derive(Debug)]
enum Looked {
    Gone,
    Refused(Reason),
    Found(Found),
}

/// A point for a boundary item, with its cavity and the verdict on it.
#[derive(Debug)]
struct Found {
    place: Place,
    /// The cavity in the list of the batch.
    cavity: Range<usize>,
    watch: Watch<TetId>,
    verdict: Verdict,
}

/// The looks at some boundary items, in their order.
#[derive(Debug, Default)]
struct Batch {
    all: Vec<(Item, TetId, Looked)>,
    tets: Vec<TetId>,
    stats: PredicateStats,
}

impl Rounds<'_, '_> {
    /// Probes boundary items, each with a slot near it, and takes those that may be split now;
    /// `true` if the work is cancelled.
    pub(super) fn probe_boundary(&mut self, items: &[(Item, TetId)], heed: Look<'_>) -> bool {
        let vertices = self.own.state.mesh.num_vertices();
        if self.in_waves {
            for (done, &own) in items.iter().enumerate() {
                if done % CHECK_EVERY == CHECK_EVERY - 1 && heed(vertices) {
                    return true;
                }
                self.probe_open(own);
            }
            return false;
        }
        let mut own = std::mem::take(&mut self.prober);
        let this = &*self;
        let look = |prober: &mut Prober, items: &[(Item, TetId)]| {
            let mut batch = Batch::default();
            for &(item, near) in items {
                let looked = this.look_at_item(item, near, prober, &mut batch.tets);
                batch.all.push((item, near, looked));
            }
            batch.stats = std::mem::take(&mut prober.search.stats);
            batch
        };
        let (mut batches, mut cancelled): (Vec<Batch>, _) = (Vec::new(), false);
        for items in items.chunks(CHECK_EVERY * self.threads) {
            cancelled = !batches.is_empty() && heed(vertices);
            if cancelled {
                break;
            }
            match self.threads > 1 && items.len() >= 2 * BATCH {
                true => {
                    let looked = items.par_chunks(BATCH).map_init(Prober::default, look);
                    batches.extend(looked.collect::<Vec<Batch>>());
                }
                false => batches.push(look(&mut own, items)),
            }
        }
        self.prober = own;
        if cancelled {
            return true;
        }
        for batch in batches {
            self.own.state.mesh.add_stats(batch.stats);
            for (item, near, looked) in batch.all {
                self.take_looked((item, near), looked, &batch.tets);
            }
        }
        let (this, count) = (&*self, self.choice.candidates.len());
        let survives = |k: &usize| this.survives(*k);
        let chosen: Vec<usize> = match this.threads > 1 && count >= MANY {
            true => (0..count).into_par_iter().filter(survives).collect(),
            false => (0..count).filter(survives).collect(),
        };
        self.stats.barred += (count - chosen.len()) as u64;
        self.choice.chosen.extend(chosen);
        false
    }

    /// The place that is proposed for a boundary item at this attempt.
    fn proposed(&self, item: Item, near: TetId, attempt: usize) -> Proposed {
        match self.own.aim_at(item, attempt) {
            None => Proposed::Gone,
            Some(Aim::At { point: p, carrier, may }) => {
                Proposed::At(Place { p, carrier, from: near }, may)
            }
            Some(Aim::Skip) => Proposed::Useless,
            Some(Aim::Refused) => Proposed::Refused(Reason::Floor),
            Some(Aim::Exhausted) => {
                let state = &self.own.state;
                let facet = match item {
                    Item::Subface(corners) => state.subfaces.get(&corners),
                    _ => None,
                };
                let reason = facet.and_then(|&f| state.angles.reason_of_facet(f));
                Proposed::Refused(reason.unwrap_or_else(|| state.unserved(item)))
            }
        }
    }

    /// Looks for the point of a boundary item; its cavity, and what is around it, is added to
    /// `list`. The last attempt is refused.
    fn look_at_item(
        &self,
        item: Item,
        near: TetId,
        prober: &mut Prober,
        list: &mut Vec<TetId>,
    ) -> Looked {
        let state = &self.own.state;
        let Prober { search, survey } = prober;
        for attempt in 0..=ATTEMPTS {
            let (place, is_on) = match self.proposed(item, near, attempt) {
                Proposed::Gone => return Looked::Gone,
                Proposed::Refused(reason) => return Looked::Refused(reason),
                Proposed::Useless => continue,
                Proposed::At(place, is_on) => (place, is_on),
            };
            let p = &place.p;
            let Some(from) = state.holder(state.start_near(near), p) else { continue };
            // The point fell together with a vertex.
            let mut corners = state.vertices(from).into_iter().filter(|&v| v != INFINITE);
            if corners.any(|v| state.at(v) == *p) {
                continue;
            }
            search.find(&state.mesh, p, from);
            let closure = InMesh::found(state, search);
            survey.look(&closure, p, place.carrier);
            let judge = Judge::new(closure, survey, &self.own.record);
            let verdict = judge.on_boundary(item, &place, is_on);
            if matches!(verdict, Verdict::Useless) {
                continue;
            }
            let start = list.len();
            list.extend(search.tets());
            let cavity = start..list.len();
            let watch = survey.watch_at_item(&closure, Some(item), place.carrier);
            let place = Place { from, ..place };
            return Looked::Found(Found { place, cavity, watch, verdict });
        }
        Looked::Refused(state.unserved(item))
    }

    /// Makes an item that may be split a candidate; `list` has its cavity.
    fn take_looked(&mut self, (item, near): (Item, TetId), looked: Looked, list: &[TetId]) {
        let found = match looked {
            Looked::Gone => {
                self.demands.remove(&item);
                return;
            }
            Looked::Refused(reason) => return self.refuse(item, reason),
            Looked::Found(found) => found,
        };
        let Found { place, cavity, watch, verdict } = found;
        self.stats.searches += 1;
        match verdict {
            Verdict::Fill(filling) => {
                let cavity = self.choice.add_cavity(&list[cavity]);
                let rank = self.choice.candidates.len() as u32;
                let (fits, alone, watch) = (true, false, Some(watch));
                let own = Candidate { item, rank, fits, watch, alone, place, cavity, filling };
                self.choice.candidates.push(own);
                self.reserve_last();
            }
            Verdict::Defer(first) => self.wait(item, first, near),
            Verdict::Refuse(reason) => self.refuse(item, reason),
            Verdict::Useless | Verdict::AtPatch => {}
        }
    }

    /// Probes a boundary item with the cavity of its point open, and takes it if it may be split.
    fn probe_open(&mut self, (item, near): (Item, TetId)) {
        for attempt in 0..=ATTEMPTS {
            let (place, is_on) = match self.proposed(item, near, attempt) {
                Proposed::Gone => {
                    self.demands.remove(&item);
                    return;
                }
                Proposed::Refused(reason) => return self.refuse(item, reason),
                Proposed::Useless => continue,
                Proposed::At(place, is_on) => (place, is_on),
            };
            let rank = self.choice.candidates.len() as u32;
            let verdict = |judge: Judge<'_>| judge.on_boundary(item, &place, is_on);
            match self.probe((item, rank), &place, verdict) {
                Probe::Fits => return self.take_or_drop(),
                Probe::Barred => return,
                Probe::Defers(first) => return self.wait(item, first, near),
                Probe::Refuses(reason) => return self.refuse(item, reason),
                Probe::Useless => {}
            }
        }
    }
}
