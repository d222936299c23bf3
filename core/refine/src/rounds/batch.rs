//! Probes of tetrahedra: the cavity of a proposed point is found on the mesh at the start of the
//! round, which nobody writes meanwhile, so that many threads may probe at once. A probe runs to
//! its end and reserves all slots of its cavity, unless it is refused: the slots, and with them
//! the choice, are a function of the mesh, whoever probes what and when.

use super::block::Here;
use super::foremost::Foremost;
use super::probe::Approach;
use super::{Candidate, Conclusion, Rounds};
use crate::mesh::item::Item;
use crate::mesh::state::{Place, State};
use crate::mesh::survey::Survey;
use crate::rules::aim::ATTEMPTS;
use crate::rules::block::{Between, Block, KeptBlock};
use crate::rules::bounded::InMesh;
use crate::rules::record::Record;
use crate::rules::verdict::{Filling, Judge, Verdict};
use crate::rules::watch::Watch;
use ltbw_core::PredicateStats;
use ltbw_core::search::Search;
use ltbw_core::topology::{INFINITE, TetId};
use rayon::prelude::*;
use std::ops::Range;

/// Probes of a batch; fewer are not worth another thread.
const BATCH: usize = if cfg!(test) { 3 } else { 64 };

/// One thread's memory for probes.
#[derive(Debug, Default)]
pub(super) struct Prober {
    pub(super) search: Search,
    pub(super) survey: Survey<TetId>,
}

impl Prober {
    /// Finds the closure of a place, whose tetrahedron holds it, and the boundary there.
    pub(super) fn see<'s>(
        &'s mut self,
        state: &'s State,
        place: &Place,
        bars: impl Fn(TetId) -> bool + Copy,
    ) -> Result<Seen<'s>, Unseen> {
        let Self { search, survey } = self;
        let mut corners = state.vertices(place.from).into_iter().filter(|&v| v != INFINITE);
        if corners.any(|v| state.at(v) == place.p) {
            return Err(Unseen::Vertex);
        }
        if bars(place.from) || !search.find(&state.mesh, &place.p, place.from, bars) {
            return Err(Unseen::Barred);
        }
        let closure = InMesh::found(state, search);
        survey.look(&closure, &place.p, place.carrier);
        Ok(Seen { closure, tets: search.tets(), survey })
    }
}

/// Why a probe has no closure.
pub(super) enum Unseen {
    /// Its point fell together with a vertex.
    Vertex,
    /// A tetrahedron bars it.
    Barred,
}

/// A closure that a probe has found.
pub(super) struct Seen<'s> {
    pub(super) closure: InMesh<'s>,
    /// The cavity.
    pub(super) tets: &'s [TetId],
    pub(super) survey: &'s Survey<TetId>,
}

impl<'s> Seen<'s> {
    /// The grounds of a verdict on its point.
    pub(super) fn judge(&self, record: &'s Record) -> Judge<'s> {
        Judge::new(self.closure, self.survey, record)
    }
}

/// A probe that reserves its cavity.
#[derive(Debug)]
struct Reserves {
    item: Item,
    rank: u32,
    place: Place,
    /// Its tetrahedra in the list of the batch.
    cavity: Range<usize>,
    watch: Option<Watch<TetId>>,
    /// The changes that come with the point, if it fits.
    filling: Option<Filling>,
}

/// The findings of some probes, in their order.
#[derive(Debug, Default)]
pub(super) struct Batch {
    probed: Vec<Reserves>,
    cavities: Vec<TetId>,
    conclusions: Vec<Conclusion>,
    blocks: Vec<KeptBlock<Here>>,
    searches: u64,
    stats: PredicateStats,
}

impl Rounds<'_, '_> {
    /// Probes leaders, given by their numbers, on all threads.
    pub(super) fn probe_tets(&mut self, list: &[u32], ranks: &[u32]) -> Vec<Batch> {
        let mut own = std::mem::take(&mut self.prober);
        let this = &*self;
        let probe = |prober: &mut Prober, list: &[u32]| {
            let mut batch = Batch::default();
            for (done, &k) in list.iter().enumerate() {
                this.fetch_ahead(&list[done + 1..]);
                this.probe_into(this.leader(k), ranks[k as usize], prober, &mut batch);
            }
            batch.stats = std::mem::take(&mut prober.search.stats);
            batch
        };
        let batches = match self.threads > 1 && list.len() >= 2 * BATCH {
            true => list.par_chunks(BATCH).map_init(Prober::default, probe).collect(),
            false => vec![probe(&mut own, list)],
        };
        self.prober = own;
        batches
    }

