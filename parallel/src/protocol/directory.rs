//! The owners of blocks, as far as one worker knows.

ltbw_core::ids! {
    /// Number of a worker.
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    WorkerId,
    /// Number of a block.
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    BlockId
}

impl WorkerId {
    /// The workers below each in the tree of barriers and termination detection, at most. Taking
    /// one more message is cheaper than waiting for one more: few levels are fast.
    pub const BELOW: u32 = 16;

    /// The worker above in that tree; none of worker 0.
    pub fn parent(self) -> Option<Self> {
        Some(Self::new(self.number().checked_sub(1)? / Self::BELOW))
    }

    /// The workers below in that tree, of `workers` in all.
    pub fn children(self, workers: u32) -> impl Iterator<Item = Self> + use<> {
        let first = self.number().saturating_mul(Self::BELOW).saturating_add(1);
        (first..workers.min(first.saturating_add(Self::BELOW))).map(Self::new)
    }
}

/// One worker's view: right for the blocks it owns, and for others as of the last news. A block
/// that it gave away points to the receiver: messages that still arrive are sent after it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Directory {
    me: WorkerId,
    /// By block: owner and the number of moves known of.
    owners: Vec<(WorkerId, u32)>,
}

impl Directory {
    /// The view of worker `me`: block `b` belongs to `owners[b]`.
    pub fn new(me: WorkerId, owners: &[WorkerId]) -> Self {
        Self { me, owners: owners.iter().map(|&w| (w, 0)).collect() }
    }

    /// The worker whose view this is.
    #[inline]
    pub fn me(&self) -> WorkerId {
        self.me
    }

    /// All blocks.
    pub fn blocks(&self) -> impl DoubleEndedIterator<Item = BlockId> + ExactSizeIterator {
        BlockId::below(self.owners.len() as u32)
    }

    /// The owner of `block`, as far as known.
    #[inline]
    pub fn owner(&self, block: BlockId) -> WorkerId {
        self.owners[block.index()].0
    }

    /// The number of moves of `block` known of.
    pub fn epoch(&self, block: BlockId) -> u32 {
        self.owners[block.index()].1
    }

    /// Is `block` this worker's? Always right.
    #[inline]
    pub fn is_mine(&self, block: BlockId) -> bool {
        self.owners[block.index()].0 == self.me
    }

    /// Takes news: `block` was at `owner` after `epoch` moves. Older news changes nothing.
    pub fn learn(&mut self, block: BlockId, owner: WorkerId, epoch: u32) {
        let entry = &mut self.owners[block.index()];
        if epoch > entry.1 {
            *entry = (owner, epoch);
        }
    }
}
