//! Exact sequential 3D Delaunay kernel of `ltbw`, on the predicates of [`ltbw_exact`].
//!
//! Data flows one way: *points → order → kernel → mesh → check → file*. Three laws keep it
//! readable: topology code never sees a coordinate; geometry code knows tagged slots and one access
//! trait, never who tagged a slot or why; protocol code never sees a float.
//!
//! | module | what it holds |
//! |---|---|
//! | [`order`] | insertion order: BRIO rounds along a Hilbert curve |
//! | [`topology`] | tetrahedra and their neighbours: 32 bytes each |
//! | `cavity` | the cavity of a point: expand, admit, fill, set back |
//! | `edges` | the joiner of faces that have an edge in common |
//! | `sphere`, `geometry`, `locate` | cached spheres, the conflict test, the walk |
//! | `transaction` | the guard of an open cavity: filled, or set back when it is dropped |
//! | [`mesh`] | [`Mesh`]: insertion and iteration |
//! | [`build`] | [`Builder`]: from a [`PointSet`] to a [`Mesh`] |
//! | `submesh` | the tetrahedra of one parallel worker, with locks |
//! | [`query`] | questions to a [`Mesh`], from many threads: locate, nearest, Voronoi cells |
//! | `remove` | a vertex taken out of a mesh |
//! | [`hash`] | the canonical mesh hash `ltbw.mesh/1` |
//! | [`snapshot`] | [`Snapshot`]: a mesh to be stored, restored through validation |
//! | `numbering` | kernel vertices by public number |
//! | [`tetmesh`], `export` | [`TetMesh`]: a plain mesh as files carry it; a mesh as one |
//! | `invariants` | one slow check per invariant of `docs/invariants.md` |
//! | `ids` | the macro of numbers in types of their own |
//! | `random` | the one random generator, the same on every machine |
//!
//! Inner modules that are not shown here are public to the other crates of the workspace alone, and
//! may change with every version.
//!
//! Unsafe code is in `arena` (arrays without bounds checks), `sphere::simd` (vector code) and
//! `mesh::lanes` (threads that insert into one mesh) alone, with one alias each in `topology` and
//! `geometry`; atomics in `sync`.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![deny(unsafe_code)]

mod arena;
pub mod build;
#[doc(hidden)]
pub mod cavity;
#[doc(hidden)]
pub mod edges;
mod export;
mod geometry;
pub mod hash;
mod ids;
#[doc(hidden)]
pub mod invariants;
mod locate;
pub mod mesh;
mod numbering;
pub mod order;
pub mod query;
#[doc(hidden)]
pub mod random;
mod remove;
#[doc(hidden)]
pub mod search;
#[cfg(feature = "serde")]
mod serialise;
pub mod snapshot;
mod sphere;
#[doc(hidden)]
pub mod submesh;
mod sync;
pub mod tetmesh;
pub mod topology;
#[doc(hidden)]
pub mod transaction;
#[doc(hidden)]
pub mod undo;

pub use arena::NoMemory;
#[doc(hidden)]
pub use arena::{ask, expect, prefetch};
pub use build::{
    Budget, BuildError, Builder, Built, Observer, Order, Outcome, Phase, Progress, Stats,
};
#[doc(inline)]
pub use cavity::{Admission, AdmitAll, Role};
pub use geometry::PredicateStats;
pub use hash::{HashError, MeshHash, canonical_hash};
pub use ltbw_exact::{Mode, Point, PointError, PointSet, Sign};
pub use mesh::{Duplicate, InsertError, Inserted, Mesh, Vertex};
#[doc(inline)]
pub use random::Random;
pub use remove::RemoveError;
pub use snapshot::{Snapshot, SnapshotError};
#[doc(hidden)]
pub use sphere::simd::{FourCorners, test_bounds};
pub use sync::CancelToken;
pub use tetmesh::{BoundaryFace, TetMesh};

/// Examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
