//! Tests of whole refinements.

use super::*;
use crate::domain::{Domain, Facet, PrepareOptions};

/// A box with corners `low` and `high`, appended to a domain.
fn add_box(domain: &mut Domain, low: Point, high: Point) {
    let base = domain.vertices.len() as u32;
    for i in 0..8 {
        domain.vertices.push([0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] }));
    }
    for corners in
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    {
        domain.facets.push(Facet::polygon(&corners.map(|c| base + c), 0));
    }
}

/// The model problem: the unit cube with an octahedral hole.
fn model() -> Domain {
    let mut domain = Domain::default();
    add_box(&mut domain, [0.0; 3], [1.0; 3]);
    for axis in 0..3 {
        for side in [0.25, 0.75] {
            let mut p = [0.5; 3];
            p[axis] = side;
            domain.vertices.push(p);
        }
    }
    for i in 0..8u32 {
        let corners = [0, 1, 2].map(|k| 8 + 2 * k + (i >> k & 1));
        domain.facets.push(Facet::polygon(&corners, 1));
    }
    domain.holes.push([0.5; 3]);
    domain
}

#[test]
fn the_model_problem_is_met() {
    let refined = Refiner::new().max_volume(1e-3).refine_ready(&model()).expect("a mesh");
    println!("{} tets {:?} {:?}", refined.num_tets(), refined.outcome, refined.stats);
    println!("{:?} {:?}", refined.lost, refined.excuses.first());
    assert_eq!(refined.outcome, RefineOutcome::Met);
}

impl Refiner<'_> {
    /// Prepares and refines.
    fn refine_ready(&self, domain: &Domain) -> Result<Refined, RefineError> {
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        self.refine(&ready.domain, &ready.lattice)
    }
}
