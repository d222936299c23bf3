//! The JSON report `ltbw.report/1`, as `docs/schema/report.json` has it. A field that exists is
//! never renamed in this version.

use crate::console;
use crate::json::write_json;
use crate::outcome::{Failure, seconds};
use crate::picture::angles::Slivers;
use ltbw::PredicateStats;
use ltbw::quality::{Extreme, Histogram, LeastAngles, Quality, SMALL_ANGLES};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;

/// The report of a run.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    /// Name and version of the schema.
    pub(crate) schema: &'static str,
    /// The command: `delaunay`, `demo` or `mesh`.
    pub(crate) command: &'static str,
    /// The points.
    pub(crate) input: Input,
    /// The mesh.
    pub(crate) mesh: MeshPart,
    /// Exact predicates.
    pub(crate) predicates: Predicates,
    /// Wall time.
    pub(crate) seconds: Seconds,
    /// Threads for ordering, checking, hashing and output, and workers if they are several.
    pub(crate) threads: usize,
    /// The most memory that the process held, where the system tells.
    pub(crate) peak_rss_bytes: Option<u64>,
    /// `complete`, `cancelled` or `budget`; of a domain `met`, `excused`, `budget` or `cancelled`.
    pub(crate) outcome: &'static str,
    /// The figures of refinement, of a domain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) refinement: Option<Value>,
    /// Histograms and extremes, of a domain's mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) quality: Option<Value>,
    /// The certificate `ltbw.cert/1`, if the mesh was checked.
    pub(crate) certificate: Option<Value>,
    /// Mesh files written.
    pub(crate) outputs: Vec<String>,
    /// Figures of each worker of the parallel kernel; none if one thread inserted.
    pub(crate) workers: Vec<ltbw::threads::WorkerStats>,
    /// The share of workers in a refinement in rounds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) share: Option<crate::workers::Share>,
    /// The times and the memory of the processes of a job that keep their parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) ranks: Option<Value>,
    /// The moves of the cuts between workers' parts of a domain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) redeals: Option<crate::workers::Redeals>,
    /// The figures of the workers' time, in nanoseconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) parallel: Option<crate::figures::Figures>,
}

impl Report {
    pub(crate) const SCHEMA: &'static str = "ltbw.report/1";

    /// The report as JSON text.
    pub(crate) fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}

/// The seconds of a stage.
pub(crate) struct Spent {
    pub(crate) stage: &'static str,
    pub(crate) time: f64,
}

/// A report, and the file for it.
pub(crate) struct Written<'a> {
    pub(crate) path: &'a Path,
    pub(crate) text: serde_json::Result<String>,
}

/// Ends a command: tells the seconds in all and of its stages, writes the report to its file and
/// prints the mesh's hash.
pub(crate) fn end(
    total: f64,
    stages: &[Spent],
    report: Option<Written<'_>>,
    hash: Option<&String>,
) -> Result<(), Failure> {
    let stages = stages.iter().map(|spent| format!("{} {}", spent.stage, seconds(spent.time)));
    let stages: Vec<String> = stages.collect();
    console::people(&format!("seconds   {}: {}", seconds(total), stages.join(", ")));
    if let Some(Written { path, text }) = report {
        write_json(path, &text.map_err(|e| Failure::Other(e.to_string()))?)?;
    }
    hash.map_or(Ok(()), |hash| console::data(&format!("ltbw.mesh/1 {hash}\n")))
}

/// The points of a run.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Input {
    /// Points in the file.
    pub(crate) points: usize,
    /// Distinct points that were meshed.
    pub(crate) distinct: usize,
    /// Points that lie where an earlier one does.
    pub(crate) duplicates: usize,
    /// For each duplicate its index and that of the point kept in its place.
    pub(crate) duplicate_of: Vec<(u32, u32)>,
}

/// The mesh of a run.
#[derive(Debug, Default, Serialize)]
pub(crate) struct MeshPart {
    /// Vertices.
    pub(crate) vertices: usize,
    /// Tetrahedra.
    pub(crate) tets: usize,
    /// Triangles of the hull.
    pub(crate) hull_faces: usize,
    /// Canonical hash `ltbw.mesh/1`.
    pub(crate) hash: Option<String>,
}

