//! `coverage`: how many lines of core and of the checker the tests run, through cargo-llvm-cov.
//!
//! The tests are their own, and those of other packages that are about code which is theirs
//! ([`TESTS`]). Lines of tests are not counted. At least [`BAR`] percent of each package must be
//! run; a file with lines that are not must be explained in `docs/coverage.md`.

use crate::require;
use crate::shell::{self, cargo, command, root, target};
use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

/// Percentage of lines that must be run, for each package.
const BAR: f64 = 95.0;
/// Folders of the packages.
const PACKAGES: [&str; 7] = [
    "core/exact",
    "core/kernel",
    "core/domain",
    "core/refine",
    "core/formats",
    "core/generate",
    "verify/checker",
];
/// The tests that run: those of the packages; those of the parallel kernel, which alone uses what
/// the kernel has for it (`submesh`); those of refinement and its checker.
const TESTS: [&[&str]; 5] = [
    &["-p", "ltbw-exact", "-p", "ltbw-core", "-p", "ltbw-domain", "--all-features"],
    &["-p", "ltbw-refine"],
    &["-p", "ltbw-formats", "-p", "ltbw-generate", "-p", "ltbw-verify", "--all-features"],
    &["-p", "ltbw", "--all-features", "--test", "parallel", "threads::"],
    &["-p", "ltbw-tests", "--test", "workspace", "--", "interleaved::", "refine::", "refine_bad::"],
];
/// Debian's tools, if they are there; else cargo-llvm-cov looks for rustup's. Their version must
/// not be older than the format of the profiles, which has been the same since LLVM 19.
const DEBIAN: [(&str, &str); 2] =
    [("LLVM_COV", "llvm-cov-19"), ("LLVM_PROFDATA", "llvm-profdata-19")];

/// Lines of one file: number, and whether it was run.
type Lines = BTreeMap<usize, bool>;

/// Runs the tests of the packages and counts; takes no arguments.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    if !args.is_empty() {
        return Err("usage: coverage".to_string());
    }
    if !shell::works(cargo().args(["llvm-cov", "--version"])) {
        let reason = "cargo-llvm-cov is not installed (cargo install --locked cargo-llvm-cov)";
        return require::skip("coverage", "llvm-cov", reason);
    }
    let report = target().join("coverage.lcov");
    // Objects of these packages built elsewhere, or before, would be counted instead of today's.
    // The dependencies stay: building GMP takes minutes.
    shell::run(llvm_cov().args(["clean", "--workspace"]))?;
    for tests in TESTS {
        shell::run(llvm_cov().args(["--quiet", "--no-report"]).args(tests))?;
    }
    shell::run(llvm_cov().args(["report", "--lcov", "--output-path"]).arg(&report))?;
    let text = fs::read_to_string(&report).map_err(|e| format!("{}: {e}", report.display()))?;
    let mut files = parse(&text)?;
    files.retain(|file, _| PACKAGES.iter().any(|p| file.starts_with(&format!("{p}/src/"))));
    for (file, lines) in &mut files {
        let source = fs::read_to_string(root().join(file)).map_err(|e| format!("{file}: {e}"))?;
        let tests = first_test_line(&source);
        lines.retain(|line, _| *line < tests);
    }
    judge(&files)
}

/// `cargo llvm-cov`, with Debian's tools if they are there.
fn llvm_cov() -> Command {
    let mut measure = cargo();
    for (variable, tool) in DEBIAN {
        if std::env::var_os(variable).is_none() && shell::works(command(tool).arg("--version")) {
            measure.env(variable, tool);
        }
    }
    // Never install anything, never ask.
    measure.env("CARGO_LLVM_COV_SETUP", "no").arg("llvm-cov");
    measure
}

