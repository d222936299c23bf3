//! Polyhedral domains of `ltbw`: piecewise linear complexes (PLCs), their repair and exact check.
//! `ltbw-refine` makes meshes of them.
//!
//! A [`Domain`] is plain data in TetGen's meaning: vertices; facets, each a set of polygons in one
//! plane with holes in them; free-standing segments; seeds of holes and of regions. It says what a
//! file said, right or wrong. The way to a mesh is
//!
//! ```text
//! read -> structure (indices, finite numbers) -> snap to the lattice -> check -> refine
//! ```
//!
//! | module | what it holds |
//! |---|---|
//! | `needles` | triangles with small angles: [`Needles`] |
//! | [`parts`] | facets that go on smoothly into each other: [`Parts`] |
//! | [`plc`] | [`Domain`], [`Facet`], [`Region`], and the check of their structure |
//! | [`lattice`] | [`Lattice`]: the grid on which input vertices live, and snapping to it |
//! | [`check`] | the exact check: [`DomainReport`], cells, volumes |
//! | [`repair`] | what is welded, dropped and closed before the check: [`Repairs`] |
//! | [`exterior`] | what is no part of a domain is left out |
//! | `given` | a domain as it is given, and its usual tolerance: [`Given`] |
//! | [`points`] | points that are to be vertices: [`Placed`] |
//! | [`skin`] | the domain that a mesh is of: [`Skin`] |
//! | [`holes`] | what users say of voids: [`Holes`] |
//! | [`prepare`] | all steps to a domain that can be meshed: [`Prepared`] |
//! | [`simplify`] | triangles of a surface are collapsed within a tolerance: [`Simplified`] |
//! | [`triangulate`] | triangles of a facet, exactly |
//! | [`defect`] | [`DomainError`], [`DomainDefect`]: what is wrong, with ids and coordinates |
//! | [`quality`] | histograms and extremes of angles, ratios, volumes, edges |
//! | [`thickness`] | the thickness of points that are nearly in one plane: [`Thickness`] |
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

pub mod check;
pub mod defect;
mod display;
pub mod exterior;
mod given;
pub mod holes;
pub mod lattice;
mod needles;
pub mod parts;
pub mod plc;
pub mod points;
pub mod prepare;
pub mod quality;
mod renumber;
pub mod repair;
pub mod simplify;
pub mod skin;
#[doc(hidden)]
pub mod straight;
pub mod thickness;
pub mod triangulate;
#[doc(hidden)]
pub mod vector;

pub use check::{Cell, CheckOptions, DomainReport, Exterior, Trouble, TroubleKind, Volume};
pub use defect::{DefectKind, DomainDefect, DomainError, Element, Severity};
#[doc(hidden)]
pub use display::Of;
pub use given::{Given, largest_tolerance, usual_tolerance};
pub use holes::Holes;
pub use lattice::{Lattice, Move, Snapped};
pub use needles::Needles;
pub use parts::{FEATURE_ANGLE, LARGEST_FEATURE_ANGLE, Part, Parts};
pub use plc::{Domain, Facet, Region};
pub use points::Placed;
pub use prepare::{Frame, PrepareError, PrepareOptions, Prepared, Welded};
pub use repair::{LONGEST_LOOP, Repairs};
pub use simplify::{Simplified, largest_simplification};
pub use skin::{PreparedSkin, Skin, SkinError};
pub use thickness::Thickness;
pub use triangulate::{Problem, Triangulated};

/// Examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
