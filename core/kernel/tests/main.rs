//! The tests of the crate: one program, a module a subject.

mod accessors;
mod canonical_hash;
mod counts;
mod kernel;
mod query;
mod remove;
mod snapshot;
mod stored_hash;
mod submesh;
mod voronoi;
