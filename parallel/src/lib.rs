//! `ltbw`: a parallel 3D Delaunay mesh generation kernel. Users add this crate alone.
//!
//! Its [`Builder`] makes meshes of points, by the exact sequential kernel, [`ltbw_core`], or on
//! several threads by the parallel one (Latency-Tolerant Bowyer-Watson), on the same cavity code.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use ltbw::{Builder, Inserted, PointSet};
//!
//! let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
//! let mut mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
//! assert_eq!(mesh.insert([0.5, 0.5, 0.5])?, Inserted::Vertex(8));
//! assert_eq!((mesh.num_vertices(), mesh.num_tets(), mesh.num_hull_faces()), (9, 12, 12));
//! for [a, b, c, d] in mesh.tets() {
//!     println!("{a} {b} {c} {d}");
//! }
//! println!("{}", mesh.hash()?);
//! # Ok(())
//! # }
//! ```
//!
//! A point set has one mesh, whatever the order of its points: [`Mesh::hash`] is a function of
//! the coordinates alone. The crate `ltbw-verify` checks meshes, by code of its own.
//!
//! | to | take |
//! |---|---|
//! | mesh points, on any number of threads | [`Builder`]; it gives a [`Built`] with a [`Mesh`] |
//! | mesh a [`Domain`] or an [`io::DomainFile`] to bounds | [`Refiner::mesh`]: [`Refined`] |
//! | walk, locate, ask for neighbours and Voronoi cells | [`Mesh::queries`], [`query`] |
//! | read and write files | [`io`] |
//! | see and stop long work | [`Observer`], [`Progress`], [`CancelToken`], [`Budget`] |
//! | measure meshes and threads | [`quality`], [`metrics`] |
//! | set up the parallel kernel, or simulate one | [`threads`], [`balance`], [`simulate`] |
//!
//! Features:
//!
//! | feature | what it brings |
//! |---|---|
//! | `io`, on by default | [`io`], and `domains`: 66 crates in `cargo tree`, 30 without |
//! | `domains` | [`domain`], [`quality`], [`refine`] |
//! | `ndarray` | [`PointSet`] of an (n, 3) view, arrays of meshes and of [`quality`] |
//! | `nalgebra` | [`PointSet`] from a slice of `Point3<f64>`, a matrix of [`quality`] |
//! | `serde` | [`Snapshot`], [`PointSet`], [`TetMesh`] and figures to be stored and read |
//! | `wire` | letters of workers in processes of their own, for the program `ltbw-mpi` |
//!
//! `use ltbw::prelude::*` brings what most programs need. The examples by task: `points`, `walk`,
//! `domain`, `watch` and `threads`, in the folder `examples` of this crate.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#![cfg_attr(not(feature = "domains"), expect(dead_code, reason = "refinement on workers uses it"))]

pub mod balance;
mod builder;
#[doc(hidden)]
pub mod check;
#[cfg(feature = "wire")]
#[doc(hidden)]
pub mod distributed;
mod failure;
#[doc(hidden)]
pub mod mailbox;
#[doc(hidden)]
pub mod mesh;
pub mod metrics;
mod payload;
pub mod prelude;
#[doc(hidden)]
pub mod protocol;
#[cfg(feature = "domains")]
#[doc(hidden)]
pub mod refining;
pub mod simulate;
mod sync;
#[cfg(feature = "wire")]
#[doc(hidden)]
pub mod team;
pub mod threads;
#[doc(hidden)]
pub mod transport;
#[cfg(feature = "wire")]
#[doc(hidden)]
pub mod wire;

pub use builder::{Builder, Built};
pub use failure::WorkerError;

// All that the kernel has is here, and what programs need is shown.
#[doc(hidden)]
pub use ltbw_core::*;
#[doc(inline)]
pub use ltbw_core::{
    Budget, BuildError, CancelToken, InsertError, Inserted, Mesh, MeshHash, Observer, Order,
    Outcome, Phase, Point, PointError, PointSet, Progress, Snapshot, Stats, TetMesh, Vertex, query,
    snapshot,
};
#[cfg(feature = "domains")]
#[doc(no_inline)]
pub use ltbw_domain::{self as domain, quality};
#[cfg(feature = "domains")]
#[doc(inline)]
pub use ltbw_domain::{Domain, DomainDefect, DomainError, Facet, Lattice, Region, Snapped};
#[cfg(any(feature = "nalgebra", feature = "ndarray"))]
pub use ltbw_exact::interop;
pub use ltbw_exact::{points, predicates};
#[cfg(feature = "io")]
#[doc(no_inline)]
pub use ltbw_formats as io;
#[cfg(feature = "domains")]
#[doc(no_inline)]
pub use ltbw_refine as refine;
#[cfg(feature = "domains")]
#[doc(inline)]
pub use ltbw_refine::{Refined, Refiner};

/// Examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
