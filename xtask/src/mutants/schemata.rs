//! All mutants of one file in one program: compiled once instead of once for each mutant.
//!
//! The mutants are those that cargo-mutants lists. Each becomes a copy of its function, and the
//! function a switch between the copies, by a variable of the environment. The mutant of a constant
//! becomes a copy of every function that names the constant. This is for a file whose functions
//! stand at the margin, as rustfmt writes them, with names of their own and plain parameters: one
//! that is generated.

use super::equivalent::{Found, known_by, read_source};
use super::{Group, MEMORY, SECONDS, environment, minimal};
use crate::shell::{cargo, target};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// The number of the mutant that is to run, 1 for the first.
const VARIABLE: &str = "LTBW_MUTANT";

/// A change of a file.
#[derive(Debug, PartialEq, Eq)]
struct Change {
    line: usize,
    /// In characters, 1 for the first.
    column: usize,
    /// The operator that is replaced; `None`: all from here to the end of the function.
    old: Option<String>,
    new: String,
}

/// Tries all mutants of `file` (from the package); `first` are names of tests that catch most of
/// them at once.
pub(super) fn test(group: &Group, file: &str, first: &[&str]) -> Result<Found, String> {
    let folder = target().join("mutants").join(group.name);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let package = minimal::package(&group.minimal, &folder)?;
    let listed = cargo()
        .args(["mutants", "--list", "--file", file, "--dir"])
        .arg(&package)
        .output()
        .map_err(|error| format!("cargo mutants: {error}"))?;
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    // Types without a default value are not known here, but no sign has one.
    let (unviable, names): (Vec<&str>, Vec<&str>) =
        listed.lines().partition(|name| name.contains("Default::default()"));
    if names.is_empty() {
        return Err(format!("cargo-mutants lists no mutants of {file}"));
    }
    let path = package.join(file);
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    let source = fs::read_to_string(&path).map_err(failed)?;
    let changes = names.iter().map(|name| Change::parse(name)).collect::<Result<Vec<_>, _>>()?;
    fs::write(&path, schemata(&source, &changes)?).map_err(failed)?;
    let program = build(&package)?;
    let mut found = Found::default();
    let known = |name: &str| known_by(&format!("{}/{name}", group.minimal.folder), &read_source);
    for name in unviable {
        found.unviable.push(known(name)?);
    }
    if !passes(&program, 0, &["predicates::"])? {
        return Err("the tests fail without a mutant".to_string());
    }
    for (number, name) in (1..).zip(names) {
        let missed = passes(&program, number, first)? && passes(&program, number, &[])?;
        let list = if missed { &mut found.missed } else { &mut found.caught };
        list.push(known(name)?);
        if missed {
            println!("missed: {name}");
        }
    }
    Ok(found)
}

/// Compiles the tests of a package; returns the path of the program.
fn build(package: &Path) -> Result<String, String> {
    let mut command = cargo();
    environment(&mut command, &target().join("mutants"))?;
    command.current_dir(package).args(["test", "--no-run", "--lib"]);
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let program = said.lines().find_map(|line| {
        let rest = line.trim_start().strip_prefix("Executable ")?;
        rest.split_once('(')?.1.strip_suffix(')')
    });
    program.map(ToString::to_string).ok_or_else(|| format!("{command:?}: {said}"))
}

/// Do the tests of these names pass with a mutant?
fn passes(program: &str, mutant: usize, tests: &[&str]) -> Result<bool, String> {
    let mut command = Command::new("prlimit");
    environment(&mut command, Path::new(""))?;
    let status = command
        .args([format!("--cpu={SECONDS}"), format!("--as={MEMORY}")])
        .args([program, "-Z", "unstable-options", "--fail-fast"])
        .args(tests)
        .env("RUSTC_BOOTSTRAP", "1")
        .env(VARIABLE, mutant.to_string())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .map_err(|error| format!("{command:?}: {error}"))?;
    Ok(status.success())
}