/// The numbers of predicate calls, by how they were decided.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Predicates {
    pub(crate) orient3d: Orient3d,
    pub(crate) insphere: Insphere,
}

impl From<&PredicateStats> for Predicates {
    fn from(stats: &PredicateStats) -> Self {
        Self {
            orient3d: Orient3d { calls: stats.orient3d_calls, exact: stats.orient3d_exact },
            insphere: Insphere {
                calls: stats.insphere_calls,
                exact: stats.insphere_exact,
                perturbed: stats.insphere_perturbed,
            },
        }
    }
}

/// Calls of `orient3d`.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Orient3d {
    /// All calls.
    pub(crate) calls: u64,
    /// Calls that no filter decided.
    pub(crate) exact: u64,
}

/// Calls of `insphere`.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Insphere {
    /// All calls.
    pub(crate) calls: u64,
    /// Calls that no filter decided.
    pub(crate) exact: u64,
    /// Calls that were exactly zero: ties, decided by the symbolic perturbation.
    pub(crate) perturbed: u64,
}

/// Wall time in seconds; 0 for what was not done.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) read: f64,
    pub(crate) order: f64,
    pub(crate) insert: f64,
    pub(crate) refine: f64,
    pub(crate) check: f64,
    pub(crate) hash: f64,
    pub(crate) write: f64,
    pub(crate) total: f64,
}

/// The quality of a mesh, and what was made of its slivers.
pub(crate) struct Measured {
    pub(crate) quality: Quality,
    pub(crate) slivers: Slivers,
}

impl Measured {
    /// A mesh whose slivers nobody has split.
    pub(crate) fn plain(quality: Quality) -> Self {
        Self { quality, slivers: Slivers::default() }
    }
}

/// Histograms and extremes of a mesh, as JSON.
pub(crate) fn quality_json(quality: &Quality) -> Value {
    let extreme = |e: Extreme| json!({ "value": e.value, "tet": e.tet });
    let histogram = |h: &Histogram| {
        json!({
            "name": h.name,
            "low": h.low,
            "high": h.high,
            "counts": h.counts,
            "least": extreme(h.least),
            "largest": extreme(h.largest),
        })
    };
    let small = |(below, tets): (&f64, u64)| json!({ "below": below, "tets": tets });
    json!({
        "dihedral": histogram(&quality.dihedral),
        "radius_edge": histogram(&quality.radius_edge),
        "volume": histogram(&quality.volume),
        "edge": histogram(&quality.edge),
        "least_dihedral": least_angles_json(&quality.least_angles),
        "least_scaled_jacobian": extreme(quality.scaled_jacobian),
        "small_dihedral": SMALL_ANGLES.iter().zip(quality.small).map(small).collect::<Vec<_>>(),
    })
}

/// As [`quality_json`], with the smallest dihedral angles before slivers were split, if they were
/// counted.
pub(crate) fn measured_json(measured: &Measured) -> Value {
    let mut all = quality_json(&measured.quality);
    let before = measured.slivers.before.as_ref();
    all["least_dihedral_before"] = before.map_or(Value::Null, least_angles_json);
    all
}

fn least_angles_json(angles: &LeastAngles) -> Value {
    json!({
        "low": 0,
        "high": LeastAngles::HIGH,
        "counts": angles.counts(),
        "least": angles.least(),
    })
}

/// The least and the largest dihedral angle, the least scaled Jacobian and the worst ratio, in a
/// line.
pub(crate) fn quality_line(quality: &Quality) -> String {
    let (d, r) = (&quality.dihedral, &quality.radius_edge);
    format!(
        "quality   dihedral {:.2} to {:.2} degrees, scaled Jacobian at least {:.4}, radius-edge at \
         most {:.4}",
        d.least.value, d.largest.value, quality.scaled_jacobian.value, r.largest.value
    )
}

/// The most memory that this process held so far, in bytes, where the system tells.
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}
