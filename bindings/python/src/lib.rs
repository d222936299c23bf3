//! The native half of the Python package `ltbw`.
//!
//! Python code (`python/ltbw`) turns what users have into arrays and gives the results their names;
//! `ltbw-bindings` meshes, checks and converts; this crate carries arrays to and fro. No call holds
//! the interpreter while it computes: `supervise` runs the work on a thread of its own, looks for
//! signals and tells the progress.
#![deny(unsafe_code)]

mod arrays;
mod certificate;
mod domain;
mod failure;
mod kernel;
mod points;
mod size;
mod stored;
mod supervise;

use pyo3::prelude::*;

/// The module `ltbw._native`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<kernel::Kernel>()?;
    module.add_function(wrap_pyfunction!(points::read_points, module)?)?;
    module.add_function(wrap_pyfunction!(points::delaunay, module)?)?;
    module.add_function(wrap_pyfunction!(domain::tetrahedralize, module)?)?;
    module.add_function(wrap_pyfunction!(certificate::check, module)?)?;
    module.add_function(wrap_pyfunction!(certificate::check_domain, module)?)?;
    module.add_function(wrap_pyfunction!(stored::save, module)?)?;
    module.add_function(wrap_pyfunction!(supervise::panics, module)?)
}
