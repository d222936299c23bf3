//! The record of earlier proposals: what was refused, under which limit, and which boundary items
//! wait for which.

use crate::mesh::bounds::Bounds;
use crate::mesh::item::Item;
use crate::mesh::journal::LimitBefore;
use crate::mesh::limit::Limit;
use crate::mesh::state::State;
use crate::outcome::Reason;
use crate::table::{Map, Set};
use ltbw_core::topology::{TetId, VertexId};

/// The part of its limit down to which an edge may be made between two segments at a small angle:
/// the points of both are as near to each other as the angle makes them.
pub(crate) const TIP_SHARE: f64 = 0.5;

/// Why an item was refused.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Refusal {
    /// The reason.
    pub reason: Reason,
    /// The edges that were allowed; a proposal that allows shorter ones may try again.
    pub limit: Option<Limit>,
}

impl Refusal {
    /// The refusal of an item that was proposed under a limit.
    pub fn under(reason: Reason, limit: Option<Limit>) -> Self {
        // The floor is no lower for a proposal that allows shorter edges.
        Self { reason, limit: limit.filter(|_| reason != Reason::Floor) }
    }

    /// A refusal for good.
    pub(crate) fn final_for(reason: Reason) -> Self {
        Self { reason, limit: None }
    }

    /// May a proposal that allows edges down to `limit` try again?
    pub(crate) fn allows(&self, limit: Option<Limit>) -> bool {
        limit.zip(self.limit).is_some_and(|(new, old)| new.is_below(0.99, old))
    }

    /// The limit of a proposal that tries again: all that was allowed before is still.
    #[must_use]
    pub fn again(&self, limit: Limit) -> Limit {
        self.limit.map_or(limit, |before| limit.or(before))
    }
}

/// The first of some items that is not barred; else the reason why none may be split, after one
/// that is known.
pub(crate) fn first_of<I: Copy>(
    items: &[I],
    bars: impl Fn(&I) -> Option<Reason>,
    mut reason: Reason,
) -> Result<I, Reason> {
    for item in items {
        match bars(item) {
            None => return Ok(*item),
            Some(why) => reason = reason.after(why),
        }
    }
    Err(reason)
}

/// The results of earlier proposals.
#[derive(Debug, Default)]
pub(crate) struct Record {
    pub(crate) refused: Map<Item, Refusal>,
    /// Proposed items near small angles: the edges that splitting them may make.
    pub(crate) limits: Map<Item, Limit>,
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
    pub(crate) fn bars(&self, item: &Item, limit: Option<Limit>) -> Option<Reason> {
        self.refused.get(item).filter(|r| !r.allows(limit)).map(|r| r.reason)
    }

    /// Restores limits, given in the order in which others were set in their place: those of a
    /// joint step end with it.
    pub(crate) fn restore_limits(&mut self, before: Vec<LimitBefore>) {
        for LimitBefore { item, limit } in before.into_iter().rev() {
            match limit {
                Some(limit) => self.limits.insert(item, limit),
                None => self.limits.remove(&item),
            };
        }
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

#[cfg(test)]
mod tests {
    use super::{Limit, Reason, Refusal};

    /// A proposal that tries again allows what was allowed before, so that none tries twice.
    #[test]
    fn a_refusal_is_tried_again_for_shorter_edges_alone() {
        let sized = |least: f64, along: f64| Limit { least, along: Some(along) };
        let under = |limit| Refusal { reason: Reason::Rounding, limit: Some(limit) };
        let first = under(Limit::all(8.0));
        assert!(!first.allows(None) && !first.allows(Some(Limit::all(7.95))));
        for limit in [Limit::all(7.0), sized(9.0, 16.0)] {
            assert!(first.allows(Some(limit)));
            let again = first.again(limit);
            let second = under(again);
            for before in [Limit::all(8.0), limit, again] {
                assert!(!second.allows(Some(before)), "{before:?} after {limit:?}");
            }
        }
        assert!(!Refusal::final_for(Reason::Rounding).allows(Some(sized(0.0, 0.0))));
    }
}
