//! `slips`: defects as a reader would make them by hand, planted behind a switch: does a test see
//! each? The list is in `slips/table.rs`; a test holds it to the sources.
//!
//! A copy of the tree gets all of them at once, so that it is built once: what is right stands in
//! each place beside what is wrong, and the variable `LTBW_SLIP` says which is done. The tree that
//! ships has neither. First the named tests must pass without any slip; then each must fail
//! with its own, and the message says which assertion has seen it. A slip that changes no verdict
//! must leave its tests as they are.

mod table;

use crate::fuzz::host;
use crate::shell::{self, cargo, command, root, target};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use table::{PACKAGES, SLIPS, Slip};

/// Seconds after which a test counts as hanging, which is no way to be seen.
const PATIENCE: u32 = 900;

/// The function that the planted places ask, at the end of each `lib.rs` concerned.
const SWITCH: &str = "
/// Is this slip the one that is asked for?
pub(crate) fn slip(number: u32) -> bool {
    static ASKED: std::sync::LazyLock<Option<u32>> =
        std::sync::LazyLock::new(|| std::env::var(\"LTBW_SLIP\").ok()?.parse().ok());
    *ASKED == Some(number)
}
";

/// Plants the slips with the numbers `args`, or all, and runs their tests.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let slips = chosen(args)?;
    let tree = target().join("slips");
    plant(&tree)?;
    shell::run(in_tree(&tree).args(["test", "--no-run", "--quiet"]).args(targets(&slips)))?;
    let mut passed = BTreeSet::new();
    for slip in slips.iter().filter(|slip| passed.insert((slip.at, slip.test))) {
        if let Some(seen) = test(&tree, slip, false)? {
            return Err(format!("slip {}: its test fails without it: {seen}", slip.number));
        }
    }
    let mut wrong = 0;
    for slip in &slips {
        let start = Instant::now();
        let seen = test(&tree, slip, true)?;
        let (is_right, outcome) = match (seen, slip.is_equivalent) {
            (Some(seen), false) => (true, format!("caught: {seen}")),
            (None, true) => (true, "changes no verdict, as it must".to_owned()),
            (Some(seen), true) => (false, format!("is said to change nothing: {seen}")),
            (None, false) => (false, format!("SURVIVES {} of {}", slip.test, slip.at)),
        };
        wrong += usize::from(!is_right);
        let seconds = start.elapsed().as_secs_f64();
        println!("slip {}, {}: {outcome} ({seconds:.1} s)", slip.number, slip.what);
    }
    println!("{} slips, {wrong} not as they must be", slips.len());
    if wrong == 0 { Ok(()) } else { Err(format!("{wrong} slips")) }
}

/// The slips with these numbers; all if there are none.
fn chosen(args: &[String]) -> Result<Vec<&'static Slip>, String> {
    if args.is_empty() {
        return Ok(SLIPS.iter().collect());
    }
    let of = |arg: &String| {
        let number = arg.parse().ok();
        let slip = SLIPS.iter().find(|slip| Some(slip.number) == number);
        slip.ok_or_else(|| format!("no slip {arg}: they are 1 to {}", SLIPS.len()))
    };
    args.iter().map(of).collect()
}

/// Cargo in the copy, with the program's own target folder: dependencies are built once.
fn in_tree(tree: &Path) -> Command {
    let mut command = cargo();
    command.current_dir(tree).env("CARGO_TARGET_DIR", target()).env_remove("LTBW_SLIP");
    command
}

/// The packages, and the test programs of some slips. The packages are always the same: their
/// features are.
fn targets(slips: &[&Slip]) -> Vec<&'static str> {
    let packages = PACKAGES.iter().flat_map(|(package, _)| ["-p", package]);
    let programs: BTreeSet<_> = slips.iter().map(|slip| program(slip)).collect();
    packages.chain(programs.into_iter().flatten()).collect()
}

/// The program and the module of a slip's test, if it is one of a crate's integration tests: they
/// are one program, named as the crate's folder, and each file is a module.
fn integration(slip: &Slip) -> Option<(&'static str, &'static str)> {
    let (folder, file) = slip.at.split_once("/tests/")?;
    let name = folder.rsplit('/').next().unwrap_or(folder);
    (!folder.contains("/src/")).then(|| (name, file.trim_end_matches(".rs")))
}

/// The test program of a slip, as cargo's arguments.
fn program(slip: &Slip) -> Vec<&'static str> {
    integration(slip).map_or(vec!["--lib"], |(name, _)| vec!["--test", name])
}

/// The name of a slip's test in its program.
fn filter(slip: &Slip) -> String {
    integration(slip).map_or(slip.test.to_owned(), |(_, module)| format!("{module}::{}", slip.test))
}

