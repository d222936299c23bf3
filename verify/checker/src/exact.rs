//! The exact stage of the predicates: short integers, else `robust` inside its window, else big
//! integers. Right for any finite f64, subnormal and huge ones too.
//!
//! * *Short integers.* When all differences are exact and span few bits (grids, lattices), they
//!   are integers of a common power of two: i64, then i128.
//! * *`robust`* (Shewchuk's expansions) where it is exact: every coordinate 0 or
//!   2^-142 ≤ |c| < 2^200. Outside it is silently wrong.
//! * *Big integers.* Every f64 is an integer times a power of two: exact, at any exponents.

use crate::determinant::{det_lifted, det3, difference, extents, in_range};
use crate::mesh::Point;
use num_bigint::{BigInt, Sign};
use robust::Coord3D;

/// The exponents of the lowest and highest set bits of a finite number, or `None` for zero.
fn bit_range(x: f64) -> Option<(i32, i32)> {
    let (mantissa, exponent) = dyadic(x);
    if mantissa == 0 {
        return None;
    }
    let magnitude = mantissa.unsigned_abs();
    // Both counts are below 64.
    let low = exponent + magnitude.trailing_zeros() as i32;
    Some((low, exponent + 63 - magnitude.leading_zeros() as i32))
}

/// A finite `x` as mantissa · 2^exponent.
pub(crate) fn dyadic(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let field = ((bits >> 52) & 0x7ff) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let mantissa = if field == 0 { fraction } else { fraction | (1 << 52) };
    (if x.is_sign_negative() { -mantissa } else { mantissa }, field.max(1) - 1075)
}

/// Whether the computed difference `d` of `a` and `b` is exact (Knuth's two-difference).
fn is_exact(a: f64, b: f64, d: f64) -> bool {
    let b_virtual = a - d;
    let a_virtual = d + b_virtual;
    (a - a_virtual) + (b_virtual - b) == 0.0
}

/// The differences of `points` to `origin` as [`whole_rows`].
fn integers<const N: usize>(
    points: [&Point; N],
    origin: &Point,
    limit: i32,
) -> Option<([[i64; 3]; N], i32)> {
    whole_rows(points.map(|p| [p, origin]), limit)
}

/// The differences of pairs of points, first less second, as integers in their common power of two,
/// and the number of bits that they need, when the differences are exact and need at most `limit`
/// bits.
fn whole_rows<const N: usize>(pairs: [[&Point; 2]; N], limit: i32) -> Option<([[i64; 3]; N], i32)> {
    let rows = pairs.map(difference);
    // Zero extents do no harm here; the others must allow scaling by 2^-low below.
    let m = extents(&rows).map(|m| if m == 0.0 { 1.0 } else { m });
    let exact =
        |([p, q], row): (&[&Point; 2], &[f64; 3])| (0..3).all(|k| is_exact(p[k], q[k], row[k]));
    if !in_range(m) || !pairs.iter().zip(&rows).all(exact) {
        return None;
    }
    let (mut low, mut high) = (i32::MAX, i32::MIN);
    for (l, h) in rows.iter().flatten().filter_map(|&d| bit_range(d)) {
        (low, high) = (low.min(l), high.max(h));
    }
    if low > high {
        return Some(([[0; 3]; N], 0)); // all differences are zero
    }
    let bits = high - low + 1;
    if bits > limit {
        return None;
    }
    // |low| is below 300 here, so the power is a normal number; bits ≤ 41 makes it exact.
    let unit = f64::from_bits(((1023 - low) as u64) << 52);
    Some((rows.map(|row| row.map(|d| (d * unit) as i64)), bits))
}

/// `robust` is exact for such a coordinate.
fn in_window(points: &[&Point]) -> bool {
    const LOW: f64 = f64::from_bits((1023 - 142) << 52);
    const HIGH: f64 = f64::from_bits((1023 + 200) << 52);
    let fits = |c: f64| c == 0.0 || (LOW <= c.abs() && c.abs() < HIGH);
    points.iter().all(|p| p.iter().all(|&c| fits(c)))
}

