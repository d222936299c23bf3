//! Conversions from and to `nalgebra` (feature `nalgebra`): points, slices in, vectors out.
//!
//! ```
//! use ltbw_exact::PointSet;
//! use ltbw_exact::interop::{from_nalgebra, to_nalgebra};
//! use nalgebra::Point3;
//!
//! let cube: Vec<Point3<f64>> =
//!     (0..8).map(|i| Point3::new(i & 1, i >> 1 & 1, i >> 2).cast()).collect();
//! assert_eq!(PointSet::try_from(&cube[..])?.points().len(), 8);
//! assert_eq!(to_nalgebra(&from_nalgebra(&cube)), cube);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::Point;
use crate::points::{PointError, PointSet};
use nalgebra::Point3;

/// Points from `nalgebra`'s, bit for bit.
#[must_use]
pub fn from_nalgebra(points: &[Point3<f64>]) -> Vec<Point> {
    points.iter().map(|p| [p.x, p.y, p.z]).collect()
}

/// Points as `nalgebra`'s, bit for bit.
#[must_use]
pub fn to_nalgebra(points: &[Point]) -> Vec<Point3<f64>> {
    points.iter().map(|&p| Point3::from(p)).collect()
}

impl TryFrom<&[Point3<f64>]> for PointSet {
    type Error = PointError;

    /// Validates `nalgebra`'s points: [`PointSet::new`].
    fn try_from(points: &[Point3<f64>]) -> Result<Self, PointError> {
        Self::new(from_nalgebra(points))
    }
}
