//! Ctrl-C in each stage of the work: the exit code, the last line, and the files that are there.
#![cfg(unix)]

use crate::common::{Run, json, names, program, read_json, run};
use ltbw::io;
use ltbw_generate::surfaces::{globe, single};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

fn interrupt(child: &Child) {
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.unwrap().success());
}

/// A run that is interrupted once its progress says that a stage was begun, or, if `counted`, that
/// some of its points are done; and the stages that it came to.
fn interrupted(dir: &Path, args: &[&str], stage: &str, counted: bool) -> (Run, Vec<String>) {
    let mut command = program(dir, &[&["--progress", "json"], args].concat());
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let (mut stderr, mut stages, mut told) = (String::new(), Vec::new(), false);
    for line in BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap) {
        if !line.starts_with('{') {
            stderr += &(line + "\n");
            continue;
        }
        let progress = json(&line);
        let name = progress["phase"].as_str().unwrap().to_owned();
        if !told && name == stage && (!counted || progress["done"].as_u64() > Some(0)) {
            interrupt(&child);
            told = true;
        }
        stages.push(name);
    }
    assert!(told, "{stage}: {stages:?}");
    (Run { code: child.wait().unwrap().code().unwrap(), stdout: String::new(), stderr }, stages)
}

/// Work that would go on for minutes, up to where there is a mesh to keep, and with one.
fn stops(inputs: &[String], dir: &Path, args: &[&str], early: [&str; 2], late: &str) {
    let output = args.last().unwrap();
    let mut nothing = 0;
    for stage in early {
        let (run, stages) = interrupted(dir, args, stage, false);
        assert_eq!(run.code, 4, "{stage}: {}", run.stderr);
        // The signal may come a little late.
        let kept = !run.stderr.contains("ltbw: cancelled; nothing was written");
        assert!(!kept || stages.iter().any(|name| name == late), "{stages:?} {}", run.stderr);
        if kept {
            let _ = std::fs::remove_file(dir.join(output));
        }
        nothing += usize::from(!kept);
        assert_eq!(names(dir), inputs, "{stage}: {}", run.stderr);
    }
    assert!(nothing > 0, "no signal came in time");
    let (stopped, stages) = interrupted(dir, args, late, true);
    assert_eq!(stopped.code, 4, "{}", stopped.stderr);
    assert!(!stages.contains(&"check".to_owned()), "{stages:?}");
    assert_eq!(names(dir).len(), inputs.len() + 1, "{:?}", names(dir));
    run(dir, &["check", output], 0);
}

#[test]
fn refinement_ends_at_once_before_there_is_a_mesh_and_keeps_it_afterwards() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    io::write_domain(dir.join("s.stl"), &single(globe(100, 100, 0.0, 1))).unwrap();
    let args = ["mesh", "s.stl", "--max-volume", "1e-9", "-o", "t.vtu"];
    stops(&names(dir), dir, &args, ["prepare", "recover"], "refine");
}

#[test]
fn insertion_ends_at_once_before_there_is_a_mesh_and_keeps_it_afterwards() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    run(dir, &["generate", "uniform", "3000000", "-o", "p.npy"], 0);
    let args = ["delaunay", "p.npy", "-o", "t.vtu"];
    stops(&names(dir), dir, &args, ["read", "order"], "insert");
    // The report is of the mesh so far.
    let args = ["delaunay", "p.npy", "--json", "r.json"];
    let (stopped, _) = interrupted(dir, &args, "insert", true);
    let report = read_json(dir.join("r.json"));
    assert_eq!((stopped.code, &report["outcome"]), (4, &"cancelled".into()));
    assert!(report["certificate"].is_null() && !stopped.stderr.contains("checked   "));
    let meshed = report["mesh"]["vertices"].as_u64().unwrap();
    assert!(0 < meshed && meshed < 3_000_000, "{meshed}");
}

/// After the last insertion Ctrl-C changes nothing: the mesh is complete, is checked, and the
/// words, the report and the exit code all say so.
#[test]
fn ctrl_c_after_the_insertion_finishes_a_complete_mesh() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), &["generate", "uniform", "300000", "-o", "p.npy"], 0);
    let args = ["delaunay", "p.npy", "--json", "r.json", "--check", "full", "--threads", "1"];
    let mut child =
        program(dir.path(), &args).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("mesh  ")), "the mesh is not announced");
    interrupt(&child);
    let rest: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{rest:?}");
    let says = |start: &str| rest.iter().any(|line| line.starts_with(start));
    assert!(says("all points are meshed; finishing"), "{rest:?}");
    assert!(says("checked   ") && !says("ltbw: "), "{rest:?}");
    let report = read_json(dir.path().join("r.json"));
    assert_eq!(report["outcome"], "complete");
    assert_eq!(report["certificate"]["passed"], true);
}
