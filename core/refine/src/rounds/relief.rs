//! Relief in rounds: one point after the other, when nothing is left but slivers.
//!
//! Tetrahedra are taken in the order of their coordinates, so that relief is the same whatever the
//! order in rounds was.

use super::{Look, Rounds};
use crate::RefineError;
use crate::late::relief::{Goal, Relief};
use crate::outcome::Reason;

impl Rounds<'_, '_> {
    /// Relieves the tetrahedra over their bounds while that makes them fewer. Returns why it
    /// stopped early: when the work was cancelled.
    ///
    /// # Errors
    /// A point that takes an item out of the mesh.
    pub(super) fn relieve(
        &mut self,
        goal: Goal,
        look: Look<'_>,
    ) -> Result<Option<Reason>, RefineError> {
        self.reserved.start(0, 0);
        let mut relief = Relief::new(goal, self.own);
        let mut stop = None;
        while self.own.inserted.points.total() < self.most {
            if look(self.own.state.mesh.num_vertices()) {
                stop = Some(Reason::Cancelled);
                break;
            }
            let Some(is_relieved) = relief.next(self.own) else { break };
            if is_relieved {
                self.note_created();
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
