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

/// Makes sure that a set may have this number of points.
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

/// The least and the largest magnitude of coordinates that are not zero. Magnitudes of all points
/// are the join of those of parts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Magnitudes {
    /// Infinite if there are none.
    least: f64,
    /// 0 if there are none.
    largest: f64,
}

impl Magnitudes {
    /// The magnitudes of no points.
    pub const NONE: Self = Self { least: f64::INFINITY, largest: 0.0 };

    /// Validates points, and replaces `-0.0` by `0.0`.
    ///
    /// # Errors
    /// [`PointError::NotFinite`] names the first coordinate that is NaN or infinite.
    pub fn of(points: &mut [Point]) -> Result<Self, PointError> {
        let mut range = Self::NONE;
        for (index, point) in points.iter_mut().enumerate() {
            *point = normalised(index, *point)?;
            for magnitude in point.map(f64::abs).into_iter().filter(|&own| own > 0.0) {
                range = range.join(Self { least: magnitude, largest: magnitude });
            }
        }
        Ok(range)
    }

    /// The magnitudes of both.
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
mod tests;
