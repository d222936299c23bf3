//! Boundary items that are to be split, each kept by one worker, and who waits for whom.

use crate::protocol::WorkerId;
use ltbw_core::topology::TetId;
use ltbw_refine::{BoundaryItem, ItemPlace, Limit};
use std::collections::BTreeMap;

/// A boundary item to be split.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    pub(super) item: BoundaryItem,
    /// The item that has to be split before it.
    pub(super) first: Option<ItemPlace>,
    pub(super) limit: Option<Limit>,
    /// A slot that was near it, where the walk to its point starts.
    pub(super) near: Option<TetId>,
}

/// An item to split, and the place of the item that waits for it.
pub(super) type Demand = (Pending, Option<(WorkerId, ItemPlace)>);

/// The boundary items that a worker keeps, and the news of a round about them.
#[derive(Debug, Default)]
pub(super) struct Demands {
    pub(super) pending: BTreeMap<ItemPlace, Pending>,
    /// By item, the items that wait for it, with their keepers.
    pub(super) waiters: BTreeMap<ItemPlace, Vec<(WorkerId, ItemPlace)>>,
    /// Items asked for in this round.
    pub(super) asked: Vec<Demand>,
    /// Items that are gone since.
    pub(super) gone: Vec<ItemPlace>,
    /// Items whose first ones are gone.
    pub(super) released: Vec<ItemPlace>,
}

impl Demands {
    /// The number of items that may be tried.
    pub(super) fn ready(&self) -> usize {
        self.pending.values().filter(|own| own.first.is_none()).count()
    }

    /// Enters the news of a round; returns the items that waited for those that are gone, with
    /// their keepers.
    pub(super) fn settle(&mut self) -> Vec<(WorkerId, ItemPlace)> {
        for (asked, waiter) in self.asked.drain(..) {
            let place = asked.item.place();
            let own = self.pending.entry(place).or_insert(asked);
            own.limit = match (own.limit, asked.limit) {
                (Some(a), Some(b)) => Some(a.or(b)),
                (a, b) => a.or(b),
            };
            own.near = own.near.or(asked.near);
            if let Some(waiter) = waiter {
                self.waiters.entry(place).or_default().push(waiter);
            }
        }
        let mut waited = Vec::new();
        for place in std::mem::take(&mut self.gone) {
            self.pending.remove(&place);
            waited.extend(self.waiters.remove(&place).into_iter().flatten());
        }
        waited
    }

    /// Lets items be tried whose first ones are gone.
    pub(super) fn release(&mut self) {
        for place in std::mem::take(&mut self.released) {
            if let Some(own) = self.pending.get_mut(&place) {
                own.first = None;
            }
        }
    }
}
