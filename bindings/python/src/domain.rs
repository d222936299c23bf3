//! Meshes of domains.

use crate::arrays::{Coordinates, points};
use crate::failure::Failure;
use crate::kernel::Kernel;
use crate::size::{Function, Size};
use crate::supervise::supervised;
use ltbw::Point;
use ltbw::domain::Region;
use ltbw::refine::Refined;
use ltbw_bindings::{Class, Frame, Holes, Near, Ready, Reins, SizeAt, Source, Wishes};
use ltbw_bindings::{Field, in_pool, unpanicked};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// Where the domain comes from.
#[derive(FromPyObject)]
pub(crate) enum Given<'py> {
    /// A file.
    File(PathBuf),
    /// Vertices, and polygons as a list of corners with the place where each polygon begins, and
    /// a marker for each.
    Arrays(Coordinates<'py>, Vec<i64>, Vec<usize>, Option<Vec<i32>>),
}

impl Given<'_> {
    /// This source without arrays of Python's.
    pub(crate) fn source(self) -> Result<Source, Failure> {
        Ok(match self {
            Self::File(path) => Source::File(path),
            Self::Arrays(coordinates, corners, starts, markers) => Source::Arrays {
                vertices: points(&coordinates)?,
                corners,
                starts,
                markers: markers.unwrap_or_default(),
            },
        })
    }
}

/// The voids: what points are in, or bodies inside others, or none.
#[derive(FromPyObject)]
pub(crate) enum Void {
    Auto(bool),
    Points(Vec<Point>),
}

/// Bounds and options, by the names that Python gives them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Asked {
    max_volume: Option<f64>,
    radius_edge: Option<f64>,
    min_dihedral: Option<f64>,
    smooth: u32,
    size: Option<Size>,
    max_edge: Option<f64>,
    /// A place, a length, a radius.
    near: Vec<(Point, f64, f64)>,
    /// A part by its marker or name, a length.
    size_at: Vec<(String, f64)>,
    curvature: Option<f64>,
    growth: Option<f64>,
    max_points: Option<u64>,
    holes: Option<Void>,
    /// A point inside, an attribute, the largest volume.
    regions: Vec<(Point, f64, Option<f64>)>,
    repair: f64,
    simplify: f64,
    fill: u32,
    flat_tolerance: Option<f64>,
    feature_angle: Option<f64>,
    exact_input: bool,
    strict: bool,
    own_frame: Option<bool>,
    check: bool,
    excused_share: Option<f64>,
    threads: u32,
}

impl Asked {
    pub(crate) fn wishes(&self) -> Wishes {
        let region = |&(seed, attribute, max_volume): &(Point, f64, Option<f64>)| Region {
            seed,
            attribute,
            max_volume,
        };
        let near = |&(at, length, radius): &(Point, f64, f64)| Near { at, length, radius };
        let at = |(part, length): &(String, f64)| SizeAt { part: part.clone(), length: *length };
        Wishes {
            max_volume: self.max_volume,
            max_edge: self.max_edge,
            near: self.near.iter().map(near).collect(),
            size_at: self.size_at.iter().map(at).collect(),
            curvature: self.curvature,
            growth: self.growth,
            radius_edge: self.radius_edge,
            min_dihedral: self.min_dihedral,
            smooth: self.smooth,
            count_angles: true,
            max_points: self.max_points,
            holes: match &self.holes {
                None => Holes::Given,
                Some(Void::Points(points)) => Holes::At(points.clone()),
                Some(Void::Auto(true)) => Holes::Auto,
                Some(Void::Auto(false)) => Holes::None,
            },
            regions: self.regions.iter().map(region).collect(),
            repair: self.repair,
            simplify: self.simplify,
            fill: self.fill,
            flat_tolerance: self.flat_tolerance,
            feature_angle: self.feature_angle,
            points: Vec::new(),
            exact_input: self.exact_input,
            strict: self.strict,
            frame: match self.own_frame {
                None => Frame::Auto,
                Some(true) => Frame::Own,
                Some(false) => Frame::Local,
            },
            unchecked: !self.check,
            excused_share: self.excused_share,
        }
    }
}

