//! `mutants`: does a test fail for every change that cargo-mutants makes to the code?
//!
//! Groups of files, each with the tests that are to catch its mutants. To make a mutant cheap, only
//! the package's own tests run, from an incremental build of the modules in question as one
//! program, with little optimisation and no debug information, and stop at the first failure.
//! Random tests draw from a fixed seed and do not shrink, so that a run can be repeated and a
//! verdict does not depend on luck. The mutants of the generated filters, nearly a thousand, are
//! one program (`schemata.rs`).
//!
//! A mutant that no test catches is an error unless `xtask/mutants.txt` says why it changes
//! nothing that could be observed; an entry whose mutant is caught now is an error too. A test
//! program that uses too much time or memory is stopped (`prlimit` of util-linux) and has failed:
//! such a mutant would not go unnoticed.

mod equivalent;
mod minimal;
mod schemata;

use crate::fuzz::host;
use crate::require;
use crate::shell::{self, cargo, root, target};
use minimal::Minimal;
use std::path::Path;
use std::process::Command;

/// Files whose mutants the same tests are to catch.
struct Group {
    name: &'static str,
    minimal: Minimal,
    /// Globs of source files, in the folder of the package.
    files: &'static [&'static str],
    /// Tests whose names hold one of these do not run: they are about other files.
    skip: &'static [&'static str],
    /// Tried in one program (`schemata.rs`): tests that catch most of the mutants at once.
    schemata: Option<&'static [&'static str]>,
}

/// Not `predicates/filter/generated.rs` in the first: a test of this package compares it with what
/// is generated, so that no change of it goes unnoticed. `filters` asks whether the predicates'
/// own tests notice, too.
const GROUPS: [Group; 4] = [
    Group {
        name: "predicates",
        minimal: Minimal { folder: "core/exact", modules: "points predicates", cases: &[] },
        files: &["src/predicates/*.rs", "src/predicates/exact/*.rs"],
        skip: &[],
        schemata: None,
    },
    Group {
        name: "filters",
        minimal: Minimal { folder: "core/exact", modules: "points predicates", cases: &[] },
        files: &["src/predicates/filter/generated.rs"],
        skip: &[],
        schemata: Some(&["predicates::tests::filters", "predicates::filter"]),
    },
    Group {
        name: "kernel",
        minimal: Minimal {
            folder: "core/kernel",
            modules: "build cavity geometry hash invariants locate ltbw_exact mesh order part \
                      query random raw snapshot special sphere sync tetmesh topology",
            cases: &["accessors", "counts", "kernel"],
        },
        files: &[
            "src/build.rs",
            "src/cavity.rs",
            "src/geometry.rs",
            "src/locate.rs",
            "src/mesh.rs",
            "src/order.rs",
            "src/sphere.rs",
            "src/topology.rs",
        ],
        skip: &["query::"],
        schemata: None,
    },
    Group {
        name: "checker",
        minimal: Minimal {
            folder: "verify/checker",
            modules: "check defect exact faces geometry adjacency_proof hash hull mesh perturb \
                      places predicates report structure chunks topology",
            cases: &["defects", "meshes", "words"],
        },
        files: &["src/*.rs"],
        skip: &[],
        schemata: None,
    },
];

/// Seconds of processor time after which a test program is stopped: several times what it needs
/// without a mutant.
const SECONDS: u32 = 30;

const USAGE: &str =
    "usage: mutants [predicates|filters|kernel|checker]... [--shard K/N] [-- ARG...]";

/// Wall-clock seconds after which cargo-mutants gives up on a build or a test program. No verdict
/// should depend on it: on a busy machine tests may take long that do end.
const TIMEOUT: &str = "900";
/// Bytes of address space for each test program: a loop that does not end may fill memory.
const MEMORY: u64 = 8 << 30;

/// The task, from the command line.
struct Plan<'a> {
    groups: Vec<&'static Group>,
    /// Handed to cargo-mutants: the shard, and what follows `--`.
    passed_on: Vec<&'a str>,
    /// Are all mutants of the groups tried? Else an entry of the list may be without a mutant.
    whole: bool,
}

impl<'a> Plan<'a> {
    fn parse(args: &'a [String]) -> Result<Self, String> {
        let mut plan = Plan { groups: Vec::new(), passed_on: Vec::new(), whole: true };
        let mut args = args.iter().map(String::as_str);
        while let Some(arg) = args.next() {
            match arg {
                "--shard" => {
                    plan.passed_on.extend([arg, args.next().ok_or(USAGE)?]);
                    plan.whole = false;
                }
                "--" => {
                    let before = plan.passed_on.len();
                    plan.passed_on.extend(args.by_ref());
                    plan.whole &= plan.passed_on.len() == before;
                }
                name => {
                    let group = GROUPS.iter().find(|group| group.name == name);
                    plan.groups.push(group.ok_or_else(|| format!("no group {name}\n{USAGE}"))?);
                }
            }
        }
        if plan.groups.is_empty() {
            plan.groups.push(&GROUPS[0]);
        }
        Ok(plan)
    }
}

