//! A mesh that Python holds: its arrays are made when they are asked for.

use crate::arrays::{Coordinates, coordinates, line, points, rows};
use crate::failure::Failure;
use crate::supervise::supervised;
use ltbw::Point;
use ltbw::quality::{Histogram, LeastAngles, Quality, SMALL_ANGLES};
use ltbw_bindings::{Meshed, Reins, in_own_pool};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::Arc;

/// Histograms and extremes for Python.
pub(crate) fn measures<'py>(py: Python<'py>, quality: &Quality) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    let histogram = |h: &Histogram| {
        let entries = PyDict::new(py);
        entries.set_item("low", h.low)?;
        entries.set_item("high", h.high)?;
        entries.set_item("counts", PyList::new(py, &h.counts)?)?;
        entries.set_item("least", (h.least.value, h.least.tet))?;
        entries.set_item("largest", (h.largest.value, h.largest.tet))?;
        PyResult::Ok(entries)
    };
    all.set_item("dihedral", histogram(&quality.dihedral)?)?;
    all.set_item("radius_edge", histogram(&quality.radius_edge)?)?;
    all.set_item("volume", histogram(&quality.volume)?)?;
    all.set_item("edge", histogram(&quality.edge)?)?;
    all.set_item("least_dihedral", least_angles(py, &quality.least_angles)?)?;
    let jacobian = quality.scaled_jacobian;
    all.set_item("least_scaled_jacobian", (jacobian.value, jacobian.tet))?;
    let small: Vec<(f64, u64)> = SMALL_ANGLES.into_iter().zip(quality.small).collect();
    all.set_item("small_dihedral", small)?;
    Ok(all)
}

/// Tetrahedra by their smallest dihedral angle.
fn least_angles<'py>(py: Python<'py>, angles: &LeastAngles) -> PyResult<Bound<'py, PyDict>> {
    let entries = PyDict::new(py);
    entries.set_item("low", 0.0)?;
    entries.set_item("high", LeastAngles::HIGH)?;
    entries.set_item("counts", PyList::new(py, angles.counts())?)?;
    entries.set_item("least", angles.least())?;
    Ok(entries)
}

/// A mesh; `ltbw.Mesh` gives its arrays their names.
#[pyclass(frozen, module = "ltbw._native")]
pub(crate) struct Kernel(Arc<Meshed>);

impl Kernel {
    pub(crate) fn new(meshed: Meshed) -> Self {
        Self(Arc::new(meshed))
    }

    /// The part of the mesh that `make` makes, without the interpreter.
    fn made<T: Send + 'static>(
        &self,
        py: Python<'_>,
        make: impl FnOnce(&Meshed) -> T + Send + 'static,
    ) -> Result<T, Failure> {
        let mesh = Arc::clone(&self.0);
        supervised(py, None, move |_| in_own_pool(|| Ok(make(&mesh))))
    }
}

#[pymethods]
impl Kernel {
    /// `complete`, `met`, `excused`, `budget` or `cancelled`.
    #[getter]
    fn outcome(&self) -> &'static str {
        self.0.outcome.name()
    }

    /// Names of boundary triangles' markers, and of regions: (dimension, number, name).
    #[getter]
    fn names(&self) -> Vec<(u8, i64, String)> {
        self.0.names.iter().map(|n| (n.dimension, n.group, n.name.clone())).collect()
    }

    /// Coordinates of the vertices, of shape (n, 3).
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = self.made(py, Meshed::points)?;
        coordinates(py, points)
    }

    /// Corners of the tetrahedra, of shape (m, 4).
    fn simplices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let tets = self.made(py, Meshed::tets)?;
        rows(py, tets)
    }

    /// Across the face opposite each corner the tetrahedron there, or -1.
    fn neighbors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let neighbours = self.made(py, Meshed::neighbours)?;
        rows(py, neighbours)
    }

    /// Facets of the convex hull, of shape (h, 3), seen counterclockwise from outside.
    fn convex_hull<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let hull = self.made(py, Meshed::hull)?;
        rows(py, hull)
    }

    /// Duplicates, each with a tetrahedron at the vertex in its place, and that vertex.
    fn coplanar<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let coplanar = self.made(py, Meshed::coplanar)?;
        rows(py, coplanar)
    }

    /// Attributes of the regions; NaN of a region without one.
    fn attributes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        line(py, self.0.attributes())
    }

    /// Boundary triangles of a domain, the markers of their facets, their tetrahedra.
    #[expect(clippy::type_complexity, reason = "three arrays")]
    fn boundary<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyArray2<i32>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i32>>)>
    {
        let faces = self.made(py, Meshed::boundary)?;
        let markers = faces.iter().map(|f| f.marker).collect();
        let tets = faces.iter().map(|f| f.tet as i32).collect();
        let corners = rows(py, faces.iter().map(|f| f.corners).collect())?;
        Ok((corners, line(py, markers), line(py, tets)))
    }

    /// The region of each tetrahedron, from 1.
    fn regions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        let regions = self.made(py, Meshed::regions)?;
        Ok(line(py, regions.into_iter().map(|r| r as i32).collect()))
    }

    /// The tetrahedra over a bound, each with the reason.
    fn excuses(&self) -> Vec<(u32, String)> {
        self.0.excuses().into_iter().map(|own| (own.tet, own.reason)).collect()
    }

    /// The place that coordinates are relative to.
    fn offset(&self) -> Point {
        self.0.offset()
    }

    /// For each point a tetrahedron that holds it, or -1.
    fn find_simplex<'py>(
        &self,
        py: Python<'py>,
        xi: Coordinates<'py>,
    ) -> PyResult<Bound<'py, PyArray1<i32>>> {
        let wanted = points(&xi)?;
        let mesh = Arc::clone(&self.0);
        let find = move |reins: &Reins| Ok(mesh.find(&wanted, &reins.cancel)?);
        let found = supervised(py, None, find)?;
        // It is the caller's alone.
        Ok(bytemuck::cast_vec::<u32, i32>(found).into_pyarray(py))
    }

    /// Histograms and extremes of dihedral angle, radius-edge ratio, volume and edge length.
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let quality = self.made(py, Meshed::quality)?;
        let all = quality.map(|quality| measures(py, &quality)).transpose()?;
        let before = self.0.before_slivers();
        let before = before.map(|before| least_angles(py, &before)).transpose()?;
        all.iter().try_for_each(|all| all.set_item("least_dihedral_before", &before))?;
        Ok(all)
    }

    /// Writes the mesh; the extension tells the format.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let mesh = Arc::clone(&self.0);
        let save = move |reins: &Reins| in_own_pool(|| Ok(mesh.save(&path, &reins.cancel)?));
        Ok(supervised(py, None, save)?)
    }

    /// The canonical hash `ltbw.mesh/1`.
    fn hash(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.made(py, Meshed::hash)?.map_err(Failure::from)?)
    }

    /// The certificate of the mesh as JSON.
    fn certify(&self, py: Python<'_>, full: bool) -> PyResult<Option<String>> {
        Ok(self.made(py, move |mesh| mesh.certify(full))?.map_err(Failure::from)?)
    }
}
