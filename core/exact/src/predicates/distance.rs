//! Which of two points is nearer: an exact comparison of squared distances.
//!
//! A filter decides nearly always. What it leaves open is decided by a sum of exact products
//! (`predicates::long`): no allocation, some 100 ns.

use std::cmp::Ordering;

use super::Sign;
use super::filter::{UNIT_ROUNDOFF, power_of_two};
use super::long::{DEGREE_2, Sum};
use crate::Point;

/// A difference of computed squared distances is certain if it exceeds this times the larger one.
///
/// A computed squared distance has a relative error of at most (1 + u)^5 - 1: one rounding of a
/// difference, squared, one of its square, two of the sum. Two of them, and the rounding of
/// their difference: below 10.1u + u; the rest covers gradual underflow under the guard.
const DISTANCE_ERROR: f64 = 16.0 * UNIT_ROUNDOFF;

/// The filter's guard: above it a square that underflows is lost in the slack of the constant.
const GUARD_LOW: f64 = power_of_two(-900);
/// The filter's guard: below it nothing has overflowed.
const GUARD_HIGH: f64 = power_of_two(1000);

/// Compares the distance from `p` to `a` with that from `p` to `b`, exactly, for any finite
/// coordinates: `Less` if `a` is strictly nearer.
///
/// ```
/// use ltbw_exact::predicates::distance::cmp_distance;
/// use std::cmp::Ordering;
/// let (a, b) = ([0.0; 3], [1.0, 0.0, 0.0]);
/// assert_eq!(cmp_distance(&[0.5, 7.0, -3.0], &a, &b), Ordering::Equal);
/// assert_eq!(cmp_distance(&[0.5 + 1e-16, 7.0, -3.0], &a, &b), Ordering::Greater);
/// ```
#[inline]
#[must_use]
pub fn cmp_distance(p: &Point, a: &Point, b: &Point) -> Ordering {
    filter(p, a, b).unwrap_or_else(|| exact_cmp_distance(p, a, b))
}

/// [`cmp_distance`] by filter; `None` if not decided.
#[inline(always)]
fn filter(p: &Point, a: &Point, b: &Point) -> Option<Ordering> {
    let (near_a, near_b) = (squared(p, a), squared(p, b));
    let larger = near_a.max(near_b);
    if larger > GUARD_LOW && larger < GUARD_HIGH {
        let margin = DISTANCE_ERROR * larger;
        if near_b - near_a > margin {
            return Some(Ordering::Less);
        }
        if near_a - near_b > margin {
            return Some(Ordering::Greater);
        }
    }
    None
}

#[inline(always)]
fn squared(p: &Point, q: &Point) -> f64 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    x * x + y * y + z * z
}

/// [`cmp_distance`] without the filter.
#[cold]
#[inline(never)]
#[must_use]
pub fn exact_cmp_distance(p: &Point, a: &Point, b: &Point) -> Ordering {
    // |p-a|^2 - |p-b|^2 = a.a - b.b - 2 p.a + 2 p.b
    let mut sum = Sum::<DEGREE_2>::new();
    for k in 0..3 {
        sum.add([a[k], a[k]], Sign::Positive);
        sum.add([b[k], b[k]], Sign::Negative);
        for _ in 0..2 {
            sum.add([p[k], a[k]], Sign::Negative);
            sum.add([p[k], b[k]], Sign::Positive);
        }
    }
    sum.compare()
}

#[cfg(test)]
mod tests {
    use super::super::long::{Parts, parts};
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    /// The twin: big integers in units of 2^-1074, differences squared.
    fn twin(p: &Point, a: &Point, b: &Point) -> Ordering {
        let integer = |c: f64| {
            let Parts { mantissa, exponent, is_negative } = parts(c);
            let magnitude = BigInt::from(mantissa) << (exponent + 1074);
            if is_negative { -magnitude } else { magnitude }
        };
        let square = |q: &Point| -> BigInt {
            (0..3).map(|k| integer(p[k]) - integer(q[k])).map(|d| &d * &d).sum()
        };
        square(a).cmp(&square(b))
    }

