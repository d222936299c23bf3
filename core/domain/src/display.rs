//! Reports for people: one line, or few.

use crate::check::DomainReport;
use crate::quality::{Histogram, Quality};
use crate::refine::{RefineOutcome, RefineStats, Refined};
use std::fmt;

/// A count and its noun.
struct Of(u64, &'static str);

impl fmt::Display for Of {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}{}", self.0, self.1, if self.0 == 1 { "" } else { "s" })
    }
}

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

impl fmt::Display for DomainReport {
    /// The parts of a sound domain, or a line for each kind of finding.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let findings: u64 = self.counts.values().sum();
        match findings {
            0 => f.write_str("no defect")?,
            _ => write!(f, "{}", Of(findings, "finding"))?,
        }
        match self.bodies {
            0 => {}
            1 => f.write_str(" in 1 body")?,
            more => write!(f, " in {more} bodies")?,
        }
        if let (Some(cells), Some(volume)) = (&self.cells, self.volume()) {
            let filled = cells.iter().filter(|cell| cell.filled).count() as u64;
            write!(f, ": {}, volume {volume}", Of(filled, "filled cell"))?;
        }
        for (kind, count) in &self.counts {
            let (severity, code) = (kind.severity().name(), kind.code());
            write!(f, "\n{severity}: {count} x {code}: {}", kind.about())?;
        }
        Ok(())
    }
}

impl fmt::Display for Histogram {
    /// The extremes: `volume: 0.001 to 0.17`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |value: f64| match value.abs() {
            size if size == 0.0 || (1e-3..1e6).contains(&size) => format!("{value:.4}"),
            _ => format!("{value:.3e}"),
        };
        write!(f, "{}: {} to {}", self.name, number(self.least.value), number(self.largest.value))
    }
}

impl fmt::Display for Quality {
    /// A line for each quantity, with its extremes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tets, dihedral, radius_edge, volume, edge, small: _ } = self;
        let tets =
            if *tets == 1 { "1 tetrahedron".to_owned() } else { format!("{tets} tetrahedra") };
        write!(f, "{tets}\n{dihedral}\n{radius_edge}\n{volume}\n{edge}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refine::{Excuse, Reason, Refiner};
    use crate::{CheckOptions, Domain};
    use ltbw_core::topology::TetId;

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

    #[test]
    fn domains_are_told_with_a_line_for_each_kind_of_finding() {
        let mut domain = Domain::cuboid([0.0; 3], [1.0, 1.0, 0.5]);
        let report = domain.check(&CheckOptions::default()).expect("a report");
        assert_eq!(report.to_string(), "no defect: 1 filled cell, volume 1/2");
        domain.facets.pop();
        let report = domain.check(&CheckOptions::default()).expect("a report");
        let text = report.to_string();
        let lines: Vec<&str> = text.lines().collect();
        let findings: u64 = report.counts.values().sum();
        assert_eq!(lines.len(), 1 + report.counts.len(), "{text}");
        assert!(lines[0].starts_with(&format!("{findings} finding")), "{text}");
        assert!(lines[1].starts_with("error: "), "{text}");
    }

    #[test]
    fn quality_is_told_by_its_extremes() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let quality = Quality::of(&points, &[[0, 1, 2, 3]]).expect("a tetrahedron");
        let text = "1 tetrahedron\n\
                    dihedral angle, degrees: 54.7356 to 90.0000\n\
                    circumradius / shortest edge: 0.8660 to 0.8660\n\
                    volume: 0.1667 to 0.1667\n\
                    edge length: 1.0000 to 1.4142";
        assert_eq!(quality.to_string(), text);
        let small = points.map(|p| p.map(|c| c * 1e-3));
        let quality = Quality::of(&small, &[[0, 1, 2, 3]]).expect("a tetrahedron");
        assert_eq!(quality.volume.to_string(), "volume: 1.667e-10 to 1.667e-10");
    }
}
