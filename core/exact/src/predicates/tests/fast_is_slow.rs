//! Fast equals slow, on every input family.

use proptest::prelude::*;

use super::families::{self, Five};
use crate::Point;
use crate::predicates::{self as fast, Sign, exact, filter, twin};

/// The sign of a float as `robust` returns it, in our orientation: its determinants are negated.
fn negated(value: f64) -> Sign {
    -Sign::from_f64(value)
}

fn coord(p: Point) -> robust::Coord3D<f64> {
    robust::Coord3D { x: p[0], y: p[1], z: p[2] }
}

/// All predicates on five points, in every stage, against the twins.
fn check(five: &Five) -> Result<(), TestCaseError> {
    let [a, b, c, d, e] = five;

    let orient = twin::orient3d(a, b, c, d);
    prop_assert_eq!(fast::orient3d(a, b, c, d), orient);
    prop_assert_eq!(exact::orient3d(a, b, c, d), orient);
    if let Some(sign) = filter::orient3d_any(a, b, c, d) {
        prop_assert_eq!(sign, orient);
    }

    let side = twin::insphere(a, b, c, d, e);
    prop_assert_eq!(fast::insphere(a, b, c, d, e), side);
    prop_assert_eq!(exact::insphere(a, b, c, d, e), side);
    if let Some(sign) = filter::insphere_any(a, b, c, d, e) {
        prop_assert_eq!(sign, side);
    }

    let turn = twin::coplanar_orient(a, b, c);
    prop_assert_eq!(fast::coplanar_orient(a, b, c), turn);
    prop_assert_eq!(exact::coplanar_orient(a, b, c), turn);
    prop_assert_eq!(fast::collinear(a, b, c), twin::collinear(a, b, c));
    prop_assert_eq!(fast::collinear(a, b, c), turn.is_zero());

    // The circle test is defined for coplanar points alone.
    if orient.is_zero() {
        let circle = twin::side_of_bounded_circle(a, b, c, d);
        prop_assert_eq!(fast::side_of_bounded_circle(a, b, c, d), circle);
        prop_assert_eq!(fast::side_of_bounded_circle(b, a, c, d), circle);
        prop_assert_eq!(exact::side_of_bounded_circle(a, b, c, d), circle);
    }
    Ok(())
}

/// Inside the window also the filters without a guard, and `robust` as a second oracle.
fn check_in_window(five: &Five) -> Result<(), TestCaseError> {
    check(five)?;
    let [a, b, c, d, e] = five;
    let orient = fast::orient3d(a, b, c, d);
    if let Some(sign) = filter::orient3d_window(a, b, c, d) {
        prop_assert_eq!(sign, orient);
    }
    let side = fast::insphere(a, b, c, d, e);
    if let Some(sign) = filter::insphere_window(a, b, c, d, e) {
        prop_assert_eq!(sign, side);
    }
    let [a, b, c, d, e] = five.map(coord);
    prop_assert_eq!(negated(robust::orient3d(a, b, c, d)), orient);
    prop_assert_eq!(negated(robust::insphere(a, b, c, d, e)), side);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn all_families_equal_the_twins(five in families::everything()) {
        check(&five)?;
    }

    #[test]
    fn the_window_agrees_with_robust_too(five in families::in_window()) {
        check_in_window(&five)?;
    }

    /// The stages at the ends of their ranges, where an overflow would show.
    #[test]
    fn full_width_differences(five in families::full_width()) {
        check_in_window(&five)?;
        let [a, b, c, d, e] = five;
        // Also with the base of the planar differences in third and fourth place.
        check(&[a, b, e, d, c])?;
        check(&[a, b, c, e, d])?;
    }

    /// Exact zeros, where a product that rounds would show as a sign: around the widths at which
    /// one stage passes on to the next.
    #[test]
    fn zeros_at_the_ends_of_the_first_stages(
        five in prop_oneof![
            families::cospherical_of_bits(7..12),
            families::cospherical_of_bits(14..18),
        ],
    ) {
        let [a, b, c, d, e] = &five;
        prop_assert_eq!(exact::insphere(a, b, c, d, e), Sign::Zero);
    }

    /// Five points of one plane: every circle test is meaningful.
    #[test]
    fn coplanar_points_at_any_scale(
        five in families::coplanar(),
        exponent in -1000..900_i32,
    ) {
        let factor = families::two_to(exponent);
        check(&five.map(|p| p.map(|c| c * factor)))?;
    }
}

#[test]
fn conventions() {
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (inside, outside) = ([0.5, 0.5, 0.4], [2.0, 0.0, 0.0]);
    assert_eq!(fast::orient3d(&o, &x, &y, &z), Sign::Positive);
    assert_eq!(twin::orient3d(&o, &x, &y, &z), Sign::Positive);
    for (point, sign) in [(inside, Sign::Positive), (outside, Sign::Negative), (x, Sign::Zero)] {
        assert_eq!(fast::insphere(&o, &x, &y, &z, &point), sign);
        assert_eq!(fast::insphere(&x, &o, &y, &z, &point), -sign);
        assert_eq!(twin::insphere(&o, &x, &y, &z, &point), sign);
    }
    assert_eq!(fast::coplanar_orient(&o, &x, &y), Sign::Positive);
    assert_eq!(fast::coplanar_orient(&o, &y, &z), Sign::Positive);
    assert_eq!(fast::coplanar_orient(&o, &x, &z), Sign::Positive);
    let [near, corner] = [[0.5, 0.5, 0.0], [1.0, 1.0, 0.0]];
    for (point, sign) in [(near, Sign::Positive), (corner, Sign::Zero), (outside, Sign::Negative)] {
        assert_eq!(fast::side_of_bounded_circle(&o, &x, &y, &point), sign);
        assert_eq!(fast::side_of_bounded_circle(&o, &y, &x, &point), sign);
        assert_eq!(twin::side_of_bounded_circle(&o, &x, &y, &point), sign);
    }
    // No circle through collinear points.
    assert_eq!(fast::side_of_bounded_circle(&o, &x, &outside, &y), Sign::Zero);
}

#[test]
fn minus_zero_is_zero() {
    let [o, x, y] = [[-0.0; 3], [1.0, -0.0, 0.0], [0.0, 1.0, -0.0]];
    let z = [-0.0, 0.0, 1.0];
    assert_eq!(fast::orient3d(&o, &x, &y, &z), Sign::Positive);
    assert_eq!(fast::cmp_xyz(&o, &[0.0; 3]), std::cmp::Ordering::Equal);
    assert_eq!(fast::insphere(&o, &x, &y, &z, &[0.0; 3]), Sign::Zero);
}
