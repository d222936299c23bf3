//! Differences of points to one base point, as exact as each stage needs them.

use super::super::filter::power_of_two;
use crate::Point;

/// Bits of the integers of [`Differences::small`].
const SMALL_BITS: i32 = 62;
/// Bits of the integers of [`Differences::medium`].
const MEDIUM_BITS: i32 = 124;

/// The differences of N points to a base point: `high + low` exactly, `high` rounded to nearest
/// (Knuth's two-sum, exact with gradual underflow), unless a difference overflows, which leaves
/// infinities and NaN in both: then no stage applies.
pub(super) struct Differences<const N: usize> {
    high: [Point; N],
    low: [Point; N],
    /// The largest |high|; NaN or infinite after overflow.
    largest: f64,
    /// Are all `low` zero?
    rounded_nothing: bool,
}

impl<const N: usize> Differences<N> {
    #[inline(always)]
    pub(super) fn new(points: [&Point; N], base: &Point) -> Self {
        let mut high = [[0.0; 3]; N];
        let mut low = [[0.0; 3]; N];
        for i in 0..N {
            for k in 0..3 {
                (high[i][k], low[i][k]) = two_difference(points[i][k], base[k]);
            }
        }
        let mut largest = 0.0;
        for &h in high.as_flattened() {
            largest = if h.abs() > largest { h.abs() } else { largest };
        }
        let mut rounded_nothing = true;
        for &l in low.as_flattened() {
            rounded_nothing &= l == 0.0;
        }
        Self { high, low, largest, rounded_nothing }
    }

    /// The exponent E with |difference| < 2^(E + 1), if scaling by powers of two near 2^-E is one
    /// multiplication by a normal number. Rounding is monotone: the bound on `high` holds for the
    /// exact difference.
    #[inline(always)]
    fn plain_exponent(&self) -> Option<i32> {
        let exponent = (self.largest.to_bits() >> 52) as i32 - 1023;
        if (-900..=900).contains(&exponent) { Some(exponent) } else { None }
    }

    /// Integers of at most BITS bits (and a sign) proportional to the differences, held in `f64`;
    /// `None` if there are none, or if a difference was rounded.
    #[inline(always)]
    pub(super) fn few_bits<const BITS: i32>(&self) -> Option<[Point; N]> {
        if !self.rounded_nothing {
            return None;
        }
        let exponent = self.plain_exponent()?;
        // |high| < 2^(exponent + 1) = 2^BITS units.
        let scale = power_of_two(BITS - 1 - exponent);
        let unit = power_of_two(exponent + 1 - BITS);
        // Adding 1.5 · 2^52 rounds to an integer. It came from `high` exactly if it gives `high`
        // back; comparing there also catches a `high` that underflowed when scaled.
        let magic = 1.5 * power_of_two(52);
        let mut integers = [[0.0; 3]; N];
        let mut exact = true;
        for (to, &h) in integers.as_flattened_mut().iter_mut().zip(self.high.as_flattened()) {
            *to = (h * scale + magic) - magic;
            exact &= *to * unit == h;
        }
        exact.then_some(integers)
    }

    /// Integers below 2^62 proportional to the differences; `None` if there are none.
    #[inline(always)]
    pub(super) fn small(&self) -> Option<[[i64; 3]; N]> {
        let exponent = self.plain_exponent()?;
        let scale = power_of_two(SMALL_BITS - 1 - exponent);
        let unit = power_of_two(exponent + 1 - SMALL_BITS);
        let mut integers = [[0_i64; 3]; N];
        let mut exact = true;
        let parts = self.high.as_flattened().iter().zip(self.low.as_flattened());
        for (to, (&h, &l)) in integers.as_flattened_mut().iter_mut().zip(parts) {
            // |h|, |l| < 2^(exponent + 1) = 2^62 units. Each came out exactly if it gives the
            // part back; comparing there also catches a part that underflowed when scaled.
            let (hi, lo) = ((h * scale) as i64, (l * scale) as i64);
            exact &= hi as f64 * unit == h && lo as f64 * unit == l;
            *to = hi.wrapping_add(lo);
        }
        exact.then_some(integers)
    }

    /// Integers below 2^124 proportional to the differences; `None` if there are none.
    #[inline(never)]
    pub(super) fn medium(&self) -> Option<[[i128; 3]; N]> {
        if !self.largest.is_finite() {
            return None;
        }
        let field = ((self.largest.to_bits() >> 52) as i32).max(1);
        // |difference| < 2^(field - 1022).
        let unit = field - 1022 - MEDIUM_BITS;
        let mut integers = [[0_i128; 3]; N];
        let parts = self.high.as_flattened().iter().zip(self.low.as_flattened());
        for (to, (&h, &l)) in integers.as_flattened_mut().iter_mut().zip(parts) {
            *to = in_units(h, unit)? + in_units(l, unit)?;
        }
        Some(integers)
    }
}

/// a - b as a rounded difference and its error.
#[inline(always)]
fn two_difference(a: f64, b: f64) -> (f64, f64) {
    let high = a - b;
    let b_virtual = a - high;
    let a_virtual = high + b_virtual;
    (high, (a - a_virtual) + (b_virtual - b))
}

