//! Refinement in rounds: the points of a round are chosen from the mesh alone, and may then be
//! inserted in any order.
//!
//! The Delaunay mesh of a point set is unique here, so the mesh after a round is a function of the
//! mesh before it. Every verdict is taken on the mesh at the start of the round, by coordinates and
//! never by numbers or slots; insertion is unconditional. `docs/rounds.md`.

mod batch;
mod block;
mod boundary;
mod choose;
mod conflict;
mod foremost;
mod insert;
mod lanes;
mod late;
mod pool;
mod probe;
mod relief;
mod resume;
mod settle;
mod sift;
mod sliver;
mod times;

#[doc(hidden)]
pub use choose::are_joined;
pub(crate) use resume::{Resumed, Waiting};
#[doc(hidden)]
pub use sift::{Bad, Ranked, sift, witness};
pub use times::RoundTimes;

use crate::RefineError;
use crate::late::again::Asking;
use crate::late::relief::Goal;
use crate::mesh::item::{Item, Queues};
use crate::mesh::limit::Limit;
use crate::mesh::names::Names;
use crate::mesh::state::Place;
use crate::outcome::{Reason, RefineStats};
use crate::queue::split::{Refinement, Step};
use crate::rules::record::Refusal;
use crate::rules::verdict::Filling;
use crate::sync::{Keys, Words};
use crate::table::Map;
use ltbw_core::cavity::AdmitAll;
use ltbw_core::topology::TetId;
use probe::Probe;
use std::ops::Range;
use times::Clock;

/// The order in which the points of a round are inserted: the mesh is the same for all.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InsertOrder {
    /// Along a Hilbert curve.
    #[default]
    Hilbert,
    /// As they were found.
    Forwards,
    /// The other way round.
    Backwards,
    /// By chance, from a seed.
    Random(u64),
    /// The permutation of this number, modulo those that there are: all numbers below the factorial
    /// of the widest round give every order of every round.
    Nth(u64),
}

/// The kinds of rounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    /// Items of the boundary; where they are few beside the tetrahedra, these as well.
    Boundary,
    Tets,
    Slivers,
}

/// The next step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Next {
    Round(Class),
    /// Items that wait for each other are split jointly.
    Circles,
    /// Refused tetrahedra are relieved, one after the other.
    Relief(Goal),
}

/// A point proposed in a round, and its cavity in the mesh at the start of the round.
#[derive(Debug)]
struct Candidate {
    item: Item,
    /// Its place among the candidates of the round; 0 is the foremost.
    rank: u32,
    /// May the point be inserted, if no other one is in its way?
    fits: bool,
    /// Is anything of its cavity marked?
    is_marked: bool,
    /// Does it have to be the foremost in its whole closure, and to be left alone there?
    alone: bool,
    place: Place,
    /// Its tetrahedra in [`Rounds::cavities`].
    cavity: Range<usize>,
    /// The changes that come with it, if nothing in its closure changes before.
    filling: Filling,
}

/// A boundary item that is to be split.
#[derive(Clone, Copy, Debug)]
struct Pending {
    /// The item that has to be split before it.
    first: Option<Item>,
    /// A slot that was near it, where the walk to its point starts.
    near: TetId,
}

/// A boundary item that is asked for in a round.
#[derive(Clone, Copy, Debug)]
struct Asked {
    item: Item,
    /// The edges that it may make.
    limit: Option<Limit>,
    near: TetId,
}

/// The outcome of the probe of a tetrahedron that is not split now: the item that it asks for,
/// or the reason why it is refused.
#[derive(Debug)]
struct Conclusion {
    t: TetId,
    rank: u32,
    verdict: Result<Asked, Reason>,
}

/// Probes, or insertions, between two looks at whether the work is cancelled.
const CHECK_EVERY: usize = 1024;

/// Why rounds stopped early, figures, the tetrahedra that are over their bounds, and the times.
type Finished = (Option<Reason>, RefineStats, Vec<TetId>, Vec<RoundTimes>);

/// Says whether the work is cancelled; is told the number of vertices.
type Look<'l> = &'l dyn Fn(usize) -> bool;

