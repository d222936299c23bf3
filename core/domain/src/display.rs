//! Reports for people: one line, or few.

use crate::DefectKind;
use crate::check::DomainReport;
use crate::quality::{Histogram, Quality};
use std::fmt;

/// A count and its noun.
#[derive(Clone, Copy, Debug)]
pub struct Of(pub u64, pub &'static str);

impl fmt::Display for Of {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}{}", self.0, self.1, if self.0 == 1 { "" } else { "s" })
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
        let Self { tets, dihedral, radius_edge, volume, edge, scaled_jacobian, .. } = self;
        let tets =
            if *tets == 1 { "1 tetrahedron".to_owned() } else { format!("{tets} tetrahedra") };
        let least = scaled_jacobian.value;
        write!(f, "{tets}\n{dihedral}\n{radius_edge}\n{volume}\n{edge}\n")?;
        write!(f, "scaled Jacobian: at least {least:.4}")
    }
}

/// The gravest defects in a line: how many of each kind, the first one, and what they mean for the
/// bodies of the surface.
pub(crate) fn summary(report: &DomainReport) -> String {
    let gravest = report.severity();
    let grave = |kind: &DefectKind| Some(kind.severity()) == gravest;
    let counts: Vec<String> = report
        .counts
        .iter()
        .filter(|(kind, _)| grave(kind))
        .map(|(kind, count)| format!("{count} {}", kind.code()))
        .collect();
    let first = report.defects.iter().find(|d| grave(&d.kind));
    let first = first.map(|d| format!("; the first: {d}")).unwrap_or_default();
    let troubles: Vec<String> = report.troubles.iter().map(ToString::to_string).collect();
    let troubles = match troubles.is_empty() {
        true => String::new(),
        false => format!("; of {} bodies: {}", report.bodies, troubles.join("; ")),
    };
    format!("defects: {}{first}{troubles}", counts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CheckOptions, Domain};

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
                    edge length: 1.0000 to 1.4142\n\
                    scaled Jacobian: at least 0.7071";
        assert_eq!(quality.to_string(), text);
        let small = points.map(|p| p.map(|c| c * 1e-3));
        let quality = Quality::of(&small, &[[0, 1, 2, 3]]).expect("a tetrahedron");
        assert_eq!(quality.volume.to_string(), "volume: 1.667e-10 to 1.667e-10");
    }
}
