//! Validated point sets.

use crate::Point;

/// Why a list of points is not a point set.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PointError {
    /// A coordinate is NaN or infinite.
    #[error("point {index}: coordinate {axis} is {value}, which is not finite")]
    NotFinite {
        /// Index of the point in the input.
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
}

/// Points that are finite, with `-0.0` normalised to `0.0`.
#[derive(Debug, Clone)]
pub struct PointSet {
    coords: Vec<Point>,
}

impl PointSet {
    /// Validates `points`.
    pub fn new(points: Vec<Point>) -> Result<Self, PointError> {
        Ok(Self { coords: points })
    }

    /// The points, in input order and input coordinates (with `-0.0` as `0.0`).
    pub fn points(&self) -> &[Point] {
        &self.coords
    }
}
