//! Dependencies: each one that a manifest has is named by the code, and leans the right way.

use super::arrows::{CRATES, may_name};
use super::source::{Token, Tree, shipped, split, tokens};

/// A dependency of a manifest.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Dependency {
    pub(crate) name: String,
    /// Is it used by tests, examples and benchmarks alone?
    pub(crate) dev: bool,
}

/// The dependencies that a manifest lists, those for some targets only included.
pub(crate) fn dependencies(manifest: &str) -> Vec<Dependency> {
    let (mut section, mut found) = (String::new(), Vec::new());
    for line in manifest.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            section = name.to_owned();
        } else if section.ends_with("dependencies")
            && let Some((name, _)) = line.split_once(['.', '=', ' '])
            && !name.is_empty()
            && !name.starts_with(['#', '"', '{', '}', ']'])
        {
            found
                .push(Dependency { name: name.into(), dev: section.ends_with("dev-dependencies") });
        }
    }
    found
}

/// Is a crate named by these tokens: as the start of a path, or of a `use` line?
fn names(tokens: &[Token], name: &str) -> bool {
    let text = |k: usize| tokens.get(k).map_or("", |token| token.text.as_str());
    let here = |k: usize| {
        let start = k == 0 || text(k - 1) != "::";
        start && (text(k + 1) == "::" || ["use", "{", ","].contains(&text(k.wrapping_sub(1))))
    };
    (0..tokens.len()).any(|k| text(k) == name && here(k))
}

/// Dependencies that nothing uses: `manifest: name`.
pub(crate) fn unused(tree: &Tree) -> Vec<String> {
    let mut found = Vec::new();
    let manifests = tree.0.iter().filter(|(path, _)| path.ends_with("/Cargo.toml"));
    let mut listed = Vec::new();
    for (path, manifest) in manifests {
        let folder = path.trim_end_matches("/Cargo.toml");
        let all: Vec<(bool, Vec<Token>)> = tree
            .rust(folder)
            .map(|(file, text)| {
                let rest = file.strip_prefix(folder).unwrap_or(file);
                let ships = ["/src/", "/fuzz_targets/"].iter().any(|part| rest.starts_with(part));
                (ships, tokens(&split(text).0))
            })
            .collect();
        for Dependency { name, dev } in dependencies(manifest) {
            let word = name.replace('-', "_");
            let is_used = all.iter().any(|(ships, tokens)| match (dev, ships) {
                (true, _) => names(tokens, &word),
                (false, true) => names(&shipped(tokens), &word),
                (false, false) => false,
            });
            if !is_used {
                found.push(format!("{path}: {name}"));
            }
            listed.push(name);
        }
    }
    let workspace = tree.0.get("Cargo.toml").map_or("", String::as_str);
    for Dependency { name, .. } in dependencies(workspace) {
        if !listed.contains(&name) {
            found.push(format!("Cargo.toml: {name}"));
        }
    }
    found
}

/// Dependencies of shipped code on a crate of ours that is not on a lower floor.
pub(crate) fn upward(tree: &Tree) -> Vec<String> {
    let mut found = Vec::new();
    for from in CRATES {
        let path = format!("{}/Cargo.toml", from.folder);
        let manifest = tree.0.get(&path).map_or("", String::as_str);
        for Dependency { name, .. } in dependencies(manifest).iter().filter(|d| !d.dev) {
            let word = name.replace('-', "_");
            if CRATES.iter().any(|to| to.name == word && !may_name(from, to)) {
                found.push(format!("{path}: {name}"));
            }
        }
    }
    found
}

#[test]
fn a_dependency_that_nothing_names_is_found() {
    let tree = |manifest, code| {
        let root = "[workspace.dependencies]\nsome-crate = \"1\"\nrust = { version = \"1\" }\n";
        Tree::of(&[("Cargo.toml", root), ("cli/Cargo.toml", manifest), ("cli/src/lib.rs", code)])
    };
    let manifest = "[package]\nname = \"x\"\n[dependencies]\n# why\nsome-crate.workspace = true\n\
                    [target.'cfg(a)'.dependencies]\n\
                    rust = { workspace = true, features = [\"x\"] }\n";
    for code in ["use some_crate::a; fn f() { rust::b() }", "use {some_crate, rust as r};"] {
        assert_eq!(unused(&tree(manifest, code)), [""; 0], "{code}");
    }
    for code in ["use some_crate::rust;", "// rust::b\nuse some_crate;", "use x::rust::some_crate;"]
    {
        assert!(unused(&tree(manifest, code)).contains(&"cli/Cargo.toml: rust".into()), "{code}");
    }
    // Used by its tests alone it is one for tests; listed by no crate it is none.
    let tests = "use some_crate; #[cfg(test)] mod tests { use rust::b; }";
    assert_eq!(unused(&tree(manifest, tests)), ["cli/Cargo.toml: rust"]);
    assert_eq!(
        unused(&tree("[dev-dependencies]\nrust = \"1\"\n", tests)),
        ["Cargo.toml: some-crate"]
    );
}

#[test]
fn a_dependency_on_a_higher_floor_is_found() {
    let tree = |section| Tree::of(&[("core/kernel/Cargo.toml", section), ("Cargo.toml", "")]);
    assert_eq!(upward(&tree("[dependencies]\nltbw-exact.workspace = true\n")), [""; 0]);
    assert_eq!(upward(&tree("[dev-dependencies]\nltbw-generate.workspace = true\n")), [""; 0]);
    assert_eq!(upward(&tree("[dependencies]\nltbw-domain.workspace = true\n")).len(), 1);
}
