//! `ltbw vectors run`: levels and flags of a right executor, of wrong ones, and of none.

use crate::common::{Run, ltbw};
use crate::require;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn kit() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../verify/vectors")
}

/// The program for Python, if there is one.
fn python() -> Option<&'static str> {
    let mut probe = Command::new("python3");
    let found = probe.arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if found.is_ok_and(|status| status.success()) {
        return Some("python3");
    }
    require::skip("the Python executor", "python3", "python3 is not installed").unwrap();
    None
}

/// Asks a Python program of the kit's folders.
fn ask(script: &Path, folders: &[&str]) -> Run {
    let kit = kit();
    let mut args = vec!["vectors", "run", "--executor", "python3", "--kit"];
    args.push(kit.to_str().unwrap());
    for folder in folders {
        args.extend(["--folder", folder]);
    }
    args.extend(["--", script.to_str().unwrap()]);
    ltbw(Path::new("."), &args)
}

/// An executor that is right but for one line.
fn spoiled(dir: &Path, line: &str) -> PathBuf {
    let path = dir.join("spoiled.py");
    let kit = kit();
    let head =
        format!("import sys\nsys.path.insert(0, {:?})\nimport executor\n", kit.to_str().unwrap());
    std::fs::write(&path, format!("{head}{line}\nexecutor.main()\n")).unwrap();
    path
}

#[test]
fn an_executor_in_python_reaches_every_level() {
    if python().is_none() {
        return;
    }
    let run = ask(&kit().join("executor.py"), &[]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    for (folder, level) in [
        ("predicates", 3),
        ("order", 2),
        ("cavity", 3),
        ("insert", 3),
        ("delaunay", 3),
        ("protocol", 3),
        ("interleavings", 2),
        ("rounds", 2),
    ] {
        assert!(
            run.stdout.contains(&format!("{folder:<14} level {level} of {level}: ")),
            "{}",
            run.stdout
        );
    }
    assert!(!run.stdout.contains("not supported"), "{}", run.stdout);
}

#[test]
fn a_protocol_without_a_rule_is_told_by_its_flags() {
    if python().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    // Wounds, the only reason for a setback, are not obeyed: older requests wait for younger ones.
    let deaf = "executor.Worker.on_wound = lambda *_, **__: None";
    let run = ask(&spoiled(dir.path(), deaf), &["protocol"]);
    assert_eq!(run.code, 1);
    assert!(
        run.stdout.contains("  wound: ") && run.stdout.contains("level 0 of 3"),
        "{}",
        run.stdout
    );
    assert!(!run.stdout.contains("  bounce: "), "{}", run.stdout);
}

#[test]
fn rounds_without_a_rule_are_told_by_their_flags() {
    if python().is_none() {
        return;
    }
    // The faces beyond do not count; one that is killed kills nobody; one wave is enough.
    let spoilt = [
        (
            "foremost-beyond",
            "old = executor.answer_foremost\n\
             executor.ANSWERS['foremost'] = lambda ask: old({**ask, \
             'neighbours': [[t for t in range(len(ask['over']))][k:k + 1] * 4 for k in \
             range(len(ask['over']))]})",
        ),
        (
            "second-wave",
            "executor.ANSWERS['quiet'] = lambda ask: {'quiet': ask['sums'][0] == ask['sums'][1]}",
        ),
        ("key", "executor.bits = lambda number: int(number)"),
    ];
    for (flag, line) in spoilt {
        let dir = tempfile::tempdir().unwrap();
        let run = ask(&spoiled(dir.path(), line), &["rounds"]);
        assert_eq!(run.code, 1, "{flag}: {}", run.stderr);
        assert!(run.stdout.contains(&format!("  {flag}: ")), "{flag}: {}", run.stdout);
        assert!(!run.stdout.contains("  tree: "), "{flag}: {}", run.stdout);
    }
}

#[test]
fn wrong_answers_are_told_by_their_flags() {
    if python().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let rounded = "executor.read = lambda p: tuple(float.fromhex(c) for c in p)";
    let run = ask(&spoiled(dir.path(), rounded), &["predicates"]);
    assert_eq!(run.code, 1);
    assert!(
        run.stdout.contains("  rounded: ") && run.stdout.contains("  range: "),
        "{}",
        run.stdout
    );
    assert!(!run.stdout.contains("sign-convention: "), "{}", run.stdout);

    let no_tie = "executor.side_of_sphere = lambda cell, p: executor.insphere(*cell, p)";
    let run = ask(&spoiled(dir.path(), no_tie), &["predicates"]);
    assert_eq!(run.code, 1);
    assert!(
        run.stdout.contains("  tie: ") && !run.stdout.contains("  rounded: "),
        "{}",
        run.stdout
    );
    assert!(run.stdout.contains("level 0 of 3"), "the first tier has ties, too: {}", run.stdout);

    let silent = "executor.main = lambda: None";
    let run = ask(&spoiled(dir.path(), silent), &["order"]);
    assert_eq!(run.code, 1);
    assert!(run.stderr.contains("started again"), "{}", run.stderr);
}

/// Texts of the files under a folder by path, apart from Python's caches.
fn texts(root: &Path) -> BTreeMap<PathBuf, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.strip_prefix(root).unwrap().to_owned();
            match path.is_dir() {
                true if name.ends_with("__pycache__") => {}
                true => folders.push(path),
                false => {
                    found.insert(name, std::fs::read_to_string(path).unwrap());
                }
            }
        }
    }
    found
}

