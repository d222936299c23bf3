//! The tests of the crate: one program, a module a subject.

mod cancel;
mod mailbox;
mod many;
mod random;
mod rounds;
mod states;
mod variants;
mod workers;
