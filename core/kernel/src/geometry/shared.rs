//! Conflicts on a mesh that is only read.

use super::{Geometry, PredicateStats, Predicates, decide_rest, lattice_step};
use crate::cavity::Conflict;
use crate::sphere::{Query, Verdict, simd};
use crate::topology::{TetId, Topology};
use ltbw_exact::Point;

/// [`Conflict`] with one point, for one of many that look at the same mesh.
#[derive(Debug)]
pub(crate) struct SharedConflict<'a> {
    geometry: &'a Geometry,
    stats: &'a mut PredicateStats,
    step: f64,
    p: Point,
    query: Query,
}

impl<'a> SharedConflict<'a> {
    /// The conflict test for `p`, counted in `stats`.
    pub(crate) fn new(geometry: &'a Geometry, p: &Point, stats: &'a mut PredicateStats) -> Self {
        let query = geometry.frame.as_ref().map_or(Query::NOWHERE, |f| f.query(p));
        Self { geometry, stats, step: geometry.step.min(lattice_step(p)), p: *p, query }
    }

    /// Is `t` in conflict?
    pub(crate) fn holds(&mut self, topology: &Topology, t: TetId) -> bool {
        match self.geometry.spheres.at(t).test(&self.query) {
            Verdict::Inside => true,
            Verdict::Outside => false,
            Verdict::Unknown => self.in_conflict(topology, t),
        }
    }

    fn predicates(&mut self) -> Predicates<'_> {
        let Geometry { points, wide, .. } = self.geometry;
        Predicates { points, wide: *wide, step: self.step, stats: self.stats }
    }
}

impl Conflict for SharedConflict<'_> {
    #[inline(always)]
    fn prefetch(&self, t: TetId) {
        self.geometry.prefetch_sphere(t);
    }

    #[inline(always)]
    fn by_sphere(&self, tets: [TetId; 4]) -> (u32, u32) {
        simd::test_spheres(tets.map(|t| self.geometry.spheres.at(t)), &self.query)
    }

    #[inline(never)]
    fn by_points(&mut self, topology: &Topology, tets: [TetId; 4], unknown: u32) -> u32 {
        let p = self.p;
        let (conflicts, open) = self.predicates().filter(topology, tets, unknown, &p);
        decide_rest(self, topology, tets, conflicts, open)
    }

    #[cold]
    fn in_conflict(&mut self, topology: &Topology, t: TetId) -> bool {
        let p = self.p;
        self.predicates().in_conflict(topology.tet(t).vertices(), &p)
    }
}
