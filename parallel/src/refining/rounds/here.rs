//! A closure that is all one worker's, as a survey reads it.

use super::serve::LookedAt;
use crate::refining::domain::DomainMesh;
use ltbw_core::topology::{INFINITE, TetId, VertexId, tet_of};
use ltbw_refine::{Corner, NOWHERE, Surveyed};
use rustc_hash::FxHashSet;
use std::collections::BTreeSet;

/// Tetrahedra that are looked through as fast as looked up.
const FEW: usize = 48;

/// A cavity, and the tetrahedra around it.
#[derive(Debug)]
pub(super) struct Here<'m, 'c> {
    pub(super) mesh: &'m DomainMesh<'c>,
    pub(super) cavity: &'m [TetId],
    /// The tetrahedra of a large cavity: at flat surfaces there are thousands.
    known: Option<FxHashSet<TetId>>,
}

impl<'m, 'c> Here<'m, 'c> {
    pub(super) fn of(mesh: &'m DomainMesh<'c>, cavity: &'m [TetId]) -> Self {
        let known = (cavity.len() > FEW).then(|| cavity.iter().copied().collect());
        Self { mesh, cavity, known }
    }

    /// The closure, each tetrahedron once.
    pub(super) fn listed(&self) -> Vec<LookedAt> {
        let around = self.cavity.iter().flat_map(|&t| self.mesh.inner.tets().neighbours(t));
        let ring: BTreeSet<TetId> = around.map(tet_of).filter(|&t| !self.is_in(t)).collect();
        let inside = self.cavity.iter().map(|&t| LookedAt { t, is_in: true });
        inside.chain(ring.into_iter().map(|t| LookedAt { t, is_in: false })).collect()
    }
}

impl Surveyed for Here<'_, '_> {
    type Tet = TetId;

    fn cavity(&self) -> impl Iterator<Item = TetId> {
        self.cavity.iter().copied()
    }

    fn is_in(&self, t: TetId) -> bool {
        match &self.known {
            None => self.cavity.contains(&t),
            Some(known) => known.contains(&t),
        }
    }

    fn vertices(&self, t: TetId) -> [u32; 4] {
        let v = self.mesh.inner.tets().vertices(t);
        v.map(|v| if v == INFINITE { NOWHERE } else { v.number() })
    }

    fn bound(&self, t: TetId) -> [bool; 4] {
        self.mesh.inner.tets().vertices(t).map(|v| self.mesh.is_bound(v))
    }

    fn corner(&self, v: u32) -> Corner {
        self.mesh.corner(VertexId::new(v))
    }

    fn region(&self, t: TetId) -> u32 {
        self.mesh.region(t)
    }

    fn beyond(&self, t: TetId, slot: usize) -> Option<TetId> {
        Some(tet_of(self.mesh.inner.tets().neighbours(t)[slot]))
    }
}
