//! Meshes that are arrays alone, as pickle leaves them.

use crate::arrays::{Coordinates, points};
use crate::failure::Failure;
use crate::supervise::supervised;
use ltbw::io::GroupName;
use ltbw::{BoundaryFace, TetMesh};
use ltbw_bindings::{Class, Reins};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;

/// The arrays of a mesh, with the names that a kernel's have.
#[derive(FromPyObject)]
pub(crate) struct Arrays<'py> {
    #[pyo3(item)]
    points: Coordinates<'py>,
    #[pyo3(item)]
    simplices: PyReadonlyArray2<'py, i32>,
    #[pyo3(item)]
    boundary: Boundary<'py>,
    #[pyo3(item)]
    regions: PyReadonlyArray1<'py, i32>,
    #[pyo3(item)]
    attributes: PyReadonlyArray1<'py, f64>,
    #[pyo3(item)]
    names: Vec<(u8, i64, String)>,
}

/// Triangles, markers, tetrahedra.
#[derive(FromPyObject)]
pub(crate) struct Boundary<'py>(
    PyReadonlyArray2<'py, i32>,
    PyReadonlyArray1<'py, i64>,
    PyReadonlyArray1<'py, i32>,
);

/// Rows of indices that are there.
fn rows<const N: usize>(
    array: &PyReadonlyArray2<'_, i32>,
    count: usize,
) -> Result<Vec<[u32; N]>, Failure> {
    let flat = array.as_slice().map_err(|e| Failure::new(Class::Input, "stored.layout", e))?;
    let named = |&v: &i32| u32::try_from(v).ok().filter(|&v| (v as usize) < count);
    let (rows, rest) = flat.as_chunks::<N>();
    let whole = rest.is_empty() && flat.iter().all(|v| named(v).is_some());
    if !whole {
        return Err(Failure::new(Class::Input, "stored.index", "an index that is not there"));
    }
    Ok(rows.iter().map(|row| row.map(|v| v as u32)).collect())
}

impl Arrays<'_> {
    fn mesh(&self) -> Result<TetMesh, Failure> {
        let layout = |e| Failure::new(Class::Input, "stored.layout", e);
        let points = points(&self.points)?;
        let tets: Vec<[u32; 4]> = rows(&self.simplices, points.len())?;
        let Boundary(triangles, markers, of) = &self.boundary;
        let markers = markers.as_slice().map_err(layout)?;
        let of = of.as_slice().map_err(layout)?;
        let face = |((corners, &marker), &tet): (([u32; 3], &i64), &i32)| {
            let tet = usize::try_from(tet).unwrap_or(usize::MAX);
            BoundaryFace { corners, marker, tet }
        };
        let corners: Vec<[u32; 3]> = rows(triangles, points.len())?;
        let faces: Vec<_> = corners.into_iter().zip(markers).zip(of).map(face).collect();
        let regions = self.regions.as_slice().map_err(layout)?;
        if faces.iter().any(|face| face.tet >= tets.len()) || regions.len() != tets.len() {
            return Err(Failure::new(Class::Input, "stored.index", "a tetrahedron too many"));
        }
        // Points alone have no regions.
        let is_domain = !faces.is_empty();
        let tags = is_domain.then(|| regions.iter().map(|&r| i64::from(r)).collect());
        let values = self.attributes.as_slice().map_err(layout)?;
        // A region without an attribute has its own number, as in files of a kernel.
        let of_region = |(region, &value): (u32, &f64)| {
            if value.is_nan() || value == 0.0 { f64::from(region) } else { value }
        };
        let values: Vec<f64> = (1..).zip(values).map(of_region).collect();
        let is_own = (1..).zip(&values).all(|(region, &value)| value == f64::from(region));
        let at = |&r: &i32| {
            let value = usize::try_from(r).ok().and_then(|r| values.get(r.checked_sub(1)?));
            value.copied().unwrap_or_default()
        };
        let attributes = (is_domain && !is_own).then(|| regions.iter().map(at).collect());
        Ok(TetMesh {
            points,
            tets,
            tet_tags: tags,
            tet_attributes: attributes,
            faces,
            point_tags: None,
        })
    }
}

/// Writes a mesh that is arrays alone; the extension tells the format.
#[pyfunction]
pub(crate) fn save(py: Python<'_>, path: PathBuf, parts: Arrays<'_>) -> PyResult<()> {
    let mesh = parts.mesh()?;
    let name = |(dimension, group, name)| GroupName { dimension, group, name };
    let names: Vec<GroupName> = parts.names.into_iter().map(name).collect();
    let save = move |reins: &Reins| Ok(ltbw_bindings::save(&mesh, &names, &path, &reins.cancel)?);
    Ok(supervised(py, None, save)?)
}
