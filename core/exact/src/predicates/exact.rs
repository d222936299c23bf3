//! Exact evaluation in stages, fast first, for any finite coordinates.
//!
//! Integer and lattice inputs are degenerate everywhere: most of their in-sphere tests end here,
//! so that these stages are a hot path of their own. The stages take the differences to one
//! point and a power of two as unit:
//!
//! 1. *few bits*: differences are exact in `f64` and multiples of a unit so large that every
//!    product is exact in `f64` (or, for `insphere`, all but the last ones);
//! 2. *small*: differences are integers below 2^62, products are fixed-width integers;
//! 3. *medium*: differences are integers below 2^124;
//! 4. *big*: whatever is left, in long accumulators.
//!
//! No stage allocates.
//!
//! Each bound below says why nothing can overflow; B stands for the bits of a difference.

mod big;
mod differences;
mod fixed;
#[cfg(test)]
mod tests;

use super::{PLANES, Sign};
use crate::Point;
use differences::Differences;
use fixed::Int;

/// Exact [`super::orient3d`], without the filter.
#[cold]
#[inline(never)]
#[must_use]
pub fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    let differences = Differences::new([a, b, c], d);
    if let Some([a, b, c]) = differences.few_bits::<16>() {
        // |det| and all partial sums <= 6 · 2^3B = 2^50.6 units: every operation is exact.
        let det = a[2] * (b[0] * c[1] - c[0] * b[1])
            + b[2] * (c[0] * a[1] - a[0] * c[1])
            + c[2] * (a[0] * b[1] - b[0] * a[1]);
        return -Sign::from_f64(det);
    }
    if let Some([a, b, c]) = differences.small() {
        return -det3_small(&a, &b, &c).sign();
    }
    if let Some([a, b, c]) = differences.medium() {
        return -det3_medium(&a, &b, &c).sign();
    }
    big::orient3d(a, b, c, d)
}

/// Exact [`super::insphere`], without the filter.
#[cold]
#[inline(never)]
#[must_use]
pub fn insphere(a: &Point, b: &Point, c: &Point, d: &Point, e: &Point) -> Sign {
    let differences = Differences::new([a, b, c, d], e);
    if let Some([a, b, c, d]) = differences.few_bits::<9>() {
        // All partial sums <= 72 · 2^5B = 2^51.2 units: every operation is exact.
        let [wa, wb, wc, wd] = insphere_factors(&a, &b, &c, &d).map(|(lift, det)| lift * det);
        return Sign::from_f64((wd - wc) + (wb - wa));
    }
    if let Some([a, b, c, d]) = differences.few_bits::<16>() {
        // |det| <= 6 · 2^3B = 2^50.6 and lift <= 3 · 2^2B = 2^33.6 are exact in f64;
        // the sum of the products, <= 2^86.2, in i128.
        let [wa, wb, wc, wd] = insphere_factors(&a, &b, &c, &d)
            .map(|(lift, det)| lift as i64 as i128 * det as i64 as i128);
        return Sign::from_ordering(((wd - wc) + (wb - wa)).cmp(&0));
    }
    if let Some([a, b, c, d]) = differences.small() {
        return insphere_small(&a, &b, &c, &d).sign();
    }
    if let Some([a, b, c, d]) = differences.medium() {
        return insphere_medium(&a, &b, &c, &d).sign();
    }
    big::insphere(a, b, c, d, e)
}

/// Exact [`super::coplanar_orient`], without the filter.
#[must_use]
pub fn coplanar_orient(a: &Point, b: &Point, c: &Point) -> Sign {
    super::first_projection(|plane| orient2d(a, b, c, plane))
}

/// Exact [`super::side_of_bounded_circle`], without the filter.
#[must_use]
pub fn side_of_bounded_circle(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    for plane in PLANES {
        let local = orient2d(a, b, c, plane);
        if !local.is_zero() {
            return incircle(a, b, c, d, plane) * local;
        }
    }
    Sign::Zero
}

