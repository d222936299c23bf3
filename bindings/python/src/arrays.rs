//! Arrays of rows, to and from numpy: one copy on the way in, none on the way out.
//!
//! Arrays of a mesh are read-only: they are kept, and everybody who asks gets the same one.

use crate::failure::Failure;
use ltbw::Point;
use ltbw_bindings::Class;
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

/// Coordinates as numpy has them: float64, C order, of shape (n, 3).
pub(crate) type Coordinates<'py> = PyReadonlyArray2<'py, f64>;

/// The points of an array.
pub(crate) fn points(array: &Coordinates<'_>) -> Result<Vec<Point>, Failure> {
    let flat = array.as_slice();
    let flat = flat.map_err(|e| Failure::new(Class::Input, "points.layout", e))?;
    let (rows, rest) = flat.as_chunks::<3>();
    match rest {
        [] => Ok(rows.to_vec()),
        _ => Err(Failure::new(Class::Input, "points.shape", "coordinates come in threes")),
    }
}

/// Numbers as a read-only array, without a copy. So are its views: numpy lets nobody make what
/// another owns writeable.
pub(crate) fn line<T: Element>(py: Python<'_>, numbers: Vec<T>) -> Bound<'_, PyArray1<T>> {
    let array = numbers.into_pyarray(py);
    array.readwrite().make_nonwriteable();
    array
}

/// Rows of indices as a read-only array of int32, without a copy; indices of points are below 2^28,
/// those of tetrahedra below 2^30.
pub(crate) fn rows<'py, const N: usize>(
    py: Python<'py>,
    rows: Vec<[u32; N]>,
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let count = rows.len();
    let flat: Vec<i32> = bytemuck::cast_vec(rows.into_flattened());
    line(py, flat).reshape([count, N])
}

/// Points as a read-only array of float64, without a copy.
pub(crate) fn coordinates<'py>(
    py: Python<'py>,
    points: Vec<Point>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let count = points.len();
    line(py, points.into_flattened()).reshape([count, 3])
}
