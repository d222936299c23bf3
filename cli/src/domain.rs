//! `check` of a domain, and its report `ltbw.domain/1`.

use crate::args::Check;
use crate::console;
use crate::json::{check_report, write_json};
use crate::outcome::{Exit, Failure};
use crate::progress::Stage;
use crate::streams::Source;
use crate::surface::{given, print_troubles, troubles_json};
use ltbw::domain::{
    CheckOptions, DefectKind, Domain, DomainDefect, DomainReport, Element, PrepareError,
    PrepareOptions, Prepared, Severity, Snapped,
};
use ltbw::io;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Defects that people are shown of each kind; the report lists more.
const SHOWN: usize = 5;

/// The report. A field that exists is never renamed in this version.
#[derive(Debug, Serialize)]
struct Report {
    schema: &'static str,
    command: &'static str,
    passed: bool,
    domain: DomainPart,
    lattice: Option<LatticePart>,
    defect_counts: BTreeMap<&'static str, u64>,
    defects: Vec<Value>,
    /// The meaning of the defects for the surface: open, doubled, bodies that touch or cross.
    kinds: Vec<Value>,
    /// The number of bodies, if there are defects.
    bodies: usize,
    /// The code of the reason why `mesh` refuses the domain, if no defect is the reason.
    refused: Option<&'static str>,
    /// Defects that snapping makes.
    snapped_defect_counts: BTreeMap<&'static str, u64>,
    snapped_defects: Vec<Value>,
}

#[derive(Debug, Serialize)]
struct DomainPart {
    vertices: usize,
    facets: usize,
    polygons: usize,
    segments: usize,
    holes: usize,
    regions: usize,
    oriented: bool,
    /// Volumes of the bounded cells; none if defects leave open what they are.
    cells: Option<Vec<Value>>,
    /// The volume of all filled cells.
    volume: Option<f64>,
    /// The volume as an exact fraction.
    volume_exact: Option<String>,
}

#[derive(Debug, Serialize)]
struct LatticePart {
    step: f64,
    lost_bits: u32,
    moved: usize,
    largest_move: Option<Value>,
}

/// `ltbw check` of a domain.
pub(crate) fn check(args: &Check, source: &Source) -> Result<Exit, Failure> {
    args.preparation.check(&[&args.mesh])?;
    if let Some(json) = &args.json {
        let other = args.preparation.write_defects.as_ref();
        check_report(json, &io::domain_files(&args.mesh), other)?;
    }
    let stage = Stage::begin("read");
    let mut file = args.preparation.read(source)?;
    drop(stage);
    let name = source.show();
    let failed = |error: PrepareError| Failure::Domain { path: source.name.clone(), error };
    let options = args.preparation.options(&mut file);
    let PrepareOptions { oriented, nested_voids, .. } = options;
    let checks = CheckOptions { oriented, nested_voids, ..CheckOptions::default() };
    let stage = Stage::begin("check");
    let report = file.domain.check(&checks).map_err(|e| failed(e.into()))?;
    drop(stage);
    print_domain(&name, &file.domain, &report);
    print_defects(&report);
    let stage = Stage::begin("prepare");
    let snapped = file.domain.snap_by(&PrepareOptions { exact_input: false, ..options });
    let snapped = snapped.map_err(failed)?;
    drop(stage);
    print_lattice(&snapped);
    if args.preparation.exact_input {
        snapped.clone().exact().map_err(|e| failed(e.into()))?;
    }
    let stage = Stage::begin("check");
    let lenient = PrepareOptions { strict: false, ..options };
    let prospect = Prospect::of(&file.domain, &report, &snapped, &lenient).map_err(failed)?;
    drop(stage);
    let passed = report.passed() && prospect.is_sound();
    if let Some(path) = &args.json {
        let text = json_report(&file.domain, file.oriented, &report, &snapped, &prospect);
        let text =
            serde_json::to_string_pretty(&text).map_err(|e| Failure::Other(e.to_string()))?;
        write_json(path, &(text + "\n"))?;
    }
    if args.preparation.strict
        && let Err(error @ PrepareError::Strict { .. }) = file.domain.prepare(&options)
    {
        return Err(failed(error));
    }
    if passed {
        args.preparation.told(&file.domain, None)?;
        prospect.ready.iter().for_each(print_repairs);
        console::people("checked   no defect");
        return Ok(Exit::Done);
    }
    if let Some(after) = &prospect.after {
        console::people("defects once the vertices are on the lattice:");
        print_defects(after);
    }
    let counted =
        if report.passed() { prospect.after.as_ref().unwrap_or(&report) } else { &report };
    print_troubles(Some(counted));
    args.preparation.told(&file.domain, Some(counted))?;
    if let Some(error) = &prospect.refused {
        console::people(&format!("ltbw: {name}: {error}"));
        return Ok(Exit::Defect);
    }
    if let Some(ready) = &prospect.ready {
        print_repairs(ready);
        let is_kept = |kind: &DefectKind| *kind == DefectKind::UnusedVertex;
        let warnings = report.counts.keys().filter(|kind| kind.severity() > Severity::Info);
        let as_it_is = ready.notes().is_empty() && warnings.copied().all(|kind| is_kept(&kind));
        let does = if as_it_is { "takes this as it is" } else { "repairs this on its way" };
        console::people(&format!("note: `ltbw mesh` {does}"));
    }
    let counts: Vec<String> = counted
        .counts
        .iter()
        .filter(|(kind, _)| kind.severity() > Severity::Info)
        .map(|(kind, n)| format!("{n} {}", kind.code()))
        .collect();
    console::people(&format!("ltbw: {name}: defects: {}", counts.join(", ")));
    Ok(Exit::Defect)
}

