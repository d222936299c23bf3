//! The full Delaunay mesh of a refined domain's vertices, exterior included, against CGAL's: points
//! on lattices, facets and segments are as degenerate as points come.
//!
//! Random domains: 10 by default, `LTBW_CASES` for more (100 for the full bar).

use ltbw::domain::PrepareOptions;
use ltbw::refine::{InsertOrder, Refiner};
use ltbw::refining::rounds_on_threads;
use ltbw::threads::Parallel;
use ltbw_tests::cases;
use ltbw_tests::cgal::Cgal;
use ltbw_tests::compare::compare_mesh;
use ltbw_tests::domains::random_domain;

#[test]
fn meshes_of_random_domains_equal_cgal() {
    let Some(mut cgal) = Cgal::for_test("meshes_of_random_domains_equal_cgal") else { return };
    let (count, mut points) = (cases(10), 0);
    for seed in 0..u64::from(count) {
        let (name, domain) = random_domain(seed);
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        // One in three in rounds, in an order of its own, and one by workers that share no mesh.
        let order = InsertOrder::Random(seed);
        let start = if seed % 3 == 0 { usize::MAX } else { 0 };
        let refiner = Refiner::new().max_volume(2e-3).insert_order(order).start(start);
        let whole = (&ready.domain, &ready.lattice);
        let refined = match seed % 3 {
            2 => rounds_on_threads(&refiner, whole, &Parallel::new(4)).expect("a mesh").refined,
            _ => refiner.refine(&ready.domain, &ready.lattice).expect("a mesh"),
        };
        let mesh = refined.mesh();
        let reply = cgal.triangulate(&mesh.to_tet_mesh().points).expect("CGAL answers");
        if let Err(difference) = compare_mesh(&reply, mesh) {
            panic!("{name} {seed}: {difference}");
        }
        points += mesh.num_vertices();
    }
    assert!(points > 100 * count as usize, "{points}");
    println!("{count} refined domains of {points} vertices in all equal CGAL");
}
