//! The view of a submesh for one that keeps more of its vertices and tetrahedra.

use super::{Blocks, LocalMesh, VertexName, WireVertex, blocks, made};
use crate::protocol::{BlockId, Directory, Insert, Walk};
use ltbw_core::cavity::Cavity;
use ltbw_core::submesh::{Earlier, Owns};
use ltbw_core::topology::{INFINITE, TetId, Topology, VertexId};
use ltbw_exact::Point;

/// A refined mesh has this many tetrahedra for each vertex, at least.
pub(crate) const TETS_PER_VERTEX: usize = 5;

/// The cavity found earlier for a point.
pub(crate) struct Again<'a, F> {
    pub(crate) found: &'a [TetId],
    /// Was something written to a slot since then?
    pub(crate) changed: &'a F,
}

impl LocalMesh {
    /// The number here of a vertex; `None` if it has none.
    pub(crate) fn number(&self, name: VertexName) -> Option<VertexId> {
        self.vertices.number(name)
    }

    /// Takes memory for about this many tetrahedra, and what comes with them. A hint.
    pub(crate) fn expect_tets(&mut self, tets: usize) {
        let vertices = tets / TETS_PER_VERTEX;
        self.tets.expect(tets, vertices);
        self.vertices.expect(vertices);
    }

    /// Inserts a point at once, if nothing is in the way; `see` is shown its cavity before that is
    /// filled.
    pub(crate) fn insert_seeing(
        &mut self,
        point: &WireVertex,
        seed: TetId,
        again: Option<Again<'_, impl Fn(TetId) -> bool>>,
        directory: &Directory,
        see: impl FnOnce(&Topology, &Cavity),
    ) -> Insert<TetId> {
        let (v, p) = (self.vertices.number(point.name), point.point());
        if v.is_none() {
            // It has a number here if it becomes a vertex here.
            self.tets.make_vertices(self.vertices.next());
        }
        let Self { tets, vertices, blocks, fixed, me, .. } = self;
        let elsewhere = v.is_none().then(|| blocks.of_name(point.name, &p));
        let number = v.unwrap_or(vertices.next());
        let new_block = || elsewhere.unwrap_or_else(|| vertices.block(number));
        let owns = match fixed {
            None => Owns::By(|[_, a, b, c]: [VertexId; 4]| {
                let [a, b] = [a, b].map(|v| vertices.block(v));
                let c = (c != INFINITE).then(|| vertices.block(c));
                directory.is_mine(blocks::prevailing([new_block(), a, b], c))
            }),
            Some(fixed) => {
                let owner = fixed.owner_of_new(new_block(), *me);
                if owner == *me { Owns::All } else { Owns::None }
            }
        };
        let mut see = Some(see);
        let mut show = |topology: &Topology, cavity: &Cavity| {
            see.take().into_iter().for_each(|see| see(topology, cavity));
        };
        let earlier = again.map(|Again { found, changed }| Earlier { seed, found, changed });
        let insert = match earlier {
            Some(earlier) if tets.insert_again(number, &p, &earlier, owns, &mut show) => {
                Insert::Done
            }
            _ => tets.insert_seeing(number, &p, seed, owns, show),
        };
        match insert {
            Insert::Done => {
                if let Some(block) = elsewhere {
                    self.add_vertex_in(point, block);
                }
                self.forget_removed();
            }
            Insert::Locked(_) | Insert::Blocked => _ = self.located.insert(point.name, seed),
            Insert::Full => self.fail_for_room(),
        }
        insert
    }

    /// The obstacle in the way of a point that is not to be inserted at once: something locked,
    /// or nothing but that. The cavity found is kept for the lock.
    pub(crate) fn probe(&mut self, point: &WireVertex, seed: TetId) -> Insert<TetId> {
        // The number is not used: no star is its submesh's own.
        let number = VertexId::new(1);
        self.tets.insert(number, &point.point(), seed, Owns::None::<fn([VertexId; 4]) -> bool>)
    }

    /// Is a tetrahedron in conflict with a point?
    pub(crate) fn conflicts(&mut self, t: TetId, p: &Point) -> bool {
        self.tets.in_conflict(t, p)
    }

    /// The cavity of a point, from a tetrahedron in conflict with it on, if its whole closure is
    /// here and unlocked.
    pub(crate) fn cavity_of(&mut self, seed: TetId, p: &Point) -> Option<&[TetId]> {
        self.tets.search(seed, p, &mut self.search).then(|| self.search.tets())
    }

    /// Looks for a tetrahedron in conflict with a point, from one here on.
    pub(crate) fn seek(&mut self, p: &Point, from: Option<TetId>) -> Walk<TetId> {
        self.tets.walk(INFINITE, p, from)
    }

    /// Its blocks.
    pub(crate) fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    /// The key of a place along the curve.
    pub(crate) fn key(&self, p: &Point) -> u64 {
        self.blocks.key(p)
    }

    /// The block of a vertex that would be made at a place.
    pub(crate) fn block_at(&self, p: &Point) -> BlockId {
        self.blocks.of_name(made(self.me, 1), p)
    }

    /// The finite vertices of a cavity that is described by some pieces.
    pub(crate) fn names_of(vertices: impl Iterator<Item = VertexName>) -> Vec<u64> {
        super::finite(vertices.collect())
    }
}
