//! The house rules, held by reading the sources: which way crates and modules lean, how long files
//! and lines are, which parameters functions have, where atomics are, which dependencies are used,
//! which words comments do without, how long a page of a decision is, which command prints a table.
//!
//! Each rule has a test with a planted violation beside its code in `tidy/`. An exception is listed
//! here with its reason; one that is not needed any more fails, too.

#[path = "tidy/arrows.rs"]
mod arrows;
#[path = "tidy/figures.rs"]
mod figures;
#[path = "tidy/manifest.rs"]
mod manifest;
#[path = "tidy/pages.rs"]
mod pages;
#[path = "tidy/signatures.rs"]
mod signatures;
#[path = "tidy/source.rs"]
mod source;
#[path = "tidy/words.rs"]
mod words;

use arrows::CRATES;
use source::{Tree, lines_of_code, shipped, split, tokens};
use std::path::Path;
use std::sync::LazyLock;

/// Lines of a file, and columns of a line.
const LINES: usize = 500;
const COLUMNS: usize = 100;

/// Circles between modules that are still there: folder, modules, why.
const CIRCLES: &[(&str, &[&str], &str)] = &[];

/// Files that are too long: generated from short descriptions, for nobody to edit.
const LONG_FILES: &[&str] = &["core/exact/src/predicates/filter/generated.rs"];

/// Lines of code that a reader of a part may have before him, at most: the kernel's auditor, and
/// whoever ports the protocol. Folders, the file that neither reads, the number.
const SIZES: &[(&[&str], &str, usize)] = &[
    (&["core/exact", "core/kernel"], "core/exact/src/predicates/dihedral.rs", 8_400),
    (&["parallel/src/protocol"], "parallel/src/protocol/variants.rs", 1_846),
];

/// Functions whose parameters Python's callers name, or a library of C has: they may have more than
/// others.
const OF_OTHER_LANGUAGES: &[&str] = &[
    "bindings/python/src/certificate.rs: check",
    "bindings/python/src/certificate.rs: check_domain",
    "xtask/traditional/src/scotch.rs: SCOTCH_dgraphBuild",
];

/// Functions with tuples among their parameters still: those of rounds are being parted.
const STILL_WITH_TUPLES: &[&str] = &[
    "parallel/src/refining/freely/team.rs: domain_on_team",
    "parallel/src/refining/rounds/mod.rs: refine",
    "parallel/src/refining/rounds/mod.rs: go_on",
    "parallel/src/refining/rounds/mod.rs: rounds_by",
    "parallel/src/refining/rounds/mod.rs: rounds_on_threads",
    "parallel/src/refining/rounds/mod.rs: begin",
    "parallel/src/refining/rounds/mod.rs: join",
    "parallel/src/refining/rounds/parts.rs: faces",
    "parallel/src/refining/rounds/ranks.rs: rounds_on_team",
    "parallel/src/refining/rounds/ranks.rs: stay",
    "parallel/src/refining/rounds/redeal.rs: send_off",
    "parallel/src/refining/rounds/redeal.rs: unpack",
];

/// Public functions with tuples in their results still: none is to come.
const RESULTS_WITH_TUPLES: &[&str] = &[
    "core/kernel/src/mesh/lanes.rs: fill_in_lanes",
    "core/kernel/src/mesh/opened.rs: reopen",
    "core/kernel/src/order.rs: bounding_box",
    "core/kernel/src/submesh.rs: far_at",
    "core/kernel/src/submesh.rs: lock_of",
    "core/kernel/src/submesh/params.rs: bounds",
    "core/kernel/src/undo.rs: fill_for_now",
    "core/domain/src/plc.rs: bounds",
    "core/refine/src/rules/complex.rs: weights",
    "core/refine/src/rules/complex.rs: point_of_tet",
    "core/refine/src/run/delegated.rs: complex",
    "core/formats/src/parted/border.rs: begin",
    "parallel/src/check/view.rs: attempt_mut",
    "parallel/src/protocol/worker.rs: into_parts",
    "parallel/src/refining/rounds/mod.rs: rounds_by",
    "parallel/src/team/mod.rs: parcels",
];

