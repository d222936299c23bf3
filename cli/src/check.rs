//! The glue to the checker: `check`, and the check of our own output.

use crate::angles;
use crate::args::{Check, Depth};
use crate::certificate;
use crate::conform;
use crate::console;
use crate::domain;
use crate::elements;
use crate::json::{check_report, is_stdout, write_json};
use crate::outcome::{Exit, Failure};
use crate::progress::Stage;
use ltbw::TetMesh;
use ltbw::io::{self, IoError, Reason};
use ltbw::quality::Quality;
use ltbw_verify as verify;
use std::path::Path;
use verify::{Outcome, VertexOrder};

/// Defects that people are shown; the certificate lists more.
const SHOWN: usize = 10;

/// `ltbw check`.
pub(crate) fn check(args: &Check) -> Result<Exit, Failure> {
    console::end_on_signal()?;
    let inputs: Vec<&Path> =
        [Some(&args.mesh), args.plc.as_ref()].into_iter().flatten().map(|p| &**p).collect();
    let formats = args.streams.resolve(&inputs, &[])?;
    let source = formats.input(&args.mesh)?;
    if source.is_domain()? {
        if args.certificate.is_some() {
            let text = format!("{}: --certificate is about a mesh", source.show());
            return Err(Failure::Usage(text));
        }
        if args.delaunay {
            return Err(Failure::Usage("--delaunay is about meshes".to_owned()));
        }
        if args.min_dihedral.is_some() {
            return Err(Failure::Usage("--min-dihedral is about meshes".to_owned()));
        }
        return domain::check(args, &source);
    }
    if let Some(report) = &args.certificate {
        return certificate::check(args, &source, report);
    }
    if let Some(plc) = &args.plc {
        return conform::check(args, &source, plc, formats);
    }
    if let Some(json) = &args.json {
        check_report(json, &io::mesh_files(&args.mesh), None)?;
    }
    let stage = Stage::begin("read");
    let file = match source.mesh() {
        // The reader has looked at the indices, and knows the line.
        Err(failure) if names_no_point(&failure) => {
            console::people(&format!("ltbw: {failure}"));
            return Ok(Exit::Defect);
        }
        file => file?,
    };
    drop(stage);
    let name = source.show();
    file.notes.iter().for_each(|n| console::people(&format!("note: {name}: {n}")));
    let TetMesh { points, tets, .. } = &file.mesh;
    let order = if args.any_order { VertexOrder::Any } else { VertexOrder::Oriented };
    let options = verify::Options { vertex_order: order, ..verify::Options::default() };
    let stage = Stage::begin("check");
    let mesh = verify::Mesh::new(points, tets);
    let report = verify::check_elements(&mesh, &options, args.delaunay);
    let small = args.min_dihedral.map(|d| verify::small_angles(&mesh, d, options.max_defects));
    let quality = Quality::of(points, tets);
    drop(stage);
    if let Some(path) = &args.json {
        let text = elements::json(&report, quality.as_ref(), small.as_ref());
        write_json(path, &(text.map_err(|e| Failure::Other(e.to_string()))? + "\n"))?;
    }
    elements::tell(&report, &file.mesh, quality.as_ref());
    small.iter().for_each(|small| console::people(&angles::line(small, &file.mesh)));
    print_defects(&report, Some(args.any_order));
    if is_of_a_domain(&report) {
        console::people(
            "note: a mesh of a domain has no convex hull: --plc DOMAIN checks it against the \
             domain",
        );
    }
    if !report.passed() {
        console::people(&format!("ltbw: {name}: {}", verdict(&report)));
        return Ok(Exit::Defect);
    }
    console::people(&format!("checked   {}", summary(&report)));
    match &report.hash {
        verify::Hash::Value(hash) if !args.json.as_deref().is_some_and(is_stdout) => {
            console::data(&format!("ltbw.mesh/1 {hash}\n"))?;
        }
        verify::Hash::None(why) => console::people(&format!("note: no hash: {why}")),
        _ => {}
    }
    let failure = small.as_ref().and_then(angles::failure);
    failure.iter().for_each(|why| console::people(&format!("ltbw: {name}: {why}")));
    Ok(if failure.is_some() { Exit::Defect } else { Exit::Done })
}

