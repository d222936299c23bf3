//! The exact check of domains.

use crate::common::{BOX, check, cubes};
use ltbw_domain::{
    CheckOptions, DefectKind, Domain, Element, Facet, PrepareError, PrepareOptions, Region,
    Severity,
};
use ltbw_formats as io;
use ltbw_generate::{DomainKind, Random, Shape, generate_domain};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;

fn fixture(name: &str) -> Domain {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/domains");
    io::read_domain(folder.join(name)).unwrap().domain
}

#[test]
fn the_model_problems_are_sound_and_have_their_volumes() {
    for (name, cells, volume) in
        [("model.poly", 2, "47/48"), ("cubeincube.poly", 2, "485/512"), ("tee.poly", 1, "47/16")]
    {
        let domain = fixture(name);
        let report = domain.check(&CheckOptions::default()).unwrap();
        assert!(report.passed(), "{name}: {:?}", report.defects);
        assert_eq!(report.cells.as_ref().unwrap().len(), cells, "{name}");
        assert_eq!(report.volume().unwrap().to_string(), volume, "{name}");
        let prepared = domain.prepare(&PrepareOptions::default()).unwrap();
        assert_eq!((prepared.moved, prepared.largest), (0, None), "{name}");
        assert_eq!(prepared.domain, domain, "{name}");
    }
    let gear = fixture("gear.poly");
    let report = gear.check(&CheckOptions::default()).unwrap();
    assert!(report.passed(), "{:?}", report.defects);
    let volume = report.volume().unwrap().to_f64();
    assert!((volume - 0.561246).abs() < 1e-6, "{volume}");
    let prepared = gear.prepare(&PrepareOptions::default()).unwrap();
    assert!(prepared.moved > 100);
    assert!(prepared.largest.unwrap().distance < 1e-8);
    assert!(prepared.report.passed(), "{:?}", prepared.report.defects);
}

/// The kinds of defects that are found, without notes.
fn kinds(domain: &Domain, oriented: bool) -> Vec<(DefectKind, u64)> {
    let counts = check(domain, oriented).counts.into_iter();
    counts.filter(|(kind, _)| kind.severity() > Severity::Info).collect()
}

#[test]
fn a_cube_is_sound() {
    let cube = cubes(&[[0.0; 3]]);
    for oriented in [false, true] {
        let report = check(&cube, oriented);
        assert!(report.passed(), "{:?}", report.defects);
        assert_eq!(report.volume().unwrap().to_string(), "1");
        assert!(report.counts.is_empty());
    }
}

#[test]
fn two_overlapping_cubes_are_named() {
    let report = check(&cubes(&[[0.0; 3], [0.5, 0.5, 0.5]]), true);
    // Three faces of each cube cross three of the other, each at two of them.
    assert_eq!(report.count(DefectKind::Intersection), 6);
    assert_eq!(report.severity(), Some(Severity::Error));
    let first = report.defects.iter().find(|d| d.kind == DefectKind::Intersection).unwrap();
    let [Element::Facet(a), Element::Facet(b)] = first.elements[..] else { panic!("{first:?}") };
    assert!(a < 6 && b >= 6, "{first}");
    assert_eq!(first.at.len(), 6);
    // Side by side with a common face that both have: each facet twice.
    let report = check(&cubes(&[[0.0; 3], [1.0, 0.0, 0.0]]), false);
    assert_eq!(report.count(DefectKind::DuplicateVertex), 4);
    assert_eq!(report.count(DefectKind::Overlap), 1);
    // Shifted along the common plane.
    let report = check(&cubes(&[[0.0; 3], [1.0, 0.25, 0.25]]), false);
    assert!(report.count(DefectKind::Overlap) >= 1, "{:?}", report.counts);
}

