//! Errors on their way to Python: a class of `ltbw._errors`, a code that stays the same between
//! versions, and the elements that are at fault.

use ltbw::domain::{DomainDefect, DomainError, Element, PrepareError};
use ltbw::io::IoError;
use ltbw::points::PointError;
use ltbw::refine::{BackgroundError, RefineError};
use ltbw::threads::RunError;
use ltbw::{BuildError, HashError};
use pyo3::prelude::*;

/// The class of an error in `ltbw._errors`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Class {
    /// The input is no input: `InputError`.
    Input,
    /// The domain is defective: `DomainError`.
    Domain,
    /// The boundary could not be brought into a Delaunay mesh: `RecoveryError`.
    Recovery,
    /// Cancelled before there was a mesh: `Cancelled`.
    Cancelled,
    /// A defect of this package: `InternalError`.
    Internal,
    /// The operating system refused a file: `FileError`.
    File,
}

/// Why there is no result.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An error of the package.
    Own { class: Class, code: &'static str, message: String, ids: Vec<u32> },
    /// An error of Python code that was called: it goes back as it is.
    Python(PyErr),
}

impl Failure {
    pub(crate) fn new(class: Class, code: &'static str, message: impl ToString) -> Self {
        Self::Own { class, code, message: message.to_string(), ids: Vec::new() }
    }

    pub(crate) fn with(self, more: impl IntoIterator<Item = u32>) -> Self {
        match self {
            Self::Own { class, code, message, mut ids } => {
                ids.extend(more);
                Self::Own { class, code, message, ids }
            }
            other => other,
        }
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        let (class, code, message, ids) = match failure {
            Failure::Python(error) => return error,
            Failure::Own { class, code, message, ids } => (class, code, message, ids),
        };
        let name = match class {
            Class::Input => "InputError",
            Class::Domain => "DomainError",
            Class::Recovery => "RecoveryError",
            Class::Cancelled => "Cancelled",
            Class::Internal => "InternalError",
            Class::File => "FileError",
        };
        Python::attach(|py| {
            let made = py
                .import("ltbw._errors")
                .and_then(|module| module.getattr(name))
                .and_then(|class| class.call1((message, code, ids)));
            made.map_or_else(|error| error, PyErr::from_value)
        })
    }
}

impl From<PointError> for Failure {
    fn from(error: PointError) -> Self {
        match error {
            PointError::NotFinite { index, .. } => {
                Self::new(Class::Input, "points.not-finite", &error).with([index as u32])
            }
            _ => Self::new(Class::Input, "points.too-many", &error),
        }
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        let (class, code) = match error {
            BuildError::TooFewPoints { .. } => (Class::Input, "points.too-few"),
            BuildError::Collinear { .. } => (Class::Input, "points.collinear"),
            BuildError::Coplanar { .. } => (Class::Input, "points.coplanar"),
            BuildError::Cancelled => (Class::Cancelled, "cancelled"),
            _ => (Class::Input, "points"),
        };
        Self::new(class, code, &error)
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Build(error) => error.into(),
            RunError::Settings(text) => Self::new(Class::Input, "threads.settings", text),
            other => Self::new(Class::Internal, "threads.failed", &other),
        }
    }
}

impl From<HashError> for Failure {
    fn from(error: HashError) -> Self {
        Self::new(Class::Input, "mesh.hash", &error)
    }
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        let (class, code) = match &error {
            IoError::Read { .. } => (Class::File, "file.read"),
            IoError::Write { .. } => (Class::File, "file.write"),
            IoError::Parse { .. } => (Class::Input, "file.parse"),
            IoError::Data { .. } => (Class::Input, "file.data"),
            _ => (Class::Input, "file.format"),
        };
        Self::new(class, code, &error)
    }
}

/// The numbers of an element.
fn numbers(element: &Element) -> Vec<u32> {
    match *element {
        Element::Vertex(n)
        | Element::Facet(n)
        | Element::Segment(n)
        | Element::Hole(n)
        | Element::Region(n) => vec![n],
        Element::Polygon { facet, polygon } => vec![facet, polygon],
        Element::FacetHole { facet, hole } => vec![facet, hole],
        Element::Edge(ends) => ends.to_vec(),
        _ => Vec::new(),
    }
}

impl From<DomainError> for Failure {
    fn from(error: DomainError) -> Self {
        Self::new(Class::Domain, error.code(), &error)
    }
}

impl From<PrepareError> for Failure {
    fn from(error: PrepareError) -> Self {
        let class = match error {
            PrepareError::Tolerance { .. } => Class::Input,
            _ => Class::Domain,
        };
        let first = |defect: &DomainDefect| defect.elements.iter().flat_map(numbers).collect();
        let ids: Vec<u32> =
            error.report().and_then(|r| r.defects.first()).map(first).unwrap_or_default();
        Self::new(class, error.code(), &error).with(ids)
    }
}

impl From<BackgroundError> for Failure {
    fn from(error: BackgroundError) -> Self {
        let failure = Self::new(Class::Input, "size", &error);
        match error {
            BackgroundError::Size { number, .. } => failure.with([number as u32]),
            _ => failure,
        }
    }
}

impl From<RefineError> for Failure {
    fn from(error: RefineError) -> Self {
        let (class, code) = match &error {
            RefineError::Bound { .. } => (Class::Input, "refine.bound"),
            RefineError::Cancelled => (Class::Cancelled, "cancelled"),
            RefineError::NoInterior => (Class::Domain, "refine.no-interior"),
            _ => (Class::Domain, "refine.domain"),
        };
        Self::new(class, code, &error)
    }
}
