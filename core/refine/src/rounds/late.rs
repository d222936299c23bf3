//! The late steps, when no tetrahedron is left that may be split: those that were refused are asked
//! again, relieved, and asked for shorter edges, and slivers are split. Each is a function of the
//! mesh, and rounds go on wherever it leaves something to split.

use super::{Class, Next, Rounds};
use crate::late::relief::Goal;

/// A late step.
#[derive(Clone, Copy)]
enum Late {
    /// Tetrahedra refused because of what no point served are asked again.
    Retry,
    Relief(Goal),
    /// Where many were refused at one corner they are asked for shorter edges.
    Insist,
    Slivers,
}

/// The late steps in their order.
const STEPS: [Late; 6] = [
    Late::Retry,
    Late::Relief(Goal::Bounds),
    Late::Insist,
    Late::Slivers,
    Late::Relief(Goal::Angles),
    Late::Relief(Goal::Bounds),
];

impl Rounds<'_, '_> {
    /// The class of the next round, or relief, when no tetrahedron is left to split; `None` if
    /// nothing is left to do.
    pub(super) fn next_late(&mut self) -> Option<Next> {
        // Every step is bounded by itself, and followed by the next one.
        while let Some(&step) = STEPS.get(self.late) {
            let is_asked = match step {
                Late::Retry => self.retry(),
                Late::Insist => self.insist(),
                Late::Slivers if self.has_slivers() => {
                    return Some(Next::Round(Class::Slivers));
                }
                Late::Slivers => false,
                Late::Relief(goal) => {
                    self.late += 1;
                    return Some(Next::Relief(goal));
                }
            };
            if !is_asked {
                self.late += 1;
                continue;
            }
            self.find_foremost();
            if !self.foremost.is_empty() {
                return Some(Next::Round(Class::Tets));
            }
        }
        None
    }

    /// Asks refused tetrahedra for shorter edges; `false` if there are none, or often enough.
    fn insist(&mut self) -> bool {
        let tets = self.own.insist(&mut self.asking);
        self.blocks.clear();
        self.look_at(&tets);
        !tets.is_empty()
    }
}
