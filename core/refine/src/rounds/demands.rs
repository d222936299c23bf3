//! Demands: boundary items that are to be split, who waits for whom, and what a round adds to that.

use crate::mesh::item::Item;
use crate::mesh::limit::Limit;
use crate::mesh::state::State;
use crate::outcome::Reason;
use crate::rules::circles::circles;
use crate::rules::record::{Record, Refusal};
use crate::table::{Map, Set};
use ltbw_core::topology::TetId;

/// A boundary item that is to be split.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    /// The item that has to be split before it.
    pub(super) first: Option<Item>,
    /// A slot that was near it, where the walk to its point starts.
    pub(super) near: TetId,
}

/// A boundary item that may be split now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ready {
    pub(super) item: Item,
    /// A slot near it.
    pub(super) near: TetId,
}

/// A boundary item that is asked for in a round.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    pub(super) item: Item,
    /// The edges that it may make.
    pub(super) limit: Option<Limit>,
    pub(super) near: TetId,
}

/// The outcome of the probe of a tetrahedron that is not split now: the item that it asks for,
/// or the reason why it is refused.
#[derive(Debug)]
pub(super) struct Conclusion {
    pub(super) t: TetId,
    pub(super) rank: u32,
    pub(super) verdict: Result<Asked, Reason>,
}

/// The boundary items that are to be split, and the news of a round.
#[derive(Debug, Default)]
pub(super) struct Demands {
    pub(super) pending: Map<Item, Pending>,
    /// Items that were split or are gone, for which others may still say that they wait. One that
    /// is not pending bars nobody; it counts when it is asked for once more.
    gone: Set<Item>,
    /// Items that were looked at for what they wait for.
    #[cfg(test)]
    steps: usize,
    /// Items asked for in this round.
    pub(super) asked: Vec<Asked>,
    /// Pending items that were found to wait in this round.
    pub(super) waits: Vec<(Item, Pending)>,
    /// Items refused in this round.
    pub(super) refusals: Vec<(Item, Reason)>,
    /// Tetrahedra of this round that are not to be split now.
    pub(super) conclusions: Vec<Conclusion>,
}

impl Demands {
    /// The items that may be tried: not before the one that it waits for is gone or refused.
    pub(super) fn ready(&self) -> impl Iterator<Item = Ready> + '_ {
        let waits =
            |own: &Pending| own.first.is_some_and(|other| self.pending.contains_key(&other));
        let ready = self.pending.iter().filter(move |(_, own)| !waits(own));
        ready.map(|(&item, own)| Ready { item, near: own.near })
    }

    /// Was any item found to wait, or refused, in this round?
    pub(super) fn has_waits_or_refusals(&self) -> bool {
        !self.refusals.is_empty() || !self.waits.is_empty()
    }

    /// Enters who waits, and the items that were asked for with their limits; `false` if these are
    /// nothing new.
    pub(super) fn take_asked(&mut self, record: &mut Record) -> bool {
        self.forget_gone();
        let Self { pending, asked, waits, .. } = self;
        let mut news = false;
        pending.extend(waits.drain(..));
        for Asked { item, limit, near } in asked.drain(..) {
            let refusal = record.refused.remove(&item);
            news |= !pending.contains_key(&item);
            pending.entry(item).or_insert(Pending { first: None, near });
            if let Some(limit) = limit {
                let limit = refusal.map_or(limit, |refusal| refusal.again(limit));
                let own = record.limits.entry(item).or_insert(limit);
                news |= limit.is_below(1.0, *own);
                *own = own.or(limit);
            }
        }
        news
    }

    /// Enters refusals; `tell` is told the tetrahedra among them. What waited for an item that is
    /// refused may be tried, also if that is asked for once more.
    pub(super) fn take_refusals(&mut self, record: &mut Record, mut tell: impl FnMut(TetId)) {
        let mut refused: Set<Item> = Set::default();
        for (item, reason) in self.refusals.drain(..) {
            record.refused.insert(item, Refusal::under(reason, record.limits.remove(&item)));
            self.pending.remove(&item);
            match item {
                // No look so far has found it so.
                Item::Tet(t, _) => tell(t),
                _ => {
                    refused.insert(item);
                }
            }
        }
        if !refused.is_empty() {
            let waited = |own: &&mut Pending| own.first.is_some_and(|item| refused.contains(&item));
            self.pending.values_mut().filter(waited).for_each(|own| own.first = None);
        }
    }

    /// An item is split, or gone.
    pub(super) fn remove(&mut self, item: &Item) {
        self.pending.remove(item);
        // Nobody waits for a tetrahedron.
        if !matches!(item, Item::Tet(..)) {
            self.gone.insert(*item);
        }
    }

    /// Nobody waits for what was removed: once in a round, since all are looked at.
    fn forget_gone(&mut self) {
        if !self.gone.is_empty() {
            #[cfg(test)]
            {
                self.steps += self.pending.len();
            }
            let waited =
                |own: &&mut Pending| own.first.is_some_and(|item| self.gone.contains(&item));
            self.pending.values_mut().filter(waited).for_each(|own| own.first = None);
            self.gone.clear();
        }
    }

    /// The foremost item of each circle of items that wait for each other, in the order of their
    /// places. Every item waits for one, so that each way ends in a circle.
    pub(super) fn circles(&self, state: &State) -> Vec<Item> {
        let mut items: Vec<Item> = self.pending.keys().copied().collect();
        state.sort(&mut items);
        let numbers: Map<Item, usize> = items.iter().copied().zip(0..).collect();
        let first_of = |item: &Item| numbers.get(&self.pending.get(item)?.first?).copied();
        let first: Vec<Option<usize>> = items.iter().map(first_of).collect();
        circles(&first).into_iter().map(|circle| items[circle[0]]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_core::topology::VertexId;

    fn segment(k: u32) -> Item {
        Item::Segment([k, k + 1].map(VertexId::new))
    }

    fn asked(item: Item) -> Asked {
        Asked { item, limit: None, near: TetId::new(0) }
    }

    /// A round splits a part of all items: to look at all for each was quadratic.
    #[test]
    fn items_that_wait_are_looked_at_once_in_a_round() {
        const COUNT: u32 = 1000;
        let (mut demands, mut record) = (Demands::default(), Record::default());
        demands.asked.extend((0..2 * COUNT).map(|k| asked(segment(k))));
        // Of two items the second waits for the first.
        demands.waits.extend((0..COUNT).map(|k| {
            let first = Some(segment(2 * k));
            (segment(2 * k + 1), Pending { first, near: TetId::new(0) })
        }));
        demands.take_asked(&mut record);
        assert_eq!(demands.ready().count(), COUNT as usize);
        (0..COUNT).for_each(|k| demands.remove(&segment(2 * k)));
        assert_eq!(demands.ready().count(), COUNT as usize, "what waited is ready");
        // An item that is asked for once more is not waited for.
        demands.asked.extend((0..COUNT).map(|k| asked(segment(2 * k))));
        demands.take_asked(&mut record);
        assert_eq!(demands.ready().count(), 2 * COUNT as usize);
        assert!(demands.steps <= 2 * COUNT as usize, "{} steps", demands.steps);
    }
}
