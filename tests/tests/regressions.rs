//! Findings of the random tests and of the fuzzer, one named set each, against brute force by
//! definition (and so without CGAL).

use ltbw::{Builder, Order, Point, PointSet};
use ltbw_tests::compare::canonical;
use ltbw_tests::oracle::brute_force;

/// Any order of insertion must give the Delaunay tetrahedra of `points` by definition.
fn by_definition(points: &[Point]) {
    let set = PointSet::new(points.to_vec()).expect("finite points");
    for order in [Order::Brio, Order::Input] {
        let built = Builder::new().order(order).build(&set).expect("a set of dimension 3");
        let tets: Vec<[u32; 4]> = built.mesh.tets().collect();
        assert_eq!(canonical(&tets), brute_force(points), "{order:?}");
    }
}

/// Eight points within an ulp of a sphere.
#[test]
fn nearly_cospherical_tenths() {
    by_definition(&[
        [-0.19999999999999998, -0.2, -0.1],
        [-0.19999999999999998, 0.1, 0.6000000000000001],
        [0.1, -0.2, -0.2],
        [-0.4, -0.30000000000000004, 0.39999999999999997],
        [0.10000000000000002, -0.2, -0.2],
        [-0.6000000000000001, -0.1, -0.20000000000000004],
        [-0.6, 0.1, 0.2],
        [-0.3000000000000001, 0.0, 0.0],
    ]);
}
