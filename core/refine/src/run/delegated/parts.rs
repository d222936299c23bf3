//! Rounds of others at whose end nothing is left to do: the mesh stays where it is.

use super::Delegated;
use crate::mesh::region::RegionInfo;
use crate::outcome::RefineStats;

impl Delegated<'_> {
    /// Is nothing done in the end whatever the mesh is? Smoothing is.
    pub fn may_stay(&self) -> bool {
        self.run.refinement.sweeps == 0
    }

    /// The figures of a refinement that others have ended, with those of all rounds, and the points
    /// made on segments, on facets, and inside.
    pub fn stats_with(&self, rounds: RefineStats, points: [u64; 3]) -> RefineStats {
        let [segment_points, facet_points, free_points] = points;
        RefineStats {
            segment_points,
            facet_points,
            free_points,
            round_threads: rayon::current_num_threads(),
            start_seconds: self.start_seconds,
            refine_seconds: self.clock.elapsed().as_secs_f64(),
            ..rounds
        }
    }

    /// The regions, the exterior first.
    pub fn regions(&self) -> &[RegionInfo] {
        &self.regions
    }
}
