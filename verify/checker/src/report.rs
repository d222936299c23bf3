//! The checker's findings, and the certificate `ltbw.cert/1` made from them.

use crate::defect::{Defect, Kind, Level};
use crate::predicates::Tally;
use serde::Serialize;
use std::collections::BTreeMap;

/// The outcome of a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Outcome {
    /// Every test of this level and of those before it was made and held.
    Passed,
    /// The level has defects.
    Failed,
    /// No defect of its own, but defects of an earlier level take the sense from its tests, or
    /// from their conclusion.
    Incomplete,
    /// Not asked for, or impossible.
    Skipped,
}

/// One level of the check.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LevelReport {
    /// Which level.
    pub level: Level,
    /// Its outcome.
    pub outcome: Outcome,
    /// Exact predicates decided by a floating-point filter.
    pub filter: u64,
    /// Exact predicates decided by exact arithmetic.
    pub exact: u64,
    /// Tests that could not be posed because of defects of earlier levels.
    pub untested: u64,
    /// Number of defects, listed or not.
    pub defects: u64,
}

/// Numbers of things in the mesh. Unsound and duplicated tetrahedra count in `tets` only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Counts {
    /// Points given.
    pub points: u64,
    /// Points that a tetrahedron uses.
    pub vertices: u64,
    /// Points that no tetrahedron uses.
    pub unused_points: u64,
    /// Places of points at which no vertex lies: without them the mesh is a triangulation of all
    /// given points. (An unused duplicate of a vertex is not one of them.)
    pub places_left_out: u64,
    /// Tetrahedra given.
    pub tets: u64,
    /// Faces; two tetrahedra share an inner one.
    pub faces: u64,
    /// Edges; 0 if the depth did not ask for them.
    pub edges: u64,
    /// Faces of only one tetrahedron.
    pub hull_facets: u64,
    /// Vertices of hull facets.
    pub hull_vertices: u64,
    /// Parts of the mesh that shared faces connect.
    pub components: u64,
    /// Negatively oriented tetrahedra, as the file has them.
    pub negative_tets: u64,
}

/// The canonical hash, or why there is none.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Hash {
    /// The hash `ltbw.mesh/1`: 64 lower-case hexadecimal digits.
    Value(String),
    /// The mesh has no hash: why.
    None(String),
    /// The depth did not ask for it.
    Skipped,
}

/// All that the checker found.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// The levels, in order.
    pub levels: Vec<LevelReport>,
    /// Listed defects, by kind, in the order of the mesh.
    pub defects: Vec<Defect>,
    /// Number of defects of each kind, listed or not.
    pub defect_counts: BTreeMap<Kind, u64>,
    /// Numbers of things.
    pub counts: Counts,
    /// Sum of the absolute volumes of the tetrahedra in cubic units of the input, rounded.
    pub volume: f64,
    /// All tetrahedra are negatively oriented: the file uses the other handedness. They were
    /// turned to positive for every test.
    pub mirrored: bool,
    /// The canonical hash.
    pub hash: Hash,
    /// The findings of [`check_elements`](crate::check_elements) that are no defects of a finite
    /// element mesh, as `defects` and `defect_counts` have those that are; `None` from
    /// [`check`](crate::check).
    pub information: Option<Information>,
    /// Number of parts of a mesh that was checked in parts.
    pub parts: Option<u64>,
}

/// The tests of a level.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Ran {
    pub(crate) tally: Tally,
    /// Tests that could not be posed.
    pub(crate) untested: u64,
    /// The level was run.
    pub(crate) ran: bool,
}

/// The outcomes of levels in their order; `includes` says which are asked for.
pub(crate) fn outcomes(
    levels: &[Level],
    ran: &[Ran; 6],
    defects: impl Fn(Level) -> u64,
    includes: impl Fn(Level) -> bool,
) -> Vec<LevelReport> {
    let mut sane = true;
    let of_level = |&level: &Level| {
        let Ran { tally, untested, ran } = ran[level as usize];
        let defects = defects(level);
        let outcome = match () {
            () if defects > 0 => Outcome::Failed,
            () if !ran || !includes(level) => Outcome::Skipped,
            () if untested > 0 || !sane => Outcome::Incomplete,
            () => Outcome::Passed,
        };
        sane &= outcome == Outcome::Passed;
        let Tally { filter, exact } = tally;
        LevelReport { level, outcome, filter, exact, untested, defects }
    };
    levels.iter().map(of_level).collect()
}

