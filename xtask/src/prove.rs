//! `prove`: the proofs of the filter constants in `verify/proofs`.
//!
//! Coq checks the permanent-style filters (`Filter.v`, `Pred.v`); Gappa checks the static and
//! semi-static ones, whose scripts two Python generators write with the bound as the goal. A copy
//! in the target folder is what runs, so that nothing is left in the tree.

use crate::require;
use crate::shell::{self, command, root, target};
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Checks all proofs.
pub(crate) fn run() -> Result<(), String> {
    let build = target().join("proofs");
    copy(&root().join("verify/proofs"), &build)
        .map_err(|error| format!("verify/proofs: {error}"))?;
    coq(&build)?;
    gappa(&build)
}

fn coq(build: &Path) -> Result<(), String> {
    if !shell::works(command("coqc").arg("--version")) {
        return require::skip("prove", "coq", "coqc is not installed (coq libcoq-flocq)");
    }
    // Pred.v builds on Filter.v, hence the order.
    for file in ["Filter.v", "Pred.v"] {
        timed(file, || shell::run(command("coqc").arg(file).current_dir(build)))?;
    }
    Ok(())
}

fn gappa(build: &Path) -> Result<(), String> {
    if !shell::works(command("gappa").arg("--version")) {
        return require::skip("prove", "gappa", "gappa is not installed");
    }
    for generator in ["gappa_static.py", "gappa_semistatic.py"] {
        shell::run(command("python3").arg(generator).current_dir(build))?;
    }
    let mut scripts: Vec<_> = fs::read_dir(build)
        .map_err(|error| format!("{}: {error}", build.display()))?
        .filter_map(Result::ok)
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".g"))
        .collect();
    scripts.sort();
    if scripts.is_empty() {
        return Err("the generators wrote no Gappa script".to_string());
    }
    for script in scripts {
        timed(&script, || shell::run(command("gappa").arg(&script).current_dir(build)))?;
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
