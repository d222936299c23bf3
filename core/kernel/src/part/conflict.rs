//! What an insertion or a walk in a part meets: proxies, closed and watched tetrahedra.

use crate::cavity::Conflict;
use crate::geometry::{Geometry, PointConflict};
use crate::locate::Gate;
use crate::special::Specials;
use crate::topology::{TetId, Topology};

/// The gate of walks: proxies and closed tetrahedra.
pub(super) struct Doors<'a, H, L>(pub(super) &'a Specials<H, L>);

impl<H: Copy, L: Copy> Gate for Doors<'_, H, L> {
    const SHUTS: bool = true;

    #[inline(always)]
    fn is_closed(&self, topology: &Topology, geometry: &Geometry, t: TetId) -> bool {
        // Both have no sphere.
        let sphere = geometry.sphere(t);
        sphere.is_blank() && (topology.tet(t).is_vacant() || self.0.is_closed(sphere))
    }
}

/// What the search for a cavity has met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Met {
    /// A watched tetrahedron.
    pub(super) watched: bool,
    /// A proxy.
    pub(super) blocked: bool,
    /// A closed tetrahedron.
    pub(super) closed: Option<TetId>,
}

/// [`Conflict`] that sees proxies and closed tetrahedra.
pub(super) struct PartConflict<'a, H, L> {
    pub(super) inner: PointConflict<'a>,
    pub(super) specials: &'a Specials<H, L>,
    pub(super) met: Met,
    /// What this holder has closed is passed over as if it were not in conflict.
    pub(super) holder: Option<H>,
}

impl<H: Copy + Eq, L: Copy> Conflict for PartConflict<'_, H, L> {
    #[inline(always)]
    fn prefetch(&self, t: TetId) {
        self.inner.prefetch(t);
    }

    #[inline(always)]
    fn certain(&self, tets: [TetId; 4]) -> (u32, u32) {
        self.inner.certain(tets)
    }

    #[inline(never)]
    fn decide(&mut self, topology: &Topology, tets: [TetId; 4], unknown: u32) -> u32 {
        // A slot that has a sphere, although that decides nothing, is an open tetrahedron; so is one
        // that is not in `unknown`, as a sphere has decided it or the cavity has it already. A
        // vacant slot has none and is not marked.
        let blank = tets.map(|t| self.inner.geometry().sphere(t).is_blank());
        let blank = (0..4).map(|slot| u32::from(blank[slot]) << slot).sum::<u32>() & unknown;
        if blank == 0 {
            return self.inner.decide(topology, tets, unknown);
        }
        let mut open = unknown & !blank;
        for (slot, &t) in tets.iter().enumerate().filter(|&(slot, _)| blank >> slot & 1 == 1) {
            if topology.tet(t).is_vacant() {
                self.met.blocked = true;
                continue;
            }
            let special = self.specials.get(self.inner.geometry().sphere(t));
            match special.and_then(|special| special.closed) {
                Some((by, _)) if self.holder == Some(by) => {}
                Some(_) => self.met.closed = Some(t),
                None => {
                    open |= 1 << slot;
                    self.met.watched |= special.is_some();
                }
            }
        }
        // Once it has met a closed one the cavity is set back: nothing more is taken into it.
        if self.met.closed.is_some() || open == 0 {
            return 0;
        }
        // A proxy has no vertices to look at: an open one stands in for it.
        let stand_in = tets[open.trailing_zeros() as usize & 3];
        let mut slot = 0;
        let tets = tets.map(|t| {
            let t = if open >> slot & 1 == 1 { t } else { stand_in };
            slot += 1;
            t
        });
        self.inner.decide(topology, tets, open)
    }

    #[cold]
    fn in_conflict(&mut self, topology: &Topology, t: TetId) -> bool {
        self.inner.in_conflict(topology, t)
    }
}
