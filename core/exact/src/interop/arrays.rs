//! Conversions from and to arrays of `ndarray` (feature `ndarray`), a row for each point.
//!
//! ```
//! use ltbw_exact::PointSet;
//! use ltbw_exact::interop::to_ndarray;
//! use ndarray::{Array2, s};
//!
//! let all = Array2::from_shape_fn((8, 4), |(i, k)| (i >> k & 1) as f64);
//! let set = PointSet::try_from(all.slice(s![.., 0..3]))?;
//! assert_eq!(set.points()[6], [0.0, 1.0, 1.0]);
//! assert_eq!(to_ndarray(set.points().to_vec()), all.slice(s![.., 0..3]));
//! assert!(PointSet::try_from(all.view()).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::Point;
use crate::points::{PointError, PointSet};
use ndarray::{Array2, ArrayView2};

/// Points from the rows of an array of shape (n, 3), in any layout, bit for bit.
///
/// # Errors
/// [`PointError::NotTriples`] if the rows do not have three columns.
pub fn from_ndarray(array: ArrayView2<'_, f64>) -> Result<Vec<Point>, PointError> {
    if array.ncols() != 3 {
        return Err(PointError::NotTriples { count: array.ncols() });
    }
    Ok(array.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect())
}

/// The array with a row for each of `rows`: points, corners of tetrahedra. Nothing is copied.
#[must_use]
pub fn to_ndarray<T, const N: usize>(rows: Vec<[T; N]>) -> Array2<T> {
    Array2::from(rows)
}

impl TryFrom<ArrayView2<'_, f64>> for PointSet {
    type Error = PointError;

    /// Validates the rows of an array of shape (n, 3): [`PointSet::new`].
    fn try_from(array: ArrayView2<'_, f64>) -> Result<Self, PointError> {
        Self::new(from_ndarray(array)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Axis, ShapeBuilder, Slice};

    #[test]
    fn any_layout_is_read_by_rows() {
        let at = |(i, k): (usize, usize)| (10 * i + k) as f64;
        let expected: Vec<Point> = (0..5).map(|i| [0, 1, 2].map(|k| at((i, k)))).collect();
        let plain = Array2::from_shape_fn((5, 3), at);
        let fortran = Array2::from_shape_fn((5, 3).f(), at);
        let wide = Array2::from_shape_fn((10, 7), |(i, k)| at((i / 2, k)));
        let turned = Array2::from_shape_fn((3, 5), |(k, i)| at((i, k)));
        let mut part = wide.view();
        part.slice_axis_inplace(Axis(0), Slice::from(..).step_by(2));
        part.slice_axis_inplace(Axis(1), Slice::from(..3));
        for view in [plain.view(), fortran.view(), part, turned.t()] {
            assert_eq!(from_ndarray(view).expect("points"), expected);
            assert_eq!(PointSet::try_from(view).expect("a set").points(), expected);
        }
        let mut back = plain.view();
        back.invert_axis(Axis(0));
        let reversed: Vec<Point> = expected.iter().rev().copied().collect();
        assert_eq!(from_ndarray(back).expect("points"), reversed);
        assert_eq!(to_ndarray(expected), plain);
    }

    #[test]
    fn other_shapes_and_values_are_refused() {
        for columns in [0, 2, 4] {
            let error = PointSet::try_from(Array2::zeros((6, columns)).view()).expect_err("rows");
            assert_eq!(error, PointError::NotTriples { count: columns });
        }
        assert!(PointSet::try_from(Array2::zeros((0, 3)).view()).expect("none").is_empty());
        let mut array = Array2::zeros((4, 3));
        array[[2, 1]] = f64::NAN;
        let error = PointSet::try_from(array.view()).expect_err("not a number");
        assert!(matches!(error, PointError::NotFinite { index: 2, axis: 'y', .. }), "{error}");
    }
}