/// Exact orientation of the projections of `a, b, c` to the axes of `plane`.
#[cold]
#[inline(never)]
#[must_use]
pub fn orient2d(a: &Point, b: &Point, c: &Point, plane: [usize; 2]) -> Sign {
    let [i, j] = plane;
    // The third axis plays no role: without it more inputs have few bits.
    let project = |p: &Point| [p[i], p[j], 0.0];
    let [pa, pb, pc] = [a, b, c].map(project);
    let differences = Differences::new([&pa, &pb], &pc);
    if let Some([a, b]) = differences.small() {
        // 2B + 1 bits and a sign: 126.
        return Sign::from_ordering(minor(&a, &b, 0, 1).cmp(&0));
    }
    if let Some([a, b]) = differences.medium() {
        // 2B + 1 bits and a sign: 250.
        let det: Int<4> = minor_medium(&a, &b, 0, 1);
        return det.sign();
    }
    big::orient2d(a, b, c, plane)
}

/// The exact in-circle determinant of [`super::filter::incircle_any`].
#[cold]
#[inline(never)]
#[must_use]
pub fn incircle(a: &Point, b: &Point, c: &Point, d: &Point, plane: [usize; 2]) -> Sign {
    let differences = Differences::new([a, b, c], d);
    if let Some([a, b, c]) = differences.small() {
        return incircle_small(&a, &b, &c, plane).sign();
    }
    if let Some([a, b, c]) = differences.medium() {
        return incircle_medium(&a, &b, &c, plane).sign();
    }
    big::incircle(a, b, c, d, plane)
}

/// Lifts and 3x3 determinants of the in-sphere determinant
/// `dlift·abc - clift·dab + blift·cda - alift·bcd` (Shewchuk's, negated): four pairs in the order
/// a, b, c, d.
#[inline(always)]
fn insphere_factors(a: &Point, b: &Point, c: &Point, d: &Point) -> [(f64, f64); 4] {
    let minor = |p: &Point, q: &Point| q[0] * p[1] - p[0] * q[1];
    let lift = |p: &Point| p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    let [ab, bc, cd, da] = [minor(a, b), minor(b, c), minor(c, d), minor(d, a)];
    let [ac, bd] = [minor(a, c), minor(b, d)];
    [
        (lift(a), b[2] * cd - c[2] * bd + d[2] * bc),
        (lift(b), c[2] * da + d[2] * ac + a[2] * cd),
        (lift(c), d[2] * ab + a[2] * bd + b[2] * da),
        (lift(d), a[2] * bc - b[2] * ac + c[2] * ab),
    ]
}

/// p[i]·q[j] - q[i]·p[j]. B <= 62: at most 125 bits and a sign.
#[inline(always)]
fn minor(p: &[i64; 3], q: &[i64; 3], i: usize, j: usize) -> i128 {
    i128::from(p[i]) * i128::from(q[j]) - i128::from(q[i]) * i128::from(p[j])
}

/// Squared length. B <= 62: at most 125.6 bits.
#[inline(always)]
fn lift_small(p: &[i64; 3]) -> i128 {
    p.iter().map(|&x| i128::from(x) * i128::from(x)).sum()
}

/// factor·minor. B <= 62: at most 187 bits and a sign.
#[inline(always)]
fn product_small(factor: i64, minor: i128) -> Int<3> {
    Int::from_i64(factor).mul(&Int::from_i128(minor))
}

/// The determinant with rows a, b, c. B <= 62: 3B + 2.6 = 188.6 bits and a sign.
#[inline(always)]
fn det3_small(a: &[i64; 3], b: &[i64; 3], c: &[i64; 3]) -> Int<3> {
    product_small(a[2], minor(b, c, 0, 1))
        .add(&product_small(b[2], minor(c, a, 0, 1)))
        .add(&product_small(c[2], minor(a, b, 0, 1)))
}