/// Differences of `points` to `origin` as big integers of one common power of two.
pub(crate) fn big_differences<const N: usize>(
    points: [&Point; N],
    origin: &Point,
) -> [[BigInt; 3]; N] {
    let low = lowest_bit(&points).min(lowest_bit(&[origin]));
    points.map(|p| [0, 1, 2].map(|k| big(p[k], low) - big(origin[k], low)))
}

/// `x` · 2^-low as an integer; `low` must not exceed the exponent of the lowest bit of `x`.
pub(crate) fn big(x: f64, low: i32) -> BigInt {
    let (mantissa, exponent) = dyadic(x);
    match exponent - low {
        up if up >= 0 => BigInt::from(mantissa) << up,
        down => BigInt::from(mantissa >> (-down).min(63)),
    }
}

/// The exponent of the lowest set bit of all coordinates, 0 if all of them are zero.
pub(crate) fn lowest_bit(points: &[&Point]) -> i32 {
    let coordinates = points.iter().flat_map(|p| p.iter());
    coordinates.filter_map(|&c| bit_range(c)).map(|(low, _)| low).min().unwrap_or(0)
}

/// The sign of a big integer.
pub(crate) fn big_sign(x: &BigInt) -> i8 {
    match x.sign() {
        Sign::Minus => -1,
        Sign::NoSign => 0,
        Sign::Plus => 1,
    }
}

fn coord([x, y, z]: &Point) -> Coord3D<f64> {
    Coord3D { x: *x, y: *y, z: *z }
}

/// The sign of `robust`'s answer with the opposite convention.
fn opposite(det: f64) -> i8 {
    i8::from(det < 0.0) - i8::from(det > 0.0)
}

/// Exact twin of [`crate::predicates::orient3d`].
///
/// With integers of b bits the determinant and all its partial sums are below 6 · 2^3b: i64 up
/// to 20 bits, i128 up to 41.
pub(crate) fn orient3d([a, b, c, d]: [&Point; 4]) -> i8 {
    match integers([b, c, d], a, 41) {
        Some((rows, ..=20)) => det3(&rows).signum() as i8,
        Some((rows, _)) => det3(&rows.map(|r| r.map(i128::from))).signum() as i8,
        None if in_window(&[a, b, c, d]) => {
            opposite(robust::orient3d(coord(a), coord(b), coord(c), coord(d)))
        }
        None => orient3d_big([a, b, c, d]),
    }
}

/// Exact twin of [`crate::predicates::triple`].
pub(crate) fn triple(vectors: [[&Point; 2]; 3]) -> i8 {
    match whole_rows(vectors, 41) {
        Some((rows, ..=20)) => det3(&rows).signum() as i8,
        Some((rows, _)) => det3(&rows.map(|r| r.map(i128::from))).signum() as i8,
        None => triple_big(vectors),
    }
}

/// Exact twin of [`crate::predicates::insphere`].
///
/// With integers of b bits the determinant and all its partial sums are below 72 · 2^5b: i64 up
/// to 11 bits, i128 up to 24.
pub(crate) fn insphere([a, b, c, d, e]: [&Point; 5]) -> i8 {
    match integers([a, b, c, d], e, 24) {
        Some((rows, ..=11)) => det_lifted(&rows).signum() as i8,
        Some((rows, _)) => det_lifted(&rows.map(|r| r.map(i128::from))).signum() as i8,
        None if in_window(&[a, b, c, d, e]) => {
            opposite(robust::insphere(coord(a), coord(b), coord(c), coord(d), coord(e)))
        }
        None => insphere_big([a, b, c, d, e]),
    }
}

/// [`orient3d`] by big integers alone.
pub(crate) fn orient3d_big([a, b, c, d]: [&Point; 4]) -> i8 {
    big_sign(&det3(&big_differences([b, c, d], a)))
}

