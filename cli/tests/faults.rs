//! A machine that lacks something, and signals: an exit code of the table, and no file left behind.
//!
//! Limits are those of the shell (`ulimit`), and of `prlimit` for another user's threads.
#![cfg(target_os = "linux")]

use crate::common::{Run, ltbw, names, program};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The command that ends a program which hangs.
const PATIENCE: &str = "timeout --foreground -s KILL 200";

/// Runs the program under the limits of a shell, with backtraces: the standard library's printing
/// of one for a failed allocation waits for itself. A program that hangs has the code 137.
///
/// The standard library ends the process where the stack for signals of a new thread finds no
/// memory: then the run is repeated, as it does not come twice.
fn limited(dir: &Path, limits: &str, args: &[&str]) -> Run {
    let mut command = Command::new("sh");
    let script = format!("{limits} && exec {PATIENCE} \"$@\"");
    command.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_ltbw")]).args(args);
    command.env("RUST_BACKTRACE", "1");
    command.current_dir(dir).stdin(Stdio::null());
    for _ in 0..3 {
        let output = command.output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        if output.status.code().is_some() || !told.contains("an alternative stack") {
            assert!(output.status.code().is_some(), "{limits} {args:?}: {}: {told}", output.status);
            return Run::of(output);
        }
        println!("repeated: {limits} {args:?}: {told}");
    }
    panic!("{limits} {args:?}: no stack for signals, three times");
}

/// Inputs, and commands that read one and write one file, which is the last word of each.
const COMMANDS: [&[&str]; 6] = [
    &["delaunay", "points.npy", "-o", "d.vtu"],
    &["delaunay", "points.npy", "--threads", "2", "-o", "e.msh"],
    &["mesh", "domain.poly", "--max-volume", "2e-4", "-o", "m.vtk"],
    &["mesh", "domain.poly", "--max-volume", "2e-4", "--workers", "2", "-o", "w.vtk"],
    &["convert", "points.npy", "c.csv"],
    &["generate", "uniform", "1000000", "-o", "g.npy"],
];

fn inputs(dir: &Path) -> Vec<String> {
    let made = ltbw(dir, &["generate", "uniform", "60000", "-o", "points.npy"]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    let made = ltbw(dir, &["generate", "cube-octahedron", "-o", "domain.poly"]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    names(dir)
}

/// The files in a folder beside its inputs, which are removed.
fn take(dir: &Path, inputs: &[String]) -> Vec<String> {
    let others: Vec<String> = names(dir).into_iter().filter(|n| !inputs.contains(n)).collect();
    others.iter().for_each(|name| std::fs::remove_file(dir.join(name)).unwrap());
    others
}

/// From 20 MB to 2 GB in 50 steps: done, with the file, or a lack of memory, without one. With more
/// memory than has been enough some times little new can be seen: a fifth of the steps.
#[test]
fn a_lack_of_memory_has_its_code_and_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let inputs = inputs(dir);
    for args in COMMANDS {
        let mut codes = Vec::new();
        for step in 0..50 {
            if step % 5 != 4 && codes.ends_with(&[0; 4]) {
                continue;
            }
            // With less the loader does not find room for the program.
            let kibibytes = (26e3 * 80_f64.powf(f64::from(step) / 49.0)) as u64;
            let run = limited(dir, &format!("ulimit -v {kibibytes}"), args);
            let left = take(dir, &inputs);
            let at = format!("{args:?}, {kibibytes} KiB: {}", run.stderr);
            match run.code {
                0 => assert_eq!(left, [*args.last().unwrap()], "{at}"),
                7 => assert!(left.is_empty(), "{left:?} {at}"),
                code => panic!("{code}: {at}"),
            }
            assert!(run.code == 0 || run.stderr.contains("memory") || has_no_threads(&run), "{at}");
            codes.push(run.code);
        }
        assert!(codes[0] == 7 && codes.ends_with(&[0; 5]), "{args:?}: {codes:?}");
    }
}

/// A thread needs memory for its stack, too.
fn has_no_threads(run: &Run) -> bool {
    run.stderr.contains("threads: ") || run.stderr.contains("cannot catch Ctrl-C")
}

/// A file that may not grow any more: `SIGXFSZ` would end the program.
#[test]
fn a_limit_of_file_size_is_an_output_that_cannot_be_written() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let inputs = inputs(dir);
    for blocks in [0, 1, 16, 1000] {
        for args in COMMANDS {
            let run = limited(dir, &format!("ulimit -f {blocks}"), args);
            assert_eq!(run.code, 6, "{args:?}: {}", run.stderr);
            assert!(run.error().ends_with("File too large (os error 27)"), "{}", run.stderr);
            assert_eq!(take(dir, &inputs), [""; 0], "{args:?}");
        }
    }
}