/// The largest entry of [`Rounds::reserved`] for a candidate. A round adds less than that.
const LAST: u32 = if cfg!(test) { 1 << 10 } else { u32::MAX >> 1 };

/// Looks at new tetrahedra after which they are counted anew. A round has fewer.
const LAST_LOOK: u32 = if cfg!(test) { 8 } else { u32::MAX >> 1 };

/// A refinement in rounds.
pub(crate) struct Rounds<'r, 'a> {
    own: &'r mut Refinement<'a>,
    order: InsertOrder,
    /// The most points to insert.
    most: u64,
    /// Per slot: the key of a tetrahedron over its bounds that was not refused, else 0.
    keys: Keys,
    /// Per slot: the look from which on it has had this key.
    stamps: Words,
    /// The number of looks at new tetrahedra, since they were counted anew.
    looks: u32,
    /// The tetrahedra whose key is not 0, and others that are gone since.
    bad: Vec<Bad>,
    /// Tetrahedra among them that come before all around them.
    foremost: Vec<foremost::Foremost>,
    /// Per group of the foremost: the index of the one that comes first.
    leaders: Vec<u32>,
    /// The leaders when last counted.
    counted: usize,
    /// Boundary items to be split.
    pending: Map<Item, Pending>,
    candidates: Vec<Candidate>,
    /// Candidates that are to be inserted.
    chosen: Vec<usize>,
    /// The cavities of the candidates.
    cavities: Vec<TetId>,
    /// Per slot, if it is more than `free`: `count` more, less the rank of the foremost candidate
    /// with the slot in its cavity; or more than that, if this round has written it.
    reserved: Words,
    /// The largest entry of the rounds before.
    free: u32,
    /// The number of ranks of this round, and of the first ones among them, which boundary items
    /// have.
    count: u32,
    boundary: u32,
    /// Looks at new tetrahedra in this round so far.
    batch: u32,
    /// Per rank: is the candidate of this rank to be alone? Empty if none is.
    alone: Vec<bool>,
    /// The numbers of points at which refusals for rounding were forgotten.
    retried: Vec<u64>,
    /// The late step to come.
    late: usize,
    asking: Asking,
    /// Slivers not yet looked at, when all else is done.
    slivers: Option<Vec<sliver::Sliver>>,
    /// The tetrahedra that may have tiny dihedral angles, if others have looked at all.
    handed: Option<Vec<TetId>>,
    /// Subfaces that tetrahedra were refused for in earlier rounds, and those of this one.
    blocks: Vec<block::Block>,
    new_blocks: Vec<block::Block>,
    /// Tetrahedra of this round that are not to be split now.
    conclusions: Vec<Conclusion>,
    /// Boundary items asked for in this round.
    asked: Vec<Asked>,
    /// Pending items that were found to wait in this round.
    waits: Vec<(Item, Pending)>,
    /// Items refused in this round.
    refusals: Vec<(Item, Reason)>,
    /// Slots written by the insertions of this round, each once.
    created: Vec<TetId>,
    /// The memory of the threads that insert together.
    lanes: lanes::Memory,
    /// The boundary by the carriers: tables and marks are compared with it in debug builds.
    names: Option<Names>,
    /// The work that the fillings put: items that are lost, of which there are none.
    nothing: Queues,
    stats: RefineStats,
    clock: Clock,
    /// Are there patches? Then many tetrahedra may have their points in one place, and those that
    /// come first are probed before the others, which they may kill.
    in_waves: bool,
    /// Are there such, or small angles? Then many may be refused: of those whose circumspheres are
    /// nearly equal one is probed.
    in_groups: bool,
    /// Threads that read the mesh together.
    threads: usize,
    /// The memory for probes on this thread.
    prober: batch::Prober,
}

