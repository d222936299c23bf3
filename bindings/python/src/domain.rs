//! Meshes of domains.

use crate::arrays::{Coordinates, points};
use crate::certificate::{conformity, json_of};
use crate::failure::{Class, Failure};
use crate::kernel::{Body, Kernel};
use crate::points::in_pool;
use crate::size::{Field, Function, Size};
use crate::supervise::{Reins, supervised, unpanicked};
use ltbw::domain::{Domain, Facet, Frame, PrepareOptions, Prepared, Region};
use ltbw::refine::{RefineOutcome, Refined, Refiner};
use ltbw::{Point, io};
use ltbw_verify::{Breach, Conformity};
use pyo3::prelude::*;
use std::collections::HashSet;
use std::path::PathBuf;

/// Where the domain comes from.
#[derive(FromPyObject)]
pub(crate) enum Source<'py> {
    /// A file.
    File(PathBuf),
    /// Vertices, and polygons as a list of corners with the place where each polygon begins, and
    /// a marker for each.
    Arrays(Coordinates<'py>, Vec<i64>, Vec<usize>, Option<Vec<i32>>),
}

/// Bounds and options.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Wishes {
    max_volume: Option<f64>,
    radius_edge: Option<f64>,
    size: Option<Size>,
    max_points: Option<u64>,
    holes: Option<Vec<Point>>,
    /// A point inside, an attribute, the largest volume.
    regions: Vec<(Point, f64, Option<f64>)>,
    repair: f64,
    exact_input: bool,
    check: bool,
    threads: u32,
}

/// The domain of a source, and whether its facets are an oriented surface.
fn domain_of(source: Source<'_>) -> Result<Read, Failure> {
    let (coordinates, corners, starts, markers) = match source {
        Source::File(path) => return Ok(Read::File(path)),
        Source::Arrays(coordinates, corners, starts, markers) => {
            (coordinates, corners, starts, markers)
        }
    };
    let vertices = points(&coordinates)?;
    let mut facets = Vec::with_capacity(starts.len());
    for (f, &start) in starts.iter().enumerate() {
        let end = starts.get(f + 1).copied().unwrap_or(corners.len());
        let named = corners.get(start..end).unwrap_or_default();
        let vertex = |&v: &i64| u32::try_from(v).ok().filter(|&v| (v as usize) < vertices.len());
        let polygon: Option<Vec<u32>> = named.iter().map(vertex).collect();
        let Some(polygon) = polygon else {
            let text = format!("face {f} names a vertex that is not there: {named:?}");
            return Err(Failure::new(Class::Input, "faces.index", text).with([f as u32]));
        };
        let marker = markers.as_ref().and_then(|m| m.get(f)).copied().unwrap_or(0);
        facets.push(Facet::polygon(&polygon, marker));
    }
    Ok(Read::Domain(Domain { vertices, facets, ..Domain::default() }))
}

/// A domain that is still to be read, or is there.
enum Read {
    File(PathBuf),
    Domain(Domain),
}

impl Read {
    fn prepare(self, wishes: &Wishes) -> Result<(Prepared, Vec<String>), Failure> {
        let (mut domain, oriented, mut notes) = match self {
            Self::File(path) => {
                let file = io::read_domain(&path)?;
                (file.domain, file.oriented, file.notes)
            }
            Self::Domain(domain) => (domain, true, Vec::new()),
        };
        domain.holes.extend(wishes.holes.iter().flatten());
        let region = |&(seed, attribute, max_volume): &(Point, f64, Option<f64>)| Region {
            seed,
            attribute,
            max_volume,
        };
        domain.regions.extend(wishes.regions.iter().map(region));
        let ready = domain.prepare(&PrepareOptions {
            exact_input: wishes.exact_input,
            frame: Frame::Auto,
            repair: wishes.repair,
            // Holes that are given say what is void.
            oriented: oriented && wishes.holes.is_none(),
        })?;
        notes.extend(ready.repairs.notes());
        Ok((ready, notes))
    }
}

/// Refines, with a sizing field or without.
fn refine(
    ready: &Prepared,
    wishes: &Wishes,
    field: Option<&Field<'_>>,
    reins: &Reins,
) -> Result<Refined, Failure> {
    let refiner = match wishes.radius_edge {
        Some(bound) => Refiner::new().radius_edge(bound),
        None => Refiner::new().any_shape(),
    };
    let mut refiner = refiner.observer(&reins.progress).cancel(&reins.cancel);
    if let Some(bound) = wishes.max_volume {
        refiner = refiner.max_volume(bound);
    }
    if let Some(count) = wishes.max_points {
        refiner = refiner.max_points(count);
    }
    if let Some(field) = field {
        refiner = refiner.sizing(&**field);
    }
    Ok(refiner.refine(&ready.domain, &ready.lattice)?)
}

/// A mesh that is what was asked for, with its certificate and notes.
type Meshed = (Kernel, Option<String>, Vec<String>);

