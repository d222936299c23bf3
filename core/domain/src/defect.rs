//! The defects that a domain can have.
//!
//! A [`DomainError`] is the first reason why a domain cannot even be looked at; a [`DomainDefect`]
//! is a finding of the geometric check, which collects them all. Both name elements as the file
//! has them, counted from 0, and both have codes that stay the same between versions.

use ltbw_exact::Point;
use std::fmt;

/// A part of a domain, by its place in the lists of [`crate::Domain`], counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Element {
    /// A vertex.
    Vertex(u32),
    /// A point that is to be a vertex of the mesh.
    Point(u32),
    /// A facet.
    Facet(u32),
    /// A polygon of a facet.
    Polygon {
        /// The facet.
        facet: u32,
        /// Which of its polygons.
        polygon: u32,
    },
    /// An edge of polygons, by its two vertices.
    Edge([u32; 2]),
    /// A free-standing segment.
    Segment(u32),
    /// A hole point of a facet.
    FacetHole {
        /// The facet.
        facet: u32,
        /// Which of its hole points.
        hole: u32,
    },
    /// A hole of the domain.
    Hole(u32),
    /// A region.
    Region(u32),
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Element::Vertex(v) => write!(f, "vertex {v}"),
            Element::Facet(i) => write!(f, "facet {i}"),
            Element::Polygon { facet, polygon: 0 } => write!(f, "facet {facet}"),
            Element::Polygon { facet, polygon } => write!(f, "facet {facet} polygon {polygon}"),
            Element::Edge([a, b]) => write!(f, "edge {a}-{b}"),
            Element::Segment(s) => write!(f, "segment {s}"),
            Element::FacetHole { facet, hole } => write!(f, "facet {facet} hole {hole}"),
            Element::Hole(h) => write!(f, "hole {h}"),
            Element::Point(p) => write!(f, "point {p}"),
            Element::Region(r) => write!(f, "region {r}"),
        }
    }
}

/// Why a domain cannot be used at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DomainError {
    /// There is no facet.
    #[error("the domain has no facets")]
    Empty,
    /// A number is NaN or infinite.
    #[error("{element} has the coordinates {at:?}, which are not all finite")]
    NotFinite {
        /// The element that has it.
        element: Element,
        /// Its coordinates.
        at: Point,
    },
    /// The attribute of a region is not finite, or its volume bound not positive and finite.
    #[error(
        "region {region}: attribute {attribute} or volume bound {max_volume:?} is no such value"
    )]
    RegionValue {
        /// The region.
        region: u32,
        /// Its attribute.
        attribute: f64,
        /// Its volume bound.
        max_volume: Option<f64>,
    },
    /// An index names no vertex.
    #[error("{element} names vertex {vertex}, but there are {vertices} vertices")]
    Index {
        /// The element that names it.
        element: Element,
        /// The index.
        vertex: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// A polygon has fewer than two vertices.
    #[error("{element} has {corners} corners; a polygon has at least 2")]
    ShortPolygon {
        /// The polygon.
        element: Element,
        /// The number of its corners.
        corners: usize,
    },
    /// More vertices than a mesh can hold.
    #[error("{count} vertices exceed the limit of {}", ltbw_exact::points::MAX_POINTS)]
    TooManyVertices {
        /// Their number.
        count: usize,
    },
    /// All vertices are at the origin, or so near to it or far from it that the lattice would
    /// leave the exactness window.
    #[error(
        "the largest coordinate is {largest:e}; the lattice needs one between 2^-90 and 2^199 \
         (rescale the domain)"
    )]
    Range {
        /// The largest magnitude of a coordinate.
        largest: f64,
    },
    /// A vertex is not on the lattice, and snapping was refused.
    #[error(
        "{moved} vertices are not on the lattice of step {step:e}; vertex {vertex} at {at:?} would \
         move farthest, by {distance:e}"
    )]
    OffLattice {
        /// The vertex that would move farthest.
        vertex: u32,
        /// Its place.
        at: Point,
        /// The distance that it would move.
        distance: f64,
        /// The step of the lattice.
        step: f64,
        /// The number of vertices that would move.
        moved: usize,
    },
}

impl DomainError {
    /// A short code that stays the same between versions, for programs to match on.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            DomainError::Empty => "domain.empty",
            DomainError::NotFinite { .. } => "domain.not-finite",
            DomainError::RegionValue { .. } => "domain.region-value",
            DomainError::Index { .. } => "domain.index",
            DomainError::ShortPolygon { .. } => "domain.short-polygon",
            DomainError::TooManyVertices { .. } => "domain.too-many-vertices",
            DomainError::Range { .. } => "domain.range",
            DomainError::OffLattice { .. } => "domain.off-lattice",
        }
    }
}

/// The gravity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Worth knowing; legal.
    Info,
    /// Repaired on the way to a mesh, or without influence on it.
    Warning,
    /// The domain cannot be meshed as it is.
    Error,
}

