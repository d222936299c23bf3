//! Domains for the checker.

use ltbw::domain::Domain;
use ltbw_verify::{Plc, PlcFacet};

/// A domain as the checker takes it.
pub fn plc_of(domain: &Domain, flat_tolerance: f64) -> Plc {
    let facet = |f: &ltbw::domain::Facet| PlcFacet {
        polygons: f.polygons.clone(),
        holes: f.holes.clone(),
        marker: f.marker,
    };
    Plc {
        vertices: domain.vertices.iter().chain(&domain.points).copied().collect(),
        facets: domain.facets.iter().map(facet).collect(),
        segments: domain.segments.iter().map(|(ends, _)| *ends).collect(),
        holes: domain.holes.clone(),
        regions: domain.regions.iter().map(|r| r.seed).collect(),
        flat_tolerance,
    }
}