/// Root may have any number of threads: the program runs as somebody else, if it can.
#[test]
fn a_lack_of_threads_has_its_code_and_leaves_nothing() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let inputs = inputs(dir);
    std::fs::set_permissions(dir, std::fs::Permissions::from_mode(0o777)).unwrap();
    let as_nobody = |threads: u32, args: &[&str]| {
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65533", "--regid=65533", "--clear-groups", "prlimit"]);
        command.arg(format!("--nproc={threads}")).arg("--").args(PATIENCE.split(' '));
        command.arg(env!("CARGO_BIN_EXE_ltbw"));
        command.args(args).current_dir(dir).stdin(Stdio::null()).output()
    };
    let able = as_nobody(1000, &["--version"]).is_ok_and(|output| output.status.success());
    if !able {
        assert!(std::env::var("LTBW_REQUIRE").is_err(), "no setpriv or prlimit, or not root");
        eprintln!("skipped: threads are not limited without setpriv, prlimit and root");
        return;
    }
    for args in COMMANDS {
        // The threads of the pool, of Ctrl-C, of workers: each is refused once. One is `timeout`.
        let mut codes = Vec::new();
        for threads in 2..=13 {
            let run = Run::of(as_nobody(threads, args).unwrap());
            let left = take(dir, &inputs);
            codes.push(run.code);
            if run.code == 0 {
                assert_eq!(left, [*args.last().unwrap()]);
                continue;
            }
            assert_eq!((run.code, left.len()), (7, 0), "{args:?} {threads}: {}", run.stderr);
            assert!(run.error().ends_with("; nothing was written"), "{}", run.stderr);
        }
        assert!(codes[1] == 7 && codes.is_sorted_by(|a, b| a >= b), "{args:?}: {codes:?}");
        let run = Run::of(as_nobody(1000, args).unwrap());
        assert_eq!(run.code, 0, "{args:?}: {}", run.stderr);
        assert_eq!(take(dir, &inputs), [*args.last().unwrap()]);
    }
}

/// A signal while a file is being written: there is a temporary file then, and none afterwards.
#[test]
fn a_signal_while_writing_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let made = ltbw(dir, &["generate", "uniform", "1500000", "-o", "points.npy"]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    let inputs = names(dir);
    let cases: [&[&str]; 2] =
        [&["generate", "uniform", "1500000", "-o", "g.csv"], &["convert", "points.npy", "c.csv"]];
    for args in cases {
        // The file may be whole before the signal is there; then once more.
        let cancelled = (0..20).any(|_| {
            let mut command = program(dir, args);
            let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
            let begun = Instant::now();
            let is_there = || names(dir).iter().any(|name| name.starts_with(".ltbw-"));
            while !is_there() && begun.elapsed() < Duration::from_secs(60) {
                std::thread::sleep(Duration::from_millis(1));
            }
            let id = child.id().to_string();
            assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
            let run = Run::of(child.wait_with_output().unwrap());
            let left = take(dir, &inputs);
            match run.code {
                4 => {
                    assert!(left.is_empty(), "{left:?}");
                    assert!(run.error().contains("cancelled"), "{}", run.stderr);
                    true
                }
                code => {
                    assert_eq!((code, &*left), (0, &[(*args.last().unwrap()).to_owned()][..]));
                    false
                }
            }
        });
        assert!(cancelled, "{args:?}");
    }
}
