//! `check --certificate`: is this the mesh that a report certifies, of this input?

use crate::args::Check;
use crate::binding::{Setting, options_hash, sha256};
use crate::conform::without_exterior;
use crate::console;
use crate::outcome::{Exit, Failure, show};
use crate::picture::angles::split_text;
use crate::progress::Stage;
use crate::streams::Source;
use ltbw::io;
use ltbw_verify as verify;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The parts of files that come beside the input.
const BESIDE: [&str; 6] = ["domain", "points", "mark", "sizes", "background", "without"];

/// `ltbw check MESH --certificate REPORT [--input FILE]`.
pub(crate) fn check(args: &Check, mesh: &Source, report: &Path) -> Result<Exit, Failure> {
    let stage = Stage::begin("read");
    let told = read(report)?;
    let certificate = certificate_of(&told, report)?;
    let mut found = Vec::new();
    drop(stage);
    compare_mesh(mesh, &told, certificate, &mut found)?;
    compare_options(certificate, &mut found);
    let passed = certificate["passed"] == true || certificate["verdict"] == "excused";
    if !passed {
        found.push("certificate: its verdict is failed".to_owned());
    }
    let inputs = compare_inputs(&args.input, certificate, &mut found)?;
    found.iter().for_each(|text| console::people(&format!("differs   {text}")));
    if found.is_empty() {
        slivers(&told).iter().for_each(|text| console::people(&format!("slivers   {text}")));
        let word = certificate["verdict"].as_str().unwrap_or("passed");
        console::people(&format!(
            "checked   the mesh, {inputs} and the options are those of the certificate ({word})"
        ));
        return Ok(Exit::Done);
    }
    let (name, report, count) = (mesh.show(), show(report), found.len());
    let plural = if count == 1 { "" } else { "s" };
    console::people(&format!("ltbw: {name}: {count} difference{plural} from {report}"));
    Ok(Exit::Defect)
}

/// The slivers that a report tells of: how many there were, and are.
fn slivers(report: &Value) -> Option<String> {
    let below = report["refinement"]["slivers"]["below"].as_f64()?;
    let of = |name: &str| {
        let counts = report["quality"][name]["counts"].as_array()?;
        let below = counts.iter().take(below as usize);
        Some(below.filter_map(Value::as_u64).sum::<u64>())
    };
    let (before, after) = (of("least_dihedral_before")?, of("least_dihedral")?);
    split_text(below, before, after)
}

fn read(report: &Path) -> Result<Value, Failure> {
    let bytes = io::read_bytes(report).map_err(Failure::Read)?;
    serde_json::from_slice(&bytes).map_err(|e| refused(report, &format!("no JSON: {e}")))
}

fn refused(report: &Path, why: &str) -> Failure {
    Failure::Report { path: report.to_owned(), why: why.to_owned() }
}

/// The certificate of a report, or one that stands alone.
fn certificate_of<'v>(told: &'v Value, report: &Path) -> Result<&'v Value, Failure> {
    let certificate = if told["schema"] == "ltbw.report/1" { &told["certificate"] } else { told };
    if certificate.is_null() {
        return Err(refused(report, "a report without a certificate: the mesh was not checked"));
    }
    let known = ["ltbw.cert/1", "ltbw.conformity/1"];
    if !certificate["schema"].as_str().is_some_and(|schema| known.contains(&schema)) {
        return Err(refused(report, "neither a report nor a certificate"));
    }
    match certificate["binding"].is_object() {
        true => Ok(certificate),
        false => Err(refused(report, "the certificate is not bound to a mesh")),
    }
}

/// Compares the hash of the mesh, computed anew, with all that are told.
fn compare_mesh(
    mesh: &Source,
    told: &Value,
    certificate: &Value,
    found: &mut Vec<String>,
) -> Result<(), Failure> {
    let stage = Stage::begin("read");
    let file = mesh.mesh()?;
    let carried = mesh.carried_hash()?;
    drop(stage);
    file.notes.iter().for_each(|n| console::people(&format!("note: {}: {n}", mesh.show())));
    let _stage = Stage::begin("hash");
    let inside = without_exterior(&file.mesh);
    let hash = match verify::canonical_hash(&inside.points, &inside.tets) {
        Ok(hash) => hash,
        Err(error) => {
            found.push(format!("mesh: {error}"));
            return Ok(());
        }
    };
    let of_certificate = text(&certificate["binding"]["mesh"]).to_owned();
    let mut others = vec![("that of the certificate", of_certificate)];
    if told["schema"] == "ltbw.report/1" {
        others.push(("that of the report", text(&told["mesh"]["hash"]).to_owned()));
    }
    others.extend(carried.map(|carried| ("the one that the file carries", carried)));
    for (name, other) in others.into_iter().filter(|(_, other)| *other != hash) {
        found.push(format!("mesh: its hash is {hash}, {name} {other}"));
    }
    Ok(())
}

/// Compares the list of options with its hash.
fn compare_options(certificate: &Value, found: &mut Vec<String>) {
    let binding = &certificate["binding"];
    let listed = binding["options"].as_object().into_iter().flatten();
    let listed =
        listed.map(|(name, value)| Setting { name, value: value.as_str().unwrap_or_default() });
    let hash = options_hash(listed);
    if binding["options_sha256"] != hash.as_str() {
        let told = &binding["options_sha256"];
        found.push(format!("options: their hash is {hash}, that of the certificate {told}"));
    }
}

/// A text, or none.
fn text(value: &Value) -> &str {
    value.as_str().unwrap_or("none")
}

/// A file that the certificate names.
struct Told<'v> {
    role: &'v str,
    name: &'v str,
    sha256: &'v str,
}

/// Compares the files that are given with those that were read: the first with the input, and
/// beside it its companions; the others with what came beside it. In words, how many there were.
fn compare_inputs(
    given: &[PathBuf],
    certificate: &Value,
    found: &mut Vec<String>,
) -> Result<String, Failure> {
    let listed = certificate["binding"]["inputs"].as_array().into_iter().flatten();
    let told: Vec<Told<'_>> = listed
        .map(|v| Told {
            role: text(&v["role"]),
            name: text(&v["name"]),
            sha256: text(&v["sha256"]),
        })
        .collect();
    let mut seen = 0;
    let mut compare = |path: &Path, told: Option<&Told<'_>>| {
        let Some(told) = told else {
            found.push(format!("input: {}: the certificate has no such file", show(path)));
            return Ok(());
        };
        let hash = sha256(&io::read_bytes(path).map_err(Failure::Read)?);
        seen += 1;
        if hash != told.sha256 {
            let (path, name, other) = (show(path), told.name, told.sha256);
            found.push(format!("input: {path}: its SHA-256 is {hash}, that of {name} {other}"));
        }
        Ok(())
    };
    if let Some((first, others)) = given.split_first() {
        compare(first, told.iter().find(|t| t.role == "input"))?;
        for companion in told.iter().filter(|t| t.role == "companion") {
            let extension = Path::new(companion.name).extension().unwrap_or_default();
            compare(&first.with_extension(extension), Some(companion))?;
        }
        for path in others {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let beside = |t: &&Told<'_>| BESIDE.contains(&t.role);
            compare(path, told.iter().filter(beside).find(|t| t.name == name))?;
        }
    }
    Ok(format!("{seen} of {} inputs", told.len()))
}
