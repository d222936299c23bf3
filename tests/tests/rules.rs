//! The rules and invariants of the protocol have one number each: in `docs/protocol.md`, beside the
//! code that obeys, on the known-bad variant that breaks, and on the check of the invariant.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All Rust files below a folder, with their text.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|ext| ext == "rs") {
            found.push((path.clone(), fs::read_to_string(&path).expect("text")));
        }
    }
    found
}

/// The rules as the code has them: name and number, from the doc comment.
fn rules() -> BTreeMap<String, String> {
    let (mut rules, mut number) = (BTreeMap::new(), None);
    for line in read("parallel/src/protocol/rules.rs").lines().map(str::trim) {
        if let Some((first, _)) = line.strip_prefix("/// R").and_then(|rest| rest.split_once(':')) {
            number = Some(format!("R{first}"));
        }
        if let Some((name, _)) = line.strip_prefix("fn ").and_then(|rest| rest.split_once(';')) {
            let number = number.take().unwrap_or_else(|| panic!("{name} has no number"));
            assert_eq!(rules.insert(name.to_owned(), number), None);
        }
    }
    rules
}

/// The rows of the page's tables that begin with this letter and a number: number, and the rest.
fn rows(letter: char) -> BTreeMap<String, String> {
    let page = read("docs/protocol.md");
    let rows = page.lines().filter_map(|line| line.strip_prefix("| ")?.split_once(" | "));
    let numbered =
        |number: &str| number.strip_prefix(letter).is_some_and(|rest| rest.parse::<u32>().is_ok());
    let rows = rows.filter(|(number, _)| numbered(number));
    rows.map(|(number, rest)| (number.to_owned(), rest.to_owned())).collect()
}

#[test]
fn every_rule_has_its_number_on_the_page_and_on_one_variant() {
    let rules = rules();
    let numbers: BTreeSet<String> = (1..=rules.len()).map(|k| format!("R{k}")).collect();
    assert_eq!(rules.values().cloned().collect::<BTreeSet<_>>(), numbers, "one after the other");

    let page: BTreeMap<String, String> = rows('R')
        .into_iter()
        .map(|(number, rest)| (rest.split('`').nth(1).unwrap_or_default().to_owned(), number))
        .collect();
    assert_eq!(page, rules, "docs/protocol.md");

    // `R5 keeps_place: LostPlace, "...";`
    let variants = read("verify/models/src/variants.rs");
    let variants: Vec<(&str, &str)> = variants
        .lines()
        .filter_map(|line| line.trim().split_once(": ")?.0.split_once(' '))
        .filter(|(number, _)| numbers.contains(*number))
        .collect();
    let mut of: BTreeMap<String, String> = BTreeMap::new();
    for (number, name) in variants {
        assert_eq!(of.insert(name.to_owned(), number.to_owned()), None, "{name} twice");
    }
    assert_eq!(of, rules, "verify/models/src/variants.rs");
    let tests = sources(&root().join("verify/models/tests"));
    for line in read("verify/models/src/variants.rs").lines() {
        let Some((left, right)) = line.trim().split_once(": ") else { continue };
        let (Some((number, _)), Some((variant, _))) = (left.split_once(' '), right.split_once(','))
        else {
            continue;
        };
        let is_caught = tests.iter().any(|(_, text)| text.contains(variant));
        assert!(!numbers.contains(number) || is_caught, "{number}: no test catches {variant}");
    }
}

/// The number of a rule stands where the code asks for it: on that line, or on a line above it in
/// the same paragraph.
#[test]
fn the_code_that_obeys_a_rule_says_its_number() {
    let rules = rules();
    let mut obeyed = BTreeSet::new();
    for (path, text) in sources(&root().join("parallel/src")) {
        let lines: Vec<&str> = text.lines().collect();
        for (k, line) in lines.iter().enumerate() {
            for (name, number) in &rules {
                if !line.contains(&format!("C::{name}")) && !line.contains(&format!("D::{name}")) {
                    continue;
                }
                obeyed.insert(name.clone());
                let near = lines[k.saturating_sub(40)..=k].iter().rev();
                let function = near.take_while(|line| !line.trim().is_empty());
                let said = function.flat_map(|line| line.split(|c: char| !c.is_alphanumeric()));
                let says = said.into_iter().any(|word| word == number);
                assert!(says, "{}:{}: {number} is not named", path.display(), k + 1);
            }
        }
    }
    let all: BTreeSet<String> = rules.into_keys().collect();
    let by_submesh = BTreeSet::from(["fresh_names".to_owned()]);
    assert_eq!(&obeyed | &by_submesh, all, "rules that no code asks for");
}

#[test]
fn every_invariant_has_its_row_and_its_check() {
    let page: BTreeSet<String> = rows('P').into_keys().collect();
    let all: BTreeSet<String> =
        ltbw::protocol::Invariant::ALL.iter().map(ToString::to_string).collect();
    assert_eq!(page, all);
    let check = read("parallel/src/check/mod.rs");
    for number in &all {
        let name = format!("check_{}", number.to_lowercase());
        assert!(check.contains(&format!("fn {name}(")), "no {name}");
        assert!(check.contains(&format!("Self::{name},")), "{name} is not called");
        assert!(check.contains(&format!("Invariant::{number},")), "{name} reports another one");
    }
    // The assertions of the code are on the page.
    for (path, text) in sources(&root().join("parallel/src")) {
        for part in text.split("invariant!(").skip(1) {
            let number: String = part.trim_start().chars().take_while(|c| *c != ',').collect();
            let known =
                all.contains(&number) || number.starts_with('$') || !number.starts_with('P');
            assert!(known, "{}: {number}", path.display());
        }
    }
}

#[test]
fn the_page_is_short_enough_to_be_read() {
    let lines = read("docs/protocol.md").lines().count();
    assert!(lines <= 250, "{lines} lines");
}
