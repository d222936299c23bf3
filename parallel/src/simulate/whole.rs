//! The whole of a run on simulated processors: what comes before and after the kernel, too.
//!
//! The kernel's figures begin when the mesh at the start is distributed, and end when the last
//! processor has stopped. Before that one processor makes the mesh at the start, and sends the
//! others their parts. Afterwards all keep theirs, as processes do (`ltbw-mpi`): each looks at it
//! once more, and they number its vertices together (of given points they order their slices along
//! the curve before, which is the same sort). What takes the whole mesh has one processor
//! take in all parts, and insert what is left. These times are computed, not simulated: a point
//! costs what it costs one processor alone in the same run, a part one message. One processor that
//! is alone is not charged with looks and numbers.

use super::Options;
use crate::metrics::{Nanos, Summary};
use crate::protocol::WorkerId;

/// Bytes of a tetrahedron on its way: the numbers of four vertices.
const TETRAHEDRON: f64 = 16.0;
/// Bytes of a vertex: three coordinates.
const VERTEX: f64 = 24.0;
/// Bytes of a vertex that asks for its number: key, coordinates, kind.
const ASKED: f64 = 40.0;
/// Bytes of a number.
const NUMBER: f64 = 4.0;
/// Bytes that each tells when parts are numbered, and those of them that all are told of each:
/// whether it keeps its part, the box around it, samples of an order, of which all are told one cut
/// each, counts, figures.
const TOLD: [[f64; 2]; 5] = [[1.0; 2], [48.0; 2], [64.0 * ASKED, ASKED], [24.0; 2], [1024.0; 2]];
/// Steps of a vertex while it is numbered: its key, and its place in two orders.
const NUMBERED: f64 = 3.0;

/// Work that one processor does, and the mesh that travels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Around {
    /// Points that one processor inserts, before and after the kernel.
    pub points: u64,
    /// Vertices of the mesh that is distributed.
    pub started: u64,
    /// Vertices of the mesh at the end.
    pub vertices: u64,
    /// The number of times that a mesh is distributed.
    pub times: u64,
    /// The number of times that one processor takes in all parts.
    pub gathered: u64,
    /// Does each look at its tetrahedra once more, where parts stay?
    pub looks: bool,
}

/// The parts of a whole run, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Whole {
    /// One processor makes the mesh at the start, and inserts what is left at the end.
    pub start: Nanos,
    /// It sends the others their parts.
    pub distribution: Nanos,
    /// All processors work.
    pub kernel: Nanos,
    /// One processor takes in all parts; 0 if nothing takes the whole mesh.
    pub gathering: Nanos,
    /// All number what they keep; 0 if one has the mesh in the end.
    pub numbering: Nanos,
    /// All of these.
    pub makespan: Nanos,
    /// The time of one processor for the same whole.
    pub one_processor: Nanos,
    /// The share of the processors' time that one would have needed.
    pub efficiency: f64,
}

impl Whole {
    /// The whole of a run; `alone` is the run of one processor. `None` if that inserted nothing:
    /// what a point costs is not known.
    #[must_use]
    pub fn of(
        summary: &Summary,
        alone: &Summary,
        around: &Around,
        options: &Options,
    ) -> Option<Self> {
        let count = summary.workers.len() as f64;
        let inserted = alone.operations();
        if inserted == 0 || count == 0.0 {
            return None;
        }
        // The time of one processor alone is slowed down already.
        let slowness = if count > 1.0 { options.slowness(WorkerId::default()) } else { 1.0 };
        let team = Team { options, count, slowness };
        let by_one = around.points as f64 * (alone.makespan as f64 / inserted as f64);
        let tets = summary.workers.iter().map(|worker| worker.tets).sum::<u64>() as f64;
        let bytes = |vertices: u64| {
            let part = vertices as f64 / around.vertices.max(1) as f64;
            ((TETRAHEDRON * tets * part + VERTEX * vertices as f64) / count) as u64
        };
        let (first, last) = (bytes(around.started), bytes(around.vertices));
        let costs = &options.costs;
        let out = team.parts(costs.sending(first, false), first) + costs.receiving(first, false);
        let back = team.parts(costs.receiving(last, false), last) + costs.sending(last, false);
        let looked = if around.looks { tets * costs.look } else { 0.0 };
        let vertices = around.vertices as f64;
        let travel = |times: u64, time: f64| {
            if count > 1.0 { (times as f64 * time) as Nanos } else { 0 }
        };
        let start = (team.slowness * by_one) as Nanos;
        let distribution = travel(around.times, out);
        let gathering = travel(around.gathered, back);
        let own = (looked + vertices * NUMBERED * costs.step) / count;
        let numbering = match count > 1.0 && around.gathered < around.times {
            true => (team.slowness * own + team.numbering(vertices / count)) as Nanos,
            false => 0,
        };
        let kernel = summary.makespan;
        let makespan = start + distribution + kernel + gathering + numbering;
        let one_processor = by_one as Nanos + alone.makespan;
        let efficiency = one_processor as f64 / (count * makespan.max(1) as f64);
        Some(Self {
            start,
            distribution,
            kernel,
            gathering,
            numbering,
            makespan,
            one_processor,
            efficiency,
        })
    }
}

/// Processors that do something together, as the members of a team of processes do; the slowest
/// one takes part in everything.
struct Team<'o> {
    options: &'o Options,
    count: f64,
    slowness: f64,
}

impl Team<'_> {
    /// The time of one that sends or takes in one part after the other, each of `own` nanoseconds:
    /// as fast as it and its link can.
    fn parts(&self, own: f64, bytes: u64) -> f64 {
        let network = &self.options.network;
        let link = network.byte * bytes as f64;
        (self.count - 1.0) * (self.slowness * own).max(link) + network.latency as f64
    }

    /// The time until all have `told` bytes for each of them, of the `bytes` that each had: the
    /// first one takes in all, and tells them down a tree in which each tells twice as many.
    fn gather_all(&self, [bytes, told]: [f64; 2]) -> f64 {
        let Options { costs, network, .. } = self.options;
        let (own, all) = (bytes as u64, (told * self.count) as u64);
        let taken = self.parts(costs.receiving(own, false), own) + costs.sending(own, false);
        let link = network.byte * all as f64 + network.latency as f64;
        let hop = self.slowness * (costs.sending(all, false) + costs.receiving(all, false)) + link;
        taken + self.count.log2().ceil() * hop
    }

    /// The time until each has what all others have for it, of as many bytes as it has for them.
    fn exchange(&self, bytes: f64) -> f64 {
        let Options { costs, network, .. } = self.options;
        let letters = (self.count - 1.0) * (costs.send + costs.receive);
        let own = letters + 2.0 * costs.byte * bytes;
        self.slowness * own + network.byte * bytes + network.latency as f64
    }

    /// The time of all messages while each numbers as many vertices: they go to where they are
    /// sorted, and their numbers back.
    fn numbering(&self, vertices: f64) -> f64 {
        let told: f64 = TOLD.iter().map(|&bytes| self.gather_all(bytes)).sum();
        told + self.exchange(ASKED * vertices) + self.exchange(NUMBER * vertices)
    }
}
