//! Certificates and hashes of anybody's meshes.

use crate::arrays::{Coordinates, points};
use crate::domain::{Asked, Given};
use crate::failure::Failure;
use crate::supervise::supervised;
use ltbw_bindings::{Class, Order, Ready};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

/// Tetrahedra as numpy has them: int64, of shape (m, 4).
type Corners<'py> = PyReadonlyArray2<'py, i64>;

/// The corners of tetrahedra; an index that no u32 holds becomes one that names no point.
fn tets(array: &Corners<'_>) -> Result<Vec<[u32; 4]>, Failure> {
    let flat = array.as_slice().map_err(|e| Failure::new(Class::Input, "tets.layout", e))?;
    let (rows, _) = flat.as_chunks::<4>();
    Ok(rows.iter().map(|row| row.map(|v| u32::try_from(v).unwrap_or(u32::MAX))).collect())
}

/// Checks a mesh against everything that makes it a Delaunay mesh; JSON `ltbw.cert/1`.
#[pyfunction]
pub(crate) fn check(
    py: Python<'_>,
    coordinates: Coordinates<'_>,
    simplices: Corners<'_>,
    any_order: bool,
    all_points: bool,
) -> PyResult<String> {
    let (points, tets) = (points(&coordinates)?, tets(&simplices)?);
    let order = if any_order { Order::Any } else { Order::Oriented };
    let checked =
        supervised(py, None, |_| Ok(ltbw_bindings::check(&points, &tets, order, all_points)?))?;
    Ok(checked.1)
}

/// Checks a mesh of a domain, without exterior; JSON `ltbw.conformity/1`.
#[pyfunction]
pub(crate) fn check_domain(
    py: Python<'_>,
    coordinates: Coordinates<'_>,
    simplices: Corners<'_>,
    any_order: bool,
    given: Given<'_>,
    asked: Asked,
) -> PyResult<String> {
    let (points, tets) = (points(&coordinates)?, tets(&simplices)?);
    let order = if any_order { Order::Any } else { Order::Oriented };
    let (source, wishes) = (given.source()?, asked.wishes());
    let checked = supervised(py, None, |_| {
        let ready = Ready::new(source, &wishes)?;
        Ok(ready.check(&points, &tets, order, &wishes))
    })?;
    Ok(checked.1)
}

/// The canonical hash `ltbw.mesh/1`.
#[pyfunction]
pub(crate) fn mesh_hash(
    py: Python<'_>,
    coordinates: Coordinates<'_>,
    simplices: Corners<'_>,
) -> PyResult<String> {
    let (points, tets) = (points(&coordinates)?, tets(&simplices)?);
    Ok(supervised(py, None, |_| Ok(ltbw_bindings::hash(&points, &tets)?))?)
}
