//! Delaunay meshes of point sets.

use crate::arrays::{Coordinates, coordinates, points};
use crate::kernel::Kernel;
use crate::supervise::supervised;
use ltbw_bindings::{Reins, in_own_pool};
use numpy::PyArray2;
use pyo3::prelude::*;
use std::path::PathBuf;

/// The points of a file.
#[pyfunction]
pub(crate) fn read_points(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let read = move |_: &Reins| {
        in_own_pool(|| {
            Ok(ltbw::io::read_points(&path).map_err(ltbw_bindings::Failure::from)?.points)
        })
    };
    coordinates(py, supervised(py, None, read)?)
}

/// Meshes points on `threads` threads, without those that `without` names; with notes.
#[pyfunction]
pub(crate) fn delaunay(
    py: Python<'_>,
    given: Coordinates<'_>,
    without: Vec<u32>,
    threads: u32,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Kernel, Vec<String>)> {
    let given = points(&given)?;
    let work = move |reins: &Reins| Ok(ltbw_bindings::delaunay(given, &without, threads, reins)?);
    let mut meshed = supervised(py, progress.as_ref(), work)?;
    let notes = std::mem::take(&mut meshed.notes);
    Ok((Kernel::new(meshed), notes))
}
