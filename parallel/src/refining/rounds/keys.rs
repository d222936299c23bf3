//! One worker's tetrahedra over their bounds, and which of them come before all around them.
//!
//! The tetrahedra around one are its face neighbours and the face neighbours of these. Where they
//! are another worker's, two exchanges tell: first the ranks of the tetrahedra at interface faces,
//! then the best rank around each of these.

use crate::protocol::{Directory, Handle, Name, Rules, Submesh, WorkerId};
use crate::refining::domain::DomainMesh;
use ltbw_core::topology::{INFINITE, TetId, VertexId, tet_of};
use ltbw_domain::refine::Rank;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// A tetrahedron over its bounds, with its vertices and its rank.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bad {
    pub(super) corners: [VertexId; 4],
    pub(super) rank: Rank,
}

/// The news for each worker at an interface face: its tetrahedron and face, and a rank.
pub(super) type Told = BTreeMap<WorkerId, Vec<(Name, u8, Rank)>>;

/// The tetrahedra over their bounds.
#[derive(Debug, Default)]
pub(super) struct Keys {
    bad: FxHashMap<TetId, Bad>,
    /// By own tetrahedron and face: the rank beyond, and the best one around that.
    beyond: [FxHashMap<(TetId, u8), Rank>; 2],
    /// The interface faces, as seen from here.
    interface: Vec<(TetId, usize, Handle)>,
}

fn best(ranks: impl Iterator<Item = Rank>) -> Option<Rank> {
    ranks.min()
}

impl Keys {
    /// Looks at new tetrahedra.
    pub(super) fn look_at<C: Rules>(&mut self, mesh: &DomainMesh<'_>, tets: &[TetId]) {
        for &t in tets {
            self.bad.remove(&t);
            let topology = mesh.inner.tets();
            if !topology.is_live(t) || topology.vertices(t)[3] == INFINITE {
                continue;
            }
            let corners = topology.vertices(t);
            let points = corners.map(|v| mesh.point(v));
            if mesh.complex.is_over(points.each_ref(), mesh.region(t)) {
                // R22.
                let rank = match C::RANKS_BY_PLACE {
                    true => Rank::of_tet(points),
                    false => Rank::of_tet(corners.map(|v| [f64::from(v.number()), 0.0, 0.0])),
                };
                self.bad.insert(t, Bad { corners, rank });
            }
        }
    }

    /// Forgets those that are gone, and what was told; finds the interface faces.
    pub(super) fn start(&mut self, mesh: &DomainMesh<'_>) {
        let tets = mesh.inner.tets();
        self.bad.retain(|&t, own| tets.is_live(t) && tets.vertices(t) == own.corners);
        self.beyond.iter_mut().for_each(FxHashMap::clear);
        self.interface.clear();
        for (t, _) in tets.tets() {
            for (slot, face) in tets.neighbours(t).into_iter().enumerate() {
                if let Some(handle) = tets.far(tet_of(face)) {
                    self.interface.push((t, slot, handle));
                }
            }
        }
    }

    /// Interface faces.
    pub(super) fn interface_faces(&self) -> usize {
        self.interface.len()
    }

    /// The tetrahedron over its bounds in a slot.
    pub(super) fn at(&self, t: TetId) -> Option<&Bad> {
        self.bad.get(&t)
    }

    fn rank(&self, t: TetId) -> Option<Rank> {
        self.bad.get(&t).map(|own| own.rank)
    }

    /// The rank of the tetrahedron in slot `t`, or of the one beyond face `slot` of `from`, if `t`
    /// stands for that.
    fn rank_beside(
        &self,
        mesh: &DomainMesh<'_>,
        (from, slot): (TetId, usize),
        t: TetId,
    ) -> Option<Rank> {
        match mesh.inner.tets().far(t) {
            Some(_) => self.beyond[0].get(&(from, slot as u8)).copied(),
            None => self.rank(t),
        }
    }

    /// The news for others in an exchange, an entry for each worker that has a tetrahedron beside
    /// one of this worker.
    pub(super) fn told(
        &self,
        mesh: &DomainMesh<'_>,
        directory: &Directory,
        exchange: usize,
    ) -> Told {
        let mut told = Told::new();
        for &(t, slot, handle) in &self.interface {
            let entry = told.entry(directory.owner(handle.block)).or_default();
            let rank = match exchange {
                0 => self.rank(t),
                _ => {
                    let around = mesh.inner.tets().neighbours(t).into_iter().enumerate();
                    let others = around.filter(|&(k, _)| k != slot);
                    best(
                        others.filter_map(|(k, face)| self.rank_beside(mesh, (t, k), tet_of(face))),
                    )
                }
            };
            entry.extend(rank.map(|rank| (handle.name, handle.face, rank)));
        }
        told
    }

    /// Takes what another worker tells.
    pub(super) fn hear(
        &mut self,
        mesh: &DomainMesh<'_>,
        exchange: usize,
        keys: Vec<(Name, u8, Rank)>,
    ) {
        for (name, face, rank) in keys {
            if let Some(t) = mesh.resolve(name) {
                self.beyond[exchange].insert((t, face), rank);
            }
        }
    }

    /// The tetrahedra that come before all around them, those at interface faces first: others are
    /// waited for there.
    pub(super) fn foremost(&self, mesh: &DomainMesh<'_>) -> Vec<TetId> {
        let mut all: Vec<(bool, TetId)> = Vec::new();
        for (&t, own) in &self.bad {
            let tets = mesh.inner.tets();
            let neighbours = tets.neighbours(t).map(tet_of);
            let is_before = |rank: Option<Rank>| rank.is_some_and(|rank| rank < own.rank);
            let mut near = neighbours.into_iter().enumerate();
            if near.any(|(slot, n)| is_before(self.rank_beside(mesh, (t, slot), n))) {
                continue;
            }
            let mut near = neighbours.into_iter().enumerate();
            let is_beaten = near.any(|(slot, n)| match tets.far(n) {
                Some(_) => is_before(self.beyond[1].get(&(t, slot as u8)).copied()),
                None => {
                    let around = tets.neighbours(n).into_iter().enumerate();
                    let mut ranks =
                        around.map(|(k, face)| self.rank_beside(mesh, (n, k), tet_of(face)));
                    ranks.any(is_before)
                }
            });
            if !is_beaten {
                let is_inner = neighbours.into_iter().all(|n| tets.far(n).is_none());
                all.push((is_inner, t));
            }
        }
        all.sort_unstable();
        all.into_iter().map(|(_, t)| t).collect()
    }
}
