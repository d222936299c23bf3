//! Meshes of domains.

use crate::Field;
use crate::body::Body;
use crate::certificate::{self, CheckedDomain, Excused, Order};
use crate::failure::{Class, Failure};
use crate::result::{Meshed, Outcome};
use crate::wishes::{SizeAt, Wishes};
use ltbw::domain::{Domain, FEATURE_ANGLE, Facet, LARGEST_FEATURE_ANGLE, Parts};
use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::io::{self, DomainFile, GroupName};
use ltbw::refine::{Background, ExcusedShare, Given, RefineOutcome, Refined, Refiner};
use ltbw::refine::{Sizes, SizesError};
use ltbw::{CancelToken, Observer, Point, TetMesh};
use std::path::PathBuf;

/// Where the domain comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A file.
    File(PathBuf),
    /// Vertices and polygons.
    Arrays {
        /// Coordinates.
        vertices: Vec<Point>,
        /// Corners of all polygons, one after the other.
        corners: Vec<i64>,
        /// The place among `corners` where each polygon begins.
        starts: Vec<usize>,
        /// A marker for each polygon; 0 where there are none.
        markers: Vec<i32>,
    },
}

impl Source {
    /// The domain as a file would have it: arrays are an oriented surface.
    fn read(self) -> Result<DomainFile, Failure> {
        let (vertices, corners, starts, markers) = match self {
            Self::File(path) => return Ok(io::read_domain(&path)?),
            Self::Arrays { vertices, corners, starts, markers } => {
                (vertices, corners, starts, markers)
            }
        };
        let mut facets = Vec::with_capacity(starts.len());
        for (f, &start) in starts.iter().enumerate() {
            let end = starts.get(f + 1).copied().unwrap_or(corners.len());
            let named = corners.get(start..end).unwrap_or_default();
            let vertex =
                |&v: &i64| u32::try_from(v).ok().filter(|&v| (v as usize) < vertices.len());
            let polygon: Option<Vec<u32>> = named.iter().map(vertex).collect();
            let Some(polygon) = polygon else {
                let text = format!("face {f} names a vertex that is not there: {named:?}");
                return Err(Failure::new(Class::Input, "faces.index", text).with([f as u32]));
            };
            facets.push(Facet::polygon(&polygon, markers.get(f).copied().unwrap_or(0)));
        }
        let domain = Domain { vertices, facets, ..Domain::default() };
        Ok(DomainFile { domain, oriented: true, ..DomainFile::default() })
    }
}

/// A domain ready to be meshed.
#[derive(Debug)]
pub struct Ready {
    prepared: Prepared,
    flat_tolerance: f64,
    excused_share: f64,
    /// The smooth parts of a surface without markers.
    parts: Option<Parts>,
    names: Vec<GroupName>,
    notes: Vec<String>,
}

impl Ready {
    /// Reads, snaps, repairs and checks a domain.
    ///
    /// # Errors
    /// Why it cannot be meshed.
    pub fn new(source: Source, wishes: &Wishes) -> Result<Self, Failure> {
        let mut file = source.read()?;
        file.domain.regions.extend(&wishes.regions);
        file.domain.points.extend_from_slice(&wishes.points);
        let mut options = PrepareOptions {
            exact_input: wishes.exact_input,
            repair: wishes.repair,
            frame: wishes.frame,
            oriented: file.oriented,
            nested_voids: false,
            strict: wishes.strict,
            simplify: wishes.simplify,
            fill: wishes.fill,
        };
        wishes.holes.apply(&mut file.domain, &mut options);
        let excused_share =
            ExcusedShare::limit(wishes.excused_share.unwrap_or(ExcusedShare::USUAL))?;
        let prepared = file.domain.prepare(&options)?;
        let usual = || file.flat_tolerance(&prepared, &options);
        let flat_tolerance = wishes.flat_tolerance.unwrap_or_else(usual);
        let parts = file.smooth_parts(&prepared, feature_angle(wishes)?, flat_tolerance);
        let mut names = file.names;
        names.extend(parts.iter().flat_map(|parts| &parts.list).map(|part| GroupName {
            dimension: 2,
            group: i64::from(part.marker),
            name: format!("part {}", part.marker),
        }));
        let mut notes = file.notes;
        notes.extend(prepared.notes());
        notes.extend(prepared.given().map(|text| format!("given: {text}")));
        notes.extend(prepared.simplified.iter().map(|told| format!("simplified: {}", told.note())));
        let offset = prepared.lattice.offset();
        if offset != [0.0; 3] {
            notes.push(format!("coordinates are relative to {offset:?}"));
        }
        Ok(Self { prepared, flat_tolerance, excused_share, parts, names, notes })
    }

