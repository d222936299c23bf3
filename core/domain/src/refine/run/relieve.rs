//! Relief with queues, when nothing else is left to do.

use super::Run;
use crate::refine::RefineError;
use crate::refine::relief::PASSES;

impl Run<'_> {
    /// Relieves the tetrahedra over their bounds while that makes them fewer.
    pub(in crate::refine) fn relieve(&mut self) -> Result<(), RefineError> {
        let mut left = self.refinement.relief_budget();
        let mut before = usize::MAX;
        for pass in 1..=PASSES {
            let over = self.refinement.refused_tets();
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
                self.refinement.relieve_tet(t, v, pass, &mut left);
            }
        }
        Ok(())
    }
}
