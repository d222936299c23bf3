//! The tests of the crate: one program, a module a subject.

mod committed;
mod hex;
mod questions;
mod simulate;
