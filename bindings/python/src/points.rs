//! Delaunay meshes of point sets.

use crate::arrays::{Coordinates, points};
use crate::failure::{Class, Failure};
use crate::kernel::{Body, Kernel};
use crate::supervise::{Reins, supervised};
use ltbw::threads::Parallel;
use ltbw::{Builder, Outcome, PointSet};
use pyo3::prelude::*;

/// Meshes points on `threads` threads.
#[pyfunction]
pub(crate) fn delaunay(
    py: Python<'_>,
    coordinates: Coordinates<'_>,
    threads: u32,
    progress: Option<Py<PyAny>>,
) -> PyResult<Kernel> {
    let given = points(&coordinates)?;
    let work = move |reins: &Reins| {
        in_pool(threads, || {
            let set = PointSet::new(given)?;
            let (mesh, outcome) = if threads == 1 {
                let builder = Builder::new().observer(&reins.progress).cancel(&reins.cancel);
                let built = builder.build(&set)?;
                (built.mesh, built.outcome)
            } else {
                let run = Parallel::new(threads).cancel(&reins.cancel).build(&set)?;
                (run.mesh, run.outcome)
            };
            let outcome = match outcome {
                Outcome::Complete => "complete",
                Outcome::Cancelled => "cancelled",
                Outcome::Budget | Outcome::TooManyTets => "budget",
            };
            Ok(Kernel::new(Body::Points { mesh: Box::new(mesh), set }, outcome))
        })
    };
    Ok(supervised(py, progress.as_ref(), work)?)
}

/// Carries out `work` with no more than `threads` threads for sorting and checking.
pub(crate) fn in_pool<T: Send>(
    threads: u32,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads as usize).build();
    pool.map_err(|e| Failure::new(Class::Internal, "threads.start", e))?.install(work)
}
