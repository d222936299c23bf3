//! A mesh that Python holds: its arrays are made when they are asked for.

use crate::arrays::{Coordinates, coordinates, line, points, rows};
use crate::failure::{Class, Failure};
use crate::supervise::supervised;
use ltbw::quality::{self, Histogram, Quality};
use ltbw::query::{Cursor, Location, Queries};
use ltbw::refine::Refined;
use ltbw::topology::TetId;
use ltbw::{Extras, Mesh, Point, PointSet, TetMesh, io};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// A mesh of a point set or of a domain.
pub(crate) enum Body {
    Points { mesh: Box<Mesh>, set: PointSet },
    Domain(Box<Refined>),
}

impl Body {
    fn mesh(&self) -> &Mesh {
        match self {
            Self::Points { mesh, .. } => mesh,
            Self::Domain(refined) => refined.mesh(),
        }
    }

    /// The tetrahedra that Python sees, in its order.
    fn ids(&self) -> Vec<TetId> {
        match self {
            Self::Points { mesh, .. } => mesh.tet_ids().collect(),
            Self::Domain(refined) => refined.tets().collect(),
        }
    }

    pub(crate) fn simplices(&self) -> Vec<[u32; 4]> {
        match self {
            Self::Points { mesh, .. } => mesh.tets().collect(),
            Self::Domain(refined) => refined.tets().filter_map(|t| refined.mesh().tet(t)).collect(),
        }
    }

    /// The mesh as files carry it.
    pub(crate) fn plain(&self) -> TetMesh {
        match self {
            Self::Points { set, .. } => TetMesh {
                points: set.points().to_vec(),
                tets: self.simplices(),
                ..TetMesh::default()
            },
            Self::Domain(refined) => refined.to_tet_mesh(false),
        }
    }
}

self_cell::self_cell!(
    /// A mesh with what questions to it need.
    struct Asked {
        owner: Arc<Body>,
        #[covariant]
        dependent: Queries,
    }
);

/// Places of tetrahedra in Python's order, and the answers to where points are.
struct Places {
    asked: Asked,
    place: Vec<u32>,
}

/// The place of a tetrahedron that Python does not see.
const NOWHERE: u32 = u32::MAX;

/// A mesh; `ltbw.Mesh` gives its arrays their names.
#[pyclass(frozen, module = "ltbw._native")]
pub(crate) struct Kernel {
    body: Arc<Body>,
    places: OnceLock<Places>,
    outcome: &'static str,
}

impl Kernel {
    pub(crate) fn new(body: Body, outcome: &'static str) -> Self {
        Self { body: Arc::new(body), places: OnceLock::new(), outcome }
    }

    fn place(&self) -> Vec<u32> {
        let mut place = vec![NOWHERE; self.body.mesh().topology().slots()];
        for (k, &t) in (0..).zip(&self.body.ids()) {
            place[t as usize] = k;
        }
        place
    }

    fn places(&self) -> &Places {
        self.places.get_or_init(|| Places {
            asked: Asked::new(Arc::clone(&self.body), |body| body.mesh().queries()),
            place: self.place(),
        })
    }
}

/// The place of a tetrahedron that holds `p`, or -1.
fn find(mesh: &Mesh, place: &[u32], cursor: &mut Cursor<'_>, p: Point) -> Result<i32, Failure> {
    let seen = |t: TetId| place.get(t as usize).copied().filter(|&k| k != NOWHERE);
    // On a vertex, edge or face any tetrahedron there will do; of several the first seen.
    let corners: Vec<u32> = match cursor.locate(p)? {
        Location::Tet(t) => return Ok(seen(t).map_or(-1, |k| k as i32)),
        Location::OutsideHull { .. } => return Ok(-1),
        Location::Vertex(v) => vec![v],
        Location::Edge { ends, .. } => ends.to_vec(),
        Location::Facet { corners, .. } => corners.to_vec(),
        // Locations of kinds to come.
        #[allow(unreachable_patterns)]
        _ => return Ok(-1),
    };
    let Some(star) = corners.first().and_then(|&v| cursor.star(v)).map(<[TetId]>::to_vec) else {
        return Ok(-1);
    };
    let has_all = |t: TetId| mesh.tet(t).is_some_and(|tet| corners.iter().all(|v| tet.contains(v)));
    let at = star.into_iter().filter(|&t| has_all(t)).filter_map(seen).min();
    Ok(at.map_or(-1, |k| k as i32))
}

