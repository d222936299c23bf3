//! The last stage: big integers, for exponents of any spread.

use num_bigint::BigInt;
use num_traits::Zero;

use super::super::Sign;
use crate::Point;

/// The points as integers in the largest power of two of which all coordinates are multiples.
fn integers<const N: usize>(points: [&Point; N]) -> [[BigInt; 3]; N] {
    let mut unit = i32::MAX;
    for &value in points.iter().copied().flatten() {
        if let Some((_, exponent)) = odd_mantissa(value) {
            unit = unit.min(exponent);
        }
    }
    points.map(|p| {
        p.map(|value| {
            let Some((mantissa, exponent)) = odd_mantissa(value) else {
                return BigInt::zero();
            };
            // `unit` is the minimum of the exponents: the shift is 0 to 2045 + 52.
            BigInt::from(mantissa) << (exponent - unit)
        })
    })
}

/// (m, e) with m odd and `value` = m · 2^e; `None` for zero.
fn odd_mantissa(value: f64) -> Option<(i64, i32)> {
    let bits = value.to_bits();
    let field = ((bits >> 52) & 0x7ff) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let (mantissa, exponent) =
        if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
    if mantissa == 0 {
        return None;
    }
    let zeros = mantissa.trailing_zeros();
    let odd = mantissa >> zeros;
    Some((if value < 0.0 { -odd } else { odd }, exponent + zeros as i32))
}

fn sign(value: &BigInt) -> Sign {
    Sign::from_ordering(value.cmp(&BigInt::zero()))
}

fn subtract(p: &[BigInt; 3], q: &[BigInt; 3]) -> [BigInt; 3] {
    std::array::from_fn(|k| &p[k] - &q[k])
}

fn lift(p: &[BigInt; 3]) -> BigInt {
    p.iter().map(|x| x * x).sum()
}

fn minor(p: &[BigInt; 3], q: &[BigInt; 3], i: usize, j: usize) -> BigInt {
    &p[i] * &q[j] - &q[i] * &p[j]
}

fn det3(a: &[BigInt; 3], b: &[BigInt; 3], c: &[BigInt; 3]) -> BigInt {
    &a[2] * minor(b, c, 0, 1) + &b[2] * minor(c, a, 0, 1) + &c[2] * minor(a, b, 0, 1)
}

#[inline(never)]
pub(super) fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    let [a, b, c, d] = integers([a, b, c, d]);
    let [a, b, c] = [a, b, c].map(|p| subtract(&p, &d));
    -sign(&det3(&a, &b, &c))
}

#[inline(never)]
pub(super) fn insphere(a: &Point, b: &Point, c: &Point, d: &Point, e: &Point) -> Sign {
    let [a, b, c, d, e] = integers([a, b, c, d, e]);
    let [a, b, c, d] = [a, b, c, d].map(|p| subtract(&p, &e));
    let ac = lift(&a) * det3(&b, &c, &d) + lift(&c) * det3(&a, &b, &d);
    let bd = lift(&b) * det3(&a, &c, &d) + lift(&d) * det3(&a, &b, &c);
    sign(&(ac - bd))
}

#[inline(never)]
pub(super) fn orient2d(a: &Point, b: &Point, c: &Point, [i, j]: [usize; 2]) -> Sign {
    let [a, b, c] = integers([a, b, c]);
    sign(&minor(&subtract(&a, &c), &subtract(&b, &c), i, j))
}

#[inline(never)]
pub(super) fn incircle(a: &Point, b: &Point, c: &Point, d: &Point, [i, j]: [usize; 2]) -> Sign {
    let [a, b, c, d] = integers([a, b, c, d]);
    let [a, b, c] = [a, b, c].map(|p| subtract(&p, &d));
    let det = lift(&a) * minor(&b, &c, i, j)
        + lift(&b) * minor(&c, &a, i, j)
        + lift(&c) * minor(&a, &b, i, j);
    sign(&det)
}
