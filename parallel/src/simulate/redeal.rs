//! The time of a redeal: all workers have stopped, and wait for each other.

use super::Options;
use crate::mesh::redeal::Moved;
use crate::metrics::Nanos;
use crate::protocol::WorkerId;

/// The exchanges that follow one another: words and parcels.
const EXCHANGES: u64 = 2;

/// The time in which the workers of a run deal out their mesh anew.
#[derive(Clone, Debug)]
pub(crate) struct Pause {
    /// Its length.
    pub(crate) all: Nanos,
    /// The part of it in which each worker is at work.
    pub(crate) own: Vec<Nanos>,
}

impl Options {
    /// The time of a redeal, for what it took each worker. What is told all goes up the tree of
    /// barriers, and down again.
    pub(crate) fn redeal(&self, moved: &[Moved]) -> Pause {
        let Self { costs, network, .. } = self;
        let workers = moved.len() as u64;
        let told: u64 = moved.iter().map(|own| own.told).sum();
        let below = u64::from(WorkerId::BELOW).min(workers.saturating_sub(1));
        let levels = u64::from(workers.max(1).ilog(WorkerId::BELOW.into())) + 1;
        // At the top come all bytes in, on the way down they come to each.
        let up = costs.receiving(0, false) * (below * levels) as f64 + told as f64 * costs.byte;
        let down = costs.sending(told, false) * (below * levels) as f64;
        let all_told = if workers > 1 { (up + down) as Nanos } else { 0 };
        let time = |(own, k)| (costs.redeal(own) * self.slowness(WorkerId::at(k))) as Nanos;
        let own: Vec<Nanos> = moved.iter().zip(0..).map(time).map(|own| own + all_told).collect();
        let most = own.iter().copied().max().unwrap_or_default();
        Pause { all: most + (EXCHANGES + 2 * levels) * network.latency, own }
    }
}