impl<'r, 'a> Rounds<'r, 'a> {
    /// Rounds from the present state on, in which nothing is missing, on as many threads as the
    /// figures so far say.
    pub(crate) fn new(
        own: &'r mut Refinement<'a>,
        order: InsertOrder,
        most: u64,
        stats: RefineStats,
    ) -> Self {
        own.state.by_place = true;
        own.state.encroachment = Default::default();
        own.record = Default::default();
        let (threads, expected) = (stats.round_threads.max(1), own.state.expected);
        let in_waves = own.state.plc.facets.iter().any(|facet| facet.patch.is_some());
        let angles = &own.state.angles;
        let in_groups = in_waves || angles.relates() || !angles.is_empty();
        let names = cfg!(debug_assertions).then(|| Names::of(&own.state));
        Self {
            own,
            order,
            most,
            keys: Keys::with_room_for(expected),
            stamps: Words::with_room_for(expected),
            looks: 0,
            bad: Vec::new(),
            foremost: Vec::new(),
            leaders: Vec::new(),
            counted: 0,
            pending: Map::default(),
            candidates: Vec::new(),
            chosen: Vec::new(),
            cavities: Vec::new(),
            reserved: Words::with_room_for(expected),
            free: 0,
            count: 0,
            boundary: 0,
            batch: 0,
            alone: Vec::new(),
            retried: Vec::new(),
            late: 0,
            asking: Asking::default(),
            slivers: None,
            handed: None,
            blocks: Vec::new(),
            new_blocks: Vec::new(),
            conclusions: Vec::new(),
            asked: Vec::new(),
            waits: Vec::new(),
            refusals: Vec::new(),
            created: Vec::new(),
            lanes: lanes::Memory::default(),
            names,
            nothing: Queues::default(),
            stats,
            clock: Clock::start(),
            in_groups,
            in_waves,
            threads,
            prober: batch::Prober::default(),
        }
    }

    /// Carries out rounds until nothing is left to do. `look` is told the number of vertices, and
    /// says whether the work is cancelled. Returns why it stopped early, figures, and the
    /// tetrahedra that are over their bounds.
    ///
    /// Ends: every round inserts a point of a finite lattice, or refuses an item, or asks for one
    /// that was not asked for.
    ///
    /// # Errors
    /// A broken invariant.
    pub(crate) fn run(mut self, look: Look<'_>) -> Result<Finished, RefineError> {
        self.look_at_first()?;
        let mut stop = None;
        self.clock.begin();
        while let Some(next) = self.next() {
            if look(self.own.state.mesh.num_vertices()) {
                stop = Some(Reason::Cancelled);
                break;
            }
            match next {
                Next::Relief(goal) => {
                    stop = self.relieve(goal, look)?;
                    if stop.is_some() {
                        break;
                    }
                }
                Next::Round(class) => {
                    if self.choose(class, look) {
                        stop = Some(Reason::Cancelled);
                        break;
                    }
                    let count = self.chosen.len();
                    self.clock.choose();
                    let total = self.own.inserted.points.total() + count as u64;
                    if total > self.most && class == Class::Slivers {
                        self.slivers = Some(Vec::new());
                        continue;
                    }
                    if total > self.most {
                        stop = Some(Reason::Budget);
                        break;
                    }
                    // Of slivers the foremost is split, or looked at no more.
                    let progress = self.record_round() || count > 0 || class == Class::Slivers;
                    let before = self.stats.round_points;
                    let cancelled = self.insert(class, look)?;
                    self.settle();
                    let inserted = self.stats.round_points - before;
                    let name = match class {
                        Class::Boundary if self.count > self.boundary => "all",
                        Class::Boundary => "boundary",
                        Class::Tets => "tetrahedra",
                        Class::Slivers => "slivers",
                    };
                    self.clock.end(name, self.candidates.len(), inserted as usize);
                    if cancelled {
                        stop = Some(Reason::Cancelled);
                        break;
                    }
                    if !progress {
                        return Err(RefineError::Invariant { what: "a round makes progress" });
                    }
                }
                Next::Circles => self.split_circles()?,
            }
            self.clock.begin();
        }
        self.check_complete()?;
        let over = self.over();
        Ok((stop, self.stats, over, self.clock.rounds))
    }

