//! The C interface: opaque handles, status codes, callbacks, and no panic across the border.
//!
//! Every function catches panics and turns them into [`Status::LTBW_INTERNAL`]. Arrays that a
//! function returns belong to the mesh and live as long as it does. The reason of the last failure
//! of a thread is kept for it: `ltbw_last_error`.
//!
//! # Safety
//! Pointers are null where the text allows it, or point to as many values as the lengths beside
//! them say; a mesh comes from this library and is freed once. Callers promise no more.
#![allow(non_camel_case_types, reason = "the constants have C names")]

mod arrays;
mod error;
mod handle;
mod input;
mod mesh;
mod predicates;
mod run;
mod sized;

pub use arrays::*;
pub use error::*;
pub use handle::*;
pub use input::*;
pub use mesh::*;
pub use predicates::*;
pub use run::*;
