//! Delaunay meshes of point sets.

use crate::arrays::{Coordinates, points};
use crate::kernel::Kernel;
use crate::supervise::supervised;
use ltbw_bindings::Reins;
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
    let work = move |reins: &Reins| Ok(ltbw_bindings::delaunay(given, threads, reins)?);
    Ok(Kernel::new(supervised(py, progress.as_ref(), work)?))
}