    /// The next step; `None` if nothing is left to do.
    fn next(&mut self) -> Option<Next> {
        if self.pending.values().any(|pending| self.is_ready(pending)) {
            return Some(Next::Round(Class::Boundary));
        }
        if !self.pending.is_empty() {
            return Some(Next::Circles);
        }
        self.find_foremost();
        // Of tetrahedra over their bounds one is before all others.
        match self.foremost.is_empty() {
            false => Some(Next::Round(Class::Tets)),
            true => self.next_late(),
        }
    }

    /// May an item be tried? Not before the one that it waits for is gone or refused.
    fn is_ready(&self, pending: &Pending) -> bool {
        !pending.first.is_some_and(|other| self.pending.contains_key(&other))
    }

    /// Writes what the choice has found into the record; `false` if that is nothing new.
    fn record_round(&mut self) -> bool {
        let mut news = !self.refusals.is_empty() || !self.waits.is_empty();
        self.stats.refused += self.refusals.len() as u64;
        self.stats.deferred += self.asked.len() as u64;
        self.pending.extend(self.waits.drain(..));
        let record = &mut self.own.record;
        for Asked { item, limit, near } in self.asked.drain(..) {
            let refusal = record.refused.remove(&item);
            news |= !self.pending.contains_key(&item);
            self.pending.entry(item).or_insert(Pending { first: None, near });
            if let Some(limit) = limit {
                let limit = refusal.map_or(limit, |refusal| refusal.again(limit));
                let own = record.limits.entry(item).or_insert(limit);
                news |= limit.is_below(1.0, *own);
                *own = own.or(limit);
            }
        }
        for (item, reason) in self.refusals.drain(..) {
            let limit = record.limits.remove(&item);
            // The floor is no lower for a proposal that allows shorter edges.
            let limit = limit.filter(|_| reason != Reason::Floor);
            record.refused.insert(item, Refusal { reason, limit });
            self.pending.remove(&item);
            if let Item::Tet(t, _) = item {
                // No look so far has found it so.
                self.keys.set(t, 0);
                self.stamps.set(t, self.looks + 1);
            }
        }
        news
    }

    /// Splits items jointly that wait for each other in a circle, in the order of their places.
    fn split_circles(&mut self) -> Result<(), RefineError> {
        self.stats.joint_phases += 1;
        self.forget_reserved(0);
        let mut work = Queues::default();
        for item in self.circles() {
            let limit = self.own.record.limits.get(&item).copied();
            match self.own.split_jointly(item, &mut work, &mut AdmitAll) {
                Step::Refused(reason) => {
                    self.own.record.refused.insert(item, Refusal { reason, limit });
                }
                Step::SetBack(_) => return Err(RefineError::Invariant { what: "room for points" }),
                Step::Inserted => self.note_created(),
                Step::Gone | Step::Deferred => {}
            }
            self.own.record.limits.remove(&item);
            self.pending.remove(&item);
        }
        self.settle();
        Ok(())
    }

    /// The foremost item of each circle of items that wait for each other, in the order of their
    /// places. Every item waits for one, so that each way ends in a circle.
    fn circles(&self) -> Vec<Item> {
        let mut items: Vec<Item> = self.pending.keys().copied().collect();
        self.own.state.sort(&mut items);
        let mut seen: Map<Item, usize> = Map::default();
        let mut foremost = Vec::new();
        for (walk, &start) in items.iter().enumerate() {
            let mut at = start;
            // A way goes on to items not seen before, of which there are as many as are pending.
            while !seen.contains_key(&at) {
                seen.insert(at, walk);
                let first = self.pending.get(&at).and_then(|pending| pending.first);
                let Some(first) = first else { break };
                at = first;
            }
            if seen.get(&at) != Some(&walk) {
                continue;
            }
            // The circle that starts at `at`.
            let (mut circle, mut next) = (Vec::new(), at);
            for _ in 0..items.len() {
                circle.push(next);
                let first = self.pending.get(&next).and_then(|pending| pending.first);
                next = first.unwrap_or(at);
                if next == at {
                    break;
                }
            }
            self.own.state.sort(&mut circle);
            foremost.extend(circle.first());
        }
        self.own.state.sort(&mut foremost);
        foremost
    }
}
