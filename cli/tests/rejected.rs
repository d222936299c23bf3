//! Refusals of the program: bad input, bad usage, outputs that cannot be written.

use crate::common::{Run, ltbw, names, points_apart, program};

/// Runs `delaunay` on a file with this content, with an output that must not appear.
fn reject(name: &str, content: &[u8]) -> String {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join(name), content).unwrap();
    let run = ltbw(dir.path(), &["delaunay", name, "-o", "out.vtu"]);
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert_eq!(run.stdout, "");
    assert_eq!(names(dir.path()), [name]);
    run.error().to_owned()
}

#[test]
fn points_that_are_no_points() {
    assert_eq!(reject("a.xyz", b"0 0 0\n1 nan 0\n"), "a.xyz: line 2: `nan` is not a finite number");
    assert_eq!(
        reject("a.csv", b"0,0,0\n1,2,-inf\n"),
        "a.csv: line 2: `-inf` is not a finite number"
    );
    assert_eq!(reject("a.xyz", b"0 0 0\n1 2\n"), "a.xyz: line 2: expected 3 values, found 2");
    assert_eq!(
        reject("a.node", b"5 3 0 0\n1 0 0 0\n"),
        "a.node: line 3: the file announces 5 points, but ends after 1"
    );
    assert_eq!(reject("a.npy", b"garbage"), "a.npy: header: not a NumPy file");
    assert_eq!(reject("a.xyz", b"\x00\x01garbage\n"), "a.xyz: line 1: `??garbage` is not a number");
    assert!(reject("a.dat", b"0 0 0\n").starts_with("a.dat: unknown extension"));
    assert!(reject("points", b"0 0 0\n").starts_with("points: unknown extension"));
    assert!(
        reject("a.STEP", b"ISO-10303-21;\n").starts_with("a.STEP: CAD files are not read: mesh")
    );
    assert_eq!(
        reject("a.vtu", b"<VTKFile/>"),
        "a.vtu: this format holds a mesh, but points are wanted"
    );
}

#[test]
fn points_without_a_mesh_name_the_dimension() {
    let lines = |n: usize, f: &dyn Fn(usize) -> String| -> Vec<u8> {
        (0..n).map(f).collect::<Vec<_>>().join("\n").into_bytes()
    };
    for (count, distinct) in [(0, 0), (1, 1), (3, 3), (6, 3)] {
        let error = reject("a.xyz", &lines(count, &|i| format!("{} 0 {}", i % 3, i % 3 * i % 3)));
        assert!(error.contains(&format!("{distinct} distinct point")), "{error}");
        assert!(error.contains("dimension"), "{error}");
    }
    let error = reject("a.xyz", &lines(9, &|i| format!("{i} {} 1", 2 * i)));
    assert!(error.contains("one line (dimension 1"), "{error}");
    let error = reject("a.xyz", &lines(9, &|i| format!("{i} {} 1", i * i)));
    assert!(error.contains("one plane (dimension 2"), "{error}");
    // The same zero twice is one point.
    let error = reject("a.xyz", b"0 0 0\n-0 0 0\n1 0 0\n0 1 0\n");
    assert!(error.contains("3 distinct point"), "{error}");
}

#[test]
fn missing_files_and_folders() {
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["delaunay", "no.xyz"]);
    assert_eq!(
        (run.code, run.error()),
        (3, "no.xyz: cannot read: No such file or directory (os error 2)")
    );
    std::fs::create_dir(dir.path().join("dir.xyz")).unwrap();
    let run = ltbw(dir.path(), &["delaunay", "dir.xyz"]);
    assert_eq!((run.code, run.error()), (3, "dir.xyz: cannot read: not a regular file"));
    for command in ["check", "convert"] {
        let args = [command, "no.vtu", "a.xyz"];
        let run = ltbw(dir.path(), &args[..if command == "check" { 2 } else { 3 }]);
        assert_eq!(run.code, 3);
        assert!(run.error().starts_with("no.vtu: cannot read: "), "{}", run.stderr);
    }
    assert_eq!(names(dir.path()), ["dir.xyz"]);
}

