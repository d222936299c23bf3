//! Subfaces that bar many tetrahedra of a round.
//!
//! Where thousands of tetrahedra have their centres in one place, as in a ball, a few subfaces that
//! may not be split bar the points of all of them. To open a cavity of thousands of tetrahedra for
//! each only to find the same subfaces takes the time of its square. So a refusal leaves these
//! subfaces behind, and from then on a tetrahedron whose point would take one of them out of the
//! mesh is refused by two tests.

use super::Rounds;
use super::foremost::Foremost;
use crate::refine::carrier::free_point;
use crate::refine::item::Item;
use crate::refine::marks::{FACES, face_bit};
use crate::refine::outcome::Reason;
use crate::refine::split::TOLERANCE;
use crate::refine::state::FACE;
use crate::refine::table::triangle;
use crate::refine::walk::Way;
use ltbw_core::topology::{TetId, VertexId, tet_of};
use ltbw_exact::Point;

/// The most subfaces that one refusal leaves behind, and the most that are kept.
const MOST: [usize; 2] = [4, 64];

/// A subface that may not be split.
#[derive(Debug)]
pub(super) struct Block {
    corners: [VertexId; 3],
    /// The tetrahedra on both sides of it.
    sides: [TetId; 2],
}

impl Rounds<'_, '_> {
    /// Notes the subfaces that the refused point of the last candidate would take out of the mesh,
    /// if they may not be split under its limit.
    pub(super) fn note_blocks(&mut self, limit: Option<f64>) {
        let Some(own) = self.candidates.last() else { return };
        if self.own.state.touched.inner.is_empty() {
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
        found.truncate(MOST[0]);
        self.new_blocks.extend(found);
    }

    /// Forgets subfaces that are gone, or may be split, or have another tetrahedron beside them.
    pub(super) fn check_blocks(&mut self) {
        let Self { blocks, own, .. } = self;
        let (state, record) = (&own.state, &own.record);
        blocks.retain(|block| {
            let stays = |&t: &TetId| {
                let v = state.vertices(t);
                block.corners.iter().all(|c| v.contains(c))
            };
            block.sides.iter().all(stays)
                && state.subfaces.contains_key(&block.corners)
                && record.refused.contains_key(&Item::Subface(block.corners))
        });
    }

    /// Adds the subfaces that were found in this round to those that are kept, and refuses those of
    /// the foremost that they bar and that were not probed.
    pub(super) fn refuse_blocked(&mut self) {
        let mut found = std::mem::take(&mut self.new_blocks);
        found.retain(|block| self.blocks.iter().all(|other| other.corners != block.corners));
        found.sort_by_cached_key(|b| self.own.state.place_of(Item::Subface(b.corners)));
        found.dedup_by_key(|block| block.corners);
        found.truncate(MOST[1].saturating_sub(self.blocks.len()));
        self.blocks.append(&mut found);
        if self.blocks.is_empty() {
            return;
        }
        let followers: Vec<Foremost> = self.followers().copied().collect();
        for own in followers {
            let tolerance = own.shape.radius() * TOLERANCE;
            let point = own.centre.and_then(|centre| free_point(&centre, tolerance));
            let arrives = |p: &Point| matches!(self.own.state.way(own.t, p), Way::Arrived(_));
            if let Some(p) = point.filter(arrives)
                && let Some(reason) = self.blocked(&p, &own)
            {
                self.refuse(Item::Tet(own.t, self.own.state.vertices(own.t)), reason);
            }
        }
    }

    /// The reason why a tetrahedron with the point `p` is refused, if that would take a subface out
    /// of the mesh that others were refused for.
    pub(super) fn blocked(&mut self, p: &Point, own: &Foremost) -> Option<Reason> {
        let mesh = &mut self.own.state.mesh;
        let mut lost =
            self.blocks.iter().filter(|b| b.sides.iter().all(|&t| mesh.in_conflict(t, p)));
        lost.next()?;
        Some(self.own.state.reason_near(own.corners))
    }
}
