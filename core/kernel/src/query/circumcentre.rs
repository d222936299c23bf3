//! Circumcentres in `f64`, each with a rigorous bound of its error.
//!
//! With A, B, C the differences of three vertices to the fourth, d, the circumcentre is d + N / D
//! for N = |A|^2 (B x C) + |B|^2 (C x A) + |C|^2 (A x B) and D = 2 A . (B x C). Both are computed
//! in `f64` with bounds of their errors; if the bound of the quotient is poor (a nearly flat
//! tetrahedron) or the extents leave the range of the proof, big integers give the centre to
//! within one unit in the last place.
//!
//! Errors, in units of u = 2^-53, mx, my, mz and L being the largest differences and squared
//! lengths: |D/2| as in [`filter::ORIENT3D_ERROR`]; each component of N carries at most 12
//! relative roundings (5 of a squared length, differences included; 4 of a minor; 1 of their
//! product; 2 of the sum), so its error is at most 12.01u times 3 L 2 mi mj, below 80u L mi mj.

use super::Queries;
use crate::topology::TetId;
use ltbw_exact::Point;
use ltbw_exact::predicates::filter::{self, GUARD_HIGH, GUARD_LOW, UNIT_ROUNDOFF, power_of_two};
use ltbw_exact::predicates::long::{Parts, parts};
use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};

/// Error of a component of N over L mi mj.
const NUMERATOR_ERROR: f64 = 80.0 * UNIT_ROUNDOFF;
/// A bound above this part of the offset from d is not good enough.
const GOOD: f64 = 1.0 / (1 << 20) as f64;
/// The least positive `f64`.
const LEAST: f64 = f64::from_bits(1);

/// The centre of a tetrahedron's circumsphere, rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Circumcentre {
    /// The computed centre, in the input's coordinates.
    pub centre: Point,
    /// No coordinate of the true centre differs from the computed one by more than this: at most
    /// 2^-20 of the circumradius, or two units in the last place of the largest coordinate.
    /// Infinite if the true centre is beyond the range of `f64`.
    pub error: f64,
}

impl Queries<'_> {
    /// The circumcentre of a finite tetrahedron; `None` if `t` is not one.
    ///
    /// Cost: some 40 ns; microseconds, and memory for big integers, if the tetrahedron is nearly
    /// flat.
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// let corners = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 6.0]];
    /// let mesh = Builder::new().build(&PointSet::new(corners)?)?.mesh;
    /// let t = mesh.tet_ids().next().expect("a tetrahedron");
    /// let found = mesh.queries().circumcentre(t).expect("a tetrahedron");
    /// let expected = [1.0, 2.0, 3.0];
    /// assert!((0..3).all(|k| (found.centre[k] - expected[k]).abs() <= found.error));
    /// assert!(found.error < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn circumcentre(&self, t: TetId) -> Option<Circumcentre> {
        self.mesh.tet(t)?;
        let mode = self.mesh.mode();
        let kernel = self.mesh.topology.tet(t).vertices();
        let corners = kernel.map(|v| mode.from_kernel(self.mesh.kernel_point(v)));
        Some(quick(&corners).unwrap_or_else(|| by_integers(&corners)))
    }
}

/// In `f64`; `None` if the bound of the error is not good.
fn quick([a, b, c, d]: &[Point; 4]) -> Option<Circumcentre> {
    let [a, b, c] = [a, b, c].map(|p| [0, 1, 2].map(|k| p[k] - d[k]));
    let extent = [0, 1, 2].map(|k| a[k].abs().max(b[k].abs()).max(c[k].abs()));
    if !extent.iter().all(|&m| m > GUARD_LOW && m < GUARD_HIGH) {
        return None;
    }
    // In the order of evaluation for which ORIENT3D_ERROR is proved.
    let half = a[2] * (b[0] * c[1] - c[0] * b[1])
        + b[2] * (c[0] * a[1] - a[0] * c[1])
        + c[2] * (a[0] * b[1] - b[0] * a[1]);
    let half_error = filter::ORIENT3D_ERROR * extent[0] * extent[1] * extent[2];
    let least = half.abs() - half_error;
    // Written so that NaN is refused.
    let certain = least > 0.0;
    if !certain {
        return None;
    }
    let lift = |p: &Point| p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    let (la, lb, lc) = (lift(&a), lift(&b), lift(&c));
    let longest = la.max(lb).max(lc);
    let (mut centre, mut error, mut reach) = ([0.0; 3], 0.0f64, 0.0f64);
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let minor = |p: &Point, q: &Point| p[i] * q[j] - p[j] * q[i];
        let numerator = la * minor(&b, &c) + lb * minor(&c, &a) + lc * minor(&a, &b);
        let numerator_error = NUMERATOR_ERROR * longest * extent[i] * extent[j];
        let offset = 0.5 * numerator / half;
        centre[k] = d[k] + offset;
        let quotient_error = (offset.abs() * half_error + 0.5 * numerator_error) / least;
        let rounding = UNIT_ROUNDOFF * (offset.abs() + centre[k].abs()) + LEAST;
        // The bound's own roundings are below 20u.
        error = error.max(1.001 * (quotient_error + rounding));
        reach = reach.max(offset.abs());
        // `max` forgets NaN.
        if !(quotient_error.is_finite() && centre[k].is_finite()) {
            return None;
        }
    }
    (error <= GOOD * reach).then_some(Circumcentre { centre, error })
}

