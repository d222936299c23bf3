//! Validated point sets: the proof that the predicates' assumptions hold.
//!
//! The filters are proved for the *exactness window*: every coordinate is 0 or has
//! 2^-142 <= |c| < 2^200. Differences are then multiples of 2^-194 below 2^201, and no expression
//! of degree five underflows inexactly or overflows. A [`PointSet`] says how its points get there:
//!
//! * [`Mode::Normal`]: they are in the window as they are;
//! * [`Mode::Rescaled`]: they are after multiplication by one power of two, which is exact and
//!   changes no sign of a predicate;
//! * [`Mode::Wide`]: their exponents spread too far; the kernel uses the guarded predicates.
//!
//! Cost: one pass over the points; nothing is copied unless they are rescaled.

use std::borrow::Cow;

use crate::Point;
use crate::predicates::filter::power_of_two;

/// The most points a set may have: 2^28.
///
/// Tetrahedra (about 6.8 per point) and their faces (four each) have to be named by `u32`.
pub const MAX_POINTS: usize = 1 << 28;

/// Exponent of the smallest non-zero |coordinate| in the exactness window: 2^-142.
pub const WINDOW_LOW_EXPONENT: i32 = -142;

/// Exponent of the upper end of the exactness window: |coordinate| < 2^200.
pub const WINDOW_HIGH_EXPONENT: i32 = 200;

/// Why a list of points is not a point set.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PointError {
    /// A coordinate is NaN or infinite.
    #[error("point {index}: coordinate {axis} is {value}, which is not finite")]
    NotFinite {
        /// Index of the point in the input; 0 for a single point.
        index: usize,
        /// `x`, `y` or `z`.
        axis: char,
        /// The value found.
        value: f64,
    },
    /// More points than `u32` indices with their reserved values can name.
    #[error("{count} points exceed the limit of {limit}")]
    TooMany {
        /// Points given.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// A flat list whose length is no multiple of three, or an array whose rows have not three
    /// numbers.
    #[error("{count} numbers are no points of three coordinates each")]
    NotTriples {
        /// Numbers given, in all or in a row.
        count: usize,
    },
}

/// The way in which the coordinates of a point set get into the exactness window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Mode {
    /// They are in it.
    Normal,
    /// They are in it after multiplication by 2^exponent, which is exact.
    Rescaled {
        /// The exponent of the factor.
        exponent: i32,
    },
    /// No power of two brings them there: predicates for any coordinates have to be used.
    Wide,
}

impl Mode {
    /// Validates a point that comes later than the set: `-0.0` becomes `0.0`, and the answer is the
    /// point in the kernel's coordinates, or `None` if it does not lie in the window under the
    /// scale of the set (a built mesh is never rescaled: it has to become [`Mode::Wide`]).
    ///
    /// # Errors
    /// [`PointError::NotFinite`], with index 0.
    pub fn admit(self, point: Point) -> Result<Option<Point>, PointError> {
        let point = normalised(0, point)?;
        let scaled = self.to_kernel(point);
        // A point far outside may overflow, or lose bits to underflow, when scaled: neither is
        // in the window then, except that an underflow to zero would look like zero.
        let kept = (0..3).all(|k| (scaled[k] == 0.0) == (point[k] == 0.0));
        let inside = self == Self::Wide || (kept && scaled.iter().all(|&c| in_window(c)));
        Ok(inside.then_some(scaled))
    }

    /// A point of the set in the coordinates in which the kernel computes.
    #[inline]
    #[must_use]
    pub fn to_kernel(self, point: Point) -> Point {
        match self {
            Self::Normal | Self::Wide => point,
            Self::Rescaled { exponent } => point.map(|c| scale(c, exponent)),
        }
    }

    /// The inverse of [`Mode::to_kernel`], bit for bit.
    #[inline]
    #[must_use]
    pub fn from_kernel(self, point: Point) -> Point {
        match self {
            Self::Normal | Self::Wide => point,
            Self::Rescaled { exponent } => point.map(|c| scale(c, -exponent)),
        }
    }
}

