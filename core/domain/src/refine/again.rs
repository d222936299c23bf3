//! Tetrahedra that were refused are asked again when nothing else is left to do.
//!
//! A refusal is that of a boundary item which the tetrahedron waits for, under the limit of its
//! time: others may have been split since, or the item may be gone. So a few refusals near a small
//! angle would leave all that waits for them, in a chain, as it was.

use super::RefineError;
use super::item::{Item, Work};
use super::run::Run;

/// The most times that refused tetrahedra are asked again.
const MOST: u32 = 5;

impl Run<'_> {
    /// Asks refused tetrahedra again while that makes them fewer.
    pub(super) fn refine_again(&mut self) -> Result<(), RefineError> {
        let mut before = usize::MAX;
        for _ in 0..MOST {
            let over = self.refused_and_over();
            if self.stop.is_some() || over.is_empty() || over.len() >= before {
                return Ok(());
            }
            before = over.len();
            let refinement = &mut self.refinement;
            let mut refused = std::mem::take(&mut refinement.record.refused);
            // On a tip or in a collar the answer is the same.
            refused.retain(|&item, _| match item {
                Item::Tet(t, v) => {
                    refinement.state.is_live(t, v) && refinement.beyond_help(t, v).is_some()
                }
                _ => false,
            });
            refinement.record.refused = refused;
            refinement.record.limits.clear();
            refinement.record.waits.clear();
            over.into_iter().for_each(|(item, weight)| self.work.put(item, weight));
            self.refine(usize::MAX)?;
        }
        Ok(())
    }

    /// The refused tetrahedra that are over their bounds and on no tip and in no collar, in the
    /// order of their slots, with their weights.
    fn refused_and_over(&self) -> Vec<(Item, f64)> {
        let refinement = &self.refinement;
        let Some(bounds) = &refinement.bounds else { return Vec::new() };
        let over = |&item: &Item| {
            let Item::Tet(t, v) = item else { return None };
            if !refinement.state.is_live(t, v) || refinement.beyond_help(t, v).is_some() {
                return None;
            }
            bounds.excess(&refinement.state, t).map(|weight| (item, weight))
        };
        let mut all: Vec<(Item, f64)> = refinement.record.refused.keys().filter_map(over).collect();
        all.sort_unstable_by_key(|&(item, _)| item);
        all
    }
}
