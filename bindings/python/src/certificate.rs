//! Certificates of anybody's meshes.

use crate::arrays::{Coordinates, points};
use crate::domain::{Asked, Given};
use crate::failure::Failure;
use crate::kernel::measures;
use crate::supervise::supervised;
use ltbw_bindings::{CheckedMesh, Class, Order, Ready, Reins, in_own_pool};
use numpy::{Element, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::fmt::Display;

/// Tetrahedra as numpy has them, of shape (m, 4): int32 as ours are, or int64.
#[derive(FromPyObject)]
pub(crate) enum Corners<'py> {
    Narrow(PyReadonlyArray2<'py, i32>),
    Wide(PyReadonlyArray2<'py, i64>),
}

impl Corners<'_> {
    /// The corners of the tetrahedra.
    fn rows(&self) -> Result<Vec<[u32; 4]>, Failure> {
        match self {
            Self::Narrow(array) => rows(array),
            Self::Wide(array) => rows(array),
        }
    }
}

fn rows<T: Element + Copy + Display + TryInto<u32>>(
    array: &PyReadonlyArray2<'_, T>,
) -> Result<Vec<[u32; 4]>, Failure> {
    let flat = array.as_slice().map_err(|e| Failure::new(Class::Input, "tets.layout", e))?;
    let (rows, _) = flat.as_chunks::<4>();
    let named = |(t, row): (u32, &[T; 4])| {
        let mut corners = [0; 4];
        for (corner, &v) in corners.iter_mut().zip(row) {
            *corner = v.try_into().map_err(|_| {
                let text = format!("tetrahedron {t} names point {v}");
                Failure::from(
                    ltbw_bindings::Failure::new(Class::Input, "tets.index", text).with([t]),
                )
            })?;
        }
        Ok(corners)
    };
    (0..).zip(rows).map(named).collect()
}

/// Checks a mesh as one of finite elements, and whether it is Delaunay; JSON `ltbw.cert/1`, and its
/// quality.
#[pyfunction]
pub(crate) fn check<'py>(
    py: Python<'py>,
    coordinates: Coordinates<'py>,
    simplices: Corners<'py>,
    any_order: bool,
    all_points: bool,
    delaunay: bool,
) -> PyResult<(String, Option<Bound<'py, PyDict>>)> {
    let (points, tets) = (points(&coordinates)?, simplices.rows()?);
    let order = if any_order { Order::Any } else { Order::Oriented };
    let check =
        move |_: &Reins| Ok(ltbw_bindings::check(&points, &tets, order, all_points, delaunay)?);
    let CheckedMesh { certificate, quality } = supervised(py, None, check)?;
    Ok((certificate, quality.map(|quality| measures(py, &quality)).transpose()?))
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
    let (points, tets) = (points(&coordinates)?, simplices.rows()?);
    let order = if any_order { Order::Any } else { Order::Oriented };
    let (source, wishes) = (given.source()?, asked.wishes());
    let checked = supervised(py, None, move |_| {
        in_own_pool(|| {
            let ready = Ready::new(source, &wishes)?;
            Ok(ready.check(&points, &tets, order, &wishes))
        })
    })?;
    Ok(checked.certificate)
}
