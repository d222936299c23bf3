//! The tests of the crate: one program, a module a subject.

mod regions;
