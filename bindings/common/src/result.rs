//! A mesh and its arrays, made when they are asked for.

use crate::body::{Body, NOWHERE};
use crate::certificate;
use crate::failure::Failure;
use crate::locate::Locator;
use crate::work::in_own_pool;
use ltbw::quality::{self, LeastAngles, Quality};
use ltbw::refine::{Excuse, Refined, RegionInfo};
use ltbw::topology::TetId;
use ltbw::{BoundaryFace, CancelToken, Point, TetMesh, canonical_hash, io};
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// A tetrahedron over a bound.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExcusedTet {
    /// Its place.
    pub tet: u32,
    /// The reason.
    pub reason: String,
}

/// The outcome of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The mesh has all points.
    Complete,
    /// The mesh of a domain meets every bound.
    Met,
    /// Some tetrahedra are over a bound, each with a reason.
    Excused,
    /// The budget was used up first.
    Budget,
    /// The work was cancelled first; the mesh is that so far.
    Cancelled,
}

impl Outcome {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Met => "met",
            Self::Excused => "excused",
            Self::Budget => "budget",
            Self::Cancelled => "cancelled",
        }
    }
}

/// A mesh, its outcome, and the notes on how it came about.
pub struct Meshed {
    body: Arc<Body>,
    locator: OnceLock<Locator>,
    /// The outcome of the work.
    pub outcome: Outcome,
    /// The certificate of a domain's mesh (`ltbw.conformity/1`), if it was checked.
    pub certificate: Option<String>,
    /// Names of markers of boundary triangles, and of regions.
    pub names: Vec<io::GroupName>,
    /// Notes for people.
    pub notes: Vec<String>,
}

impl std::fmt::Debug for Meshed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Meshed").field("outcome", &self.outcome).finish_non_exhaustive()
    }
}

impl Meshed {
    pub(crate) fn new(body: Body, outcome: Outcome) -> Self {
        let (body, locator) = (Arc::new(body), OnceLock::new());
        let (names, notes) = (Vec::new(), Vec::new());
        Self { body, locator, outcome, certificate: None, names, notes }
    }

    fn refined(&self) -> Option<&Refined> {
        match &*self.body {
            Body::Points { .. } => None,
            Body::Domain(refined) => Some(refined),
        }
    }

    /// Coordinates of the vertices; of a point set those given.
    #[must_use]
    pub fn points(&self) -> Vec<Point> {
        match &*self.body {
            Body::Points { set, .. } => set.points().to_vec(),
            Body::Domain(refined) => refined.mesh().to_tet_mesh().points,
        }
    }

    /// Corners of the tetrahedra.
    #[must_use]
    pub fn tets(&self) -> Vec<[u32; 4]> {
        match &*self.body {
            Body::Points { mesh, .. } => mesh.tets().collect(),
            Body::Domain(refined) => refined.tets().filter_map(|t| refined.tet(t)).collect(),
        }
    }

    /// Across the face opposite each corner the tetrahedron there, or [`NOWHERE`].
    #[must_use]
    pub fn neighbours(&self) -> Vec<[u32; 4]> {
        let (mesh, place) = (self.body.mesh(), self.body.places());
        let across = |t: TetId, slot| mesh.neighbour(t, slot).map_or(NOWHERE, |o| place[o.index()]);
        let all = |t: TetId| {
            let own = mesh.tet(t).unwrap_or_default();
            // The kernel has the corners of a domain's tetrahedron in an order of its own.
            let shown = self.refined().and_then(|refined| refined.tet(t)).unwrap_or(own);
            let slot = |corner: &u32| own.iter().position(|v| v == corner).unwrap_or_default();
            shown.map(|corner| across(t, slot(&corner)))
        };
        self.body.ids().into_iter().map(all).collect()
    }

    /// Facets of the convex hull of all vertices, counterclockwise from outside.
    #[must_use]
    pub fn hull(&self) -> Vec<[u32; 3]> {
        self.body.mesh().hull_facets().collect()
    }

    /// Duplicates, each with the vertex at its place.
    #[must_use]
    pub fn duplicates(&self) -> Vec<[u32; 2]> {
        self.body.mesh().duplicates().iter().map(|d| [d.number, d.kept]).collect()
    }

    /// Boundary triangles of a domain; none of a point set.
    #[must_use]
    pub fn boundary(&self) -> Vec<BoundaryFace> {
        self.refined().map(|refined| refined.boundary()).unwrap_or_default()
    }

    /// The region of each tetrahedron, from 1; of a point set all are 1.
    #[must_use]
    pub fn regions(&self) -> Vec<u32> {
        match &*self.body {
            Body::Points { mesh, .. } => vec![1; mesh.num_tets()],
            Body::Domain(refined) => refined.tets().map(|t| refined.region(t)).collect(),
        }
    }

    /// The tetrahedra over a bound.
    #[must_use]
    pub fn excuses(&self) -> Vec<ExcusedTet> {
        let Some(refined) = self.refined() else { return Vec::new() };
        let place = self.body.places();
        let all = refined.excuses.iter();
        let told =
            |e: &Excuse| ExcusedTet { tet: place[e.tet.index()], reason: e.reason.to_string() };
        all.map(told).collect()
    }

