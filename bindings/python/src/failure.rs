//! Errors on their way to Python: classes of `ltbw.errors`.

use ltbw_bindings::{Class, Defect};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::io::ErrorKind;

/// Why there is no result.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An error of the package.
    Own(ltbw_bindings::Failure),
    /// An error of Python code that was called: it goes back as it is.
    Python(PyErr),
}

impl Failure {
    pub(crate) fn new(class: Class, code: &'static str, message: impl ToString) -> Self {
        Self::Own(ltbw_bindings::Failure::new(class, code, message))
    }
}

impl From<ltbw_bindings::Failure> for Failure {
    fn from(failure: ltbw_bindings::Failure) -> Self {
        Self::Own(failure)
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        let failure = match failure {
            Failure::Python(error) => return error,
            Failure::Own(failure) => failure,
        };
        let name = match failure.class {
            Class::Input => "InputError",
            Class::Domain => "DomainError",
            Class::Recovery => "RecoveryError",
            Class::Cancelled => "Cancelled",
            Class::Machine => "MachineError",
            Class::Internal => "InternalError",
            Class::File if failure.reason().is_some_and(|e| e.kind() == ErrorKind::NotFound) => {
                "MissingFileError"
            }
            Class::File => "FileError",
        };
        let reason = failure.reason();
        Python::attach(|py| {
            let made = py
                .import("ltbw.errors")
                .and_then(|module| module.getattr(name))
                .and_then(|class| class.call1((failure.message, failure.code, failure.ids)))
                .and_then(|error| {
                    if let (Some(reason), Some((number, path))) = (reason, failure.file) {
                        error.setattr("errno", number)?;
                        error.setattr("strerror", reason.to_string())?;
                        error.setattr("filename", path)?;
                    }
                    if !failure.defects.is_empty() {
                        error.setattr("defects", listed(py, &failure.defects)?)?;
                    }
                    Ok(error)
                });
            made.map_or_else(|error| error, PyErr::from_value)
        })
    }
}

/// Defects as a list of dicts.
fn listed<'py>(py: Python<'py>, defects: &[Defect]) -> PyResult<Bound<'py, PyList>> {
    let entries = defects.iter().map(|defect| {
        let entry = PyDict::new(py);
        entry.set_item("kind", defect.kind)?;
        entry.set_item("text", &defect.text)?;
        entry.set_item("vertices", &defect.vertices)?;
        entry.set_item("facets", &defect.facets)?;
        entry.set_item("edges", &defect.edges)?;
        entry.set_item("places", &defect.places)?;
        Ok(entry)
    });
    PyList::new(py, entries.collect::<PyResult<Vec<_>>>()?)
}
