//! Probes of boundary items: where each is to be split, and the verdict on that point, on the mesh
//! at the start of the round. All threads look at them, in any order; one waits if another with a
//! larger key is in its way, whatever becomes of that. At patches they are taken in turns, and one
//! waits for those that were taken before.

use super::batch::{Prober, Unseen};
use super::demands::Ready;
use super::{CHECK_EVERY, Candidate, Look, Rounds};
use crate::mesh::item::Item;
use crate::mesh::state::Place;
use crate::outcome::Reason;
use crate::rules::aim::{ATTEMPTS, Aim};
use crate::rules::turns::Held;
use crate::rules::verdict::Verdict;
use crate::rules::watch::Watch;
use ltbw_core::PredicateStats;
use ltbw_core::topology::TetId;
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
    /// One taken before it is in its way.
    Barred,
    Found(Found),
}

/// A point for a boundary item, with its cavity and the verdict on it.
#[derive(Debug)]
struct Found {
    place: Place,
    /// The cavity in the list of the batch.
    cavity: Range<usize>,
    watch: Option<Watch<TetId>>,
    verdict: Verdict,
}

/// The looks at some boundary items, in their order.
#[derive(Debug, Default)]
struct Batch {
    all: Vec<(Ready, Looked)>,
    tets: Vec<TetId>,
    stats: PredicateStats,
}

impl Rounds<'_, '_> {
    /// Probes boundary items, and takes those that may be split now;
    /// `true` if the work is cancelled.
    pub(super) fn probe_boundary(&mut self, items: &[Ready], heed: Look<'_>) -> bool {
        let vertices = self.own.state.mesh.num_vertices();
        let mut cancelled = false;
        if self.in_waves {
            let (mut own, mut tets) = (std::mem::take(&mut self.prober), Vec::new());
            for (done, &item) in items.iter().enumerate() {
                cancelled = done % CHECK_EVERY == CHECK_EVERY - 1 && heed(vertices);
                if cancelled {
                    break;
                }
                tets.clear();
                let looked = self.look_at_item(item, &mut own, &mut tets);
                self.take_looked(item, looked, &tets);
            }
            self.own.state.mesh.add_stats(std::mem::take(&mut own.search.stats));
            self.prober = own;
            return cancelled;
        }
        let mut own = std::mem::take(&mut self.prober);
        let this = &*self;
        let look = |prober: &mut Prober, items: &[Ready]| {
            let mut batch = Batch::default();
            for &item in items {
                let looked = this.look_at_item(item, prober, &mut batch.tets);
                batch.all.push((item, looked));
            }
            batch.stats = std::mem::take(&mut prober.search.stats);
            batch
        };
        let mut batches: Vec<Batch> = Vec::new();
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
            for (item, looked) in batch.all {
                self.take_looked(item, looked, &batch.tets);
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

    /// Looks for the point of a boundary item; its cavity is added to `list`. The last attempt is
    /// refused.
    fn look_at_item(&self, own: Ready, prober: &mut Prober, list: &mut Vec<TetId>) -> Looked {
        let Ready { item, near } = own;
        let state = &self.own.state;
        for attempt in 0..=ATTEMPTS {
            let (place, is_on) = match self.proposed(item, near, attempt) {
                Proposed::Gone => return Looked::Gone,
                Proposed::Refused(reason) => return Looked::Refused(reason),
                Proposed::Useless => continue,
                Proposed::At(place, is_on) => (place, is_on),
            };
            let from = state.holder(state.start_near(near), &place.p);
            let Some(place) = from.map(|from| Place { from, ..place }) else { continue };
            // Points in turns mostly have to wait: a search ends where one was taken before.
            let bars = |t: TetId| self.in_waves && self.bars(t, place.carrier);
            let seen = match prober.see(state, &place, bars) {
                Ok(seen) => seen,
                Err(Unseen::Vertex) => continue,
                Err(Unseen::Barred) => return Looked::Barred,
            };
            let verdict = seen.judge(&self.own.record).on_boundary(item, &place, is_on);
            if matches!(verdict, Verdict::Useless) {
                continue;
            }
            let start = list.len();
            list.extend(seen.tets);
            let cavity = start..list.len();
            let watch = matches!(verdict, Verdict::Fill(_))
                .then(|| seen.survey.watch_at_item(&seen.closure, Some(item), place.carrier));
            return Looked::Found(Found { place, cavity, watch, verdict });
        }
        Looked::Refused(state.unserved(item))
    }

    /// Makes an item that may be split a candidate; `list` has its cavity.
    fn take_looked(&mut self, own: Ready, looked: Looked, list: &[TetId]) {
        let Ready { item, near } = own;
        let found = match looked {
            Looked::Gone => return self.demands.remove(&item),
            Looked::Refused(reason) => return self.refuse(item, reason),
            Looked::Barred => {
                self.stats.barred += 1;
                return;
            }
            Looked::Found(found) => found,
        };
        let Found { place, cavity, watch, verdict } = found;
        self.stats.searches += 1;
        match verdict {
            Verdict::Fill(filling) => {
                let cavity = self.choice.add_cavity(&list[cavity]);
                let rank = self.choice.candidates.len() as u32;
                // Labels at a patch are a function of the mesh as long as one point at a time
                // changes them.
                let is_patch = |f: u32| self.own.state.is_patch(f);
                let alone = filling.changes.iter().any(|change| is_patch(change.facet));
                let fits = true;
                let own = Candidate { item, rank, fits, watch, alone, place, cavity, filling };
                self.choice.candidates.push(own);
                self.reserved.note_alone(rank, alone);
                match self.in_waves {
                    true => self.take_or_drop(),
                    false => self.reserve_last(),
                }
            }
            Verdict::Defer(first) => self.wait(item, first, near),
            Verdict::Refuse(reason) => self.refuse(item, reason),
            Verdict::Useless => {}
        }
    }

    /// Takes the last candidate, unless one taken before it is in its way.
    fn take_or_drop(&mut self) {
        let last = self.choice.candidates.len() - 1;
        if self.survives(last) {
            self.choice.chosen.push(last);
            self.reserve_last();
        } else if let Some(last) = self.choice.candidates.pop() {
            self.stats.barred += 1;
            self.choice.cavities.truncate(last.cavity.start);
        }
    }
}