#[test]
fn a_cube_without_a_lid_leaks_at_four_edges() {
    let mut cube = cubes(&[[0.0; 3]]);
    cube.facets.remove(1);
    for oriented in [false, true] {
        let report = check(&cube, oriented);
        assert_eq!(kinds(&cube, oriented), [(DefectKind::Leak, 4)]);
        for defect in &report.defects {
            assert!(matches!(defect.elements[..], [Element::Edge(_), Element::Facet(_)]));
            assert!(defect.at.iter().all(|p| p[2] == 1.0), "{defect}");
        }
    }
    let error = cube.prepare(&PrepareOptions::default()).unwrap_err();
    assert_eq!(error.code(), "domain.defects");
    assert!(error.to_string().starts_with("defects: 4 domain.leak; the first: "), "{error}");
}

/// The unit cube with a square inside, `gap` above its floor.
fn plate(gap: f64) -> Domain {
    let mut domain = cubes(&[[0.0; 3]]);
    for [x, y] in [[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.75]] {
        domain.vertices.push([x, y, gap]);
    }
    domain.facets.push(Facet::polygon(&[8, 9, 10, 11], 5));
    domain
}

#[test]
fn a_plate_just_above_the_floor_is_legal_until_it_is_below_the_lattice() {
    let report = check(&plate(1e-9), false);
    assert!(report.passed(), "{:?}", report.defects);
    assert_eq!(report.count(DefectKind::Dangling), 4);
    assert_eq!(report.cells.as_ref().unwrap().len(), 1);
    // An oriented surface must not have one.
    assert_eq!(kinds(&plate(1e-9), true), [(DefectKind::Leak, 4)]);
    let error = plate(1e-9).prepare(&PrepareOptions::default()).unwrap_err();
    let PrepareError::BelowLattice { report, step } = &error else { panic!("{error}") };
    assert_eq!(*step, 2.0_f64.powi(-26));
    assert!(report.count(DefectKind::Overlap) == 1, "{:?}", report.counts);
    assert!(report.defects[0].elements.contains(&Element::Facet(6)), "{:?}", report.defects);
    // Two steps above it the lattice holds it.
    assert!(plate(2.0_f64.powi(-25)).prepare(&PrepareOptions::default()).is_ok());
}

#[test]
fn each_planted_defect_is_found_and_no_other() {
    let plant = |change: &dyn Fn(&mut Domain), oriented: bool| {
        let mut domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).unwrap();
        change(&mut domain);
        kinds(&domain, oriented)
    };
    use DefectKind as K;
    let duplicate = plant(
        &|d| {
            d.vertices.push(d.vertices[3]);
            let v = d.vertices.len() as u32 - 1;
            let polygon = &mut d.facets[0].polygons[0];
            let at = polygon.iter().position(|&v| v == 3).unwrap();
            polygon[at] = v;
        },
        false,
    );
    assert_eq!(duplicate, [(K::DuplicateVertex, 1)]);
    assert_eq!(plant(&|d| d.vertices.push([0.1; 3]), false), [(K::UnusedVertex, 1)]);
    let on_facet = plant(&|d| d.vertices.push([0.3, 0.4, 0.0]), false);
    assert_eq!(on_facet, [(K::UnusedVertex, 1)]);
    let no_area = plant(
        &|d| {
            d.vertices.push([0.5, 0.0, 0.0]);
            d.facets.push(Facet::polygon(&[0, 14, 1], 0));
        },
        false,
    );
    // The vertex lies on the edge of two faces, too, but no sound facet names it.
    assert_eq!(no_area, [(K::Degenerate, 1)]);
    let bent = plant(&|d| d.vertices[7] = [1.125, 1.0625, 1.03125], false);
    assert_eq!(bent, [(K::NonPlanar, 3)]);
    let turned = plant(&|d| d.facets[6].polygons[0].reverse(), true);
    assert_eq!(turned, [(K::Orientation, 1)]);
    assert_eq!(plant(&|d| d.facets[6].polygons[0].reverse(), false), []);
    let twice = plant(&|d| d.facets.push(d.facets[8].clone()), false);
    assert_eq!(twice, [(K::Overlap, 1)]);
    let through = plant(&|d| d.segments.push(([0, 7], 0)), false);
    assert!(through.iter().any(|&(kind, _)| kind == K::Intersection), "{through:?}");
    assert_eq!(plant(&|d| d.holes[0] = [0.5, 0.5, 0.0], false), [(K::SeedOnFacet, 1)]);
    assert_eq!(plant(&|d| d.holes[0] = [0.5, 0.5, 1.5], false), [(K::SeedOutside, 1)]);
    let region = |seed: [f64; 3]| Region { seed, attribute: 1.0, max_volume: None };
    assert_eq!(plant(&|d| d.regions.push(region([0.1; 3])), false), []);
    // In the hole.
    assert_eq!(plant(&|d| d.regions.push(region([0.5; 3])), false), [(K::SeedOutside, 1)]);
    assert_eq!(plant(&|d| d.regions.push(region([0.0; 3])), false), [(K::SeedOnFacet, 1)]);
    let leak = plant(&|d| drop(d.facets.remove(9)), false);
    // The hole's surface has a gap: inside it is a sheet, and the hole point is in the solid.
    assert_eq!(leak, []);
    assert_eq!(plant(&|d| drop(d.facets.remove(9)), true), [(K::Leak, 3)]);
    let own_crossing = plant(&|d| d.facets[0].polygons[0].swap(0, 1), false);
    // Two of its edges are others now, and those of its neighbours are alone.
    assert_eq!(own_crossing, [(K::Intersection, 1), (K::Leak, 2)]);
    let hole_of_facet = plant(&|d| d.facets[0].holes.push([5.0, 5.0, 0.0]), false);
    assert_eq!(hole_of_facet, [(K::SeedOutside, 1)]);
}

