//! The glue to the checker's test of conformity: `check --plc`, and the check of our own meshes.

use crate::angles;
use crate::args::Check;
use crate::bounds::Asked;
use crate::console;
use crate::json::{check_report, write_json};
use crate::outcome::{Exit, Failure};
use crate::plc::plc_of;
use crate::progress::Stage;
use crate::streams::{Formats, Source};
use ltbw::domain::Prepared;
use ltbw::quality::Quality;
use ltbw::refine::{RefineOutcome, Refined, Verdict};
use ltbw::{TetMesh, io};
use ltbw_verify as verify;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use verify::{Conformity, ConformityDefect, Finding, Limits};

/// Breaches that people are shown.
const SHOWN: usize = 10;

/// `ltbw check MESH --plc DOMAIN`.
pub(crate) fn check(
    args: &Check,
    mesh: &Source,
    plc: &Path,
    formats: Formats,
) -> Result<Exit, Failure> {
    let domain = formats.input(plc)?;
    args.preparation.check(&[&args.mesh, plc])?;
    if let Some(json) = &args.json {
        let mut inputs = [io::mesh_files(&args.mesh), io::domain_files(plc)].concat();
        inputs.extend(args.preparation.points.clone());
        check_report(json, &inputs, args.preparation.write_defects.as_ref())?;
    }
    let stage = Stage::begin("read");
    let file = mesh.mesh()?;
    drop(stage);
    let name = mesh.show();
    file.notes.iter().for_each(|n| console::people(&format!("note: {name}: {n}")));
    let stage = Stage::begin("prepare");
    let (ready, flat_tolerance) = args.preparation.prepare(&domain)?;
    drop(stage);
    let stage = Stage::begin("check");
    let inside = without_exterior(&file.mesh);
    let limits = Limits {
        radius_edge: args.radius_edge,
        max_volume: args.max_volume,
        max_edge: args.max_edge,
        region_volumes: ready.domain.regions.iter().map(|r| r.max_volume).collect(),
        min_dihedral: args.min_dihedral,
    };
    let order = match args.any_order {
        true => verify::VertexOrder::Any,
        false => verify::VertexOrder::Oriented,
    };
    let options = verify::Options { vertex_order: order, ..verify::Options::default() };
    let mesh = verify::Mesh::new(&inside.points, &inside.tets);
    let tags = inside.tet_tags.as_deref();
    let complex = plc_of(ready.judged(), flat_tolerance);
    let mut found = verify::conforms(&mesh, &complex, tags, &limits, &options);
    let same = same_volume(&ready, &found);
    let word = if found.passed() && same { Verdict::Passed } else { Verdict::Failed };
    drop(stage);
    if let Some(path) = &args.json {
        let text = serde_json::to_string_pretty(&certificate(&found, same, word))
            .map_err(|e| Failure::Other(e.to_string()))?;
        write_json(path, &(text + "\n"))?;
    }
    print(&mut found);
    let small = found.below_dihedral.as_ref();
    if let Some(small) = small {
        console::people(&angles::line(small, &inside));
        let quality = Quality::of(&inside.points, &inside.tets);
        let angles = quality.map(|quality| angles::by_smallest(&quality.least_angles));
        angles.iter().for_each(|line| console::people(line));
    }
    if word == Verdict::Passed {
        console::people(&format!("checked   {}", summary(&found)));
        let failure = small.and_then(angles::failure);
        failure.iter().for_each(|why| console::people(&format!("ltbw: {name}: {why}")));
        return Ok(if failure.is_some() { Exit::Defect } else { Exit::Done });
    }
    if !same {
        console::people("defect    the mesh has not the volume of the domain");
    }
    console::people(&format!("ltbw: {name}: does not conform to {}", domain.show()));
    Ok(Exit::Defect)
}

/// The degrees below which slivers were looked for, if they were.
fn looked_for(refined: &Refined) -> Option<f64> {
    let degrees = refined.stats.min_dihedral;
    (degrees > 0.0 && refined.outcome != RefineOutcome::Cancelled).then_some(degrees)
}

/// Are the slivers that are told as many as the checker counts? If not, people hear of it.
pub(crate) fn tells_all_slivers(told: usize, found: &Conformity) -> bool {
    let all_told = found.below_dihedral.as_ref().is_none_or(|small| small.count == told as u64);
    if !all_told {
        console::people("defect    other tetrahedra have small dihedral angles than those told");
    }
    all_told
}

/// The limits that our own mesh has to keep, where slivers below some degrees were looked for.
pub(crate) fn own_limits(ready: &Prepared, asked: Asked, min_dihedral: Option<f64>) -> Limits {
    Limits {
        radius_edge: asked.radius_edge,
        max_volume: asked.max_volume,
        max_edge: asked.max_edge,
        region_volumes: ready.domain.regions.iter().map(|r| r.max_volume).collect(),
        min_dihedral,
    }
}

