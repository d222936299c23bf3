//! Rounds that take over from others, who have carried out some before.

use super::{BlockHere, Pending, Rounds};
use crate::RefineError;
use crate::mesh::item::Item;
use crate::mesh::limit::Limit;
use crate::rules::block::{Block, Blocks, KeptBlock};
use crate::rules::record::Refusal;
use crate::thin::Thin;
use ltbw_core::topology::TetId;

/// A boundary item that was to be split when others handed over.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waiting {
    pub(crate) item: Item,
    pub(crate) first: Option<Item>,
    /// A slot at it.
    pub(crate) near: TetId,
    pub(crate) limit: Option<Limit>,
}

/// The work that others leave to be done.
#[derive(Debug)]
pub(crate) struct Resumed {
    pub(crate) waiting: Vec<Waiting>,
    pub(crate) refused: Vec<(Item, Refusal)>,
    /// The candidates among the tetrahedra when last counted.
    pub(crate) candidates: usize,
    /// If none is over its bounds, those that may have tiny dihedral angles.
    pub(crate) thin: Option<Vec<TetId>>,
    /// If rounds of slivers have begun, those that are still to be looked at: the late steps before
    /// found nothing to do.
    pub(crate) slivers: Option<Vec<TetId>>,
    /// Refused tetrahedra for which no point was found that relieves them.
    pub(crate) in_vain: Vec<Item>,
    /// The transactions of joint steps so far.
    pub(crate) spent: usize,
    /// Subfaces that bar many.
    pub(crate) blocks: Vec<(Block, BlockHere)>,
}

impl Rounds<'_, '_> {
    /// Leaves slivers to others, if there are as many as `few`, and works up to these.
    pub(crate) fn leave_slivers(&mut self, few: usize) {
        self.leaves_slivers = Some(few);
    }

    /// Takes over from others.
    pub(crate) fn resume(&mut self, resumed: Resumed) {
        self.front.counted = resumed.candidates;
        self.late.thin = resumed.thin;
        let kept = resumed.blocks.into_iter().map(|(block, here)| KeptBlock { block, here });
        self.blocks = Blocks::of(kept.collect());
        if let Some(slivers) = resumed.slivers {
            let vertices = |t: TetId| self.own.state.vertices(t);
            let mut slivers: Vec<Thin> = slivers.into_iter().map(|t| (t, vertices(t))).collect();
            slivers.sort_by_cached_key(|&(t, v)| self.own.state.place_of(Item::Tet(t, v)));
            self.late.go_on_with(slivers);
        }
        self.own.record.joint_transactions = resumed.spent;
        self.own.record.refused.extend(resumed.refused);
        self.own.record.in_vain.extend(resumed.in_vain);
        for Waiting { item, first, near, limit } in resumed.waiting {
            self.demands.pending.insert(item, Pending { first, near });
            self.own.record.limits.extend(limit.map(|limit| (item, limit)));
        }
    }

    /// Looks at all tetrahedra, unless others have.
    ///
    /// # Errors
    /// In debug builds: others have not seen what there is.
    pub(super) fn look_at_first(&mut self) -> Result<(), RefineError> {
        let Some(thin) = self.late.thin.take() else {
            self.look_at_all();
            return Ok(());
        };
        let vertices = |t: TetId| self.own.state.vertices(t);
        let mut thin: Vec<Thin> = thin.into_iter().map(|t| (t, vertices(t))).collect();
        if cfg!(debug_assertions) {
            self.look_at_all();
            let mut all = std::mem::take(&mut self.own.inserted.thin.tets);
            all.sort_unstable();
            thin.sort_unstable();
            if all != thin || self.keys.count() > 0 {
                return Err(RefineError::Invariant {
                    what: "others have looked at all tetrahedra",
                });
            }
        }
        self.make_room();
        self.own.inserted.thin.tets = thin;
        Ok(())
    }
}