/// Meshes a domain.
#[pyfunction]
pub(crate) fn tetrahedralize(
    py: Python<'_>,
    source: Source<'_>,
    wishes: Wishes,
    progress: Option<Py<PyAny>>,
) -> PyResult<Meshed> {
    let read = domain_of(source)?;
    let tell = progress.as_ref();
    let whole = |reins: &Reins| {
        in_pool(wishes.threads, || {
            let (ready, notes) = read.prepare(&wishes)?;
            let field = wishes.size.as_ref().map(|size| size.field(&ready)).transpose()?.flatten();
            if let (None, Some(Size::Function(_))) = (&field, &wishes.size) {
                return Ok((ready, notes, None));
            }
            let refined = refine(&ready, &wishes, field.as_ref(), reins)?;
            Ok((ready, notes, Some(refined)))
        })
    };
    let (ready, notes, refined) = supervised(py, tell, whole)?;
    let refined = match (refined, &wishes.size) {
        (Some(refined), _) => refined,
        (None, Some(Size::Function(function))) => {
            with_function(py, &ready, &wishes, function, tell)?
        }
        (None, _) => return Err(Failure::new(Class::Internal, "internal.size", "no sizes").into()),
    };
    Ok(supervised(py, None, |_| finish(&ready, &wishes, notes, refined))?)
}

/// Refines on the calling thread: the function of the sizes is asked there, and nowhere else.
fn with_function(
    py: Python<'_>,
    ready: &Prepared,
    wishes: &Wishes,
    function: &Py<PyAny>,
    tell: Option<&Py<PyAny>>,
) -> Result<Refined, Failure> {
    let reins = Reins::new();
    let asked = Function::new(function, ready.lattice.offset(), &reins, tell);
    let refined = py.detach(|| {
        let field: Field<'_> = Box::new(|p| asked.at(p));
        unpanicked(|| refine(ready, wishes, Some(&field), &reins))
    });
    asked.raised().map_or(refined, Err)
}

/// Checks the mesh; a boundary that is not in it is an error.
fn finish(
    ready: &Prepared,
    wishes: &Wishes,
    notes: Vec<String>,
    refined: Refined,
) -> Result<Meshed, Failure> {
    let outcome = match refined.outcome {
        RefineOutcome::Met => "met",
        RefineOutcome::Excused => "excused",
        RefineOutcome::Budget => "budget",
        RefineOutcome::Cancelled => "cancelled",
        RefineOutcome::Unrecovered => return Err(unrecovered(&refined)),
    };
    let excused: HashSet<[u32; 4]> =
        refined.excuses.iter().filter_map(|e| refined.mesh().tet(e.tet)).collect();
    let body = Body::Domain(Box::new(refined));
    let mut certificate = None;
    if wishes.check && outcome != "cancelled" {
        let mesh = body.plain();
        let bounds = (wishes.radius_edge, wishes.max_volume);
        let tags = mesh.tet_tags.as_deref();
        let found = conformity(ready, &mesh.points, &mesh.tets, tags, bounds, excused.len());
        let same = match (ready.report.volume(), &found.volume) {
            (Some(a), Some(b)) => a.to_string() == b.to_string(),
            _ => true,
        };
        let text = json_of(&found, same && found.passed()).to_string();
        if !(same && is_explained(&found, &mesh.tets, &excused)) {
            let message = format!("a defect of ltbw: the mesh is not what was asked for: {text}");
            return Err(Failure::new(Class::Internal, "internal.mesh", message));
        }
        certificate = Some(text);
    }
    Ok((Kernel::new(body, outcome), certificate, notes))
}

/// Why some of the boundary is not in the mesh.
fn unrecovered(refined: &Refined) -> Failure {
    let first = refined.lost.iter().take(5).map(|(item, reason)| {
        let (kind, at) = refined.place(item);
        format!("{kind} at {at:?}: {reason}")
    });
    let first: Vec<String> = first.collect();
    let text = format!(
        "{} items of the boundary could not be brought into the mesh; {}",
        refined.lost.len(),
        first.join("; ")
    );
    Failure::new(Class::Recovery, "refine.unrecovered", text)
}

/// Is every finding a bound that a tetrahedron with an excuse exceeds?
fn is_explained(found: &Conformity, tets: &[[u32; 4]], excused: &HashSet<[u32; 4]>) -> bool {
    let is_excused = |&t: &u32| tets.get(t as usize).is_some_and(|tet| excused.contains(tet));
    found.mesh_defect_count == 0
        && found.counts.iter().all(|(&breach, &count)| {
            let listed = found.findings.iter().filter(|f| f.breach == breach);
            matches!(breach, Breach::RatioExceeded | Breach::VolumeExceeded)
                && listed.clone().count() as u64 == count
                && listed.clone().all(|f| f.ids.first().is_some_and(is_excused))
        })
}