/// The in-sphere determinant. B <= 62: 5B + 6.2 = 316.2 bits and a sign.
fn insphere_small(a: &[i64; 3], b: &[i64; 3], c: &[i64; 3], d: &[i64; 3]) -> Int<5> {
    let m = |p, q| minor(p, q, 0, 1);
    let [ab, bc, cd, da, ac, bd] = [m(b, a), m(c, b), m(d, c), m(a, d), m(c, a), m(d, b)];
    let p = product_small;
    let bcd = p(b[2], cd).sub(&p(c[2], bd)).add(&p(d[2], bc));
    let cda = p(c[2], da).add(&p(d[2], ac)).add(&p(a[2], cd));
    let dab = p(d[2], ab).add(&p(a[2], bd)).add(&p(b[2], da));
    let abc = p(a[2], bc).sub(&p(b[2], ac)).add(&p(c[2], ab));

    let lift = |p: &[i64; 3]| Int::from_i128(lift_small(p));
    let [wa, wb, wc, wd]: [Int<5>; 4] =
        [lift(a).mul(&bcd), lift(b).mul(&cda), lift(c).mul(&dab), lift(d).mul(&abc)];
    wd.sub(&wc).add(&wb.sub(&wa))
}

/// The in-circle determinant. B <= 62: 18 · 2^4B and a sign, 254 bits.
#[inline(always)]
fn incircle_small(a: &[i64; 3], b: &[i64; 3], c: &[i64; 3], [i, j]: [usize; 2]) -> Int<4> {
    let term = |p: &[i64; 3], u: &[i64; 3], v: &[i64; 3]| -> Int<4> {
        Int::from_i128(lift_small(p)).mul(&Int::from_i128(minor(u, v, i, j)))
    };
    term(a, b, c).add(&term(b, c, a)).add(&term(c, a, b))
}

/// p[i]·q[j] - q[i]·p[j]. B <= 124: at most 249 bits and a sign.
#[inline(always)]
fn minor_medium(p: &[i128; 3], q: &[i128; 3], i: usize, j: usize) -> Int<4> {
    let product = |x: i128, y: i128| Int::from_i128(x).mul(&Int::from_i128(y));
    product(p[i], q[j]).sub(&product(q[i], p[j]))
}

/// Squared length. B <= 124: at most 249.6 bits and a sign.
#[inline(always)]
fn lift_medium(p: &[i128; 3]) -> Int<4> {
    let [x, y, z] = p.map(|x| Int::from_i128(x).mul(&Int::from_i128(x)));
    x.add(&y).add(&z)
}

/// The determinant with rows a, b, c. B <= 124: 3B + 2.6 = 374.6 bits and a sign.
fn det3_medium(a: &[i128; 3], b: &[i128; 3], c: &[i128; 3]) -> Int<6> {
    let term = |p: &[i128; 3], u: &[i128; 3], v: &[i128; 3]| -> Int<6> {
        Int::from_i128(p[2]).mul(&minor_medium(u, v, 0, 1))
    };
    term(a, b, c).add(&term(b, c, a)).add(&term(c, a, b))
}

/// The in-sphere determinant. B <= 124: 5B + 6.2 = 626.2 bits and a sign.
fn insphere_medium(a: &[i128; 3], b: &[i128; 3], c: &[i128; 3], d: &[i128; 3]) -> Int<10> {
    let term = |p: &[i128; 3], u: &[i128; 3], v: &[i128; 3], w: &[i128; 3]| -> Int<10> {
        lift_medium(p).mul(&det3_medium(u, v, w))
    };
    // Expansion of the 4x4 determinant along its lift column, negated: positive inside.
    let [wa, wb, wc, wd] = [term(a, b, c, d), term(b, a, c, d), term(c, a, b, d), term(d, a, b, c)];
    wa.sub(&wb).add(&wc.sub(&wd))
}

/// The in-circle determinant. B <= 124: 18 · 2^4B and a sign, 502 bits.
#[inline(always)]
fn incircle_medium(a: &[i128; 3], b: &[i128; 3], c: &[i128; 3], [i, j]: [usize; 2]) -> Int<8> {
    let term = |p: &[i128; 3], u: &[i128; 3], v: &[i128; 3]| -> Int<8> {
        lift_medium(p).mul(&minor_medium(u, v, i, j))
    };
    term(a, b, c).add(&term(b, c, a)).add(&term(c, a, b))
}
