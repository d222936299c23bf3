//! stdin and stdout in place of files: `-` and `--format`.

use crate::common::{Run, ltbw, names, program};
use std::io::Write;
use std::path::Path;
use std::process::{Output, Stdio};

/// Runs the program with `input` on stdin.
fn fed(dir: &Path, input: &[u8], args: &[&str]) -> Output {
    let mut command = program(dir, args);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    std::thread::scope(|scope| {
        // A refused command line closes the pipe early.
        scope.spawn(move || drop(stdin.write_all(input)));
        child.wait_with_output().unwrap()
    })
}

fn bytes(dir: &Path, name: &str) -> Vec<u8> {
    std::fs::read(dir.join(name)).unwrap()
}

#[test]
fn points_come_from_stdin_and_the_mesh_goes_to_stdout() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    assert_eq!(ltbw(dir, &["generate", "uniform", "200", "-o", "p.npy"]).code, 0);
    let whole = ltbw(dir, &["delaunay", "p.npy", "-o", "m.vtu"]);
    assert_eq!(whole.code, 0, "{}", whole.stderr);
    let points = bytes(dir, "p.npy");
    for name in ["-", "/dev/stdin"] {
        let run = Run::of(fed(dir, &points, &["delaunay", name, "--format", "npy"]));
        assert_eq!((run.code, &run.stdout), (0, &whole.stdout), "{}", run.stderr);
        assert!(run.stderr.contains("200 in stdin"), "{}", run.stderr);
    }
    let args = ["delaunay", "-", "--format", "npy", "-o", "-", "--output-format", "vtu"];
    let run = fed(dir, &points, &args);
    assert_eq!(run.status.code(), Some(0));
    assert!(run.stdout == bytes(dir, "m.vtu"), "nothing but the mesh is on stdout");
    assert!(String::from_utf8_lossy(&run.stderr).contains("wrote     stdout"));
    // The one format is that of the one stream.
    for args in [
        &["delaunay", "p.npy", "-o", "-", "--format", "vtu"][..],
        &["delaunay", "p.npy", "-o", "/dev/stdout", "--format", "vtu", "--quiet"],
        &["convert", "m.vtu", "-", "--format", "vtu"],
    ] {
        let run = fed(dir, b"", args);
        assert_eq!(run.status.code(), Some(0), "{args:?}");
        assert!(run.stdout == bytes(dir, "m.vtu"), "{args:?}");
    }
    assert_eq!(names(dir), ["m.vtu", "p.npy"]);
}