/// Points that are finite, with `-0.0` normalised to `0.0`, and the [`Mode`] in which the
/// predicates are right for them.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSet {
    coords: Vec<Point>,
    mode: Mode,
}

impl PointSet {
    /// Validates `points`. Duplicates are allowed.
    ///
    /// # Errors
    /// [`PointError::NotFinite`] names the first coordinate that is NaN or infinite;
    /// [`PointError::TooMany`] if there are more than [`MAX_POINTS`].
    pub fn new(mut points: Vec<Point>) -> Result<Self, PointError> {
        check_count(points.len())?;
        let mode = Magnitudes::of(&mut points)?.mode();
        Ok(Self { coords: points, mode })
    }

    /// Validates points whose coordinates lie one after the other: x, y, z, x, y, z, ...
    ///
    /// # Errors
    /// As [`PointSet::new`], and [`PointError::NotTriples`].
    pub fn from_flat(coordinates: &[f64]) -> Result<Self, PointError> {
        let (points, rest) = coordinates.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(PointError::NotTriples { count: coordinates.len() });
        }
        Self::new(points.to_vec())
    }

    /// The points, in input order and input coordinates (with `-0.0` as `0.0`).
    #[inline]
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.coords
    }

    /// The number of points, duplicates included.
    #[inline]
    #[must_use]
    pub fn len(&self) -> usize {
        self.coords.len()
    }

    /// Are there no points?
    #[inline]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.coords.is_empty()
    }

    /// The way in which the coordinates get into the exactness window.
    #[inline]
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The points in the coordinates in which the kernel computes: times 2^exponent in rescaled
    /// mode (a copy), else the input's own.
    #[must_use]
    pub fn kernel_points(&self) -> Cow<'_, [Point]> {
        match self.mode {
            Mode::Normal | Mode::Wide => Cow::Borrowed(&self.coords),
            Mode::Rescaled { .. } => {
                Cow::Owned(self.coords.iter().map(|&p| self.mode.to_kernel(p)).collect())
            }
        }
    }

    /// One point in the coordinates in which the kernel computes; `None` past the end.
    #[inline]
    #[must_use]
    pub fn kernel_point(&self, index: usize) -> Option<Point> {
        self.coords.get(index).map(|&p| self.mode.to_kernel(p))
    }

    /// The input points, without a copy.
    #[must_use]
    pub fn into_points(self) -> Vec<Point> {
        self.coords
    }
}

/// Makes sure that a set may have so many points.
///
/// # Errors
/// [`PointError::TooMany`] if it may not.
pub fn check_count(count: usize) -> Result<(), PointError> {
    if count > MAX_POINTS {
        return Err(PointError::TooMany { count, limit: MAX_POINTS });
    }
    Ok(())
}

/// Finite, and `-0.0` replaced by `0.0`.
#[inline]
fn normalised(index: usize, point: Point) -> Result<Point, PointError> {
    for (axis, value) in ['x', 'y', 'z'].into_iter().zip(point) {
        if !value.is_finite() {
            return Err(PointError::NotFinite { index, axis, value });
        }
    }
    // In rounding to nearest, -0.0 + 0.0 is 0.0; nothing else changes.
    Ok(point.map(|c| c + 0.0))
}

/// Is a coordinate inside the exactness window?
#[inline]
fn in_window(coordinate: f64) -> bool {
    const LOW: f64 = power_of_two(WINDOW_LOW_EXPONENT);
    const HIGH: f64 = power_of_two(WINDOW_HIGH_EXPONENT);
    let magnitude = coordinate.abs();
    magnitude == 0.0 || (LOW..HIGH).contains(&magnitude)
}

/// The least and the largest magnitude of coordinates that are not zero. Those of all points are
/// the join of those of parts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Magnitudes {
    /// Infinite if there are none.
    least: f64,
    /// 0 if there are none.
    largest: f64,
}

impl Magnitudes {
    /// Those of no points.
    pub const NONE: Self = Self { least: f64::INFINITY, largest: 0.0 };

