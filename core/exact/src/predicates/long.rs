//! Exact sums of products of any finite `f64`, in fixed-point numbers wide enough for all of
//! them (Kulisch's long accumulator): no rounding, no allocation.

use std::cmp::Ordering;

use super::Sign;

/// Limbs of one product: five factors of 53 bits, moved by up to 63.
const LIMBS: usize = 6;

/// Words for sums of products of two `f64`: each is a multiple of 2^-2148 below 2^2048, 4196
/// bits; ten more for up to a thousand summands, and room for the upper limbs, which are zero.
pub const DEGREE_2: usize = 4206_usize.div_ceil(64) + LIMBS;
/// Words for sums of products of three factors.
pub const DEGREE_3: usize = 6304_usize.div_ceil(64) + LIMBS;
/// Words for sums of products of four factors.
pub const DEGREE_4: usize = 8402_usize.div_ceil(64) + LIMBS;
/// Words for sums of products of five factors.
pub const DEGREE_5: usize = 10500_usize.div_ceil(64) + LIMBS;

/// A sum of products, positive and negative ones apart, so that carries are short.
pub struct Sum<const WORDS: usize> {
    positive: [u64; WORDS],
    negative: [u64; WORDS],
}

impl<const WORDS: usize> Default for Sum<WORDS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const WORDS: usize> Sum<WORDS> {
    /// The empty sum.
    pub fn new() -> Self {
        Self { positive: [0; WORDS], negative: [0; WORDS] }
    }

    /// Adds (`sign` positive) or subtracts the product of `factors`: as many as `WORDS` is for,
    /// up to a thousand times.
    pub fn add<const FACTORS: usize>(&mut self, factors: [f64; FACTORS], sign: Sign) {
        let mut product = [0u64; LIMBS];
        product[0] = 1;
        let mut shift = 0;
        let mut negative = sign.is_negative();
        for (k, &factor) in factors.iter().enumerate() {
            let Parts { mantissa, exponent, is_negative } = parts(factor);
            if mantissa == 0 {
                return;
            }
            multiply(&mut product[..=k], mantissa);
            // Not negative: the least exponent of a bit of an f64 is -1074.
            shift += (exponent + 1074) as usize;
            negative ^= is_negative;
        }
        let (word, bit) = (shift / 64, shift % 64);
        let sum = if negative { &mut self.negative } else { &mut self.positive };
        let (mut carry, mut low) = (false, 0);
        for (k, digit) in sum[word..].iter_mut().enumerate() {
            let limb = product.get(k).copied().unwrap_or(0);
            let moved = if bit == 0 { limb } else { limb << bit | low >> (64 - bit) };
            low = limb;
            let (first, second);
            (*digit, first) = digit.overflowing_add(moved);
            (*digit, second) = digit.overflowing_add(u64::from(carry));
            carry = first | second;
            if k >= LIMBS && !carry {
                break;
            }
        }
    }

    /// The sign of the sum.
    pub fn sign(&self) -> Sign {
        Sign::from_ordering(self.compare())
    }

    /// The order of the sum and zero.
    pub fn compare(&self) -> Ordering {
        self.positive.iter().rev().cmp(self.negative.iter().rev())
    }
}

/// `number` times `factor`: the last limb of `number`, least first, must be zero.
#[inline(always)]
fn multiply(number: &mut [u64], factor: u64) {
    let mut carry = 0u64;
    for limb in number {
        // At most (2^64 - 1)^2 + 2^64 - 1 < 2^128.
        let wide = u128::from(*limb) * u128::from(factor) + u128::from(carry);
        (*limb, carry) = (wide as u64, (wide >> 64) as u64);
    }
}

/// The parts of an `f64`, whose magnitude is `mantissa` · 2^`exponent`.
#[derive(Clone, Copy, Debug)]
pub struct Parts {
    /// Below 2^53.
    pub mantissa: u64,
    /// At least -1074.
    pub exponent: i32,
    /// The sign bit.
    pub is_negative: bool,
}

