//! Every input family of the bars against CGAL: set equality of finite tetrahedra and hull facets,
//! and of the hash; for each small set in twenty shuffled orders as well.
//!
//! Full sizes: `cargo xtask bars`.

use ltbw::{Order, Point};
use ltbw_tests::cgal::Cgal;
use ltbw_tests::compare::{compare, compare_with};
use ltbw_tests::families::{Rng, Size, all, grid, more_speed, snapped, wide};

#[test]
fn every_family_equals_cgal() {
    let Some(mut cgal) = Cgal::for_test("every_family_equals_cgal") else { return };
    let more = more_speed(Size::Moderate).into_iter().chain(wide(Size::Moderate));
    for family in all(Size::Moderate).into_iter().chain(more) {
        if let Err(difference) = compare(&mut cgal, &family.points, Order::Brio) {
            panic!("{} of {} points: {difference}", family.name, family.points.len());
        }
    }
}

#[test]
fn twenty_orders_of_every_small_set_equal_cgal() {
    let Some(mut cgal) = Cgal::for_test("twenty_orders_of_every_small_set_equal_cgal") else {
        return;
    };
    let mut rng = Rng::new(20);
    let more = more_speed(Size::Small).into_iter().chain(wide(Size::Small));
    for mut family in all(Size::Small).into_iter().chain(more) {
        for turn in 0..20 {
            rng.shuffle(&mut family.points);
            // The tetrahedra name indices, so CGAL is asked for each order anew.
            let reply = cgal.triangulate(&family.points).expect("CGAL answers");
            for order in [Order::Input, Order::Brio] {
                if let Err(difference) = compare_with(&reply, &family.points, order) {
                    panic!("{}, order {turn}, {order:?}: {difference}", family.name);
                }
            }
        }
    }
}

#[test]
fn sets_without_volume_are_refused_as_cgal_does() {
    let Some(mut cgal) = Cgal::for_test("sets_without_volume_are_refused_as_cgal_does") else {
        return;
    };
    let flat: Vec<Point> = grid(4).into_iter().map(|[x, y, _]| [x, y, x + 2.0 * y]).collect();
    let line: Vec<Point> = (0..9).map(|i| [f64::from(i) * 0.1; 3]).collect();
    let corner = grid(2)[..3].to_vec();
    for points in [vec![], vec![[1.0; 3]; 5], corner, line, flat] {
        if let Err(difference) = compare(&mut cgal, &points, Order::Brio) {
            panic!("{points:?}: {difference}");
        }
    }
}

/// A fixed sample of the random degenerate sets; `proptest_cgal.rs` draws new ones and shrinks.
#[test]
fn snapped_sets_equal_cgal() {
    let Some(mut cgal) = Cgal::for_test("snapped_sets_equal_cgal") else { return };
    for seed in 0..500 {
        let points = snapped(seed);
        if let Err(difference) = compare(&mut cgal, &points, Order::Input) {
            panic!("seed {seed}: {points:?}: {difference}");
        }
    }
}