impl Severity {
    /// Its name, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Severity::Info => "info",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// The kinds of findings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum DefectKind {
    /// Two vertices have the same coordinates.
    DuplicateVertex,
    /// No facet and no segment names the vertex.
    UnusedVertex,
    /// A polygon has no area, or crosses itself, or a segment has no length.
    Degenerate,
    /// The corners of a facet do not lie in one plane.
    NonPlanar,
    /// Two facets of one plane overlap, or a facet is there twice.
    Overlap,
    /// Two facets, or a segment and a facet, or two segments cross; or a segment or a facet's edge
    /// lies in a facet that does not draw it (as a polygon of two corners).
    Intersection,
    /// A vertex lies inside an edge or a facet that does not name it.
    TJunction,
    /// An edge of one facet only: the surface has a gap there.
    Leak,
    /// A facet edge inside the domain that no other facet has: a sheet that ends there.
    Dangling,
    /// A body of an oriented surface that has facets that point inwards.
    Orientation,
    /// A body of an oriented surface inside another that is turned likewise: a region of its own.
    Nested,
    /// More than two facets meet at an edge.
    NonManifold,
    /// A hole or region point lies on a facet.
    SeedOnFacet,
    /// A hole or region point, or that of a facet's hole, lies outside.
    SeedOutside,
    /// A facet that ends in the exterior: it is no part of the domain.
    EndsOutside,
    /// Another facet with nothing but exterior around it.
    Exterior,
    /// A connected part of the surface is so small or thin, against the domain, that what lies
    /// around it could not be found: the domain is not understood.
    Unresolved,
}

impl DefectKind {
    /// Every kind.
    pub const ALL: [DefectKind; 17] = [
        DefectKind::DuplicateVertex,
        DefectKind::UnusedVertex,
        DefectKind::Degenerate,
        DefectKind::NonPlanar,
        DefectKind::Overlap,
        DefectKind::Intersection,
        DefectKind::TJunction,
        DefectKind::Leak,
        DefectKind::Dangling,
        DefectKind::Orientation,
        DefectKind::Nested,
        DefectKind::NonManifold,
        DefectKind::SeedOnFacet,
        DefectKind::SeedOutside,
        DefectKind::EndsOutside,
        DefectKind::Exterior,
        DefectKind::Unresolved,
    ];

    /// A short code that stays the same between versions, for programs to match on.
    #[must_use]
    pub fn code(self) -> &'static str {
        match self {
            DefectKind::DuplicateVertex => "domain.duplicate-vertex",
            DefectKind::UnusedVertex => "domain.unused-vertex",
            DefectKind::Degenerate => "domain.degenerate",
            DefectKind::NonPlanar => "domain.non-planar",
            DefectKind::Overlap => "domain.overlap",
            DefectKind::Intersection => "domain.intersection",
            DefectKind::TJunction => "domain.t-junction",
            DefectKind::Leak => "domain.leak",
            DefectKind::Dangling => "domain.dangling",
            DefectKind::Orientation => "domain.orientation",
            DefectKind::Nested => "domain.nested",
            DefectKind::NonManifold => "domain.non-manifold",
            DefectKind::SeedOnFacet => "domain.seed-on-facet",
            DefectKind::SeedOutside => "domain.seed-outside",
            DefectKind::EndsOutside => "domain.ends-outside",
            DefectKind::Exterior => "domain.exterior",
            DefectKind::Unresolved => "domain.unresolved",
        }
    }

    /// Its gravity.
    #[must_use]
    pub fn severity(self) -> Severity {
        match self {
            DefectKind::NonManifold
            | DefectKind::Dangling
            | DefectKind::Nested
            | DefectKind::Exterior => Severity::Info,
            DefectKind::DuplicateVertex
            | DefectKind::UnusedVertex
            | DefectKind::NonPlanar
            | DefectKind::Orientation
            | DefectKind::EndsOutside => Severity::Warning,
            _ => Severity::Error,
        }
    }

    /// Its meaning, in a few words.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            DefectKind::DuplicateVertex => "vertices with the same coordinates",
            DefectKind::UnusedVertex => "a vertex that nothing names",
            DefectKind::Degenerate => "a polygon without area or that crosses itself",
            DefectKind::NonPlanar => "a facet whose corners are not in one plane",
            DefectKind::Overlap => "facets that overlap in their plane",
            DefectKind::Intersection => "facets or segments that cross",
            DefectKind::TJunction => "a vertex inside an edge or facet that does not name it",
            DefectKind::Leak => "an edge with a facet on one side only",
            DefectKind::Dangling => "an edge inside where a facet ends",
            DefectKind::Orientation => "a body with facets that point inwards",
            DefectKind::Nested => "a body inside another, turned likewise: a region",
            DefectKind::NonManifold => "an edge of more than two facets",
            DefectKind::SeedOnFacet => "a hole or region point on a facet",
            DefectKind::SeedOutside => "a hole or region point outside",
            DefectKind::EndsOutside => "a facet that ends in the exterior",
            DefectKind::Exterior => "a facet with nothing but exterior around it",
            DefectKind::Unresolved => "a part of the surface too small to be placed",
        }
    }
}

/// A finding of the geometric check.
#[derive(Debug, Clone, PartialEq)]
pub struct DomainDefect {
    /// Its kind.
    pub kind: DefectKind,
    /// The elements that it concerns.
    pub elements: Vec<Element>,
    /// Its places: coordinates of vertices, of ends of edges, of seeds.
    pub at: Vec<Point>,
}

impl fmt::Display for DomainDefect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}:", self.kind.code(), self.kind.about())?;
        for (i, element) in self.elements.iter().enumerate() {
            write!(f, "{} {element}", if i == 0 { "" } else { "," })?;
        }
        for (i, [x, y, z]) in self.at.iter().enumerate() {
            write!(f, "{} ({x:?} {y:?} {z:?})", if i == 0 { " at" } else { "," })?;
        }
        Ok(())
    }
}
