//! The late steps, when no tetrahedron is left that may be split: those that were refused are asked
//! again, relieved, and asked for shorter edges, and slivers are split. Each is a function of the
//! mesh, and rounds go on wherever it leaves something to split.

use super::{Class, Next, Rounds};
use crate::late::again::Asking;
use crate::late::relief::Goal;
use crate::thin::Thin;
use ltbw_core::topology::TetId;

/// A late step.
#[derive(Clone, Copy)]
enum Step {
    /// Tetrahedra refused because of what no point served are asked again.
    Retry,
    Relief(Goal),
    /// Where many were refused at one corner they are asked for shorter edges.
    Insist,
    Slivers,
}

/// The late steps in their order.
const STEPS: [Step; 7] = [
    Step::Retry,
    Step::Relief(Goal::Bounds),
    Step::Insist,
    Step::Slivers,
    Step::Relief(Goal::Angles),
    Step::Relief(Goal::Bounds),
    // Relief makes room.
    Step::Slivers,
];

/// The memory of the late steps.
#[derive(Debug, Default)]
pub(super) struct Late {
    /// The step to come.
    pub(super) step: usize,
    /// The numbers of points at which refusals for rounding were forgotten.
    pub(super) retried: Vec<u64>,
    pub(super) asking: Asking,
    /// Slivers not yet looked at, when all else is done.
    pub(super) slivers: Option<Vec<Thin>>,
    /// The tetrahedra that may have tiny dihedral angles, if others have looked at all.
    pub(super) thin: Option<Vec<TetId>>,
}

impl Rounds<'_, '_> {
    /// The class of the next round, or relief, when no tetrahedron is left to split; `None` if
    /// nothing is left to do.
    pub(super) fn next_late(&mut self) -> Option<Next> {
        // Every step is bounded by itself, and followed by the next one.
        while let Some(&step) = STEPS.get(self.late.step) {
            let is_asked = match step {
                Step::Retry => self.retry(),
                Step::Insist => self.insist(),
                Step::Slivers if self.has_slivers() => {
                    return Some(Next::Round(Class::Slivers));
                }
                Step::Slivers => {
                    self.late.slivers = None;
                    false
                }
                Step::Relief(goal) => {
                    self.late.step += 1;
                    return Some(Next::Relief(goal));
                }
            };
            if !is_asked {
                self.late.step += 1;
                continue;
            }
            self.find_foremost();
            if !self.front.foremost.is_empty() {
                return Some(Next::Round(Class::Tets));
            }
        }
        None
    }

    /// Asks refused tetrahedra for shorter edges; `false` if there are none, or often enough.
    fn insist(&mut self) -> bool {
        let tets = self.own.insist(&mut self.late.asking);
        self.blocks.clear();
        self.look_at(&tets);
        !tets.is_empty()
    }
}