#[test]
fn outputs_that_cannot_be_written() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("dir.vtu")).unwrap();
    let made = ltbw(dir.path(), &["generate", "uniform", "100", "-o", "a.npy"]);
    assert_eq!(made.code, 0);
    for output in ["dir.vtu", "no/a.vtu", "a.npy/b.vtu"] {
        let run = ltbw(dir.path(), &["delaunay", "a.npy", "-o", output]);
        assert_eq!(run.code, 6, "{}", run.stderr);
        assert!(run.error().starts_with(&format!("{output}: cannot write: ")), "{}", run.stderr);
    }
    // Before the work: nothing else is said, and no mesh is left behind.
    for args in [&["delaunay", "a.npy", "-o", "b.vtu"][..], &["check", "missing.vtu"]] {
        let run = ltbw(dir.path(), &[args, &["--json", "no/x.json"]].concat());
        assert_eq!(run.code, 6, "{}", run.stderr);
        let why = "no/x.json: cannot write: the folder no is missing";
        assert_eq!(run.stderr, format!("ltbw: {why}\n"));
    }
    let run = ltbw(dir.path(), &["convert", "a.npy", "no/a.xyz"]);
    assert_eq!(run.code, 6, "{}", run.stderr);
    let run = ltbw(dir.path(), &["generate", "grid", "8", "-o", "no/a.xyz"]);
    assert_eq!(run.code, 6, "{}", run.stderr);
    let run = ltbw(dir.path(), &["man", "no/dir"]);
    let why = "no/dir/ltbw.1: cannot write: the folder no/dir is missing";
    assert_eq!((run.code, run.error()), (6, why));
    assert_eq!(names(dir.path()), ["a.npy", "dir.vtu"]);
}

/// Also where the name of the output is another than that of the input.
#[test]
fn the_input_is_not_overwritten() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(ltbw(dir.path(), &["generate", "uniform", "50", "-o", "p.node"]).code, 0);
    assert_eq!(ltbw(dir.path(), &["delaunay", "p.node", "-o", "m.ele"]).code, 0);
    let bytes = |name: &str| std::fs::read(dir.path().join(name)).unwrap();
    let before = (bytes("p.node"), bytes("m.ele"), bytes("m.node"));
    let cases: [(&[&str], &str); 5] = [
        (&["delaunay", "p.node", "-o", "p.ele"], "p.node"),
        (&["delaunay", "./p.node", "-o", "a.vtu", "-o", "p.node"], "p.node"),
        (&["delaunay", "p.node", "--json", "p.node"], "p.node"),
        (&["check", "m.ele", "--json", "m.ele"], "m.ele"),
        (&["check", "m.ele", "--json", "m.node"], "m.node"),
    ];
    for (args, output) in cases {
        let run = ltbw(dir.path(), args);
        assert_eq!(run.code, 2, "{args:?}: {}", run.stderr);
        assert_eq!(run.stderr, format!("ltbw: {output}: this would overwrite the input\n"));
    }
    assert_eq!((bytes("p.node"), bytes("m.ele"), bytes("m.node")), before);
    assert_eq!(names(dir.path()), ["m.ele", "m.node", "p.node"]);
}

/// Sizes and the mesh that they are about are inputs, too, and so are all files of that mesh.
#[test]
fn sizes_and_the_background_mesh_are_not_overwritten() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(ltbw(dir.path(), &["generate", "l-block", "-o", "d.poly"]).code, 0);
    assert_eq!(ltbw(dir.path(), &["mesh", "d.poly", "-o", "b.ele", "-o", "b.vtu"]).code, 0);
    std::fs::write(dir.path().join("s.mtr"), "1 1\n0.5\n").unwrap();
    let before: Vec<(String, Vec<u8>)> = names(dir.path())
        .into_iter()
        .map(|name| (name.clone(), std::fs::read(dir.path().join(name)).unwrap()))
        .collect();
    let cases: [(&[&str], &str); 6] = [
        (&["--json", "s.mtr"], "s.mtr"),
        (&["--background", "b.vtu", "-o", "a.vtu", "--json", "./s.mtr"], "./s.mtr"),
        (&["--background", "b.vtu", "-o", "b.vtu"], "b.vtu"),
        (&["--background", "b.ele", "--json", "b.ele"], "b.ele"),
        (&["--background", "b.ele", "--json", "b.node"], "b.node"),
        (&["--background", "b.node", "-o", "b.ele"], "b.node"),
    ];
    for (args, output) in cases {
        let args = [&["mesh", "d.poly", "--sizes", "s.mtr"], args].concat();
        let run = ltbw(dir.path(), &args);
        assert_eq!(run.code, 2, "{args:?}: {}", run.stderr);
        assert_eq!(run.error(), format!("{output}: this would overwrite the input"));
    }
    let after = names(dir.path());
    assert_eq!(after.len(), before.len(), "{after:?}");
    for (name, bytes) in before {
        assert!(std::fs::read(dir.path().join(&name)).unwrap() == bytes, "{name}");
    }
}

