//! Coordinates as whole numbers of one power of two, and exact sums of them.

use crate::exact::{dyadic, lowest_bit};
use crate::mesh::Point;
use num_bigint::BigInt;

/// Bits of a coordinate that this module can take: products of two differences fit in i128.
const BITS: u32 = 60;

/// A point in units.
pub(crate) type Whole = [i128; 3];

/// The unit: 2^low.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Units {
    low: i32,
}

impl Units {
    /// The largest unit of which all coordinates are multiples; `None` if one has more than 2^60
    /// of them or is not finite.
    pub(crate) fn of(points: &[&[Point]]) -> Option<Self> {
        let units = Self::at(Self::lowest(points)?);
        units.fit_all(points).then_some(units)
    }

    /// The exponent of that unit, however many of it a coordinate has; the largest number if all
    /// are zero, and `None` if one is not finite.
    pub(crate) fn lowest(points: &[&[Point]]) -> Option<i32> {
        let all = || points.iter().flat_map(|list| list.iter());
        let is_finite = all().all(|p| p.iter().all(|c| c.is_finite()));
        let nonzero = all().filter(|p| p.iter().any(|&c| c != 0.0));
        is_finite.then(|| nonzero.map(|p| lowest_bit(&[p])).min().unwrap_or(i32::MAX))
    }

    /// The unit with such an exponent.
    pub(crate) fn at(lowest: i32) -> Self {
        Self { low: if lowest == i32::MAX { 0 } else { lowest } }
    }

    /// Has no coordinate more than 2^60 of them?
    pub(crate) fn fit_all(&self, points: &[&[Point]]) -> bool {
        points.iter().flat_map(|list| list.iter()).all(|p| p.iter().all(|&c| self.fits(c)))
    }

    fn fits(&self, c: f64) -> bool {
        let (mantissa, exponent) = dyadic(c);
        let bits = 64 - mantissa.unsigned_abs().leading_zeros();
        mantissa == 0
            || i64::from(exponent) + i64::from(bits) - i64::from(self.low) <= i64::from(BITS)
    }

    /// A point in units; for a point that is not on them, rounded towards zero.
    pub(crate) fn whole(&self, p: &Point) -> Whole {
        p.map(|c| {
            let (mantissa, exponent) = dyadic(c);
            let shift = exponent - self.low;
            match shift {
                0..=66 => i128::from(mantissa) << shift,
                ..0 => i128::from(mantissa) >> (-shift).min(64),
                _ => i128::from(mantissa.signum()) << 66,
            }
        })
    }

    /// The exponent of the unit.
    pub(crate) fn exponent(&self) -> i32 {
        self.low
    }

    /// An area of square units in the coordinates of the mesh, rounded.
    pub(crate) fn square(&self, area: f64) -> f64 {
        let half = f64::from_bits(((1023 + self.low.clamp(-1022, 1023)) as u64) << 52);
        area * half * half
    }

    /// A volume in cubic units: exact but for overflow and underflow, which bounds of meshes that
    /// fit do not reach.
    pub(crate) fn cubic(&self, volume: f64) -> f64 {
        let half = |e: i32| f64::from_bits(((1023 + e.clamp(-1022, 1023)) as u64) << 52);
        volume * half(-self.low) * half(-self.low) * half(-self.low)
    }

    /// A length in units, as [`Units::cubic`] has volumes.
    pub(crate) fn linear(&self, length: f64) -> f64 {
        length * f64::from_bits(((1023 + (-self.low).clamp(-1022, 1023)) as u64) << 52)
    }

    /// `sum` cubic units over 6, as a fraction in lowest terms.
    pub(crate) fn sixth(&self, sum: &BigInt) -> Fraction {
        let (mut numerator, mut denominator) = (sum.clone(), BigInt::from(6));
        let shift = 3 * self.low;
        if shift >= 0 {
            numerator <<= shift;
        } else {
            denominator <<= -shift;
        }
        Fraction::reduced(numerator, denominator)
    }
}