impl Change {
    /// Reads a line of cargo-mutants' list: `FILE:LINE:COLUMN: replace OLD with NEW in FUNCTION`,
    /// `… delete OLD in FUNCTION`, or `… replace FUNCTION -> TYPE with NEW`.
    fn parse(name: &str) -> Result<Self, String> {
        let parse = || {
            let (place, change) = name.split_once(": ")?;
            let mut place = place.rsplit(':');
            let (column, line) = (place.next()?.parse().ok()?, place.next()?.parse().ok()?);
            let (old, new) = if let Some(rest) = change.strip_prefix("delete ") {
                (Some(rest.split(' ').next()?), "")
            } else {
                let (old, new) = change.strip_prefix("replace ")?.split_once(" with ")?;
                if old.contains(" -> ") { (None, new) } else { (Some(old), new.split(' ').next()?) }
            };
            let (old, new) = (old.map(ToString::to_string), new.to_string());
            Some(Self { line, column, old, new })
        };
        parse().ok_or_else(|| format!("cargo-mutants wrote {name:?}"))
    }

    /// The lines of a function or of a constant, of which the first has the number `first`, with
    /// the change.
    fn apply(&self, lines: &[&str], first: usize) -> Option<String> {
        let at = self.line.checked_sub(first)?;
        let line = lines.get(at)?;
        let (byte, _) = line.char_indices().nth(self.column.checked_sub(1)?)?;
        let mut changed: Vec<String> = lines[..at].iter().map(ToString::to_string).collect();
        match &self.old {
            Some(old) => {
                let rest = line[byte..].strip_prefix(old.as_str())?;
                changed.push(format!("{}{}{rest}", &line[..byte], self.new));
                changed.extend(lines[at + 1..].iter().map(ToString::to_string));
            }
            None => changed.push(format!("{}{}\n}}", &line[..byte], self.new)),
        }
        Some(changed.join("\n"))
    }
}

/// The source with each function as a switch between itself and its mutants.
fn schemata(source: &str, changes: &[Change]) -> Result<String, String> {
    let lines: Vec<&str> = source.lines().collect();
    let mut text = String::new();
    let mut used = vec![false; changes.len()];
    let mut at = 0;
    while at < lines.len() {
        let line = lines[at];
        if !line.starts_with("fn ") && !line.starts_with("pub fn ") {
            text.push_str(&format!("{line}\n"));
            at += 1;
            continue;
        }
        let end = lines[at..].iter().position(|line| *line == "}").map(|n| at + n + 1);
        let body = &lines[at..end.ok_or("a function without an end")?];
        let mut copies = Vec::new();
        for (k, change) in changes.iter().enumerate() {
            let copy = if (at + 1..=at + body.len()).contains(&change.line) {
                change.apply(body, at + 1)
            } else {
                constant(&lines, change).and_then(|(name, value)| {
                    let body = body.join("\n");
                    body.contains(name).then(|| body.replace(name, &format!("({value})")))
                })
            };
            if let Some(copy) = copy {
                used[k] = true;
                copies.push(Copied { number: k + 1, text: copy });
            }
        }
        text.push_str(&switch(&body.join("\n"), &copies)?);
        at += body.len();
    }
    if let Some(k) = used.iter().position(|used| !used) {
        return Err(format!("no place for {:?}", changes[k]));
    }
    Ok(format!(
        "{text}\nstatic MUTANT: std::sync::LazyLock<usize> = std::sync::LazyLock::new(|| {{\n    \
         std::env::var(\"{VARIABLE}\").ok().and_then(|n| n.parse().ok()).unwrap_or(0)\n}});\n"
    ))
}

/// The constant that a change is about, and its value with the change.
fn constant<'a>(lines: &[&'a str], change: &Change) -> Option<(&'a str, String)> {
    let line = *lines.get(change.line.checked_sub(1)?)?;
    let name = line.strip_prefix("pub const ")?.split(':').next()?;
    let changed = change.apply(&[line], change.line)?;
    Some((name, changed.split_once("= ")?.1.trim_end_matches(';').to_string()))
}

/// A changed copy of a function.
struct Copied {
    /// The number of the change.
    number: usize,
    text: String,
}

