//! `prove`: the proofs of `verify/proofs`.
//!
//! First all that is generated is compared with its description: the proofs are about the constants
//! and terms that are compiled, or nothing is proved. Then Coq checks every file, and the
//! assumptions of every theorem are printed and compared with the axioms that the real numbers of
//! Coq's library bring. Constants that are a step too low must be refused. Gappa, if it is there,
//! gives a second opinion on the constants. A copy in the target folder is what runs, so that
//! nothing is left in the tree.

use crate::generate;
use crate::predicates::coq::lowered;
use crate::predicates::{gappa, spheres};
use crate::require;
use crate::shell::{self, command, root, target};
use std::fs;
use std::path::Path;
use std::time::Instant;

/// The files, each after those that it builds on.
const FILES: &[&str] = &[
    "Rounding",
    "Poly",
    "Expr",
    "Bound",
    "Filter",
    "Exact",
    "Predicates",
    "Means",
    "Constants",
    "Single",
    "Centre",
    "Sphere",
    "TwoSum",
    "Distance",
];

/// The axioms that a proof may rest on: Coq's classical real numbers, and that functions with
/// equal values are equal.
const AXIOMS: &[&str] = &[
    "ClassicalDedekindReals.sig_not_dec",
    "ClassicalDedekindReals.sig_forall_dec",
    "FunctionalExtensionality.functional_extensionality_dep",
    "Classical_Prop.classic",
];

/// Words that leave a proof open, or assume something.
const OPEN: &[&str] = &[
    "Admitted",
    "admit",
    "give_up",
    "Axiom",
    "Axioms",
    "Parameter",
    "Parameters",
    "Conjecture",
    "Abort",
];

/// Checks all proofs.
pub(crate) fn run() -> Result<(), String> {
    let files = generate::compare(&generate::files()?, generate::checked_in)?;
    println!("generated: {files} files are what their descriptions say");
    let build = target().join("proofs");
    copy(&root().join("verify/proofs"), &build)
        .map_err(|error| format!("verify/proofs: {error}"))?;
    if shell::works(command("coqc").arg("--version")) {
        for file in FILES {
            closed(&build, file)?;
            timed(&format!("{file}.v"), || coqc(&build, file).map(drop))?;
        }
        assumptions(&build)?;
        refused(&build)?;
        refused_spheres(&build)?;
    } else {
        require::skip("prove", "coq", "coqc is not installed (coq libcoq-flocq)")?;
    }
    gappa()
}

/// Every script of the folder `gappa`, whose goal is the bound itself.
fn gappa() -> Result<(), String> {
    if !shell::works(command("gappa").arg("--version")) {
        return require::skip("prove", "gappa", "gappa is not installed");
    }
    for (name, _) in gappa::files()? {
        let script = root().join("verify/proofs/gappa").join(&name);
        timed(&name, || shell::run(command("gappa").arg(&script)))?;
    }
    Ok(())
}