/// Prints the figures; an error if a package is below the bar or a file is not explained.
fn judge(files: &BTreeMap<String, Lines>) -> Result<(), String> {
    let page = "docs/coverage.md";
    let explained = fs::read_to_string(root().join(page)).map_err(|e| format!("{page}: {e}"))?;
    let mut wrong = Vec::new();
    for (file, lines) in files {
        let missed: Vec<usize> = lines.iter().filter(|(_, run)| !**run).map(|(n, _)| *n).collect();
        if missed.is_empty() {
            continue;
        }
        println!("not run: {file}: {}", ranges(&missed));
        if !explained.contains(&format!("`{file}`")) {
            wrong.push(format!("{page} does not explain {file}"));
        }
    }
    for package in PACKAGES {
        let lines = files.iter().filter(|(file, _)| file.starts_with(&format!("{package}/src/")));
        let lines: Vec<bool> = lines.flat_map(|(_, lines)| lines.values().copied()).collect();
        let run = lines.iter().filter(|run| **run).count();
        if lines.is_empty() {
            return Err(format!("nothing measured in {package}"));
        }
        let share = 100.0 * run as f64 / lines.len() as f64;
        println!("coverage of {package}: {share:.2} % of {} lines", lines.len());
        if share < BAR {
            wrong.push(format!("{package} is below {BAR} %"));
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}

/// The lines of an lcov report, by file (relative to the root); files outside are left out.
fn parse(report: &str) -> Result<BTreeMap<String, Lines>, String> {
    let root = format!("{}/", root().display());
    let mut files: BTreeMap<String, Lines> = BTreeMap::new();
    let mut lines = None;
    for record in report.lines() {
        if let Some(path) = record.strip_prefix("SF:") {
            let file = path.strip_prefix(&root).unwrap_or(path);
            lines = (!file.starts_with('/')).then(|| files.entry(file.to_string()).or_default());
        } else if let (Some(record), Some(lines)) = (record.strip_prefix("DA:"), &mut lines) {
            let wrong = || format!("lcov report: DA:{record}");
            let mut fields = record.split(',');
            let mut number = || fields.next().and_then(|f| f.parse::<u64>().ok()).ok_or_else(wrong);
            let (line, count) = (number()? as usize, number()?);
            *lines.entry(line).or_default() |= count > 0;
        }
    }
    Ok(files)
}

/// The first line of a file's tests: one past the end if it has none.
fn first_test_line(source: &str) -> usize {
    let lines: Vec<&str> = source.lines().collect();
    let tests =
        lines.windows(2).position(|w| w[0] == "#[cfg(test)]" && w[1].starts_with("mod tests {"));
    tests.unwrap_or(lines.len()) + 1
}

/// `[3, 4, 5, 9]` as `3-5, 9`.
fn ranges(lines: &[usize]) -> String {
    let mut text = Vec::new();
    let mut rest = lines;
    while let Some(&first) = rest.first() {
        let run = rest.iter().zip(first..).take_while(|(line, expected)| *line == expected).count();
        text.push(match run {
            1 => first.to_string(),
            _ => format!("{first}-{}", first + run - 1),
        });
        rest = &rest[run..];
    }
    text.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_read() {
        let file = root().join("core/kernel/src/x.rs");
        let report = format!(
            "SF:{}\nFN:1,f\nDA:1,4\nDA:2,0\nDA:2,1\nDA:3,0\nend_of_record\nSF:/elsewhere/y.rs\n\
             DA:1,0\nend_of_record\n",
            file.display()
        );
        let files = parse(&report).expect("a report");
        let lines = Lines::from([(1, true), (2, true), (3, false)]);
        assert_eq!(files, BTreeMap::from([("core/kernel/src/x.rs".to_string(), lines)]));
        assert!(parse(&format!("SF:{}\nDA:1\n", file.display())).is_err());
    }

    #[test]
    fn tests_are_not_counted() {
        assert_eq!(first_test_line("a\nb\n"), 3);
        assert_eq!(first_test_line("a\n#[cfg(test)]\nmod tests {\n    b\n}\n"), 2);
        assert_eq!(first_test_line("#[cfg(test)]\nmod tests;\nb\n"), 4);
    }

    #[test]
    fn lines_are_given_as_ranges() {
        assert_eq!(ranges(&[3, 4, 5, 9, 11, 12]), "3-5, 9, 11-12");
        assert_eq!(ranges(&[]), "");
    }
}
