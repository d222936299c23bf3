//! `generate`: writes what is generated from the descriptions of the predicates. A test, and
//! `prove` before it proves anything, compare what is checked in.

use crate::predicates;
use crate::shell::{command, root};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// Writes every generated file.
pub(crate) fn run() -> Result<(), String> {
    for Generated { path, text } in files()? {
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

/// A generated file.
pub(crate) struct Generated {
    /// Its path in the workspace.
    pub(crate) path: PathBuf,
    pub(crate) text: String,
}

/// Every generated file.
pub(crate) fn files() -> Result<Vec<Generated>, String> {
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
    Ok(files.into_iter().map(|(path, text)| Generated { path, text }).collect())
}

/// Compares every generated file with what `read` finds at its path. Returns how many there are.
///
/// # Errors
/// The first line that is another one: somebody has changed it by hand.
pub(crate) fn compare(
    files: &[Generated],
    read: impl Fn(&Path) -> std::io::Result<String>,
) -> Result<usize, String> {
    for Generated { path, text } in files {
        let name = path.display();
        let found = read(path).map_err(|error| format!("{name}: {error}"))?;
        if found != *text {
            let same = |(found, text): &(&str, &str)| found == text;
            let line = 1 + found.lines().zip(text.lines()).take_while(same).count();
            let there = |text: &str| text.lines().nth(line - 1).unwrap_or("(the end)").to_owned();
            return Err(format!(
                "{name}:{line} is not what its description says: `{}` instead of `{}`; `cargo \
                 xtask generate` writes it anew",
                there(&found),
                there(text),
            ));
        }
    }
    Ok(files.len())
}

/// The text in the tree.
pub(crate) fn checked_in(path: &Path) -> std::io::Result<String> {
    fs::read_to_string(root().join(path))
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
    use super::{Generated, checked_in, compare, files};
    use std::path::Path;

    #[test]
    fn checked_in_files_are_the_generated_ones() {
        let files = files().expect("the descriptions are sound");
        assert_eq!(compare(&files, checked_in), Ok(files.len()));
    }

    /// A number of a line `const NAME: .. = NUMBER..`, made smaller by its last digit but zeros.
    fn lowered(line: &str) -> Option<String> {
        let is_constant = line.contains("const ") || line.starts_with("Definition ");
        let value = line.find('=').filter(|_| is_constant)?;
        let digit = value + line[value..].find(|c| ('1'..='9').contains(&c))?;
        let smaller = char::from(line.as_bytes()[digit] - 1);
        Some(format!("{}{smaller}{}", &line[..digit], &line[digit + 1..]))
    }

    /// `prove` begins with this comparison: a constant that is lowered by hand, in the kernel's
    /// source or in the proofs', never gets as far as a proof about another one.
    #[test]
    fn a_constant_lowered_by_hand_is_found() {
        let files = files().expect("the descriptions are sound");
        let mut constants = 0;
        for Generated { path, text } in &files {
            for (k, line) in text.lines().enumerate() {
                let Some(other) = lowered(line) else { continue };
                constants += 1;
                let changed = |asked: &Path| match asked == path {
                    true => Ok(text.replacen(line, &other, 1)),
                    false => checked_in(asked),
                };
                let error = compare(&files, changed).expect_err("a lowered constant");
                let place = format!("{}:{} is not what", path.display(), k + 1);
                assert!(error.starts_with(&place) && error.contains(&other), "{error}");
            }
        }
        assert!(constants >= 18, "{constants}");
        // A file that is not there, and one that ends early.
        let missing = |_: &Path| Err(std::io::ErrorKind::NotFound.into());
        assert!(compare(&files, missing).is_err());
        let cut = |path: &Path| checked_in(path).map(|text| text[..text.len() - 1].to_owned());
        assert!(compare(&files, cut).is_err());
    }
}