/// Checks the mesh; lists as many breaches of each kind as there are excuses, or more.
pub(crate) fn check_own(
    inside: &TetMesh,
    ready: &Prepared,
    asked: Asked,
    refined: &Refined,
    excuses: usize,
) -> Conformity {
    let limits = own_limits(ready, asked, looked_for(refined));
    let mesh = verify::Mesh::new(&inside.points, &inside.tets);
    let plc = plc_of(ready.judged(), refined.stats.flat_tolerance);
    let tags = inside.tet_tags.as_deref();
    let options = verify::Options::default();
    let max_defects = options.max_defects.max(excuses);
    let options = verify::Options { max_defects, numbered_regions: true, ..options };
    verify::conforms(&mesh, &plc, tags, &limits, &options)
}

/// The tetrahedra whose tag is not 0, or without tags the attribute, if some of them are not 0.
pub(crate) fn without_exterior(mesh: &TetMesh) -> TetMesh {
    let tags = mesh.tet_tags.as_ref();
    let attributes = mesh.tet_attributes.as_ref().filter(|_| tags.is_none());
    let is_outside = |t: usize| {
        tags.and_then(|tags| tags.get(t)).is_some_and(|&tag| tag == 0)
            || attributes.and_then(|all| all.get(t)).is_some_and(|&value| value == 0.0)
    };
    let kept: Vec<usize> = (0..mesh.tets.len()).filter(|&t| !is_outside(t)).collect();
    if kept.is_empty() {
        return mesh.clone();
    }
    TetMesh {
        points: mesh.points.clone(),
        tets: kept.iter().map(|&t| mesh.tets[t]).collect(),
        tet_tags: tags.map(|tags| kept.iter().filter_map(|&t| tags.get(t).copied()).collect()),
        ..TetMesh::default()
    }
}

/// Has the mesh the exact volume that the check of the domain computed from its facets, or one that
/// differs from it by no more than its patches allow? That is the kernel's own check, not the
/// checker's; a domain whose volume is not known passes.
pub(crate) fn same_volume(ready: &Prepared, found: &Conformity) -> bool {
    match (ready.report.volume(), &found.volume) {
        (Some(a), Some(b)) if found.patches == 0 => a.to_string() == b.to_string(),
        (Some(a), Some(b)) => {
            b.difference(&a.to_string()).is_some_and(|d| d <= found.volume_within)
        }
        _ => true,
    }
}

/// Shows the first breaches and defects.
pub(crate) fn print(found: &mut Conformity) {
    for defect in found.mesh_defects.iter().take(SHOWN) {
        console::people(&format!("defect    {defect}"));
    }
    for finding in found.findings.iter().take(SHOWN) {
        console::people(&format!("defect    {finding}"));
    }
    let all = found.mesh_defect_count + found.counts.values().sum::<u64>();
    let listed = found.mesh_defects.len().min(SHOWN) + found.findings.len().min(SHOWN);
    if let Some(more) = all.checked_sub(listed as u64).filter(|&more| more > 0) {
        console::people(&format!("          and {more} more"));
    }
}

/// The findings, in a line.
pub(crate) fn summary(found: &Conformity) -> String {
    let volume = found.volume.as_ref().map(ToString::to_string).unwrap_or_default();
    let volume = if volume.len() <= 40 { format!(", volume {volume}") } else { String::new() };
    let within = match found.patches {
        0 => String::new(),
        n => format!(", {n} patches, volume within {:.3e}", found.volume_within),
    };
    format!(
        "structure, orientation, delaunay, conformity, bounds: no defect ({} subfaces, \
         {} cells{within}{volume}; {} tests by filter, {} exactly)",
        found.subfaces, found.cells, found.tests.0, found.tests.1
    )
}

/// Breaches of each kind that the certificate lists.
const LISTED: usize = 100;

/// The certificate of conformity as JSON.
pub(crate) fn certificate(found: &Conformity, same_volume: bool, verdict: Verdict) -> Value {
    let mut listed: BTreeMap<ConformityDefect, usize> = BTreeMap::new();
    let mut is_listed = |breach: ConformityDefect| {
        let count = listed.entry(breach).or_default();
        *count += 1;
        *count <= LISTED
    };
    let breaches: Vec<&Finding> = found.findings.iter().filter(|f| is_listed(f.breach)).collect();
    let counts: Vec<Value> = found
        .counts
        .iter()
        .map(|(breach, count)| json!({ "breach": breach, "count": count }))
        .collect();
    let mut certificate = json!({
        "schema": "ltbw.conformity/1",
        "checker": concat!("ltbw-verify ", env!("CARGO_PKG_VERSION")),
        "passed": verdict == Verdict::Passed,
        "verdict": verdict.name(),
        "volume": found.volume.as_ref().map(ToString::to_string),
        "volume_is_the_domains": same_volume,
        "patches": found.patches,
        "volume_within": found.volume_within,
        "tets": found.tets,
        "subfaces": found.subfaces,
        "cells": found.cells,
        "tests": { "filter": found.tests.0, "exact": found.tests.1 },
        "breach_counts": counts,
        "breaches": breaches,
        "mesh_defect_count": found.mesh_defect_count,
        "mesh_defects": found.mesh_defects,
    });
    if let Some(parts) = found.parts {
        certificate["parts"] = json!(parts);
    }
    if let Some(small) = &found.below_dihedral {
        certificate["below_dihedral"] = json!(small);
    }
    certificate
}
