//! Exact numbers of the check: places along a line, and volumes.

use ltbw_exact::Point;
use ltbw_exact::predicates::filter::power_of_two;
use ltbw_exact::predicates::long::{Parts, parts};
use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::fmt;

/// The exponent of the least bit that any coordinate has; 0 if all are zero.
fn unit<'a>(points: impl Iterator<Item = &'a Point>) -> i32 {
    let coordinates = points.flatten().filter(|&&c| c != 0.0);
    coordinates.map(|&c| lowest_bit(c)).min().unwrap_or(0)
}

/// The exponent of the lowest bit of a number that is not zero.
fn lowest_bit(value: f64) -> i32 {
    let Parts { mantissa, exponent, .. } = parts(value);
    exponent + mantissa.trailing_zeros() as i32
}

/// A point in units of 2^unit, of which its coordinates have to be multiples.
fn integers(p: &Point, unit: i32) -> [BigInt; 3] {
    p.map(|c| {
        if c == 0.0 {
            return BigInt::zero();
        }
        let Parts { mantissa, exponent, is_negative } = parts(c);
        let shift = exponent - unit;
        let magnitude = if shift >= 0 {
            BigInt::from(mantissa) << shift
        } else {
            BigInt::from(mantissa >> -shift)
        };
        if is_negative { -magnitude } else { magnitude }
    })
}

/// det(a, b, c).
fn determinant<T>([a, b, c]: [&[T; 3]; 3]) -> T
where
    for<'a> &'a T: std::ops::Mul<&'a T, Output = T>,
    T: std::ops::Sub<Output = T> + std::ops::Add<Output = T>,
{
    let minor = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
    &a[0] * &minor(1, 2) + &a[1] * &minor(2, 0) + &a[2] * &minor(0, 1)
}

/// The point where a line segment passes through a triangle's plane, as a fraction of its length.
#[derive(Debug, Clone)]
pub(super) struct Along {
    numerator: BigInt,
    /// Positive.
    denominator: BigInt,
}

impl Along {
    /// The segment from `from` to `to`, whose ends are strictly on different sides.
    pub(super) fn new(from: &Point, to: &Point, corners: [&Point; 3]) -> Self {
        let unit = unit(corners.into_iter().chain([from, to]));
        let [a, b, c] = corners.map(|p| integers(p, unit));
        let minus = |p: &[BigInt; 3]| -> [BigInt; 3] { std::array::from_fn(|k| &p[k] - &a[k]) };
        let (u, v) = (minus(&b), minus(&c));
        let height = |p: &Point| determinant([&u, &v, &minus(&integers(p, unit))]);
        let (start, end) = (height(from), height(to));
        let (numerator, denominator) = (start.clone(), start - end);
        if denominator.is_negative() {
            Self { numerator: -numerator, denominator: -denominator }
        } else {
            Self { numerator, denominator }
        }
    }

    /// Which of the two comes first.
    pub(super) fn cmp(&self, other: &Self) -> Ordering {
        (&self.numerator * &other.denominator).cmp(&(&other.numerator * &self.denominator))
    }

    /// Rounded.
    pub(super) fn to_f64(&self) -> f64 {
        ratio(&self.numerator, &self.denominator)
    }
}

/// A quotient, rounded: with 64 bits of the denominator, then once more.
fn ratio(numerator: &BigInt, denominator: &BigInt) -> f64 {
    let bits = |n: &BigInt| i64::try_from(n.bits()).unwrap_or(i64::MAX);
    // As many bits more in the numerator as make the quotient one of 64 bits or so.
    let shift = (64 + bits(denominator) - bits(numerator)).max(0);
    // Below the least double.
    if shift > 1400 {
        return 0.0;
    }
    let quotient = (numerator << shift) / denominator;
    quotient.to_f64().unwrap_or(f64::NAN) * power(-shift as i32)
}

