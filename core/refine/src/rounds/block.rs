//! Blocks on one mesh: each is kept with its item, and the tetrahedra on both sides of it.

use super::Rounds;
use super::foremost::Foremost;
use crate::mesh::item::Item;
use crate::mesh::state::{FACE, State};
use crate::outcome::Reason;
use crate::rules::aim::{Aim, at_centre};
use crate::rules::block::{Block, KeptBlock};
use crate::rules::walk::Way;
use crate::table::triangle;
use crate::thin::Thin;
use ltbw_core::topology::TetId;
use ltbw_exact::Point;

/// A block in the mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Here {
    pub(crate) item: Item,
    /// The tetrahedra on both sides, with their vertices: others may have one of their slots.
    pub(crate) sides: [Thin; 2],
}

impl State {
    /// A block with its item, which a tetrahedron has; none if others are beside that by now.
    pub(crate) fn block_at(&self, block: &Block, item: Item, near: TetId) -> Option<Here> {
        let Item::Subface(corners) = item else { return None };
        let v = self.vertices(near);
        let slot = (0..4).find(|&slot| {
            let [a, b, c] = FACE[slot].map(|k| v[k]);
            triangle(a, b, c) == corners
        })?;
        let beyond = self.neighbours(near)[slot];
        let sides = [near, beyond].map(|t| (t, self.vertices(t)));
        let own = Block::new(corners, sides.map(|own| own.1), |v| self.at(v));
        own.is_same(block).then_some(Here { item, sides })
    }
}

impl Rounds<'_, '_> {
    /// The blocks that are left, for others.
    pub(crate) fn blocks_left(&self) -> Vec<Block> {
        let state = &self.own.state;
        let is_left =
            |own: &&KeptBlock<Here>| own.here.sides.iter().all(|&(t, v)| state.is_live(t, v));
        self.blocks.kept().iter().filter(is_left).map(|own| own.block.clone()).collect()
    }

    /// Forgets subfaces that are gone, or may be split, or have another tetrahedron beside them.
    pub(super) fn check_blocks(&mut self) {
        let Self { blocks, own, .. } = self;
        let (state, record) = (&own.state, &own.record);
        blocks.retain(|own| {
            let Here { item, sides } = &own.here;
            sides.iter().all(|&(t, v)| state.is_live(t, v)) && record.refused.contains_key(item)
        });
    }

    /// Adds the subfaces that were found in this round to those that are kept, and refuses those of
    /// the foremost that they bar and that were not probed.
    pub(super) fn refuse_blocked(&mut self) {
        if !self.blocks.keep() {
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
        let is_lost =
            |kept: &KeptBlock<Here>| kept.here.sides.iter().all(|&(t, _)| mesh.in_conflict(t, p));
        let bars = |kept: &KeptBlock<Here>| {
            self.own.record.bars(&kept.here.item, self.limit(own.t, &own.shape))
        };
        self.blocks.refuse(is_lost, bars, || self.own.state.reason_near(own.corners))
    }
}

#[cfg(test)]
mod tests {
    use super::{Block, Here};
    use crate::Refiner;
    use crate::mesh::item::Item;
    use crate::mesh::marks::face_bit;
    use crate::mesh::state::FACE;
    use crate::outcome::{Reason, RefineStats};
    use crate::rounds::{InsertOrder, Rounds};
    use crate::rules::block::{Blocks, KeptBlock};
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

    /// Keeps a block between two tetrahedra.
    fn keep(rounds: &mut Rounds<'_, '_>, corners: [VertexId; 3], sides: [TetId; 2]) -> Here {
        let state = &rounds.own.state;
        let sides = sides.map(|t| (t, state.vertices(t)));
        let block = Block::new(corners, sides.map(|own| own.1), |v| state.at(v));
        let here = Here { item: Item::Subface(corners), sides };
        assert!(state.block_at(&block, here.item, sides[0].0).is_some(), "it is found again");
        rounds.blocks = Blocks::of(vec![KeptBlock { block, here }]);
        here
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
            keep(rounds, corners, [t, other]);
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
            let sides = keep(rounds, corners, [t, other]).sides;
            rounds.check_blocks();
            assert_eq!(rounds.blocks.kept().len(), 1, "both are there");
            // The one that was here had another apex.
            let apex = |v: [VertexId; 4]| (0..4).find(|&k| !corners.contains(&v[k]));
            let [mut gone, stays] = sides;
            let [k, j] = [gone, stays].map(|(_, v)| apex(v).expect("an apex"));
            gone.1[k] = stays.1[j];
            let KeptBlock { block, here } = rounds.blocks.kept()[0].clone();
            let here = Here { sides: [gone, stays], ..here };
            rounds.blocks = Blocks::of(vec![KeptBlock { block, here }]);
            rounds.check_blocks();
            assert!(rounds.blocks.kept().is_empty(), "kept by its slot");
        });
    }
}
