//! The tests of the program, run as its users run it: one program, a module a subject.
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod angles;
mod certificate;
mod common;
mod domain;
mod faults;
mod fill;
mod lenience;
mod losses;
mod mesh;
mod newcomer;
mod one_default;
mod options;
mod page;
mod parallel;
mod parts;
mod readback;
mod readme;
mod refine;
mod rejected;
mod repair;
#[path = "../../tests/src/require.rs"]
#[expect(unreachable_pub, reason = "it is public in the library that owns it")]
mod require;
mod schema;
mod schemas;
mod signals;
mod simplify;
mod simulated;
mod sizes;
mod streams;
mod vectors;
mod without;
mod works;
