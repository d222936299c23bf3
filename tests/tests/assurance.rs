//! The names in docs/assurance-case.md exist: its commands, their test programs, examples and
//! filters, and as many tests as it says.

use std::fs;
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../docs/assurance-case.md");
const XTASK: &str = include_str!("../../xtask/src/commands.rs");
const KINDS: [&str; 4] = ["proved", "exhaustive", "statistical", "argued"];

/// A row of evidence.
struct Row {
    claim: &'static str,
    kind: &'static str,
    evidence: &'static str,
    prints: &'static str,
}

/// The rows of all tables of evidence.
fn rows() -> Vec<Row> {
    let lines = PAGE.lines().map(|line| line.trim_matches(['|', ' ']));
    let cells = lines.map(|line| line.split(" | ").map(str::trim).collect::<Vec<_>>());
    let mut rows = Vec::new();
    let mut inside = false;
    for cells in cells {
        match cells[..] {
            ["claim", "kind", "evidence", "prints"] => inside = true,
            [claim, kind, evidence, prints] if inside => {
                rows.push(Row { claim, kind, evidence, prints });
            }
            // The last cell of an argued claim is empty.
            [claim, kind, evidence] if inside => {
                rows.push(Row { claim, kind, evidence, prints: "" });
            }
            [rule] if rule.starts_with("---") => {}
            _ => inside = false,
        }
    }
    rows
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a package of the workspace").into()
}

/// The folder of a package of the workspace.
fn folder(package: &str) -> PathBuf {
    let name = format!("name = \"{package}\"");
    let core =
        ["exact", "kernel", "domain", "refine", "formats", "generate"].map(|c| format!("core/{c}"));
    let rest =
        ["parallel", "verify/checker", "verify/models", "verify/kit", "cli", "xtask", "tests"];
    let found =
        core.into_iter().chain(rest.map(String::from)).map(|folder| root().join(folder)).find(
            |folder| {
                let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
                manifest.lines().any(|line| line == name)
            },
        );
    found.unwrap_or_else(|| panic!("no package {package}"))
}

/// The text of every Rust file below `folder`.
fn sources(folder: &Path) -> String {
    let mut text = String::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            text.push_str(&sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            text.push_str(&fs::read_to_string(&path).expect("a source"));
        }
    }
    text
}

/// Is there a test, or a module of tests, of which `name` is the name or its beginning?
fn has_test(sources: &str, name: &str) -> bool {
    sources.contains(&format!("fn {name}")) || sources.contains(&format!("mod {name}"))
}

/// The text of a module of the tests of a package, and the rest of the name that begins with it.
fn module<'a>(folder: &Path, name: &'a str) -> (String, &'a str) {
    let (module, rest) = name.split_once("::").unwrap_or_else(|| panic!("{name}: no module"));
    let tests = folder.join("tests");
    let main = fs::read_to_string(tests.join("main.rs")).expect("the list of modules");
    // A filter is a part of a name: another module that ends so would run, too.
    let of = |line: &str| Some(line.strip_prefix("mod ")?.strip_suffix(';')?.ends_with(module));
    let count = main.lines().filter(|line| of(line) == Some(true)).count();
    assert!(count == 1, "{count} modules end with {module}");
    let path = tests.join(format!("{module}.rs"));
    (fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}")), rest)
}

/// The number of tests in a text that are not ignored.
fn count_tests(text: &str) -> usize {
    let count = |start: &str| text.lines().filter(|l| l.trim().starts_with(start)).count();
    count("#[test]") - count("#[ignore")
}