/// [`triple`] by big integers alone.
pub(crate) fn triple_big(vectors: [[&Point; 2]; 3]) -> i8 {
    let low = lowest_bit(vectors.as_flattened());
    big_sign(&det3(&vectors.map(|[p, q]| [0, 1, 2].map(|k| big(p[k], low) - big(q[k], low)))))
}

/// [`insphere`] by big integers alone.
pub(crate) fn insphere_big([a, b, c, d, e]: [&Point; 5]) -> i8 {
    big_sign(&det_lifted(&big_differences([a, b, c, d], e)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicates::{self, Tally};
    use proptest::prelude::*;

    const O: Point = [0.0; 3];
    const X: Point = [1.0, 0.0, 0.0];
    const Y: Point = [0.0, 1.0, 0.0];
    const Z: Point = [0.0, 0.0, 1.0];

    /// All ways to an answer must agree; returns it.
    fn orient_all_ways(p: [&Point; 4]) -> i8 {
        let expected = orient3d_big(p);
        assert_eq!(orient3d(p), expected, "exact {p:?}");
        assert_eq!(predicates::orient3d(p, &mut Tally::default()), expected, "fast {p:?}");
        expected
    }

    fn triple_all_ways(v: [[&Point; 2]; 3]) -> i8 {
        let expected = triple_big(v);
        assert_eq!(triple(v), expected, "exact {v:?}");
        assert_eq!(predicates::triple(v, &mut Tally::default()), expected, "fast {v:?}");
        expected
    }

    fn insphere_all_ways(p: [&Point; 5]) -> i8 {
        let expected = insphere_big(p);
        assert_eq!(insphere(p), expected, "exact {p:?}");
        assert_eq!(predicates::insphere(p, &mut Tally::default()), expected, "fast {p:?}");
        expected
    }

    #[test]
    fn sign_conventions() {
        for scale in [1.0, 5e-324, 1e-200, 3.0, 1e100, 1e307] {
            let [x, y, z] = [X, Y, Z].map(|p| p.map(|c| c * scale));
            assert_eq!(orient_all_ways([&O, &x, &y, &z]), 1);
            assert_eq!(orient_all_ways([&O, &y, &x, &z]), -1);
            assert_eq!(orient_all_ways([&O, &x, &y, &[scale, scale, 0.0]]), 0);
            let corner = [scale; 3]; // on the sphere
            assert_eq!(insphere_all_ways([&O, &x, &y, &z, &corner]), 0);
            assert_eq!(insphere_all_ways([&O, &x, &y, &z, &[-scale, 0.0, 0.0]]), -1);
            assert_eq!(insphere_all_ways([&O, &x, &y, &z, &[scale, scale, -0.0]]), 0);
            if scale > 1e-300 {
                let inside = [0.25 * scale; 3];
                assert_eq!(insphere_all_ways([&O, &x, &y, &z, &inside]), 1);
                assert_eq!(insphere_all_ways([&O, &y, &x, &z, &inside]), -1);
            }
        }
    }

    #[test]
    fn the_largest_and_the_smallest_numbers() {
        let (m, e) = (f64::MAX, 5e-324);
        assert_eq!(orient_all_ways([&[-m, -m, -m], &[m, -m, -m], &[-m, m, -m], &[m, m, m]]), 1);
        assert_eq!(orient_all_ways([&O, &[m, 0.0, 0.0], &[0.0, m, 0.0], &[m, m, -e]]), -1);
        let t = [&O, &[m, 0.0, 0.0], &[0.0, m, 0.0], &[0.0, 0.0, m]];
        let [a, b, c, d] = t;
        assert_eq!(insphere_all_ways([a, b, c, d, &[m, m, m]]), 0);
        assert_eq!(insphere_all_ways([a, b, c, d, &[e, e, e]]), 1);
        assert_eq!(insphere_all_ways([a, b, c, d, &[-e, 0.0, 0.0]]), -1);
    }

    #[test]
    fn powers_of_two_and_dyadics() {
        assert_eq!(bit_range(0.0), None);
        assert_eq!(bit_range(12.0), Some((2, 3)));
        assert_eq!(bit_range(5e-324), Some((-1074, -1074)));
        assert_eq!(bit_range(-f64::MAX), Some((971, 1023)));
        assert_eq!(big(-12.0, 2), BigInt::from(-3));
        assert_eq!(big(0.0, 40), BigInt::from(0));
    }

    #[test]
    fn which_integers_are_short() {
        let p = [[3.0, 0.5, 0.0], [0.0, -4.0, 1.5]];
        let (rows, bits) = integers([&p[0], &p[1]], &O, 41).unwrap();
        assert_eq!((rows, bits), ([[6, 1, 0], [0, -8, 3]], 4));
        assert!(integers([&p[0], &p[1]], &O, 3).is_none());
        // A rounded difference is no integer of the points.
        assert!(integers([&[1.0, 0.0, 0.0]], &[1e-30, 0.0, 0.0], 41).is_none());
    }

    /// Integers of some bits, ulps around them, at any scale; many degenerate, some with zeros.
    fn points<const N: usize>() -> impl Strategy<Value = [Point; N]> {
        let bits =
            prop_oneof![Just(1u32), Just(3), Just(9), Just(12), Just(20), Just(30), 1..53u32];
        let exponent = prop_oneof![Just(0), -60..60i32, -1074..960i32];
        (bits, exponent, any::<bool>(), any::<[[u64; 3]; N]>(), any::<[[u8; 3]; N]>()).prop_map(
            |(bits, exponent, ulps, words, noise)| {
                let (half, rest) = (exponent / 2, exponent - exponent / 2);
                let mut points = [O; N];
                for i in 0..N {
                    for k in 0..3 {
                        let whole = (words[i][k] >> (64 - bits)) as f64;
                        let mut c = whole * 2f64.powi(half) * 2f64.powi(rest);
                        if ulps && c != 0.0 {
                            c = f64::from_bits(c.to_bits() + u64::from(noise[i][k] % 3) - 1);
                        }
                        points[i][k] = if noise[i][k] >= 128 { -c } else { c };
                    }
                }
                points
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]

        #[test]
        fn orientation_agrees(p in points::<4>()) {
            let sign = orient_all_ways([&p[0], &p[1], &p[2], &p[3]]);
            prop_assert_eq!(orient_all_ways([&p[1], &p[0], &p[2], &p[3]]), -sign);
            // A point of the plane, exactly, when the sums are exact.
            let on = [0, 1, 2].map(|k| p[1][k] + (p[2][k] - p[0][k]));
            prop_assume!(on.iter().all(|c| c.is_finite()));
            orient_all_ways([&p[0], &p[1], &p[2], &on]);
        }

        #[test]
        fn triple_products_agree(p in points::<6>()) {
            let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(|i| &p[i]);
            let sign = triple_all_ways([[a, b], [c, d], [e, f]]);
            prop_assert_eq!(triple_all_ways([[c, d], [a, b], [e, f]]), -sign);
            prop_assert_eq!(triple_all_ways([[b, a], [c, d], [e, f]]), -sign);
            // Of four points it is their orientation.
            prop_assert_eq!(
                triple_all_ways([[b, a], [c, a], [d, a]]),
                orient_all_ways([a, b, c, d])
            );
            prop_assert_eq!(triple_all_ways([[a, b], [c, d], [a, b]]), 0);
        }

        #[test]
        fn in_sphere_agrees(p in points::<5>()) {
            let sign = insphere_all_ways([&p[0], &p[1], &p[2], &p[3], &p[4]]);
            prop_assert_eq!(insphere_all_ways([&p[1], &p[0], &p[2], &p[3], &p[4]]), -sign);
            // Corners of one box are on one sphere.
            let (a, g) = (p[0], p[1]);
            let (b, c, d) = ([g[0], a[1], a[2]], [a[0], g[1], a[2]], [a[0], a[1], g[2]]);
            prop_assert_eq!(insphere_all_ways([&a, &b, &c, &d, &g]), 0);
        }
    }
}