/// The outcome of `mesh` on a domain. Nothing is known of one whose defects keep it from being
/// meshed, nor of one that it takes as it is.
#[derive(Default)]
struct Prospect {
    /// The domain that it would mesh.
    ready: Option<Prepared>,
    /// The defects that snapping brings to a domain that can be meshed as it is.
    after: Option<DomainReport>,
    /// The reason why it refuses a domain without defects.
    refused: Option<PrepareError>,
}

impl Prospect {
    fn of(
        domain: &Domain,
        report: &DomainReport,
        snapped: &Snapped,
        options: &PrepareOptions,
    ) -> Result<Self, PrepareError> {
        let is_filled = report.cells.as_ref().is_none_or(|cells| cells.iter().any(|c| c.filled));
        let is_whole = report.exterior.is_empty() && report.count(DefectKind::Nested) == 0;
        if report.passed()
            && snapped.moved == 0
            && is_filled
            && is_whole
            && domain.points.is_empty()
        {
            return Ok(Self::default());
        }
        match domain.prepare(options) {
            Ok(ready) => Ok(Self { ready: Some(ready), ..Self::default() }),
            Err(_) if !report.is_meshable() => Ok(Self::default()),
            Err(PrepareError::BelowLattice { report, .. }) => {
                Ok(Self { after: Some(*report), ..Self::default() })
            }
            Err(error @ (PrepareError::NothingInside | PrepareError::Undecided)) => {
                Ok(Self { refused: Some(error), ..Self::default() })
            }
            Err(error) => Err(error),
        }
    }

    /// Is there nothing against meshing it that the check of the input does not say?
    fn is_sound(&self) -> bool {
        self.after.is_none() && self.refused.is_none()
    }
}

/// Tells what `mesh` would repair of a domain, leave out, guess, or keep though nothing names it.
fn print_repairs(ready: &Prepared) {
    ready.notes().iter().for_each(|n| console::people(&format!("repair    {n}")));
    given(ready).iter().for_each(|line| console::people(line));
    match ready.report.count(DefectKind::UnusedVertex) {
        0 => {}
        1 => console::people("kept      1 vertex that nothing names, inside"),
        n => console::people(&format!("kept      {n} vertices that nothing names, inside")),
    }
}

fn print_domain(name: &str, domain: &Domain, report: &DomainReport) {
    console::people(&format!(
        "domain    {name}: {} vertices, {} facets, {} segments, {} holes, {} regions",
        domain.vertices.len(),
        domain.facets.len(),
        domain.segments.len(),
        domain.holes.len(),
        domain.regions.len()
    ));
    if let (Some(cells), Some(volume)) = (&report.cells, report.volume()) {
        let filled = cells.iter().filter(|c| c.filled).count();
        let exact = volume.to_string();
        // Coordinates of many bits make fractions that nobody reads.
        let exact = if exact.len() <= 24 { format!(" = {exact}") } else { String::new() };
        console::people(&format!(
            "cells     {} bounded, {filled} of them filled; volume {:?}{exact}",
            cells.len(),
            volume.to_f64()
        ));
    }
}

