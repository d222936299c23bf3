//! Subfaces that bar many tetrahedra of a round.
//!
//! Where thousands of tetrahedra have their centres in one place, as in a ball, a few subfaces that
//! may not be split bar the points of all of them. To open a cavity of thousands of tetrahedra for
//! each only to find the same subfaces takes the time of its square. So a refusal leaves these
//! subfaces behind, and from then on a tetrahedron whose point would take one of them out of the
//! mesh is refused by two tests.

use super::Rounds;
use super::foremost::Foremost;
use crate::mesh::item::Item;
use crate::mesh::limit::Limit;
use crate::mesh::marks::{FACES, face_bit};
use crate::mesh::state::FACE;
use crate::mesh::survey::Survey;
use crate::outcome::Reason;
use crate::rules::aim::{Aim, at_centre};
use crate::rules::walk::Way;
use crate::table::triangle;
use crate::thin::Thin;
use ltbw_core::topology::{TetId, VertexId, tet_of};
use ltbw_exact::Point;

/// The most subfaces that one refusal leaves behind, and the most that are kept.
const MOST: [usize; 2] = [4, 64];

/// A subface that may not be split.
#[derive(Debug)]
pub(super) struct Block {
    corners: [VertexId; 3],
    /// The tetrahedra on both sides of it, with their vertices: others may have the subface, too,
    /// and one of their slots.
    sides: [Thin; 2],
}

/// The subfaces that tetrahedra were refused for.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    /// In earlier rounds.
    kept: Vec<Block>,
    /// In this one.
    pub(super) found: Vec<Block>,
}

impl Blocks {
    /// Are there none?
    pub(super) fn are_none(&self) -> bool {
        self.kept.is_empty() && self.found.is_empty()
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.kept.clear();
        self.found.clear();
    }
}

impl Rounds<'_, '_> {
    /// The subfaces that a refused point would take out of the mesh, of the boundary in its cavity,
    /// if they may not be split under its limit.
    pub(super) fn blocks_in(
        &self,
        tets: &[TetId],
        survey: &Survey<TetId>,
        limit: Option<Limit>,
    ) -> Vec<Block> {
        if survey.inner().next().is_none() {
            return Vec::new();
        }
        let topology = self.own.state.mesh.topology();
        let mut found = Vec::new();
        for &t in tets {
            let word = self.own.state.marks.of(t);
            let tet = topology.at(t);
            for slot in (0..4).filter(|&slot| word & FACES & face_bit(slot) != 0) {
                let [a, b, c] = FACE[slot].map(|k| tet.vertices()[k]);
                let corners = triangle(a, b, c);
                let is_lost = survey.inner().any(|face| face.key == corners);
                let sides = [t, tet_of(tet.neighbours()[slot])];
                // Beside dust of a patch others may become subfaces in its place.
                let is_fixed =
                    !sides.iter().any(|&t| self.own.state.is_flat(self.own.state.vertices(t)));
                // Each is met from both sides.
                if is_lost
                    && is_fixed
                    && sides[0] < sides[1]
                    && self.own.record.bars(&Item::Subface(corners), limit).is_some()
                {
                    let sides = sides.map(|t| (t, self.own.state.vertices(t)));
                    found.push(Block { corners, sides });
                }
            }
        }
        let place = |block: &Block| self.own.state.place_of(Item::Subface(block.corners));
        found.sort_by_cached_key(place);
        found.truncate(MOST[0]);
        found
    }

    /// Forgets subfaces that are gone, or may be split, or have another tetrahedron beside them.
    pub(super) fn check_blocks(&mut self) {
        let Self { blocks: Blocks { kept: blocks, .. }, own, .. } = self;
        let (state, record) = (&own.state, &own.record);
        blocks.retain(|block| {
            block.sides.iter().all(|&(t, v)| state.is_live(t, v))
                && state.subfaces.contains_key(&block.corners)
                && record.refused.contains_key(&Item::Subface(block.corners))
        });
    }

    /// Adds the subfaces that were found in this round to those that are kept, and refuses those of
    /// the foremost that they bar and that were not probed.
    pub(super) fn refuse_blocked(&mut self) {
        let mut found = std::mem::take(&mut self.blocks.found);
        found.retain(|block| self.blocks.kept.iter().all(|other| other.corners != block.corners));
        found.sort_by_cached_key(|b| self.own.state.place_of(Item::Subface(b.corners)));
        found.dedup_by_key(|block| block.corners);
        found.truncate(MOST[1].saturating_sub(self.blocks.kept.len()));
        self.blocks.kept.append(&mut found);
        if self.blocks.kept.is_empty() {
            return;
        }
        let followers: Vec<Foremost> = self.followers().copied().collect();
        for own in followers {
            let aim = at_centre(own.shape.radius(), own.centre, 0);
            if let Aim::At { point: p, may: true, .. } = aim
                && let Way::Arrived(_) = self.own.state.way(own.t, &p)
                && let Some(reason) = self.blocked(&p, &own)
            {
                self.refuse(Item::Tet(own.t, self.own.state.vertices(own.t)), reason);
            }
        }
    }

