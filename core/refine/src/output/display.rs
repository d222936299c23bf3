//! Refinements for people: one line, or few.

use crate::{RefineOutcome, RefineStats, Refined};
use ltbw_domain::Of;
use std::fmt;

impl fmt::Display for RefineOutcome {
    /// In a word: `met`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Met => "met",
            Self::Excused => "excused",
            Self::Unrecovered => "unrecovered",
            Self::Budget => "budget",
            Self::Cancelled => "cancelled",
        })
    }
}

impl fmt::Display for Refined {
    /// The outcome and the size of the mesh, and what is not as it was asked for.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let vertices = self.mesh().num_vertices();
        write!(f, "{}: {} tetrahedra, {vertices} vertices", self.outcome, self.num_tets())?;
        let regions = self.regions.len().saturating_sub(1) as u64;
        write!(f, ", {}", Of(regions, "region"))?;
        if !self.excuses.is_empty() {
            write!(f, "; {} over a bound, each with its reason", self.excuses.len())?;
        }
        if !self.lost.is_empty() {
            write!(f, "; {} of the boundary not in the mesh", Of(self.lost.len() as u64, "item"))?;
        }
        Ok(())
    }
}

impl fmt::Display for RefineStats {
    /// The points inserted and the time; patches and rounds where there are some.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { segment_points, facet_points, free_points, deferred, refused, .. } = self;
        write!(f, "{} on segments, {facet_points} on facets, ", Of(*segment_points, "point"))?;
        write!(f, "{free_points} inside; {deferred} put off, {refused} refused; ")?;
        let (recover, refine) = (self.recover_seconds, self.refine_seconds);
        write!(f, "{recover:.3} s for the boundary, {refine:.3} s for the rest")?;
        if self.patches > 0 {
            let (patches, within) = (self.patches, self.flat_tolerance);
            write!(f, "; {patches} sets of facets coplanar within {within:e}")?;
        }
        match self.rounds {
            0 => Ok(()),
            rounds => write!(f, "; {}", Of(rounds, "round")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Excuse, Reason, Refiner};
    use ltbw_core::topology::TetId;
    use ltbw_domain::Domain;

    #[test]
    fn refinements_are_told_in_a_line() {
        let domain = Domain::cuboid([0.0; 3], [1.0; 3]);
        let mut refined = Refiner::new().max_volume(0.02).mesh(&domain).expect("a mesh");
        let vertices = refined.mesh().num_vertices();
        let size = format!("{} tetrahedra, {vertices} vertices, 1 region", refined.num_tets());
        assert_eq!(refined.to_string(), format!("met: {size}"));
        refined.excuses = vec![Excuse { tet: TetId::default(), reason: Reason::Rounding }; 2];
        refined.outcome = RefineOutcome::Excused;
        let text = format!("excused: {size}; 2 over a bound, each with its reason");
        assert_eq!(refined.to_string(), text);
        let stats = RefineStats { recover_seconds: 0.0, refine_seconds: 0.5, ..refined.stats };
        let points = stats.segment_points + stats.facet_points + stats.free_points;
        assert_eq!(points, vertices as u64 - 8);
        let stats = RefineStats { segment_points: 1, facet_points: 2, free_points: 3, ..stats };
        let stats = RefineStats { deferred: 4, refused: 5, ..stats };
        let text = "1 point on segments, 2 on facets, 3 inside; 4 put off, 5 refused; \
                    0.000 s for the boundary, 0.500 s for the rest";
        assert_eq!(stats.to_string(), text);
        let more = RefineStats { patches: 7, flat_tolerance: 0.25, rounds: 3, ..stats };
        let more = more.to_string();
        let expected = format!("{text}; 7 sets of facets coplanar within 2.5e-1; 3 rounds");
        assert_eq!(more, expected);
    }
}
