//! Obstacles for a newcomer: outputs that overwrite each other, folders that take no file, a
//! mesh of a domain taken for one of its points, numbers written in other ways. Others of the kind:
//! pipes in `streams.rs`, losses in `losses.rs`, the conformance kit in `vectors.rs`.

use crate::common::{ltbw, names, points_apart};

#[test]
fn no_output_replaces_another() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(ltbw(dir.path(), &["generate", "uniform", "50", "-o", "p.npy"]).code, 0);
    assert_eq!(ltbw(dir.path(), &["generate", "wedge", "-o", "d.poly"]).code, 0);
    let cases: [&[&str]; 11] = [
        &["delaunay", "p.npy", "-o", "a.vtu", "--json", "a.vtu"],
        &["delaunay", "p.npy", "-o", "a.vtu", "-o", "./a.vtu"],
        &["delaunay", "p.npy", "-o", "a.ele", "--json", "a.node"],
        &["delaunay", "p.npy", "--threads", "2", "--trace", "x", "--json", "x"],
        &["mesh", "d.poly", "--page", "x", "--histogram", "x"],
        &["mesh", "d.poly", "--page", "x", "--json", "x"],
        &["simulate", "--points", "100", "--json", "x", "--trace", "x"],
        &["mesh", "d.poly", "-o", "a.ele", "--json", "a.face"],
        &["mesh", "d.poly", "-o", "a.ele", "--page", "a.face"],
        &["check", "d.poly", "--json", "x.ply", "--write-defects", "x.ply"],
        &["check", "p.npy", "--plc", "d.poly", "--json", "x.ply", "--write-defects", "x.ply"],
    ];
    for args in cases {
        let run = ltbw(dir.path(), args);
        assert_eq!(run.code, 2, "{args:?}: {}", run.stderr);
        assert!(run.error().ends_with(": two outputs would be written there"), "{}", run.stderr);
        assert_eq!(run.stdout, "");
    }
    assert_eq!(names(dir.path()), ["d.poly", "p.npy"]);
    let run = ltbw(dir.path(), &["delaunay", "p.npy", "-o", "a.vtu", "--json", "a.json"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
}

/// Points of a domain in a `.node`, which a mesh of the same name would replace.
#[test]
fn points_of_a_domain_are_not_overwritten() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(ltbw(dir.path(), &["generate", "cube-in-cube", "-o", "d.poly"]).code, 0);
    // Where the points are in the `.poly` the mesh may have its name, also the second time.
    for _ in 0..2 {
        let run = ltbw(dir.path(), &["mesh", "d.poly", "-o", "d.ele"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    points_apart(dir.path());
    let node = std::fs::read_to_string(dir.path().join("e.node")).unwrap();
    let run = ltbw(dir.path(), &["mesh", "e.poly", "-o", "e.ele"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert_eq!(run.error(), "e.node: this would overwrite the input");
    assert_eq!(std::fs::read_to_string(dir.path().join("e.node")).unwrap(), node);
    assert_eq!(ltbw(dir.path(), &["mesh", "e.poly", "-o", "other.ele"]).code, 0);
}

/// No file can be made in `/proc`, whoever asks.
#[cfg(target_os = "linux")]
#[test]
fn outputs_are_tried_before_the_work() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(ltbw(dir.path(), &["generate", "uniform", "50", "-o", "p.npy"]).code, 0);
    for args in [
        &["delaunay", "p.npy", "-o", "/proc/a.vtu"][..],
        &["delaunay", "p.npy", "--json", "/proc/a.json"],
        &["demo", "--out", "/proc/a.vtu"],
        &["convert", "missing.npy", "/proc/a.xyz"],
        &["mesh", "missing.poly", "-o", "/proc/a.vtu"],
        &["mesh", "missing.poly", "--page", "/proc/a.html"],
        &["simulate", "--trace", "/proc/a.json"],
    ] {
        let run = ltbw(dir.path(), args);
        assert_eq!(run.code, 6, "{args:?}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "before the work: {}", run.stderr);
    }
    assert_eq!(names(dir.path()), ["p.npy"]);
}

#[test]
fn a_mesh_of_a_domain_is_recognised() {
    let dir = tempfile::tempdir().unwrap();
    for args in [&["generate", "tee", "-o", "d.poly"][..], &["mesh", "d.poly", "-o", "d.vtu"]] {
        assert_eq!(ltbw(dir.path(), args).code, 0);
    }
    let run = ltbw(dir.path(), &["check", "d.vtu"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("not convex"), "{}", run.stderr);
    let run = ltbw(dir.path(), &["check", "d.vtu", "--delaunay"]);
    assert_eq!(run.code, 1);
    assert!(run.stderr.contains("--plc DOMAIN checks it against the domain"), "{}", run.stderr);
    assert_eq!(ltbw(dir.path(), &["check", "d.vtu", "--plc", "d.poly"]).code, 0);
}

#[test]
fn counts_may_be_written_with_an_exponent_and_bounds_may_be_negative_to_be_refused() {
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["generate", "uniform", "1e3", "-o", "p.npy"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("1000 points"), "{}", run.stderr);
    for count in ["1.5", "1e300", "-1", "many", "1e9"] {
        let run = ltbw(dir.path(), &["generate", "uniform", count, "-o", "q.npy"]);
        assert_eq!(run.code, 2, "{count}: {}", run.stderr);
    }
    assert_eq!(ltbw(dir.path(), &["generate", "wedge", "-o", "d.poly"]).code, 0);
    for bound in ["--max-volume", "--radius-edge", "--size", "--max-edge", "--growth"] {
        let run = ltbw(dir.path(), &["mesh", "d.poly", bound, "-1"]);
        assert_eq!(run.code, 2, "{bound}: {}", run.stderr);
        assert!(run.error().contains("-1") && !run.error().contains("unexpected argument"));
    }
}

#[test]
fn progress_can_be_read_by_programs_and_silenced() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(ltbw(dir.path(), &["generate", "uniform", "20000", "-o", "p.npy"]).code, 0);
    for threads in [&[][..], &["--threads", "2"]] {
        let args = ["delaunay", "p.npy", "-o", "m.vtu", "--progress", "json"];
        let run = ltbw(dir.path(), &[&args[..], threads].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        let lines = run.stderr.lines().filter(|line| line.starts_with('{'));
        let lines: Vec<serde_json::Value> =
            lines.map(|line| serde_json::from_str(line).unwrap()).collect();
        let mut phases: Vec<&str> = lines.iter().map(|l| l["phase"].as_str().unwrap()).collect();
        phases.dedup();
        let gather: &[&str] = if threads.is_empty() { &[] } else { &["gather"] };
        let end = ["hash", "check", "write"];
        assert_eq!(phases, [&["read", "order", "insert"], gather, &end].concat());
        let last = lines.iter().rfind(|l| l["phase"] == "insert").unwrap();
        assert_eq!((&last["done"], &last["total"]), (&20_000.into(), &20_000.into()));
    }
    let quiet = ltbw(dir.path(), &["delaunay", "p.npy", "-o", "m.vtu", "--quiet"]);
    assert_eq!((quiet.code, quiet.stderr.as_str()), (0, ""));
    assert!(quiet.stdout.starts_with("ltbw.mesh/1 "));
    // Errors and outcomes are told all the same.
    let wrong = ltbw(dir.path(), &["-q", "delaunay", "none.npy"]);
    assert_eq!((wrong.code, wrong.stderr.lines().count()), (3, 1));
}

#[test]
fn shells_and_manuals_know_every_command() {
    let dir = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        let run = ltbw(dir.path(), &["completions", shell]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        for word in ["delaunay", "simulate", "max-volume"] {
            assert!(run.stdout.contains(word), "{shell}: {word}");
        }
    }
    let run = ltbw(dir.path(), &["man", "."]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let pages = names(dir.path());
    for command in ["ltbw.1", "ltbw-mesh.1", "ltbw-check.1", "ltbw-vectors.1"] {
        assert!(pages.iter().any(|page| page == command), "{pages:?}");
    }
    let page = std::fs::read_to_string(dir.path().join("ltbw-mesh.1")).unwrap();
    assert!(page.starts_with(".ie") && page.contains("max\\-volume"), "{page}");
    assert_eq!(ltbw(dir.path(), &["man", "missing"]).code, 6);
}

/// The lines of `--progress json`.
fn progress(dir: &std::path::Path, args: &[&str]) -> Vec<serde_json::Value> {
    let run = ltbw(dir, &[args, &["--progress", "json"]].concat());
    assert_eq!(run.code, 0, "{args:?}: {}", run.stderr);
    let lines = run.stderr.lines().filter(|line| line.starts_with('{'));
    lines.map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// A total that nobody knows is none, not 0, of which 97,928 points were done.
#[test]
fn progress_never_exceeds_its_total() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(ltbw(dir.path(), &["generate", "tee", "-o", "d.poly"]).code, 0);
    let lines = progress(dir.path(), &["mesh", "d.poly", "--max-volume", "1e-3"]);
    assert!(lines.iter().any(|l| l["phase"] == "refine" && l["done"].as_u64() > Some(0)));
    for line in &lines {
        if let Some(total) = line["total"].as_u64() {
            assert!(total > 0 && line["done"].as_u64() <= Some(total), "{line}");
        }
    }
}

#[test]
fn every_long_command_tells_its_phases() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    assert_eq!(ltbw(dir, &["generate", "uniform", "300", "-o", "p.npy"]).code, 0);
    let commands: [(&[&str], &[&str]); 4] = [
        (
            &["delaunay", "p.npy", "--threads", "2", "-o", "m.vtu"],
            &["read", "insert", "hash", "check", "write"],
        ),
        (&["check", "m.vtu"], &["read", "check"]),
        (&["convert", "m.vtu", "m.msh"], &["convert"]),
        (&["simulate", "--points", "300"], &["simulate"]),
    ];
    for (args, wanted) in commands {
        let lines = progress(dir, args);
        for phase in wanted {
            assert!(lines.iter().any(|line| line["phase"] == *phase), "{args:?}: {phase}");
        }
    }
}

#[test]
fn a_misspelt_option_is_answered_with_the_right_one_and_the_right_help() {
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["delaunay", "p.npy", "--thread", "2"]);
    assert_eq!(run.code, 2);
    let error = run.error();
    assert!(error.contains("--threads") && error.contains("ltbw delaunay --help"), "{error}");
}

#[test]
fn short_times_have_digits_and_help_tells_the_codes_of_its_command() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(ltbw(dir.path(), &["generate", "uniform", "100", "-o", "p.npy"]).code, 0);
    let run = ltbw(dir.path(), &["delaunay", "p.npy"]);
    let seconds = run.stderr.lines().find(|line| line.starts_with("seconds ")).unwrap();
    let insert = seconds.split(", ").find_map(|part| part.strip_prefix("insert ")).unwrap();
    assert!(insert.parse::<f64>().unwrap() > 0.0, "{seconds}");
    let help = ltbw(dir.path(), &["convert", "--help"]).stdout;
    // Neither checks a convert its own output, nor finds it defects.
    assert!(help.contains("\n  6  ") && !help.contains("\n  5  "), "{help}");
    let help = ltbw(dir.path(), &["mesh", "--help"]).stdout;
    let (_, size) = help.split_once("--size <H>").unwrap();
    assert!(size.trim_start().starts_with("Usual edge length"), "{size}");
}

/// Files that newcomers bring: each is read, or refused by a line that names what is.
#[test]
fn files_of_newcomers_are_read_or_the_right_ones_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    std::fs::write(dir.join("p.txt"), "# x y z\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n").unwrap();
    assert_eq!(ltbw(dir, &["delaunay", "p.txt", "-o", "m.vtk"]).code, 0);
    assert_eq!(ltbw(dir, &["check", "m.vtk"]).code, 0);
    // A compressor in the header of a file that holds text alone.
    assert_eq!(ltbw(dir, &["convert", "m.vtk", "m.vtu", "--ascii"]).code, 0);
    let text = std::fs::read_to_string(dir.join("m.vtu")).unwrap();
    for name in ["LZ4", "LZMA", "ZLib"] {
        let header = format!("<VTKFile compressor=\"vtk{name}DataCompressor\"");
        std::fs::write(dir.join("c.vtu"), text.replacen("<VTKFile", &header, 1)).unwrap();
        let run = ltbw(dir, &["check", "c.vtu"]);
        assert_eq!(run.code, 0, "{name}: {}", run.stderr);
    }
    for name in ["a.vtp", "a.meshb", "a.inp"] {
        std::fs::write(dir.join(name), "").unwrap();
        let run = ltbw(dir, &["check", name]);
        assert_eq!(run.code, 3);
        assert!(run.error().contains("unknown extension; points: .npy"), "{}", run.stderr);
    }
    std::fs::write(dir.join("old.msh"), "$MeshFormat\n4 0 8\n$EndMeshFormat\n").unwrap();
    let run = ltbw(dir, &["check", "old.msh"]);
    assert_eq!(run.code, 3);
    assert!(run.error().ends_with("version 4; 4.1 and 2.2 are read"), "{}", run.stderr);
}