#[pymethods]
impl Kernel {
    /// `complete`, `met`, `excused`, `budget` or `cancelled`.
    #[getter]
    fn outcome(&self) -> &'static str {
        self.outcome
    }

    /// Coordinates of the vertices, of shape (n, 3).
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = match &*self.body {
            Body::Points { set, .. } => set.points().to_vec(),
            Body::Domain(refined) => py.detach(|| refined.mesh().to_tet_mesh().points),
        };
        coordinates(py, points)
    }

    /// Corners of the tetrahedra, of shape (m, 4).
    fn simplices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let simplices = py.detach(|| self.body.simplices());
        rows(py, simplices)
    }

    /// Across the face opposite each corner the tetrahedron there, or -1.
    fn neighbors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let neighbours = py.detach(|| {
            let (mesh, place) = (self.body.mesh(), self.place());
            let across = |t: TetId| {
                [0, 1, 2, 3].map(|slot| {
                    let other = mesh.neighbour(t, slot);
                    // -1 as an int32 is the largest u32.
                    other.map_or(NOWHERE, |other| place[other as usize])
                })
            };
            self.body.ids().into_iter().map(across).collect()
        });
        rows(py, neighbours)
    }

    /// Facets of the convex hull, of shape (h, 3), seen counterclockwise from outside.
    fn convex_hull<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let hull = py.detach(|| self.body.mesh().hull_facets().collect());
        rows(py, hull)
    }

    /// Duplicates, each with the vertex at its place.
    fn duplicates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        rows(py, self.body.mesh().duplicates().iter().map(|&(a, b)| [a, b]).collect())
    }

    /// Boundary triangles, and the markers of their facets. None for a point set.
    #[expect(clippy::type_complexity, reason = "two arrays")]
    fn boundary<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(Bound<'py, PyArray2<i32>>, Bound<'py, PyArray1<i64>>)>> {
        let Body::Domain(refined) = &*self.body else { return Ok(None) };
        let faces = py.detach(|| refined.boundary(false));
        let markers = faces.iter().map(|f| f.marker).collect();
        let corners = rows(py, faces.iter().map(|f| f.corners).collect())?;
        Ok(Some((corners, line(py, markers))))
    }

    /// The region of each tetrahedron, from 1; None for a point set.
    fn regions<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<i32>>> {
        let Body::Domain(refined) = &*self.body else { return None };
        let regions = refined.tets().map(|t| refined.region(t) as i32).collect();
        Some(line(py, regions))
    }

    /// The tetrahedra over a bound, each with the reason.
    fn excuses(&self) -> Vec<(i32, String)> {
        let Body::Domain(refined) = &*self.body else { return Vec::new() };
        let place = self.place();
        let excuse =
            |e: &ltbw::refine::Excuse| (place[e.tet as usize] as i32, e.reason.to_string());
        refined.excuses.iter().map(excuse).collect()
    }

    /// The place that coordinates are relative to.
    fn offset(&self) -> Point {
        match &*self.body {
            Body::Points { .. } => [0.0; 3],
            Body::Domain(refined) => refined.lattice.offset(),
        }
    }

    /// For each point a tetrahedron that holds it, or -1.
    fn find_simplex<'py>(
        &self,
        py: Python<'py>,
        xi: Coordinates<'py>,
    ) -> PyResult<Bound<'py, PyArray1<i32>>> {
        let wanted = points(&xi)?;
        let found = supervised(py, None, |_| {
            let places = self.places();
            let (mesh, queries) = (self.body.mesh(), places.asked.borrow_dependent());
            let find = |cursor: &mut Cursor<'_>, &p: &Point| find(mesh, &places.place, cursor, p);
            wanted.par_iter().map_init(|| queries.cursor(), find).collect::<Result<Vec<i32>, _>>()
        })?;
        Ok(line(py, found))
    }

    /// Histograms and extremes of dihedral angle, radius-edge ratio, volume and edge length.
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let quality = py.detach(|| {
            let mesh = self.body.plain();
            Quality::of(&mesh.points, &mesh.tets)
        });
        let Some(quality) = quality else { return Ok(None) };
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
        Ok(Some(all))
    }

    /// Writes the mesh; the extension tells the format.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let body = &self.body;
        Ok(supervised(py, None, |_| {
            let mesh = body.plain();
            let extras = match &**body {
                Body::Points { .. } => Extras::default(),
                Body::Domain(refined) => Extras {
                    values: quality::arrays(&mesh.points, &mesh.tets),
                    faces: refined.boundary(false),
                },
            };
            io::write_mesh_and(&path, &mesh, &extras, io::WriteOptions::default())
                .map_err(Failure::from)
        })?)
    }

    /// The certificate of the mesh as a Delaunay mesh, as JSON; of a domain's mesh None (its own
    /// certificate came with it).
    fn certify(&self, py: Python<'_>, full: bool) -> PyResult<Option<String>> {
        let Body::Points { mesh, set } = &*self.body else { return Ok(None) };
        let text = supervised(py, None, |_| {
            let place = self.place();
            let ids = self.body.ids();
            let across = |&t: &TetId| {
                [0, 1, 2, 3]
                    .map(|slot| mesh.neighbour(t, slot).map_or(NOWHERE, |o| place[o as usize]))
            };
            let neighbours: Vec<[u32; 4]> = ids.iter().map(across).collect();
            let (tets, hull) = (self.body.simplices(), mesh.hull_facets().collect::<Vec<_>>());
            let own = ltbw_verify::Mesh::new(set.points(), &tets);
            let own = own.with_neighbours(&neighbours).with_hull(&hull);
            let depth = if full { ltbw_verify::Depth::Full } else { ltbw_verify::Depth::Fast };
            let all_points = self.outcome == "complete";
            let options =
                ltbw_verify::Options { depth, all_points, ..ltbw_verify::Options::default() };
            let report = ltbw_verify::check(&own, &options);
            report
                .certificate()
                .to_json()
                .map_err(|e| Failure::new(Class::Internal, "internal.json", e))
        })?;
        Ok(Some(text))
    }
}
