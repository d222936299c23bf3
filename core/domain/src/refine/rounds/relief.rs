//! Relief in rounds: one point after the other, when nothing is left but slivers.
//!
//! Tetrahedra are taken in the order of their coordinates, so that relief is the same whatever the
//! order in rounds was.

use super::{Look, Rounds};
use crate::refine::RefineError;
use crate::refine::outcome::Reason;
use crate::refine::relief::{Goal, PASSES};

impl Rounds<'_, '_> {
    /// Relieves the tetrahedra over their bounds while that makes them fewer. Returns why it
    /// stopped early: when the work was cancelled.
    ///
    /// # Errors
    /// A point that takes an item out of the mesh.
    pub(super) fn relieve(&mut self, look: Look<'_>) -> Result<Option<Reason>, RefineError> {
        self.is_relieved = true;
        let mut left = self.own.relief_budget();
        let (mut least, mut stop) = (usize::MAX, None);
        self.forget_reserved(0);
        'passes: for pass in 1..=PASSES {
            let over = self.own.refused_tets();
            if over.is_empty() || over.len() >= least {
                break;
            }
            least = over.len();
            for (t, v) in over {
                let before = self.own.state.mesh.num_vertices();
                if look(before) {
                    stop = Some(Reason::Cancelled);
                }
                let is_spent = self.own.inserted.points.total() >= self.most;
                if stop.is_some() || left == 0 || is_spent {
                    break 'passes;
                }
                if self.own.relieve_tet(t, v, Goal::Bounds, pass, &mut left) {
                    self.note_created();
                    self.script_joint(before);
                }
            }
        }
        if !self.own.state.is_complete() {
            return Err(RefineError::Invariant { what: "relief loses no item of the boundary" });
        }
        // New tetrahedra over their bounds were refused as they were made.
        self.settle();
        Ok(stop)
    }
}