/// Every file that a command reads, by every option that names an output.
#[test]
fn no_output_is_any_file_that_is_read() {
    let dir = tempfile::tempdir().unwrap();
    let done = |args: &[&str]| assert_eq!(ltbw(dir.path(), args).code, 0, "{args:?}");
    done(&["generate", "l-block", "-o", "d.poly"]);
    points_apart(dir.path());
    done(&["generate", "uniform", "50", "-o", "p.node"]);
    done(&["mesh", "e.poly", "-o", "b.ele"]);
    done(&["mesh", "e.poly", "--workers", "2", "-o", "m.pvtu"]);
    std::fs::write(dir.path().join("s.mtr"), "1 1\n0.5\n").unwrap();
    let read = |name: &String| std::fs::read(dir.path().join(name)).unwrap();
    let before: Vec<(String, Vec<u8>)> =
        names(dir.path()).into_iter().map(|name| (name.clone(), read(&name))).collect();
    let mesh: &[&str] = &["mesh", "e.poly", "--sizes", "s.mtr", "--background", "b.ele"];
    let commands: [(&[&str], &[&str], &[&str]); 7] = [
        (
            mesh,
            &["e.poly", "e.node", "s.mtr", "b.ele", "b.node"],
            &["--json", "--trace", "--page", "--histogram"],
        ),
        (mesh, &["e.poly"], &["--write-defects"]),
        (&["delaunay", "p.node", "--threads", "2"], &["p.node"], &["--json", "--trace", "--page"]),
        (&["check", "m.pvtu"], &["m.pvtu", "m_0.vtu", "m_1.vtu"], &["--json"]),
        (&["check", "e.poly"], &["e.poly", "e.node"], &["--json"]),
        (
            &["check", "b.ele", "--plc", "e.poly"],
            &["b.ele", "b.node", "e.poly", "e.node"],
            &["--json"],
        ),
        (&["simulate", "--domain", "e.poly"], &["e.poly", "e.node"], &["--json"]),
    ];
    for (command, inputs, options) in commands {
        for (input, option) in inputs.iter().flat_map(|i| options.iter().map(move |o| (i, o))) {
            let run = ltbw(dir.path(), &[command, &[option, input]].concat());
            assert_eq!(run.code, 2, "{command:?} {option} {input}: {}", run.stderr);
            assert_eq!(run.error(), format!("{input}: this would overwrite the input"));
        }
    }
    assert_eq!(names(dir.path()).len(), before.len());
    for (name, bytes) in &before {
        assert!(read(name) == *bytes, "{name}");
    }
}

/// Two names of one file that is not there yet are one output, too.
#[cfg(unix)]
#[test]
fn links_to_one_file_are_one_output() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    assert_eq!(ltbw(dir.path(), &["generate", "uniform", "50", "-o", "p.npy"]).code, 0);
    std::os::unix::fs::symlink("m.vtu", at("link.vtu")).unwrap();
    for outputs in [["m.vtu", "link.vtu"], ["link.vtu", "./m.vtu"]] {
        let run = ltbw(dir.path(), &["delaunay", "p.npy", "-o", outputs[0], "--json", outputs[1]]);
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(run.error().ends_with("two outputs would be written there"), "{}", run.stderr);
    }
    let run = ltbw(dir.path(), &["delaunay", "p.npy", "-o", "link.vtu", "--json", "r.json"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(names(dir.path()), ["link.vtu", "m.vtu", "p.npy", "r.json"]);
    assert!(std::fs::symlink_metadata(at("link.vtu")).unwrap().file_type().is_symlink());
}

/// A limit on the size of files stands in for a full disk: writing fails in the middle.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_file() {
    let dir = tempfile::tempdir().unwrap();
    let made = ltbw(dir.path(), &["generate", "uniform", "2000", "-o", "a.npy"]);
    assert_eq!(made.code, 0);
    std::fs::write(dir.path().join("a.xyz"), "old").unwrap();
    for args in ["delaunay a.npy -o a.vtu", "convert a.npy a.xyz", "generate uniform 9000 -o b.npy"]
    {
        // 8 blocks of 512 or 1024 bytes; with the signal ignored, writing fails with an error.
        let script = format!("trap '' XFSZ; ulimit -f 8; exec \"$0\" {args}");
        let output = std::process::Command::new("sh")
            .args(["-c", &script, env!("CARGO_BIN_EXE_ltbw")])
            .current_dir(dir.path())
            .output()
            .unwrap();
        let run = Run::of(output);
        assert_eq!(run.code, 6, "{args}: {}", run.stderr);
        assert!(run.error().contains(": cannot write: "), "{}", run.stderr);
        assert_eq!(names(dir.path()), ["a.npy", "a.xyz"]);
    }
    assert_eq!(std::fs::read(dir.path().join("a.xyz")).unwrap(), b"old");
}