#[test]
fn what_cannot_be_looked_at() {
    let code = |change: &dyn Fn(&mut Domain)| {
        let mut cube = cubes(&[[0.0; 3]]);
        change(&mut cube);
        let error = cube.check(&CheckOptions::default()).unwrap_err();
        let refused = cube.prepare(&PrepareOptions::default()).unwrap_err();
        assert_eq!(refused.to_string(), error.to_string());
        (error.code(), error.to_string())
    };
    assert_eq!(code(&|d| d.facets.clear()).0, "domain.empty");
    assert_eq!(code(&|d| *d = Domain::default()).0, "domain.empty");
    let (nan, text) = code(&|d| d.vertices[5][1] = f64::NAN);
    assert_eq!(nan, "domain.not-finite");
    assert!(text.starts_with("vertex 5 has the coordinates [1.0, NaN, 1.0]"), "{text}");
    assert_eq!(code(&|d| d.vertices[5][1] = f64::INFINITY).0, "domain.not-finite");
    assert_eq!(code(&|d| d.holes.push([0.0, f64::NAN, 0.0])).0, "domain.not-finite");
    let (index, text) = code(&|d| d.facets[2].polygons[0][1] = 8);
    assert_eq!(index, "domain.index");
    assert_eq!(text, "facet 2 names vertex 8, but there are 8 vertices");
    assert_eq!(code(&|d| d.segments.push(([0, 99], 0))).0, "domain.index");
    assert_eq!(code(&|d| d.facets[2].polygons[0].truncate(1)).0, "domain.short-polygon");
    for factor in [1e300, 1e-40, 0.0] {
        let scale = |d: &mut Domain| d.vertices.iter_mut().flatten().for_each(|c| *c *= factor);
        assert_eq!(code(&scale).0, "domain.range");
    }
    let region = Region { seed: [0.5; 3], attribute: 0.0, max_volume: Some(-1.0) };
    assert_eq!(code(&|d| d.regions.push(region)).0, "domain.region-value");
}

