//! Boxes, and their check, for the tests of domains.
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use ltbw_domain::{CheckOptions, Domain, DomainReport, Facet};

/// A domain of unit cubes at these places, each with vertices of its own.
pub(crate) fn cubes(places: &[[f64; 3]]) -> Domain {
    let mut domain = Domain::default();
    for place in places {
        let first = domain.vertices.len() as u32;
        domain.vertices.extend((0..8).map(|i| [0, 1, 2].map(|k| place[k] + f64::from(i >> k & 1))));
        for face in BOX {
            domain.facets.push(Facet::polygon(&face.map(|v| v + first), 0));
        }
    }
    domain
}

/// The faces of a box whose vertices have their numbers by bits.
pub(crate) const BOX: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// The report of a domain, whose facets may be `oriented`.
pub(crate) fn check(domain: &Domain, oriented: bool) -> DomainReport {
    domain.check(&CheckOptions { oriented, ..CheckOptions::default() }).unwrap()
}
