//! Boundary items that are to be split, each kept by one worker, and who waits for whom.

use crate::protocol::WorkerId;
use ltbw_core::topology::TetId;
use ltbw_refine::{BoundaryItem, ItemPlace, Limit, Reason, Refusal, Refusals};
use std::collections::{BTreeMap, BTreeSet};

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

/// The boundary items that were refused.
#[derive(Debug, Default)]
pub(super) struct Refused {
    /// Before this round, by all.
    pub(super) all: Refusals,
    /// In this one, of those that this worker keeps.
    pub(super) new: Vec<(ItemPlace, Reason)>,
    /// The number of these and of the tetrahedra that this worker has refused in this round.
    pub(super) count: i64,
}

impl Refused {
    /// An item is refused, or it is not any more.
    pub(super) fn set(&mut self, place: ItemPlace, why: Option<Refusal>) {
        match why {
            Some(why) => self.all.insert(place, why),
            None => self.all.remove(&place),
        };
    }

    /// Notes that all are to be told of an item that this worker keeps.
    fn tell(&mut self, place: ItemPlace, why: Option<Refusal>, settled: &mut Settled) {
        self.set(place, why);
        settled.refused.push(ItemRefusal { place, why });
    }
}

/// An item that is refused, or is not any more.
#[derive(Clone, Copy, Debug)]
pub(super) struct ItemRefusal {
    pub(super) place: ItemPlace,
    pub(super) why: Option<Refusal>,
}

/// The consequences of a round's news about the items of a keeper.
#[derive(Debug, Default)]
pub(super) struct Settled {
    /// The items that waited for those that are gone or refused, with their keepers.
    pub(super) waited: Vec<(WorkerId, ItemPlace)>,
    /// The items that are refused, or are not any more.
    pub(super) refused: Vec<ItemRefusal>,
}

/// The boundary items that a worker keeps, and the news of a round about them.
#[derive(Debug, Default)]
pub(super) struct Demands {
    pub(super) pending: BTreeMap<ItemPlace, Pending>,
    /// By item, the items that wait for it, with their keepers.
    pub(super) waiters: BTreeMap<ItemPlace, Vec<(WorkerId, ItemPlace)>>,
    /// The items that were refused.
    pub(super) refused: Refused,
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

    /// Enters the news of a round. An item that was refused and is asked for once more is refused
    /// no longer; one that is refused in this round is so with all that was asked of it.
    pub(super) fn settle(&mut self) -> Settled {
        let mut settled = Settled::default();
        for (mut asked, waiter) in self.asked.drain(..) {
            let place = asked.item.place();
            if let Some(before) = self.refused.all.get(&place).copied() {
                asked.limit = asked.limit.map(|limit| before.again(limit));
                self.refused.tell(place, None, &mut settled);
            }
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
        for (place, reason) in std::mem::take(&mut self.refused.new) {
            let limit = self.end(place, &mut settled);
            self.refused.tell(place, Some(Refusal::under(reason, limit)), &mut settled);
        }
        for place in std::mem::take(&mut self.gone) {
            self.end(place, &mut settled);
            if self.refused.all.contains_key(&place) {
                self.refused.tell(place, None, &mut settled);
            }
        }
        self.refused.count = 0;
        settled
    }

    /// An item is to be split no more; returns its limit.
    fn end(&mut self, place: ItemPlace, settled: &mut Settled) -> Option<Limit> {
        settled.waited.extend(self.waiters.remove(&place).into_iter().flatten());
        self.pending.remove(&place).and_then(|own| own.limit)
    }

    /// Items of circles are to be split no more, whoever keeps them: those of this keeper that wait
    /// for one may be tried.
    pub(super) fn forget(&mut self, ended: &BTreeSet<ItemPlace>) {
        self.pending.retain(|place, _| !ended.contains(place));
        self.waiters.retain(|place, _| !ended.contains(place));
        for own in self.pending.values_mut() {
            own.first = own.first.filter(|first| !ended.contains(first));
        }
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
