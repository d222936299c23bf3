//! `generate`: writes what is generated from the descriptions of the predicates; a test compares
//! what is checked in.

use crate::predicates;
use crate::shell::{command, root};
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::Stdio;

/// Writes every generated file.
pub(crate) fn run() -> Result<(), String> {
    for (path, text) in files()? {
        let full = root().join(&path);
        if fs::read_to_string(&full).is_ok_and(|old| old == text) {
            continue;
        }
        let folder = full.parent().map_or_else(root, PathBuf::from);
        fs::create_dir_all(folder)
            .and_then(|()| fs::write(&full, text))
            .map_err(|error| format!("{}: {error}", path.display()))?;
        println!("written: {}", path.display());
    }
    Ok(())
}

/// Every generated file: its path in the workspace, and its text.
pub(crate) fn files() -> Result<Vec<(PathBuf, String)>, String> {
    let rust = formatted(&predicates::rust::file()?)?;
    let spheres = formatted(&predicates::spheres::rust())?;
    let mut files: Vec<(PathBuf, String)> = vec![
        ("core/kernel/src/sphere/constants.rs".into(), spheres),
        ("verify/proofs/Constants.v".into(), predicates::spheres::coq()),
        ("core/exact/src/predicates/filter/generated.rs".into(), rust),
        ("verify/proofs/Predicates.v".into(), predicates::coq::file()?),
    ];
    let folder = PathBuf::from("verify/proofs/gappa");
    let scripts = predicates::gappa::files()?;
    files.extend(scripts.into_iter().map(|(name, text)| (folder.join(name), text)));
    Ok(files)
}

/// `source` as rustfmt writes it, with the settings of the workspace.
fn formatted(source: &str) -> Result<String, String> {
    let mut child = command("rustfmt")
        .args(["--edition", "2024", "--emit", "stdout"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| format!("rustfmt: {error}"))?;
    // Both ends are small files: rustfmt reads all of its input before it writes.
    let sent = child.stdin.take().map_or(Ok(()), |mut stdin| stdin.write_all(source.as_bytes()));
    let output = child.wait_with_output().map_err(|error| format!("rustfmt: {error}"))?;
    sent.map_err(|error| format!("rustfmt: {error}"))?;
    if !output.status.success() {
        return Err(format!("rustfmt: {}\n{source}", output.status));
    }
    String::from_utf8(output.stdout).map_err(|error| format!("rustfmt: {error}"))
}

#[cfg(test)]
mod tests {
    use super::{files, root};

    #[test]
    fn checked_in_files_are_the_generated_ones() {
        for (path, text) in files().expect("the descriptions are sound") {
            let found = std::fs::read_to_string(root().join(&path)).expect("a checked-in file");
            assert!(found == text, "{}: run `cargo xtask generate`", path.display());
        }
    }
}
