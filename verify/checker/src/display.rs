//! Reports for people: a line, and one more for each kind of defect.

use crate::conform::Conformity;
use crate::report::{Certificate, Report};
use std::fmt;

/// A number of tetrahedra, with the noun.
fn tetrahedra(count: u64) -> String {
    if count == 1 { "1 tetrahedron".to_owned() } else { format!("{count} tetrahedra") }
}

impl fmt::Display for Report {
    /// As its certificate.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.certificate().fmt(f)
    }
}

impl fmt::Display for Certificate<'_> {
    /// The outcome, the size of the mesh, the hash, and a line for each kind of defect.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (counts, hash) = self.figures();
        let outcome = if self.passed() { "passed" } else { "FAILED" };
        write!(f, "{outcome}: {}, {} vertices", tetrahedra(counts.tets), counts.vertices)?;
        if let Some(hash) = hash {
            write!(f, ", ltbw.mesh/1 {hash}")?;
        }
        for (kind, count) in self.defect_counts() {
            write!(f, "\n{count} x {kind}: {}", kind.text())?;
        }
        Ok(())
    }
}

impl fmt::Display for Conformity {
    /// The outcome, the size of the mesh, its exact volume, and a line for each kind of breach.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let outcome = if self.passed() { "passed" } else { "FAILED" };
        let Self { tets, subfaces, cells, .. } = self;
        let noun = if *cells == 1 { "cell" } else { "cells" };
        let tets = tetrahedra(*tets);
        write!(f, "{outcome}: {tets}, {subfaces} faces on facets, {cells} {noun}")?;
        if let Some(volume) = &self.volume {
            write!(f, ", volume {volume}")?;
        }
        if self.mesh_defect_count > 0 {
            write!(f, "\n{} x a defect of the mesh itself", self.mesh_defect_count)?;
        }
        for (breach, count) in &self.counts {
            write!(f, "\n{count} x {}", breach.text())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::{Limits, Mesh, Options, Plc, PlcFacet, check, conforms};

    const POINTS: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn certificates_are_told_in_a_line_and_one_for_each_kind_of_defect() {
        let report = check(&Mesh::new(&POINTS, &[[0, 1, 2, 3]]), &Options::default());
        let text = report.certificate().to_string();
        assert!(text.starts_with("passed: 1 tetrahedron, 4 vertices, ltbw.mesh/1 "), "{text}");
        assert_eq!((text.len(), text.lines().count(), &text), (111, 1, &report.to_string()));
        let report = check(&Mesh::new(&POINTS, &[[0, 1, 2, 3], [3, 2, 1, 0]]), &Options::default());
        let text = report.to_string();
        assert!(text.starts_with("FAILED: 2 tetrahedra, 4 vertices"), "{text}");
        assert_eq!(text.lines().count(), 1 + report.defect_counts.len(), "{text}");
        assert!(text.contains("\n1 x duplicate_tet: "), "{text}");
    }

    #[test]
    fn conformity_is_told_in_a_line_and_one_for_each_kind_of_breach() {
        let faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
        let facet =
            |face: &[u32; 3]| PlcFacet { polygons: vec![face.to_vec()], ..PlcFacet::default() };
        let facets = faces.iter().map(facet).collect();
        let mut plc = Plc { vertices: POINTS.to_vec(), facets, ..Plc::default() };
        let mesh = Mesh::new(&POINTS, &[[0, 1, 2, 3]]);
        let (limits, options) = (Limits::default(), Options::default());
        let found = conforms(&mesh, &plc, None, &limits, &options);
        let size = "1 tetrahedron, 4 faces on facets, 1 cell, volume 1/6";
        assert_eq!(found.to_string(), format!("passed: {size}"));
        plc.holes.push([0.1; 3]);
        let limits = Limits { max_volume: Some(0.1), ..limits };
        let text = conforms(&mesh, &plc, None, &limits, &options).to_string();
        let breaches = "1 x this hole's point is in this tetrahedron\n\
                        1 x the volume is above the bound";
        assert_eq!(text, format!("FAILED: {size}\n{breaches}"));
    }
}
