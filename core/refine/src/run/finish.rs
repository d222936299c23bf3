//! The end of a run: numbers, what is over its bounds and why, what is missing.

use super::Run;
use crate::RefineError;
use crate::mesh::item::Item;
use crate::mesh::region::RegionInfo;
use crate::outcome::{Reason, RefineOutcome, RefineStats};
use crate::output::refined::Refined;
use crate::queue::split::Refinement;
use ltbw_domain::Lattice;

impl Run<'_> {
    /// Collects what is over its bounds.
    ///
    /// # Errors
    /// A sizing function that gives no lengths, or different ones for one place.
    pub(super) fn finish(
        self,
        regions: Vec<RegionInfo>,
        lattice: Lattice,
    ) -> Result<Refined, RefineError> {
        let heed = self.heed();
        let Refinement { mut state, bounds, record, inserted, .. } = self.refinement;
        let (points, rounds) = (inserted.points, self.rounds);
        let stats = RefineStats {
            segment_points: points.segments,
            facet_points: points.facets,
            free_points: points.free,
            ..self.stats
        };
        state.mesh.set_next_number(inserted.next_number);
        state.number_vertices();
        let order = state.tets_in_order(inserted.next_number);
        let (mut excuses, mut slivers) = (Vec::new(), Vec::new());
        if bounds.is_some() {
            state.settle_all_dust();
        }
        // Of a mesh that is half done nearly all may be over a bound: nobody waits for the list.
        let wanted = bounds.as_ref().filter(|_| self.stop != Some(Reason::Cancelled));
        if let Some(bounds) = wanted {
            // At the end whatever is over its bounds was refused.
            let refused = || record.refused_over(bounds, &state).map(|(t, _)| t).collect();
            let over = self.over.or_else(|| self.stop.is_none().then(refused));
            // A sizing function of a work that is cancelled is not asked, or may answer anything.
            let sound = match &over {
                _ if heed.is_cancelled() => Ok(()),
                Some(over) => state.check_field(bounds, &order, over),
                None => bounds.check_sizes(&state, &order),
            };
            sound.or_else(|error| heed.is_cancelled().then_some(()).ok_or(error))?;
            excuses = state.excuses(bounds, &record, &order, over, self.stop);
            slivers = state.slivers_among(inserted.thin.tets, bounds);
        }
        let segments = state.missing_segments.iter().map(|&s| Item::Segment(s));
        let missing = segments.chain(state.missing.iter().map(|&s| Item::Subface(s)));
        let reason = |item: &Item| record.refused.get(item).map(|r| r.reason).or(self.stop);
        let mut lost: Vec<(Item, Reason)> =
            missing.map(|item| (item, reason(&item).unwrap_or(Reason::Rounding))).collect();
        lost.sort_by_cached_key(|(item, _)| state.place_of(*item));
        let outcome = match self.stop {
            _ if !lost.is_empty() => RefineOutcome::Unrecovered,
            Some(Reason::Cancelled) => RefineOutcome::Cancelled,
            Some(_) if !excuses.is_empty() => RefineOutcome::Budget,
            _ if excuses.is_empty() => RefineOutcome::Met,
            _ => RefineOutcome::Excused,
        };
        Ok(Refined {
            outcome,
            excuses,
            slivers,
            lost,
            regions,
            stats,
            rounds,
            lattice,
            markers: None,
            state,
            order,
        })
    }
}
