//! Deferral: an item waits until another one is split, or both are split jointly.

use super::split::{Refinement, Step};
use crate::mesh::item::{Item, Queues};
use crate::mesh::journal::LimitBefore;
use crate::mesh::limit::Limit;
use crate::outcome::Reason;
use crate::rules::record::Refusal;

impl Refinement<'_> {
    /// Puts one of the items `all` before `item`, which waits for it. Near small angles, splitting
    /// it may make no edges but those that `limit` allows.
    ///
    /// If all were refused, so is this one, for the same reason, unless it allows shorter edges
    /// than before. Items that wait for each other in a circle are split jointly.
    pub(crate) fn defer(
        &mut self,
        item: Item,
        all: Vec<Item>,
        limit: Option<Limit>,
        work: &mut Queues,
    ) -> Step {
        let mut reason = match item {
            Item::Tet(_, v) => self.state.reason_near(v),
            _ => Reason::Rounding,
        };
        for first in all {
            let mut limit = limit;
            if let Some(refusal) = self.record.refused.get(&first) {
                if !refusal.allows(limit) {
                    reason = reason.after(refusal.reason);
                    continue;
                }
                limit = limit.map(|limit| refusal.again(limit));
                self.record.refused.remove(&first);
            }
            if self.record.waits_for(first, item) {
                reason = self.state.reason_in_circle(item);
                if self.bounds.is_none() || self.state.journal.is_some() {
                    continue;
                }
                if let Some(limit) = limit.filter(|limit| limit.along.is_some()) {
                    self.record.limits.entry(first).or_insert(limit);
                }
                match self.split_jointly(first, work) {
                    Step::Refused(why) => {
                        let why = match why {
                            Reason::Interlocked { .. } => self.state.reason_in_circle(first),
                            why => why,
                        };
                        self.record.refused.insert(first, Refusal::final_for(why));
                        continue;
                    }
                    Step::SetBack(setback) => return Step::SetBack(setback),
                    _ => {
                        work.put(item, 1.0);
                        return Step::Deferred;
                    }
                }
            }
            if !matches!(item, Item::Tet(..)) {
                self.record.waits.insert(item, first);
            }
            if let Some(limit) = limit {
                let before = self.record.limits.insert(first, limit);
                if let Some(journal) = &mut self.state.journal {
                    journal.limits.push(LimitBefore { item: first, limit: before });
                }
            }
            self.state.enter(first);
            work.put_behind(item, first);
            return Step::Deferred;
        }
        Step::Refused(reason)
    }
}
