//! The tests of the crate: one program, a module a subject.

mod angles;
mod common;
mod defects;
mod domains;
mod exterior;
mod growth;
mod meshes;
mod parted;
mod patches;
mod words;