/// In big integers, then rounded.
#[cold]
fn by_integers(corners: &[Point; 4]) -> Circumcentre {
    let nonzero = corners.iter().flatten().filter(|&&c| c != 0.0);
    let unit = nonzero.map(|&c| parts(c).exponent).min().unwrap_or(0);
    let integers = corners.map(|p| {
        p.map(|c| {
            let Parts { mantissa, exponent, is_negative } = parts(c);
            // Zero has the least exponent of all, and no unit.
            let magnitude = BigInt::from(mantissa) << (exponent - unit).max(0);
            if is_negative { -magnitude } else { magnitude }
        })
    });
    let [a, b, c, d] = integers;
    let [a, b, c] = [a, b, c].map(|p| [0, 1, 2].map(|k| &p[k] - &d[k]));
    let lift = |p: &[BigInt; 3]| -> BigInt { p.iter().map(|x| x * x).sum() };
    let cross = |p: &[BigInt; 3], q: &[BigInt; 3]| {
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &p[i] * &q[j] - &p[j] * &q[i])
    };
    let (bc, ca, ab) = (cross(&b, &c), cross(&c, &a), cross(&a, &b));
    let denominator: BigInt = (0..3).map(|k| 2 * &a[k] * &bc[k]).sum();
    let centre = [0, 1, 2].map(|k| {
        let offset = lift(&a) * &bc[k] + lift(&b) * &ca[k] + lift(&c) * &ab[k];
        rounded(&(offset + &d[k] * &denominator), &denominator, unit)
    });
    let largest = centre.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    Circumcentre { centre, error: f64::EPSILON * largest + LEAST }
}

/// numerator / denominator 2^exponent, within one unit in the last place; infinite beyond the
/// range of `f64`. The denominator is not zero: no tetrahedron is flat.
fn rounded(numerator: &BigInt, denominator: &BigInt, exponent: i32) -> f64 {
    if numerator.is_zero() || denominator.is_zero() {
        return 0.0;
    }
    // A quotient of 100 or 101 bits fits into u128.
    let shift = 100 - (numerator.bits() as i64 - denominator.bits() as i64);
    let (mut n, mut d) = (numerator.abs(), denominator.abs());
    if shift >= 0 {
        n <<= shift;
    } else {
        d <<= -shift;
    }
    let mut value = (n / d).to_u128().map_or(f64::INFINITY, |q| q as f64);
    let mut left = i64::from(exponent) - shift;
    // Ends: each step takes up to 1000 of at most some ten thousand.
    while left != 0 && value != 0.0 && value.is_finite() {
        let part = left.clamp(-1000, 1000);
        value *= power_of_two(part as i32);
        left -= part;
    }
    if numerator.is_negative() == denominator.is_negative() { value } else { -value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_exact::predicates::{Sign, exact};

    /// Four points with coordinates of a few bits, of all bits, or within ulps of one plane.
    fn corners(kind: usize, next: &mut impl FnMut() -> u64) -> [Point; 4] {
        let mut fraction = || (next() >> 11) as f64 * 2f64.powi(-53);
        [0; 4].map(|_| {
            let [x, y, z] = [fraction(), fraction(), fraction()];
            match kind {
                0 => [x, y, z].map(|c| (c * 9.0).floor()),
                1 => [x, y, z],
                _ => [x, y, x + y + (z * 4.0).floor() * f64::EPSILON],
            }
        })
    }

    #[test]
    fn both_ways_agree_within_their_bounds() {
        let mut s = 42u64;
        let mut next = || {
            s ^= s << 13;
            s ^= s >> 7;
            s ^= s << 17;
            s
        };
        let mut seen = [[0; 2]; 3];
        for k in 0..6000 {
            let kind = k % 3;
            let tet = corners(kind, &mut next);
            let [a, b, c, d] = &tet;
            if exact::orient3d(a, b, c, d) == Sign::Zero {
                continue;
            }
            let slow = by_integers(&tet);
            assert!(
                slow.error
                    <= 2.0 * f64::EPSILON * slow.centre.map(f64::abs).iter().sum::<f64>() + LEAST
            );
            match quick(&tet) {
                None => seen[kind][0] += 1,
                Some(fast) => {
                    seen[kind][1] += 1;
                    for axis in 0..3 {
                        let off = (fast.centre[axis] - slow.centre[axis]).abs();
                        assert!(off <= fast.error + slow.error, "{tet:?}: {fast:?} {slow:?}");
                    }
                }
            }
        }
        assert!(seen[0][1] > 1000 && seen[1][1] > 1000 && seen[2][0] > 1000, "{seen:?}");
    }

    #[test]
    fn integers_give_known_centres_at_any_scale() {
        for scale in [-1060, -700, 0, 700, 1010] {
            let unit = power_of_two(scale / 2) * power_of_two(scale - scale / 2);
            let tet = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 6.0]];
            let found = by_integers(&tet.map(|p| p.map(|c| c * unit)));
            assert_eq!(found.centre, [unit, 2.0 * unit, 3.0 * unit]);
        }
        // 1/3 is rounded; the centre of a nearly flat tetrahedron is beyond f64.
        assert!((rounded(&BigInt::from(-1), &BigInt::from(3), 0) + 1.0 / 3.0).abs() < 1e-16);
        let flat = [[0.0; 3], [1e300, 0.0, 0.0], [0.0, 1e300, 0.0], [1e300, 1e300, 1e-300]];
        let found = by_integers(&flat);
        assert!(found.error.is_infinite() || found.centre.iter().all(|c| c.is_finite()));
        let far = [[0.0; 3], [1e300, 0.0, 0.0], [0.0, 1e300, 0.0], [1e300, 2e300, 1e-300]];
        assert!(by_integers(&far).error.is_infinite());
    }
}