/// Compiles a file; its output.
fn coqc(build: &Path, file: &str) -> Result<String, String> {
    let output = command("coqc")
        .arg(format!("{file}.v"))
        .current_dir(build)
        .output()
        .map_err(|error| format!("coqc: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() {
        Ok(text(&output.stdout))
    } else {
        Err(format!(
            "{file}.v: {}\n{}{}",
            output.status,
            text(&output.stdout),
            text(&output.stderr)
        ))
    }
}

/// The text of a file without its comments, which do not nest here.
fn source(build: &Path, file: &str) -> Result<String, String> {
    let path = build.join(format!("{file}.v"));
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut parts = text.split("(*");
    let mut code = parts.next().unwrap_or_default().to_string();
    for part in parts {
        code.push_str(part.split_once("*)").map_or("", |(_, after)| after));
    }
    Ok(code)
}

/// No proof is left open, nothing is assumed.
fn closed(build: &Path, file: &str) -> Result<(), String> {
    let code = source(build, file)?;
    let mut words = code.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    match words.find(|word| OPEN.contains(word)) {
        Some(word) => Err(format!("{file}.v: `{word}`")),
        None => Ok(()),
    }
}

/// Prints what all theorems rest on, and compares it with [`AXIOMS`]. They are asked about at
/// once, as one tuple: one by one takes minutes.
fn assumptions(build: &Path) -> Result<(), String> {
    let mut script = format!("Require Import {}.\nDefinition all := (0", FILES.join(" "));
    let mut count = 0;
    for file in FILES {
        for line in source(build, file)?.lines() {
            let named = line.strip_prefix("Theorem ").or_else(|| line.strip_prefix("Lemma "));
            // A lemma of a section has the same name outside of it.
            if let Some(name) = named.and_then(|rest| rest.split([' ', ':']).next()) {
                script.push_str(&format!(",\n  @{file}.{name}"));
                count += 1;
            }
        }
    }
    script.push_str(").\nPrint Assumptions all.\n");
    fs::write(build.join("Assumptions.v"), script).map_err(|error| error.to_string())?;
    let output = coqc(build, "Assumptions")?;
    println!("Print Assumptions of all {count} theorems and lemmas:\n{}", output.trim_end());
    let mut lines = output.lines();
    if lines.next() != Some("Axioms:") || count == 0 {
        return Err("Coq did not answer".to_string());
    }
    // The type of an axiom may take more lines, which begin with a space.
    let names = lines.filter(|line| !line.starts_with(' ') && !line.is_empty());
    let names = names.map(|line| line.split(' ').next().unwrap_or(line));
    match names.into_iter().find(|axiom| !AXIOMS.contains(axiom)) {
        Some(axiom) => Err(format!("an axiom that no proof may use: {axiom}")),
        None => Ok(()),
    }
}

/// A constant that is lowered by one step makes its proof fail, for that reason.
fn refused(build: &Path) -> Result<(), String> {
    for (name, text) in lowered()? {
        let file = format!("Lowered_{name}");
        fs::write(build.join(format!("{file}.v")), text).map_err(|error| error.to_string())?;
        match coqc(build, &file) {
            Ok(_) => return Err(format!("{name} is proved with u/16 less: lower it")),
            Err(why) if why.contains("Unable to unify \"true\" with \"false\"") => {
                println!("refused: {name} lowered by u/16");
            }
            Err(why) => return Err(format!("{name} lowered fails for another reason: {why}")),
        }
    }
    Ok(())
}

/// A lowered constant of the cached spheres makes its proof fail, in a folder of its own, for the
/// proofs know the file by its name.
fn refused_spheres(build: &Path) -> Result<(), String> {
    let folder = build.join("wrong");
    let io = |error: std::io::Error| format!("{}: {error}", folder.display());
    for (name, text, proof) in spheres::wrong() {
        fs::create_dir_all(&folder).map_err(io)?;
        for file in ["Rounding.vo".to_string(), format!("{proof}.v")] {
            fs::copy(build.join(&file), folder.join(&file)).map_err(io)?;
        }
        fs::write(folder.join("Constants.v"), text).map_err(io)?;
        coqc(&folder, "Constants")?;
        match coqc(&folder, proof) {
            Ok(_) => return Err(format!("{proof}.v accepts a wrong {name}")),
            // The arithmetic of a proof fails, not its text.
            Err(why) if why.contains("Cannot find witness") || why.contains("No applicable") => {
                println!("refused: {proof}.v with a wrong {name}");
            }
            Err(why) => return Err(format!("{name} wrong fails for another reason: {why}")),
        }
    }
    Ok(())
}

fn timed(name: &str, check: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
    let start = Instant::now();
    check()?;
    println!("proved: {name} ({:.1} s)", start.elapsed().as_secs_f64());
    Ok(())
}

/// Copies the files of the folder `from` into a fresh folder `to`.
fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    if to.exists() {
        fs::remove_dir_all(to)?;
    }
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        if entry.file_type()?.is_file() {
            fs::copy(entry.path(), to.join(entry.file_name()))?;
        }
    }
    Ok(())
}
