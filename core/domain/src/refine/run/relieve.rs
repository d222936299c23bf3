//! Relief with queues, when nothing else is left to do.

use super::Run;
use crate::refine::RefineError;
use crate::refine::relief::{Goal, Relief};
use ltbw_core::cavity::AdmitAll;

impl Run<'_> {
    /// Splits slivers, then relieves those that are left.
    pub(in crate::refine) fn split_slivers(&mut self) -> Result<(), RefineError> {
        self.refinement.split_slivers(self.most, &mut self.work, &mut AdmitAll);
        // A sizing field may ask for more afterwards.
        self.refine(usize::MAX)?;
        self.relieve(Goal::Angles)
    }

    /// Relieves tetrahedra while that makes those that the goal asks for fewer.
    pub(in crate::refine) fn relieve(&mut self, goal: Goal) -> Result<(), RefineError> {
        let mut relief = Relief::new(goal, &self.refinement);
        loop {
            let is_spent = self.refinement.inserted.points.total() >= self.most;
            if self.stop.is_some() || is_spent || relief.next(&mut self.refinement).is_none() {
                return Ok(());
            }
            self.look()?;
        }
    }
}
