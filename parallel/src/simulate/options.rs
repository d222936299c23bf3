//! The options of a simulated run.

use super::CostModel;
use super::error::SimulationError;
use super::network::{Bursts, Network};
use crate::balance::Balance;
use crate::metrics::Nanos;
use crate::protocol::WorkerId;

/// Blocks that move for no reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RandomMigrations {
    /// Each `every`, one block of a random worker is to go to a random other one.
    pub every: Nanos,
}

/// The options of a simulated run.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Determines all that is random.
    pub seed: u64,
    /// The costs of work and messages.
    pub costs: CostModel,
    /// The network.
    pub network: Network,
    /// Processors that take longer for everything: which, and by what factor.
    pub slow: Vec<(WorkerId, f64)>,
    /// Blocks given to workers that run out of points.
    pub balance: Option<Balance>,
    /// Blocks that move for no reason.
    pub storm: Option<RandomMigrations>,
    /// The time at which all workers are told to start no more points.
    pub cancel: Option<Nanos>,
    /// Under the paper's rule an operation starts again after a random time up to this and four
    /// latencies, doubled with each setback up to 1024 times: the rule may never end if operations
    /// start again before they can have heard of each other.
    pub backoff: Nanos,
    /// The number of events after which the run fails.
    pub max_events: u64,
    /// The longest time without an insertion, while a worker has work, before the run fails.
    pub patience: Nanos,
    /// The invariants of the protocol are checked over all workers each time this number of events
    /// have happened; 0 for never. A check takes time in proportion to the mesh.
    pub check_every: u64,
    /// A worker with work of its own looks for messages before each `poll_every`-th step of it: the
    /// paper polls after every cavity, and names over-polling as the price. In rounds, where others
    /// wait, it looks before each.
    pub poll_every: u32,
    /// The messages of a turn, from one look for messages to the next, leave together when it is
    /// over, as those of threads and processes do; if not, each leaves at once.
    pub letters: bool,
    /// Stretches of time kept for a trace, per worker; 0 for no trace.
    pub spans: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            seed: 1,
            costs: CostModel::default(),
            network: Network::default(),
            slow: Vec::new(),
            balance: None,
            storm: None,
            cancel: None,
            backoff: 50_000,
            max_events: 10_000_000_000,
            patience: 3_600_000_000_000,
            check_every: 0,
            poll_every: 1,
            letters: false,
            spans: 0,
        }
    }
}

/// The most processors of a simulation.
pub(super) const MAX_PROCESSORS: usize = 1024;

/// Every single time is below this (a day), so that no sum of times overflows.
const LONGEST: Nanos = 86_400_000_000_000;

impl Options {
    /// The factor by which a processor takes longer.
    pub(super) fn slowness(&self, id: WorkerId) -> f64 {
        self.slow.iter().find(|(w, _)| *w == id).map_or(1.0, |&(_, factor)| factor)
    }

    /// Do the options make sense for this number of workers?
    pub(super) fn check(&self, workers: usize) -> Result<(), SimulationError> {
        let network = &self.network;
        let bursts = network.bursts.unwrap_or(Bursts { every: 1, length: 0 });
        let storm = self.storm.map_or(1, |s| s.every);
        let balance = self.balance.map_or(1, |b| b.again);
        let times = [network.latency, bursts.every, storm, balance, self.backoff];
        let checks = [
            ((1..=MAX_PROCESSORS).contains(&workers), "there must be 1 to 1024 processors"),
            (self.costs.is_sensible(), "costs must lie from 0 to 10^12 ns"),
            ((0.0..=1e6).contains(&network.byte), "a byte must take from 0 to 10^6 ns"),
            (times.iter().all(|&t| t <= LONGEST), "no time may be longer than a day"),
            (bursts.length < bursts.every, "a burst must be shorter than its period"),
            (self.poll_every > 0, "messages must be looked for every so many steps, not every 0"),
            (storm > 0 && balance > 0, "periods must not be 0"),
            (
                self.slow.iter().all(|(_, factor)| (0.001..=1e6).contains(factor)),
                "a processor's slowness must lie from 0.001 to 10^6",
            ),
            (
                self.slow.iter().all(|&(w, _)| w.index() < workers),
                "a slow processor must be one of the processors",
            ),
        ];
        match checks.iter().find(|(holds, _)| !holds) {
            Some((_, text)) => Err(SimulationError::Options((*text).to_owned())),
            None => Ok(()),
        }
    }
}