#[test]
fn commands_are_joined_by_pipes() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let made = fed(dir, b"", &["generate", "wedge", "-o", "-", "--format", "poly"]);
    assert_eq!(made.status.code(), Some(0));
    assert_eq!(ltbw(dir, &["generate", "wedge", "-o", "d.poly"]).code, 0);
    assert!(made.stdout == bytes(dir, "d.poly"));
    let args = ["mesh", "-", "--format", "poly", "-o", "-", "--output-format", "msh"];
    let mesh = fed(dir, &made.stdout, &args);
    assert_eq!(mesh.status.code(), Some(0), "{}", String::from_utf8_lossy(&mesh.stderr));
    assert_eq!(ltbw(dir, &["mesh", "d.poly", "-o", "d.msh"]).code, 0);
    assert!(mesh.stdout == bytes(dir, "d.msh"));
    let check = fed(dir, &mesh.stdout, &["check", "-", "--format", "msh", "--plc", "d.poly"]);
    assert_eq!(check.status.code(), Some(0), "{}", String::from_utf8_lossy(&check.stderr));
    let check = fed(dir, &made.stdout, &["check", "-", "--format", "poly"]);
    assert_eq!(check.status.code(), Some(0), "{}", String::from_utf8_lossy(&check.stderr));
    // Points, too, and a file without extension.
    let args = ["convert", "-", "-", "--format", "msh", "--output-format", "xyz"];
    let points = fed(dir, &mesh.stdout, &args);
    assert_eq!(points.status.code(), Some(0));
    std::fs::write(dir.join("points"), &points.stdout).unwrap();
    let run = ltbw(dir, &["delaunay", "points", "--format", "xyz"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = ltbw(dir, &["convert", "d.msh", "mesh", "--format", "vtu"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = ltbw(dir, &["check", "mesh", "--format", "vtu", "--plc", "d.poly"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(names(dir), ["d.msh", "d.poly", "mesh", "points"]);
}

#[test]
fn streams_that_make_no_sense_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    assert_eq!(ltbw(dir, &["generate", "uniform", "50", "-o", "p.npy"]).code, 0);
    assert_eq!(ltbw(dir, &["delaunay", "p.npy", "-o", "m.ele", "-o", "m.vtu"]).code, 0);
    std::fs::write(dir.join("d.poly"), "0 3 0 0\n0 0\n0\n0\n").unwrap();
    let several = "is a format of several files here, which one stream cannot be";
    let told = "the extension of every file tells its format";
    let cases: [(&[&str], i32, &str); 14] = [
        (&["delaunay", "-"], 2, "stdin: --format has to name its format"),
        (&["delaunay", "p.npy", "-o", "-"], 2, "has to name its format"),
        (&["convert", "-", "-", "--format", "vtu"], 2, "stdout: --format, or --output-format"),
        (&["delaunay", "p.npy", "--format", "npy"], 2, told),
        (&["delaunay", "p.npy", "--output-format", "vtu"], 2, told),
        (&["delaunay", "p.npy", "-o", "-", "--format", "ele"], 2, several),
        (&["delaunay", "p.npy", "-o", "-", "--format", "npy"], 2, "this format holds points"),
        (&["delaunay", "p.npy", "-o", "-", "--format", "pvtu"], 2, "pvtu"),
        (&["check", "-", "--format", "ele"], 3, several),
        (&["mesh", "-", "--format", "poly"], 3, several),
        (&["delaunay", "p.npy", "-o", "-", "--json", "-", "--format", "vtu"], 2, "two outputs"),
        (&["delaunay", "-", "--format", "npy"], 3, "stdin: header: not a NumPy file"),
        (&["generate", "uniform", "5", "-o", "-", "--format", "stl"], 2, "only read"),
        (&["mesh", "d.poly", "-o", "-"], 2, "stdout: --format"),
    ];
    for (args, code, text) in cases {
        let run = Run::of(fed(dir, b"0 3 0 0\n0 0\n0\n0\n", args));
        assert_eq!(run.code, code, "{args:?}: {}", run.stderr);
        assert!(run.error().contains(text), "{args:?}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{args:?}");
    }
}

/// Pages, pictures and traces go where reports go: `-` is stdout, and never a file of that name.
#[test]
fn pages_pictures_and_traces_go_to_stdout() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    assert_eq!(ltbw(dir, &["generate", "uniform", "300", "-o", "p.npy"]).code, 0);
    assert_eq!(ltbw(dir, &["generate", "wedge", "-o", "d.poly"]).code, 0);
    let simulate = ["simulate", "--points", "5e2", "--processors", "2e0"];
    let threads = ["delaunay", "p.npy", "--threads", "2"];
    let (html, trace) = (("<!doctype html>", "</html>"), ("{", "}"));
    let cases = [
        (&["delaunay", "p.npy", "--page", "-"][..], html),
        (&[&threads[..], &["--trace", "-"]].concat(), trace),
        (&["mesh", "d.poly", "--page", "-"], html),
        (&["mesh", "d.poly", "--histogram", "/dev/stdout"], ("<svg", "</svg>")),
        (&[&simulate[..], &["--page", "-"]].concat(), html),
        (&[&simulate[..], &["--trace", "-"]].concat(), trace),
    ];
    for (args, (start, end)) in cases {
        let run = Run::of(fed(dir, b"", args));
        assert_eq!(run.code, 0, "{args:?}: {}", run.stderr);
        let text = run.stdout.trim();
        assert!(text.to_lowercase().starts_with(start), "{args:?}: {text:.100}");
        assert!(text.ends_with(end), "{args:?}: nothing else is on stdout");
        assert!(run.stderr.contains("wrote     stdout"), "{args:?}: {}", run.stderr);
    }
    let twice = [&threads[..], &["--page", "-", "--json", "-"]].concat();
    let cases: [&[&str]; 4] = [
        &twice,
        &["mesh", "d.poly", "--page", "-", "--histogram", "-"],
        &["mesh", "d.poly", "-o", "-", "--output-format", "vtu", "--page", "/dev/stdout"],
        &["simulate", "--points", "500", "--json", "-", "--trace", "-"],
    ];
    for args in cases {
        let run = Run::of(fed(dir, b"", args));
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{args:?}: {}", run.stderr);
        assert!(run.error().contains("two outputs"), "{args:?}: {}", run.stderr);
    }
    assert_eq!(names(dir), ["d.poly", "p.npy"]);
}

/// Of a mesh and its domain either may come from stdin; `--format` is about that one.
#[test]
fn a_domain_to_conform_to_comes_from_stdin() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    for args in [&["generate", "wedge", "-o", "d.poly"][..], &["mesh", "d.poly", "-o", "d.vtu"]] {
        assert_eq!(ltbw(dir, args).code, 0);
    }
    let domain = bytes(dir, "d.poly");
    let args = ["check", "d.vtu", "--plc", "-", "--format", "poly"];
    let run = Run::of(fed(dir, &domain, &args));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = Run::of(fed(dir, &domain, &["check", "d.vtu", "--plc", "-"]));
    assert_eq!((run.code, run.error()), (2, "stdin: --format has to name its format"));
    let run = Run::of(fed(dir, &domain, &["check", "-", "--plc", "-", "--format", "vtk"]));
    assert_eq!((run.code, run.error()), (2, "stdin: two inputs cannot both be read from it"));
}

/// A reader of data that is gone has not got all of it: the output could not be written.
#[cfg(unix)]
#[test]
fn data_for_a_closed_pipe_could_not_be_written() {
    let dir = tempfile::tempdir().unwrap();
    let args = ["generate", "uniform", "100000", "-o", "-", "--format", "npy"];
    let mut child =
        program(dir.path(), &args).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(6));
}
