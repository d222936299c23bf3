//! The predicates against three others: `rug` (exact for any f64), our own exact twin, and
//! `robust` inside the window in which that crate is exact. On every input family of the
//! reference: uniform, coplanar and cospherical, exactly and within ulps, small integers, offsets,
//! clusters; each over the exponents of the window.
//!
//! Cases per family: 2,000, or `LTBW_CASES`.

use ltbw::predicates::{self, perturb, twin};
use ltbw::{Point, Sign};
use ltbw_tests::families::{Rng, two_to};
use ltbw_tests::five_points::{FACTORS, WINDOW};
use ltbw_tests::{cases, oracle};

fn for_all(check: impl Fn(&str, &[Point; 5])) {
    for (number, (name, draw)) in WINDOW.iter().enumerate() {
        let mut rng = Rng::new(number as u64);
        for case in 0..cases(2_000) {
            let factor = two_to(FACTORS[case as usize % FACTORS.len()]);
            let points = draw(&mut rng).map(|p| p.map(|c| c * factor));
            check(&format!("{name}, case {case}: {points:?}"), &points);
        }
    }
}

fn sign(value: f64) -> Sign {
    match value.partial_cmp(&0.0) {
        Some(std::cmp::Ordering::Less) => Sign::Negative,
        Some(std::cmp::Ordering::Greater) => Sign::Positive,
        _ => Sign::Zero,
    }
}

fn coord([x, y, z]: Point) -> robust::Coord3D<f64> {
    robust::Coord3D { x, y, z }
}

#[test]
fn orient3d_equals_all_oracles() {
    for_all(|name, points| {
        let [a, b, c, d, _] = points;
        let expected = oracle::orient3d(a, b, c, d);
        assert_eq!(predicates::orient3d(a, b, c, d), expected, "{name}");
        assert_eq!(twin::orient3d(a, b, c, d), expected, "twin: {name}");
        // Shewchuk's orientation is the mirror image of ours.
        let theirs = -robust::orient3d(coord(*a), coord(*b), coord(*c), coord(*d));
        assert_eq!(sign(theirs), expected, "robust: {name}");
    });
}

#[test]
fn insphere_equals_all_oracles() {
    for_all(|name, points| {
        let [a, b, c, d, e] = points;
        let expected = oracle::insphere(a, b, c, d, e);
        assert_eq!(predicates::insphere(a, b, c, d, e), expected, "{name}");
        assert_eq!(twin::insphere(a, b, c, d, e), expected, "twin: {name}");
        let theirs = -robust::insphere(coord(*a), coord(*b), coord(*c), coord(*d), coord(*e));
        assert_eq!(sign(theirs), expected, "robust: {name}");
    });
}

#[test]
fn the_planar_predicates_equal_all_oracles() {
    for_all(|name, points| {
        let [a, b, c, d, _] = points;
        let expected = oracle::coplanar_orient(a, b, c);
        assert_eq!(predicates::coplanar_orient(a, b, c), expected, "{name}");
        assert_eq!(twin::coplanar_orient(a, b, c), expected, "twin: {name}");
        let turn = robust::orient2d(
            robust::Coord { x: a[0], y: a[1] },
            robust::Coord { x: b[0], y: b[1] },
            robust::Coord { x: c[0], y: c[1] },
        );
        if turn != 0.0 {
            assert_eq!(sign(turn), expected, "robust: {name}");
        }
        if oracle::orient3d(a, b, c, d) == Sign::Zero && expected != Sign::Zero {
            let expected = oracle::side_of_bounded_circle(a, b, c, d);
            assert_eq!(predicates::side_of_bounded_circle(a, b, c, d), expected, "{name}");
            assert_eq!(twin::side_of_bounded_circle(a, b, c, d), expected, "twin: {name}");
        }
    });
}

#[test]
fn the_perturbed_predicates_equal_the_oracle_and_are_never_zero() {
    for_all(|name, points| {
        let mut distinct = points.to_vec();
        distinct.sort_by(|p, q| p.partial_cmp(q).expect("finite"));
        distinct.dedup();
        let [mut a, mut b, c, d, p] = points.each_ref();
        if distinct.len() < 5 {
            return;
        }
        if oracle::coplanar_orient(a, b, c) != Sign::Zero {
            let expected = oracle::side_of_hull_facet([a, b, c], p);
            assert_ne!(expected, Sign::Zero, "{name}");
            assert_eq!(perturb::side_of_hull_facet(a, b, c, p), expected, "{name}");
            if oracle::orient3d(a, b, c, p) == Sign::Zero {
                let expected = oracle::side_of_circle([a, b, c], p);
                assert_eq!(perturb::side_of_circle(a, b, c, p), expected, "{name}");
            }
        }
        match oracle::orient3d(a, b, c, d) {
            Sign::Zero => return,
            Sign::Negative => std::mem::swap(&mut a, &mut b),
            Sign::Positive => {}
        }
        let expected = oracle::side_of_sphere([a, b, c, d], p);
        assert_ne!(expected, Sign::Zero, "{name}");
        assert_eq!(perturb::side_of_sphere(a, b, c, d, p), expected, "{name}");
    });
}

/// The families would test nothing if they never met a zero or never missed one.
#[test]
fn the_families_hold_degenerate_and_general_cases() {
    let mut seen = [[0u32; 3]; 2];
    let seen = &mut seen;
    let count = std::cell::RefCell::new(seen);
    for_all(|_, [a, b, c, d, e]| {
        let mut count = count.borrow_mut();
        count[0][(oracle::orient3d(a, b, c, d) as i8 + 1) as usize] += 1;
        count[1][(oracle::insphere(a, b, c, d, e) as i8 + 1) as usize] += 1;
    });
    let count = count.into_inner();
    assert!(count.iter().flatten().all(|&n| n > 1_000), "{count:?}");
}
