use super::*;
use proptest::prelude::*;

#[test]
fn numbers_ascend_as_coordinates_do_and_come_back() {
    let all = [f64::MIN, -1.5, -f64::MIN_POSITIVE, -5e-324, 0.0, 5e-324, 1.0, f64::MAX];
    let keys: Vec<[u64; 3]> = all.iter().map(|&c| ascending(&[c; 3])).collect();
    assert!(keys.is_sorted() && keys.windows(2).all(|pair| pair[0] != pair[1]));
    for (key, c) in keys.iter().zip(all) {
        assert_eq!(of_ascending(*key).map(f64::to_bits), [c.to_bits(); 3]);
    }
    assert_eq!(ascending(&[-0.0; 3]), ascending(&[0.0; 3]));
}

#[test]
fn magnitudes_of_parts_joined_are_those_of_all() {
    let all = vec![[0.0; 3], [1e-300, 2.0, -0.0], [1e300, 0.0, -3.0], [0.5, 0.25, 1e-310]];
    let of = |points: &[Point]| Magnitudes::of(&mut points.to_vec()).unwrap();
    for count in 0..all.len() {
        for cut in 0..=count {
            let joined = of(&all[..cut]).join(of(&all[cut..count]));
            assert_eq!(joined, of(&all[..count]));
            assert_eq!(joined.mode(), mode_of(&all[..count]));
        }
    }
    assert_eq!((of(&[]), Magnitudes::NONE.mode()), (Magnitudes::NONE, Mode::Normal));
    assert_eq!((of(&all).mode(), of(&all[..2]).mode() == Mode::Normal), (Mode::Wide, false));
}

fn bits(points: &[Point]) -> Vec<[u64; 3]> {
    points.iter().map(|p| p.map(f64::to_bits)).collect()
}

fn mode_of(points: &[Point]) -> Mode {
    PointSet::new(points.to_vec()).expect("finite").mode()
}

/// 2^exponent, subnormal ones included.
fn power(exponent: i32) -> f64 {
    let half = exponent / 2;
    power_of_two(half) * power_of_two(exponent - half)
}

#[test]
fn values_that_are_not_finite_are_named() {
    for (axis, name) in [(0, 'x'), (1, 'y'), (2, 'z')] {
        for value in [f64::INFINITY, f64::NEG_INFINITY] {
            let mut points = vec![[0.0, 1.0, 2.0]; 5];
            points[3][axis] = value;
            points[4] = [f64::NAN; 3];
            let error = PointSet::new(points).expect_err("not finite");
            assert_eq!(error, PointError::NotFinite { index: 3, axis: name, value });
        }
    }
    let error = PointSet::new(vec![[0.0, f64::NAN, 0.0]]).expect_err("NaN");
    assert_eq!(error.to_string(), "point 0: coordinate y is NaN, which is not finite");
}

