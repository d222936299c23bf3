//! What an insertion or a walk in a part meets: proxies, closed and watched tetrahedra.

use crate::cavity::Conflict;
use crate::geometry::{Geometry, PointConflict};
use crate::locate::Gate;
use crate::special::Specials;
use crate::topology::{INFINITE, TetId, Topology, VertexId};
use std::ops::Range;

/// The gate of walks: proxies and closed tetrahedra.
pub(super) struct Doors<'a, H, L>(pub(super) &'a Specials<H, L>);

impl<H: Copy, L: Copy> Gate for Doors<'_, H, L> {
    const SHUTS: bool = true;

    #[inline(always)]
    fn is_closed(&self, topology: &Topology, geometry: &Geometry, t: TetId) -> bool {
        // Both have no sphere.
        let sphere = geometry.sphere(t);
        sphere.0[3].is_nan() && (topology.tet(t).is_proxy() || self.0.is_closed(sphere))
    }
}

/// [`Conflict`] that sees proxies and closed tetrahedra, and vertices outside the home range.
pub(super) struct PartConflict<'a, H, L> {
    pub(super) inner: PointConflict<'a>,
    pub(super) specials: &'a Specials<H, L>,
    pub(super) home: &'a Range<VertexId>,
    /// A watched tetrahedron was met.
    pub(super) met: bool,
    /// A proxy was met.
    pub(super) blocked: bool,
    /// A closed tetrahedron that was met.
    pub(super) closed: Option<TetId>,
    /// A vertex outside the home range was met.
    pub(super) border: bool,
}

impl<H: Copy, L: Copy> Conflict for PartConflict<'_, H, L> {
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
        let mut open = 0u32;
        for (slot, &t) in tets.iter().enumerate().filter(|&(slot, _)| unknown >> slot & 1 == 1) {
            let (tet, sphere) = (topology.tet(t), self.inner.geometry().sphere(t));
            if tet.is_proxy() {
                self.blocked = true;
            } else if self.specials.is_closed(sphere) {
                self.closed = Some(t);
            } else {
                open |= 1 << slot;
                let strange = |&v: &VertexId| v != INFINITE && !self.home.contains(&v);
                self.border |= tet.vertices().iter().any(strange);
                self.met |= self.specials.is_watched(sphere);
            }
        }
        // Once it has met a closed one the cavity is set back: nothing more is taken into it.
        if self.closed.is_some() || open == 0 {
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
