//! The model domains, and triangles of facets.

use ltbw_domain::{CheckOptions, Domain, Facet, PrepareOptions, Problem, Region};
use ltbw_exact::Point;
use ltbw_formats as io;
use ltbw_generate::{DomainKind, Random, Shape, ShapeError, generate_domain};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::path::Path;

fn model(kind: DomainKind) -> Domain {
    generate_domain(kind, &Shape::default()).unwrap()
}

/// Marker, polygons and number of holes of a facet: coordinates in units of 2^-40, whatever the
/// order of vertices and polygons.
type Place = (i32, BTreeSet<BTreeSet<[i64; 3]>>, usize);

fn facets(domain: &Domain) -> BTreeSet<Place> {
    let unit = 2.0_f64.powi(40);
    let place = |p: &Point| p.map(|c| (c * unit).round() as i64);
    let polygon = |p: &Vec<u32>| p.iter().map(|&v| place(&domain.vertices[v as usize])).collect();
    let facet = |f: &Facet| (f.marker, f.polygons.iter().map(polygon).collect(), f.holes.len());
    domain.facets.iter().map(facet).collect()
}

#[test]
fn the_papers_domains_are_those_of_the_files() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/domains");
    for (kind, name) in [
        (DomainKind::CubeOctahedron, "model.poly"),
        (DomainKind::CubeInCube, "cubeincube.poly"),
        (DomainKind::Gear, "gear.poly"),
        (DomainKind::Tee, "tee.poly"),
    ] {
        let ours = model(kind);
        let file = io::read_domain(folder.join(name)).unwrap().domain;
        assert_eq!(ours.vertices.len(), file.vertices.len(), "{kind}");
        assert_eq!(ours.facets.len(), file.facets.len(), "{kind}");
        assert_eq!(facets(&ours), facets(&file), "{kind}");
        assert_eq!(ours.holes, file.holes, "{kind}");
        assert_eq!(ours.regions, file.regions, "{kind}");
    }
}

#[test]
fn every_model_is_sound_and_oriented() {
    for kind in DomainKind::ALL {
        let domain = model(kind);
        assert_eq!(kind.name().parse(), Ok(kind));
        assert_eq!(domain, model(kind));
        // The wall between two materials has no right orientation; the rest is checked below.
        let oriented = kind != DomainKind::TwoMaterial;
        let report = domain.check(&CheckOptions { oriented, ..Default::default() }).unwrap();
        assert!(report.passed(), "{kind}: {:?}", report.defects);
        let prepared = domain.prepare(&PrepareOptions { oriented, ..Default::default() }).unwrap();
        assert!(prepared.report.passed(), "{kind}: {:?}", prepared.report.defects);
    }
    let volume = |domain: &Domain| {
        domain.check(&CheckOptions::default()).unwrap().volume().unwrap().to_string()
    };
    assert_eq!(volume(&model(DomainKind::CubeOctahedron)), "47/48");
    assert_eq!(volume(&model(DomainKind::LBlock)), "3");
    assert_eq!(volume(&model(DomainKind::Stair)), "10");
    assert_eq!(volume(&model(DomainKind::Voxels)), "100");
    let mut two = model(DomainKind::TwoMaterial);
    let report = two.check(&CheckOptions::default()).unwrap();
    let cells = report.cells.unwrap();
    assert_eq!(cells.iter().map(|c| c.volume.to_string()).collect::<Vec<_>>(), ["1", "1"]);
    assert_eq!(cells.iter().map(|c| c.regions.len()).collect::<Vec<_>>(), [1, 1]);
    // Without the wall it is an oriented box, with four edges that stand free in its sides.
    two.facets.remove(2);
    let report = two.check(&CheckOptions { oriented: true, ..Default::default() }).unwrap();
    assert!(report.passed(), "{:?}", report.defects);
}

#[test]
fn schoenhardts_polyhedron_is_bent_inwards() {
    let domain = model(DomainKind::Schoenhardt);
    let volume = domain.check(&CheckOptions::default()).unwrap().volume().unwrap().to_f64();
    let prism = 3.0_f64.sqrt() * 0.75;
    assert!(volume < 0.9 * prism, "{volume}");
    // Every diagonal that is no edge runs outside: its middle is in no cell.
    let edges: BTreeSet<[u32; 2]> = domain
        .facets
        .iter()
        .flat_map(|f| (0..3).map(move |i| [f.polygons[0][i], f.polygons[0][(i + 1) % 3]]))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    let mut outside = 0;
    for a in 0..6_u32 {
        for b in a + 1..6 {
            if !edges.contains(&[a, b]) {
                let mut seeded = domain.clone();
                let [p, q] = [a, b].map(|v| domain.vertices[v as usize]);
                let seed = [0, 1, 2].map(|k| (p[k] + q[k]) / 2.0);
                seeded.regions.push(Region { seed, attribute: 1.0, max_volume: None });
                let report = seeded.check(&CheckOptions::default()).unwrap();
                outside += report.count(ltbw_domain::DefectKind::SeedOutside);
            }
        }
    }
    assert_eq!((edges.len(), outside), (12, 3));
}

