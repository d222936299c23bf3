//! The list of mutants that no test can catch, and its comparison with what was found.
//!
//! A mutant is known by its file, what was replaced by what, and the line of source with a mark
//! `»` at the place of the change. Line numbers are left out: they change with every edit above.

use crate::shell::root;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Mutants as cargo-mutants sorts them, in the form of [`known_by`].
#[derive(Default)]
pub(super) struct Found {
    pub(super) caught: Vec<String>,
    pub(super) missed: Vec<String>,
    pub(super) timeout: Vec<String>,
    pub(super) unviable: Vec<String>,
}

impl Found {
    /// Reads the lists in `folder`, which cargo-mutants wrote; its paths start in
    /// the folder `below`.
    pub(super) fn read(folder: &Path, below: &str) -> Result<Self, String> {
        let list = |name: &str| -> Result<Vec<String>, String> {
            let path = folder.join(name);
            let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            text.lines().map(|line| known_by(&format!("{below}/{line}"), &read_source)).collect()
        };
        Ok(Self {
            caught: list("caught.txt")?,
            missed: list("missed.txt")?,
            timeout: list("timeout.txt")?,
            unviable: list("unviable.txt")?,
        })
    }
}

pub(super) fn read_source(file: &str) -> Result<String, String> {
    fs::read_to_string(root().join(file)).map_err(|error| format!("{file}: {error}"))
}

/// The name of a mutant by its line's text: `x.rs:5:9: replace + with - in f` becomes
/// `x.rs: replace + with - in f: a »+ b`.
pub(super) fn known_by(
    mutant: &str,
    source: &impl Fn(&str) -> Result<String, String>,
) -> Result<String, String> {
    let unknown = || format!("cargo-mutants wrote {mutant:?}");
    let (place, change) = mutant.split_once(": ").ok_or_else(unknown)?;
    let mut parts = place.split(':');
    let (Some(file), Some(line), Some(column), None) =
        (parts.next(), parts.next(), parts.next(), parts.next())
    else {
        return Err(unknown());
    };
    let line: usize = line.parse().map_err(|_| unknown())?;
    let column: usize = column.parse().map_err(|_| unknown())?;
    let text = source(file)?;
    let text = text.lines().nth(line.wrapping_sub(1)).ok_or_else(unknown)?;
    let (before, after): (String, String) = (
        text.chars().take(column.saturating_sub(1)).collect(),
        text.chars().skip(column.saturating_sub(1)).collect(),
    );
    Ok(format!("{file}: {change}: {}»{}", before.trim_start(), after.trim_end()))
}

/// The equivalent mutants of the list `path`, each with its reason.
///
/// Paragraphs of a reason (lines that start with `#`) and the mutants it holds for.
pub(super) fn read(path: &Path) -> Result<BTreeMap<String, String>, String> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    parse(&text)
}

fn parse(text: &str) -> Result<BTreeMap<String, String>, String> {
    let mut equivalent = BTreeMap::new();
    for paragraph in text.split("\n\n") {
        let (reason, mutants): (Vec<&str>, Vec<&str>) =
            paragraph.lines().filter(|line| !line.is_empty()).partition(|l| l.starts_with('#'));
        for mutant in mutants {
            if reason.is_empty() {
                return Err(format!("xtask/mutants.txt: no reason for {mutant}"));
            }
            if equivalent.insert(mutant.to_string(), reason.join("\n")).is_some() {
                return Err(format!("xtask/mutants.txt: twice: {mutant}"));
            }
        }
    }
    Ok(equivalent)
}

/// The differences: survivors that are not equivalent, equivalent ones that did not survive. If
/// `whole`, all mutants of the files for which `tried` holds were tried: an excuse for one that is
/// not among them is out of date.
pub(super) fn compare(
    equivalent: &BTreeMap<String, String>,
    found: &Found,
    whole: bool,
    tried: impl Fn(&str) -> bool,
) -> Result<Vec<String>, String> {
    let missed: BTreeSet<&String> = found.missed.iter().collect();
    let dead: BTreeSet<&String> = found.caught.iter().collect();
    let mut wrong: Vec<String> =
        found.timeout.iter().map(|mutant| format!("no verdict in time: {mutant}")).collect();
    for mutant in &missed {
        if !equivalent.contains_key(*mutant) {
            wrong.push(format!("not caught: {mutant}"));
        }
    }
    for mutant in equivalent.keys() {
        let file = mutant.split(": ").next().unwrap_or_default();
        if dead.contains(mutant) && !missed.contains(mutant) {
            wrong.push(format!("in the list, but caught: {mutant}"));
        } else if whole && tried(file) && !missed.contains(mutant) {
            wrong.push(format!("in the list, but there is no such mutant: {mutant}"));
        }
    }
    Ok(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(_: &str) -> Result<String, String> {
        Ok("fn f() {\n    a + b\n}\n".to_string())
    }

    #[test]
    fn a_mutant_is_known_by_its_line_and_place() {
        let known = known_by("core/kernel/src/x.rs:2:7: replace + with - in f", &source);
        assert_eq!(known.as_deref(), Ok("core/kernel/src/x.rs: replace + with - in f: a »+ b"));
        for wrong in ["", "x.rs:1: y", "x.rs:9:1: past the end", "x.rs:a:1: y", "x.rs:1:1:1: y"] {
            assert!(known_by(wrong, &source).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_list_gives_reasons() {
        let list = parse("# why\n# so\na.rs: x: »y\nb.rs: x: »y\n\n# other\nc.rs: x: »y\n");
        let list = list.expect("a list");
        assert_eq!(list.len(), 3);
        assert_eq!(list["a.rs: x: »y"], "# why\n# so");
        assert_eq!(list["c.rs: x: »y"], "# other");
        assert!(parse("a.rs: x: »y\n").is_err(), "without a reason");
        assert!(parse("# r\na.rs: x: »y\na.rs: x: »y\n").is_err(), "twice");
    }

    #[test]
    fn survivors_and_stale_excuses_are_wrong() {
        let names = |list: &[&str]| list.iter().map(|name| (*name).to_string()).collect();
        let equivalent = parse("# r\na.rs: 1\na.rs: 2\na.rs: 3\nb.rs: 1\n").expect("a list");
        let found = Found {
            caught: names(&["a.rs: 2", "a.rs: 8"]),
            missed: names(&["a.rs: 1", "a.rs: 9"]),
            timeout: names(&["a.rs: 7"]),
            ..Found::default()
        };
        let wrong =
            |whole| compare(&equivalent, &found, whole, |file| file == "a.rs").expect("lists");
        let part = [
            "no verdict in time: a.rs: 7",
            "not caught: a.rs: 9",
            "in the list, but caught: a.rs: 2",
        ];
        assert_eq!(wrong(false), part);
        let gone = "in the list, but there is no such mutant: a.rs: 3";
        assert_eq!(wrong(true), [part[0], part[1], part[2], gone]);
    }
}
