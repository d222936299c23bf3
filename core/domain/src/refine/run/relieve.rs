//! Relief with queues, when nothing else is left to do.

use super::Run;
use crate::refine::RefineError;
use crate::refine::relief::{Goal, PASSES};

impl Run<'_> {
    /// Relieves the tetrahedra over their bounds while that makes them fewer.
    pub(in crate::refine) fn relieve(&mut self) -> Result<(), RefineError> {
        self.relieve_for(Goal::Bounds)
    }

    /// Relieves the tetrahedra with tiny dihedral angles while that makes them fewer.
    pub(in crate::refine) fn relieve_angles(&mut self) -> Result<(), RefineError> {
        self.relieve_for(Goal::Angles)
    }

    fn relieve_for(&mut self, goal: Goal) -> Result<(), RefineError> {
        let mut left = self.refinement.relief_budget();
        let mut before = usize::MAX;
        for pass in 1..=PASSES {
            let over = match goal {
                Goal::Bounds => self.refinement.refused_tets(),
                Goal::Angles => self.refinement.slivers(),
            };
            if self.stop.is_some() || over.is_empty() || over.len() >= before {
                break;
            }
            before = over.len();
            for (t, v) in over {
                self.look()?;
                let spent = self.refinement.inserted.points.total() >= self.most;
                if spent || left == 0 || self.stop.is_some() {
                    return Ok(());
                }
                self.refinement.relieve_tet(t, v, goal, pass, &mut left);
            }
        }
        Ok(())
    }
}