#[test]
fn shells_in_shells_are_voids_and_islands() {
    // Four nested cubes, each turned inside out against the one around it.
    let mut domain = Domain::default();
    for (i, size) in [4.0, 3.0, 2.0, 1.0].into_iter().enumerate() {
        let first = domain.vertices.len() as u32;
        let at = |c: f64| (c - 0.5) * size;
        let corner = |b: u32| [0, 1, 2].map(|k| at(f64::from(b >> k & 1)));
        domain.vertices.extend((0..8).map(corner));
        for mut face in BOX.map(|f| f.map(|v| v + first)) {
            if i % 2 == 1 {
                face.reverse();
            }
            domain.facets.push(Facet::polygon(&face, i as i32));
        }
    }
    let report = check(&domain, true);
    assert!(report.passed(), "{:?}", report.defects);
    assert_eq!(report.volume().unwrap().to_string(), "44");
    let filled: Vec<bool> = report.cells.as_ref().unwrap().iter().map(|c| c.filled).collect();
    assert_eq!(filled.iter().filter(|&&f| f).count(), 2);
    assert_eq!(report.voids.len(), 2);
    let prepared =
        domain.prepare(&PrepareOptions { oriented: true, ..PrepareOptions::default() }).unwrap();
    // With the hole points it is the same domain to callers that know of no orientation.
    let plain = check(&prepared.domain, false);
    assert!(plain.passed(), "{:?}", plain.defects);
    assert_eq!(plain.volume().unwrap().to_string(), "44");

    // A shell the wrong way round is a body, with a body in it and a void in that. Where shells in
    // shells are voids its facets are named, as one finding, and turning them round helps.
    (6..12).for_each(|f| domain.facets[f].polygons[0].reverse());
    let report = check(&domain, true);
    assert_eq!((report.count(DefectKind::Nested), report.voids.len()), (2, 1));
    let voids = CheckOptions { oriented: true, nested_voids: true, ..CheckOptions::default() };
    let report = domain.check(&voids).unwrap();
    assert_eq!(report.inward, (6..12).collect::<Vec<_>>());
    assert_eq!(report.count(DefectKind::Orientation), 1);
    domain.turn_round(&report.inward);
    assert!(check(&domain, true).passed());
}

#[test]
fn cubes_that_touch_in_an_edge_or_a_corner() {
    let edge = cubes(&[[0.0; 3], [1.0, 1.0, 0.0]]).welded().domain;
    let report = check(&edge, false);
    assert!(report.passed(), "{:?}", report.defects);
    assert_eq!(report.counts, BTreeMap::from([(DefectKind::NonManifold, 1)]));
    assert_eq!(report.volume().unwrap().to_string(), "2");
    let corner = cubes(&[[0.0; 3], [1.0; 3]]).welded().domain;
    let report = check(&corner, true);
    assert!(report.counts.is_empty(), "{:?}", report.defects);
    assert_eq!(report.volume().unwrap().to_string(), "2");
}

#[test]
fn random_unions_of_cubes_have_their_volume() {
    for seed in 0..30 {
        let count = 5 + 10 * seed as u32;
        let shape = Shape { count: Some(count), seed, ..Shape::default() };
        let domain = generate_domain(DomainKind::Voxels, &shape).unwrap();
        let report = check(&domain, false);
        assert!(report.passed(), "{seed}: {:?}", report.defects);
        assert_eq!(report.volume().unwrap().to_string(), count.to_string(), "{seed}");
        // Parity finds the voids without hole points.
        let surface = Domain { holes: Vec::new(), ..domain.clone() };
        let report = check(&surface, true);
        assert!(report.passed(), "{seed}: {:?}", report.defects);
        assert_eq!(report.volume().unwrap().to_string(), count.to_string(), "{seed}");
        assert_eq!(report.voids.len(), domain.holes.len(), "{seed}");
    }
}

#[test]
fn bad_facets_do_not_make_their_neighbours_leak() {
    // A triangle strip in which one triangle has no area: its neighbours name its edges.
    let mut cube = cubes(&[[0.0; 3]]);
    cube.vertices.push([0.5, 0.0, 0.0]);
    // The bottom edge 0-1 of the faces z = 0 and y = 0 is split in one of them only.
    cube.facets[2] = Facet::polygon(&[0, 8, 1, 5, 4], 0);
    assert_eq!(kinds(&cube, true)[0].0, DefectKind::TJunction);
    cube.facets.push(Facet::polygon(&[0, 1, 8], 0));
    let found = kinds(&cube, true);
    assert!(found.contains(&(DefectKind::Degenerate, 1)), "{found:?}");
    assert!(!found.iter().any(|&(kind, _)| kind == DefectKind::Leak), "{found:?}");
}

