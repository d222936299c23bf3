//! The tests of the crate: one program, a module a subject.

mod angles;
mod given_points;
mod regions;
mod resume;
mod smoothing;
mod usual_edge;
