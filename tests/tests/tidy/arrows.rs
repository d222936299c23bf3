//! Arrows between crates and between modules, read from `use` lines and paths of shipped code.

use super::source::{Token, Tree, shipped, split, tokens};
use std::collections::{BTreeMap, BTreeSet};

/// A crate: the name by which code names it, its folder, and its floor.
pub(crate) struct Crate {
    pub(crate) name: &'static str,
    pub(crate) folder: &'static str,
    /// Shipped code names crates on lower floors only; `None`: no crate of ours at all.
    pub(crate) floor: Option<u8>,
}

const fn on(floor: u8, name: &'static str, folder: &'static str) -> Crate {
    Crate { name, folder, floor: Some(floor) }
}

const fn alone(name: &'static str, folder: &'static str) -> Crate {
    Crate { name, folder, floor: None }
}

/// All crates of the workspace, and those of workspaces of their own.
pub(crate) const CRATES: &[Crate] = &[
    on(0, "ltbw_exact", "core/exact"),
    on(1, "ltbw_core", "core/kernel"),
    on(2, "ltbw_domain", "core/domain"),
    on(3, "ltbw_refine", "core/refine"),
    on(3, "ltbw_formats", "core/formats"),
    on(3, "ltbw_generate", "core/generate"),
    on(4, "ltbw", "parallel"),
    alone("ltbw_verify", "verify/checker"),
    on(5, "ltbw_models", "verify/models"),
    on(5, "ltbw_cli", "cli"),
    on(6, "ltbw_tests", "tests"),
    on(7, "ltbw_kit", "verify/kit"),
    on(7, "ltbw_fuzz", "fuzz"),
    on(5, "ltbw_bindings", "bindings/common"),
    on(6, "ltbw_python", "bindings/python"),
    on(6, "ltbw_c", "bindings/c"),
    on(6, "ltbw_mpi", "parallel/mpi"),
    on(5, "ltbw_traditional", "xtask/traditional"),
    alone("xtask", "xtask"),
];

/// Crates on floors above which the checker may be named: the kernel never leans on its judge.
const JUDGED: u8 = 4;

/// The names that a path in the code goes through, and its line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Named {
    pub(crate) path: Vec<String>,
    /// The last name under which a `use` makes it known.
    alias: Option<String>,
    pub(crate) line: usize,
}

/// The paths that code names: those of `use` lines, braces expanded, and those that start at
/// `crate`, `self`, `super` or a crate of ours.
pub(crate) fn paths(tokens: &[Token]) -> Vec<Named> {
    let text = |k: usize| tokens.get(k).map_or("", |token| token.text.as_str());
    let is_start = |word: &str| {
        ["crate", "self", "super"].contains(&word) || CRATES.iter().any(|c| c.name == word)
    };
    let (mut found, mut k) = (Vec::new(), 0);
    while k < tokens.len() {
        if text(k) == "use" && (k == 0 || text(k - 1) != "::") {
            k = use_tree(tokens, k + 1, &[], &mut found);
            continue;
        }
        let after_path = k > 0 && ["::", "$"].contains(&text(k - 1));
        let visibility = k > 1 && text(k - 1) == "in" && text(k - 2) == "(";
        if is_start(text(k)) && text(k + 1) == "::" && !after_path && !visibility {
            let (mut path, line) = (vec![text(k).to_owned()], tokens[k].line);
            while text(k + 1) == "::"
                && text(k + 2).starts_with(|c: char| c.is_alphabetic() || c == '_')
            {
                path.push(text(k + 2).to_owned());
                k += 2;
            }
            found.push(Named { path, alias: None, line });
        }
        k += 1;
    }
    found
}

/// Reads one tree of a `use` line from `k` on; returns the place after it.
fn use_tree(tokens: &[Token], mut k: usize, before: &[String], found: &mut Vec<Named>) -> usize {
    let text = |k: usize| tokens.get(k).map_or(";", |token| token.text.as_str());
    let mut path = before.to_vec();
    let line = tokens.get(k).map_or(0, |token| token.line);
    loop {
        match text(k) {
            "{" => {
                k += 1;
                while text(k) != "}" && text(k) != ";" {
                    k = use_tree(tokens, k, &path, found);
                    k += usize::from(text(k) == ",");
                }
                return k + 1;
            }
            "as" => {
                found.push(Named { path, alias: Some(text(k + 1).to_owned()), line });
                return k + 2;
            }
            "," | ";" | "}" => break,
            "::" => k += 1,
            word => {
                path.push(word.to_owned());
                k += 1;
            }
        }
    }
    if path.last().is_some_and(|last| last == "self") && path.len() > 1 {
        path.pop();
    }
    let alias = path.last().cloned();
    found.push(Named { path, alias, line });
    k
}

