//! The full Delaunay mesh of a refined domain's vertices, exterior included, against CGAL's: points
//! on lattices, facets and segments are as degenerate as points come.
//!
//! Named domains; random ones: 10 by default, `LTBW_CASES` for more (100 for the full bar).

use ltbw::refine::{InsertOrder, Refined, Refiner};
use ltbw::refining::rounds_on_threads;
use ltbw::threads::Parallel;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_tests::cases;
use ltbw_tests::cgal::Cgal;
use ltbw_tests::compare::compare_mesh;
use ltbw_tests::domains::{NAMED, prepared, random_domain};

/// Compares the mesh of a refined domain with CGAL's of its vertices; returns their number.
fn compare(cgal: &mut Cgal, name: &str, refined: &Refined) -> usize {
    let mesh = refined.mesh();
    let reply = cgal.triangulate(&mesh.to_tet_mesh().points).expect("CGAL answers");
    if let Err(difference) = compare_mesh(&reply, mesh) {
        panic!("{name}: {difference}");
    }
    mesh.num_vertices()
}

#[test]
fn meshes_of_named_domains_equal_cgal() {
    let Some(mut cgal) = Cgal::for_test("meshes_of_named_domains_equal_cgal") else { return };
    let mut points = 0;
    let field = |p: ltbw::Point| 0.2 + 0.1 * p[0];
    let mut all = Vec::new();
    for (kind, volume, angle, _) in NAMED {
        all.push((kind, angle, Refiner::new().max_volume(volume)));
    }
    for kind in [DomainKind::CubeOctahedron, DomainKind::Gear, DomainKind::TwoMaterial] {
        all.push((kind, None, Refiner::new().sizing(&field)));
    }
    for angle in [0.1, 0.5, 2.0, 10.0, 20.0, 60.0] {
        all.push((DomainKind::Wedge, Some(angle), Refiner::new().max_volume(1e-2)));
    }
    for (kind, angle, refiner) in &all {
        let shape = Shape { angle: *angle, ..Shape::default() };
        let ready = prepared(&generate_domain(*kind, &shape).expect("a domain"));
        let refined = refiner.start(0).refine(&ready.domain, &ready.lattice).expect("a mesh");
        points += compare(&mut cgal, &format!("{kind:?} {angle:?}"), &refined);
    }
    println!("{} named domains of {points} vertices in all equal CGAL", all.len());
    assert!(points > 10_000, "{points}");
}

#[test]
fn meshes_of_random_domains_equal_cgal() {
    let Some(mut cgal) = Cgal::for_test("meshes_of_random_domains_equal_cgal") else { return };
    let (count, mut points) = (cases(10), 0);
    for seed in 0..u64::from(count) {
        let (name, domain) = random_domain(seed);
        let ready = prepared(&domain);
        // One in three in rounds, in an order of its own, and one by workers that share no mesh.
        let order = InsertOrder::Random(seed);
        let start = if seed % 3 == 0 { usize::MAX } else { 0 };
        let refiner = Refiner::new().max_volume(2e-3).insert_order(order).start(start);
        let whole = (&ready.domain, &ready.lattice);
        let refined = match seed % 3 {
            2 => rounds_on_threads(&refiner, whole, &Parallel::new(4)).expect("a mesh").refined,
            _ => refiner.refine(&ready.domain, &ready.lattice).expect("a mesh"),
        };
        points += compare(&mut cgal, &format!("{name} {seed}"), &refined);
    }
    assert!(points > 100 * count as usize, "{points}");
    println!("{count} refined domains of {points} vertices in all equal CGAL");
}
