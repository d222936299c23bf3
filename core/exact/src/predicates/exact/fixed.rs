//! Signed integers of fixed width on the stack.

use super::super::Sign;

/// A signed integer of N 64-bit limbs, two's complement, least significant limb first.
///
/// Operations wrap; each use says why its values fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Int<const N: usize>([u64; N]);

impl Int<1> {
    #[inline(always)]
    pub(super) fn from_i64(value: i64) -> Self {
        Self([value as u64])
    }
}

impl Int<2> {
    #[inline(always)]
    pub(super) fn from_i128(value: i128) -> Self {
        Self([value as u64, (value >> 64) as u64])
    }
}

impl<const N: usize> Int<N> {
    #[inline(always)]
    pub(super) fn add(&self, other: &Self) -> Self {
        let mut sum = self.0;
        let mut carry = false;
        for (limb, &addend) in sum.iter_mut().zip(&other.0) {
            (*limb, carry) = limb.carrying_add(addend, carry);
        }
        Self(sum)
    }

    #[inline(always)]
    pub(super) fn sub(&self, other: &Self) -> Self {
        let mut difference = self.0;
        subtract_if(true, &mut difference, &other.0);
        Self(difference)
    }

    /// The full product: R = N + M limbs hold every value.
    #[inline(always)]
    pub(super) fn mul<const M: usize, const R: usize>(&self, other: &Int<M>) -> Int<R> {
        const { assert!(R == N + M) };
        let mut product = [0_u64; R];
        for i in 0..N {
            let mut carry = 0;
            for j in 0..M {
                (product[i + j], carry) =
                    self.0[i].carrying_mul_add(other.0[j], product[i + j], carry);
            }
            product[i + M] = carry;
        }
        // The limbs of a negative number stand for 2^(64·width) more than its value:
        // the other factor has to be taken off again at that height.
        subtract_if(self.is_negative(), &mut product[N..], &other.0);
        subtract_if(other.is_negative(), &mut product[M..], &self.0);
        Int(product)
    }

    #[inline(always)]
    fn is_negative(&self) -> bool {
        self.0.last().is_some_and(|&top| (top as i64) < 0)
    }

    #[inline(always)]
    pub(super) fn sign(&self) -> Sign {
        if self.is_negative() {
            Sign::Negative
        } else if self.0.iter().all(|&limb| limb == 0) {
            Sign::Zero
        } else {
            Sign::Positive
        }
    }
}

#[cfg(test)]
pub(super) fn big<const N: usize>(value: &Int<N>) -> num_bigint::BigInt {
    let bytes: Vec<u8> = value.0.iter().flat_map(|limb| limb.to_le_bytes()).collect();
    num_bigint::BigInt::from_signed_bytes_le(&bytes)
}

/// `from -= what` if `condition`, without a branch; both have the same length.
#[inline(always)]
fn subtract_if(condition: bool, from: &mut [u64], what: &[u64]) {
    let mask = u64::from(condition).wrapping_neg();
    let mut borrow = false;
    for (limb, &w) in from.iter_mut().zip(what) {
        (*limb, borrow) = limb.borrowing_sub(w & mask, borrow);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    /// Limbs that are often all zeros or all ones, where carries and signs go wrong.
    fn limb() -> impl Strategy<Value = u64> {
        prop_oneof![any::<u64>(), Just(0), Just(u64::MAX), Just(1 << 63), Just(1)]
    }

    proptest! {
        #[test]
        fn products_equal_big_integers(
            a in [limb(), limb(), limb()],
            b in [limb(), limb()],
        ) {
            let (a, b) = (Int(a), Int(b));
            let product: Int<5> = a.mul(&b);
            prop_assert_eq!(big(&product), big(&a) * big(&b));
            let swapped: Int<5> = b.mul(&a);
            prop_assert_eq!(product, swapped);
        }

        #[test]
        fn sums_and_differences_wrap(
            a in [limb(), limb(), limb()],
            b in [limb(), limb(), limb()],
        ) {
            let modulus = BigInt::from(1) << 192;
            let (a, b) = (Int(a), Int(b));
            let wrapped = |x: BigInt| ((x % &modulus) + &modulus) % &modulus;
            prop_assert_eq!(wrapped(big(&a.add(&b))), wrapped(big(&a) + big(&b)));
            prop_assert_eq!(wrapped(big(&a.sub(&b))), wrapped(big(&a) - big(&b)));
        }

        #[test]
        fn signs_equal_big_integers(a in [limb(), limb()]) {
            let a = Int(a);
            let expected = Sign::from_ordering(big(&a).cmp(&BigInt::from(0)));
            prop_assert_eq!(a.sign(), expected);
        }
    }
}