#[test]
fn angles_and_counts() {
    let wedge = |angle: f64| {
        generate_domain(DomainKind::Wedge, &Shape { angle: Some(angle), ..Shape::default() })
    };
    for degrees in [0.1, 1.0, 5.0, 30.0, 60.0, 90.0, 120.0, 179.0] {
        let domain = wedge(degrees).unwrap();
        let [x, y, _] = domain.vertices[2];
        assert!((y.atan2(x).to_degrees() - degrees).abs() < 1e-12, "{degrees}");
        assert!(domain.check(&CheckOptions::default()).unwrap().passed(), "{degrees}");
        assert!(domain.prepare(&PrepareOptions::default()).is_ok(), "{degrees}");
    }
    let error = wedge(180.0).unwrap_err();
    assert_eq!(error.to_string(), "a wedge has an angle above 0 and below 180 degrees, not 180");
    assert!(matches!(wedge(f64::NAN), Err(ShapeError::Angle { .. })));
    let count = |kind, count| generate_domain(kind, &Shape { count, ..Shape::default() });
    assert_eq!(count(DomainKind::Stair, Some(40)).unwrap().facets[0].polygons[0].len(), 82);
    let error = count(DomainKind::Voxels, Some(0)).unwrap_err();
    assert_eq!(error.to_string(), "a domain of voxels has 1 to 1000000 parts, not 0");
}

/// Twice the area of the triangles of a facet in the plane z = 0, all counterclockwise.
fn doubled_area(domain: &Domain, triangles: &[[u32; 3]]) -> f64 {
    let areas = triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| domain.vertices[v as usize]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!(area > 0.0);
        area
    });
    areas.sum()
}

fn shoelace(polygon: &[[i64; 2]]) -> i64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(p, q)| p[0] * q[1] - q[0] * p[1]).sum()
}

#[test]
fn rings_and_free_edges() {
    let gear = model(DomainKind::Gear);
    let ring = gear.triangulate(0).unwrap();
    // 96 corners and one hole: 96 triangles.
    assert_eq!((ring.triangles.len(), ring.planar, ring.is_sound()), (96, true, true));
    let two = model(DomainKind::TwoMaterial);
    let side = two.triangulate(3).unwrap();
    assert_eq!((side.triangles.len(), side.loose.len(), side.is_sound()), (4, 0, true));
    assert_eq!(two.triangulate(7), None);
    // A free edge beside the facet.
    let square = vec![[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
    let mut domain = Domain { vertices: square, ..Domain::default() };
    domain.vertices.extend([[3.0, 0.0, 0.0], [3.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    let mut facet = Facet::polygon(&[0, 1, 2, 3], 0);
    facet.polygons.push(vec![4, 5]);
    domain.facets.push(facet);
    let found = domain.triangulate(0).unwrap();
    assert_eq!((found.triangles.len(), found.loose.as_slice()), (2, &[[4, 5]][..]));
    let problems = |polygons: &[&[u32]]| {
        let polygons = polygons.iter().map(|p| p.to_vec()).collect();
        let facet = Facet { polygons, ..Facet::default() };
        let one = Domain { facets: vec![facet], ..domain.clone() };
        one.triangulate(0).unwrap().problems
    };
    assert_eq!(problems(&[&[0, 1, 4]]), [Problem::NoArea]);
    assert_eq!(problems(&[&[0, 1, 2, 1]]), [Problem::RepeatedVertex { polygon: 0, vertex: 1 }]);
    assert_eq!(
        problems(&[&[0, 1, 2, 3], &[6, 3]]),
        [Problem::VertexOnEdge { vertex: 6, edge: [0, 1] }]
    );
    assert_eq!(problems(&[&[0, 1, 2, 3], &[0, 2], &[1, 3]]).len(), 1);
    assert!(matches!(problems(&[&[0, 2, 1, 3]])[..], [Problem::Crossing(..)]));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// Star-shaped polygons of random integer corners, with a smaller copy of the same shape as a
    /// hole: the areas are those of the shoelace formula, exactly.
    #[test]
    fn polygons_with_a_hole_have_their_area(
        seed in any::<u64>(), corners in 3..40_usize, back in any::<bool>(),
    ) {
        let mut random = Random::new(seed);
        // Directions sorted by angle: first by half-plane, then by cross product.
        let mut directions: Vec<[i64; 2]> = Vec::new();
        while directions.len() < corners {
            let d = [0, 1].map(|_| random.below(41) as i64 - 20);
            let parallel =
                |e: &[i64; 2]| d[0] * e[1] == d[1] * e[0] && d[0] * e[0] + d[1] * e[1] > 0;
            if d != [0, 0] && !directions.iter().any(parallel) {
                directions.push(d);
            }
        }
        let half = |d: &[i64; 2]| d[1] < 0 || (d[1] == 0 && d[0] < 0);
        directions.sort_by(|d, e| {
            half(d).cmp(&half(e)).then_with(|| (e[0] * d[1]).cmp(&(d[0] * e[1])))
        });
        let turns = |d: &[i64; 2], e: &[i64; 2]| d[0] * e[1] - d[1] * e[0] > 0;
        let around = (0..corners).all(|i| turns(&directions[i], &directions[(i + 1) % corners]));
        prop_assume!(around);
        let outer: Vec<[i64; 2]> = directions.iter().map(|d| d.map(|c| 3 * c)).collect();
        let count = corners as u32;
        let mut polygons: Vec<Vec<u32>> = vec![(0..count).collect(), (count..2 * count).collect()];
        if back {
            polygons[1].reverse();
        }
        let vertices = outer.iter().chain(&directions).map(|d| [d[0] as f64, d[1] as f64, 0.0]);
        let facet = Facet { polygons, holes: vec![[0.0; 3]], marker: 0 };
        let (vertices, facets) = (vertices.collect(), vec![facet]);
        let domain = Domain { vertices, facets, ..Domain::default() };
        let found = domain.triangulate(0).unwrap();
        prop_assert!(found.is_sound() && found.problems.is_empty(), "{:?}", found.problems);
        prop_assert_eq!(found.triangles.len(), 2 * corners);
        let area = shoelace(&outer) - shoelace(&directions);
        prop_assert_eq!(doubled_area(&domain, &found.triangles), area as f64);
    }
}
