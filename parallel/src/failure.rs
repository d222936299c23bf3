//! The failure of a worker, which ends its run: on threads and simulated alike.

use crate::protocol::{Broken, Invariant, SubmeshError, WorkerId};

/// Why a worker has failed, and with it the run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WorkerError {
    /// Its submesh has failed: it has no room for more tetrahedra, say.
    #[error("worker {worker}: {error}")]
    Submesh {
        /// The worker.
        worker: WorkerId,
        /// Why it has failed.
        error: SubmeshError,
    },
    /// An invariant of the protocol is broken: a defect of this crate, or of the submesh.
    #[error("worker {worker}: invariant {invariant} is broken: {what}")]
    Broken {
        /// The worker that found it.
        worker: WorkerId,
        /// Which one, of `docs/protocol.md`.
        invariant: Invariant,
        /// The finding.
        what: String,
    },
    /// It has panicked: a defect.
    #[error("worker {worker} has failed: {message}")]
    Failed {
        /// The worker.
        worker: WorkerId,
        /// The message of its panic.
        message: String,
    },
}

impl WorkerError {
    /// The error of a worker whose step has panicked with `message`.
    pub(crate) fn of_panic(worker: WorkerId, message: String) -> Self {
        match Broken::from_message(&message) {
            Some(Broken { invariant, what }) => Self::Broken { worker, invariant, what },
            None => Self::Failed { worker, message },
        }
    }
}