    /// Validates points, and replaces `-0.0` by `0.0`.
    ///
    /// # Errors
    /// [`PointError::NotFinite`] names the first coordinate that is NaN or infinite.
    pub fn of(points: &mut [Point]) -> Result<Self, PointError> {
        let mut range = Self::NONE;
        for (index, point) in points.iter_mut().enumerate() {
            *point = normalised(index, *point)?;
            for magnitude in point.map(f64::abs) {
                if magnitude > 0.0 {
                    range = range.join(Self { least: magnitude, largest: magnitude });
                }
            }
        }
        Ok(range)
    }

    /// Those of both.
    #[must_use]
    pub fn join(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), largest: self.largest.max(other.largest) }
    }

    /// The mode for coordinates in this range.
    #[must_use]
    pub fn mode(self) -> Mode {
        let Self { least, largest } = self;
        if least > largest || in_window(least) && in_window(largest) {
            return Mode::Normal;
        }
        let (low, high) = (exponent_of(least), exponent_of(largest));
        // Exponents inside the window run from -142 to 199: 342 of them.
        let slack = (WINDOW_HIGH_EXPONENT - 1 - WINDOW_LOW_EXPONENT) - (high - low);
        if slack < 0 {
            return Mode::Wide;
        }
        // In the middle of the window: later points have as much room below as above.
        Mode::Rescaled { exponent: WINDOW_LOW_EXPONENT + slack / 2 - low }
    }
}

/// floor(log2(magnitude)) for a positive finite number, subnormal ones included.
fn exponent_of(magnitude: f64) -> i32 {
    let bits = magnitude.to_bits();
    let field = (bits >> 52) as i32;
    if field > 0 {
        return field - 1023;
    }
    // Subnormal: bits · 2^-1074.
    63 - bits.leading_zeros() as i32 - 1074
}

/// value · 2^exponent for |exponent| <= 2044, exact if the result is normal, and if it is the
/// inverse of such a scaling.
///
/// Two steps because 2^exponent itself may not be an `f64`. Half-way, the magnitude is the
/// geometric mean of both ends: since one end is inside the window, it is never subnormal, and
/// the only rounding that could occur is that of the result.
fn scale(value: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    value * power_of_two(half) * power_of_two(exponent - half)
}

/// Whole numbers that ascend as the coordinates of a point do; `-0.0` is `0.0`.
#[inline]
#[must_use]
pub fn ascending(p: &Point) -> [u64; 3] {
    // In rounding to nearest, -0.0 + 0.0 is 0.0; nothing else changes.
    p.map(|c| match (c + 0.0).to_bits() {
        bits if bits & SIGN == 0 => bits | SIGN,
        bits => !bits,
    })
}

/// The point of such numbers.
#[inline]
#[must_use]
pub fn of_ascending(numbers: [u64; 3]) -> Point {
    numbers.map(|own| f64::from_bits(if own & SIGN == 0 { !own } else { own ^ SIGN }))
}

