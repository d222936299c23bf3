//! Exact sequential 3D Delaunay kernel of `ltbw`.
//!
//! Data flows one way: *points → order → kernel → mesh → check → file*.
//!
//! | module | what it holds |
//! |---|---|
//! | [`points`] | [`PointSet`]: validated points, the exactness window |
//! | [`predicates`] | `orient3d`, `insphere`, the planar ones: filter, then exact |
//! | [`hash`] | the canonical mesh hash `ltbw.mesh/1` |
//! | [`tetmesh`] | [`TetMesh`]: a plain mesh as files carry it |
//! | [`io`] | readers and writers of point and mesh files |
//! | [`generate`] | test point sets, the same on every machine |

pub mod generate;
pub mod hash;
pub mod io;
pub mod points;
pub mod predicates;
pub mod tetmesh;

pub use hash::{HashError, MeshHash, canonical_hash};
pub use points::{PointError, PointSet};
pub use predicates::Sign;
pub use tetmesh::TetMesh;

/// A point: three finite coordinates.
pub type Point = [f64; 3];