/// A function, its copies, and the switch between them under its name.
fn switch(function: &str, copies: &[Copied]) -> Result<String, String> {
    let parts = || {
        let (head, _) = function.split_once('{')?;
        let (before, rest) = head.split_once('(')?;
        let name = before.split_once("fn ")?.1;
        let (parameters, result) = rest.rsplit_once(") ->")?;
        Some((before, name, types(parameters), result.trim()))
    };
    let (before, name, types, result) = parts().ok_or("a function of another form")?;
    let numbered = |n: usize, text: &str| {
        let text = text.strip_prefix("pub ").unwrap_or(text);
        text.replacen(&format!("fn {name}("), &format!("fn {name}_{n}("), 1)
    };
    let parameters: Vec<String> =
        types.iter().enumerate().map(|(k, t)| format!("p{k}: {t}")).collect();
    let passed: Vec<String> = (0..types.len()).map(|k| format!("p{k}")).collect();
    let passed = passed.join(", ");
    let mut text = format!("{before}({}) -> {result} {{\n", parameters.join(", "));
    text.push_str("    match *MUTANT {\n");
    for Copied { number: n, .. } in copies {
        text.push_str(&format!("        {n} => {name}_{n}({passed}),\n"));
    }
    text.push_str(&format!("        _ => {name}_0({passed}),\n    }}\n}}\n"));
    text.push_str(&format!("{}\n", numbered(0, function)));
    for Copied { number, text: copy } in copies {
        text.push_str(&format!("{}\n", numbered(*number, copy)));
    }
    Ok(text)
}

/// The types of parameters: what follows the colons outside brackets.
fn types(parameters: &str) -> Vec<String> {
    let (mut types, mut depth, mut current) = (Vec::new(), 0, None::<String>);
    for c in parameters.chars() {
        match c {
            '[' | '(' => depth += 1,
            ']' | ')' => depth -= 1,
            _ => {}
        }
        match (c, depth, &mut current) {
            (':', 0, None) => current = Some(String::new()),
            (',', 0, _) => types.extend(current.take()),
            (_, _, Some(text)) => text.push(c),
            _ => {}
        }
    }
    types.extend(current);
    types.iter().map(|t| t.trim().to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "\
pub const C: f64 = 2.0 * U;

/// About f.
#[inline(always)]
pub fn f([x, y]: [f64; 2], z: f64) -> f64 {
    let w = x * y;
    C * w - z
}
";

    #[test]
    fn lines_of_the_list_are_read() {
        let change = |line, column, old: Option<&str>, new: &str| Change {
            line,
            column,
            old: old.map(ToString::to_string),
            new: new.to_string(),
        };
        for (name, expected) in [
            ("a/b.rs:6:15: replace * with + in f", change(6, 15, Some("*"), "+")),
            ("a/b.rs:1:24: replace * with /", change(1, 24, Some("*"), "/")),
            ("a/b.rs:7:5: delete - in f", change(7, 5, Some("-"), "")),
            ("b.rs:6:5: replace f -> Option<S> with (0.0, [1.0; 3])", {
                change(6, 5, None, "(0.0, [1.0; 3])")
            }),
        ] {
            assert_eq!(Change::parse(name), Ok(expected));
        }
        assert!(Change::parse("b.rs:6: replace").is_err());
    }

    #[test]
    fn every_mutant_becomes_a_copy() {
        let names = [
            "x.rs:6:15: replace * with + in f",
            "x.rs:1:24: replace * with /",
            "x.rs:6:5: replace f -> f64 with -1.0",
        ];
        let changes: Vec<Change> =
            names.iter().map(|name| Change::parse(name).expect("a change")).collect();
        let expected = "\
pub const C: f64 = 2.0 * U;

/// About f.
#[inline(always)]
pub fn f(p0: [f64; 2], p1: f64) -> f64 {
    match *MUTANT {
        1 => f_1(p0, p1),
        2 => f_2(p0, p1),
        3 => f_3(p0, p1),
        _ => f_0(p0, p1),
    }
}
fn f_0([x, y]: [f64; 2], z: f64) -> f64 {
    let w = x * y;
    C * w - z
}
fn f_1([x, y]: [f64; 2], z: f64) -> f64 {
    let w = x + y;
    C * w - z
}
fn f_2([x, y]: [f64; 2], z: f64) -> f64 {
    let w = x * y;
    (2.0 / U) * w - z
}
fn f_3([x, y]: [f64; 2], z: f64) -> f64 {
    -1.0
}
";
        let text = schemata(SOURCE, &changes).expect("a program");
        assert!(text.starts_with(expected), "{text}");
        let nowhere = Change { line: 2, column: 1, old: None, new: String::new() };
        assert!(schemata(SOURCE, &[nowhere]).is_err());
        let other = Change { line: 6, column: 15, old: Some("+".into()), new: "*".into() };
        assert!(schemata(SOURCE, &[other]).is_err());
    }
}
