//! Cavities opened again, from what an earlier search has found.

use super::Mesh;
use crate::cavity::{AdmitAll, Setback};
use crate::topology::TetId;
use crate::transaction::OpenCavity;
use ltbw_exact::Point;

impl Mesh {
    /// Opens the cavity of a point in kernel coordinates, which is no vertex, from `tets`, its
    /// cavity as it was found earlier; `changed` says of a slot whether it was written since then.
    /// Only slots that were are tested. Says whether the closure is as it was; `None` if all of
    /// the list has changed: the mesh is as before.
    ///
    /// # Errors
    /// The mesh is full, and as before.
    #[doc(hidden)]
    #[inline]
    pub fn reopen(
        &mut self,
        p: &Point,
        tets: &[TetId],
        changed: &impl Fn(TetId) -> bool,
    ) -> Result<Option<(OpenCavity<'_, Self>, bool)>, Setback> {
        let mut conflict = self.geometry.conflict_of(p);
        let Self { cavity, topology, .. } = self;
        let is_same = cavity.reopen(topology, tets, &mut conflict, changed, &mut AdmitAll)?;
        Ok(is_same.map(|is_same| (OpenCavity::new(self), is_same)))
    }

    /// Asks the processor to fetch a tetrahedron that is about to be looked at. A hint.
    #[doc(hidden)]
    #[inline(always)]
    pub fn prefetch(&self, t: TetId) {
        self.topology.prefetch(t);
    }

    /// The same, with its cached sphere.
    #[doc(hidden)]
    #[inline(always)]
    pub fn prefetch_sphere(&self, t: TetId) {
        self.geometry.prefetch_sphere(t);
    }
}
