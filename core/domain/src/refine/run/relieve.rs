//! Relief with queues, when nothing else is left to do.

use super::Run;
use crate::refine::RefineError;
use crate::refine::relief::{Goal, Relief};

impl Run<'_> {
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
