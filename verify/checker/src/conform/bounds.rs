//! Exact tests of the bounds: circumradius to shortest edge, volume, longest edge.
//!
//! A filter in f64 whose errors are bounded generously (u = 2^-53, m the largest |difference| of
//! the tetrahedron), then big integers. Coordinates are units, so nothing underflows.

use super::whole::{Whole, six_volumes};
use crate::exact::dyadic;
use num_bigint::BigInt;

const UNIT_ROUNDOFF: f64 = 1.0 / (1u64 << 53) as f64;

/// A positive finite number as mantissa · 2^exponent.
fn parts(x: f64) -> (BigInt, i32) {
    let (mantissa, exponent) = dyadic(x);
    (BigInt::from(mantissa), exponent)
}

/// The sign of a · 2^p - b.
fn exceeds(a: &BigInt, p: i32, b: &BigInt) -> bool {
    if p >= 0 { (a << p) > *b } else { *a > (b << -p) }
}

/// Is the volume of a tetrahedron above `bound` cubic units?
pub(crate) fn volume_exceeds(corners: [Whole; 4], bound: f64) -> bool {
    let six = six_volumes(corners);
    let six = if six < BigInt::ZERO { -six } else { six };
    let (mantissa, exponent) = parts(bound);
    // six > 6 mantissa 2^exponent
    exceeds(&six, -exponent, &(6 * mantissa))
}

/// Is an edge of a tetrahedron longer than `bound` units?
pub(crate) fn edge_exceeds([a, b, c, d]: [Whole; 4], bound: f64) -> bool {
    [(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)].into_iter().any(|(p, q)| {
        let difference = [0, 1, 2].map(|k| p[k] - q[k]);
        // Three squares of differences with three roundings each, and that of the bound.
        let square: f64 = difference.iter().map(|&x| x as f64 * x as f64).sum();
        if (square - bound * bound).abs() > 16.0 * UNIT_ROUNDOFF * square {
            return square > bound * bound;
        }
        let square: BigInt = difference.iter().map(|&x| BigInt::from(x) * x).sum();
        let (mantissa, exponent) = parts(bound);
        exceeds(&square, -2 * exponent, &(&mantissa * &mantissa))
    })
}

/// Is circumradius to shortest edge above `bound`?
pub(crate) fn ratio_exceeds([a, b, c, d]: [Whole; 4], bound: f64) -> bool {
    let rows = [a, b, c].map(|p| [0, 1, 2].map(|k| p[k] - d[k]));
    let f = rows.map(|row| row.map(|x| x as f64));
    let m = f.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    let (left, right) = sides(f, 4.0 * bound * bound);
    // At most 972 (left) and 108 · 4B² (right) products of eight differences with fewer than 45
    // roundings each, those of the conversion and of 4B² included.
    let m4 = m * m * m * m;
    let error = 45.0 * UNIT_ROUNDOFF * (972.0 + 432.0 * bound * bound) * m4 * m4;
    if (left - right).abs() > error {
        return left > right;
    }
    let big = rows.map(|row| row.map(BigInt::from));
    let (normal2, edge2, det) = big_sides(&big);
    let (mantissa, exponent) = parts(bound);
    // |N|² > 4 B² l² D²
    exceeds(&normal2, -2 * exponent, &(4 * &mantissa * &mantissa * edge2 * &det * &det))
}

/// |N|² and `factor` · l² · D², rounded.
fn sides([a, b, c]: [[f64; 3]; 3], factor: f64) -> (f64, f64) {
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    let (aa, bb, cc) = (dot(a, a), dot(b, b), dot(c, c));
    let n = [0, 1, 2].map(|k| aa * bc[k] + bb * ca[k] + cc * ab[k]);
    let det = dot(a, bc);
    let others = [minus(a, b), minus(b, c), minus(c, a)].map(|e| dot(e, e));
    let edge2 = others.into_iter().chain([aa, bb, cc]).fold(f64::INFINITY, f64::min);
    (dot(n, n), factor * edge2 * det * det)
}

