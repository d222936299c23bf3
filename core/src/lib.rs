//! Exact sequential 3D Delaunay kernel of `ltbw`.
//!
//! Data flows one way: *points → order → kernel → mesh → check → file*. Three laws keep it
//! readable: topology code never sees a coordinate; geometry code never sees a lock; protocol
//! code never sees a float.
//!
//! | module | what it holds |
//! |---|---|
//! | [`points`] | [`PointSet`]: validated points, the exactness window |
//! | [`predicates`] | `orient3d`, `insphere`, the planar ones: filter, exact, perturbation |
//! | [`order`] | insertion order: BRIO rounds along a Hilbert curve |
//! | [`topology`] | tetrahedra and their neighbours: 32 bytes each |
//! | [`cavity`] | the cavity of a point: expand, admit, fill, set back |
//! | `sphere`, `geometry`, `locate` | cached spheres, the conflict test, the walk |
//! | [`mesh`] | [`Mesh`]: insertion and iteration |
//! | [`build`] | [`Builder`]: from a [`PointSet`] to a [`Mesh`] |
//! | [`part`] | [`part::Part`]: the part of a mesh that one worker of the parallel kernel owns |
//! | [`query`] | questions to a [`Mesh`], from many threads: locate, nearest, Voronoi cells |
//! | [`quality`] | histograms and extremes of angles, ratios, volumes, edges |
//! | [`refine`] | conforming Delaunay refinement of domains |
//! | [`hash`] | the canonical mesh hash `ltbw.mesh/1` |
//! | [`snapshot`] | [`Snapshot`]: a mesh to be stored, restored through validation |
//! | `interop` | conversions from and to `nalgebra` (feature `nalgebra`) |
//! | [`tetmesh`] | [`TetMesh`]: a plain mesh as files carry it |
//! | [`invariants`] | one slow check per invariant of `docs/invariants.md` |
//! | [`domain`] | [`Domain`]: a polyhedral domain, its lattice, its exact check |
//! | [`io`] | readers and writers of point and mesh files |
//! | [`generate`] | test point sets, the same on every machine |
//!
//! `raw` is the only module with unsafe code; `sync` the only one with atomics.
#![deny(unsafe_code)]

pub mod build;
pub mod cavity;
pub mod domain;
pub mod generate;
mod geometry;
pub mod hash;
#[cfg(feature = "nalgebra")]
pub mod interop;
pub mod invariants;
pub mod io;
mod locate;
pub mod mesh;
pub mod order;
pub mod part;
pub mod points;
pub mod predicates;
pub mod quality;
pub mod query;
mod raw;
pub mod refine;
#[cfg(feature = "serde")]
mod serialise;
pub mod snapshot;
mod special;
mod sphere;
mod sync;
pub mod tetmesh;
pub mod topology;

pub use build::{Budget, BuildError, Builder, Built, Observer, Order, Outcome, Stats};
pub use cavity::{Admission, Open, Role};
pub use domain::{Domain, DomainDefect, DomainError, Facet, Lattice, Region, Snapped};
pub use geometry::PredicateStats;
pub use hash::{HashError, MeshHash, canonical_hash};
pub use mesh::{InsertError, Inserted, Mesh, Vertex};
pub use points::{Mode, PointError, PointSet};
pub use predicates::Sign;
pub use snapshot::{Snapshot, SnapshotError};
pub use sync::CancelToken;
pub use tetmesh::{BoundaryFace, Extras, TetMesh};

/// A point: three finite coordinates.
pub type Point = [f64; 3];
