//! Conforming Delaunay refinement of domains.
//!
//! The boundary of a domain is *marks on faces and edges* of a plain Delaunay mesh; the mesh is
//! refined by three rules until every subsegment and subface of the boundary is in it and every
//! tetrahedron of the domain meets its bounds. All points lie on the domain's lattice, those of
//! segments and facets exactly on their carrier; every decision is exact.
//!
//! The rules and their order: `docs/refinement.md`; their termination: `docs/why-it-ends.md`.
//!
//! | module | what it holds |
//! |---|---|
//! | `plc` | the complex: corners, segments, facets as maximal coplanar groups |
//! | `flat`, `patch` | polygons coplanar within a tolerance, and their projection |
//! | `tiles`, `layer`, `surface` | where such a patch is in the mesh; how a point changes it |
//! | `carrier` | points of segments and facets, with whole parameters |
//! | `measure` | closed balls and bounds: filters and exact integers |
//! | `marks` | marks of faces and edges, regions: one word per tetrahedron |
//! | `run`, `item` | the driver; what there is to do before the first round |
//! | `encroachment` | pending boundary items by place |
//! | `state`, `facet`, `plan` | mesh, marks and tables; how a point changes a facet |
//! | `angles`, `near` | where the theory gives no guarantee: small angles, narrow gaps |
//! | `sharp` | tetrahedra at angles too small for their bound of shape |
//! | `dust` | flat tetrahedra of a patch go to its outer side |
//! | `recover`, `mend` | from the mesh of the corners to one that has the boundary |
//! | `seed` | the first points where empty balls are large |
//! | `sliver`, `thin` | flat tetrahedra that the bounds allow |
//! | `split` | the three rules |
//! | `bounded`, `look`, `survey` | a closure, whoever has it; the boundary in its cavity |
//! | `verdict`, `watch` | what follows for its point, alone and beside others |
//! | `fill` | the point inserted, and marks and tables brought up to date |
//! | `defer`, `record` | what comes first, and what came of earlier proposals |
//! | `joint`, `journal` | several items split as one step, or none |
//! | `walk` | the way to a proposed point |
//! | `key` | orders by coordinates alone |
//! | `rounds` | refinement in rounds: one mesh whatever the order of insertion |
//! | `again`, `relief` | what was refused: asked again; a point with which fewer are over |
//! | `region` | inside, outside, regions |
//! | `choice`, `aims`, `by_values`, `surveyed` | the choice of a round by values |
//! | `complex` | boundary, bounds and points as values, for engines on many processors |
//! | `background` | sizing by a background mesh, or at input vertices |
//! | `excuse`, `share` | what is over its bounds at the end, and why; whether that is much |
//! | `number` | numbers of vertices, and orders, that are functions of the mesh alone |
//! | `output` | the mesh and its boundary as plain arrays |

#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod again;
mod aims;
mod angles;
mod arc;
mod background;
mod bounded;
mod bounds;
mod by_values;
mod carrier;
mod choice;
mod complex;
mod defer;
mod display;
mod dust;
mod encroachment;
mod excuse;
mod facet;
mod fill;
mod flat;
mod heed;
mod item;
mod joint;
mod journal;
mod key;
mod layer;
mod limit;
mod look;
mod marks;
mod measure;
mod mend;
mod names;
mod near;
mod number;
mod outcome;
mod output;
mod parts;
mod patch;
#[cfg(test)]
mod patch_tests;
mod plan;
mod plc;
mod record;
mod recover;
mod region;
mod relief;
mod ring;
mod rounds;
mod rules;
mod run;
mod seed;
mod share;
mod sharp;
mod sliver;
mod split;
mod state;
mod surface;
mod survey;
mod surveyed;
mod sync;
mod table;
#[cfg(test)]
mod tests;
mod thin;
mod tiles;
mod turned;
mod verdict;
mod walk;
mod watch;
mod whole;

