//! Pages of decisions: short ones, each a line of the index. The page of tests: each file of these
//! is behind one of its questions.

use super::source::Tree;

/// The folder of the pages, and its index.
const FOLDER: &str = "docs/decisions/";
const INDEX: &str = "docs/decisions/README.md";

/// Lines of a page of a decision.
pub(crate) const LINES: usize = 30;

/// Pages of decisions that are too long, not called `NN-subject.md`, without the word that says
/// whether the decision stands, or not in the index once; and pages that the index alone knows.
pub(crate) fn faults(tree: &Tree) -> Vec<String> {
    let index = tree.0.get(INDEX).map_or("", String::as_str);
    let links: Vec<&str> =
        index.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|l| l.0).collect();
    let pages = tree.0.iter().filter_map(|(path, text)| Some((path.strip_prefix(FOLDER)?, text)));
    let pages: Vec<(&str, &String)> = pages.filter(|(name, _)| *name != "README.md").collect();
    let mut found = Vec::new();
    for (k, &(name, text)) in pages.iter().enumerate() {
        let number = name.split('-').next().unwrap_or_default();
        let is_number = number.len() == 2 && number.bytes().all(|digit| digit.is_ascii_digit());
        let is_taken = k > 0 && pages[k - 1].0.starts_with(&format!("{number}-"));
        if !is_number || !text.starts_with(&format!("# {number}. ")) || is_taken {
            found.push(format!("{name}: a number of its own, in the name and in the title"));
        }
        if text.lines().count() > LINES {
            found.push(format!("{name}: {} lines", text.lines().count()));
        }
        if !["**Stands.**", "**Replaced"].iter().any(|status| text.contains(status)) {
            found.push(format!("{name}: does it stand?"));
        }
        if links.iter().filter(|&&link| link == name).count() != 1 {
            found.push(format!("{name}: not in the index once"));
        }
    }
    let is_gone = |link: &str| !link.contains('/') && !pages.iter().any(|(name, _)| *name == link);
    let gone = links.iter().filter(|link| is_gone(link));
    found.extend(gone.map(|link| format!("{link}: in the index alone")));
    found
}

/// Files of tests behind none of the questions; files and folders that are not there. In a row a
/// name alone is in the folder of the path before.
pub(crate) fn without_question(tree: &Tree, page: &str) -> Vec<String> {
    let text = tree.0.get(page).map_or("", String::as_str);
    let mut told: Vec<String> = Vec::new();
    for row in text.lines().filter(|line| line.starts_with('|')) {
        let mut folder = "";
        for code in row.split('`').skip(1).step_by(2).filter(|code| !code.contains(' ')) {
            match code.rsplit_once('/') {
                Some((own, file)) if file.ends_with(".rs") => {
                    folder = own;
                    told.push(code.to_owned());
                }
                Some(_) => told.push(format!("{code}/")),
                None => told.push(format!("{folder}/{code}")),
            }
        }
    }
    let is_told = |path: &str| {
        told.iter().any(|own| own == path || own.ends_with('/') && path.starts_with(own.as_str()))
    };
    let is_there = |own: &String| {
        let is_it = |path: &String| path == own || own.ends_with('/') && path.starts_with(own);
        own.starts_with("bindings/python/") || tree.0.keys().any(is_it)
    };
    // A program of a crate, not a part of one of its modules.
    let is_test = |path: &str| {
        let file = path.split_once("/tests/");
        file.is_some_and(|(folder, file)| {
            !format!("/{folder}/").contains("/src/") && !file.contains('/') && file != "main.rs"
        })
    };
    let untold =
        tree.rust("").map(|(path, _)| path).filter(|&path| is_test(path) && !is_told(path));
    let mut found: Vec<String> = untold.map(|path| format!("{path}: no question")).collect();
    found.extend(told.iter().filter(|own| !is_there(own)).map(|own| format!("{own}: not there")));
    found
}

#[test]
fn files_of_tests_without_a_question_are_found() {
    let faults_of = |row: &str| {
        let page = format!("`x/tests/no.rs`\n| question | file |\n|---|---|\n| Is it? | {row} |\n");
        let files = ["a/tests/one.rs", "a/tests/two.rs", "b/c/tests/one.rs", "b/c/tests/more/d.rs"];
        let mut all: Vec<(&str, &str)> = files.iter().map(|&file| (file, "")).collect();
        all.extend([("a/tests/main.rs", ""), ("a/src/tests/e.rs", ""), ("T.md", &page)]);
        without_question(&Tree::of(&all), "T.md")
    };
    assert_eq!(faults_of("`b/c/tests`; `a/tests/one.rs`, `two.rs`, `cargo test`"), [""; 0]);
    assert_eq!(faults_of("`b/c/tests/one.rs`; `a/tests`"), [""; 0]);
    assert_eq!(faults_of("`a/tests/two.rs`, `b/c/tests`"), ["a/tests/one.rs: no question"]);
    let gone = ["a/tests/three.rs: not there", "b/tests/: not there"];
    assert_eq!(faults_of("`a/tests`, `b/c/tests`, `a/tests/three.rs`, `b/tests`"), gone);
}

#[test]
fn faults_of_decisions_are_found() {
    let page = |number: &str, lines: usize| {
        format!("# {number}. Title\n\n**Stands.**\n{}", "x\n".repeat(lines - 3))
    };
    let faults_of = |files: &[(&str, &str)]| {
        let index = ("README.md", "[a](../refinement.md#x)\n[01](01-a.md)\n[02](02-b.md)\n");
        let files: Vec<(String, &str)> =
            files.iter().chain([&index]).map(|&(name, t)| (format!("{FOLDER}{name}"), t)).collect();
        faults(&Tree::of(&files.iter().map(|(name, t)| (&**name, *t)).collect::<Vec<_>>()))
    };
    let (a, b, long) = (page("01", LINES), page("02", 4), page("02", LINES + 1));
    assert_eq!(faults_of(&[("01-a.md", &a), ("02-b.md", &b)]), [""; 0]);
    assert_eq!(faults_of(&[("01-a.md", &a), ("02-b.md", &long)]), ["02-b.md: 31 lines"]);
    assert_eq!(faults_of(&[("01-a.md", &a)]), ["02-b.md: in the index alone"]);
    let number = "a number of its own, in the name and in the title";
    let third = [("01-a.md", &*a), ("02-b.md", &b), ("02-c.md", &b)];
    let expected = [format!("02-c.md: {number}"), "02-c.md: not in the index once".into()];
    assert_eq!(faults_of(&third), expected);
    let stands = ("02-b.md", "# 02. Title\n");
    assert_eq!(faults_of(&[("01-a.md", &a), stands]), ["02-b.md: does it stand?"]);
    let untitled = ("02-b.md", "# Title\n**Stands.**\n");
    assert_eq!(faults_of(&[("01-a.md", &a), untitled]), [format!("02-b.md: {number}")]);
}
