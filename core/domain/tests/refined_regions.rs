//! The regions of refined domains, and their attributes.

use ltbw_domain::refine::Refiner;
use ltbw_domain::{Domain, PrepareOptions, Region};
use ltbw_generate::{DomainKind, Shape, generate_domain};

/// Two regions in a box, with these attributes.
fn two_regions(attributes: [f64; 2]) -> Domain {
    let mut domain = generate_domain(DomainKind::TwoMaterial, &Shape::default()).expect("a domain");
    for (region, attribute) in domain.regions.iter_mut().zip(attributes) {
        *region = Region { attribute, max_volume: None, ..*region };
    }
    domain
}

#[test]
fn tetrahedra_have_the_attributes_of_their_regions() {
    let cases = [
        ([70.0, 90.5], Some(vec![0.0, 70.0, 90.5])),
        ([0.0, 7.0], Some(vec![0.0, 1.0, 7.0])),
        // None, or such as the numbers of the regions are: nothing that tags do not tell.
        ([0.0, 0.0], None),
        ([1.0, 2.0], None),
    ];
    for (given, expected) in cases {
        let ready = two_regions(given).prepare(&PrepareOptions::default()).expect("a sound domain");
        let refined = Refiner::new().refine(&ready.domain, &ready.lattice).expect("a mesh");
        assert_eq!(refined.attributes(), expected, "{given:?}");
        for mesh in [refined.inside(), refined.with_exterior()] {
            let tags = mesh.tet_tags.expect("tags");
            let of_tags = |all: &Vec<f64>| tags.iter().map(|&tag| all[tag as usize]).collect();
            assert_eq!(mesh.tet_attributes, expected.as_ref().map(of_tags), "{given:?}");
        }
    }
}
