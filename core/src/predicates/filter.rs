//! Floating-point filters: most signs without exact arithmetic.
//!
//! Every filter is *semi-static*: it evaluates the determinant in `f64`, in the order of
//! Shewchuk's `predicates.c` for which the constants are proved, and compares it with a constant
//! times a product of the largest coordinate differences mx, my, mz and m = max(mx, my, mz).
//! `None` means "not decided", never a guess.
//!
//! * `*_window`: no guard. Sound when every coordinate `c` is 0 or 2^-142 <= |c| < 2^200 (the
//!   exactness window): differences are then multiples of 2^-194 below 2^201, so that no
//!   expression of degree 5 or less overflows or rounds below the normal range.
//! * `*_any`: sound for any finite coordinates. Guard: those of mx, my, mz that are not zero lie
//!   in (2^-190, 2^200). An axis without extent makes the determinant exactly zero.
//!
//! Comparisons are written `det > bound || -det > bound`, never negated, so that NaN decides
//! nothing. The determinants are Shewchuk's, whose signs are opposite to ours: hence the swapped
//! answers of `orient3d` and `insphere`.

use super::Sign;
use crate::Point;

/// Unit roundoff u of `f64`: 2^-53.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// |error of `orient3d`| <= this times mx·my·mz.
///
/// Gappa proves 46.00 u for the sum itself; the rest covers the rounding of the bound.
pub const ORIENT3D_ERROR: f64 = 46.1 * UNIT_ROUNDOFF;

/// |error of `insphere`| <= this times mx·my·mz·m².
///
/// Gappa proves 1104 u for the sum itself; the rest covers the rounding of the bound.
pub const INSPHERE_ERROR: f64 = 1106.0 * UNIT_ROUNDOFF;

/// |error of a 2x2 minor| <= this times the product of the two extents.
///
/// From the theorem of `Filter.v`: k = 4u + O(u²) times the permanent, which is at most 2·mx·my;
/// the rest covers the rounding of the bound and gradual underflow under the guard.
pub const ORIENT2D_ERROR: f64 = 8.1 * UNIT_ROUNDOFF;

/// |error of `incircle`| <= this times mi·mj·m², i and j being the axes of the projection.
///
/// From the theorem of `Filter.v`: k = 12u + O(u²) times the permanent, which is at most
/// 3 · 3m² · 2·mi·mj; the rest covers the rounding of the bound and gradual underflow.
pub const INCIRCLE_ERROR: f64 = 217.0 * UNIT_ROUNDOFF;

/// The guard of the filters for any coordinates: extents outside (`GUARD_LOW`, `GUARD_HIGH`) that
/// are not zero leave the decision to the exact stages. 2^-190: even the product of five extents
/// stays normal, and gradual underflow of the terms is lost in the slack of the constants.
pub const GUARD_LOW: f64 = power_of_two(-190);

/// See [`GUARD_LOW`]. 2^200: the product of five extents stays finite.
pub const GUARD_HIGH: f64 = power_of_two(200);