/// The mesh, its certificate, and notes.
type Meshed = (Kernel, Option<String>, Vec<String>);

/// Meshes a domain, with more points as vertices.
#[pyfunction]
pub(crate) fn tetrahedralize(
    py: Python<'_>,
    given: Given<'_>,
    asked: Asked,
    more: Option<Coordinates<'_>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Meshed> {
    let source = given.source()?;
    let more = more.map(|more| points(&more)).transpose()?.unwrap_or_default();
    let wishes = Arc::new(Wishes { points: more, ..asked.wishes() });
    let (tell, asked) = (progress.as_ref(), Arc::new(asked));
    let own = (Arc::clone(&wishes), Arc::clone(&asked));
    let whole = move |reins: &Reins| {
        let (wishes, asked) = own;
        in_pool(asked.threads, || {
            let ready = Ready::new(source, &wishes)?;
            let field = asked.size.as_ref().map(|size| size.field(&ready)).transpose()?.flatten();
            if let (None, Some(Size::Function(_))) = (&field, &asked.size) {
                return Ok((ready, None));
            }
            let graded = ready.graded(&wishes)?;
            let both = |p| {
                let own = field.as_ref().map_or(f64::INFINITY, |field| field(p));
                graded.as_ref().map_or(own, |sizes| own.min(sizes.at(p)))
            };
            let is_asked = field.is_some() || graded.is_some();
            let field = is_asked.then_some(&both as &Field<'_>);
            let refined = ready.refine(&wishes, field, false, &reins.progress, &reins.cancel)?;
            Ok((ready, Some(refined)))
        })
    };
    let (ready, refined) = supervised(py, tell, whole)?;
    let refined = match (refined, &asked.size) {
        (Some(refined), _) => refined,
        (None, Some(Size::Function(function))) => {
            with_function(py, &ready, &wishes, function, tell)?
        }
        (None, _) => return Err(Failure::new(Class::Internal, "internal.size", "no sizes").into()),
    };
    let threads = asked.threads;
    let finish = move |_: &Reins| in_pool(threads, || Ok(ready.finish(&wishes, refined)?));
    let meshed = supervised(py, None, finish)?;
    let (certificate, notes) = (meshed.certificate.clone(), meshed.notes.clone());
    Ok((Kernel::new(meshed), certificate, notes))
}

/// Refuses work of the calling thread in a process that was forked after such work: it uses the
/// threads that Rayon keeps, which are lost there.
fn forked() -> Result<(), Failure> {
    static BEGUN: OnceLock<u32> = OnceLock::new();
    let own = std::process::id();
    if *BEGUN.get_or_init(|| own) == own {
        return Ok(());
    }
    let text = "a sizing function was used before this process was forked, and cannot be used in \
                it: start processes by \"spawn\" or \"forkserver\"";
    Err(Failure::new(Class::Input, "threads.forked", text))
}

/// Refines on the calling thread: the function of the sizes is asked there, and nowhere else.
fn with_function(
    py: Python<'_>,
    ready: &Ready,
    wishes: &Wishes,
    function: &Py<PyAny>,
    tell: Option<&Py<PyAny>>,
) -> Result<Refined, Failure> {
    forked()?;
    let reins = Reins::default();
    let asked = Function::new(function, ready.offset(), &reins, tell);
    let graded = ready.graded(wishes)?;
    let refined = py.detach(|| {
        let field = |p| graded.as_ref().map_or(f64::INFINITY, |own| own.at(p)).min(asked.at(p));
        unpanicked(|| Ok(ready.refine(wishes, Some(&field), true, &asked, &reins.cancel)?))
    });
    asked.raised().map_or(refined, Err)
}