#[test]
fn the_kit_inside_the_program_is_that_of_the_repository() {
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["vectors", "unpack", "new/kit"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let unpacked = texts(&dir.path().join("new/kit"));
    let own = texts(&kit());
    assert!(unpacked.keys().eq(own.keys()), "`cargo xtask vectors` packs the kit anew");
    for (path, text) in &own {
        assert!(unpacked[path] == *text, "{}: `cargo xtask vectors`", path.display());
    }
    assert!(own.len() > 20 && own.contains_key(Path::new("executor.py")));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = |name: &str| {
            let file = dir.path().join("new/kit").join(name);
            std::fs::metadata(file).unwrap().permissions().mode()
        };
        assert_eq!((mode("executor.py") & 0o100, mode("README.md") & 0o111), (0o100, 0));
    }
    // A folder that cannot be made is an output that cannot be written.
    std::fs::write(dir.path().join("file"), "").unwrap();
    assert_eq!(ltbw(dir.path(), &["vectors", "unpack", "file/kit"]).code, 6);
}

#[test]
fn porting_needs_the_program_alone() {
    if python().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/porting.md");
    let page = std::fs::read_to_string(page).unwrap();
    let lines = page.lines().filter_map(|line| line.strip_prefix("    ltbw "));
    // `./port` is the reader's own program.
    let commands: Vec<&str> = lines.filter(|line| !line.contains("./port")).collect();
    assert_eq!(commands.len(), 2, "{commands:?}");
    for command in commands {
        let mut args: Vec<&str> = command.split(' ').collect();
        if let Some(executor) = args.iter().position(|word| *word == "--executor") {
            // All of it is asked for above.
            args.splice(executor..executor, ["--folder", "cavity"]);
        }
        let run = ltbw(dir.path(), &args);
        assert_eq!(run.code, 0, "{command}: {}", run.stderr);
    }
}

#[test]
fn no_executor_and_no_kit_are_refused() {
    let missing = ["vectors", "run", "--executor", "./no-such-program"];
    let run = ltbw(Path::new("."), &missing);
    assert_eq!(run.code, 2);
    assert!(run.error().contains("no-such-program"));
    let missing = ["vectors", "run", "--executor", "true", "--kit", "no-such-kit"];
    let run = ltbw(Path::new("."), &missing);
    assert_eq!(run.code, 2);
    assert!(run.error().contains("no-such-kit"));
}