/// |N|², l² and D.
fn big_sides([a, b, c]: &[[BigInt; 3]; 3]) -> (BigInt, BigInt, BigInt) {
    let dot =
        |p: &[BigInt; 3], q: &[BigInt; 3]| -> BigInt { p.iter().zip(q).map(|(x, y)| x * y).sum() };
    let cross = |p: &[BigInt; 3], q: &[BigInt; 3]| {
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &p[i] * &q[j] - &p[j] * &q[i])
    };
    let minus = |p: &[BigInt; 3], q: &[BigInt; 3]| [0, 1, 2].map(|k| &p[k] - &q[k]);
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    let (aa, bb, cc) = (dot(a, a), dot(b, b), dot(c, c));
    let n = [0, 1, 2].map(|k| &aa * &bc[k] + &bb * &ca[k] + &cc * &ab[k]);
    let others = [minus(a, b), minus(b, c), minus(c, a)].map(|e| dot(&e, &e));
    let edge2 = others.into_iter().chain([aa, bb, cc]).min().unwrap_or(BigInt::ZERO);
    (dot(&n, &n), edge2, dot(a, &bc))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bounds_are_exact_at_equality() {
        // Three edges of a cube of side s: volume s³/6, circumradius √3/2 s, shortest edge s.
        for s in [1i128, 12, 1 << 50] {
            let corners = [[0; 3], [s, 0, 0], [0, s, 0], [0, 0, s]];
            assert!(!ratio_exceeds(corners, 0.8660254037844387));
            assert!(ratio_exceeds(corners, 0.8660254037844386));
        }
        let corners = [[0; 3], [12, 0, 0], [0, 1, 0], [0, 0, 1]];
        assert!(!volume_exceeds(corners, 2.0));
        assert!(volume_exceeds(corners, 2f64.next_down()));
        // The longest edge is 5, or 5 · 2^50.
        for s in [1i128, 1 << 50] {
            let (corners, five) = ([[0; 3], [3 * s, 4 * s, 0], [0, s, 0], [s; 3]], 5.0 * s as f64);
            assert!(!edge_exceeds(corners, five) && edge_exceeds(corners, five.next_down()));
            assert!(edge_exceeds(corners, 1.0) && !edge_exceeds(corners, 2.0 * five));
        }
        // Shortest edge 2, circumradius 3: the ratio is 3/2 exactly.
        let corners = [[2, 0, 0], [0, 0, 0], [0, 4, 0], [0, 0, 4]];
        assert!(!ratio_exceeds(corners, 1.5) && ratio_exceeds(corners, 1.5f64.next_down()));
    }

    /// Is the ratio above `bound`? By Crelle's formula: with P, Q, S the products of the squares of
    /// opposite edges, 16 D² R² = 2 (PQ + QS + SP) - P² - Q² - S².
    fn exceeds_by_edges(corners: [Whole; 4], bound: f64) -> bool {
        let square = |i: usize, j: usize| -> BigInt {
            (0..3).map(|k| BigInt::from(corners[i][k] - corners[j][k]).pow(2)).sum()
        };
        let pairs = [[(0, 1), (2, 3)], [(0, 2), (1, 3)], [(0, 3), (1, 2)]];
        let shortest = pairs.iter().flatten().map(|&(i, j)| square(i, j)).min();
        let [p, q, s] = pairs.map(|pair| pair.map(|(i, j)| square(i, j)).into_iter().product());
        let all: [&BigInt; 3] = [&p, &q, &s];
        let squares: BigInt = all.iter().map(|&x| x * x).sum();
        let left: BigInt = 2 * (&p * &q + &q * &s + &s * &p) - squares;
        let six = six_volumes(corners);
        let (mantissa, exponent) = parts(bound);
        let right = 16 * &mantissa * &mantissa * shortest.expect("edges") * &six * &six;
        exceeds(&left, -2 * exponent, &right)
    }

    /// The answer of doubles alone.
    fn exceeds_in_doubles([a, b, c, d]: [Whole; 4], bound: f64) -> bool {
        let rows = [a, b, c].map(|p| [0, 1, 2].map(|k| (p[k] - d[k]) as f64));
        let (left, right) = sides(rows, 4.0 * bound * bound);
        left > right
    }

    #[test]
    fn the_ratio_is_compared_in_integers_where_doubles_are_wrong() {
        let mut state = 88_172_645_463_325_252u64;
        let mut next = |bits: u32| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            i128::from(state >> (64 - bits))
        };
        let mut wrong = [0; 2];
        for round in 0..240 {
            let bits = [8, 20, 33, 45][round % 4];
            let corners = [0; 4].map(|_| [0; 3].map(|_| next(bits)));
            let six = six_volumes(corners);
            if six == BigInt::ZERO {
                continue;
            }
            // The double at the ratio, by bisection; then its neighbours.
            let (mut low, mut high) = (0.5f64, 2f64.powi(60));
            while low.next_up() < high {
                let middle = f64::from_bits(low.to_bits().midpoint(high.to_bits()));
                let end = if exceeds_by_edges(corners, middle) { &mut low } else { &mut high };
                *end = middle;
            }
            for (is_above, bound) in [(true, low), (false, high)] {
                assert_eq!(ratio_exceeds(corners, bound), is_above, "{corners:?}, {bound}");
                wrong[usize::from(is_above)] +=
                    usize::from(exceeds_in_doubles(corners, bound) != is_above);
            }
        }
        // Else these cases would say nothing.
        assert!(wrong.iter().all(|&n| n > 20), "doubles are wrong in {wrong:?} cases");
    }

    /// Three orthogonal edges 2a, 2b, 2c with a² + b² + c² = d²: the circumradius is d.
    #[test]
    fn the_ratio_is_exact_at_equality_whatever_doubles_make_of_the_coordinates() {
        let mut wrong = 0;
        for [a, b, c, d] in [
            [1i128, 2, 2, 3],
            [2, 3, 6, 7],
            [1, 4, 8, 9],
            [4, 4, 7, 9],
            [2, 6, 9, 11],
            [8, 9, 12, 17],
        ] {
            for factor in (0..40).map(|k| (k << 45) + 12_345 * k + 1) {
                let ratio = d as f64 / (2 * a) as f64;
                let [a, b, c] = [a, b, c].map(|edge: i128| 2 * edge * factor);
                let corners = [[0, 0, 0], [a, 0, 0], [0, b, 0], [0, 0, c]];
                for (bound, is_above) in
                    [(ratio, false), (ratio.next_down(), true), (ratio.next_up(), false)]
                {
                    assert_eq!(ratio_exceeds(corners, bound), is_above, "{corners:?}, {bound}");
                    assert_eq!(exceeds_by_edges(corners, bound), is_above);
                    wrong += usize::from(exceeds_in_doubles(corners, bound) != is_above);
                }
            }
        }
        assert!(wrong > 20, "doubles are wrong in {wrong} cases");
    }
}