#[test]
fn heaps_of_overlapping_triangles_are_given_up_early() {
    let mut random = Random::new(5);
    let mut domain = Domain::default();
    for _ in 0..20_000 {
        let first = domain.vertices.len() as u32;
        domain.vertices.extend([0; 3].map(|_| [0; 3].map(|_| random.unit())));
        domain.facets.push(Facet::polygon(&[first, first + 1, first + 2], 0));
    }
    let report = check(&domain, false);
    assert!(report.count(DefectKind::Intersection) > 20_000);
    assert_eq!(report.defects.len(), 2000, "1000 each of intersections and leaks");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// A box turned and moved at random inside another: facets are not planar, but the domain can
    /// be prepared, and keeps its volume nearly.
    #[test]
    fn turned_boxes_are_prepared(q in prop::array::uniform4(-1.0..1.0_f64)) {
        let length = q.iter().map(|c| c * c).sum::<f64>();
        prop_assume!(length > 0.01);
        let [w, x, y, z] = q.map(|c| c / length.sqrt());
        let turn = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let mut domain = cubes(&[[0.0; 3], [0.0; 3]]);
        for p in &mut domain.vertices[8..] {
            let c = p.map(|c| 0.5 * (c - 0.5));
            *p = [0, 1, 2].map(|k| 0.5 + (0..3).map(|j| turn[k][j] * c[j]).sum::<f64>());
        }
        for facet in &mut domain.facets[6..] {
            facet.polygons[0].reverse();
        }
        let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
        let prepared = domain.prepare(&options).unwrap();
        prop_assert!(prepared.report.passed(), "{:?}", prepared.report.defects);
        prop_assert_eq!(prepared.domain.holes.len(), 1);
        let volume = prepared.report.volume().unwrap().to_f64();
        prop_assert!((volume - 0.875).abs() < 1e-6, "{}", volume);
        let lattice = prepared.lattice;
        prop_assert!(prepared.domain.vertices.iter().all(|p| lattice.steps(p).is_some()));
        prop_assert!(prepared.facet_map.iter().max() == Some(&11));
        if prepared.moved > 0 {
            let exact = PrepareOptions { exact_input: true, ..options };
            prop_assert_eq!(domain.prepare(&exact).unwrap_err().code(), "domain.off-lattice");
        }
    }
}

/// The projection alone decides what is Delaunay, if the corners are not in one plane: by distances
/// in space, flips of edges would go round in circles.
#[test]
fn facets_that_are_far_from_planar_have_triangles() {
    let mut random = Random::new(11);
    for round in 0..2000 {
        let count = 5 + round % 12;
        let mut domain = Domain::default();
        for i in 0..count {
            let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            let radius = 0.5 + random.unit();
            let height = 2.0 * (random.unit() - 0.5);
            domain.vertices.push([radius * angle.cos(), radius * angle.sin(), height]);
        }
        domain.facets.push(Facet::polygon(&(0..count).collect::<Vec<_>>(), 0));
        let found = domain.triangulate(0).unwrap();
        assert!(!found.planar);
        // Along another axis the polygon may cross itself.
        if found.is_sound() {
            assert_eq!(found.triangles.len(), count as usize - 2, "{domain:?}");
        }
    }
}

#[test]
fn a_shell_too_small_to_be_found_is_a_finding() {
    let tiny = |size: f64| {
        let mut domain = cubes(&[[-0.5; 3], [0.0; 3]]);
        for p in &mut domain.vertices[8..] {
            *p = p.map(|c| c * size);
        }
        check(&domain, false)
    };
    let report = tiny(2f64.powi(-26));
    assert!(report.passed(), "{:?}", report.defects);
    assert_eq!(report.cells.unwrap().len(), 2);
    let report = tiny(1e-200);
    assert_eq!(report.count(DefectKind::Unresolved), 1, "{:?}", report.defects);
    assert!(!report.is_meshable() && report.cells.is_none());
    assert_eq!(report.defects[0].elements.len(), 1);
}
