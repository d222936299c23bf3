//! The blocks that a worker keeps, and its tetrahedra that they may bar.

use super::ranked::Own;
use ltbw_refine::{Blocks, ItemPlace};
use rustc_hash::FxHashSet;

/// The knowledge that a worker has of blocks.
#[derive(Debug, Default)]
pub(super) struct Barriers {
    /// The blocks that all keep, and the ones found in this round.
    pub(super) all: Blocks<()>,
    /// The foremost tetrahedra here that are not probed, since others of their groups are.
    pub(super) followers: Vec<Own>,
    /// Does the second part of the choice go on?
    pub(super) is_second: bool,
    /// The blocks beside which points of this worker take tetrahedra away in this round.
    pub(super) touched: FxHashSet<ItemPlace>,
}
