//! One worker's tetrahedra by their ranks.

use crate::protocol::Rules;
use crate::refining::domain::DomainMesh;
use ltbw_core::topology::{TetId, VertexId, tet_of};
use ltbw_core::{Point, prefetch};
use ltbw_refine::{Rank, Ranked, witness};
use std::marker::PhantomData;

/// A tetrahedron, and its vertices.
pub(super) type Own = (TetId, [VertexId; 4]);

/// The places by which a tetrahedron with these corners is ranked.
#[inline(always)]
pub(super) fn places_of<C: Rules>(mesh: &DomainMesh<'_>, corners: [VertexId; 4]) -> [Point; 4] {
    // R22.
    match C::RANKS_BY_PLACE {
        true => corners.map(|v| mesh.point(v)),
        false => corners.map(|v| [f64::from(v.number()), 0.0, 0.0]),
    }
}

/// The rank of a tetrahedron with these corners.
pub(super) fn rank_of<C: Rules>(mesh: &DomainMesh<'_>, corners: [VertexId; 4]) -> Rank {
    Rank::of_tet(places_of::<C>(mesh, corners))
}

/// A worker's tetrahedra by their ranks. Others' count for nothing.
pub(super) struct RankedHere<'k, 'c, C> {
    /// By slot: the leading part of a rank, 0 if there is none; the look at which it was written.
    pub(super) keys: &'k [u64],
    pub(super) stamps: &'k [u32],
    pub(super) mesh: &'k DomainMesh<'c>,
    pub(super) rules: PhantomData<C>,
}

impl<C: Rules> RankedHere<'_, '_, C> {
    /// The rank of a tetrahedron over its bounds.
    pub(super) fn rank(&self, t: TetId) -> Option<Rank> {
        let is_over = self.keys[t.index()] != 0;
        is_over.then(|| rank_of::<C>(self.mesh, self.mesh.inner.tets().vertices(t)))
    }

    /// Does one tetrahedron come before another one with the same key?
    #[cold]
    #[inline(never)]
    fn is_first_by_place(&self, one: TetId, other: TetId) -> bool {
        self.rank(one) < self.rank(other)
    }
}

impl<C: Rules> Ranked for RankedHere<'_, '_, C> {
    #[inline(always)]
    fn stamp(&self, t: TetId) -> u32 {
        self.stamps[t.index()]
    }

    #[inline(always)]
    fn neighbours(&self, t: TetId) -> [TetId; 4] {
        self.mesh.inner.tets().neighbours(t).map(tet_of)
    }

    #[inline(always)]
    fn prefetch(&self, t: TetId) {
        self.mesh.inner.tets().topology().prefetch(t);
        prefetch(self.keys.as_ptr().wrapping_add(t.index()));
    }

    #[inline(always)]
    fn one_before(&self, t: TetId) -> Option<[TetId; 2]> {
        let (keys, key) = (self.keys, self.keys[t.index()]);
        // The slot of a far face has no key, or while points are inserted one of before: a witness
        // that `start` forgets.
        let is_before = |&one: &TetId| {
            let other = keys[one.index()];
            // R26.
            (other > key && (C::BREAKS_TIES || !Rank::is_tie(other, key)))
                || other == key && one != t && self.is_first_by_place(one, t)
        };
        let around = |way: TetId| self.mesh.inner.tets().is_live(way).then(|| self.neighbours(way));
        witness(t, self.neighbours(t), around, is_before)
    }
}