/// Arrows between crates against the order of floors: `file:line: crate names crate`.
pub(crate) fn upward(tree: &Tree) -> Vec<String> {
    let mut wrong = Vec::new();
    for from in CRATES {
        for (file, text) in tree.shipped(from.folder) {
            for named in paths(&shipped(&tokens(&split(text).0))) {
                let to = CRATES.iter().find(|c| c.name == named.path[0] && c.name != from.name);
                if to.is_some_and(|to| !may_name(from, to)) {
                    wrong.push(format!(
                        "{file}:{}: {} names {}",
                        named.line, from.name, named.path[0]
                    ));
                }
            }
        }
    }
    wrong
}

/// May the shipped code of `from` name `to`?
pub(crate) fn may_name(from: &Crate, to: &Crate) -> bool {
    match (from.floor, to.floor) {
        (Some(from), Some(to)) => from > to,
        (Some(from), None) => from > JUDGED && to.name != "xtask",
        (None, _) => false,
    }
}

/// A module of a crate: its children by name, and what its file names.
#[derive(Default)]
struct Module {
    children: BTreeMap<String, usize>,
    parent: Option<usize>,
    name: String,
    file: String,
    named: Vec<Named>,
}

/// The modules of a crate, as its `mod` lines tell them; entry 0 is its root.
struct Modules(Vec<Module>);

impl Modules {
    fn read(tree: &Tree, folder: &str) -> Option<Self> {
        let roots = ["src/lib.rs", "src/main.rs"].map(|file| format!("{folder}/{file}"));
        let root = roots.into_iter().find(|file| tree.0.contains_key(file))?;
        let root = Module { file: root, ..Module::default() };
        let (mut all, mut next) = (Self(vec![root]), 0);
        while next < all.0.len() {
            let file = all.0[next].file.clone();
            let code = shipped(&tokens(&split(&tree.0[&file]).0));
            all.0[next].named = paths(&code);
            let folder = match file.rsplit_once('/') {
                Some((folder, "lib.rs" | "main.rs" | "mod.rs")) => folder.to_owned(),
                _ => file.trim_end_matches(".rs").to_owned(),
            };
            for words in code.windows(3).filter(|w| w[0].text == "mod" && w[2].text == ";") {
                let name = &words[1].text;
                let files = [format!("{folder}/{name}.rs"), format!("{folder}/{name}/mod.rs")];
                // A module with a path of its own is another crate's file.
                let Some(file) = files.into_iter().find(|f| tree.0.contains_key(f)) else {
                    continue;
                };
                let number = all.0.len();
                all.0[next].children.insert(name.clone(), number);
                let (parent, name) = (Some(next), name.clone());
                all.0.push(Module { parent, name, file, ..Module::default() });
            }
            next += 1;
        }
        Some(all)
    }

    /// The module that has the item of a path named in module `from`; `None` if it is not of this
    /// crate. Names that a module has from a `use` are followed, at most `depth` times.
    fn resolve(&self, from: usize, path: &[String], depth: usize) -> Option<usize> {
        let mut place = from;
        for (k, name) in path.iter().enumerate() {
            let module = &self.0[place];
            match name.as_str() {
                "self" => {}
                "crate" => place = 0,
                "super" => place = module.parent?,
                _ => {
                    if let Some(&child) = module.children.get(name) {
                        place = child;
                        continue;
                    }
                    let import = module.named.iter().find(|n| n.alias.as_ref() == Some(name));
                    let Some(import) = import.filter(|_| depth > 0) else {
                        // The first name of a path without `crate` and the like is another crate,
                        // unless the module knows it.
                        return (k > 0).then_some(place);
                    };
                    let rest = [&import.path[..], &path[k + 1..]].concat();
                    return self.resolve(place, &rest, depth - 1);
                }
            }
        }
        Some(place)
    }

    /// The modules from the root to `module`.
    fn line(&self, module: usize) -> Vec<usize> {
        let mut line = vec![module];
        while let Some(parent) = self.0[line[line.len() - 1]].parent {
            line.push(parent);
        }
        line.reverse();
        line
    }

    /// Arrows between modules with the same parent, with a place where each is: a module stands for
    /// all below it, and a parent is no room of its own.
    fn arrows(&self) -> BTreeMap<(usize, usize), String> {
        let mut arrows = BTreeMap::new();
        for (from, module) in self.0.iter().enumerate() {
            for named in &module.named {
                let Some(to) = self.resolve(from, &named.path, 16) else { continue };
                let (a, b) = (self.line(from), self.line(to));
                let common = a.iter().zip(&b).take_while(|(a, b)| a == b).count();
                if let (Some(&a), Some(&b)) = (a.get(common), b.get(common)) {
                    let place = || format!("{}:{}", module.file, named.line);
                    arrows.entry((a, b)).or_insert_with(place);
                }
            }
        }
        arrows
    }
}