/// The parts of a finite `f64`.
#[inline]
pub fn parts(value: f64) -> Parts {
    let bits = value.to_bits();
    let field = ((bits >> 52) & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let (mantissa, exponent) =
        if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
    Parts { mantissa, exponent, is_negative: bits >> 63 == 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicates::filter::power_of_two;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    /// Any bits; infinities and NaN made finite.
    fn any_finite() -> impl Strategy<Value = f64> {
        let finite = |bits| {
            let value = f64::from_bits(bits);
            if value.is_finite() { value } else { f64::from_bits(bits & !(1 << 62)) }
        };
        prop_oneof![
            4 => any::<u64>().prop_map(finite),
            1 => prop::sample::select(vec![0.0, -0.0, 5e-324, f64::MAX, f64::MIN, 1.0, -1.0]),
        ]
    }

    fn integer(value: f64) -> BigInt {
        let Parts { mantissa, exponent, is_negative } = parts(value);
        let magnitude = BigInt::from(mantissa) << (exponent + 1074);
        if is_negative { -magnitude } else { magnitude }
    }

    fn check<const N: usize, const WORDS: usize>(terms: &[[f64; N]]) {
        let mut sum = Sum::<WORDS>::new();
        let mut twin = BigInt::from(0);
        for (k, &term) in terms.iter().enumerate() {
            let product: BigInt = term.iter().map(|&c| integer(c)).product();
            if k % 3 == 2 {
                sum.add(term, Sign::Negative);
                twin -= product;
            } else {
                sum.add(term, Sign::Positive);
                twin += product;
            }
            assert_eq!(sum.compare(), twin.cmp(&BigInt::from(0)), "{terms:?}");
        }
        // Take all of it away again: what is left is zero, to the last bit.
        for (k, &term) in terms.iter().enumerate() {
            sum.add(term, if k % 3 == 2 { Sign::Positive } else { Sign::Negative });
        }
        assert_eq!(sum.sign(), Sign::Zero, "{terms:?}");
    }

    proptest! {
        #[test]
        fn sums_agree_with_big_integers(terms in prop::collection::vec([any_finite(),
            any_finite(), any_finite(), any_finite(), any_finite()], 1..12))
        {
            check::<2, DEGREE_2>(&terms.iter().map(|t| [t[0], t[1]]).collect::<Vec<_>>());
            check::<3, DEGREE_3>(&terms.iter().map(|t| [t[0], t[1], t[2]]).collect::<Vec<_>>());
            check::<4, DEGREE_4>(
                &terms.iter().map(|t| [t[0], t[1], t[2], t[3]]).collect::<Vec<_>>());
            check::<5, DEGREE_5>(&terms);
        }
    }

    /// Bits that are all ones, over many more words than one product has, and one more at the end.
    #[test]
    fn a_carry_runs_as_far_as_it_must() {
        let ones = (1u64 << 53) as f64 - 1.0;
        for (least, count) in [(-1000, 36), (-1000, 9), (0, 18)] {
            let mut sum = Sum::<DEGREE_2>::new();
            for k in 0..count {
                sum.add([ones, power_of_two(least + 53 * k)], Sign::Positive);
            }
            sum.add([1.0, power_of_two(least)], Sign::Positive);
            sum.add([1.0, power_of_two(least + 53 * count)], Sign::Negative);
            assert_eq!(sum.sign(), Sign::Zero, "{count} times 53 bits from 2^{least}");
        }
    }

    #[test]
    fn a_thousand_of_the_largest_products_fit() {
        check::<2, DEGREE_2>(&[[f64::MAX; 2]; 1000]);
        check::<3, DEGREE_3>(&[[f64::MAX; 3]; 1000]);
        check::<4, DEGREE_4>(&[[f64::MAX; 4]; 1000]);
        check::<5, DEGREE_5>(&[[f64::MAX; 5]; 1000]);
    }
}
