//! One worker's tetrahedra by their ranks.

use crate::protocol::Rules;
use crate::refining::domain::DomainMesh;
use ltbw_core::Point;
use ltbw_core::topology::{TetId, VertexId, tet_of};
use ltbw_refine::{Rank, Ranked};
use std::marker::PhantomData;

/// A tetrahedron, and its vertices.
pub(super) type Own = (TetId, [VertexId; 4]);

/// The places by which a tetrahedron with these corners is ranked.
#[inline(always)]
pub(super) fn places_of<C: Rules>(mesh: &DomainMesh<'_>, corners: [VertexId; 4]) -> [Point; 4] {
    // R22.
    match C::ranks_by_place() {
        true => corners.map(|v| mesh.point(v)),
        false => corners.map(|v| [f64::from(v.number()), 0.0, 0.0]),
    }
}

/// The rank of a tetrahedron with these corners.
pub(super) fn rank_of<C: Rules>(mesh: &DomainMesh<'_>, corners: [VertexId; 4]) -> Rank {
    Rank::of_tet(places_of::<C>(mesh, corners))
}

/// A worker's tetrahedra, of which those over their bounds have ranks. Others' count for nothing.
pub(super) struct RankedHere<'m, 'c, C> {
    mesh: &'m DomainMesh<'c>,
    rules: PhantomData<C>,
}

impl<'m, 'c, C: Rules> RankedHere<'m, 'c, C> {
    pub(super) fn of(mesh: &'m DomainMesh<'c>) -> Self {
        Self { mesh, rules: PhantomData }
    }
}

impl<C: Rules> Ranked for RankedHere<'_, '_, C> {
    #[inline(always)]
    fn neighbours(&self, t: TetId) -> [TetId; 4] {
        self.mesh.inner.tets().neighbours(t).map(tet_of)
    }

    #[inline(always)]
    fn around(&self, way: TetId) -> Option<[TetId; 4]> {
        self.mesh.inner.tets().is_live(way).then(|| self.neighbours(way))
    }

    #[inline(always)]
    fn prefetch(&self, t: TetId) {
        self.mesh.inner.tets().topology().prefetch(t);
    }

    #[cold]
    #[inline(never)]
    fn is_first_by_place(&self, one: TetId, other: TetId) -> bool {
        let rank = |t: TetId| rank_of::<C>(self.mesh, self.mesh.inner.tets().vertices(t));
        rank(one) < rank(other)
    }

    #[inline(always)]
    fn breaks_ties(&self) -> bool {
        // R26.
        C::breaks_ties()
    }
}