#[test]
fn bad_usage_is_one_line_and_exit_2() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a.xyz"), "0 0 0\n").unwrap();
    let cases: [(&[&str], &str); 15] = [
        (&["delaunay"], "the following required arguments were not provided: <POINTS>"),
        (&["delaunay", "a.xyz", "--frobnicate"], "unexpected argument '--frobnicate'"),
        (&["delaunay", "a.xyz", "--threads", "0"], "invalid value '0'"),
        (&["delaunay", "a.xyz", "--check", "slow"], "invalid value 'slow'"),
        (&["delaunay", "a.xyz", "-o", "a.npy"], "a.npy: this format holds points"),
        (&["delaunay", "a.xyz", "-o", "mesh.foo"], "mesh.foo: unknown extension"),
        (&["generate", "chaos", "-o", "b.xyz"], "invalid value 'chaos'"),
        (&["generate", "grid", "-o", "b.vtu"], "b.vtu: this format holds a mesh"),
        (&["generate", "uniform", "4294967295", "-o", "b.xyz"], "invalid value '4294967295'"),
        (&["generate", "uniform", "268435457", "-o", "b.xyz"], "invalid value '268435457'"),
        (&["convert", "a.xyz", "b.vtu"], "a.xyz: points are no mesh"),
        (&["convert", "a.xyz", "b.off"], "b.off: this format is only read"),
        (&["delaunay", "a.xyz", "-o", "x.stl"], "x.stl: this format holds a surface or points"),
        (&["generate", "uniform", "-5", "-o", "b.xyz"], "invalid value '-5' for '[N]'"),
        (&["demo", "--out", "-"], "--out: stdout has no place for the page"),
    ];
    for (args, start) in cases {
        let run = ltbw(dir.path(), args);
        assert_eq!(run.code, 2, "{args:?}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
        assert!(run.error().starts_with(start), "{args:?}: {}", run.stderr);
        assert_eq!(run.stdout, "");
    }
    let bare = ltbw(dir.path(), &[]);
    assert_eq!(bare.code, 2);
    assert!(bare.stderr.contains("Usage: ltbw [OPTIONS] <COMMAND>"), "{}", bare.stderr);
    assert_eq!(names(dir.path()), ["a.xyz"]);
}

#[test]
fn help_teaches() {
    let dir = tempfile::tempdir().unwrap();
    for command in ["", "delaunay", "check", "convert", "generate", "demo"] {
        let args: Vec<&str> = [command, "--help"].into_iter().filter(|a| !a.is_empty()).collect();
        let run = ltbw(dir.path(), &args);
        assert_eq!(run.code, 0);
        assert!(run.stdout.contains("Exit codes:"), "{command}: {}", run.stdout);
        assert!(run.stdout.lines().all(|l| l.chars().count() <= 100), "{}", run.stdout);
    }
}

/// Data whose reader is gone were not delivered; help that is not read to its end is no error.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_an_error_of_data_alone() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(ltbw(dir.path(), &["generate", "uniform", "9", "-o", "a.xyz"]).code, 0);
    let cases: [(&[&str], i32); 6] = [
        (&["delaunay", "a.xyz", "--json", "-"], 6),
        (&["delaunay", "a.xyz"], 6),
        (&["convert", "a.xyz", "-", "--format", "csv"], 6),
        (&["generate", "uniform", "9", "-o", "-", "--format", "npy"], 6),
        (&["--version"], 0),
        (&["help", "mesh"], 0),
    ];
    for (args, code) in cases {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = program(dir.path(), args);
        command.stdout(writer).stderr(std::process::Stdio::piped());
        let run = Run::of(command.output().unwrap());
        assert_eq!(run.code, code, "{args:?}: {}", run.stderr);
        assert!(!run.stderr.contains("panic"), "{}", run.stderr);
        if code == 6 {
            assert_eq!(run.error(), "stdout: cannot write: Broken pipe (os error 32)");
        }
    }
}

/// A full disk behind stdout is an error like any other: data that nobody got is not "done".
#[cfg(target_os = "linux")]
#[test]
fn a_full_stdout_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let made = ltbw(dir.path(), &["generate", "uniform", "50", "-o", "a.xyz"]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    assert_eq!(ltbw(dir.path(), &["delaunay", "a.xyz", "-o", "a.vtu"]).code, 0);
    let cases: [&[&str]; 6] = [
        &["delaunay", "a.xyz", "--json", "-"],
        &["delaunay", "a.xyz"],
        &["check", "a.vtu", "--json", "-"],
        &["check", "a.vtu"],
        &["--version"],
        &["help", "check"],
    ];
    for args in cases {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let mut command = program(dir.path(), args);
        let output = command.stdout(full).stderr(std::process::Stdio::piped()).output().unwrap();
        let run = Run::of(output);
        assert_eq!(run.code, 6, "{args:?}: {}", run.stderr);
        assert_eq!(run.error(), "stdout: cannot write: No space left on device (os error 28)");
    }
}
