//! The record of earlier proposals: what was refused, under which limit, and which boundary items
//! wait for which.

use super::bounds::Bounds;
use super::item::Item;
use super::outcome::Reason;
use super::state::State;
use super::table::{Map, Set};
use ltbw_core::topology::{TetId, VertexId};

/// The part of its limit down to which an edge may be made between two segments at a small angle:
/// the points of both are as near to each other as the angle makes them.
pub(crate) const TIP_SHARE: f64 = 0.5;

/// Why an item was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Refusal {
    pub(crate) reason: Reason,
    /// The shortest edge that was allowed; a proposal that allows shorter ones may try again.
    pub(crate) limit: Option<f64>,
}

impl Refusal {
    /// A refusal for good.
    pub(crate) fn final_for(reason: Reason) -> Self {
        Self { reason, limit: None }
    }

    /// May a proposal that allows edges down to `limit` try again?
    pub(crate) fn allows(&self, limit: Option<f64>) -> bool {
        limit.zip(self.limit).is_some_and(|(new, old)| new < 0.99 * old)
    }
}

/// The results of earlier proposals.
#[derive(Debug, Default)]
pub(crate) struct Record {
    pub(crate) refused: Map<Item, Refusal>,
    /// Proposed items near small angles: the shortest edge that splitting them may make.
    pub(crate) limits: Map<Item, f64>,
    /// Refused tetrahedra that are asked again with a part of the shortest edge that they may make.
    pub(crate) parts: Map<Item, f64>,
    /// Boundary items that wait for another one, since the last insertion.
    pub(crate) waits: Map<Item, Item>,
    /// Refused tetrahedra for which no point was found that relieves them.
    pub(crate) in_vain: Set<Item>,
    /// The transactions of joint steps so far.
    pub(crate) joint_transactions: usize,
}

impl Record {
    /// The reason why an item was refused, unless a proposal down to `limit` may try again.
    pub(crate) fn bars(&self, item: &Item, limit: Option<f64>) -> Option<Reason> {
        self.refused.get(item).filter(|r| !r.allows(limit)).map(|r| r.reason)
    }

    /// The refused tetrahedra that are over their bounds.
    pub(crate) fn refused_over<'r>(
        &'r self,
        bounds: &'r Bounds<'_>,
        state: &'r State,
    ) -> impl Iterator<Item = (TetId, [VertexId; 4])> + 'r {
        self.refused.keys().filter_map(|&item| match item {
            Item::Tet(t, v) if state.is_live(t, v) => bounds.is_over(state, t).then_some((t, v)),
            _ => None,
        })
    }

    /// Does `first` wait for `item`, or for something that does?
    pub(crate) fn waits_for(&self, first: Item, item: Item) -> bool {
        let mut next = first;
        // No circle is ever closed, so no item is passed twice.
        for _ in 0..=self.waits.len() {
            if next == item {
                return true;
            }
            let Some(&then) = self.waits.get(&next) else { return false };
            next = then;
        }
        true
    }
}