static TREE: LazyLock<Tree> = LazyLock::new(|| {
    Tree::read(Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a package of the workspace"))
});

/// Files with more lines than allowed.
fn long_files(tree: &Tree) -> Vec<&str> {
    let is_long = |text: &str| text.lines().count() > LINES;
    tree.rust("").filter(|(_, text)| is_long(text)).map(|(file, _)| file).collect()
}

/// Files of tests that no program of tests has as a module: nothing would run them, and nobody
/// would be told.
fn left_out(tree: &Tree) -> Vec<&str> {
    let is_left_out = |path: &str| {
        let (folder, file) = path.rsplit_once("/tests/")?;
        let main = tree.0.get(&format!("{folder}/tests/main.rs"))?;
        let module = format!("mod {};", file.strip_suffix(".rs")?);
        // A program of its own has its name in the manifest.
        let program = format!("name = \"{}\"", file.strip_suffix(".rs")?);
        let manifest = tree.0.get(&format!("{folder}/Cargo.toml"))?;
        let is_own = file.contains('/') || file == "main.rs" || manifest.contains(&program);
        Some(!is_own && !main.lines().any(|line| line == module))
    };
    tree.rust("").map(|(path, _)| path).filter(|path| is_left_out(path) == Some(true)).collect()
}

/// The lines of code of `folders`, tests and the file `but` left out.
fn size(tree: &Tree, folders: &[&str], but: &str) -> usize {
    let inside = |file: &str| folders.iter().any(|folder| file.starts_with(&format!("{folder}/")));
    let files = CRATES.iter().flat_map(|krate| tree.shipped(krate.folder));
    let files = files.filter(|&(file, _)| inside(file) && file != but);
    files.map(|(_, text)| lines_of_code(text)).sum()
}

/// Lines with more columns than allowed: `file:line`.
fn long_lines(tree: &Tree) -> Vec<String> {
    let of_file = |(file, text): (&str, &str)| {
        let long = text.lines().enumerate().filter(|(_, line)| line.chars().count() > COLUMNS);
        long.map(|(k, _)| format!("{file}:{}", k + 1)).collect::<Vec<_>>()
    };
    tree.rust("").flat_map(of_file).collect()
}

/// Shipped code with atomics outside the module `sync` of its crate.
fn stray_atomics(tree: &Tree) -> Vec<String> {
    let mut found = Vec::new();
    for krate in CRATES {
        let doors = ["sync.rs", "sync/"].map(|door| format!("{}/src/{door}", krate.folder));
        let is_door = |file: &str| doors.iter().any(|door| file.starts_with(door.as_str()));
        for (file, text) in tree.shipped(krate.folder).filter(|&(file, _)| !is_door(file)) {
            let code = shipped(&tokens(&split(text).0));
            let is_atomic = |word: &str| {
                word == "atomic"
                    || word.strip_prefix("Atomic").is_some_and(|kind| {
                        kind == "Ptr"
                            || kind.trim_end_matches(|c: char| c.is_ascii_digit()) != kind
                            || ["Bool", "Usize", "Isize"].contains(&kind)
                    })
            };
            if let Some(token) = code.iter().find(|token| is_atomic(&token.text)) {
                found.push(format!("{file}:{}", token.line));
            }
        }
    }
    found
}

#[test]
fn crates_lean_downwards() {
    assert_eq!(arrows::upward(&TREE), [""; 0], "code names a crate that is not on a lower floor");
    assert_eq!(manifest::upward(&TREE), [""; 0], "a dependency is not on a lower floor");
}

#[test]
fn the_list_of_crates_is_that_of_the_workspace() {
    let manifests = TREE.0.iter().filter(|(path, _)| path.ends_with("/Cargo.toml"));
    let mut found: Vec<(String, &str)> = manifests
        .map(|(path, text)| {
            let name = text.lines().find_map(|line| line.strip_prefix("name = "));
            let name = name.expect("a package").trim_matches('"').replace('-', "_");
            (name, path.trim_end_matches("/Cargo.toml"))
        })
        .collect();
    let mut listed: Vec<(String, &str)> =
        CRATES.iter().map(|c| (c.name.to_owned(), c.folder)).collect();
    found.sort();
    listed.sort();
    assert_eq!(found, listed);
}

#[test]
fn no_two_modules_lean_on_each_other() {
    let all = CRATES.iter().flat_map(|c| arrows::circles(&TREE, c.folder));
    let (mut new, mut there) = (Vec::new(), Vec::new());
    for circle in all {
        let is_it = |&&(folder, rooms, _): &&(&str, &[&str], &str)| {
            folder == circle.folder && rooms == circle.rooms
        };
        match CIRCLES.iter().find(is_it) {
            Some(listed) => there.push(listed),
            None => new.push(circle),
        }
    }
    assert!(new.is_empty(), "circles of modules: {new:#?}");
    let gone: Vec<_> = CIRCLES.iter().filter(|listed| !there.contains(listed)).collect();
    assert!(gone.is_empty(), "mended, but still listed: {gone:#?}");
}

#[test]
fn files_are_short() {
    assert_eq!(long_files(&TREE), LONG_FILES, "files of more than {LINES} lines, and those listed");
}

#[test]
fn all_files_of_tests_are_run() {
    assert_eq!(left_out(&TREE), [""; 0], "files that no tests/main.rs names");
}

#[test]
fn what_is_read_as_a_whole_is_small() {
    for &(folders, but, most) in SIZES {
        let size = size(&TREE, folders, but);
        assert!(size <= most, "{folders:?} have {size} lines of code; {most} are allowed");
    }
}

#[test]
fn lines_are_short_and_comments_do_without_banned_words() {
    let found = [long_lines(&TREE), words::banned(&TREE), words::leaning(&TREE)].concat();
    assert_eq!(found, [""; 0], "long lines, banned words, doc comments that lean on others");
}

#[test]
fn parameters_are_few_and_have_names() {
    let (many, tuples) = (signatures::many_parameters(&TREE), signatures::tuples(&TREE));
    assert_eq!(many, OF_OTHER_LANGUAGES, "functions of many parameters, and those listed");
    assert_eq!(tuples, STILL_WITH_TUPLES, "functions with tuples whose members want names");
    let results = signatures::tuples_in_results(&TREE);
    assert_eq!(results, RESULTS_WITH_TUPLES, "results with tuples whose members want names");
}

#[test]
fn atomics_are_in_one_module_of_a_crate() {
    assert_eq!(stray_atomics(&TREE), [""; 0]);
}

#[test]
fn dependencies_are_used() {
    assert_eq!(manifest::unused(&TREE), [""; 0]);
}

#[test]
fn pages_name_what_there_is() {
    for page in ["docs/ARCHITECTURE.md", "docs/algorithm.md", "docs/glossary.md"] {
        assert!(TREE.0.contains_key(page), "{page}");
        assert_eq!(words::unknown_names(&TREE, page), [""; 0], "names that no source has");
    }
}

#[test]
fn decisions_have_short_pages_and_a_line_of_the_index() {
    assert!(TREE.0.contains_key("docs/decisions/README.md"), "the index of decisions");
    assert_eq!(pages::faults(&TREE), [""; 0]);
}

#[test]
fn each_file_of_tests_has_a_question() {
    assert_eq!(pages::without_question(&TREE, "tests/README.md"), [""; 0]);
}

#[test]
fn tables_of_numbers_name_the_command_that_prints_them() {
    assert_eq!(figures::faults_of_pages(&TREE), [""; 0]);
}

#[test]
fn long_files_and_lines_are_found() {
    let tree = |text: &str| Tree::of(&[("cli/src/lib.rs", text)]);
    assert_eq!(long_files(&tree(&"\n".repeat(LINES))), [""; 0]);
    assert_eq!(long_files(&tree(&"\n".repeat(LINES + 1))), ["cli/src/lib.rs"]);
    assert_eq!(long_lines(&tree(&"ä".repeat(COLUMNS))), [""; 0]);
    assert_eq!(long_lines(&tree(&format!("\n{}", "ä".repeat(COLUMNS + 1)))), ["cli/src/lib.rs:2"]);
}

#[test]
fn files_of_tests_that_nobody_names_are_found() {
    let tree = Tree::of(&[
        ("cli/Cargo.toml", "name = \"alone\""),
        ("cli/tests/main.rs", "mod a;"),
        ("cli/tests/a.rs", ""),
        ("cli/tests/a/part.rs", ""),
        ("cli/tests/alone.rs", ""),
        ("cli/tests/b.rs", ""),
        ("core/tests/c.rs", ""),
    ]);
    assert_eq!(left_out(&tree), ["cli/tests/b.rs"]);
}

#[test]
fn code_is_counted_by_folder() {
    let tree = Tree::of(&[
        ("cli/src/a/b.rs", "fn f() {}\n\nfn g() {}"),
        ("cli/src/a/c.rs", "fn f() {}"),
        ("cli/src/a/tests.rs", "fn f() {}"),
        ("cli/src/ab.rs", "fn f() {}"),
        ("xtask/src/d.rs", "// none\n"),
    ]);
    assert_eq!(size(&tree, &["cli/src/a", "xtask"], ""), 3);
    assert_eq!(size(&tree, &["cli", "xtask"], "cli/src/a/c.rs"), 3);
}

#[test]
fn atomics_elsewhere_are_found() {
    let tree = |file: &str, text: &str| Tree::of(&[(&*format!("cli/src/{file}"), text)]);
    let code = "use std::sync::atomic::AtomicU32;";
    assert_eq!(stray_atomics(&tree("lib.rs", code)), ["cli/src/lib.rs:1"]);
    assert_eq!(stray_atomics(&tree("lib.rs", "\nfn f(_: &AtomicBool) {}")), ["cli/src/lib.rs:2"]);
    assert_eq!(stray_atomics(&tree("sync.rs", code)), [""; 0]);
    let tests = "// AtomicBool\n#[cfg(test)] mod tests { use std::sync::atomic::AtomicU32; }";
    assert_eq!(stray_atomics(&tree("lib.rs", tests)), [""; 0]);
    assert_eq!(stray_atomics(&tree("lib.rs", "struct AtomicFile;")), [""; 0]);
}