/// Checks `cargo test` with its arguments; returns how many tests it runs, where that is known.
fn check_test(args: &[&str]) -> Option<usize> {
    let (mut package, mut program, mut lib, mut filters) = (None, None, false, Vec::new());
    let mut args = args.iter().copied();
    while let Some(arg) = args.next() {
        match arg {
            "-p" => package = args.next(),
            "--test" => program = args.next(),
            "--lib" => lib = true,
            "--release" | "--" | "--nocapture" | "--include-ignored" => {}
            name => {
                assert!(!name.starts_with('-'), "what is {name}?");
                filters.push(name);
            }
        }
    }
    let folder = folder(package.expect("a package"));
    if let Some(program) = program.filter(|_| !lib) {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
        let target = format!("name = \"{program}\"\npath = \"tests/main.rs\"");
        assert!(manifest.contains(&target), "no test program {program}");
        assert!(!filters.is_empty(), "which module?");
        return filters.iter().try_fold(0, |sum, filter| {
            let (text, rest) = module(&folder, filter);
            assert!(rest.is_empty() || has_test(&text, rest), "no test {filter}");
            let is_one = text.contains(&format!("fn {rest}("));
            let count = if rest.is_empty() { Some(count_tests(&text)) } else { None };
            Some(sum + count.or(is_one.then_some(1))?)
        });
    }
    // A command without library and test program runs all of the package.
    let text = sources(&folder.join("src"));
    let &[name] = filters.as_slice() else {
        assert!(filters.is_empty() && !text.is_empty(), "no tests");
        return None;
    };
    assert!(has_test(&text, name), "no test {name}");
    text.contains(&format!("fn {name}(")).then_some(1)
}

/// Checks one command; returns how many tests it runs, where that is known.
fn check(command: &str) -> Option<usize> {
    let words: Vec<&str> = command.split(' ').filter(|word| !word.contains('=')).collect();
    match words[..] {
        ["cargo", "xtask", name, ..] => {
            assert!(XTASK.contains(&format!("name: \"{name}\"")), "no such command of xtask");
            None
        }
        ["cargo", "test", ref args @ ..] => check_test(args),
        ["cargo", "run", "--release", "-p", package, "--example", name, ..] => {
            let path = folder(package).join("examples").join(format!("{name}.rs"));
            assert!(path.is_file(), "no example {name}");
            None
        }
        ["cargo", "run", "--release", "-p", "ltbw-cli", "--", name, ..] => {
            let variant = name[..1].to_uppercase() + &name[1..];
            let found = sources(&folder("ltbw-cli").join("src")).contains(&variant);
            assert!(found, "no such command of the program");
            None
        }
        _ => panic!("what is this?"),
    }
}

/// The text in backquotes, if that is all of it.
fn code(cell: &'static str) -> Option<&'static str> {
    cell.strip_prefix('`')?.strip_suffix('`').filter(|code| !code.contains('`'))
}

#[test]
fn its_commands_exist_and_run_the_tests_that_it_counts() {
    let (mut commands, mut counts, mut others) = (0, 0, Vec::new());
    for row in rows() {
        let Some(command) = code(row.evidence).filter(|code| code.contains("cargo ")) else {
            continue;
        };
        println!("{command}");
        commands += 1;
        let count = check(command);
        let said = code(row.prints).and_then(|code| code.strip_suffix(" passed"));
        if let (Some(count), Some(said)) = (count, said) {
            let said: usize = said.parse().expect("a number of tests");
            if said != count {
                others.push(format!("{command}: {said} passed, but there are {count} tests"));
            }
            counts += 1;
        }
    }
    assert_eq!(others, [""; 0]);
    assert!(commands >= 25 && counts >= 15, "{commands} commands, {counts} with a count");
}

#[test]
fn every_claim_has_a_kind_and_evidence_of_that_kind() {
    for Row { claim, kind, evidence, prints } in rows() {
        let word = kind.split(',').next().unwrap_or_default();
        assert!(KINDS.contains(&word), "{claim}: {kind}");
        let command = code(evidence).is_some_and(|code| code.contains("cargo "));
        assert_eq!(command, word != "argued", "{claim}: {evidence}");
        assert_eq!(command, !prints.is_empty(), "{claim}: what does it print?");
    }
}

#[test]
fn what_is_argued_is_written_down() {
    for row in rows().iter().filter(|row| row.kind == "argued") {
        let path = row.evidence.split('`').nth(1).expect("a file");
        let text = fs::read_to_string(root().join(path)).expect(path);
        if let Some((_, section)) = row.evidence.split_once("section *") {
            let section = section.trim_end_matches('*');
            let heading = text.lines().any(|line| {
                line.trim_start_matches(['/', '!', ' ', '#']) == section && line.contains('#')
            });
            assert!(heading, "{path} has no section {section}");
        }
    }
}

#[test]
fn its_links_lead_to_pages() {
    let links = PAGE.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let mut count = 0;
    for link in links {
        let file = link.split('#').next().unwrap_or_default();
        assert!(root().join("docs").join(file).is_file(), "{link}");
        count += 1;
    }
    assert!(count >= 5, "{count} links");
}
