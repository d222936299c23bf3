//! Crates that are published say of themselves what their page needs, and no two tell it otherwise.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a package of the workspace").into()
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Folders and manifests of the workspace's members.
fn members() -> Vec<(String, String)> {
    let manifest = read(&root().join("Cargo.toml"));
    let list = manifest.split("members = [").nth(1).and_then(|rest| rest.split(']').next());
    let folders = list.expect("members").split('"').skip(1).step_by(2);
    folders.map(|f| (f.to_owned(), read(&root().join(f).join("Cargo.toml")))).collect()
}

/// The value of a field of `[package]`, without quotes.
fn field<'a>(manifest: &'a str, name: &str) -> Option<&'a str> {
    let package = manifest.split("\n[").next().unwrap_or_default();
    let value = package.lines().find_map(|l| l.strip_prefix(name)?.strip_prefix(" = "))?;
    Some(value.trim_matches('"'))
}

#[test]
fn published_crates_are_the_libraries_and_the_program() {
    let members = members();
    let published = members.iter().filter(|(_, m)| field(m, "publish") != Some("false"));
    let names: Vec<&str> = published.filter_map(|(_, m)| field(m, "name")).collect();
    let expected = [
        "ltbw-exact",
        "ltbw-core",
        "ltbw-domain",
        "ltbw-refine",
        "ltbw-formats",
        "ltbw-generate",
        "ltbw",
        "ltbw-verify",
        "ltbw-cli",
    ];
    assert_eq!(names, expected);
}

#[test]
fn published_crates_have_what_their_page_needs() {
    for (folder, manifest) in members() {
        if field(&manifest, "publish") == Some("false") {
            continue;
        }
        let of = |name| field(&manifest, name).unwrap_or_else(|| panic!("{folder}: no {name}"));
        let name = of("name");
        assert!(of("description").len() > 30, "{folder}");
        assert_eq!(of("documentation"), format!("https://docs.rs/{name}"));
        let readme = read(&root().join(&folder).join(of("readme")));
        assert!(readme.starts_with(&format!("# {name}\n")) || folder == "verify/checker");
        let keywords: Vec<&str> = of("keywords").split('"').skip(1).step_by(2).collect();
        assert!((1..=5).contains(&keywords.len()), "{folder}: at most five keywords");
        assert!(keywords.iter().all(|k| k.len() <= 20 && !k.contains(' ')), "{keywords:?}");
        assert!((1..=5).contains(&of("categories").split('"').skip(1).step_by(2).count()));
        assert!(manifest.contains("[package.metadata.docs.rs]\nall-features = true\n"), "{folder}");
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let own = read(&root().join(&folder).join(licence));
            assert!(own == read(&root().join(licence)), "{folder}: {licence}");
        }
        // Examples of a library's page are its doc tests.
        let library = read(&root().join(&folder).join("src/lib.rs"));
        let is_tested = library.contains("#[doc = include_str!(\"../README.md\")]");
        assert!(is_tested || !readme.contains("```rust"), "{folder}: README.md is not tested");
    }
}

/// A crate that depends on another in its tests alone, and is needed by it, cannot name its
/// version: neither could be published first.
#[test]
fn crates_can_be_published_one_after_the_other() {
    let members = members();
    let needs = |manifest: &str| -> Vec<String> {
        let mut section = "";
        let mut found = Vec::new();
        for line in manifest.lines() {
            section = if line.starts_with('[') { line } else { section };
            let is_versioned = section == "[dependencies]"
                || section == "[dev-dependencies]" && line.contains("workspace = true");
            let name = line.split(['.', ' ']).next().filter(|name| name.starts_with("ltbw"));
            found.extend(name.filter(|_| is_versioned).map(str::to_owned));
        }
        found
    };
    let mut left: Vec<(String, Vec<String>)> = members
        .iter()
        .filter(|(_, m)| field(m, "publish") != Some("false"))
        .filter_map(|(_, m)| Some((field(m, "name")?.to_owned(), needs(m))))
        .collect();
    while !left.is_empty() {
        let names: Vec<String> = left.iter().map(|(name, _)| name.clone()).collect();
        let count = left.len();
        left.retain(|(_, needs)| needs.iter().any(|need| names.contains(need)));
        assert!(left.len() < count, "none of {names:?} can be the first");
    }
}

/// A user of points alone gets neither formats nor domains, nor what they need.
#[test]
fn points_alone_need_thirty_crates() {
    let tree = ["tree", "-p", "ltbw", "--no-default-features", "-e", "normal"];
    let form = ["--prefix", "none", "--no-dedupe", "--offline", "--locked"];
    let mut cargo = Command::new(env!("CARGO"));
    let output = cargo.current_dir(root()).args(tree).args(form).output().expect("cargo");
    let text = String::from_utf8(output.stdout).expect("text");
    let names: BTreeSet<&str> = text.lines().filter_map(|line| line.split(' ').next()).collect();
    assert!(names.contains("ltbw-core") && !names.contains("ltbw-formats"), "{names:?}");
    assert!(names.len() <= 30, "{}: {names:?}", names.len());
}
