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
mod demands;
mod foremost;
mod insert;
mod keys;
mod lanes;
mod late;
mod pool;
mod probe;
mod ranked;
mod relief;
mod reserved;
mod resume;
mod settle;
mod sliver;
mod smooth;
mod times;
#[cfg(test)]
mod twin;

pub(crate) use block::Here as BlockHere;
#[doc(hidden)]
pub use choose::are_joined;
#[doc(hidden)]
pub use keys::Keys;
#[doc(hidden)]
pub use ranked::{Bad, Ranked};
pub(crate) use resume::{Resumed, Waiting};
pub use times::RoundTimes;

use crate::RefineError;
use crate::late::relief::Goal;
use crate::mesh::item::{Item, Queues};
use crate::mesh::names::Names;
use crate::mesh::state::Place;
use crate::outcome::{Reason, RefineStats};
use crate::queue::split::Refinement;
use crate::rules::block::{Block, Blocks};
use crate::rules::verdict::Filling;
use crate::rules::watch::Watch;
use crate::thin::Thin;
use block::Here;
use demands::{Asked, Conclusion, Demands, Pending};
use foremost::Front;
use late::Late;
use ltbw_core::topology::TetId;
use reserved::Reserved;
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
    /// The tetrahedra at which those before it make it wait; none if nothing of its cavity is on
    /// the boundary, or it does not fit.
    watch: Option<Watch<TetId>>,
    /// Does it have to be the foremost in its whole closure, and to be left alone there?
    alone: bool,
    place: Place,
    /// Its tetrahedra in [`Choice::cavities`].
    cavity: Range<usize>,
    /// The changes that come with it, if nothing in its closure changes before.
    filling: Filling,
}

/// Probes, or insertions, between two looks at whether the work is cancelled.
const CHECK_EVERY: usize = 1024;

/// The end of rounds.
pub(crate) struct Finished {
    /// Why they stopped early.
    pub(crate) stop: Option<Reason>,
    pub(crate) stats: RefineStats,
    /// The tetrahedra that are over their bounds.
    pub(crate) over: Vec<TetId>,
    pub(crate) times: Vec<RoundTimes>,
    /// The slivers, if others are to split these.
    pub(crate) slivers: Option<Vec<Thin>>,
    /// The blocks, if so.
    pub(crate) blocks: Vec<Block>,
}

/// Says whether the work is cancelled; is told the number of vertices.
type Look<'l> = &'l dyn Fn(usize) -> bool;

/// The candidates of a round.
#[derive(Debug, Default)]
struct Choice {
    candidates: Vec<Candidate>,
    /// The numbers of the candidates that are to be inserted.
    chosen: Vec<usize>,
    /// The cavities of all candidates.
    cavities: Vec<TetId>,
}

impl Choice {
    fn clear(&mut self) {
        self.candidates.clear();
        self.chosen.clear();
        self.cavities.clear();
    }

    /// The cavity of the k-th candidate.
    fn cavity(&self, k: usize) -> &[TetId] {
        self.cavity_of(&self.candidates[k])
    }

    /// The cavity of a candidate.
    fn cavity_of(&self, own: &Candidate) -> &[TetId] {
        &self.cavities[own.cavity.clone()]
    }

    /// Adds a cavity to the list.
    fn add_cavity(&mut self, tets: &[TetId]) -> Range<usize> {
        let start = self.cavities.len();
        self.cavities.extend_from_slice(tets);
        start..self.cavities.len()
    }
}