/// An exact fraction in lowest terms, its denominator positive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fraction {
    numerator: BigInt,
    denominator: BigInt,
}

impl Fraction {
    fn reduced(numerator: BigInt, denominator: BigInt) -> Self {
        let (mut a, mut b) = (numerator.clone(), denominator.clone());
        // Euclid: ends because the remainders shrink.
        while b != BigInt::ZERO {
            (a, b) = (b.clone(), a % b);
        }
        let divisor = if a < BigInt::ZERO { -a } else { a };
        Self { numerator: numerator / &divisor, denominator: denominator / divisor }
    }
}

impl Fraction {
    /// The absolute difference to a fraction written as text, rounded; `None` if it is none.
    pub fn difference(&self, text: &str) -> Option<f64> {
        let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
        let (n, d): (BigInt, BigInt) = (numerator.parse().ok()?, denominator.parse().ok()?);
        let (top, bottom) = (&self.numerator * &d - n * &self.denominator, &self.denominator * d);
        if bottom <= BigInt::ZERO {
            return None;
        }
        let top = if top < BigInt::ZERO { -top } else { top };
        let bits = |x: &BigInt| i64::try_from(x.bits()).unwrap_or(i64::MAX);
        // A quotient of 60 bits, rounded.
        let shift = 60 + bits(&bottom) - bits(&top);
        let quotient = if shift >= 0 { (top << shift) / bottom } else { (top >> -shift) / bottom };
        let quotient: f64 = quotient.to_string().parse().ok()?;
        Some(quotient * (-(shift as f64)).exp2())
    }
}

impl std::fmt::Display for Fraction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.denominator == BigInt::from(1) {
            return write!(f, "{}", self.numerator);
        }
        write!(f, "{}/{}", self.numerator, self.denominator)
    }
}

/// Twice the signed area of a triangle in the plane; coordinates below 2^61.
pub(crate) fn twice_area(a: [i128; 2], b: [i128; 2], c: [i128; 2]) -> i128 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Six times the signed volume of a tetrahedron.
pub(crate) fn six_volumes([a, b, c, d]: [Whole; 4]) -> BigInt {
    let minus = |p: Whole| [0, 1, 2].map(|k| p[k] - a[k]);
    let (u, v, w) = (minus(b), minus(c), minus(d));
    let largest = u.iter().chain(&v).chain(&w).fold(0, |m: i128, c| m.max(c.abs()));
    let minor = |i: usize, j: usize| v[i] * w[j] - v[j] * w[i];
    let terms = [(u[0], minor(1, 2)), (u[1], minor(2, 0)), (u[2], minor(0, 1))];
    // 6 · 2^(3 · 41) is below 2^126.
    if largest < 1 << 41 {
        return BigInt::from(terms.iter().map(|(x, m)| x * m).sum::<i128>());
    }
    terms.iter().map(|(x, m)| BigInt::from(*x) * BigInt::from(*m)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_fractions_and_volumes() {
        let points = [[0.0, 0.5, 3.0], [-0.375, 8.0, 1.0]];
        let units = Units::of(&[&points]).expect("few bits");
        assert_eq!(units.whole(&points[1]), [-3, 64, 8]);
        // 47/48 cubic units of input are 47/48 · 8³ cubes of an eighth, times six.
        let sum = BigInt::from(47 * 64);
        assert_eq!(units.sixth(&sum).to_string(), "47/48");
        assert!(Units::of(&[&[[1.0, 2f64.powi(-70), 0.0]]]).is_none());
        assert!(Units::of(&[&[[f64::NAN, 0.0, 0.0]]]).is_none());
        let far = 1i128 << 60;
        let corner = [[0; 3], [far, 0, 0], [0, far, 0], [0, 0, far]];
        assert_eq!(six_volumes(corner), BigInt::from(1) << 180);
        assert_eq!(six_volumes([[1; 3], [3, 1, 1], [1, 3, 1], [1, 1, 3]]), BigInt::from(8));
    }
}
