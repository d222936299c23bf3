//! The tests of the crate: one program, a module a subject.
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod common;
mod domain_check;
mod domain_exterior;
mod domain_lattice;
mod domain_models;
mod domain_repair;
mod domain_segments;
mod domain_simplify;
