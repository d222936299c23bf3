//! The tests of the crate: one program, a module a subject.
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod carried;
mod domain_io;
mod extras;
mod groups;
mod io_refusals;
mod liberal;
mod mesh_io;
mod msh;
mod parted;
mod ply;
mod slices;
mod strategies;
mod texts;
mod vtk;
mod vtu;
