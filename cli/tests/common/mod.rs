//! Running the program in a folder of its own.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// A run of the program that has ended.
pub(crate) struct Run {
    /// The exit code.
    pub(crate) code: i32,
    /// Its output on stdout.
    pub(crate) stdout: String,
    /// Its output on stderr.
    pub(crate) stderr: String,
}

impl Run {
    /// The ended run of a program.
    pub(crate) fn of(output: Output) -> Self {
        Self {
            code: output.status.code().expect("the program was not killed"),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// The line of stderr that tells the error, without `ltbw: `; the last line, and the only
    /// one of its kind.
    pub(crate) fn error(&self) -> &str {
        let errors = self.stderr.lines().filter(|l| l.starts_with("ltbw: ")).count();
        assert_eq!(errors, 1, "{}", self.stderr);
        let last = self.stderr.lines().last().unwrap();
        last.strip_prefix("ltbw: ").unwrap_or_else(|| panic!("{}", self.stderr))
    }
}

/// The program, to be run in `dir`.
pub(crate) fn program(dir: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ltbw"));
    command.args(args).current_dir(dir).stdin(Stdio::null());
    command
}

/// Runs the program in `dir`.
pub(crate) fn ltbw(dir: &Path, args: &[&str]) -> Run {
    Run::of(program(dir, args).output().unwrap())
}

/// Runs the program in `dir`; it ends with this code.
pub(crate) fn run(dir: &Path, args: &[&str], code: i32) -> Run {
    let run = ltbw(dir, args);
    assert_eq!(run.code, code, "{args:?}: {}", run.stderr);
    run
}

/// JSON.
pub(crate) fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// JSON in a file.
pub(crate) fn read_json(path: impl AsRef<Path>) -> Value {
    json(&std::fs::read_to_string(path).unwrap())
}

/// The files in a folder.
pub(crate) fn names(dir: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(dir)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// A domain whose points are in a file of their own: `e.poly` and `e.node`, from `d.poly`.
pub(crate) fn points_apart(dir: &Path) {
    let whole = std::fs::read_to_string(dir.join("d.poly")).unwrap();
    let mut lines = whole.lines().skip_while(|line| line.starts_with('#'));
    let count: usize = lines.next().unwrap().split(' ').next().unwrap().parse().unwrap();
    let points: Vec<&str> = lines.by_ref().take(count).collect();
    let facets: Vec<&str> = lines.collect();
    let node = format!("{count} 3 0 0\n{}\n", points.join("\n"));
    std::fs::write(dir.join("e.node"), node).unwrap();
    std::fs::write(dir.join("e.poly"), format!("0 3 0 0\n{}\n", facets.join("\n"))).unwrap();
}
