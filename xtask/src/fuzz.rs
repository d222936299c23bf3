//! `fuzz`: the canary, then every target of `fuzz/fuzz_targets` through cargo-fuzz for a number of
//! seconds each, and a summary.
//!
//! The canary has a planted bug. A run in which it is not found within [`CANARY_SECONDS`] says that
//! the fuzzing is broken, whatever the others do not find.
//!
//! cargo-fuzz passes sanitizer flags that stable rustc accepts only with `RUSTC_BOOTSTRAP=1`; with
//! it the fuzzers run the same compiler as the tests.

use crate::require;
use crate::shell::{self, cargo, command, rust_files, target as target_folder, works};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// The target that fails on purpose.
const CANARY: &str = "canary";
/// The longest time that the canary may live.
const CANARY_SECONDS: u32 = 60;
/// The canary's last words when it dies as it should: `FOUND` of `tests/src/fuzz/canary.rs`.
const CANARY_FOUND: &str = "the canary's planted bug was found";

const USAGE: &str = "usage: fuzz [--renew] [--seconds N] [TARGET]...";

/// The result of a run of one target, from libFuzzer's output.
#[derive(Debug, Default, PartialEq, Eq)]
struct Run {
    runs: u64,
    per_second: u64,
    /// Edges of the control flow that the corpus covers.
    edges: u64,
    /// Inputs that reached something new.
    new_units: u64,
    passed: bool,
}

/// Runs the canary and all targets, or those that `args` name; `args` may hold `--seconds N` (for
/// each target, default 60). With `--renew`, the committed corpora take in what was found, as few
/// inputs as cover the same.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let Wishes { seconds, is_renewal, named } = parse(args)?;
    if !works(cargo().args(["fuzz", "--version"])) {
        let reason = "cargo-fuzz is not installed (cargo install cargo-fuzz)";
        return require::skip("fuzz", "fuzz", reason);
    }
    let all = rust_files("fuzz/fuzz_targets")?;
    if let Some(unknown) = named.iter().find(|name| !all.contains(name)) {
        return Err(format!("no such target: {unknown}; there are {}", all.join(", ")));
    }
    let chosen = all.iter().filter(|t| *t != CANARY && (named.is_empty() || named.contains(t)));
    let fuzzer = Fuzzer::new()?;
    let start = Instant::now();
    fuzzer.build()?;
    println!("fuzz: built in {} s", start.elapsed().as_secs());
    fuzzer.canary()?;
    let mut findings = Vec::new();
    println!("{:<12} {:>10} {:>8} {:>7} {:>6}", "target", "runs", "runs/s", "edges", "new");
    for target in chosen {
        let (run, log) = fuzzer.fuzz(target, seconds)?;
        let Run { runs, per_second, edges, new_units, passed } = run;
        let outcome = if passed { "" } else { "  FOUND A BUG" };
        println!("{target:<12} {runs:>10} {per_second:>8} {edges:>7} {new_units:>6}{outcome}");
        if is_renewal && passed {
            fuzzer.renew(target)?;
        }
        if !passed {
            findings.push(format!("{target}: {}\n{}", log.display(), last_lines(&log)));
        }
    }
    match findings.len() {
        0 => Ok(()),
        n => Err(format!("{n} targets have findings\n{}", findings.join("\n"))),
    }
}

/// The wishes of the arguments.
#[derive(Debug, PartialEq, Eq)]
struct Wishes {
    seconds: u32,
    is_renewal: bool,
    named: Vec<String>,
}

fn parse(args: &[String]) -> Result<Wishes, String> {
    let (mut seconds, mut is_renewal, mut named) = (60, false, Vec::new());
    let mut rest = args.iter();
    while let Some(arg) = rest.next() {
        if arg == "--seconds" {
            let n = rest.next().ok_or(USAGE)?;
            seconds = n.parse().map_err(|_| format!("--seconds takes a whole number, not {n}"))?;
        } else if arg == "--renew" {
            is_renewal = true;
        } else if arg.starts_with('-') {
            return Err(USAGE.to_string());
        } else {
            named.push(arg.clone());
        }
    }
    Ok(Wishes { seconds, is_renewal, named })
}

