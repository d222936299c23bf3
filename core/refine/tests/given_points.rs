//! Points given in a domain: vertices of its mesh, inside, on facets, on segments.

use ltbw_core::{Point, canonical_hash};
use ltbw_domain::exterior::LEFT_OUT;
use ltbw_domain::{Domain, PrepareOptions, Prepared};
use ltbw_generate::scattered::scattered;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_refine::{RefineOutcome, Refined, Refiner};
use ltbw_verify::{Conformity, ConformityDefect, Limits, Mesh, Options, Plc, PlcFacet, conforms};
use std::collections::HashSet;

pub(crate) fn prepared(domain: &Domain) -> Prepared {
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

/// A domain as the checker takes it: its points are vertices that have to be in the mesh.
pub(crate) fn plc_of(domain: &Domain) -> Plc {
    let facet = |f: &ltbw_domain::Facet| PlcFacet {
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
        flat_tolerance: 0.0,
    }
}

fn judged(refined: &Refined, plc: &Plc) -> Conformity {
    judged_within(refined, plc, &Limits::default())
}

/// The judgement of the independent checker.
pub(crate) fn judged_within(refined: &Refined, plc: &Plc, limits: &Limits) -> Conformity {
    let mesh = refined.inside();
    let own = Mesh::new(&mesh.points, &mesh.tets);
    conforms(&own, plc, mesh.tet_tags.as_deref(), limits, &Options::default())
}

pub(crate) fn with_points(kind: DomainKind, points: Vec<Point>) -> Prepared {
    let domain = generate_domain(kind, &Shape::default()).expect("a domain");
    prepared(&Domain { points, ..domain })
}

fn hash(refined: &Refined) -> String {
    let mesh = refined.inside();
    canonical_hash(&mesh.points, &mesh.tets).expect("a hash").to_string()
}

/// Refines, and has the checker find all points in the mesh.
fn certified(ready: &Prepared, volume: f64) -> Refined {
    let refiner = Refiner::new().max_volume(volume);
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    assert!(
        matches!(refined.outcome, RefineOutcome::Met | RefineOutcome::Excused),
        "{:?} {:?}",
        refined.outcome,
        refined.lost.first()
    );
    let found = judged(&refined, &plc_of(&ready.domain));
    assert!(found.passed(), "{:?} {:?}", found.findings.first(), found.mesh_defects.first());
    // Their numbers follow those of the vertices.
    let first = ready.domain.vertices.len();
    let mesh = refined.inside();
    let used: HashSet<u32> = mesh.tets.iter().flatten().copied().collect();
    for (k, p) in ready.domain.points.iter().enumerate() {
        assert_eq!(mesh.points[first + k], *p);
        assert!(used.contains(&((first + k) as u32)), "{p:?} is outside");
    }
    refined
}

#[test]
fn a_thousand_points_are_vertices() {
    for (kind, volume) in [
        (DomainKind::CubeOctahedron, 1e-3),
        (DomainKind::CubeInCube, 1e-3),
        (DomainKind::Tee, 1e-2),
        (DomainKind::Gear, 1e-2),
    ] {
        let domain = generate_domain(kind, &Shape::default()).expect("a domain");
        let points = scattered(&domain, 7, 340);
        let (facets, edges) = (points.on_facets.len(), points.on_edges.len());
        let all = points.all();
        let ready = with_points(kind, all.clone());
        let placed = &ready.placed;
        assert!(
            placed.on_edges > edges * 9 / 10 && placed.on_facets > facets * 9 / 10,
            "{placed:?}"
        );
        assert!(placed.farthest <= 3.0 * ready.lattice.step(), "{placed:?}");
        let left_out = placed.map.iter().filter(|&&number| number == LEFT_OUT).count();
        assert_eq!(left_out, ready.repairs.exterior_points);
        assert!(kind == DomainKind::CubeInCube || left_out > 0, "{kind:?}");
        assert!(ready.domain.points.len() + left_out + placed.doubled == all.len());
        assert!(ready.domain.points.len() > 750, "{kind:?} {}", ready.domain.points.len());
        let refined = certified(&ready, volume);
        // A judge who is given another place does not find it.
        let mut wrong = plc_of(&ready.domain);
        let last = wrong.vertices.len() - 1;
        wrong.vertices[last][0] += 2_f64.powi(-20);
        let found = judged(&refined, &wrong);
        assert_eq!(found.counts[&ConformityDefect::VertexMissing], 1, "{kind:?}");
    }
}

#[test]
fn the_mesh_depends_on_no_order() {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a domain");
    let all = scattered(&domain, 3, 60).all();
    let ready = with_points(DomainKind::CubeOctahedron, all.clone());
    let refiner = Refiner::new().max_volume(1e-3).start(256);
    let one = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let mut turned = Domain { points: all, ..domain };
    turned.points.reverse();
    turned.points.extend(turned.points.clone());
    turned.facets.reverse();
    let turned = prepared(&turned);
    assert_eq!(turned.domain.points.len(), ready.domain.points.len());
    let other = refiner.refine(&turned.domain, &turned.lattice).expect("a mesh");
    assert_eq!(hash(&one), hash(&other));
}

#[test]
fn isolated_vertices_of_a_domain_are_vertices_wherever_they_are() {
    let cube = Domain::cuboid([0.0; 3], [1.0; 3]);
    let spare: [Point; 6] = [
        [0.5, 0.25, 0.5],
        [0.3, 0.0, 0.7],
        [0.3, 0.0, 0.0],
        [0.3, 0.3, 1.0 + 1e-9],
        [0.3, 1.5, 0.0],
        [1.0; 3],
    ];
    let mut domain = cube.clone();
    domain.vertices.splice(0..0, spare);
    domain.facets.iter_mut().flat_map(|f| f.polygons.iter_mut().flatten()).for_each(|v| *v += 6);
    let ready = prepared(&domain);
    assert_eq!(ready.domain.vertices.len(), 9, "one inside");
    let ends = &ready.vertex_map[..6];
    assert_eq!(ends[4], LEFT_OUT);
    let place = |number: u32| match ready.domain.vertices.get(number as usize) {
        Some(p) => *p,
        None => ready.domain.points[number as usize - 9],
    };
    let places = [0, 1, 2, 3, 5].map(|k| place(ends[k]));
    let step = ready.lattice.step();
    for (at, k) in places.iter().zip([0, 1, 2, 3, 5]) {
        assert!((0..3).all(|i| (at[i] - spare[k][i]).abs() <= 2.0 * step), "{at:?}");
    }
    assert_eq!((places[1][1], places[2][1], places[2][2], places[3][2]), (0.0, 0.0, 0.0, 1.0));
    assert_eq!((ready.placed.on_edges, ready.placed.on_facets), (1, 2));
    assert_eq!(ready.repairs.exterior_vertices, 1);
    let refined = certified(&ready, 0.05);
    assert_eq!(refined.outcome, RefineOutcome::Met);
    // The others are refused where that is asked for.
    let strict = PrepareOptions { strict: true, ..PrepareOptions::default() };
    let outside = Domain { points: vec![[2.0, 0.5, 0.5]], ..cube.clone() };
    let error = outside.prepare(&strict).expect_err("a point outside").to_string();
    assert!(error.contains("1 point left out: outside"), "{error}");
    let inside = Domain { points: vec![[0.25; 3]], ..cube };
    inside.prepare(&strict).expect("a point inside");
}
