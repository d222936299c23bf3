//! Certificates of anybody's meshes, and of our own against their domains.

use crate::failure::{Class, Failure};
use crate::wishes::Wishes;
use crate::work::in_own_pool;
use ltbw::domain::{Domain, Prepared};
use ltbw::quality::Quality;
use ltbw::refine::{ExcusedShare, Verdict};
use ltbw::{Point, TetMesh};
use ltbw_verify::{self as verify, Conformity, ConformityDefect, Limits, Plc, PlcFacet, Report};
use serde_json::{Value, json};
use std::collections::HashSet;

/// Breaches that a certificate lists.
const LISTED: usize = 100;

/// The meaning of the order of a tetrahedron's corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// All have the same handedness.
    Oriented,
    /// It means nothing.
    Any,
}

impl Order {
    fn for_checker(self) -> verify::VertexOrder {
        match self {
            Self::Any => verify::VertexOrder::Any,
            Self::Oriented => verify::VertexOrder::Oriented,
        }
    }
}

/// A mesh as it was found as one of finite elements.
#[derive(Clone, Debug)]
pub struct CheckedMesh {
    /// JSON `ltbw.cert/1`.
    pub certificate: String,
    /// Its quality, if it has tetrahedra.
    pub quality: Option<Quality>,
}

/// A mesh of a domain as it was found.
#[derive(Clone, Debug)]
pub struct CheckedDomain {
    /// Is it as the domain, and the bounds asked for, have it?
    pub passed: bool,
    /// JSON `ltbw.conformity/1`.
    pub certificate: String,
}

/// Checks anybody's mesh as one of finite elements, with `delaunay` also as the Delaunay mesh of
/// its vertices, as the program does.
///
/// # Errors
/// A certificate that is no JSON.
pub fn check(
    points: &[Point],
    tets: &[[u32; 4]],
    order: Order,
    all_points: bool,
    delaunay: bool,
) -> Result<CheckedMesh, Failure> {
    let vertex_order = order.for_checker();
    let options = verify::Options { vertex_order, all_points, ..verify::Options::default() };
    in_own_pool(|| {
        let report = verify::check_elements(&verify::Mesh::new(points, tets), &options, delaunay);
        Ok(CheckedMesh { certificate: json(&report)?, quality: Quality::of(points, tets) })
    })
}

pub(crate) fn json(report: &Report) -> Result<String, Failure> {
    let text = report.certificate().to_json();
    text.map_err(|e| Failure::new(Class::Internal, "internal.json", e))
}

/// A domain as the checker takes it.
fn plc_of(domain: &Domain, flat_tolerance: f64) -> Plc {
    let facet = |f: &ltbw::domain::Facet| PlcFacet {
        polygons: f.polygons.clone(),
        holes: f.holes.clone(),
        marker: f.marker,
    };
    Plc {
        flat_tolerance,
        vertices: domain.vertices.iter().chain(&domain.points).copied().collect(),
        facets: domain.facets.iter().map(facet).collect(),
        segments: domain.segments.iter().map(|(ends, _)| *ends).collect(),
        holes: domain.holes.clone(),
        regions: domain.regions.iter().map(|r| r.seed).collect(),
    }
}

/// The findings on a mesh of a domain, and whether it has the domain's volume.
fn conformity(
    ready: &Prepared,
    mesh: &TetMesh,
    wishes: &Wishes,
    flat_tolerance: f64,
    options: &verify::Options,
) -> (Conformity, bool) {
    let Wishes { radius_edge, max_volume, max_edge, .. } = *wishes;
    let region_volumes = ready.domain.regions.iter().map(|r| r.max_volume).collect();
    let limits = Limits { radius_edge, max_volume, max_edge, region_volumes, min_dihedral: None };
    let (plc, tags) = (plc_of(ready.judged(), flat_tolerance), mesh.tet_tags.as_deref());
    let given = verify::Mesh::new(&mesh.points, &mesh.tets);
    let found = verify::conforms(&given, &plc, tags, &limits, options);
    // Patches within a tolerance change the volume by as much as they say.
    let same = match (ready.report.volume(), &found.volume) {
        (Some(a), Some(b)) if found.patches == 0 => a.to_string() == b.to_string(),
        (Some(a), Some(b)) => {
            b.difference(&a.to_string()).is_some_and(|d| d <= found.volume_within)
        }
        _ => true,
    };
    (found, same)
}

