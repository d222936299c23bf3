//! The common half of the bindings to other languages.
//!
//! Requests are plain data, results plain arrays; failures have a class, a code and the elements at
//! fault; by the reins the calling side watches and ends the work. No other language is known here.
//!
//! | module | what it holds |
//! |---|---|
//! | `points` | meshes of point sets |
//! | `domain`, `wishes` | meshes of domains: source, demands, check |
//! | `body` | the mesh itself, and which of its tetrahedra the caller sees |
//! | `result` | [`Meshed`]: a mesh and its arrays |
//! | `locate` | tetrahedra that hold given points |
//! | `certificate` | certificates of anybody's meshes |
//! | `failure` | [`Failure`]: why there is no result |
//! | `work`, `sync` | [`Reins`], panics as failures, threads |
#![forbid(unsafe_code)]

mod body;
mod certificate;
mod domain;
mod failure;
mod locate;
mod points;
mod result;
mod sync;
mod wishes;
mod work;

pub use body::NOWHERE;
pub use certificate::{CheckedDomain, CheckedMesh, Order, check};
pub use domain::{Ready, Source};
pub use failure::{Class, Defect, Failure};
pub use points::delaunay;
pub use result::{ExcusedTet, Meshed, Outcome, save};
pub use sync::{Figures, Progress};
pub use wishes::{Near, SizeAt, Wishes};
pub use work::{PATIENCE, Reins, in_own_pool, in_pool, unpanicked};

pub use ltbw::domain::{Frame, Holes};

/// An edge length as a function of the place, in the coordinates of the prepared domain.
pub type Field<'a> = dyn Fn(ltbw::Point) -> f64 + Sync + 'a;