use ltbw_core::build::BuildError;
use ltbw_domain::Element;
use ltbw_exact::Point;
use ltbw_exact::points::PointError;

pub use background::{Background, BackgroundError};
pub use bounds::SizeField;
#[doc(hidden)]
pub use by_values::Survey;
pub use carrier::Carrier;
#[doc(hidden)]
pub use choice::{
    BoundaryItem, Closure, Corner, ItemPlace, NOWHERE, Rank, RankLead, Rival, Ruling,
};
pub use complex::{Complex, ComplexError, Start};
pub use excuse::Excused;
pub use item::{Item, Queues, Work};
pub use outcome::{Excuse, Reason, RefineOutcome, RefineStats, Spot};
pub use output::Refined;
pub use region::RegionInfo;
#[doc(hidden)]
pub use rounds::{Bad, Ranked, are_joined, sift, witness};
pub use rounds::{InsertOrder, RoundTimes};
#[doc(hidden)]
pub use rules::aim::Aim;
#[doc(hidden)]
pub use rules::way::{Across, Heading, Stop, View, Way, middle, walk};
pub use run::Refiner;
#[doc(hidden)]
pub use run::{Asked, Delegated, Handed, Parted};
pub use share::{ExcusedShare, Verdict};
#[doc(hidden)]
pub use surveyed::{Collected, Surveyed};
#[doc(hidden)]
pub use thin::{Thin, ThinTets};
#[doc(hidden)]
pub use watch::Watch;
pub use whole::MeshError;
// The tolerance of a refinement, beside its bounds.
pub use ltbw_domain::{Given, largest_tolerance, usual_tolerance};

/// Why there is no mesh of a domain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RefineError {
    /// A vertex is not on the lattice: the domain was not snapped.
    #[error("vertex {vertex} at {at:?} is not on the lattice")]
    OffLattice {
        /// The vertex.
        vertex: u32,
        /// Its coordinates.
        at: Point,
    },
    /// Two vertices lie at the same place.
    #[error("vertices {first} and {second} are at the same place")]
    DuplicateVertex {
        /// One of them.
        first: u32,
        /// The other.
        second: u32,
    },
    /// A facet that is not planar cannot be divided into triangles.
    #[error("{element} is not planar and cannot be divided")]
    NotPlanar {
        /// The facet.
        element: Element,
    },
    /// A facet has no area.
    #[error("{element} has no area")]
    Degenerate {
        /// The facet.
        element: Element,
    },
    /// The seed of a hole or region is on the boundary.
    #[error("the point {at:?} of {element} is on the boundary")]
    Seed {
        /// The hole or region.
        element: Element,
        /// The point.
        at: Point,
    },
    /// The facets enclose nothing.
    #[error("the facets enclose no region: they are open, or all is hole")]
    NoInterior,
    /// A bound cannot be met by any refinement.
    #[error("the bound {name} = {value:e} cannot be met: {limit}")]
    Bound {
        /// Which bound.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The limit that it breaks.
        limit: String,
    },
    /// The sizing function gave something that is no length.
    #[error("the size at {at:?} is {value:?}: an edge length is positive, and so is its cube")]
    Size {
        /// The place, in the coordinates of the mesh.
        at: Point,
        /// The size.
        value: f64,
    },
    /// The sizing function gave different sizes for one place.
    #[error("the size at {at:?} is not what it was before: it has to depend on the place alone")]
    ImpureSize {
        /// The place, in the coordinates of the mesh.
        at: Point,
    },
    /// The vertices are not a point set.
    #[error(transparent)]
    Points(#[from] PointError),
    /// The vertices have no mesh.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A promise of the engine was broken: a defect of this library.
    #[error("broken invariant of refinement: {what}")]
    Invariant {
        /// The promise.
        what: &'static str,
    },
    /// The work was cancelled before there was a mesh of the domain.
    #[error("cancelled before the boundary was recovered")]
    Cancelled,
}

/// Examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
