//! The tetrahedra that are over their bounds at the end, each with the reason.

use super::bounds::Bounds;
use super::item::Item;
use super::number::in_order;
use super::outcome::{Excuse, Reason};
use super::record::Record;
use super::state::State;
use ltbw_core::topology::TetId;

impl State {
    /// The excuses of the tetrahedra over their bounds, in the order of `order`, which has all;
    /// `over` lists them if they are known. What was not refused is over for the reason `stop`.
    pub(crate) fn excuses(
        &self,
        bounds: &Bounds<'_>,
        record: &Record,
        order: &[TetId],
        over: Option<Vec<TetId>>,
        stop: Option<Reason>,
    ) -> Vec<Excuse> {
        let is_over = |t: &TetId| bounds.excess(self, *t).is_some();
        let all = || -> Vec<TetId> { order.iter().copied().filter(is_over).collect() };
        let over = match over {
            None => all(),
            Some(mut over) => {
                over.sort_unstable_by_key(|&t| self.mesh.tet(t).map(in_order));
                debug_assert_eq!(over, all(), "what is over its bounds is known");
                over
            }
        };
        let excuse = |tet: TetId| {
            let item = Item::Tet(tet, self.vertices(tet));
            let reason = record.refused.get(&item).map(|r| r.reason).or(stop);
            Excuse { tet, reason: reason.unwrap_or(Reason::Rounding) }
        };
        over.into_iter().map(excuse).collect()
    }
}
