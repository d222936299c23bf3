//! Subfaces that bar many tetrahedra of a round.
//!
//! Where thousands of tetrahedra have their centres in one place, as in a ball, a few subfaces that
//! may not be split bar the points of all of them. To open a cavity of thousands of tetrahedra for
//! each only to find the same subfaces takes the time of its square. So the first refusal of a
//! round leaves its subfaces behind, and a tetrahedron whose point would take one of them out of
//! the mesh is refused in its turn at the cost of two tests.

use super::Rounds;
use crate::refine::item::Item;
use crate::refine::marks::{FACES, face_bit};
use crate::refine::outcome::Reason;
use crate::refine::state::FACE;
use crate::refine::table::triangle;
use ltbw_core::topology::{TetId, VertexId, tet_of};
use ltbw_exact::Point;

/// The most subfaces of a round that are kept.
const MOST: usize = 16;

/// A subface that may not be split.
#[derive(Debug)]
pub(super) struct Block {
    corners: [VertexId; 3],
    /// The tetrahedra on both sides of it.
    sides: [TetId; 2],
}

impl Rounds<'_, '_> {
    /// Keeps the subfaces that the refused point of the last candidate would take out of the mesh,
    /// if they may not be split under its limit.
    pub(super) fn note_blocks(&mut self, limit: Option<f64>) {
        let Some(own) = self.candidates.last() else { return };
        if self.blocks.len() >= MOST || self.own.state.touched.inner.is_empty() {
            return;
        }
        let topology = self.own.state.mesh.topology();
        let touched = &self.own.state.touched;
        let mut found = Vec::new();
        for &t in &self.cavities[own.cavity.clone()] {
            let word = self.own.state.marks.of(t);
            let tet = topology.at(t);
            for slot in (0..4).filter(|&slot| word & FACES & face_bit(slot) != 0) {
                let [a, b, c] = FACE[slot].map(|k| tet.vertices()[k]);
                let corners = triangle(a, b, c);
                let is_lost = touched.inner.iter().any(|&(s, _)| s == corners);
                let sides = [t, tet_of(tet.neighbours()[slot])];
                // Each is met from both sides.
                if is_lost
                    && sides[0] < sides[1]
                    && self.own.record.bars(&Item::Subface(corners), limit).is_some()
                {
                    found.push(Block { corners, sides });
                }
            }
        }
        let place = |block: &Block| self.own.state.place_of(Item::Subface(block.corners));
        found.sort_by_cached_key(place);
        found.truncate(MOST - self.blocks.len());
        self.blocks.extend(found);
    }

    /// The reason why a tetrahedron with the point `p` is refused, if that would take a subface out
    /// of the mesh that others were refused for in this round.
    pub(super) fn blocked(&mut self, p: &Point, v: [VertexId; 4]) -> Option<Reason> {
        let mesh = &mut self.own.state.mesh;
        let mut lost =
            self.blocks.iter().filter(|b| b.sides.iter().all(|&t| mesh.in_conflict(t, p)));
        lost.next()?;
        Some(self.own.state.reason_near(v))
    }
}
