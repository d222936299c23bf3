//! The tetrahedra that are over their bounds at the end, each with the reason; and counts of them
//! by corner and segment.

use super::RefineError;
use super::bounds::Bounds;
use super::item::Item;
use super::key::sorted;
use super::measure::Shape;
use super::number::in_order;
use super::outcome::{Excuse, Reason};
use super::output::Refined;
use super::record::Record;
use super::state::State;
use super::table::{Map, Set};
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
        let all = || -> Vec<TetId> {
            let all = order.iter().copied();
            bounds.over_of(self, all, &mut Vec::new()).map(|(t, _)| t).collect()
        };
        let over = match over {
            None => all(),
            Some(mut over) => {
                over.sort_unstable_by_key(|&t| self.mesh.tet(t).map(in_order));
                // A field was asked once more already.
                debug_assert!(
                    bounds.field.is_some() || over == all(),
                    "all that are over their bounds are known"
                );
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

    /// Has the sizing field lengths for all tetrahedra, which `order` has, and are those over their
    /// bounds now the ones of before? It is asked for each once more.
    ///
    /// # Errors
    /// A place where it has none, or another one.
    pub(crate) fn check_field(
        &self,
        bounds: &Bounds<'_>,
        order: &[TetId],
        before: &[TetId],
    ) -> Result<(), RefineError> {
        if bounds.field.is_none() {
            return Ok(());
        }
        bounds.check_sizes(self, order)?;
        let before: Set<TetId> = before.iter().copied().collect();
        let (mut thin, all) = (Vec::new(), order.iter().copied());
        let now: Set<TetId> = bounds.over_of(self, all, &mut thin).map(|(t, _)| t).collect();
        let differs = |t: &&TetId| before.contains(*t) != now.contains(*t);
        let Some(&t) = order.iter().find(differs) else { return Ok(()) };
        let corners = self.vertices(t).map(|v| self.at(v));
        Err(RefineError::ImpureSize { at: bounds.centroid(corners.each_ref()) })
    }
}

/// The tetrahedra over a bound for one reason: at one corner or segment of the input, for example.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excused {
    /// The reason that they have in common.
    pub reason: Reason,
    /// Their number.
    pub tets: usize,
    /// The volume that they fill, rounded, in the coordinates of the domain.
    pub volume: f64,
}

impl Refined {
    /// The excuses counted by reason, in the order of reasons: corner by corner, then segment by
    /// segment.
    pub fn excused(&self) -> Vec<Excused> {
        let mut all: Map<Reason, (usize, f64)> = Map::default();
        let step = self.lattice.fine_step();
        for excuse in &self.excuses {
            // Rounded in an order that is the same for all slots and vertices.
            let [a, b, c, d] = sorted(self.state.vertices(excuse.tet).map(|v| self.state.at(v)));
            let volume = Shape::of([&a, &b, &c, &d]).det.abs() / 6.0 * step * step * step;
            let entry = all.entry(excuse.reason).or_default();
            *entry = (entry.0 + 1, entry.1 + volume);
        }
        let excused = |(reason, (tets, volume))| Excused { reason, tets, volume };
        let mut list: Vec<Excused> = all.into_iter().map(excused).collect();
        list.sort_unstable_by_key(|excused| excused.reason);
        list
    }
}