/// The fuzzers of this machine.
struct Fuzzer {
    /// The triple this machine compiles for.
    host: String,
    /// Corpora, artifacts and logs.
    folder: PathBuf,
}

impl Fuzzer {
    fn new() -> Result<Self, String> {
        Ok(Self { host: host()?, folder: target_folder().join("fuzz") })
    }

    /// Builds every target, in a target folder of its own.
    fn build(&self) -> Result<(), String> {
        shell::run(
            cargo()
                .env("RUSTC_BOOTSTRAP", "1")
                .env("CARGO_TARGET_DIR", self.folder.join("build"))
                // One unit a crate, as cargo-fuzz would have it, takes twice as long to compile.
                .args(["fuzz", "build", "--codegen-units", "16", "--target", &self.host]),
        )
    }

    /// Fuzzes one target, from its committed corpus and what earlier runs have found. The output
    /// goes to the log that is returned.
    fn fuzz(&self, target: &str, seconds: u32) -> Result<(Run, PathBuf), String> {
        let found = self.fresh("corpus", target, false)?;
        let artifacts = self.fresh("artifacts", target, false)?;
        let committed = self.committed(target)?;
        let time = format!("-max_total_time={seconds}");
        self.libfuzzer(target, &time, &[&found, &committed], &artifacts)
    }

    /// The committed corpus as files.
    fn committed(&self, target: &str) -> Result<PathBuf, String> {
        let folder = self.fresh("committed", target, true)?;
        shell::run(&mut corpus("unpack", target, &folder))?;
        Ok(folder)
    }

    /// Commits the fewest inputs that cover what the committed ones and those found cover.
    fn renew(&self, target: &str) -> Result<(), String> {
        let found = self.fresh("corpus", target, false)?;
        let artifacts = self.fresh("artifacts", target, false)?;
        let [committed, merged] = [self.committed(target)?, self.fresh("merged", target, true)?];
        let corpora = [merged.as_path(), &committed, &found];
        let (run, log) = self.libfuzzer(target, "-merge=1", &corpora, &artifacts)?;
        if !run.passed {
            return Err(format!("{target}: no merge\n{}", last_lines(&log)));
        }
        shell::run(&mut corpus("pack", target, &merged))
    }

    /// The canary, from nothing.
    fn canary(&self) -> Result<(), String> {
        let start = Instant::now();
        let empty = self.fresh("corpus", CANARY, true)?;
        let artifacts = self.fresh("artifacts", CANARY, true)?;
        let time = format!("-max_total_time={CANARY_SECONDS}");
        let (run, log) = self.libfuzzer(CANARY, &time, &[&empty], &artifacts)?;
        let said = fs::read_to_string(&log).map_err(|e| format!("{}: {e}", log.display()))?;
        if run.passed || !said.contains(CANARY_FOUND) {
            let why = format!("the canary lives after {CANARY_SECONDS} s: fuzzing is broken");
            return Err(format!("{why}\n{}", last_lines(&log)));
        }
        println!("{CANARY}: found after {:.1} s, as it must be", start.elapsed().as_secs_f64());
        Ok(())
    }