/// 2^exponent, for the exponents of normal numbers: -1022 to 1023.
pub(crate) const fn power_of_two(exponent: i32) -> f64 {
    assert!(-1022 <= exponent && exponent <= 1023, "a normal power of two");
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

/// The larger one; a single instruction, unlike `f64::max`. No operand is ever NaN here.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The sign of `det` if |det| exceeds its error bound.
#[inline(always)]
fn decide(det: f64, bound: f64) -> Option<Sign> {
    if det > bound {
        Some(Sign::Positive)
    } else if -det > bound {
        Some(Sign::Negative)
    } else {
        None
    }
}

/// Is this extent one with which the filters are proved? Zero has to be handled before.
#[inline(always)]
fn guarded(extent: f64) -> bool {
    extent > GUARD_LOW && extent < GUARD_HIGH
}

/// Determinant and extents (mx, my, mz) of Shewchuk's `orient3d`, sign as in our convention.
#[inline(always)]
fn orient3d_det(a: &Point, b: &Point, c: &Point, d: &Point) -> (f64, Point) {
    let [adx, ady, adz] = [a[0] - d[0], a[1] - d[1], a[2] - d[2]];
    let [bdx, bdy, bdz] = [b[0] - d[0], b[1] - d[1], b[2] - d[2]];
    let [cdx, cdy, cdz] = [c[0] - d[0], c[1] - d[1], c[2] - d[2]];

    let det = adz * (bdx * cdy - cdx * bdy)
        + bdz * (cdx * ady - adx * cdy)
        + cdz * (adx * bdy - bdx * ady);

    let mx = larger(larger(adx.abs(), bdx.abs()), cdx.abs());
    let my = larger(larger(ady.abs(), bdy.abs()), cdy.abs());
    let mz = larger(larger(adz.abs(), bdz.abs()), cdz.abs());
    (-det, [mx, my, mz])
}

/// `orient3d` by filter, for points inside the exactness window; `None` if not decided.
#[inline(always)]
#[must_use]
pub fn orient3d_window(a: &Point, b: &Point, c: &Point, d: &Point) -> Option<Sign> {
    let (det, [mx, my, mz]) = orient3d_det(a, b, c, d);
    decide(det, ORIENT3D_ERROR * mx * my * mz)
}

/// [`orient3d_window`] for points whose coordinates are all multiples of the power of two `step`
/// (zero: of none): differences of at most 2^16 steps are decided without any error, for every
/// intermediate result is an integer of steps^3 below 6 2^48 < 2^53.
#[inline(always)]
#[must_use]
pub fn orient3d_lattice(a: &Point, b: &Point, c: &Point, d: &Point, step: f64) -> Option<Sign> {
    let (det, [mx, my, mz]) = orient3d_det(a, b, c, d);
    let sign = decide(det, ORIENT3D_ERROR * mx * my * mz);
    if sign.is_none() && larger(larger(mx, my), mz) <= 65536.0 * step {
        return Some(Sign::from_f64(det));
    }
    sign
}

/// `orient3d` by filter, for any finite coordinates; `None` if not decided.
#[inline(always)]
#[must_use]
pub fn orient3d_any(a: &Point, b: &Point, c: &Point, d: &Point) -> Option<Sign> {
    let (det, [mx, my, mz]) = orient3d_det(a, b, c, d);
    if guarded(mx) && guarded(my) && guarded(mz) {
        return decide(det, ORIENT3D_ERROR * mx * my * mz);
    }
    // With gradual underflow a difference is zero only between equal coordinates.
    if mx == 0.0 || my == 0.0 || mz == 0.0 { Some(Sign::Zero) } else { None }
}

/// Determinant and extents (mx, my, mz) of Shewchuk's `insphere`, sign as in our convention.
#[inline(always)]
fn insphere_det(a: &Point, b: &Point, c: &Point, d: &Point, e: &Point) -> (f64, Point) {
    let [aex, aey, aez] = [a[0] - e[0], a[1] - e[1], a[2] - e[2]];
    let [bex, bey, bez] = [b[0] - e[0], b[1] - e[1], b[2] - e[2]];
    let [cex, cey, cez] = [c[0] - e[0], c[1] - e[1], c[2] - e[2]];
    let [dex, dey, dez] = [d[0] - e[0], d[1] - e[1], d[2] - e[2]];

    let ab = aex * bey - bex * aey;
    let bc = bex * cey - cex * bey;
    let cd = cex * dey - dex * cey;
    let da = dex * aey - aex * dey;
    let ac = aex * cey - cex * aey;
    let bd = bex * dey - dex * bey;

    let abc = aez * bc - bez * ac + cez * ab;
    let bcd = bez * cd - cez * bd + dez * bc;
    let cda = cez * da + dez * ac + aez * cd;
    let dab = dez * ab + aez * bd + bez * da;

    let alift = aex * aex + aey * aey + aez * aez;
    let blift = bex * bex + bey * bey + bez * bez;
    let clift = cex * cex + cey * cey + cez * cez;
    let dlift = dex * dex + dey * dey + dez * dez;

    let det = (dlift * abc - clift * dab) + (blift * cda - alift * bcd);

    let mx = larger(larger(aex.abs(), bex.abs()), larger(cex.abs(), dex.abs()));
    let my = larger(larger(aey.abs(), bey.abs()), larger(cey.abs(), dey.abs()));
    let mz = larger(larger(aez.abs(), bez.abs()), larger(cez.abs(), dez.abs()));
    (-det, [mx, my, mz])
}

/// `insphere` by filter, for points inside the exactness window; `None` if not decided.
#[inline(always)]
#[must_use]
pub fn insphere_window(a: &Point, b: &Point, c: &Point, d: &Point, e: &Point) -> Option<Sign> {
    let (det, [mx, my, mz]) = insphere_det(a, b, c, d, e);
    let m = larger(larger(mx, my), mz);
    decide(det, INSPHERE_ERROR * mx * my * mz * (m * m))
}

/// [`insphere_window`] for points whose coordinates are all multiples of the power of two `step`
/// (zero: of none): differences of at most 2^9 steps are decided without any error, for every
/// intermediate result is an integer of steps^5 of at most 72 2^45 < 2^52.
#[inline(always)]
#[must_use]
pub fn insphere_lattice([a, b, c, d]: [&Point; 4], e: &Point, step: f64) -> Option<Sign> {
    let (det, [mx, my, mz]) = insphere_det(a, b, c, d, e);
    let m = larger(larger(mx, my), mz);
    let sign = decide(det, INSPHERE_ERROR * mx * my * mz * (m * m));
    if sign.is_none() && m <= 512.0 * step {
        return Some(Sign::from_f64(det));
    }
    sign
}

/// `insphere` by filter, for any finite coordinates; `None` if not decided.
#[inline(always)]
#[must_use]
pub fn insphere_any(a: &Point, b: &Point, c: &Point, d: &Point, e: &Point) -> Option<Sign> {
    let (det, [mx, my, mz]) = insphere_det(a, b, c, d, e);
    if guarded(mx) && guarded(my) && guarded(mz) {
        let m = larger(larger(mx, my), mz);
        return decide(det, INSPHERE_ERROR * mx * my * mz * (m * m));
    }
    if mx == 0.0 || my == 0.0 || mz == 0.0 { Some(Sign::Zero) } else { None }
}

/// Orientation of the projections of `a, b, c` to the axes of `plane`, by filter.
#[inline]
#[must_use]
pub fn orient2d_any(a: &Point, b: &Point, c: &Point, plane: [usize; 2]) -> Option<Sign> {
    let [i, j] = plane;
    let [aci, acj] = [a[i] - c[i], a[j] - c[j]];
    let [bci, bcj] = [b[i] - c[i], b[j] - c[j]];
    let mi = larger(aci.abs(), bci.abs());
    let mj = larger(acj.abs(), bcj.abs());
    if guarded(mi) && guarded(mj) {
        return decide(aci * bcj - acj * bci, ORIENT2D_ERROR * mi * mj);
    }
    if mi == 0.0 || mj == 0.0 { Some(Sign::Zero) } else { None }
}

/// The in-circle determinant of four points of one plane, projected to the axes of `plane`, by
/// filter: the lift is the squared distance in space, so that circles stay circles. Positive
/// inside if the projections of `a, b, c` turn counterclockwise.
#[inline]
#[must_use]
pub fn incircle_any(a: &Point, b: &Point, c: &Point, d: &Point, plane: [usize; 2]) -> Option<Sign> {
    let [i, j] = plane;
    let ad = [a[0] - d[0], a[1] - d[1], a[2] - d[2]];
    let bd = [b[0] - d[0], b[1] - d[1], b[2] - d[2]];
    let cd = [c[0] - d[0], c[1] - d[1], c[2] - d[2]];
    let extent = |k: usize| larger(larger(ad[k].abs(), bd[k].abs()), cd[k].abs());
    let [mi, mj] = [extent(i), extent(j)];
    let m = larger(larger(mi, mj), extent(3 - i - j));
    if !(guarded(mi) && guarded(mj) && guarded(m)) {
        return if mi == 0.0 || mj == 0.0 { Some(Sign::Zero) } else { None };
    }

    let lift = |p: &Point| p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    let det = lift(&ad) * (bd[i] * cd[j] - cd[i] * bd[j])
        + lift(&bd) * (cd[i] * ad[j] - ad[i] * cd[j])
        + lift(&cd) * (ad[i] * bd[j] - bd[i] * ad[j]);
    decide(det, INCIRCLE_ERROR * mi * mj * (m * m))
}
