//! Processes that mesh together: each is given the same command line, and reads the same input; the
//! first one checks, writes and reports.
//!
//! Refusals are agreed upon before the work: the lowest process that refuses is
//! told of, once, and all end with its exit code. Afterwards a failure of one is the end
//! of all ([`Ended::Alone`]).

mod checkpoint;
mod options;
mod team;

pub use checkpoint::Checkpoint;
pub use team::{Ended, Judge, run};