#[test]
fn flat_lists_are_triples() {
    let set = PointSet::from_flat(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).expect("two points");
    assert_eq!(set.points(), [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
    let error = PointSet::from_flat(&[0.0; 4]).expect_err("four numbers");
    assert_eq!(error, PointError::NotTriples { count: 4 });
    assert!(PointSet::from_flat(&[]).expect("no points").is_empty());
}

#[test]
fn too_many_points_are_refused() {
    assert_eq!(check_count(MAX_POINTS), Ok(()));
    let error = PointError::TooMany { count: MAX_POINTS + 1, limit: MAX_POINTS };
    assert_eq!(check_count(MAX_POINTS + 1), Err(error));
}

#[test]
fn minus_zero_becomes_zero() {
    let set = PointSet::new(vec![[-0.0, 1.0, -0.0]]).expect("finite");
    assert_eq!(bits(set.points()), bits(&[[0.0, 1.0, 0.0]]));
    let admitted = set.mode().admit([-0.0; 3]).expect("finite").expect("in the window");
    assert_eq!(bits(&[admitted]), bits(&[[0.0; 3]]));
}

#[test]
fn the_window_has_these_ends() {
    let (low, high) = (power(-142), power(200));
    let below = |x: f64| f64::from_bits(x.to_bits() - 1);
    assert_eq!(mode_of(&[]), Mode::Normal);
    assert_eq!(mode_of(&[[0.0; 3]]), Mode::Normal);
    assert_eq!(mode_of(&[[low, -below(high), 0.0]]), Mode::Normal);
    // One step beyond either end: the range is one exponent too wide.
    assert_eq!(mode_of(&[[low, high, 0.0]]), Mode::Wide);
    assert_eq!(mode_of(&[[below(low), -below(high), 0.0]]), Mode::Wide);
    assert!(matches!(mode_of(&[[below(low), 1.0, 0.0]]), Mode::Rescaled { .. }));
    assert!(matches!(mode_of(&[[1.0, -high, 0.0]]), Mode::Rescaled { .. }));
    assert_eq!(mode_of(&[[f64::from_bits(1), f64::MAX, 0.0]]), Mode::Wide);
}

#[test]
fn every_range_that_fits_is_rescaled() {
    for low in (-1074..=682).step_by(7) {
        let widest = [power(low), power(low + 341) * 1.75, 0.0];
        let set = PointSet::new(vec![widest]).expect("finite");
        if low == -142 {
            assert_eq!(set.mode(), Mode::Normal);
        } else {
            assert_eq!(set.mode(), Mode::Rescaled { exponent: -142 - low });
        }
        assert!(set.kernel_points()[0].iter().all(|&c| in_window(c)));
        assert_eq!(mode_of(&[[power(low), power(low + 342), 0.0]]), Mode::Wide);
    }
}

#[test]
fn normal_sets_are_not_copied() {
    let set = PointSet::new(vec![[1.0, 2.0, 3.0]]).expect("finite");
    assert!(matches!(set.kernel_points(), Cow::Borrowed(_)));
    assert_eq!(set.kernel_point(0), Some([1.0, 2.0, 3.0]));
    assert_eq!(set.kernel_point(1), None);
    assert_eq!((set.len(), set.is_empty()), (1, false));
}

#[test]
fn later_points_are_admitted_under_the_same_scale() {
    let mode = mode_of(&[[power(-700), 0.0, 0.0]]);
    let Mode::Rescaled { exponent } = mode else { panic!("{mode:?}") };
    assert_eq!(exponent, 728);
    let admit = |c: f64| mode.admit([c, 0.0, 0.0]).expect("finite");
    assert_eq!(admit(power(-700)), Some([power(28), 0.0, 0.0]));
    assert_eq!(admit(power(-700 - 170)), Some([power(-142), 0.0, 0.0]));
    assert_eq!(admit(power(-700 - 171)), None);
    assert_eq!(admit(power(-700 + 171)), Some([power(199), 0.0, 0.0]));
    assert_eq!(admit(power(-700 + 172)), None);
    assert_eq!(admit(1.0), None);
    assert_eq!(admit(f64::MAX), None);
    // Under a scale that shrinks, small values underflow to zero: they are not zero.
    let shrinking = mode_of(&[[power(1000), 0.0, 0.0]]);
    assert_eq!(shrinking.admit([f64::from_bits(1), 0.0, 0.0]), Ok(None));
    assert_eq!(Mode::Normal.admit([power(200), 0.0, 0.0]), Ok(None));
    let far = [power(200), f64::from_bits(1), f64::MAX];
    assert_eq!(Mode::Wide.admit(far), Ok(Some(far)));
    let error = PointError::NotFinite { index: 0, axis: 'z', value: f64::INFINITY };
    for mode in [Mode::Normal, mode, Mode::Wide] {
        assert_eq!(mode.admit([0.0, 0.0, f64::INFINITY]), Err(error.clone()));
    }
}

/// Coordinates of exponents from `low` on, over the whole range that can be rescaled.
fn coordinates(low: i32) -> impl Strategy<Value = f64> {
    prop_oneof![
        1 => Just(0.0),
        9 => (1.0..2.0, low..=(low + 341).min(1023), any::<bool>()).prop_map(
            |(mantissa, exponent, negative): (f64, i32, bool)| {
                let half = exponent / 2;
                let value = mantissa * power_of_two(half) * power_of_two(exponent - half);
                if negative { -value } else { value }
            }
        ),
    ]
}

proptest! {
    #[test]
    fn there_and_back_gives_identical_bits(
        points in (-1074..=682_i32)
            .prop_flat_map(|low| prop::collection::vec(
                [coordinates(low), coordinates(low), coordinates(low)], 1..20)),
    ) {
        let set = PointSet::new(points.clone()).expect("finite");
        prop_assert_eq!(bits(set.points()), bits(&points.iter()
            .map(|p| p.map(|c| c + 0.0)).collect::<Vec<_>>()));
        prop_assert_ne!(set.mode(), Mode::Wide);
        let kernel = set.kernel_points();
        prop_assert!(kernel.iter().flatten().all(|&c| in_window(c)));
        let back: Vec<Point> = kernel.iter().map(|&p| set.mode().from_kernel(p)).collect();
        prop_assert_eq!(bits(&back), bits(set.points()));
        for (i, &p) in points.iter().enumerate() {
            prop_assert_eq!(set.kernel_point(i), Some(kernel[i]));
            prop_assert_eq!(set.mode().admit(p), Ok(Some(kernel[i])));
        }
    }
}
