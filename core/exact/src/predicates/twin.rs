//! Slow exact twins of the predicates: the reference of the tests ("fast equals slow").
//!
//! Every coordinate becomes a big integer in units of 2^-1074, which holds any finite `f64`, and
//! the homogeneous determinants are expanded as they stand: no filter, no stages, no
//! differences, and formulas other than those of [`super::exact`], so that the two do not share
//! a mistake. Cost: tens of microseconds per call.

use num_bigint::BigInt;
use num_traits::{One, Zero};

use super::{PLANES, Sign};
use crate::Point;

/// The least exponent of a bit of an `f64`.
const LEAST_EXPONENT: i32 = -1074;

/// `value` in units of 2^-1074: always an integer.
fn dyadic(value: f64) -> BigInt {
    let bits = value.to_bits();
    let field = ((bits >> 52) & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    // Value = mantissa · 2^exponent; subnormals have no implicit bit.
    let (mantissa, exponent) =
        if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
    let magnitude = BigInt::from(mantissa) << (exponent - LEAST_EXPONENT);
    if value.is_sign_negative() { -magnitude } else { magnitude }
}

fn dyadic_point(p: &Point) -> [BigInt; 3] {
    p.map(dyadic)
}

fn sign(value: &BigInt) -> Sign {
    Sign::from_ordering(value.cmp(&BigInt::zero()))
}

/// Determinant by expansion along the first row. Recursion depth: the number of rows.
fn determinant(rows: &[Vec<BigInt>]) -> BigInt {
    let Some((first, rest)) = rows.split_first() else {
        return BigInt::one();
    };
    let mut sum = BigInt::zero();
    for (column, factor) in first.iter().enumerate() {
        if factor.is_zero() {
            continue;
        }
        let minor: Vec<Vec<BigInt>> =
            rest.iter().map(|row| [&row[..column], &row[column + 1..]].concat()).collect();
        let term = factor * determinant(&minor);
        if column % 2 == 0 {
            sum += term;
        } else {
            sum -= term;
        }
    }
    sum
}

fn squared_length(p: &[BigInt; 3]) -> BigInt {
    &p[0] * &p[0] + &p[1] * &p[1] + &p[2] * &p[2]
}

/// Homogeneous row (1, x, y, z).
fn row4(p: &[BigInt; 3]) -> Vec<BigInt> {
    vec![BigInt::one(), p[0].clone(), p[1].clone(), p[2].clone()]
}

/// Homogeneous lifted row (1, x, y, z, x² + y² + z²).
fn row5(p: &[BigInt; 3]) -> Vec<BigInt> {
    let mut row = row4(p);
    row.push(squared_length(p));
    row
}

/// Twin of [`super::orient3d`].
#[must_use]
pub fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    let rows: Vec<_> = [a, b, c, d].iter().map(|p| row4(&dyadic_point(p))).collect();
    sign(&determinant(&rows))
}

/// Twin of [`super::insphere`].
#[must_use]
pub fn insphere(a: &Point, b: &Point, c: &Point, d: &Point, e: &Point) -> Sign {
    let rows: Vec<_> = [a, b, c, d, e].iter().map(|p| row5(&dyadic_point(p))).collect();
    -sign(&determinant(&rows))
}

/// Twin of [`super::coplanar_orient`].
#[must_use]
pub fn coplanar_orient(a: &Point, b: &Point, c: &Point) -> Sign {
    let points = [a, b, c].map(dyadic_point);
    for [i, j] in PLANES {
        let rows: Vec<_> =
            points.iter().map(|p| vec![BigInt::one(), p[i].clone(), p[j].clone()]).collect();
        let found = sign(&determinant(&rows));
        if !found.is_zero() {
            return found;
        }
    }
    Sign::Zero
}

/// Twin of [`super::collinear`]: is the cross product of the differences zero?
#[must_use]
pub fn collinear(a: &Point, b: &Point, c: &Point) -> bool {
    let [a, b, c] = [a, b, c].map(dyadic_point);
    normal(&a, &b, &c).iter().all(Zero::is_zero)
}

/// (b - a) x (c - a).
fn normal(a: &[BigInt; 3], b: &[BigInt; 3], c: &[BigInt; 3]) -> [BigInt; 3] {
    let u: [BigInt; 3] = std::array::from_fn(|k| &b[k] - &a[k]);
    let v: [BigInt; 3] = std::array::from_fn(|k| &c[k] - &a[k]);
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        &u[i] * &v[j] - &u[j] * &v[i]
    })
}

/// Twin of [`super::side_of_bounded_circle`].
///
/// A sphere through `a, b, c` and the point `a + normal` beside their plane meets the plane in
/// the circle through `a, b, c`: its in-sphere test, oriented, is the answer.
#[must_use]
pub fn side_of_bounded_circle(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    let [a, b, c, d] = [a, b, c, d].map(dyadic_point);
    let normal = normal(&a, &b, &c);
    let apex: [BigInt; 3] = std::array::from_fn(|k| &a[k] + &normal[k]);
    let orient = determinant(&[&a, &b, &c, &apex].map(row4));
    let insphere = determinant(&[&a, &b, &c, &apex, &d].map(row5));
    -sign(&insphere) * sign(&orient)
}