    /// The reason why a tetrahedron with the point `p` is refused, if that would take a subface out
    /// of the mesh that others were refused for.
    pub(super) fn blocked(&self, p: &Point, own: &Foremost) -> Option<Reason> {
        let mesh = &self.own.state.mesh;
        let is_lost = |block: &&Block| block.sides.iter().all(|&(t, _)| mesh.in_conflict(t, p));
        let lost: Vec<Item> =
            self.blocks.kept.iter().filter(is_lost).map(|b| Item::Subface(b.corners)).collect();
        if lost.is_empty() {
            return None;
        }
        // It may be split for a shorter edge than those before allowed.
        let limit = self.limit(own.t, &own.shape);
        let root = lost.iter().find_map(|item| self.own.record.bars(item, limit))?;
        match self.own.state.reason_near(own.corners) {
            Reason::Rounding => Some(root),
            named => Some(named),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Block;
    use crate::Refiner;
    use crate::mesh::item::Item;
    use crate::mesh::marks::face_bit;
    use crate::mesh::state::FACE;
    use crate::outcome::{Reason, RefineStats};
    use crate::rounds::{InsertOrder, Rounds};
    use crate::rules::record::Refusal;
    use crate::table::triangle;
    use crate::tests::ready;
    use ltbw_core::topology::{TetId, VertexId, tet_of};
    use ltbw_generate::{DomainKind, Shape};

    /// A tetrahedron over its bounds with a subface between two regions, and the one behind it.
    fn beside_two_regions(rounds: &Rounds<'_, '_>) -> Option<(TetId, [VertexId; 3], TetId)> {
        let state = &rounds.own.state;
        rounds.keys.entries().find_map(|t| {
            let tet = state.mesh.topology().at(t);
            let slot = (0..4).find(|&slot| {
                let other = tet_of(tet.neighbours()[slot]);
                state.marks.of(t) & face_bit(slot) != 0
                    && !state.mesh.topology().at(other).is_ghost()
            })?;
            let corners = FACE[slot].map(|k| tet.vertices()[k]);
            Some((t, corners, tet_of(tet.neighbours()[slot])))
        })
    }

    /// Tells rounds before their first choice, and what [`beside_two_regions`] finds there.
    fn with_block(tell: impl FnOnce(&mut Rounds<'_, '_>, (TetId, [VertexId; 3], TetId))) {
        let ready = ready(DomainKind::TwoMaterial, &Shape::default());
        let refiner = Refiner::new().max_volume(1e-3);
        let (mut run, _) = refiner.recovered(&ready.domain, &ready.lattice).expect("a mesh");
        let (own, stats) = (&mut run.refinement, RefineStats::default());
        let mut rounds = Rounds::new(own, InsertOrder::Hilbert, u64::MAX, stats);
        rounds.look_at_all();
        rounds.find_foremost();
        let found = beside_two_regions(&rounds).expect("a subface between two regions");
        tell(&mut rounds, found);
    }

    #[test]
    fn a_block_bars_no_tetrahedron_that_allows_shorter_edges() {
        with_block(|rounds, (t, corners, other)| {
            // Its centroid is in the balls on both sides.
            let points = corners.map(|v| rounds.own.state.at(v));
            let p = [0, 1, 2].map(|k| points.iter().map(|p| p[k] / 3.0).sum::<f64>().round());
            let [a, b, c] = corners;
            let corners = triangle(a, b, c);
            let own = rounds.own.state.foremost_at(t, 1);
            let sides = [t, other].map(|t| (t, rounds.own.state.vertices(t)));
            rounds.blocks.kept.push(Block { corners, sides });
            let limit = rounds.limit(t, &own.shape).expect("bounds");
            let item = Item::Subface(corners);
            for (factor, is_barred) in [(0.5, true), (1.0, true), (2.0, false)] {
                let refusal = Refusal { reason: Reason::Floor, limit: Some(limit.times(factor)) };
                rounds.own.record.refused.insert(item, refusal);
                assert_eq!(rounds.blocked(&p, &own).is_some(), is_barred, "{factor}");
            }
            rounds.own.record.refused.insert(item, Refusal::final_for(Reason::Floor));
            assert!(rounds.blocked(&p, &own).is_some());
        });
    }

    /// Which slot a tetrahedron gets depends on the order of insertion: one that has a block's
    /// corners, too, and the slot of one of its sides, may have it in one order alone.
    #[test]
    fn a_block_is_forgotten_with_its_tetrahedra_whoever_has_their_slots() {
        with_block(|rounds, (t, corners, other)| {
            let [a, b, c] = corners;
            let corners = triangle(a, b, c);
            let item = Item::Subface(corners);
            rounds.own.record.refused.insert(item, Refusal::final_for(Reason::Floor));
            let sides = [t, other].map(|t| (t, rounds.own.state.vertices(t)));
            rounds.blocks.kept.push(Block { corners, sides });
            rounds.check_blocks();
            assert_eq!(rounds.blocks.kept.len(), 1, "both are there");
            // The one that was here had another apex.
            let apex = |v: [VertexId; 4]| (0..4).find(|&k| !corners.contains(&v[k]));
            let [mut gone, stays] = sides;
            let [k, j] = [gone, stays].map(|(_, v)| apex(v).expect("an apex"));
            gone.1[k] = stays.1[j];
            rounds.blocks.kept[0].sides = [gone, stays];
            rounds.check_blocks();
            assert!(rounds.blocks.kept.is_empty(), "kept by its slot");
        });
    }
}