/// Runs cargo-mutants on the groups that `args` name (the predicates if none), and compares what
/// survived with the list of equivalent mutants.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let plan = Plan::parse(args)?;
    if !shell::works(cargo().args(["mutants", "--version"])) {
        let reason = "cargo-mutants is not installed (cargo install --locked cargo-mutants)";
        return require::skip("mutants", "mutants", reason);
    }
    let equivalent = equivalent::read(&root().join("xtask/mutants.txt"))?;
    let mut wrong = Vec::new();
    for group in &plan.groups {
        let found = test(group, &plan)?;
        println!(
            "mutants of the {}: {} caught, {} survived, {} did not compile, {} without a verdict",
            group.name,
            found.caught.len(),
            found.missed.len(),
            found.unviable.len(),
            found.timeout.len(),
        );
        wrong.extend(equivalent::compare(&equivalent, &found, plan.whole, |file| {
            group.holds(file)
        })?);
    }
    for line in &wrong {
        println!("{line}");
    }
    match wrong.len() {
        0 => Ok(()),
        n => Err(format!("{n} mutants differ from xtask/mutants.txt")),
    }
}

impl Group {
    /// Is `file` (from the root of the workspace) one of the group's?
    fn holds(&self, file: &str) -> bool {
        let file = file.strip_prefix(self.minimal.folder).and_then(|file| file.strip_prefix('/'));
        file.is_some_and(|file| {
            self.files.iter().any(|glob| match glob.split_once('*') {
                Some((folder, _)) => {
                    file.rsplit_once('/').is_some_and(|(f, _)| f == folder.trim_end_matches('/'))
                }
                None => *glob == file,
            })
        })
    }
}

/// Runs cargo-mutants on one group; its own log stays below the target folder.
fn test(group: &Group, plan: &Plan<'_>) -> Result<equivalent::Found, String> {
    if let (Some(first), [file]) = (group.schemata, group.files) {
        return match plan.whole {
            true => schemata::test(group, file, first),
            false => Err(format!("the {} are one program: no parts", group.name)),
        };
    }
    let folder = target().join("mutants").join(group.name);
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut command = cargo();
    environment(&mut command, &target().join("mutants"))?;
    command.args(["mutants", "--no-shuffle", "--timeout", TIMEOUT]);
    command.arg("--output").arg(&folder);
    // In place: the package is a copy already.
    command.args(["--in-place", "--dir"]).arg(minimal::package(&group.minimal, &folder)?);
    command.args(group.files.iter().flat_map(|file| ["--file", file]));
    command.arg("--cargo-arg=--lib");
    command.args(&plan.passed_on).args(["--", "--", "-Z", "unstable-options", "--fail-fast"]);
    command.args(group.skip.iter().flat_map(|name| ["--skip", name]));
    let status = command.status().map_err(|error| format!("{command:?}: {error}"))?;
    match status.code() {
        // All caught, some missed, some without a verdict: the lists say which.
        Some(0 | 2 | 3) => {
            equivalent::Found::read(&folder.join("mutants.out"), group.minimal.folder)
        }
        _ => Err(format!("{command:?}: {status}")),
    }
}

/// A build folder of its own, a cheap profile, bounded test programs, and random tests that can be
/// repeated.
fn environment(command: &mut Command, target: &Path) -> Result<(), String> {
    // The test runner's --fail-fast is not stable: programs that run may use it, the compiler
    // does not see it.
    let runner = format!("prlimit --cpu={SECONDS} --as={MEMORY} env RUSTC_BOOTSTRAP=1");
    let host = host()?.to_uppercase().replace('-', "_");
    command
        .env(format!("CARGO_TARGET_{host}_RUNNER"), runner)
        .env("CARGO_TARGET_DIR", target)
        .env("CARGO_INCREMENTAL", "1")
        .env("CARGO_PROFILE_DEV_OPT_LEVEL", "1")
        .env("CARGO_PROFILE_DEV_DEBUG", "0")
        .env("PROPTEST_RNG_SEED", "1")
        .env("PROPTEST_MAX_SHRINK_ITERS", "0")
        .env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "1");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_choose_groups_and_shards() {
        let parse = |args: &[&str]| {
            let args: Vec<String> = args.iter().map(ToString::to_string).collect();
            Plan::parse(&args).map(|plan| {
                let names: Vec<&str> = plan.groups.iter().map(|group| group.name).collect();
                (names.join(" "), plan.passed_on.join(" "), plan.whole)
            })
        };
        let plan = |names: &str, rest: &str, whole| Ok((names.into(), rest.into(), whole));
        assert_eq!(parse(&[]), plan("predicates", "", true));
        assert_eq!(parse(&["kernel", "checker"]), plan("kernel checker", "", true));
        assert_eq!(parse(&["kernel", "--shard", "1/8"]), plan("kernel", "--shard 1/8", false));
        assert_eq!(parse(&["checker", "--", "--re", "x"]), plan("checker", "--re x", false));
        assert!(parse(&["kernels"]).is_err() && parse(&["--shard"]).is_err());
    }

    #[test]
    fn groups_hold_files_that_exist_and_share_none() {
        let count = |file: &str| GROUPS.iter().filter(|group| group.holds(file)).count();
        for group in &GROUPS {
            for glob in group.files.iter().filter(|glob| !glob.contains('*')) {
                let file = format!("{}/{glob}", group.minimal.folder);
                assert!(root().join(&file).is_file(), "{file}");
                assert_eq!(count(&file), 1, "{file}");
            }
        }
        for file in [
            "core/exact/src/predicates/perturb.rs",
            "core/exact/src/predicates/filter/generated.rs",
        ] {
            assert_eq!(count(file), 1, "{file}");
        }
        assert_eq!(count("core/exact/src/predicates/exact/big.rs"), 1);
        assert_eq!(count("core/formats/src/ply.rs"), 0);
    }
}
