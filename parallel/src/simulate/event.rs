//! The events of a simulated run, and their order.

use super::processor::Envelope;
use crate::metrics::Nanos;
use crate::protocol::{Submesh, Ticket, WorkerId};
use std::cmp::Ordering;

/// An event at a point of virtual time.
pub(super) enum What<S: Submesh> {
    /// A message arrives.
    Arrive(WorkerId, Envelope<S>),
    /// A processor has ended its step.
    Free(WorkerId),
    /// A backoff is over.
    Retry(WorkerId, Ticket),
    /// A worker may ask for a block.
    Ask(WorkerId),
    /// A random block moves.
    RandomMigrations,
    /// All workers are told to start no more points.
    Cancel,
}

/// An event in the queue.
pub(super) struct Entry<S: Submesh> {
    pub(super) time: Nanos,
    pub(super) sequence: u64,
    pub(super) what: What<S>,
}

impl<S: Submesh> Entry<S> {
    /// The earliest one is the greatest; `sequence` makes the order total.
    fn key(&self) -> (std::cmp::Reverse<Nanos>, std::cmp::Reverse<u64>) {
        (std::cmp::Reverse(self.time), std::cmp::Reverse(self.sequence))
    }
}

impl<S: Submesh> PartialEq for Entry<S> {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}
impl<S: Submesh> Eq for Entry<S> {}
impl<S: Submesh> PartialOrd for Entry<S> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl<S: Submesh> Ord for Entry<S> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}
