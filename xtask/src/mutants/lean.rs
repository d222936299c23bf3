//! A package of one module alone: it compiles in a fraction of the time of the whole package,
//! and every mutant is compiled once.

use crate::shell::root;
use std::fs;
use std::path::{Path, PathBuf};

/// The library of the package: what the module uses of its crate's root.
const LIBRARY: &str = "\
//! One module, compiled alone.
pub type Point = [f64; 3];
pub mod predicates;
";

const MANIFEST: &str = r#"[package]
name = "lean"
version = "0.0.0"
edition.workspace = true

[dependencies]
num-bigint.workspace = true
num-traits.workspace = true

[dev-dependencies]
proptest.workspace = true
robust.workspace = true

[features]
serde = []

"#;

/// Writes the package of `module` of the package in `folder` anew, below `below`; returns its
/// folder. Versions, profiles and the lock file are the workspace's.
pub(super) fn package(folder: &str, module: &str, below: &Path) -> Result<PathBuf, String> {
    let package = below.join("package");
    write(folder, module, &package).map_err(|error| format!("{}: {error}", package.display()))?;
    Ok(package)
}

fn write(folder: &str, module: &str, package: &Path) -> std::io::Result<()> {
    let source = package.join("src");
    if source.exists() {
        fs::remove_dir_all(&source)?;
    }
    fs::create_dir_all(&source)?;
    let workspace = fs::read_to_string(root().join("Cargo.toml"))?;
    fs::write(package.join("Cargo.toml"), format!("{MANIFEST}{}", shared(&workspace)))?;
    fs::copy(root().join("Cargo.lock"), package.join("Cargo.lock"))?;
    fs::write(source.join("lib.rs"), LIBRARY)?;
    copy(&root().join(folder).join("src").join(module), &source.join(module))
}

/// The manifest of the workspace without its lists of members.
fn shared(workspace: &str) -> String {
    let mut text = "[workspace]\n".to_string();
    let rest = workspace.find("[workspace.package]").map_or("", |at| &workspace[at..]);
    text.push_str(rest);
    text
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
    use super::shared;

    #[test]
    fn members_are_left_out_and_versions_kept() {
        let workspace = "[workspace]\nmembers = []\n\n[workspace.package]\nedition = \"2024\"\n";
        assert_eq!(shared(workspace), "[workspace]\n[workspace.package]\nedition = \"2024\"\n");
    }
}
