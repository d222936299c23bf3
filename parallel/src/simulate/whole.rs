//! The whole of a run on simulated processors: what comes before and after the kernel, too.
//!
//! The kernel's figures begin when the mesh at the start is distributed, and end when the last
//! processor has stopped. Before that one processor makes the mesh at the start, and sends the
//! others their parts; afterwards it takes in all parts, and inserts what is left. These times are
//! computed, not simulated: a point costs what it costs one processor alone in the same run, a part
//! one message.

use super::Options;
use crate::metrics::{Nanos, Summary};
use crate::protocol::WorkerId;

/// Bytes of a tetrahedron on its way: the numbers of four vertices.
const TETRAHEDRON: f64 = 16.0;
/// Bytes of a vertex: three coordinates.
const VERTEX: f64 = 24.0;

/// Work that one processor does, and the mesh that travels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Around {
    /// Points that one processor inserts, before and after the kernel.
    pub points: u64,
    /// Vertices of the mesh that is distributed.
    pub started: u64,
    /// Vertices of the mesh at the end.
    pub vertices: u64,
    /// The number of times that a mesh is distributed and gathered.
    pub times: u64,
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
    /// One processor takes in all parts.
    pub gathering: Nanos,
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
        let slowness = options.slowness(WorkerId::default());
        let by_one = around.points as f64 * (alone.makespan as f64 / inserted as f64);
        let tets = summary.workers.iter().map(|worker| worker.tets).sum::<u64>() as f64;
        let bytes = |vertices: u64| {
            let part = vertices as f64 / around.vertices.max(1) as f64;
            ((TETRAHEDRON * tets * part + VERTEX * vertices as f64) / count) as u64
        };
        // A processor sends or takes in one part after the other, as fast as it and its link can.
        let parts = |own: f64, bytes: u64| {
            let link = options.network.byte * bytes as f64;
            (count - 1.0) * (slowness * own).max(link) + options.network.latency as f64
        };
        let (first, last) = (bytes(around.started), bytes(around.vertices));
        let costs = &options.costs;
        let times = around.times as f64;
        let travel = |time: f64| if count > 1.0 { (times * time) as Nanos } else { 0 };
        let out = parts(costs.sending(first, false), first) + costs.receiving(first, false);
        let back = parts(costs.receiving(last, false), last) + costs.sending(last, false);
        let start = (slowness * by_one) as Nanos;
        let (distribution, gathering) = (travel(out), travel(back));
        let kernel = summary.makespan;
        let makespan = start + distribution + kernel + gathering;
        let one_processor = by_one as Nanos + alone.makespan;
        let efficiency = one_processor as f64 / (count * makespan.max(1) as f64);
        Some(Self { start, distribution, kernel, gathering, makespan, one_processor, efficiency })
    }
}