    /// The place that coordinates are relative to.
    #[must_use]
    pub fn offset(&self) -> Point {
        self.refined().map_or([0.0; 3], |refined| refined.lattice.offset())
    }

    /// Attributes of the regions, the first that of region 1; NaN of a region without one.
    #[must_use]
    pub fn attributes(&self) -> Vec<f64> {
        let attribute = |r: &RegionInfo| if r.seed.is_some() { r.attribute } else { f64::NAN };
        match &*self.body {
            Body::Points { .. } => vec![f64::NAN],
            Body::Domain(refined) => refined.regions.iter().skip(1).map(attribute).collect(),
        }
    }

    /// For each duplicate its number, a tetrahedron at the vertex in its place, and that vertex.
    #[must_use]
    pub fn coplanar(&self) -> Vec<[u32; 3]> {
        let duplicates = self.duplicates();
        if duplicates.is_empty() {
            return Vec::new();
        }
        let mut at = vec![NOWHERE; self.points().len()];
        for (t, corners) in (0..).zip(self.tets()) {
            for v in corners {
                at[v as usize] = at[v as usize].min(t);
            }
        }
        duplicates.into_iter().map(|[point, vertex]| [point, at[vertex as usize], vertex]).collect()
    }

    /// For each point, in the mesh's coordinates, a tetrahedron that holds it, or [`NOWHERE`]. The
    /// first call takes O(n).
    ///
    /// # Errors
    /// A point that is not finite; work cancelled.
    pub fn find(&self, points: &[Point], cancel: &CancelToken) -> Result<Vec<u32>, Failure> {
        let locator = self.locator.get_or_init(|| Locator::new(&self.body));
        in_own_pool(|| locator.find(points, cancel))
    }

    /// The canonical hash `ltbw.mesh/1`.
    ///
    /// # Errors
    /// A mesh without one.
    pub fn hash(&self) -> Result<String, Failure> {
        in_own_pool(|| Ok(canonical_hash(&self.points(), &self.tets())?.to_string()))
    }

    /// Histograms and extremes; `None` of a mesh without tetrahedra.
    #[must_use]
    pub fn quality(&self) -> Option<Quality> {
        Quality::of(&self.points(), &self.tets())
    }

    /// Smallest dihedral angles before slivers were split, if they were counted.
    #[must_use]
    pub fn before_slivers(&self) -> Option<LeastAngles> {
        self.refined()?.stats.before_slivers
    }

    /// The mesh as files carry it.
    pub(crate) fn plain(&self) -> TetMesh {
        match self.refined() {
            Some(refined) => refined.inside(),
            None => TetMesh { points: self.points(), tets: self.tets(), ..TetMesh::default() },
        }
    }

    /// Writes the mesh; the extension tells the format. Cancelled, it leaves the file as it was.
    ///
    /// # Errors
    /// Formats that hold no mesh; files that cannot be written; work cancelled.
    pub fn save(&self, path: &Path, cancel: &CancelToken) -> Result<(), Failure> {
        save(&self.plain(), &self.names, path, cancel)
    }

    /// The certificate as JSON: of points `ltbw.cert/1`, made anew; of a domain the one that came
    /// with it, if it was checked.
    ///
    /// # Errors
    /// A certificate that is no JSON.
    pub fn certify(&self, full: bool) -> Result<Option<String>, Failure> {
        if self.refined().is_some() {
            return Ok(self.certificate.clone());
        }
        let (points, tets) = (self.points(), self.tets());
        let (neighbours, hull) = (self.neighbours(), self.hull());
        let mesh = ltbw_verify::Mesh::new(&points, &tets);
        let mesh = mesh.with_neighbours(&neighbours).with_hull(&hull);
        let depth = if full { ltbw_verify::Depth::Full } else { ltbw_verify::Depth::Fast };
        // Some may have been removed.
        let (vertices, duplicates) = (self.body.mesh().num_vertices(), self.duplicates().len());
        let all_points = vertices + duplicates == points.len();
        let options = ltbw_verify::Options { depth, all_points, ..ltbw_verify::Options::default() };
        in_own_pool(|| certificate::json(&ltbw_verify::check(&mesh, &options)).map(Some))
    }
}

/// Writes a mesh with names of its groups; that of a domain, which has faces, with the quality of
/// its tetrahedra. The extension tells the format. Cancelled, it leaves the file as it was.
///
/// # Errors
/// Formats that hold no mesh; files that cannot be written; work cancelled.
pub fn save(
    mesh: &TetMesh,
    names: &[io::GroupName],
    path: &Path,
    cancel: &CancelToken,
) -> Result<(), Failure> {
    let values = match mesh.faces.is_empty() {
        false => quality::arrays(&mesh.points, &mesh.tets),
        true => Vec::new(),
    };
    let writer = io::MeshWriter::new(mesh).values(&values).names(names).cancel(cancel);
    // Other formats carry none.
    let hash = match io::Format::from_path(path)? {
        io::Format::Vtu | io::Format::Msh => {
            let hash = in_own_pool(|| Ok::<_, Failure>(canonical_hash(&mesh.points, &mesh.tets)?));
            Some(hash?.to_string())
        }
        _ => None,
    };
    Ok(hash.as_deref().map_or(writer, |hash| writer.hash(hash)).write(path)?)
}
