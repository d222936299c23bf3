//! A package cut down to some modules, its test programs included as modules: one small program
//! to compile for each mutant, instead of a library and several.

use crate::shell::root;
use std::fs;
use std::path::{Path, PathBuf};

/// The part of a package that stays.
pub(super) struct Minimal {
    /// The folder of the package.
    pub(super) folder: &'static str,
    /// The modules that stay, with blanks between them: all that those in question need.
    pub(super) modules: &'static str,
    /// The test programs of `tests/` that are included.
    pub(super) cases: &'static [&'static str],
}

/// Writes the cut package anew, below `below`; returns its folder. Versions, profiles and the
/// lock file are the workspace's.
pub(super) fn package(minimal: &Minimal, below: &Path) -> Result<PathBuf, String> {
    let package = below.join("package");
    write(minimal, &package).map_err(|error| format!("{}: {error}", package.display()))?;
    Ok(package)
}

fn write(minimal: &Minimal, package: &Path) -> std::io::Result<()> {
    let from = root().join(minimal.folder);
    // Test programs name their data by a path from where they are.
    for folder in ["src", "tests", "testdata"] {
        if package.join(folder).exists() {
            fs::remove_dir_all(package.join(folder))?;
        }
        if from.join(folder).exists() {
            copy(&from.join(folder), &package.join(folder))?;
        }
    }
    let manifest = fs::read_to_string(from.join("Cargo.toml"))?;
    let workspace = fs::read_to_string(root().join("Cargo.toml"))?;
    let shared = shared(&workspace, &root().display().to_string());
    fs::write(package.join("Cargo.toml"), format!("{manifest}\n{shared}"))?;
    fs::copy(root().join("Cargo.lock"), package.join("Cargo.lock"))?;
    let library = library(&fs::read_to_string(from.join("src/lib.rs"))?, &manifest, minimal);
    fs::write(package.join("src/lib.rs"), library)
}

/// The manifest of the workspace in `root` without its list of members; paths start at `root`.
fn shared(workspace: &str, root: &str) -> String {
    let rest = workspace.find("[workspace.package]").map_or("", |at| &workspace[at..]);
    format!("[workspace]\n{}", rest.replace("path = \"", &format!("path = \"{root}/")))
}

/// `library` (a `lib.rs`) with the minimal package's modules alone, and its test programs.
fn library(library: &str, manifest: &str, minimal: &Minimal) -> String {
    let mut text = String::new();
    let mut attribute = "";
    for line in library.lines() {
        if line.starts_with("#[cfg(feature") {
            attribute = line;
            continue;
        }
        if module(line).is_none_or(|name| minimal.modules.split(' ').any(|m| m == name)) {
            if !attribute.is_empty() {
                text.push_str(&format!("{attribute}\n"));
            }
            text.push_str(&format!("{line}\n"));
        }
        attribute = "";
    }
    // Test programs name the package by its name.
    let name = manifest.lines().find_map(|line| line.strip_prefix("name = ")).unwrap_or_default();
    let name = name.trim_matches('"').replace('-', "_");
    text.push_str(&format!("#[cfg(test)]\nextern crate self as {name};\n"));
    for case in minimal.cases {
        text.push_str(&format!(
            "#[cfg(test)]\n#[path = \"../tests/{case}.rs\"]\nmod test_{case};\n"
        ));
    }
    text
}

/// The module that a line declares, or takes names from.
fn module(line: &str) -> Option<&str> {
    let line = line.strip_prefix("pub ").unwrap_or(line);
    let name = line.strip_prefix("mod ").or_else(|| line.strip_prefix("use "))?;
    name.split([';', ':']).next()
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let to = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &to)?;
        } else {
            fs::copy(entry.path(), to)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_left_out_and_versions_kept() {
        let workspace =
            "[workspace]\nmembers = []\n\n[workspace.package]\na = { path = \"core/a\" }\n";
        assert_eq!(
            shared(workspace, "/r"),
            "[workspace]\n[workspace.package]\na = { path = \"/r/core/a\" }\n"
        );
    }

    #[test]
    fn modules_that_are_not_needed_go() {
        let whole = "//! Text.\n#![deny(x)]\npub mod a;\n#[cfg(feature = \"f\")]\nmod b;\nmod c;\n\
                     pub use a::A;\npub use b::B;\n\n/// One.\npub type T = u8;\n";
        let minimal = Minimal { folder: "", modules: "a c", cases: &["k"] };
        assert_eq!(
            library(whole, "[package]\nname = \"x-y\"\n", &minimal),
            "//! Text.\n#![deny(x)]\npub mod a;\nmod c;\npub use a::A;\n\n/// One.\npub type T = \
             u8;\n#[cfg(test)]\nextern crate self as x_y;\n#[cfg(test)]\n#[path = \
             \"../tests/k.rs\"]\nmod test_k;\n"
        );
    }
}
