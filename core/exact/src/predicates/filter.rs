//! Floating-point filters: most signs without exact arithmetic.
//!
//! Every filter is *semi-static*: it evaluates a value in `f64` and compares it with a bound of its
//! error: constants times products of the largest coordinate differences mx, my, mz and
//! m = max(mx, my, mz). `None` means "not decided", never a guess.
//!
//! The filters, orders of evaluation and constants are generated from one description of each
//! predicate, and so are the terms of which `verify/proofs` proves that the constants hold. This
//! module holds what they share.
//!
//! * `*_window`: no guard. Sound when every coordinate `c` is 0 or 2^-142 <= |c| < 2^200 (the
//!   exactness window): differences are then multiples of 2^-194 below 2^201, so that no
//!   expression of degree 5 or less overflows or rounds below the normal range.
//! * `*_any`: sound for any finite coordinates. Guard: those of mx, my, mz that are not zero lie
//!   in a range of powers of two, as do parameters. An axis without extent makes a determinant
//!   exactly zero.
//! * `*_lattice`: exact for small multiples of a power of two.
//!
//! Comparisons are written `value > bound || -value > bound`, never negated, so that NaN decides
//! nothing. The determinants of `orient3d` and `insphere` are those of Shewchuk's `predicates.c`,
//! whose signs are opposite to ours: hence the negated values.

mod generated;

pub use generated::*;

use super::Sign;

/// Unit roundoff u of `f64`: 2^-53.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// The guard of the filters for any coordinates: extents outside (`GUARD_LOW`, `GUARD_HIGH`) that
/// are not zero leave the decision to the exact stages. 2^-190: even the product of five extents
/// stays normal, and gradual underflow of the terms is lost in the slack of the constants.
pub const GUARD_LOW: f64 = power_of_two(-190);

/// See [`GUARD_LOW`]. 2^200: the product of five extents stays finite.
pub const GUARD_HIGH: f64 = power_of_two(200);

/// 2^exponent, for the exponents of normal numbers: -1022 to 1023.
#[inline]
pub const fn power_of_two(exponent: i32) -> f64 {
    assert!(-1022 <= exponent && exponent <= 1023, "a normal power of two");
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

/// The larger one; a single instruction, unlike `f64::max`. No operand is ever NaN here.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller one, likewise.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The sign of `value` if |value| exceeds its error bound.
#[inline(always)]
fn decide(value: f64, bound: f64) -> Option<Sign> {
    if value > bound {
        Some(Sign::Positive)
    } else if -value > bound {
        Some(Sign::Negative)
    } else {
        None
    }
}

/// Is this extent or parameter one with which the filters are proved?
#[inline(always)]
fn within(value: f64, low: f64, high: f64) -> bool {
    value > low && value < high
}

#[cfg(test)]
mod tests {
    use super::*;
    use Sign::{Negative, Positive};

    const O: [f64; 3] = [0.0; 3];
    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn balls_have_an_inside_and_an_outside() {
        let far = [0.5, 0.5, 0.75];
        let near = [0.5, 0.5, 0.625];
        // The ball with the diameter XY: radius √½ = 0.7071 around (½, ½, 0).
        assert_eq!(in_diametral_ball_any(&X, &Y, &far), Some(Negative));
        assert_eq!(in_diametral_ball_any(&X, &Y, &near), Some(Positive));
        assert_eq!(in_diametral_ball_any(&X, &Y, &O), None, "on the sphere");
        // The equatorial ball of the right triangle OXY is the same.
        for [a, b, c] in [[O, X, Y], [Y, O, X], [X, O, Y]] {
            assert_eq!(in_equatorial_ball_any(&a, &b, &c, &far), Some(Negative));
            assert_eq!(in_equatorial_ball_any(&a, &b, &c, &near), Some(Positive));
            assert_eq!(in_equatorial_ball_any(&a, &b, &c, &[1.0, 1.0, 0.0]), None, "on the sphere");
        }
    }

    #[test]
    fn bounds_are_exceeded_or_not() {
        // Circumradius √3/2, shortest edge 1, volume 1/6, whatever the order of the corners.
        let corners = [O, X, Y, Z];
        for turn in 0..4 {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| corners[(k + turn) % 4]);
            assert_eq!(exceeds_radius_edge_any(&a, &b, &c, &d, 0.866), Some(Positive));
            assert_eq!(exceeds_radius_edge_any(&a, &b, &c, &d, 0.867), Some(Negative));
        }
        assert_eq!(exceeds_volume_any(&O, &X, &Y, &Z, 0.1666), Some(Positive));
        assert_eq!(exceeds_volume_any(&O, &X, &Y, &Z, 0.1667), Some(Negative));
        assert_eq!(exceeds_volume_any(&X, &O, &Y, &Z, 0.1), Some(Negative), "a negative volume");
        assert_eq!(exceeds_volume_any(&O, &X, &Y, &[1.0, 1.0, 0.0], 1e-9), None, "no extent");
    }

    #[test]
    fn guards_leave_the_ends_of_the_range_undecided() {
        let at = |c: f64| [O, X, Y, Z].map(|p| p.map(|x| x * c));
        for exponent in [-200, 210] {
            let [a, b, c, d] = at(power_of_two(exponent));
            assert_eq!(in_diametral_ball_any(&a, &b, &d), None);
            assert_eq!(in_equatorial_ball_any(&a, &b, &c, &d), None);
            assert_eq!(exceeds_radius_edge_any(&a, &b, &c, &d, 0.1), None);
            assert_eq!(exceeds_volume_any(&a, &b, &c, &d, power_of_two(-599)), None);
        }
    }
}
