//! The vertex closure of a cavity: all tetrahedra that touch it.

use super::LocalMesh;
use super::WireVertex;
use super::name::{NOWHERE, VertexName};
use crate::protocol::{Insert, Submesh};
use ltbw_core::topology::{TetId, VertexId, tet_of};
use rustc_hash::FxHashSet;

impl LocalMesh {
    /// The neighbours of `t` across faces that have one of `corners`.
    pub(super) fn around(&self, t: TetId, corners: &[VertexName]) -> impl Iterator<Item = TetId> {
        let names = self.tets.vertices(t).map(|v| self.vertices.name(v));
        let is_corner = names.map(|name| corners.binary_search(&name).is_ok());
        let others = move |slot: usize| (1..4).any(|k| is_corner[(slot + k) % 4]);
        let neighbours = self.tets.neighbours(t).map(tet_of).into_iter().enumerate();
        neighbours.filter(move |&(slot, _)| others(slot)).map(|(_, u)| u)
    }

    /// The obstacle in the vertex closure of `point` to inserting it at once: a locked tetrahedron,
    /// else another worker's.
    pub(super) fn vertex_closure(
        &mut self,
        point: &WireVertex,
        seed: TetId,
    ) -> Option<Insert<TetId>> {
        let (mut seen, mut far, mut locked) = (FxHashSet::default(), false, None);
        let mut corners: Vec<VertexId> = self.tets.vertices(seed).to_vec();
        let mut cavity = vec![seed];
        seen.insert(seed);
        // The cavity; then, from it on, what touches it.
        let mut next = 0;
        while let Some(&t) = cavity.get(next) {
            next += 1;
            for u in self.tets.neighbours(t).map(tet_of) {
                if self.tets.far(u).is_some() {
                    far = true;
                } else if self.in_conflict(u, point) && seen.insert(u) {
                    corners.extend(self.tets.vertices(u));
                    cavity.push(u);
                }
            }
        }
        let corners = finite(corners.into_iter().map(|v| self.vertices.name(v)).collect());
        let mut all = cavity;
        while let Some(t) = all.pop() {
            if self.tets.holder(t).is_some() {
                locked = locked.or(Some(Insert::Locked(t)));
            }
            for u in self.around(t, &corners) {
                if self.tets.far(u).is_some() {
                    far = true;
                } else if seen.insert(u) {
                    all.push(u);
                }
            }
        }
        locked.or(far.then_some(Insert::Blocked))
    }
}

/// The finite ones of some vertices, each once, ascending.
pub(super) fn finite(mut vertices: Vec<VertexName>) -> Vec<VertexName> {
    vertices.retain(|&v| v != NOWHERE);
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}
