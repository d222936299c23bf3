//! Why threads have made no mesh.

use crate::WorkerError;
use crate::mesh::GatherError;
use ltbw_core::BuildError;

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// There is no first tetrahedron.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A worker has failed.
    #[error(transparent)]
    Worker(#[from] WorkerError),
    /// The machine lacks the threads.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// The number that was wanted.
        threads: usize,
        /// The system's reason.
        reason: String,
    },
    /// The settings contradict each other.
    #[error("{0}")]
    Settings(String),
    /// The submeshes could not be put together.
    #[error(transparent)]
    Gather(#[from] GatherError),
    /// A worker elsewhere, or what came from it.
    #[cfg(feature = "wire")]
    #[error(transparent)]
    Team(#[from] crate::team::TeamError),
    /// A share that came from a worker elsewhere is no part of the mesh.
    #[cfg(feature = "wire")]
    #[error(transparent)]
    Share(#[from] crate::mesh::share::ShareError),
}
