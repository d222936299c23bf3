//! `ltbw mesh` and `ltbw check --plc`, from file to file.
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod common;

use common::{ltbw, names};
use std::path::Path;

fn model(dir: &Path) {
    assert_eq!(ltbw(dir, &["generate", "cube-octahedron", "-o", "model.poly"]).code, 0);
}

#[test]
fn the_model_problem_goes_from_domain_to_certified_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    model(dir);
    let run = ltbw(
        dir,
        &[
            "mesh",
            "model.poly",
            "--max-volume",
            "1e-3",
            "-o",
            "m.vtu",
            "-o",
            "m.ele",
            "--json",
            "r.json",
            "--histogram",
            "h.svg",
        ],
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.starts_with("ltbw.mesh/1 "), "{}", run.stdout);
    assert!(run.stderr.contains("volume 47/48"), "{}", run.stderr);
    let report = std::fs::read_to_string(dir.join("r.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["schema"], "ltbw.report/1");
    assert_eq!(report["command"], "mesh");
    assert_eq!(report["outcome"], "met");
    assert_eq!(report["certificate"]["volume"], "47/48");
    assert_eq!(report["certificate"]["passed"], true);
    let ratio = report["quality"]["radius_edge"]["largest"]["value"].as_f64().unwrap();
    assert!(ratio <= 2.0, "{ratio}");
    let svg = std::fs::read_to_string(dir.join("h.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    for mesh in ["m.vtu", "m.ele"] {
        let bounds = ["--radius-edge", "2", "--max-volume", "1e-3"];
        let run = ltbw(dir, &[&["check", mesh, "--plc", "model.poly"], &bounds[..]].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    let run = ltbw(dir, &["check", "m.vtu", "--plc", "model.poly", "--max-volume", "1e-5"]);
    assert_eq!(run.code, 1);
    assert!(run.stderr.contains("VolumeExceeded"), "{}", run.stderr);
    // It is no mesh of another domain.
    assert_eq!(ltbw(dir, &["generate", "cube-in-cube", "-o", "other.poly"]).code, 0);
    let run = ltbw(dir, &["check", "m.vtu", "--plc", "other.poly", "--json", "-"]);
    assert_eq!(run.code, 1);
    let found: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(found["schema"], "ltbw.conformity/1");
    assert_eq!(found["passed"], false);
}

#[test]
fn a_bound_not_met_is_exit_1_with_its_reason_and_the_mesh_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    assert_eq!(ltbw(dir, &["generate", "wedge", "--angle", "5", "-o", "w.poly"]).code, 0);
    let run = ltbw(dir, &["mesh", "w.poly", "--max-volume", "1e-3", "-o", "w.vtu"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.error().contains("small"), "{}", run.stderr);
    let run = ltbw(dir, &["check", "w.vtu", "--plc", "w.poly"]);
    assert_eq!(run.code, 0, "it conforms all the same: {}", run.stderr);
}

#[test]
fn what_cannot_be_meshed_is_said_in_a_line() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    model(dir);
    let run = ltbw(dir, &["mesh", "model.poly", "--radius-edge", "0.5", "-o", "m.vtu"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.error().contains("radius-edge"));
    let run = ltbw(dir, &["mesh", "model.poly", "--tetgen-switches", "pq1.4x"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    // A tetrahedron without its last facet is open.
    let off = "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n";
    std::fs::write(dir.join("open.off"), off).unwrap();
    let run = ltbw(dir, &["mesh", "open.off", "-o", "m.vtu"]);
    assert_eq!(run.code, 3, "{}", run.stderr);
    let run = ltbw(dir, &["mesh", "model.poly", "-o", "model.poly"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert_eq!(names(dir), ["model.poly", "open.off"], "nothing was written");
}