    fn check(p: &Point, a: &Point, b: &Point) -> Ordering {
        let expected = twin(p, a, b);
        assert_eq!(exact_cmp_distance(p, a, b), expected, "{p:?} {a:?} {b:?}");
        assert_eq!(cmp_distance(p, a, b), expected, "{p:?} {a:?} {b:?}");
        expected
    }

    fn any_finite() -> impl Strategy<Value = f64> + Clone {
        any::<u64>().prop_map(|bits| {
            let value = f64::from_bits(bits);
            if value.is_finite() { value } else { f64::from_bits(bits & !(1 << 62)) }
        })
    }

    fn point(c: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = Point> {
        [c.clone(), c.clone(), c]
    }

    proptest! {
        #[test]
        fn any_bits_agree_with_the_twin(
            p in point(any_finite()), a in point(any_finite()), b in point(any_finite()),
        ) {
            check(&p, &a, &b);
        }

        #[test]
        fn nearly_equal_distances_agree_with_the_twin(
            p in point((-9..9).prop_map(f64::from)),
            d in point((-9..9).prop_map(f64::from)),
            turn in 0..3_usize,
            steps in 0..3_u64,
            scale in -1060..1000_i32,
        ) {
            let scale = |q: Point| q.map(|c| {
                let half = scale / 2;
                c * power_of_two(half) * power_of_two(scale - half)
            });
            let mut a = scale([0, 1, 2].map(|k| p[k] + d[k]));
            let b = scale([0, 1, 2].map(|k| p[k] - d[(k + turn) % 3]));
            a[0] = f64::from_bits(a[0].to_bits() + steps);
            check(&scale(p), &a, &b);
        }
    }

    /// Points on an axis at the distances `a` and `b` from the origin.
    fn filtered(a: f64, b: f64) -> Option<Ordering> {
        let found = filter(&[0.0; 3], &[a, 0.0, 0.0], &[0.0, b, 0.0]);
        assert_eq!(filter(&[0.0; 3], &[0.0, 0.0, b], &[0.0, a, 0.0]), found.map(Ordering::reverse));
        found
    }

    #[test]
    fn the_filter_decides_up_to_its_margin() {
        let ulps = |n: i32| 1.0 - f64::from(n) * UNIT_ROUNDOFF;
        // The square of 1 - 8u is 1 - 16u, rounded: the difference is the margin.
        assert_eq!(filtered(ulps(8), 1.0), None);
        assert_eq!(filtered(ulps(9), 1.0), Some(Ordering::Less));
        assert_eq!(filtered(1.0, 1.0), None);
    }

    #[test]
    fn the_filter_decides_between_its_guards() {
        let (low, high) = (power_of_two(-450), power_of_two(500));
        assert_eq!(filtered(0.5 * low, low), None);
        assert_eq!(filtered(low, 1.5 * low), Some(Ordering::Less));
        assert_eq!(filtered(high.next_down(), 1.0), Some(Ordering::Greater));
        assert_eq!(filtered(high, 1.0), None);
        assert_eq!(filtered(2.0 * high, high), None);
        assert_eq!(filtered(power_of_two(1000), 1.0), None);
    }

    #[test]
    fn the_ends_of_the_range_do_not_overflow() {
        let (big, tiny) = (f64::MAX, f64::from_bits(1));
        let ends = [big, -big, tiny, -tiny, 0.0, 1.0];
        let mut seen = [0; 3];
        for i in 0..6usize.pow(3) {
            let [x, y, z] = [i % 6, i / 6 % 6, i / 36].map(|k| ends[k]);
            let sign = check(&[x; 3], &[y; 3], &[z; 3]);
            check(&[x, y, z], &[y, z, x], &[z, y, y]);
            seen[(sign as i8 + 1) as usize] += 1;
        }
        assert!(seen.iter().all(|&n| n > 20), "{seen:?}");
    }
}