/// Runs a slip's test. Returns the assertion that fails, if one does.
fn test(tree: &Path, slip: &Slip, is_planted: bool) -> Result<Option<String>, String> {
    let mut cargo = in_tree(tree);
    let runner = format!("CARGO_TARGET_{}_RUNNER", host()?.to_uppercase().replace('-', "_"));
    cargo.env(runner, format!("timeout {PATIENCE}")).env("RUST_BACKTRACE", "0");
    if is_planted {
        cargo.env("LTBW_SLIP", slip.number.to_string());
    }
    cargo.args(["test", "--quiet"]).args(targets(&[slip])).args(["--", &filter(slip)]);
    let output = cargo.output().map_err(|error| format!("{cargo:?}: {error}"))?;
    if output.status.success() {
        return Ok(None);
    }
    let text = [output.stdout, output.stderr].map(|b| String::from_utf8_lossy(&b).into_owned());
    let text = text.concat();
    // The message of the first panic, and the place.
    let mut lines = text.lines().skip_while(|line| !line.contains(" panicked at "));
    match (lines.next(), lines.next()) {
        (Some(place), Some(message)) => {
            let place = place.split(" panicked at ").nth(1).unwrap_or_default();
            Ok(Some(format!("{} {}", place, message.chars().take(200).collect::<String>())))
        }
        _ => Err(format!("slip {}: no assertion has failed:\n{text}", slip.number)),
    }
}

/// Copies the tree and plants all slips in the copy. A file that stays as it is is not written, so
/// that nothing is built again for it.
fn plant(tree: &Path) -> Result<(), String> {
    let listed = command("git").args(["ls-files", "-z"]).output();
    let listed = listed.map_err(|error| format!("git ls-files: {error}"))?.stdout;
    for name in String::from_utf8_lossy(&listed).split('\0').filter(|name| !name.is_empty()) {
        let (from, to) = (root().join(name), tree.join(name));
        let io = |error: std::io::Error| format!("{}: {error}", from.display());
        // Removed, and not committed yet; or a link.
        if !from.is_file() {
            continue;
        }
        let bytes = match planted(name, || fs::read_to_string(&from))? {
            Some(text) => text.into_bytes(),
            None => fs::read(&from).map_err(io)?,
        };
        if fs::read(&to).is_ok_and(|old| old == bytes) {
            continue;
        }
        let folder = to.parent().map_or_else(PathBuf::new, PathBuf::from);
        fs::create_dir_all(folder).and_then(|()| fs::write(&to, bytes)).map_err(io)?;
    }
    Ok(())
}

/// The text of a file with its slips, and with the switch if others of its crate ask for it; `None`
/// if it has neither.
fn planted(
    name: &str,
    read: impl Fn() -> std::io::Result<String>,
) -> Result<Option<String>, String> {
    let is_root = PACKAGES.iter().any(|(_, folder)| name == format!("{folder}/src/lib.rs"));
    let edits = SLIPS.iter().flat_map(|slip| slip.edits.iter().map(move |edit| (slip, edit)));
    let edits: Vec<_> = edits.filter(|(_, edit)| edit.file == name).collect();
    if edits.is_empty() && !is_root {
        return Ok(None);
    }
    let mut text = read().map_err(|error| format!("{name}: {error}"))?;
    for (Slip { number, .. }, edit) in edits {
        let places = text.matches(edit.right).count();
        if places != 1 {
            let right = edit.right;
            return Err(format!("slip {number}: {places} places of {name} have `{right}`"));
        }
        let both =
            format!("(if crate::slip({number}) {{ {} }} else {{ {} }})", edit.wrong, edit.right);
        text = text.replacen(edit.right, &both, 1);
    }
    if is_root {
        // Planted code need not be neat.
        text = format!("#![allow(warnings)]\n{text}{SWITCH}");
    }
    Ok(Some(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A list that names code of yesterday plants nothing.
    #[test]
    fn every_slip_has_its_place_and_its_test() {
        let numbers: Vec<u32> = SLIPS.iter().map(|slip| slip.number).collect();
        assert_eq!(numbers, (1..=SLIPS.len() as u32).collect::<Vec<_>>());
        for slip in SLIPS {
            assert!(!slip.edits.is_empty(), "{}", slip.number);
            for edit in slip.edits {
                let read = || fs::read_to_string(root().join(edit.file));
                let text = planted(edit.file, read).expect("one place").expect("a slip");
                assert!(text.contains(&format!("crate::slip({})", slip.number)), "{}", edit.file);
                let package = PACKAGES
                    .iter()
                    .find(|(_, folder)| edit.file.starts_with(&format!("{folder}/src/")));
                assert!(package.is_some(), "{} is in none of the packages", edit.file);
            }
            let path = root().join(slip.at);
            let text = fs::read_to_string(&path).expect("a file with tests");
            let name = slip.test.rsplit("::").next().unwrap_or_default();
            assert!(text.contains(&format!("fn {name}")), "slip {}: no {name}", slip.number);
            let is_in_package = PACKAGES.iter().any(|(_, folder)| slip.at.starts_with(folder));
            assert!(is_in_package, "slip {}: {}", slip.number, slip.at);
        }
        assert_eq!(planted("README.md", || Ok(String::new())), Ok(None));
    }

    #[test]
    fn numbers_choose() {
        let of = |args: &[&str]| {
            let args: Vec<String> = args.iter().map(ToString::to_string).collect();
            chosen(&args).map(|slips| slips.iter().map(|slip| slip.number).collect::<Vec<_>>())
        };
        assert_eq!(of(&["22", "5"]), Ok(vec![22, 5]));
        assert_eq!(of(&[]).map(|all| all.len()), Ok(SLIPS.len()));
        assert!(of(&["0"]).is_err() && of(&["x"]).is_err());
    }
}