/// `value` / 2^unit if it is an integer. The caller knows that it is below 2^124.
#[inline(always)]
fn in_units(value: f64, unit: i32) -> Option<i128> {
    if value == 0.0 {
        return Some(0);
    }
    let bits = value.to_bits();
    let field = ((bits >> 52) & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let (mantissa, exponent) = match field {
        0x7ff => return None,
        0 => (fraction, -1074),
        _ => (fraction | 1 << 52, field - 1075),
    };
    // Dropping the zeros below the mantissa leaves a shift to the left or no integer.
    let zeros = mantissa.trailing_zeros();
    let shift = exponent + zeros as i32 - unit;
    if !(0..MEDIUM_BITS).contains(&shift) {
        return None;
    }
    let magnitude = i128::from(mantissa >> zeros) << shift;
    Some(if value.is_sign_negative() { -magnitude } else { magnitude })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn differences(points: [Point; 4], base: Point) -> Differences<4> {
        Differences::new(points.each_ref(), &base)
    }

    /// Four corners of a cube against another, with edges `edge` at `corner`.
    fn cube(corner: f64, edge: f64) -> Differences<4> {
        let [x, y] = [corner, corner + edge];
        differences([[x, x, x], [y, x, x], [x, y, x], [x, x, y]], [y, y, y])
    }

    #[test]
    fn lattices_have_few_bits() {
        let few = cube(100.0, 3.0).few_bits::<9>().expect("differences of two bits");
        assert_eq!(
            few,
            [[-384.0; 3], [0.0, -384.0, -384.0], [-384.0, 0.0, -384.0], [-384.0, -384.0, 0.0]]
        );
    }

    #[test]
    fn few_bits_count() {
        let with = |c: f64| differences([[c, 1.0, 0.0]; 4], [0.0; 3]);
        assert!(with(511.0).few_bits::<9>().is_some());
        assert!(with(513.0).few_bits::<9>().is_none());
        assert!(with(513.0).few_bits::<16>().is_some());
        assert!(with(65535.0).few_bits::<16>().is_some());
        assert!(with(65537.0).few_bits::<16>().is_none());
    }

    #[test]
    fn small_integers_are_exact_where_differences_round() {
        // 1 + 2^-52 and 2^-60: the difference has 61 bits.
        let tiny = power_of_two(-60);
        let found = differences([[1.0 + f64::EPSILON, 0.0, 0.0]; 4], [tiny, 0.0, 0.0]);
        assert!(!found.rounded_nothing && found.few_bits::<16>().is_none());
        let small = found.small().expect("61 bits");
        // `high` rounds up to 1 + 2^-52 in [2^0, 2^1): the unit is 2^(1-62).
        let expected = (1_i64 << 61) + (1 << 9) - 2;
        assert_eq!(small[0], [expected, 0, 0]);
        // Two bits more do not fit, but the next stage takes them.
        let found = differences([[1.0, 0.0, 0.0]; 4], [power_of_two(-63), 0.0, 0.0]);
        assert!(found.small().is_none());
        let medium = found.medium().expect("63 bits");
        assert_eq!(medium[0][0], (1 << 123) - (1 << 60));
    }

    #[test]
    fn small_integers_do_not_depend_on_the_unit() {
        let tiny = power_of_two(-60);
        let at = |unit: f64| {
            differences([[unit + unit * f64::EPSILON, 0.0, unit]; 4], [unit * tiny, 0.0, 0.0])
        };
        let expected = at(1.0).small();
        assert!(expected.is_some());
        for exponent in [-900, -100, -1, 1, 100, 900] {
            assert_eq!(at(power_of_two(exponent)).small(), expected, "2^{exponent}");
        }
        for exponent in [-901, 901] {
            assert_eq!(at(power_of_two(exponent)).small(), None, "2^{exponent}");
        }
    }

    #[test]
    fn no_integer_is_infinite_or_not_a_number() {
        for value in [f64::INFINITY, -f64::INFINITY, f64::NAN] {
            assert_eq!(in_units(value, 900), None);
        }
        assert_eq!(in_units(-power_of_two(1023), 900), Some(-(1 << 123)));
    }

    #[test]
    fn a_value_that_underflows_when_scaled_is_not_zero() {
        let least = f64::from_bits(1);
        let found = differences([[power_of_two(200), least, 0.0]; 4], [0.0; 3]);
        assert!(found.few_bits::<16>().is_none());
        assert!(found.small().is_none());
        assert!(found.medium().is_none());
    }

    #[test]
    fn overflow_leaves_every_stage_out() {
        let found = differences([[f64::MAX, 0.0, 0.0]; 4], [-f64::MAX, 0.0, 0.0]);
        assert!(found.few_bits::<9>().is_none());
        assert!(found.small().is_none());
        assert!(found.medium().is_none());
    }

    #[test]
    fn subnormals_reach_the_medium_stage() {
        let found = differences([[f64::from_bits(5), 0.0, 0.0]; 4], [f64::from_bits(2), 0.0, 0.0]);
        let medium = found.medium().expect("two bits");
        assert!(medium[0][0] > 0 && medium[0][0] % 3 == 0 && medium[0][1] == 0);
    }
}
