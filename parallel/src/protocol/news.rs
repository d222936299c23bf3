//! News: all that sources tell each other.
//!
//! The points of a run may come in rounds, chosen by all workers together. Their sources do that by
//! *news*, which the worker only carries. To know that a round is over they ask where their workers
//! stand. Sources of given points tell nothing: [`NoNews`].

/// The news of sources that tell none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum NoNews {}

/// Where a worker stands with the operations of a round. The messages are counted only for sources
/// that ask ([`Source::counts`](super::Source::counts)): counts without an end would leave no model
/// finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Standing {
    /// No operation is at home here.
    pub is_passive: bool,
    /// Messages about operations sent so far.
    pub sent: u64,
    /// Messages about operations taken so far.
    pub received: u64,
}