/// A refinement in rounds.
pub(crate) struct Rounds<'r, 'a> {
    own: &'r mut Refinement<'a>,
    order: InsertOrder,
    /// The most points to insert.
    most: u64,
    /// The tetrahedra over their bounds that were not refused.
    keys: Keys,
    front: Front,
    demands: Demands,
    choice: Choice,
    reserved: Reserved,
    blocks: Blocks<Here>,
    late: Late,
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
    /// Others split slivers, if there are as many when these come first.
    leaves_slivers: Option<usize>,
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
        let in_waves = own.state.plc.has_patches();
        let in_groups = in_waves || own.state.angles.matter();
        let names = cfg!(debug_assertions).then(|| Names::of(&own.state));
        let (mut keys, mut reserved) = (Keys::default(), Reserved::default());
        keys.expect_tets(expected);
        reserved.expect(expected);
        Self {
            own,
            order,
            most,
            keys,
            front: Front::new(in_groups),
            demands: Demands::default(),
            choice: Choice::default(),
            reserved,
            blocks: Blocks::default(),
            late: Late::default(),
            created: Vec::new(),
            lanes: lanes::Memory::default(),
            names,
            nothing: Queues::default(),
            stats,
            clock: Clock::start(),
            in_waves,
            leaves_slivers: None,
            threads,
            prober: batch::Prober::default(),
        }
    }

    /// Carries out rounds until nothing is left to do. `look` is told the number of vertices, and
    /// says whether the work is cancelled.
    ///
    /// Ends: every round inserts a point of a finite lattice, or refuses an item, or asks for one
    /// that was not asked for.
    ///
    /// # Errors
    /// A broken invariant.
    pub(crate) fn run(mut self, look: Look<'_>) -> Result<Finished, RefineError> {
        self.look_at_first()?;
        let (mut stop, mut slivers) = (None, None);
        self.clock.begin();
        while let Some(next) = self.next() {
            if next == Next::Round(Class::Slivers) {
                slivers = self.slivers_for_others();
            }
            if slivers.is_some() {
                break;
            }
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
                    let count = self.choice.chosen.len();
                    self.clock.choose();
                    let total = self.own.inserted.points.total() + count as u64;
                    if total > self.most && class == Class::Slivers {
                        self.late.slivers = Some(Vec::new());
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
                        Class::Boundary if !self.reserved.of_tets().is_empty() => "all",
                        Class::Boundary => "boundary",
                        Class::Tets => "tetrahedra",
                        Class::Slivers => "slivers",
                    };
                    self.clock.end(name, self.choice.candidates.len(), inserted as usize);
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
        // Vertices are moved when all else is done, by others, too.
        let is_over = stop.is_none() && slivers.is_none();
        if is_over && self.smooth(self.own.sweeps, look)? {
            stop = Some(Reason::Cancelled);
        }
        self.check_complete()?;
        let (over, blocks) = (self.over(), self.blocks_left());
        let (stats, times) = (self.stats, self.clock.rounds);
        Ok(Finished { stop, stats, over, times, slivers, blocks })
    }

    /// The next step; `None` if nothing is left to do.
    fn next(&mut self) -> Option<Next> {
        if self.demands.ready().next().is_some() {
            return Some(Next::Round(Class::Boundary));
        }
        if !self.demands.pending.is_empty() {
            return Some(Next::Circles);
        }
        self.find_foremost();
        // Of tetrahedra over their bounds one is before all others.
        match self.front.foremost.is_empty() {
            false => Some(Next::Round(Class::Tets)),
            true => self.next_late(),
        }
    }

    /// Writes what the choice has found into the record; `false` if that is nothing new.
    fn record_round(&mut self) -> bool {
        let Self { own, demands, keys, stats, .. } = self;
        let news = demands.has_waits_or_refusals();
        stats.refused += demands.refusals.len() as u64;
        stats.deferred += demands.asked.len() as u64;
        let has_asked = demands.take_asked(&mut own.record);
        demands.take_refusals(&mut own.record, |t| keys.write(t, 0, keys.look() + 1));
        news || has_asked
    }

    /// Splits items jointly that wait for each other in a circle, in the order of their places.
    fn split_circles(&mut self) -> Result<(), RefineError> {
        self.stats.joint_phases += 1;
        self.reserved.start(0, 0);
        let mut work = Queues::default();
        for item in self.demands.circles(&self.own.state) {
            match self.own.part_circle(item, &mut work) {
                Err(_) => return Err(RefineError::Invariant { what: "room for points" }),
                Ok(true) => self.note_created(),
                Ok(false) => {}
            }
            self.demands.remove(&item);
        }
        self.settle();
        Ok(())
    }
}