    /// The place that its coordinates are relative to.
    #[must_use]
    pub fn offset(&self) -> Point {
        self.prepared.lattice.offset()
    }

    /// Edge lengths near places, at parts and by curvature, if some are asked for.
    ///
    /// # Errors
    /// Lengths, radii, factors and parts that make no sense.
    pub fn graded(&self, wishes: &Wishes) -> Result<Option<Sizes>, Failure> {
        let somewhere = !wishes.near.is_empty() || !wishes.size_at.is_empty();
        if !somewhere && wishes.curvature.is_none() {
            return Ok(None);
        }
        let wrong = |code: &'static str, error: &SizesError| {
            let name = code.split('.').next().unwrap_or_default();
            Failure::new(Class::Input, code, format!("{name}: {error}"))
        };
        let mut sizes = Sizes::new(&self.prepared);
        if let Some(growth) = wishes.growth {
            sizes = sizes.growth(growth).map_err(|e| wrong("growth.value", &e))?;
        }
        for near in &wishes.near {
            let added = sizes.near(near.at, near.length, near.radius);
            sizes = added.map_err(|e| wrong("near.value", &e))?;
        }
        let domain = &self.prepared.domain;
        for SizeAt { part, length } in &wishes.size_at {
            let own = |n: &&GroupName| n.dimension == 2 && n.name == *part;
            let named = self.names.iter().find(own).map(|n| n.group);
            let marker = named.or_else(|| part.parse().ok());
            let is_meant = |f: usize| {
                let own =
                    self.parts.as_ref().map_or(&domain.facets[f].marker, |all| &all.markers[f]);
                marker == Some(i64::from(*own))
            };
            let added = sizes.at_facets(domain, is_meant, *length);
            sizes = added.map_err(|e| wrong("size_at.value", &e))?;
        }
        if let Some(per_turn) = wishes.curvature {
            let smooth = || Parts::smooth(&self.prepared, FEATURE_ANGLE, self.flat_tolerance);
            let parts = self.parts.clone().unwrap_or_else(smooth);
            let curved = sizes.curved(domain, &parts, per_turn);
            sizes = curved.map_err(|e| wrong("curvature.value", &e))?;
        }
        Ok(Some(sizes))
    }

    /// Edge lengths at the vertices of the source.
    ///
    /// # Errors
    /// Sizes that are no lengths, or not as many as vertices.
    pub fn sizes(&self, sizes: &[f64]) -> Result<Box<Field<'static>>, Failure> {
        let background = Background::at_vertices(&self.prepared, sizes)?;
        Ok(Box::new(move |p| background.at(p)))
    }

    /// Edge lengths at the points of a mesh in the source's coordinates, linear in between.
    ///
    /// # Errors
    /// Sizes that are no lengths, or not as many as points; a mesh that names none of its points.
    pub fn sizes_on(
        &self,
        points: Vec<Point>,
        tets: Vec<[u32; 4]>,
        sizes: &[f64],
    ) -> Result<Box<Field<'static>>, Failure> {
        let mesh = TetMesh { points, tets, ..TetMesh::default() };
        let (background, offset) = (Background::new(&mesh, sizes)?, self.offset());
        Ok(Box::new(move |p| background.at([0, 1, 2].map(|k| p[k] + offset[k]))))
    }

    /// Refines, with a sizing field or without. The observer is called by this thread, and so is
    /// the field if `here`.
    ///
    /// # Errors
    /// Bounds that no mesh can meet; work cancelled before there is a mesh.
    pub fn refine(
        &self,
        wishes: &Wishes,
        field: Option<&Field<'_>>,
        here: bool,
        observer: &dyn Observer,
        cancel: &CancelToken,
    ) -> Result<Refined, Failure> {
        let refiner = match wishes.radius_edge {
            Some(bound) => Refiner::new().radius_edge(bound),
            None => Refiner::new().any_shape(),
        };
        let refiner = match wishes.min_dihedral {
            Some(degrees) => refiner.min_dihedral(degrees),
            None => refiner,
        };
        let refiner = refiner.flat_tolerance(self.flat_tolerance).smooth(wishes.smooth);
        let mut refiner = refiner.observer(observer).cancel(cancel);
        if let Some(bound) = wishes.max_volume {
            refiner = refiner.max_volume(bound);
        }
        if wishes.count_angles {
            refiner = refiner.count_angles();
        }
        if let Some(bound) = wishes.max_edge {
            refiner = refiner.max_edge(bound);
        }
        if let Some(count) = wishes.max_points {
            refiner = refiner.max_points(count);
        }
        if let Some(field) = field {
            refiner = refiner.sizing(field);
        }
        if here {
            refiner = refiner.one_thread();
        }
        Ok(refiner.refine(&self.prepared.domain, &self.prepared.lattice)?)
    }

    /// Checks anybody's mesh of the domain, without exterior, by independent code: structure,
    /// Delaunay property, conformity, volume, and the bounds of `wishes`.
    #[must_use]
    pub fn check(
        &self,
        points: &[Point],
        tets: &[[u32; 4]],
        order: Order,
        wishes: &Wishes,
    ) -> CheckedDomain {
        let (points, tets) = (points.to_vec(), tets.to_vec());
        let mesh = TetMesh { points, tets, ..TetMesh::default() };
        certificate::of_domain(&self.prepared, &mesh, order, wishes, self.flat_tolerance)
    }

    /// Checks the mesh.
    ///
    /// # Errors
    /// A boundary that is not in the mesh; a mesh that is not what was asked for.
    pub fn finish(self, wishes: &Wishes, refined: Refined) -> Result<Meshed, Failure> {
        let outcome = match refined.outcome {
            RefineOutcome::Met => Outcome::Met,
            RefineOutcome::Excused => Outcome::Excused,
            RefineOutcome::Budget => Outcome::Budget,
            RefineOutcome::Cancelled => Outcome::Cancelled,
            RefineOutcome::Unrecovered => return Err(unrecovered(&refined)),
        };
        let flat_tolerance = refined.stats.flat_tolerance;
        let excused = Excused {
            tets: refined.excuses.iter().filter_map(|e| refined.tet(e.tet)).collect(),
            share: refined.excused_share(),
            limit: self.excused_share,
        };
        let refined = match self.parts {
            Some(parts) => refined.with_markers(parts.markers),
            None => refined,
        };
        let mut meshed = Meshed::new(Body::Domain(Box::new(refined)), outcome);
        if !wishes.unchecked && outcome != Outcome::Cancelled {
            let plain = meshed.plain();
            let own = certificate::own(&self.prepared, &plain, wishes, flat_tolerance, &excused);
            meshed.certificate = Some(own?);
        }
        (meshed.names, meshed.notes) = (self.names, self.notes);
        Ok(meshed)
    }
}

/// The feature angle that is asked for.
fn feature_angle(wishes: &Wishes) -> Result<Option<f64>, Failure> {
    let angle = wishes.feature_angle;
    if angle.is_none_or(|angle| (0.0..=LARGEST_FEATURE_ANGLE).contains(&angle)) {
        return Ok(angle);
    }
    let text = format!("feature_angle: 0 to {LARGEST_FEATURE_ANGLE} degrees, not {angle:?}");
    Err(Failure::new(Class::Input, "feature_angle.value", text))
}

/// Why some of the boundary is not in the mesh.
fn unrecovered(refined: &Refined) -> Failure {
    let place = |(item, reason): &(ltbw::refine::Item, ltbw::refine::Reason)| {
        let (kind, at) = (item.kind(), refined.middle(item));
        format!("{kind} at {at:?}: {reason}")
    };
    let first: Vec<String> = refined.lost.iter().take(5).map(place).collect();
    let (count, first) = (refined.lost.len(), first.join("; "));
    let text = format!("{count} items of the boundary could not be brought into the mesh; {first}");
    Failure::new(Class::Recovery, "refine.unrecovered", text)
}
