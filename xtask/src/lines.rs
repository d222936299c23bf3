//! `lines`: how much there is to read, by folder: code without blanks, comments and tests.
//!
//! Lines are told apart by the tests of tidiness themselves ([`source`]), so that a line of code is
//! one thing in both. With a commit, all is counted there as well, and the difference is printed.

use crate::shell::command;
use crate::source;
use std::collections::BTreeMap;
use std::ops::AddAssign;

/// Folders that tell what refinement is, wherever they stand.
const REFINEMENT: [&str; 2] = ["refine", "refining"];

/// The lines that one file, or one folder, has.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
struct Count {
    files: usize,
    /// All lines, as `wc` counts them.
    all: usize,
    /// Lines of shipped code.
    code: usize,
    /// Lines that hold a comment and no code, in shipped files.
    comments: usize,
}

impl AddAssign for Count {
    fn add_assign(&mut self, other: Self) {
        self.files += other.files;
        self.all += other.all;
        self.code += other.code;
        self.comments += other.comments;
    }
}

impl Count {
    /// Counts the file of this path. A file of tests has lines, but neither code nor comments.
    fn of(path: &str, text: &str) -> Self {
        let all = text.lines().count();
        if is_test(path) {
            return Self { files: 1, all, ..Self::default() };
        }
        let comment = |line: &&str| line.trim_start().starts_with("//");
        let comments = text.lines().filter(comment).count();
        Self { files: 1, all, code: source::lines_of_code(text), comments }
    }
}

/// Counts by folder.
type Counts = BTreeMap<String, Count>;

/// Does the file belong to tests, or to the suites about them?
fn is_test(path: &str) -> bool {
    let mut parts = path.split('/').peekable();
    let suite = parts.peek().is_some_and(|first| ["tests", "fuzz"].contains(first));
    suite || parts.any(|part| part == "tests" || part == "tests.rs" || part.ends_with("_tests.rs"))
}

/// Is the file about refinement?
fn is_refinement(path: &str) -> bool {
    path.split('/').any(|part| REFINEMENT.contains(&part.trim_end_matches(".rs")))
}

/// Counts the working tree, and the commit that is named.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let before = match args {
        [] => None,
        [commit] if !commit.starts_with('-') => Some(at(commit)?),
        _ => return Err("usage: lines [COMMIT]".to_owned()),
    };
    let now = count(&here()?);
    print(&now, before.map(|files| count(&files)).as_ref());
    Ok(())
}

/// A Rust source.
struct Source {
    path: String,
    text: String,
}

/// Files of the working tree that git tracks or would.
fn here() -> Result<Vec<Source>, String> {
    let names = git(&["ls-files", "--cached", "--others", "--exclude-standard", "*.rs"])?;
    let read = |name: &str| {
        let text = std::fs::read_to_string(crate::shell::root().join(name)).ok()?;
        Some(Source { path: name.to_owned(), text })
    };
    // A file that is deleted, but not yet for git, has no lines.
    Ok(names.lines().filter_map(read).collect())
}

/// Files of a commit.
fn at(commit: &str) -> Result<Vec<Source>, String> {
    let names = git(&["ls-tree", "-r", "--name-only", "--end-of-options", commit])?;
    let rust = names.lines().filter(|name| name.ends_with(".rs"));
    let shown = |name: &str| git(&["show", &format!("{commit}:{name}")]);
    rust.map(|name| Ok(Source { path: name.to_owned(), text: shown(name)? })).collect()
}

/// The text that git prints.
fn git(args: &[&str]) -> Result<String, String> {
    let output = command("git").args(args).output().map_err(|error| format!("git: {error}"))?;
    if !output.status.success() {
        return Err(format!("git: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    String::from_utf8(output.stdout).map_err(|error| format!("git {}: {error}", args.join(" ")))
}

/// Counts by folder, with sums named `= refinement` and `= all`.
fn count(files: &[Source]) -> Counts {
    let mut counts = Counts::new();
    for Source { path, text } in files {
        let count = Count::of(path, text);
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        let mut add = |name: &str| *counts.entry(name.to_owned()).or_default() += count;
        add(folder);
        add("= all");
        if is_refinement(path) {
            add("= refinement");
        }
    }
    counts
}

/// A line for each folder and each sum; with `before`, how much code has come or gone.
fn print(now: &Counts, before: Option<&Counts>) {
    let head = ["folder", "files", "lines", "code", "comments", "share"];
    let [folder, files, all, code, comments, share] = head;
    let change = if before.is_some() { "  change of code, lines" } else { "" };
    println!("{folder:<44} {files:>5} {all:>7} {code:>7} {comments:>8} {share:>6}{change}");
    let mut names: Vec<&String> = now.keys().chain(before.iter().flat_map(|b| b.keys())).collect();
    names.sort_by_key(|name| (name.starts_with('='), name.as_str()));
    names.dedup();
    for name in names {
        let get = |counts: &Counts| counts.get(name).copied().unwrap_or_default();
        let Count { files, all, code, comments } = get(now);
        let share = percent(comments, code + comments);
        let change = before.map_or_else(String::new, |before| {
            let was = get(before);
            format!("  {:>+8} {:>+8}", difference(code, was.code), difference(all, was.all))
        });
        println!("{name:<44} {files:>5} {all:>7} {code:>7} {comments:>8} {share:>6}{change}");
    }
}

/// `part` of `whole`, in percent.
fn percent(part: usize, whole: usize) -> String {
    (100 * part).checked_div(whole).map_or_else(|| "-".to_owned(), |share| format!("{share} %"))
}

/// The excess of `now` over `was`.
fn difference(now: usize, was: usize) -> i64 {
    i64::try_from(now).unwrap_or(i64::MAX) - i64::try_from(was).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_comments_and_tests_are_told_apart() {
        let text = "//! A page.\n\nfn f() {\n    // why\n    g(); // how\n}\n\n#[cfg(test)]\n\
                    mod tests {\n    fn h() {}\n}\n";
        let count = Count::of("core/refine/src/f.rs", text);
        assert_eq!(count, Count { files: 1, all: 11, code: 3, comments: 2 });
        for path in ["core/refine/tests/f.rs", "core/refine/src/tests.rs", "tests/src/f.rs"] {
            assert_eq!(Count::of(path, text), Count { files: 1, all: 11, code: 0, comments: 0 });
        }
    }

    #[test]
    fn folders_are_summed_and_refinement_is_found_by_name() {
        let file = |path: &str| Source { path: path.to_owned(), text: "fn f() {}\n".to_owned() };
        let files = ["a/src/refine/x.rs", "a/src/refine.rs", "b/refining/y/z.rs", "a/src/w.rs"];
        let counts = count(&files.map(file));
        assert_eq!(counts["= all"].code, 4);
        assert_eq!(counts["= refinement"].code, 3);
        assert_eq!(counts["a/src"].files, 2);
    }
}
