//! `fuzz`: every target of `fuzz/fuzz_targets` through cargo-fuzz, for a number of seconds each.
//!
//! cargo-fuzz passes sanitizer flags that stable rustc accepts only with `RUSTC_BOOTSTRAP=1`; with
//! it the fuzzers run the same compiler as the tests.

use crate::require;
use crate::shell::{cargo, command, root, run as call, target as target_folder, works};
use std::process::Command;

/// Runs every target; `args` may hold `--seconds N` (default 60).
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let seconds = match args {
        [] => 60,
        [flag, n] if flag == "--seconds" => {
            n.parse::<u32>().map_err(|_| format!("--seconds takes a whole number, not {n}"))?
        }
        _ => return Err("usage: fuzz [--seconds N]".to_string()),
    };
    if !works(cargo().args(["fuzz", "--version"])) {
        let reason = "cargo-fuzz is not installed (cargo install cargo-fuzz)";
        return require::skip("fuzz", "fuzz", reason);
    }
    let host = host()?;
    for target in targets()? {
        println!("fuzz: {target}, {seconds} s");
        let found = target_folder().join("fuzz-corpus").join(&target);
        std::fs::create_dir_all(&found).map_err(|error| format!("{}: {error}", found.display()))?;
        call(
            cargo()
                .env("RUSTC_BOOTSTRAP", "1")
                .args(["fuzz", "run", "--target", &host, &target])
                // What is found goes to the first folder; the committed corpus is read only.
                .args([&found, &root().join("fuzz/corpus").join(&target)])
                .arg("--")
                .arg(format!("-max_total_time={seconds}"))
                // Memory grows with what the corpus reaches, not with one input; a hang is a
                // finding.
                .args(["-rss_limit_mb=4096", "-timeout=60", "-print_final_stats=1"]),
        )?;
    }
    Ok(())
}

/// The triple this machine compiles for.
pub(crate) fn host() -> Result<String, String> {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_string());
    let output: &mut Command = &mut command(&rustc);
    let output = output.arg("-vV").output().map_err(|error| format!("{rustc}: {error}"))?;
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .find_map(|line| line.strip_prefix("host: ").map(str::to_string))
        .ok_or_else(|| format!("{rustc} -vV names no host"))
}

/// Names of the fuzz targets, sorted.
fn targets() -> Result<Vec<String>, String> {
    let folder = root().join("fuzz/fuzz_targets");
    let entries =
        std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut names: Vec<String> = entries
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .filter_map(|path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned()))
        .collect();
    names.sort();
    Ok(names)
}
