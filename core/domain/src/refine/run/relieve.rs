//! Relief with queues, when nothing else is left to do.

use super::Run;
use crate::refine::RefineError;
use crate::refine::relief::{Goal, Relief};
use ltbw_core::cavity::AdmitAll;

impl Run<'_> {
    /// Relieves tetrahedra while that makes those that the goal asks for fewer.
    pub(in crate::refine) fn relieve(&mut self, goal: Goal) -> Result<(), RefineError> {
        self.relieve_all(Relief::new(goal, &self.refinement))
    }

    /// Splits slivers, then relieves those that are left.
    pub(in crate::refine) fn split_slivers(&mut self) -> Result<(), RefineError> {
        let left = self.refinement.split_slivers(self.most, &mut self.work, &mut AdmitAll);
        let points = self.refinement.inserted.points.total();
        // A sizing field may ask for more afterwards.
        self.refine(usize::MAX)?;
        let is_known = self.refinement.inserted.points.total() == points;
        self.relieve_all(match is_known {
            true => Relief::of_slivers(left, &self.refinement),
            false => Relief::new(Goal::Angles, &self.refinement),
        })
    }

    fn relieve_all(&mut self, mut relief: Relief) -> Result<(), RefineError> {
        loop {
            let is_spent = self.refinement.inserted.points.total() >= self.most;
            if self.stop.is_some() || is_spent || relief.next(&mut self.refinement).is_none() {
                return Ok(());
            }
            self.look()?;
        }
    }
}
