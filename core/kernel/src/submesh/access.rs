//! Obstacles to an insertion or a walk in a submesh: far faces, locked and tagged tetrahedra.

use super::lock_table::LockTable;
use crate::cavity::Conflict;
use crate::geometry::{Geometry, PointConflict};
use crate::locate::Access;
use crate::topology::{TetId, Topology};

/// Bars walks from far faces and locked tetrahedra.
pub(super) struct LockFilter<'a, H, T>(pub(super) &'a LockTable<H, T>);

impl<H: Copy, T: Copy> Access for LockFilter<'_, H, T> {
    const IS_LIMITED: bool = true;

    #[inline(always)]
    fn bars(&self, topology: &Topology, geometry: &Geometry, t: TetId) -> bool {
        // Both have no sphere.
        let sphere = geometry.sphere(t);
        sphere.is_blank() && (topology.tet(t).is_vacant() || self.0.is_locked(sphere))
    }
}

/// The obstacles that the search for a cavity has met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Met {
    /// A tagged tetrahedron.
    pub(super) tagged: bool,
    /// A far face.
    pub(super) blocked: bool,
    /// A locked tetrahedron.
    pub(super) locked: Option<TetId>,
}

/// [`Conflict`] that sees far faces and locked tetrahedra.
pub(super) struct SubmeshConflict<'a, H, T> {
    pub(super) inner: PointConflict<'a>,
    pub(super) locks: &'a LockTable<H, T>,
    pub(super) met: Met,
    /// The holder whose locked tetrahedra are passed over as if they were not in conflict.
    pub(super) holder: Option<H>,
}

impl<H: Copy + Eq, T: Copy> Conflict for SubmeshConflict<'_, H, T> {
    #[inline(always)]
    fn prefetch(&self, t: TetId) {
        self.inner.prefetch(t);
    }

    #[inline(always)]
    fn by_sphere(&self, tets: [TetId; 4]) -> (u32, u32) {
        self.inner.by_sphere(tets)
    }

    #[inline(never)]
    fn by_points(&mut self, topology: &Topology, tets: [TetId; 4], unknown: u32) -> u32 {
        // A slot that has a sphere, although that decides nothing, is an unlocked tetrahedron; so
        // is one that is not in `unknown`, as a sphere has decided it or the cavity has it already.
        // A vacant slot has none and is not marked.
        let blank = tets.map(|t| self.inner.geometry().sphere(t).is_blank());
        let blank = (0..4).map(|slot| u32::from(blank[slot]) << slot).sum::<u32>() & unknown;
        if blank == 0 {
            return self.inner.by_points(topology, tets, unknown);
        }
        let mut unlocked = unknown & !blank;
        for (slot, &t) in tets.iter().enumerate().filter(|&(slot, _)| blank >> slot & 1 == 1) {
            if topology.tet(t).is_vacant() {
                self.met.blocked = true;
                continue;
            }
            let entry = self.locks.get(self.inner.geometry().sphere(t));
            match entry.and_then(|entry| entry.lock) {
                Some((by, _)) if self.holder == Some(by) => {}
                Some(_) => self.met.locked = Some(t),
                None => {
                    unlocked |= 1 << slot;
                    self.met.tagged |= entry.is_some();
                }
            }
        }
        // Once it has met a locked one the cavity is set back: nothing more is taken into it.
        if self.met.locked.is_some() || unlocked == 0 {
            return 0;
        }
        // A far face has no vertices to look at: an unlocked one stands in for it.
        let stand_in = tets[unlocked.trailing_zeros() as usize & 3];
        let mut slot = 0;
        let tets = tets.map(|t| {
            let t = if unlocked >> slot & 1 == 1 { t } else { stand_in };
            slot += 1;
            t
        });
        self.inner.by_points(topology, tets, unlocked)
    }

    #[cold]
    fn in_conflict(&mut self, topology: &Topology, t: TetId) -> bool {
        self.inner.in_conflict(topology, t)
    }
}
