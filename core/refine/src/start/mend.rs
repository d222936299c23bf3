//! Recovery of the boundary, one item after the other: segments, facets, then patches.

use crate::RefineError;
use crate::mesh::tiles::Found;
use crate::patches::layer::Hole;
use crate::queue::split::Step;
use crate::run::Run;
use crate::table::Set;

/// The most rounds in which patches are recovered.
const ROUNDS: u32 = 256;

impl Run<'_> {
    /// Splits what is missing until every subsegment, then every subface is there.
    pub(crate) fn recover(&mut self) -> Result<(), RefineError> {
        let heed = self.heed();
        self.refinement.state.enter_segments(&mut self.work, heed)?;
        self.drain_boundary()?;
        self.refinement.state.enter_subfaces(&mut self.work, heed)?;
        self.drain_boundary()?;
        self.refinement.state.at_edge = None;
        Ok(())
    }

    /// Inserts points where patches are not in the mesh until they are; or the patches with which
    /// that does not succeed, if these are known.
    pub(crate) fn recover_patches(&mut self) -> Result<Result<Found, Vec<u32>>, RefineError> {
        for _ in 0..ROUNDS {
            self.drain_boundary()?;
            self.look()?;
            let state = &self.refinement.state;
            if !state.is_complete() || self.stop.is_some() {
                return Ok(Err(Vec::new()));
            }
            let mut found = state.find_layers();
            let mut holes = match state.holes(&mut found) {
                Ok(holes) if holes.is_empty() => return Ok(Ok(found)),
                Ok(holes) => holes,
                Err(unknown) => return Ok(Err(unknown)),
            };
            // One point for holes that have corners in common: the next round looks again.
            holes.sort_by(Hole::order);
            let (mut seen, mut inserted) = (Set::default(), false);
            let all: Set<u32> = holes.iter().map(|hole| hole.facet).collect();
            for hole in holes {
                if hole.corners.iter().any(|v| seen.contains(v)) {
                    continue;
                }
                seen.extend(hole.corners);
                inserted |= self.fill(&hole)?;
            }
            if !inserted {
                return Ok(Err(all.into_iter().collect()));
            }
        }
        Ok(Err(Vec::new()))
    }

    /// One point for a hole; did it come to be?
    fn fill(&mut self, hole: &Hole) -> Result<bool, RefineError> {
        self.look()?;
        if self.refinement.inserted.points.total() >= self.most {
            return Ok(false);
        }
        let step = self.refinement.fill_hole(hole, &mut self.work);
        Ok(step == Step::Inserted)
    }

    fn drain_boundary(&mut self) -> Result<(), RefineError> {
        // Ends: every insertion takes a new point of the finite lattice, refused items do not
        // come back, and a deferred one waits for an insertion or for a refusal.
        while let Some(item) = self.work.next_boundary() {
            self.step(item)?;
        }
        Ok(())
    }
}
