//! `mutants`: does a test fail for every change that cargo-mutants makes to the code?
//!
//! Three groups, each with the tests that are to catch its mutants. To make a mutant cheap, only
//! the package's own tests run, from an incremental build with little optimisation and no debug
//! information, and stop at the first failure. Random tests draw from a fixed seed and do not
//! shrink, so that a run can be repeated and a verdict does not depend on luck.
//!
//! A mutant that no test catches is an error unless `xtask/mutants.txt` says why it changes
//! nothing that could be observed; an entry whose mutant is caught now is an error too. A test
//! program that uses too much time or memory is stopped (`prlimit` of util-linux) and has failed:
//! such a mutant would not go unnoticed.

mod excused;
mod lean;

use crate::fuzz::host;
use crate::require;
use crate::shell::{self, cargo, root, target};
use std::path::Path;
use std::process::Command;

/// Files whose mutants the same tests are to catch.
struct Group {
    name: &'static str,
    package: &'static str,
    /// Globs of source files.
    files: &'static [&'static str],
    /// Which tests are built: arguments of `cargo test`.
    tests: &'static [&'static str],
    /// Which of them do not run, because they are about other files.
    skip: &'static [&'static str],
    /// Seconds of processor time after which a test program is stopped: some five times what it
    /// needs without a mutant.
    seconds: u32,
    /// Is this module of the package compiled alone, without the rest of it?
    alone: Option<&'static str>,
}

const GROUPS: [Group; 3] = [
    Group {
        name: "predicates",
        package: "ltbw-core",
        files: &["core/src/predicates/**/*.rs"],
        tests: &["--lib"],
        skip: &[],
        seconds: 30,
        alone: Some("predicates"),
    },
    Group {
        name: "kernel",
        package: "ltbw-core",
        files: &[
            "core/src/build.rs",
            "core/src/cavity.rs",
            "core/src/geometry.rs",
            "core/src/locate.rs",
            "core/src/mesh.rs",
            "core/src/order.rs",
            "core/src/sphere.rs",
            "core/src/topology.rs",
        ],
        tests: &["--lib", "--test=kernel"],
        skip: &["predicates::", "io::", "query::"],
        seconds: 30,
        alone: None,
    },
    Group {
        name: "checker",
        package: "ltbw-verify",
        files: &["verify/src/*.rs"],
        tests: &["--tests"],
        skip: &[],
        seconds: 30,
        alone: None,
    },
];

const USAGE: &str = "usage: mutants [predicates|kernel|checker]... [--shard K/N] [-- ARG...]";

/// Wall-clock seconds after which cargo-mutants gives up on a build or a test program. No verdict
/// should depend on it: on a busy machine tests may take long that do end.
const TIMEOUT: &str = "900";
/// Bytes of address space for each test program: a loop that does not end may fill memory.
const MEMORY: u64 = 8 << 30;

/// What to do, from the command line.
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
/// survived with the list of excused mutants.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let plan = Plan::parse(args)?;
    if !shell::works(cargo().args(["mutants", "--version"])) {
        let reason = "cargo-mutants is not installed (cargo install --locked cargo-mutants)";
        return require::skip("mutants", "mutants", reason);
    }
    let excused = excused::read(&root().join("xtask/mutants.txt"))?;
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
        wrong.extend(excused::compare(&excused, &found, plan.whole, |file| {
            file.starts_with(&format!("{}/", group.folder())) && group.holds(file)
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
    /// The folder of the package.
    fn folder(&self) -> &'static str {
        self.files[0].split('/').next().unwrap_or_default()
    }

    /// Is `file` one of the group's?
    fn holds(&self, file: &str) -> bool {
        self.files.iter().any(|glob| match glob.split_once('*') {
            Some((folder, _)) => file.starts_with(folder),
            None => *glob == file,
        })
    }
}

/// Runs cargo-mutants on one group; its own log stays below the target folder.
fn test(group: &Group, plan: &Plan<'_>) -> Result<excused::Found, String> {
    let folder = target().join("mutants").join(group.name);
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut command = cargo();
    environment(&mut command, group, &target().join("mutants"))?;
    command.args(["mutants", "--no-shuffle", "--timeout", TIMEOUT]);
    command.arg("--output").arg(&folder);
    let mut below = String::new();
    if let Some(module) = group.alone {
        let package = lean::package(group.folder(), module, &folder)?;
        command.args(["--in-place", "--dir"]).arg(package);
        below = format!("{}/", group.folder());
    } else {
        command.args(["--jobs", "1", "--package", group.package]);
        command.args(group.files.iter().flat_map(|file| ["--file", file]));
    }
    command.args(group.tests.iter().map(|test| format!("--cargo-arg={test}")));
    command.args(&plan.passed_on).args(["--", "--", "-Z", "unstable-options", "--fail-fast"]);
    command.args(group.skip.iter().flat_map(|name| ["--skip", name]));
    let status = command.status().map_err(|error| format!("{command:?}: {error}"))?;
    match status.code() {
        // All caught, some missed, some without a verdict: the lists say which.
        Some(0 | 2 | 3) => excused::Found::read(&folder.join("mutants.out"), &below),
        _ => Err(format!("{command:?}: {status}")),
    }
}

/// A build folder of its own, a cheap profile, bounded test programs, and random tests that can be
/// repeated.
fn environment(command: &mut Command, group: &Group, target: &Path) -> Result<(), String> {
    // The test runner's --fail-fast is not stable: programs that run may use it, the compiler
    // sees nothing of it.
    let runner = format!("prlimit --cpu={} --as={MEMORY} env RUSTC_BOOTSTRAP=1", group.seconds);
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