/// Does a cell of the file name a point that is not there?
fn names_no_point(failure: &Failure) -> bool {
    let Failure::Read(IoError::Parse { error, .. }) = failure else { return false };
    matches!(error.reason, Reason::Index { .. })
}

/// Is all that is wrong what makes a mesh of a domain differ from that of its points?
fn is_of_a_domain(report: &verify::Report) -> bool {
    use verify::Kind::{ConcaveHull, Euler, HullDisconnected, HullEuler};
    let kinds = [ConcaveHull, Euler, HullDisconnected, HullEuler];
    !report.passed() && report.defect_counts.keys().all(|kind| kinds.contains(kind))
}

/// The defects of a mesh, in a line.
fn verdict(report: &verify::Report) -> String {
    let counts: Vec<String> =
        report.defect_counts.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
    format!("defects: {}", counts.join(", "))
}

/// The levels that passed, and how much arithmetic had to be exact.
fn summary(report: &verify::Report) -> String {
    let passed = report.levels.iter().filter(|l| l.outcome == Outcome::Passed);
    let names: Vec<&str> = passed.clone().map(|l| l.level.name()).collect();
    let (filter, exact) = passed.fold((0, 0), |(f, e), l| (f + l.filter, e + l.exact));
    format!("{}: no defect ({filter} tests by filter, {exact} exactly)", names.join(", "))
}

/// Shows the first defects; `any_order` is how `check` was asked to read vertex orders.
fn print_defects(report: &verify::Report, any_order: Option<bool>) {
    report.defects.iter().take(SHOWN).for_each(|d| console::people(&format!("defect    {d}")));
    let all: u64 = report.defect_counts.values().sum();
    let more = all.saturating_sub(SHOWN as u64);
    if more > 0 {
        console::people(&format!("          and {more} more (--json lists them)"));
    }
    if any_order == Some(false) && report.counts.negative_tets > 0 && !report.mirrored {
        console::people(
            "note: if the order of vertices means nothing in this file: --any-order; `ltbw convert \
             --orient` turns negative tetrahedra",
        );
    }
}

/// The result of checking our own output.
pub(crate) struct Checked {
    /// Nothing is wrong.
    pub(crate) passed: bool,
    /// The levels in words.
    pub(crate) summary: String,
    /// The certificate `ltbw.cert/1`.
    pub(crate) certificate: Option<serde_json::Value>,
}

/// Checks our own mesh of all points, given with its neighbours and its hull; `hash` is what the
/// kernel computed.
pub(crate) fn check_own(mesh: &verify::Mesh<'_>, hash: &str, depth: Depth) -> Option<Checked> {
    let report = verify::check(mesh, &own_options(depth)?);
    Some(checked_own(&report, hash))
}

/// The options of the check of our own mesh of all points; `None` if it is not checked.
pub(crate) fn own_options(depth: Depth) -> Option<verify::Options> {
    let depth = match depth {
        Depth::Off => return None,
        Depth::Fast => verify::Depth::Fast,
        Depth::Full => verify::Depth::Full,
    };
    Some(verify::Options { depth, all_points: true, ..verify::Options::default() })
}

/// The result of a check of our own mesh, which has this hash.
pub(crate) fn checked_own(report: &verify::Report, hash: &str) -> Checked {
    // The checker's hash is computed by code that shares nothing with the kernel's.
    let same_hash = match &report.hash {
        verify::Hash::Value(other) => other == hash,
        verify::Hash::Skipped => true,
        _ => false,
    };
    if !same_hash {
        console::people("defect    the checker computes another hash");
    }
    print_defects(report, None);
    Checked {
        passed: report.passed() && same_hash,
        summary: summary(report),
        certificate: serde_json::to_value(report.certificate()).ok(),
    }
}