    fn libfuzzer(
        &self,
        target: &str,
        task: &str,
        corpora: &[&Path],
        artifacts: &Path,
    ) -> Result<(Run, PathBuf), String> {
        let log = self.folder.join(format!("{target}.log"));
        let file = File::create(&log).map_err(|e| format!("{}: {e}", log.display()))?;
        let clone = file.try_clone().map_err(|e| format!("{}: {e}", log.display()))?;
        let program = self.folder.join("build").join(&self.host).join("release").join(target);
        let status = command(&program.to_string_lossy())
            // The CGAL reference is the one that the tests have compiled.
            .env("LTBW_CGAL_FOLDER", target_folder().join("cgal"))
            // Small meshes: a second thread would cost more than it does.
            .env("RAYON_NUM_THREADS", "1")
            .args(corpora)
            .arg(task)
            .arg(format!("-artifact_prefix={}/", artifacts.display()))
            // Memory grows with what the corpus reaches, not with one input; a hang is a finding.
            .args(["-rss_limit_mb=4096", "-timeout=60", "-print_final_stats=1"])
            .stdin(Stdio::null())
            .stdout(clone)
            .stderr(file)
            .status()
            .map_err(|error| format!("{}: {error}", program.display()))?;
        let text = fs::read(&log).map_err(|e| format!("{}: {e}", log.display()))?;
        let run = Run::of(&String::from_utf8_lossy(&text), status.success());
        Ok((run, log))
    }

    /// The folder `kind/target`, emptied if it has to be.
    fn fresh(&self, kind: &str, target: &str, empty: bool) -> Result<PathBuf, String> {
        let folder = self.folder.join(kind).join(target);
        let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
        if empty && folder.exists() {
            fs::remove_dir_all(&folder).map_err(failed)?;
        }
        fs::create_dir_all(&folder).map_err(failed)?;
        Ok(folder)
    }
}

impl Run {
    /// Reads libFuzzer's statistics and its last line with a coverage.
    fn of(log: &str, passed: bool) -> Self {
        let stat = |name: &str| {
            let line = log.lines().find_map(|line| line.strip_prefix(&format!("stat::{name}:")));
            line.and_then(|value| value.trim().parse().ok()).unwrap_or(0)
        };
        let covered = |line: &str| line.split_once(" cov: ")?.1.split(' ').next()?.parse().ok();
        Self {
            runs: stat("number_of_executed_units"),
            per_second: stat("average_exec_per_sec"),
            edges: log.lines().rev().find_map(covered).unwrap_or(0),
            new_units: stat("new_units_added"),
            passed,
        }
    }
}

/// The program that packs and unpacks committed corpora.
fn corpus(task: &str, target: &str, folder: &Path) -> Command {
    let mut command = shell::of_tests("corpus");
    command.args([task, target]).arg(folder);
    command
}

/// The end of a log, for a failure's message.
fn last_lines(log: &Path) -> String {
    let text = fs::read(log).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(40)..].join("\n")
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

#[cfg(test)]
mod tests {
    use super::{Run, Wishes, parse};

    #[test]
    fn statistics_are_read_from_the_log() {
        let log = "#2\tINITED cov: 7 ft: 8 corp: 1/1b\n#64\tpulse  cov: 4711 ft: 9 corp: 2/3b\n\
                   Done 12 runs in 3 second(s)\nstat::number_of_executed_units: 12\n\
                   stat::average_exec_per_sec:     4\nstat::new_units_added:          5\n";
        let run = Run { runs: 12, per_second: 4, edges: 4711, new_units: 5, passed: true };
        assert_eq!(Run::of(log, true), run);
        assert_eq!(Run::of("", false), Run::default());
    }

    #[test]
    fn arguments() {
        let words = |text: &str| text.split(' ').map(str::to_string).collect::<Vec<_>>();
        let of = |seconds, is_renewal, named: &[&str]| {
            let named = named.iter().map(ToString::to_string).collect();
            Ok(Wishes { seconds, is_renewal, named })
        };
        assert_eq!(parse(&[]), of(60, false, &[]));
        assert_eq!(parse(&words("--seconds 7 cli")), of(7, false, &["cli"]));
        assert_eq!(parse(&words("--renew cli")), of(60, true, &["cli"]));
        assert!(parse(&words("--seconds")).is_err() && parse(&words("--seconds x")).is_err());
        assert!(parse(&words("--fast")).is_err());
    }
}
