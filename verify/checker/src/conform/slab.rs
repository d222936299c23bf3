//! The slab of a tolerance about a plane, and products of vectors.

use super::whole::{Units, Whole};
use crate::exact::dyadic;
use num_bigint::BigInt;

/// The tolerance, as mantissa · 2^exponent units.
#[derive(Debug, Clone)]
pub(crate) struct Slab {
    mantissa: BigInt,
    exponent: i32,
}

impl Slab {
    pub(crate) fn new(tolerance: f64, units: &Units) -> Self {
        let (mantissa, exponent) = dyadic(tolerance);
        Self { mantissa: BigInt::from(mantissa), exponent: exponent - units.exponent() }
    }

    /// Is `value`² at most the tolerance² times `square`?
    pub(crate) fn holds(&self, value: &BigInt, square: &BigInt) -> bool {
        let (left, right) = (value * value, &self.mantissa * &self.mantissa * square);
        match self.exponent {
            e @ 0.. => left <= right << (2 * e),
            e => left << (-2 * e) <= right,
        }
    }
}

pub(crate) fn minus(a: &Whole, b: &Whole) -> Whole {
    [0, 1, 2].map(|k| a[k] - b[k])
}

/// Entries below 2^62 have products that fit.
pub(crate) fn cross(a: &Whole, b: &Whole) -> Whole {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| a[i] * b[j] - a[j] * b[i])
}

pub(crate) fn dot(a: &Whole, b: &Whole) -> i128 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

pub(crate) fn big_dot(a: &Whole, b: &Whole) -> BigInt {
    (0..3).map(|k| BigInt::from(a[k]) * BigInt::from(b[k])).sum()
}

impl Slab {
    /// Is `square` at most the tolerance² times `other`?
    pub(crate) fn squares(&self, square: &BigInt, other: &BigInt) -> bool {
        let right = &self.mantissa * &self.mantissa * other;
        match self.exponent {
            e @ 0.. => *square <= right << (2 * e),
            e => square << (-2 * e) <= right,
        }
    }
}
