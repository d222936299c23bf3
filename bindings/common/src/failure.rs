//! Failures: a class, a code that stays the same between versions, and the elements that are at
//! fault.

use ltbw::domain::{DomainDefect, DomainError, Element, PrepareError};
use ltbw::io::IoError;
use ltbw::points::PointError;
use ltbw::refine::{BackgroundError, RefineError};
use ltbw::threads::RunError;
use ltbw::{BuildError, HashError, Point, RemoveError};
use std::io::ErrorKind;
use std::path::PathBuf;

/// The class of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// The arguments are no points, no surface, or no bounds that a mesh can meet.
    Input,
    /// The domain bounds nothing that can be meshed.
    Domain,
    /// The boundary could not be brought into a Delaunay mesh.
    Recovery,
    /// Cancelled before there was a mesh.
    Cancelled,
    /// The machine lacks memory or threads.
    Machine,
    /// A defect of ltbw.
    Internal,
    /// The operating system refused a file.
    File,
}

/// Why there is no result.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Its class.
    pub class: Class,
    /// A short name that stays the same between versions.
    pub code: &'static str,
    /// The message for people.
    pub message: String,
    /// The numbers of the elements at fault, counted from 0.
    pub ids: Vec<u32>,
    /// The operating system's number of an error, and the file.
    pub file: Option<(i32, PathBuf)>,
    /// The defects of a domain, the first hundred of each kind.
    pub defects: Box<[Defect]>,
}

/// A defect of a domain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Defect {
    /// A short name of its kind, that stays the same between versions.
    pub kind: &'static str,
    /// The text for people.
    pub text: String,
    /// The vertices that it concerns, counted from 0.
    pub vertices: Vec<u32>,
    /// The facets that it concerns.
    pub facets: Vec<u32>,
    /// The edges that it concerns, by their ends.
    pub edges: Vec<[u32; 2]>,
    /// Its places.
    pub places: Vec<Point>,
}

impl From<&DomainDefect> for Defect {
    fn from(defect: &DomainDefect) -> Self {
        let (kind, text) = (defect.kind.code(), defect.to_string());
        let mut own = Self { kind, text, places: defect.at.clone(), ..Self::default() };
        for element in &defect.elements {
            match *element {
                Element::Vertex(v) => own.vertices.push(v),
                Element::Facet(f) => own.facets.push(f),
                Element::Polygon { facet, .. } | Element::FacetHole { facet, .. } => {
                    own.facets.push(facet);
                }
                Element::Edge(ends) => own.edges.push(ends),
                _ => {}
            }
        }
        own
    }
}

impl Failure {
    /// A failure of no element in particular.
    pub fn new(class: Class, code: &'static str, message: impl ToString) -> Self {
        let (message, ids) = (message.to_string(), Vec::new());
        Self { class, code, message, ids, file: None, defects: Box::default() }
    }

    /// The operating system's reason, if it is one of a file.
    #[must_use]
    pub fn reason(&self) -> Option<std::io::Error> {
        self.file.as_ref().map(|(number, _)| std::io::Error::from_raw_os_error(*number))
    }

    /// This failure with elements at fault.
    #[must_use]
    pub fn with(mut self, more: impl IntoIterator<Item = u32>) -> Self {
        self.ids.extend(more);
        self
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
            BuildError::Memory(_) => (Class::Machine, "memory"),
            _ => (Class::Input, "points"),
        };
        Self::new(class, code, &error)
    }
}

impl From<RemoveError> for Failure {
    fn from(error: RemoveError) -> Self {
        match error {
            RemoveError::Unknown { vertex } => {
                Self::new(Class::Input, "without.unknown", error).with([vertex])
            }
            RemoveError::Flat { vertex, .. } => {
                Self::new(Class::Input, "without.flat", error).with([vertex])
            }
            RemoveError::TooManyTets { .. } => Self::new(Class::Input, "without.too-many", error),
            other => Self::new(Class::Internal, "without.damaged", other),
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Build(error) => error.into(),
            RunError::Threads { .. } => Self::new(Class::Machine, "threads.start", &error),
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
            IoError::Read { source, .. } | IoError::Write { source, .. }
                if source.kind() == ErrorKind::OutOfMemory =>
            {
                (Class::Machine, "memory")
            }
            IoError::Read { .. } => (Class::File, "file.read"),
            IoError::Write { .. } => (Class::File, "file.write"),
            IoError::Cancelled { .. } => (Class::Cancelled, "cancelled"),
            IoError::Parse { .. } => (Class::Input, "file.parse"),
            IoError::Data { .. } => (Class::Input, "file.data"),
            _ => (Class::Input, "file.format"),
        };
        let file = match &error {
            _ if class == Class::Machine => None,
            IoError::Read { path, source } | IoError::Write { path, source } => {
                source.raw_os_error().map(|number| (number, path.clone()))
            }
            _ => None,
        };
        Self { file, ..Self::new(class, code, &error) }
    }
}

/// The numbers of an element.
fn numbers(element: &Element) -> Vec<u32> {
    match *element {
        Element::Vertex(n)
        | Element::Facet(n)
        | Element::Segment(n)
        | Element::Hole(n)
        | Element::Region(n)
        | Element::Point(n) => vec![n],
        Element::Polygon { facet, polygon } => vec![facet, polygon],
        Element::FacetHole { facet, hole } => vec![facet, hole],
        Element::Edge(ends) => ends.to_vec(),
        _ => Vec::new(),
    }
}

impl From<DomainError> for Failure {
    fn from(error: DomainError) -> Self {
        let at_fault = match &error {
            DomainError::NotFinite { element, .. }
            | DomainError::Index { element, .. }
            | DomainError::ShortPolygon { element, .. } => numbers(element),
            DomainError::RegionValue { region, .. } => vec![*region],
            DomainError::OffLattice { vertex, .. } => vec![*vertex],
            _ => Vec::new(),
        };
        Self::new(Class::Domain, error.code(), &error).with(at_fault)
    }
}

impl From<PrepareError> for Failure {
    fn from(error: PrepareError) -> Self {
        let class = match error {
            PrepareError::Domain(error) => return error.into(),
            PrepareError::Tolerance { .. }
            | PrepareError::Simplify { .. }
            | PrepareError::SimplifyPoints { .. } => Class::Input,
            _ => Class::Domain,
        };
        let first = |defect: &DomainDefect| defect.elements.iter().flat_map(numbers).collect();
        let ids: Vec<u32> =
            error.report().and_then(|r| r.defects.first()).map(first).unwrap_or_default();
        let defects = error.report().map(|r| r.defects.iter().map(Defect::from).collect());
        let failure = Self::new(class, error.code(), &error).with(ids);
        Self { defects: defects.unwrap_or_default(), ..failure }
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
            RefineError::Build(BuildError::Memory(_)) => (Class::Machine, "memory"),
            RefineError::Bound { .. } => (Class::Input, "refine.bound"),
            RefineError::Size { .. } | RefineError::ImpureSize { .. } => {
                (Class::Input, "refine.size")
            }
            RefineError::Cancelled => (Class::Cancelled, "cancelled"),
            RefineError::NoInterior => (Class::Domain, "refine.no-interior"),
            _ => (Class::Domain, "refine.domain"),
        };
        Self::new(class, code, &error)
    }
}
