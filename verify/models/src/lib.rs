//! Model checks of ltbw's concurrent code, over the real code: `cargo xtask model-check`.
//!
//! * **States** (stateright and a liveness pass of our own): every order in which messages arrive
//!   and workers act, in small closed [`world`]s. Each transition is one call of the real
//!   `Worker::step`; only the mesh is abstract, a convex hull in the plane ([`hull`]).
//! * **Threads** (loom, shuttle): the real mailbox, alone and under the real loop of a worker,
//!   which runs the same step. Only with `--cfg loom` or `--cfg shuttle`.
//! * **Known-bad variants** ([`variants`]): every known defect, as rules of its own that a checker
//!   must catch. A checker that has never found anything shows nothing.
//!
//! Every model asserts *witnesses*, what must have been reached, and a least size.
#![forbid(unsafe_code)]

#[cfg(not(any(loom, shuttle)))]
pub mod graph;
pub mod hull;
#[cfg(not(any(loom, shuttle)))]
mod properties;
pub mod random;
pub mod report;
pub mod rounds;
#[cfg(not(any(loom, shuttle)))]
pub mod runs;
#[cfg(not(any(loom, shuttle)))]
pub mod system;
#[cfg(any(loom, shuttle))]
pub mod threads;
pub mod told;
pub mod variants;
pub mod witness;
pub mod world;
pub mod worlds;