fn print_lattice(snapped: &Snapped) {
    let lattice = &snapped.lattice;
    let lost = match lattice.lost_bits() {
        0 => String::new(),
        bits => format!(" ({bits} bits lost to the distance from the origin)"),
    };
    let moves = match &snapped.largest {
        None => "all vertices are on it".to_owned(),
        Some(m) => format!(
            "{} vertices move, the farthest is vertex {}, by {:.3e}, {:.1e} of the diagonal",
            snapped.moved,
            m.vertex,
            m.distance,
            m.distance / snapped.diagonal
        ),
    };
    console::people(&format!("lattice   step 2^{}{lost}: {moves}", lattice.exponent()));
}

/// Shows the first defects of each kind.
fn print_defects(report: &DomainReport) {
    for (&kind, &count) in &report.counts {
        let word = match kind.severity() {
            Severity::Error => "defect   ",
            Severity::Warning => "warning  ",
            Severity::Info => "note     ",
        };
        let listed = report.defects.iter().filter(|d| d.kind == kind).take(SHOWN);
        listed.for_each(|d| console::people(&format!("{word} {d}")));
        if let Some(more) = count.checked_sub(SHOWN as u64).filter(|&more| more > 0) {
            console::people(&format!("          and {more} more {}", kind.code()));
        }
    }
}

fn json_report(
    domain: &Domain,
    oriented: bool,
    report: &DomainReport,
    snapped: &Snapped,
    prospect: &Prospect,
) -> Report {
    let after = prospect.after.as_ref();
    let counts = |r: &DomainReport| r.counts.iter().map(|(k, &n)| (k.code(), n)).collect();
    let defects = |r: &DomainReport| r.defects.iter().map(json_defect).collect();
    let volume = report.volume();
    Report {
        schema: "ltbw.domain/1",
        command: "check",
        passed: report.passed() && prospect.is_sound(),
        domain: DomainPart {
            vertices: domain.vertices.len(),
            facets: domain.facets.len(),
            polygons: domain.polygon_count(),
            segments: domain.segments.len(),
            holes: domain.holes.len(),
            regions: domain.regions.len(),
            oriented,
            cells: report.cells.as_ref().map(|cells| {
                let cell = |c: &ltbw::domain::Cell| {
                    json!({
                        "volume": c.volume.to_f64(),
                        "filled": c.filled,
                        "holes": c.holes,
                        "regions": c.regions,
                    })
                };
                cells.iter().map(cell).collect()
            }),
            volume: volume.as_ref().map(|v| v.to_f64()),
            volume_exact: volume.as_ref().map(ToString::to_string),
        },
        lattice: Some(LatticePart {
            step: snapped.lattice.step(),
            lost_bits: snapped.lattice.lost_bits(),
            moved: snapped.moved,
            largest_move: snapped.largest.map(|m| {
                json!({ "vertex": m.vertex, "from": m.from, "to": m.to, "distance": m.distance })
            }),
        }),
        defect_counts: counts(report),
        defects: defects(report),
        kinds: troubles_json(after.unwrap_or(report)),
        bodies: after.unwrap_or(report).bodies,
        refused: prospect.refused.as_ref().map(PrepareError::code),
        snapped_defect_counts: after.map(counts).unwrap_or_default(),
        snapped_defects: after.map(defects).unwrap_or_default(),
    }
}

fn json_defect(defect: &DomainDefect) -> Value {
    json!({
        "kind": defect.kind.code(),
        "severity": defect.kind.severity().name(),
        "elements": defect.elements.iter().map(json_element).collect::<Vec<_>>(),
        "at": defect.at,
    })
}

fn json_element(element: &Element) -> Value {
    match *element {
        Element::Vertex(v) => json!({ "vertex": v }),
        Element::Facet(f) => json!({ "facet": f }),
        Element::Polygon { facet, polygon } => json!({ "facet": facet, "polygon": polygon }),
        Element::Edge(ends) => json!({ "edge": ends }),
        Element::Segment(s) => json!({ "segment": s }),
        Element::FacetHole { facet, hole } => json!({ "facet": facet, "facet_hole": hole }),
        Element::Hole(h) => json!({ "hole": h }),
        Element::Region(r) => json!({ "region": r }),
        Element::Point(p) => json!({ "point": p }),
        ref other => json!({ "other": other.to_string() }),
    }
}