/// Checks anybody's mesh of a domain, without exterior.
pub(crate) fn of_domain(
    ready: &Prepared,
    mesh: &TetMesh,
    order: Order,
    wishes: &Wishes,
    flat_tolerance: f64,
) -> CheckedDomain {
    let options =
        verify::Options { vertex_order: order.for_checker(), ..verify::Options::default() };
    let (found, same) = conformity(ready, mesh, wishes, flat_tolerance, &options);
    let passed = same && found.passed();
    let verdict = if passed { Verdict::Passed } else { Verdict::Failed };
    CheckedDomain { passed, certificate: json_of(&found, verdict).to_string() }
}

/// The excused tetrahedra of a mesh.
pub(crate) struct Excused {
    /// Their corners.
    pub(crate) tets: HashSet<[u32; 4]>,
    /// Their share of the mesh.
    pub(crate) share: ExcusedShare,
    /// The share that may be.
    pub(crate) limit: f64,
}

/// The certificate of a domain's own mesh.
///
/// # Errors
/// Breaches that no excuse explains: a defect of ours.
pub(crate) fn own(
    ready: &Prepared,
    mesh: &TetMesh,
    wishes: &Wishes,
    flat_tolerance: f64,
    excused: &Excused,
) -> Result<String, Failure> {
    let options = verify::Options::default();
    // A tetrahedron that is not listed cannot be told to be excused.
    let max_defects = options.max_defects.max(excused.tets.len());
    let options = verify::Options { max_defects, numbered_regions: true, ..options };
    let (found, same) = conformity(ready, mesh, wishes, flat_tolerance, &options);
    let explained = same && is_explained(&found, &mesh.tets, &excused.tets);
    let passed = same && found.passed();
    let verdict = Verdict::of(passed, explained, &excused.share, excused.limit);
    let text = json_of(&found, verdict).to_string();
    if explained {
        return Ok(text);
    }
    let message = format!("a defect of ltbw: the mesh is not what was asked for: {text}");
    Err(Failure::new(Class::Internal, "internal.mesh", message))
}

/// Is every finding a bound that a tetrahedron with an excuse exceeds?
fn is_explained(found: &Conformity, tets: &[[u32; 4]], excused: &HashSet<[u32; 4]>) -> bool {
    let is_excused = |&t: &u32| tets.get(t as usize).is_some_and(|tet| excused.contains(tet));
    found.mesh_defect_count == 0
        && found.counts.iter().all(|(&breach, &count)| {
            let listed = found.findings.iter().filter(|f| f.breach == breach);
            matches!(
                breach,
                ConformityDefect::RatioExceeded
                    | ConformityDefect::VolumeExceeded
                    | ConformityDefect::EdgeExceeded
            ) && listed.clone().count() as u64 == count
                && listed.clone().all(|f| f.ids.first().is_some_and(is_excused))
        })
}

/// A certificate of conformity.
fn json_of(found: &Conformity, verdict: Verdict) -> Value {
    let counts: Vec<Value> = found
        .counts
        .iter()
        .map(|(breach, count)| json!({ "breach": breach, "count": count }))
        .collect();
    json!({
        "schema": "ltbw.conformity/1",
        "passed": verdict == Verdict::Passed,
        "verdict": verdict.name(),
        "volume": found.volume.as_ref().map(ToString::to_string),
        "tets": found.tets,
        "subfaces": found.subfaces,
        "cells": found.cells,
        "patches": found.patches,
        "volume_within": found.volume_within,
        "breach_counts": counts,
        "breaches": found.findings.iter().take(LISTED).collect::<Vec<_>>(),
        "mesh_defect_count": found.mesh_defect_count,
        "defects": found.mesh_defects,
    })
}
