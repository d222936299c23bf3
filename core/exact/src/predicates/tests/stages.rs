//! Each stage is really used: a stage that always passes its input on is correct and useless.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use super::families::{self, Five};
use crate::predicates::{Sign, exact, filter};

/// `count` values of a family, always the same ones.
fn sample(family: &impl Strategy<Value = Five>, count: usize) -> Vec<Five> {
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    (0..count).map(|_| family.new_tree(&mut runner).expect("no filters").current()).collect()
}

/// The share of the family that `decided` accepts.
fn share(family: &impl Strategy<Value = Five>, decided: impl Fn(&Five) -> bool) -> f64 {
    let points = sample(family, 4000);
    points.iter().filter(|five| decided(five)).count() as f64 / points.len() as f64
}

#[test]
fn filters_decide_random_input() {
    let family = families::uniform();
    let orient_window =
        share(&family, |[a, b, c, d, _]| filter::orient3d_window(a, b, c, d).is_some());
    let orient_any = share(&family, |[a, b, c, d, _]| filter::orient3d_any(a, b, c, d).is_some());
    let side_window =
        share(&family, |[a, b, c, d, e]| filter::insphere_window(a, b, c, d, e).is_some());
    let side_any = share(&family, |[a, b, c, d, e]| filter::insphere_any(a, b, c, d, e).is_some());
    let turn = share(&family, |[a, b, c, _, _]| filter::orient2d_any(a, b, c, [0, 1]).is_some());
    let circle =
        share(&family, |[a, b, c, d, _]| filter::incircle_any(a, b, c, d, [1, 2]).is_some());
    for share in [orient_window, orient_any, side_window, side_any, turn, circle] {
        assert!(share > 0.999, "a filter decides only {share} of random input");
    }
}

#[test]
fn filters_never_decide_a_zero_but_by_extent() {
    let family = families::cospherical();
    for five in sample(&family, 2000) {
        let [a, b, c, d, e] = &five;
        assert_eq!(exact::insphere(a, b, c, d, e), Sign::Zero);
        assert_eq!(filter::insphere_window(a, b, c, d, e), None);
    }
}

#[test]
fn wide_exponents_are_decided_by_the_guarded_filter() {
    // Far outside the window, yet with extents inside the guard.
    let family = families::scaled(-170..-150);
    let decided = share(&family, |[a, b, c, d, _]| filter::orient3d_any(a, b, c, d).is_some());
    assert!(decided > 0.3, "the guard refuses extents that it should not: {decided}");
}

#[test]
fn lattice_filters_decide_few_steps_exactly_and_no_more() {
    use crate::Point;
    let mut bits = 0x9e37_79b9_7f4a_7c15u64;
    let mut next = move |bound: u64| {
        bits ^= bits << 13;
        bits ^= bits >> 7;
        bits ^= bits << 17;
        (bits >> 11) % bound
    };
    let (mut zeros, mut beyond) = (0, 0);
    for round in 0..40_000u64 {
        let step = 2f64.powi((next(300) as i32) - 120);
        // Extents of up to 2^9 steps are decided for insphere, of up to 2^16 for orient3d.
        let span = [2, 9, 10, 16, 17, 30][round as usize % 6];
        let offset = next(1 << 20) as f64;
        let mut point =
            || -> Point { [0, 1, 2].map(|_| (offset + next((1 << span) + 1) as f64) * step) };
        let [a, b, c, d] = [point(), point(), point(), point()];
        // Half of the time a fifth vertex of the box of a and b, often cospherical.
        let e = if round % 2 == 0 { point() } else { [a[0], b[1], a[2]] };
        let side = filter::insphere_lattice([&a, &b, &c, &d], &e, step);
        let turn = filter::orient3d_lattice(&a, &b, &c, &d, step);
        if let Some(sign) = side {
            assert_eq!(sign, exact::insphere(&a, &b, &c, &d, &e), "{a:?} {b:?} {c:?} {d:?} {e:?}");
            zeros += u32::from(sign.is_zero());
        }
        if let Some(sign) = turn {
            assert_eq!(sign, exact::orient3d(&a, &b, &c, &d), "{a:?} {b:?} {c:?} {d:?}");
            zeros += u32::from(sign.is_zero());
        }
        assert!(side.is_some() || span > 9 && turn.is_some() || span > 16, "{span} bits");
        let window = filter::insphere_window(&a, &b, &c, &d, &e);
        assert!(window.is_none() || window == side);
        assert!(filter::insphere_lattice([&a, &b, &c, &d], &e, 0.0) == window);
        beyond += u32::from(side.is_none());
    }
    assert!(zeros > 1000 && beyond > 10, "{zeros} zeros, {beyond} left to the exact stages");
}

#[test]
fn lattice_filters_decide_zeros_up_to_their_number_of_steps() {
    let decided = |yes: bool| yes.then_some(Sign::Zero);
    for exponent in [-120, -40, -1, 0, 1, 40, 120] {
        let step = families::two_to(exponent);
        for (turn, extent) in
            (0..3).flat_map(|turn| [511, 512, 513, 65_535, 65_536, 65_537].map(|e| (turn, e)))
        {
            let at = |x: u32, y: u32, z: u32| {
                let mut p = [x, y, z].map(|c| f64::from(1000 + c) * step);
                p.rotate_left(turn);
                p
            };
            // Five corners of a box, and the four of a parallelogram.
            let box_of = [at(0, 0, 0), at(extent, 5, 0), at(extent, 0, 7), at(0, 5, 7)];
            let side = filter::insphere_lattice(box_of.each_ref(), &at(extent, 5, 7), step);
            assert_eq!(side, decided(extent <= 512), "{extent} {exponent}");
            let [a, b, c, d] = [at(0, 0, 0), at(extent, 3, 1), at(extent, 5, 8), at(0, 2, 7)];
            let side = filter::orient3d_lattice(&a, &b, &c, &d, step);
            assert_eq!(side, decided(extent <= 65_536), "{extent} {exponent}");
        }
    }
}

#[test]
fn the_constants_that_the_bounds_are_made_of() {
    let of =
        |constant: f64, exponent| assert_eq!(constant.to_bits(), 2f64.powi(exponent).to_bits());
    of(filter::UNIT_ROUNDOFF, -53);
    of(filter::GUARD_LOW, -190);
    of(filter::GUARD_HIGH, 200);
}
