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