/// A circle: the folder of its modules, their names, and the places of the arrows among them.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Circle {
    pub(crate) folder: String,
    pub(crate) rooms: Vec<String>,
    pub(crate) places: Vec<String>,
}

/// The circles between modules of the crate in `folder`.
pub(crate) fn circles(tree: &Tree, folder: &str) -> Vec<Circle> {
    let Some(modules) = Modules::read(tree, folder) else { return Vec::new() };
    let arrows = modules.arrows();
    let reach = |from: usize| {
        let (mut seen, mut todo) = (BTreeSet::new(), vec![from]);
        while let Some(place) = todo.pop() {
            let next = arrows.keys().filter(|&&(a, _)| a == place).map(|&(_, b)| b);
            todo.extend(next.filter(|&b| seen.insert(b)));
        }
        seen
    };
    let reached: Vec<BTreeSet<usize>> = (0..modules.0.len()).map(reach).collect();
    let mut found = BTreeSet::new();
    for first in 0..modules.0.len() {
        let circle: BTreeSet<usize> =
            reached[first].iter().copied().filter(|&b| reached[b].contains(&first)).collect();
        if circle.len() < 2 {
            continue;
        }
        let inside = |&(a, b): &(usize, usize)| circle.contains(&a) && circle.contains(&b);
        let of = |m: usize| modules.0[m].name.as_str();
        let place =
            |((a, b), at): (&(usize, usize), &String)| format!("{at}: {} -> {}", of(*a), of(*b));
        let mut rooms: Vec<String> = circle.iter().map(|&m| of(m).to_owned()).collect();
        rooms.sort();
        let line = modules.line(first);
        let names = line[..line.len() - 1].iter().filter(|&&m| m != 0).map(|&m| of(m));
        found.insert(Circle {
            folder: [folder].into_iter().chain(names).collect::<Vec<_>>().join("/"),
            rooms,
            places: arrows.iter().filter(|(pair, _)| inside(pair)).map(place).collect(),
        });
    }
    found.into_iter().collect()
}

#[test]
fn an_arrow_to_a_higher_floor_is_found() {
    let tree = |text| Tree::of(&[("core/kernel/src/lib.rs", text)]);
    assert_eq!(upward(&tree("use ltbw_exact::Point;")), [""; 0]);
    // Tests and comments may name any crate.
    assert_eq!(upward(&tree("// ltbw::x\n#[cfg(test)] mod tests { use ltbw::x; }")), [""; 0]);
    let found = upward(&tree("\nfn f() { ltbw_domain::f() }"));
    assert_eq!(found, ["core/kernel/src/lib.rs:2: ltbw_core names ltbw_domain"]);
    assert_eq!(upward(&tree("use {std::fs, ltbw_formats::vtu};")).len(), 1);
    // The checker names none, and no floor below the program names it.
    let checker = Tree::of(&[("verify/checker/src/lib.rs", "use ltbw_exact::Point;")]);
    assert_eq!(upward(&checker).len(), 1);
    assert_eq!(upward(&Tree::of(&[("parallel/src/lib.rs", "use ltbw_verify as v;")])).len(), 1);
    assert_eq!(upward(&Tree::of(&[("cli/src/lib.rs", "use ltbw_verify as v;")])).len(), 0);
}

#[test]
fn a_circle_of_modules_is_found() {
    let tree = |b: &str, root: &str| {
        Tree::of(&[
            ("cli/src/lib.rs", root),
            ("cli/src/a.rs", "use super::b::{self, B}; pub struct A;"),
            ("cli/src/b.rs", b),
            ("cli/src/b/c.rs", "use crate::A;"),
        ])
    };
    let root = "mod a; mod b; pub use a::A;";
    assert_eq!(circles(&tree("pub struct B;", root), "cli"), []);
    // By a path, and through the name that the root has of it, from a module further down.
    for b in ["fn f() -> crate::a::A {}", "mod c;", "fn f(_: super::A) {}"] {
        let found = circles(&tree(b, root), "cli");
        assert_eq!(found.len(), 1, "{b}");
        assert_eq!(
            (found[0].folder.as_str(), &found[0].rooms[..]),
            ("cli", &["a".into(), "b".into()][..])
        );
        assert_eq!(found[0].places.len(), 2);
    }
    // In tests it is none, nor is a word in a string, nor the same name of another crate.
    for b in
        ["#[cfg(test)] mod tests { use crate::A; }", "const X: &str = \"crate::A\";", "use a::A;"]
    {
        assert_eq!(circles(&tree(b, root), "cli"), [], "{b}");
    }
}
