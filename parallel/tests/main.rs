//! The tests of the crate: one program, a module a subject.

mod builder;
mod closure;
mod examples;
mod foreign;
mod home;
mod limit;
mod ownership;
mod refining_angles;
mod refining_circles;
mod refining_domains;
mod refining_freely;
mod refining_given;
mod refining_patches;
mod refining_plates;
mod refining_rounds;
mod refining_slivers;
mod simulate_mesh;
mod threads;
mod vertices;
