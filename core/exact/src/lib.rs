//! Exact arithmetic of `ltbw`: validated points, predicates that are never wrong, the symbolic
//! perturbation that makes the Delaunay mesh one function of its points.
//!
//! | module | what it holds |
//! |---|---|
//! | [`points`] | [`PointSet`]: validated points, the exactness window |
//! | [`predicates`] | `orient3d`, `insphere`, the planar ones: filter, exact, perturbation |
//! | `interop` | conversions from and to `nalgebra` and `ndarray` (features of these names) |
//!
//! This is the ground floor: it knows no mesh. `docs/numerics.md` argues why nothing depends on a
//! rounded value; `verify/proofs` proves the constants.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

#[cfg(any(feature = "nalgebra", feature = "ndarray"))]
pub mod interop;
pub mod points;
pub mod predicates;
#[cfg(feature = "serde")]
mod serialise;

pub use points::{Mode, PointError, PointSet};
pub use predicates::Sign;

/// A point: three finite coordinates.
pub type Point = [f64; 3];

/// Examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
