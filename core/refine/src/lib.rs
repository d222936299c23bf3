//! Conforming Delaunay refinement of domains.
//!
//! The boundary of a domain is *marks on faces and edges* of a plain Delaunay mesh; the mesh is
//! refined by three rules until every subsegment and subface of the boundary is in it and every
//! tetrahedron of the domain meets its bounds. All points lie on the domain's lattice, those of
//! segments and facets exactly on their carrier; every decision is exact.
//!
//! The rules and their order: `docs/refinement.md`; their termination: `docs/why-it-ends.md`.
//!
//! | folder | what it holds |
//! |---|---|
//! | `complex` | the boundary of a domain, before there is a mesh |
//! | `mesh` | the boundary in a mesh: marks, tables, surveys, bounds, orders |
//! | `patches` | surfaces that are flat within a tolerance, in a mesh |
//! | `rules` | the rules: point, way, closure, verdict, what keeps points apart |
//! | `queue`, `start` | one item after the other: the boundary is recovered, the first points |
//! | `rounds` | refinement in rounds: one mesh whatever the order of insertion |
//! | `late` | what was refused: asked again, relieved; flat tetrahedra |
//! | `run` | the driver |
//! | `output` | the mesh as plain arrays; what is over its bounds, and why |
//!
//! At the root: the insertion of a point (`fill`), reasons (`outcome`), tables, arrays for threads
//! (`sync`), flat tetrahedra as they come (`thin`), a mesh written whole (`whole`), a mesh gone on
//! with (`resume`), edge lengths by place (`sizes`).

#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod complex;
mod fill;
mod heed;
mod late;
mod mesh;
mod outcome;
mod output;
#[cfg(test)]
mod patch_tests;
mod patches;
mod queue;
mod resume;
mod rounds;
mod rules;
mod run;
mod sizes;
mod start;
mod sync;
mod table;
#[cfg(test)]
mod tests;
mod thin;
mod whole;

use ltbw_core::build::BuildError;
use ltbw_domain::Element;
use ltbw_exact::Point;
use ltbw_exact::points::PointError;

pub use complex::background::{Background, BackgroundError};
pub use complex::carrier::Carrier;
pub use complex::marked::Marked;
#[doc(hidden)]
pub use mesh::bounds::Solid;
pub use mesh::bounds::{MOST_SWEEPS, SizeField};
pub use mesh::item::Item;
#[doc(hidden)]
pub use mesh::limit::Limit;
pub use mesh::region::RegionInfo;
pub use outcome::{Excuse, Reason, RefineOutcome, RefineStats, Sliver, Spot};
pub use output::excuse::Excused;
#[doc(hidden)]
pub use output::part::{Amiss, GivenNumbers, ThinTet, from_smallest, in_order};
pub use output::refined::Refined;
#[doc(hidden)]
pub use output::refined::attributes_of;
pub use output::share::{ExcusedShare, Verdict};
pub use resume::ResumeError;
#[doc(hidden)]
pub use rounds::{Bad, Keys, Ranked, are_joined};
pub use rounds::{InsertOrder, RoundTimes};
#[doc(hidden)]
pub use rules::aim::Aim;
#[doc(hidden)]
pub use rules::block::{Block, Blocks, KeptBlock};
#[doc(hidden)]
pub use rules::by_values::{OnBoundary, SliverRuling, Survey};
#[doc(hidden)]
pub use rules::choice::{
    BoundaryItem, Closure, Corner, Filled, ItemPlace, NOWHERE, Rank, RankLead, Relabelled, Rival,
    Ruling, TetPlace,
};
pub use rules::complex::{Complex, ComplexError, Start};
#[doc(hidden)]
pub use rules::group::Group;
#[doc(hidden)]
pub use rules::past::{Past, Refusals};
#[doc(hidden)]
pub use rules::record::Refusal;
#[doc(hidden)]
pub use rules::sliver::{Tries, Try};
#[doc(hidden)]
pub use rules::strategy::{Order, Strategy};
#[doc(hidden)]
pub use rules::surveyed::{Collected, Surveyed};
#[doc(hidden)]
pub use rules::turns::{Contender, Held, next_wave};
#[doc(hidden)]
pub use rules::watch::Watch;
#[doc(hidden)]
pub use rules::way::{Across, Heading, Stop, View, Walked, Way, middle, walk};
pub use run::Refiner;
#[doc(hidden)]
pub use run::{
    Asked, Delegated, Handed, Labelled, Lent, LentTet, Parted, PartedPoint, Parting, Remaining,
    Waits, circles_among,
};
pub use sizes::{Sizes, SizesError};
#[doc(hidden)]
pub use thin::{Thin, ThinTets};
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
