//! Why a simulated run has no result.

use crate::WorkerError;
use crate::metrics::Nanos;
use crate::protocol::{Invariant, WorkerId};

/// Why a simulated run has no result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// An option makes no sense.
    #[error("{0}")]
    Options(String),
    /// The workers are not numbered from 0 on, or there are none.
    #[error("the workers are not numbered from 0 to one less than their number: {place} is {id}")]
    Workers {
        /// The place in the list.
        place: usize,
        /// The worker there.
        id: WorkerId,
    },
    /// A worker has failed.
    #[error(transparent)]
    Worker(#[from] WorkerError),
    /// The check over all workers has found a broken invariant, see [`Options::check_every`].
    ///
    /// [`Options::check_every`]: super::Options::check_every
    #[error("at {time} ns: invariant {invariant} is broken: {what}")]
    Inconsistent {
        /// Virtual time.
        time: Nanos,
        /// Which one, of `docs/protocol.md`.
        invariant: Invariant,
        /// The finding.
        what: String,
    },
    /// The limit on events is reached.
    #[error("{events} events, and no end: {operations} points inserted by {time} ns")]
    TooManyEvents {
        /// Events so far.
        events: u64,
        /// Points inserted.
        operations: u64,
        /// Virtual time.
        time: Nanos,
    },
    /// No point was inserted for too long although worker `worker` has work.
    #[error(
        "no point was inserted from {since} to {time} ns, with work left at worker {worker}: \
         {operations} inserted, {setbacks} setbacks"
    )]
    NoProgress {
        /// The last insertion.
        since: Nanos,
        /// Virtual time.
        time: Nanos,
        /// A worker with work.
        worker: WorkerId,
        /// Points inserted.
        operations: u64,
        /// Attempts set back.
        setbacks: u64,
    },
    /// No event is left, but these workers have not stopped.
    #[error("nothing happens any more at {time} ns, but {workers:?} have not stopped")]
    Stuck {
        /// Virtual time.
        time: Nanos,
        /// The workers.
        workers: Vec<WorkerId>,
    },
    /// The run has ended, but something is still locked or awaited at these workers.
    #[error("all workers stopped, but something is still locked or awaited at {workers:?}")]
    NotQuiescent {
        /// The workers.
        workers: Vec<WorkerId>,
    },
}
