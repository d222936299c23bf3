//! The protocol on simulated processors: 2 to 1024 of them, any latency, in virtual time.
//!
//! [`simulate`] runs the workers that threads run, one [`Worker::step`] after the other, in the
//! order of a heap of (virtual time, sequence number). A processor is serial: a step takes as long
//! as the [`CostModel`] says for the walk steps, conflict tests, tetrahedra and messages of that
//! step, and messages that arrive meanwhile queue up. It looks for messages before it takes up
//! local work. Messages of one processor to another arrive in the order in which they were sent,
//! whatever their latency; those of different pairs overtake each other.
//!
//! Nothing depends on the machine it runs on: the same workers, options and seed give the same
//! run, step for step. Random times need neither logarithms nor powers. A run ends with a result
//! or a typed error: events are counted, and time without progress is limited.
//!
//! [`Worker::step`]: crate::protocol::Worker::step

mod cost;
mod engine;
mod error;
mod event;
mod mesh;
mod network;
mod options;
mod processor;
mod redeal;
mod whole;

pub use crate::payload::Payload;
pub use cost::CostModel;
pub use engine::{Simulation, simulate};
pub use error::SimulationError;
pub use mesh::{MeshError, Meshed, simulate_as, simulate_mesh};
pub use network::{Bursts, Distribution, Network};
pub use options::{Options, RandomMigrations};
pub use whole::{Around, Whole};
