//! The regions of refined domains, and their attributes.

use ltbw_domain::{Domain, Facet, PrepareOptions, Region};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_refine::Refiner;

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

/// A box of slabs one wide along x, with seeds in the slabs of these numbers.
fn slabs(count: u32, seeds: &[u32]) -> Domain {
    let corner = |k: u32| [f64::from(k >> 2), f64::from(k >> 1 & 1), f64::from(k & 1)];
    let walls = (0..=count).map(|x| vec![4 * x, 4 * x + 1, 4 * x + 3, 4 * x + 2]);
    let sides = [[0, 1], [1, 3], [3, 2], [2, 0]];
    let sides = (0..count)
        .flat_map(|x| sides.map(|[a, b]| vec![4 * x + a, 4 * x + b, 4 * x + 4 + b, 4 * x + 4 + a]));
    let facet = |ring| Facet { polygons: vec![ring], ..Facet::default() };
    let region = |&slab: &u32| Region {
        seed: [f64::from(slab) + 0.5, 0.375, 0.625],
        attribute: 100.0 + f64::from(slab),
        max_volume: None,
    };
    Domain {
        vertices: (0..4 * count + 4).map(corner).collect(),
        facets: walls.chain(sides).map(facet).collect(),
        regions: seeds.iter().map(region).collect(),
        ..Domain::default()
    }
}

/// The first seed's region is 1, the next one's 2, wherever they are; slabs without a seed follow.
#[test]
fn tetrahedra_have_the_tags_of_the_seeds_in_them() {
    for seeds in [[2, 0, 3], [0, 1, 2], [3, 2, 1], [1, 3, 0]] {
        let ready = slabs(4, &seeds).prepare(&PrepareOptions::default()).expect("a sound domain");
        let refiner = Refiner::new().max_volume(0.02);
        let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        let mesh = refined.inside();
        let tags = mesh.tet_tags.expect("tags");
        let attributes = mesh.tet_attributes.expect("attributes");
        let mut seen = [0; 5];
        for ((tet, tag), attribute) in mesh.tets.iter().zip(tags).zip(attributes) {
            let middle = tet.iter().map(|&v| mesh.points[v as usize][0] / 4.0).sum::<f64>();
            let slab = middle as u32;
            let place = seeds.iter().position(|&seed| seed == slab);
            assert_eq!(tag, place.map_or(4, |k| k as i64 + 1), "{seeds:?}, slab {slab}");
            let own = place.map_or(4.0, |_| 100.0 + f64::from(slab));
            assert_eq!(attribute, own, "{seeds:?}, slab {slab}");
            seen[tag as usize] += 1;
        }
        assert!(seen[0] == 0 && seen[1..].iter().all(|&n| n > 50), "{seen:?}");
    }
}