    /// Asks the processor to fetch what the next probes begin with. A hint.
    fn fetch_ahead(&self, next: &[u32]) {
        let mesh = &self.own.state.mesh;
        if let Some(&k) = next.first() {
            for t in self.neighbours(self.leader(k).t) {
                mesh.prefetch(t);
                mesh.prefetch_sphere(t);
                self.own.state.marks.prefetch(t);
            }
        }
        if let Some(&k) = next.get(1) {
            mesh.prefetch(self.leader(k).t);
        }
    }

    /// Proposes a point for a tetrahedron, the leader of a group, of this rank.
    fn probe_into(&self, own: &Foremost, rank: u32, prober: &mut Prober, batch: &mut Batch) {
        let (t, state) = (own.t, &self.own.state);
        for attempt in 0..=ATTEMPTS {
            let place = match self.approach(own, rank, attempt) {
                Approach::At(place) => place,
                Approach::Elsewhere => continue,
                Approach::Ends(conclusion) => return batch.conclusions.push(conclusion),
            };
            batch.searches += 1;
            let Ok(seen) = prober.see(state, &place, |_| false) else { continue };
            let (filling, first) = match seen.judge(&self.own.record).on_tet(t, &place) {
                Verdict::Fill(filling) => (Some(filling), Vec::new()),
                Verdict::Defer(first) => (None, first),
                Verdict::Useless | Verdict::Refuse(_) => continue,
            };
            if filling.is_none() {
                let conclusion = self.conclusion(own, rank, &first);
                let is_refused = conclusion.verdict.is_err();
                batch.conclusions.push(conclusion);
                if is_refused {
                    // It is in nobody's way.
                    batch.blocks.extend(self.blocks_in(&seen, own));
                    return;
                }
            }
            let Seen { closure, tets, survey } = seen;
            // Reserved at once, while they are in this thread's cache.
            self.reserved.reserve(rank, tets, self.threads == 1);
            let start = batch.cavities.len();
            batch.cavities.extend(tets);
            batch.probed.push(Reserves {
                item: Item::Tet(t, state.vertices(t)),
                rank,
                place,
                cavity: start..batch.cavities.len(),
                watch: filling.as_ref().and_then(|_| survey.watch_in_tet(&closure)),
                filling,
            });
            return;
        }
    }

    /// The subfaces that the refused point of a tetrahedron would take out of the mesh.
    fn blocks_in(&self, seen: &Seen<'_>, own: &Foremost) -> Vec<KeptBlock<Here>> {
        let (record, limit) = (&self.own.record, self.limit(own.t, &own.shape));
        let found = seen.judge(record).blocks(|s| record.bars(&Item::Subface(s), limit).is_some());
        let here = |(block, (corners, sides)): (Block, Between<TetId>)| {
            let sides = sides.map(|t| (t, self.own.state.vertices(t)));
            KeptBlock { block, here: Here { item: Item::Subface(corners), sides } }
        };
        found.into_iter().map(here).collect()
    }

    /// Takes over what a batch has found.
    pub(super) fn take_batch(&mut self, batch: Batch) {
        for Reserves { item, rank, place, cavity, watch, filling } in batch.probed {
            let cavity = self.choice.add_cavity(&batch.cavities[cavity]);
            let (fits, filling) = (filling.is_some(), filling.unwrap_or_default());
            // A point inside changes nothing but patches. Labels there are a function of the mesh
            // as long as one point at a time changes them.
            let alone = !filling.changes.is_empty();
            self.reserved.note_alone(rank, alone);
            let own = Candidate { item, rank, fits, watch, alone, place, cavity, filling };
            self.choice.candidates.push(own);
        }
        self.demands.conclusions.extend(batch.conclusions);
        self.blocks.note(batch.blocks);
        self.stats.searches += batch.searches;
        self.own.state.mesh.add_stats(batch.stats);
    }
}
