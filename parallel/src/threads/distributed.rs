//! A mesh that is where it was built: every worker has its submesh.

use super::{Run, RunError, WorkerStats};
use crate::mesh::{LocalMesh, SharedInput, gather};
use crate::metrics::{Summary, Trace};
use ltbw_core::{Outcome, Vertex};
use std::time::Instant;

/// A mesh in as many parts as there were workers.
#[derive(Debug)]
pub struct Distributed {
    pub(super) meshes: Vec<LocalMesh>,
    pub(super) common: SharedInput,
    pub(super) outcome: Outcome,
    /// Seconds of the start and of the workers.
    pub(super) seconds: [f64; 2],
    pub(super) workers: Vec<WorkerStats>,
    pub(super) summary: Option<Summary>,
    pub(super) trace: Option<Trace>,
}

impl Distributed {
    /// The outcome: whether all points are in the mesh.
    pub fn outcome(&self) -> Outcome {
        self.outcome
    }

    /// Number of parts: that of the workers.
    pub fn parts(&self) -> usize {
        self.meshes.len()
    }

    /// The finite tetrahedra of a part, positively oriented, by the input's numbers. Each
    /// tetrahedron of the mesh is in one part; a part may be empty.
    pub fn tets(&self, part: usize) -> impl Iterator<Item = [Vertex; 4]> + '_ {
        let all = self.meshes.get(part).into_iter().flat_map(LocalMesh::given_tets);
        all.map(|v| v.map(|v| self.common.numbers[v as usize - 1]))
    }

    /// Puts the parts together.
    ///
    /// # Errors
    /// [`RunError::Gather`] if there are too many tetrahedra.
    pub fn gather(self) -> Result<Run, RunError> {
        let clock = Instant::now();
        let whole = gather(self.meshes, self.common)?;
        let [start_seconds, insert_seconds] = self.seconds;
        Ok(Run {
            mesh: whole.mesh,
            outcome: self.outcome,
            duplicates: whole.duplicates,
            start_seconds,
            insert_seconds,
            gather_seconds: clock.elapsed().as_secs_f64(),
            workers: self.workers,
            summary: self.summary,
            trace: self.trace,
        })
    }
}