/// A triangle of a surface, and how often its volume counts.
#[derive(Clone, Copy)]
pub(super) struct Turned {
    pub(super) corners: [u32; 3],
    /// -1 where it is seen from its other side; at most 1.
    pub(super) factor: i32,
}

/// An exact volume: a rational number.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Volume {
    /// Six times the volume, in units of 2^exponent; odd unless zero.
    sixfold: BigInt,
    exponent: i32,
}

impl Volume {
    fn new(sixfold: BigInt, exponent: i32) -> Self {
        match sixfold.trailing_zeros() {
            None => Self::default(),
            Some(zeros) => Self { sixfold: sixfold >> zeros, exponent: exponent + zeros as i32 },
        }
    }

    /// The sum over triangles of the signed volumes of the tetrahedra that they form with the
    /// origin, each times its factor. Over a closed surface: the volume inside.
    pub(super) fn of_cone(points: &[Point], triangles: &[Turned]) -> Self {
        let of = |turned: &Turned| turned.corners.map(|v| &points[v as usize]);
        let corners = || triangles.iter().flat_map(of);
        let unit = unit(corners());
        let highest = corners().flatten().filter(|&&c| c != 0.0).map(|&c| highest_bit(c)).max();
        // Bits of a product of three coordinates, of the six of them in a determinant, of the sum.
        let bits = 3 * (highest.unwrap_or(unit) - unit + 1) + 3;
        let count = triangles.len().max(1).ilog2() as i32 + 1;
        let sum = if bits + count < 126 {
            let small = |p: &Point| p.map(|c| (c / power(unit)) as i128);
            let one = |turned: &Turned| {
                let [a, b, c] = of(turned).map(small);
                determinant([&a, &b, &c]) * i128::from(turned.factor)
            };
            BigInt::from(triangles.par_iter().map(one).sum::<i128>())
        } else {
            let one = |turned: &Turned| {
                let [a, b, c] = of(turned).map(|p| integers(p, unit));
                determinant([&a, &b, &c]) * turned.factor
            };
            triangles.par_iter().map(one).reduce(BigInt::zero, |a, b| a + b)
        };
        Self::new(sum, 3 * unit)
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        let unit = self.exponent.min(other.exponent);
        let raise = |v: &Self| &v.sixfold << (v.exponent - unit);
        Self::new(raise(self) + raise(other), unit)
    }

    /// Rounded to a double.
    #[must_use]
    pub fn to_f64(&self) -> f64 {
        let [numerator, denominator] = self.fraction();
        ratio(&numerator, &denominator)
    }

    /// Numerator and denominator in lowest terms.
    fn fraction(&self) -> [BigInt; 2] {
        let three = BigInt::from(3);
        let (mut numerator, mut denominator) = (self.sixfold.clone(), BigInt::from(1));
        if (&numerator % &three).is_zero() {
            numerator /= three;
        } else {
            denominator = three;
        }
        // The other factor of six is one of the units; the numerator is odd (or zero).
        let exponent = if numerator.is_zero() { 0 } else { self.exponent - 1 };
        if exponent >= 0 {
            numerator <<= exponent
        } else {
            denominator <<= -exponent
        }
        [numerator, denominator]
    }
}

/// The exponent of the highest bit of a number that is not zero.
fn highest_bit(value: f64) -> i32 {
    let Parts { mantissa, exponent, .. } = parts(value);
    exponent + 63 - mantissa.leading_zeros() as i32
}

/// 2^exponent, in two steps that are normal numbers for all units of `f64`s.
fn power(exponent: i32) -> f64 {
    power_of_two(exponent / 2) * power_of_two(exponent - exponent / 2)
}

impl fmt::Display for Volume {
    /// As a fraction in lowest terms: `47/48`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [numerator, denominator] = self.fraction();
        if denominator == BigInt::from(1) {
            write!(f, "{numerator}")
        } else {
            write!(f, "{numerator}/{denominator}")
        }
    }
}