/// Findings that are no defects.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Information {
    /// Number of findings of each kind, listed or not.
    #[serde(rename = "information_counts")]
    pub counts: BTreeMap<Kind, u64>,
    /// Listed findings, by kind, in the order of the mesh.
    #[serde(rename = "information")]
    pub listed: Vec<Defect>,
}

impl Information {
    /// Number of findings of a kind.
    pub fn count(&self, kind: Kind) -> u64 {
        self.counts.get(&kind).copied().unwrap_or(0)
    }
}

/// The level that [`check`](crate::check) does not ask for.
const NOT_ASKED: LevelReport = LevelReport {
    level: Level::Overlap,
    outcome: Outcome::Skipped,
    filter: 0,
    exact: 0,
    untested: 0,
    defects: 0,
};

impl Report {
    /// Whether every level that was asked for passed.
    pub fn passed(&self) -> bool {
        self.levels.iter().all(|l| matches!(l.outcome, Outcome::Passed | Outcome::Skipped))
            && self.level(Level::Structure).outcome == Outcome::Passed
    }

    /// The report of a level; one that says "skipped" if there is none.
    pub fn level(&self, level: Level) -> &LevelReport {
        self.levels.iter().find(|report| report.level == level).unwrap_or(&NOT_ASKED)
    }

    /// Number of defects of a kind.
    pub fn count(&self, kind: Kind) -> u64 {
        self.defect_counts.get(&kind).copied().unwrap_or(0)
    }

    /// The certificate of this report.
    pub fn certificate(&self) -> Certificate<'_> {
        let (hash, no_hash) = match &self.hash {
            Hash::Value(hash) => (Some(hash.as_str()), None),
            Hash::None(why) => (None, Some(why.as_str())),
            Hash::Skipped => (None, Some("not asked for")),
        };
        Certificate {
            schema: Certificate::SCHEMA,
            checker: concat!("ltbw-verify ", env!("CARGO_PKG_VERSION")),
            passed: self.passed(),
            mesh: MeshPart {
                hash_schema: "ltbw.mesh/1",
                hash,
                no_hash,
                counts: self.counts,
                volume: self.volume.is_finite().then_some(self.volume),
                mirrored: self.mirrored,
            },
            levels: &self.levels,
            defect_counts: &self.defect_counts,
            defects: &self.defects,
            parts: self.parts,
            judged_as: self.information.as_ref().map(|_| "elements"),
            information: self.information.as_ref(),
        }
    }
}

/// The certificate `ltbw.cert/1`, for serialisation. It is a function of the mesh and the options
/// alone: neither time nor machine nor number of threads is in it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Certificate<'a> {
    schema: &'static str,
    checker: &'static str,
    passed: bool,
    mesh: MeshPart<'a>,
    levels: &'a [LevelReport],
    defect_counts: &'a BTreeMap<Kind, u64>,
    defects: &'a [Defect],
    #[serde(skip_serializing_if = "Option::is_none")]
    parts: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    judged_as: Option<&'static str>,
    #[serde(flatten)]
    information: Option<&'a Information>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct MeshPart<'a> {
    hash_schema: &'static str,
    hash: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    no_hash: Option<&'a str>,
    #[serde(flatten)]
    counts: Counts,
    volume: Option<f64>,
    mirrored: bool,
}

impl Certificate<'_> {
    /// The name and version of the schema.
    pub const SCHEMA: &'static str = "ltbw.cert/1";

    /// Whether every level that was asked for passed.
    pub fn passed(&self) -> bool {
        self.passed
    }

    /// Number of defects of each kind, listed or not.
    pub(crate) fn defect_counts(&self) -> &BTreeMap<Kind, u64> {
        self.defect_counts
    }

    /// Numbers of things in the mesh, and its hash, if there is one.
    pub(crate) fn figures(&self) -> (&Counts, Option<&str>) {
        (&self.mesh.counts, self.mesh.hash)
    }

    /// The certificate as JSON text, indented.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}
