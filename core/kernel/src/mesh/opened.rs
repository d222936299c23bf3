//! Cavities opened, or opened again from what an earlier search has found.

use super::{At, Mesh};
use crate::cavity::{Admission, AdmitAll, Setback};
use crate::locate::{Found, walk};
use crate::topology::{TetId, VertexId};
use crate::transaction::OpenCavity;
use ltbw_exact::Point;

impl Mesh {
    /// Finds the cavity of a point in kernel coordinates, walking from `from`.
    #[doc(hidden)]
    #[inline]
    pub fn begin<A: Admission>(
        &mut self,
        p: Point,
        from: TetId,
        admission: &mut A,
    ) -> Result<OpenCavity<'_, Self>, At> {
        self.begin_as::<A, false>(p, from, admission)
    }

    /// The cavity of a point, found fast where points are inserted anywhere.
    #[doc(hidden)]
    #[inline]
    pub fn begin_anywhere(&mut self, p: Point, from: TetId) -> Result<OpenCavity<'_, Self>, At> {
        self.begin_as::<_, true>(p, from, &mut AdmitAll)
    }

    #[inline(always)]
    fn begin_as<A: Admission, const FAR: bool>(
        &mut self,
        p: Point,
        from: TetId,
        admission: &mut A,
    ) -> Result<OpenCavity<'_, Self>, At> {
        let mut conflict = self.geometry.conflict_of(&p);
        let start = match walk(&self.topology, &mut conflict, from) {
            // Nothing bars a walk in a whole mesh.
            Found::Conflict(t) | Found::Outside(t) | Found::Barred(t) => t,
            Found::Inside(t) => {
                let geometry = conflict.geometry();
                let corners = self.topology.tet(t).vertices();
                if let Some(&v) = corners.iter().find(|&&v| *geometry.point(v) == p) {
                    return Err(At::Vertex(v));
                }
                t
            }
        };
        match self.cavity.expand::<_, A, FAR>(&mut self.topology, start, &mut conflict, admission) {
            Ok(()) => Ok(OpenCavity::new(self)),
            Err(setback) => Err(At::SetBack(setback)),
        }
    }

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

    /// A hint to fetch a tetrahedron and its cached sphere.
    #[doc(hidden)]
    #[inline(always)]
    pub fn prefetch_sphere(&self, t: TetId) {
        self.geometry.prefetch_sphere(t);
    }

    /// A hint to fetch a vertex.
    #[doc(hidden)]
    #[inline(always)]
    pub fn prefetch_point(&self, v: VertexId) {
        self.geometry.prefetch_point(v);
    }
}
