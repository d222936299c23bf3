//! Certificates of anybody's meshes.

use crate::arrays::{Coordinates, points};
use crate::failure::{Class, Failure};
use crate::supervise::supervised;
use ltbw::canonical_hash;
use ltbw::domain::{Domain, Prepared};
use ltbw_verify::{self as verify, Conformity, Limits, Plc, PlcFacet};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use serde_json::{Value, json};

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
    Ok(supervised(py, None, |_| {
        let vertex_order = match any_order {
            true => verify::VertexOrder::Any,
            false => verify::VertexOrder::Oriented,
        };
        let options = verify::Options { vertex_order, all_points, ..verify::Options::default() };
        let report = verify::check(&verify::Mesh::new(&points, &tets), &options);
        let text = report.certificate().to_json();
        text.map_err(|e| Failure::new(Class::Internal, "internal.json", e))
    })?)
}

/// The canonical hash `ltbw.mesh/1`.
#[pyfunction]
pub(crate) fn mesh_hash(
    py: Python<'_>,
    coordinates: Coordinates<'_>,
    simplices: Corners<'_>,
) -> PyResult<String> {
    let (points, tets) = (points(&coordinates)?, tets(&simplices)?);
    Ok(supervised(py, None, |_| Ok(canonical_hash(&points, &tets)?.to_string()))?)
}

/// A domain as the checker takes it.
pub(crate) fn plc_of(domain: &Domain) -> Plc {
    let facet =
        |f: &ltbw::domain::Facet| PlcFacet { polygons: f.polygons.clone(), holes: f.holes.clone() };
    Plc {
        vertices: domain.vertices.clone(),
        facets: domain.facets.iter().map(facet).collect(),
        segments: domain.segments.iter().map(|(ends, _)| *ends).collect(),
        holes: domain.holes.clone(),
        regions: domain.regions.iter().map(|r| r.seed).collect(),
    }
}

/// Checks a mesh against a domain.
pub(crate) fn conformity(
    ready: &Prepared,
    points: &[ltbw::Point],
    tets: &[[u32; 4]],
    tags: Option<&[i64]>,
    bounds: (Option<f64>, Option<f64>),
    listed: usize,
) -> Conformity {
    let limits = Limits {
        radius_edge: bounds.0,
        max_volume: bounds.1,
        region_volumes: ready.domain.regions.iter().map(|r| r.max_volume).collect(),
    };
    let options = verify::Options::default();
    let options = verify::Options { max_defects: options.max_defects.max(listed), ..options };
    verify::conforms(
        &verify::Mesh::new(points, tets),
        &plc_of(&ready.domain),
        tags,
        &limits,
        &options,
    )
}

/// A certificate of conformity as JSON.
pub(crate) fn json_of(found: &Conformity, passed: bool) -> Value {
    let counts: Vec<Value> = found
        .counts
        .iter()
        .map(|(breach, count)| json!({ "breach": breach, "count": count }))
        .collect();
    json!({
        "schema": "ltbw.conformity/1",
        "passed": passed,
        "volume": found.volume.as_ref().map(ToString::to_string),
        "tets": found.tets,
        "subfaces": found.subfaces,
        "cells": found.cells,
        "breach_counts": counts,
        "breaches": found.findings.iter().take(100).collect::<Vec<_>>(),
        "mesh_defect_count": found.mesh_defect_count,
        "defects": found.mesh_defects,
    })
}