/// The sign of a number among its bits.
const SIGN: u64 = 1 << 63;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_ascend_as_coordinates_do_and_come_back() {
        let all = [f64::MIN, -1.5, -f64::MIN_POSITIVE, -5e-324, 0.0, 5e-324, 1.0, f64::MAX];
        let keys: Vec<[u64; 3]> = all.iter().map(|&c| ascending(&[c; 3])).collect();
        assert!(keys.is_sorted() && keys.windows(2).all(|pair| pair[0] != pair[1]));
        for (key, c) in keys.iter().zip(all) {
            assert_eq!(of_ascending(*key).map(f64::to_bits), [c.to_bits(); 3]);
        }
        assert_eq!(ascending(&[-0.0; 3]), ascending(&[0.0; 3]));
    }
    use proptest::prelude::*;

    #[test]
    fn magnitudes_of_parts_joined_are_those_of_all() {
        let all = vec![[0.0; 3], [1e-300, 2.0, -0.0], [1e300, 0.0, -3.0], [0.5, 0.25, 1e-310]];
        let of = |points: &[Point]| Magnitudes::of(&mut points.to_vec()).unwrap();
        for count in 0..all.len() {
            for cut in 0..=count {
                let joined = of(&all[..cut]).join(of(&all[cut..count]));
                assert_eq!(joined, of(&all[..count]));
                assert_eq!(joined.mode(), mode_of(&all[..count]));
            }
        }
        assert_eq!((of(&[]), Magnitudes::NONE.mode()), (Magnitudes::NONE, Mode::Normal));
        assert_eq!((of(&all).mode(), of(&all[..2]).mode() == Mode::Normal), (Mode::Wide, false));
    }

    fn bits(points: &[Point]) -> Vec<[u64; 3]> {
        points.iter().map(|p| p.map(f64::to_bits)).collect()
    }

    fn mode_of(points: &[Point]) -> Mode {
        PointSet::new(points.to_vec()).expect("finite").mode()
    }

    /// 2^exponent, subnormal ones included.
    fn power(exponent: i32) -> f64 {
        let half = exponent / 2;
        power_of_two(half) * power_of_two(exponent - half)
    }

    #[test]
    fn values_that_are_not_finite_are_named() {
        for (axis, name) in [(0, 'x'), (1, 'y'), (2, 'z')] {
            for value in [f64::INFINITY, f64::NEG_INFINITY] {
                let mut points = vec![[0.0, 1.0, 2.0]; 5];
                points[3][axis] = value;
                points[4] = [f64::NAN; 3];
                let error = PointSet::new(points).expect_err("not finite");
                assert_eq!(error, PointError::NotFinite { index: 3, axis: name, value });
            }
        }
        let error = PointSet::new(vec![[0.0, f64::NAN, 0.0]]).expect_err("NaN");
        assert_eq!(error.to_string(), "point 0: coordinate y is NaN, which is not finite");
    }

    #[test]
    fn flat_lists_are_triples() {
        let set = PointSet::from_flat(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).expect("two points");
        assert_eq!(set.points(), [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
        let error = PointSet::from_flat(&[0.0; 4]).expect_err("four numbers");
        assert_eq!(error, PointError::NotTriples { count: 4 });
        assert!(PointSet::from_flat(&[]).expect("no points").is_empty());
    }

    #[test]
    fn too_many_points_are_refused() {
        assert_eq!(check_count(MAX_POINTS), Ok(()));
        let error = PointError::TooMany { count: MAX_POINTS + 1, limit: MAX_POINTS };
        assert_eq!(check_count(MAX_POINTS + 1), Err(error));
    }

    #[test]
    fn minus_zero_becomes_zero() {
        let set = PointSet::new(vec![[-0.0, 1.0, -0.0]]).expect("finite");
        assert_eq!(bits(set.points()), bits(&[[0.0, 1.0, 0.0]]));
        let admitted = set.mode().admit([-0.0; 3]).expect("finite").expect("in the window");
        assert_eq!(bits(&[admitted]), bits(&[[0.0; 3]]));
    }

    #[test]
    fn the_window_has_these_ends() {
        let (low, high) = (power(-142), power(200));
        let below = |x: f64| f64::from_bits(x.to_bits() - 1);
        assert_eq!(mode_of(&[]), Mode::Normal);
        assert_eq!(mode_of(&[[0.0; 3]]), Mode::Normal);
        assert_eq!(mode_of(&[[low, -below(high), 0.0]]), Mode::Normal);
        // One step beyond either end: the range is one exponent too wide.
        assert_eq!(mode_of(&[[low, high, 0.0]]), Mode::Wide);
        assert_eq!(mode_of(&[[below(low), -below(high), 0.0]]), Mode::Wide);
        assert!(matches!(mode_of(&[[below(low), 1.0, 0.0]]), Mode::Rescaled { .. }));
        assert!(matches!(mode_of(&[[1.0, -high, 0.0]]), Mode::Rescaled { .. }));
        assert_eq!(mode_of(&[[f64::from_bits(1), f64::MAX, 0.0]]), Mode::Wide);
    }

    #[test]
    fn every_range_that_fits_is_rescaled() {
        for low in (-1074..=682).step_by(7) {
            let widest = [power(low), power(low + 341) * 1.75, 0.0];
            let set = PointSet::new(vec![widest]).expect("finite");
            if low == -142 {
                assert_eq!(set.mode(), Mode::Normal);
            } else {
                assert_eq!(set.mode(), Mode::Rescaled { exponent: -142 - low });
            }
            assert!(set.kernel_points()[0].iter().all(|&c| in_window(c)));
            assert_eq!(mode_of(&[[power(low), power(low + 342), 0.0]]), Mode::Wide);
        }
    }

    #[test]
    fn normal_sets_are_not_copied() {
        let set = PointSet::new(vec![[1.0, 2.0, 3.0]]).expect("finite");
        assert!(matches!(set.kernel_points(), Cow::Borrowed(_)));
        assert_eq!(set.kernel_point(0), Some([1.0, 2.0, 3.0]));
        assert_eq!(set.kernel_point(1), None);
        assert_eq!((set.len(), set.is_empty()), (1, false));
    }

    #[test]
    fn later_points_are_admitted_under_the_same_scale() {
        let mode = mode_of(&[[power(-700), 0.0, 0.0]]);
        let Mode::Rescaled { exponent } = mode else { panic!("{mode:?}") };
        assert_eq!(exponent, 728);
        let admit = |c: f64| mode.admit([c, 0.0, 0.0]).expect("finite");
        assert_eq!(admit(power(-700)), Some([power(28), 0.0, 0.0]));
        assert_eq!(admit(power(-700 - 170)), Some([power(-142), 0.0, 0.0]));
        assert_eq!(admit(power(-700 - 171)), None);
        assert_eq!(admit(power(-700 + 171)), Some([power(199), 0.0, 0.0]));
        assert_eq!(admit(power(-700 + 172)), None);
        assert_eq!(admit(1.0), None);
        assert_eq!(admit(f64::MAX), None);
        // Under a scale that shrinks, small values underflow to zero: they are not zero.
        let shrinking = mode_of(&[[power(1000), 0.0, 0.0]]);
        assert_eq!(shrinking.admit([f64::from_bits(1), 0.0, 0.0]), Ok(None));
        assert_eq!(Mode::Normal.admit([power(200), 0.0, 0.0]), Ok(None));
        let far = [power(200), f64::from_bits(1), f64::MAX];
        assert_eq!(Mode::Wide.admit(far), Ok(Some(far)));
        let error = PointError::NotFinite { index: 0, axis: 'z', value: f64::INFINITY };
        for mode in [Mode::Normal, mode, Mode::Wide] {
            assert_eq!(mode.admit([0.0, 0.0, f64::INFINITY]), Err(error.clone()));
        }
    }

    /// Coordinates of exponents from `low` on, over the whole range that can be rescaled.
    fn coordinates(low: i32) -> impl Strategy<Value = f64> {
        prop_oneof![
            1 => Just(0.0),
            9 => (1.0..2.0, low..=(low + 341).min(1023), any::<bool>()).prop_map(
                |(mantissa, exponent, negative): (f64, i32, bool)| {
                    let half = exponent / 2;
                    let value = mantissa * power_of_two(half) * power_of_two(exponent - half);
                    if negative { -value } else { value }
                }
            ),
        ]
    }

    proptest! {
        #[test]
        fn there_and_back_gives_identical_bits(
            points in (-1074..=682_i32)
                .prop_flat_map(|low| prop::collection::vec(
                    [coordinates(low), coordinates(low), coordinates(low)], 1..20)),
        ) {
            let set = PointSet::new(points.clone()).expect("finite");
            prop_assert_eq!(bits(set.points()), bits(&points.iter()
                .map(|p| p.map(|c| c + 0.0)).collect::<Vec<_>>()));
            prop_assert_ne!(set.mode(), Mode::Wide);
            let kernel = set.kernel_points();
            prop_assert!(kernel.iter().flatten().all(|&c| in_window(c)));
            let back: Vec<Point> = kernel.iter().map(|&p| set.mode().from_kernel(p)).collect();
            prop_assert_eq!(bits(&back), bits(set.points()));
            for (i, &p) in points.iter().enumerate() {
                prop_assert_eq!(set.kernel_point(i), Some(kernel[i]));
                prop_assert_eq!(set.mode().admit(p), Ok(Some(kernel[i])));
            }
        }
    }
}
