//! `--repair`, `--write-defects`, frames, and what a refusal says of a surface.

use crate::common::{ltbw, names, run};
use serde_json::Value;
use std::path::Path;

/// A cube as `.off`, its lid in two halves with a seam `gap` away from the walls' upper edges.
fn seam(dir: &Path, name: &str, gap: f64) {
    let text = format!(
        "OFF\n10 7 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n\
         0.5 {gap} 1\n0.5 {} 1\n\
         4 0 2 3 1\n4 4 8 9 6\n4 8 5 7 9\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n",
        1.0 - gap
    );
    std::fs::write(dir.join(name), text).unwrap();
}

/// Two cubes as `.off`, the second shifted along x and y.
fn two(dir: &Path, name: &str, [x, y]: [f64; 2]) {
    let mut text = String::from("OFF\n16 12 0\n");
    for [dx, dy] in [[0.0, 0.0], [x, y]] {
        for i in 0..8 {
            let at = |k: i32, d: f64| f64::from(i >> k & 1) + d;
            text += &format!("{} {} {}\n", at(0, dx), at(1, dy), at(2, 0.0));
        }
    }
    for first in [0, 8] {
        for face in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            let [a, b, c, d] = face.map(|v: i32| v + first);
            text += &format!("4 {a} {b} {c} {d}\n");
        }
    }
    std::fs::write(dir.join(name), text).unwrap();
}

#[test]
fn a_seam_is_closed_on_request_and_the_mesh_is_certified() {
    let dir = tempfile::tempdir().unwrap();
    seam(dir.path(), "s.off", 1e-5);
    let refused = run(dir.path(), &["mesh", "s.off"], 3);
    assert!(refused.error().contains("; of 1 bodies: open: "), "{}", refused.stderr);
    let made =
        run(dir.path(), &["mesh", "s.off", "--repair", "1e-4", "-o", "s.vtu", "--json", "-"], 0);
    assert!(made.stderr.contains("2 vertices put into open edges near them"), "{}", made.stderr);
    let report: Value = serde_json::from_str(&made.stdout).unwrap();
    assert_eq!(report["refinement"]["repairs"]["seam_vertices"], 2);
    run(dir.path(), &["check", "s.vtu", "--plc", "s.off", "--repair", "1e-4"], 0);
    // Too little, and nothing to do: both are said.
    let left = run(dir.path(), &["mesh", "s.off", "--repair", "1e-9"], 3);
    assert!(left.stderr.contains("--repair 1e-9 leaves defects"), "{}", left.stderr);
    run(dir.path(), &["generate", "tee", "-o", "t.off"], 0);
    let idle = run(dir.path(), &["mesh", "t.off", "--repair", "1e-6"], 0);
    assert!(idle.stderr.contains("note: --repair 1e-6 changed nothing"), "{}", idle.stderr);
}

#[test]
fn tolerances_that_make_no_sense_are_usage_errors() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), &["generate", "tee", "-o", "t.off"], 0);
    let usage =
        |args: &[&str]| run(dir.path(), &[&["mesh", "t.off"], args].concat(), 2).error().to_owned();
    assert!(usage(&["--repair", "-1"]).starts_with("--repair -1: "));
    assert!(usage(&["--repair", "NaN"]).starts_with("--repair NaN: "));
    assert!(usage(&["--repair", "1"]).contains("the tolerance 1e0 is not between 0 and "));
    assert!(
        usage(&["--repair", "1e-4", "--exact-input"]).starts_with("--exact-input and --repair")
    );
    run(dir.path(), &["mesh", "t.off", "--repair", "0", "--exact-input"], 0);
}

#[test]
fn kinds_are_named_and_defects_can_be_looked_at() {
    let dir = tempfile::tempdir().unwrap();
    two(dir.path(), "cross.off", [0.5, 0.25]);
    let args = ["mesh", "cross.off", "--write-defects", "bad.ply", "-o", "m.vtu"];
    let refused = run(dir.path(), &args, 3);
    assert!(refused.error().contains("bodies that "), "{}", refused.stderr);
    assert!(refused.error().contains("in 2 bodies"), "{}", refused.stderr);
    assert!(refused.stderr.contains("facets with defects"), "{}", refused.stderr);
    assert_eq!(names(dir.path()), ["bad.ply", "cross.off"]);
    let told = run(dir.path(), &["check", "cross.off", "--json", "-"], 1);
    let report: Value = serde_json::from_str(&told.stdout).unwrap();
    let kinds: Vec<&str> =
        report["kinds"].as_array().unwrap().iter().map(|k| k["kind"].as_str().unwrap()).collect();
    assert!(kinds.iter().all(|k| k.starts_with("bodies-")), "{kinds:?}");
    assert_eq!(report["bodies"], 2);
    assert!(told.stderr.contains("kind      bodies that "), "{}", told.stderr);
    // The output is a surface that the program itself reads.
    let looked = ltbw(dir.path(), &["check", "bad.ply"]);
    assert!(looked.stderr.contains("domain    bad.ply: "), "{}", looked.stderr);
    // Without defects nothing is written, and that is said.
    run(dir.path(), &["generate", "tee", "-o", "t.off"], 0);
    let sound = run(dir.path(), &["check", "t.off", "--write-defects", "none.ply"], 0);
    assert!(sound.stderr.contains("none.ply was not written"), "{}", sound.stderr);
    let same = run(dir.path(), &["check", "t.off", "--write-defects", "t.off"], 2);
    assert!(same.error().contains("would overwrite the input"), "{}", same.stderr);
}

#[test]
fn joined_bodies_share_a_facet_and_check_says_what_mesh_repairs() {
    let dir = tempfile::tempdir().unwrap();
    two(dir.path(), "joined.off", [1.0, 0.0]);
    let made = run(dir.path(), &["mesh", "joined.off", "-o", "j.vtu", "--json", "-"], 0);
    assert!(made.stderr.contains("1 facet given once from either side"), "{}", made.stderr);
    let report: Value = serde_json::from_str(&made.stdout).unwrap();
    assert_eq!(report["certificate"]["volume"], "2");
    assert_eq!(report["refinement"]["repairs"]["inner_facets"], 1);
    run(dir.path(), &["check", "j.vtu", "--plc", "joined.off"], 0);
    let told = run(dir.path(), &["check", "joined.off"], 1);
    assert!(told.stderr.contains("kind      doubled"), "{}", told.stderr);
    assert!(told.stderr.contains("`ltbw mesh` repairs this on its way"), "{}", told.stderr);
}

#[test]
fn far_domains_get_a_frame_of_their_own() {
    let dir = tempfile::tempdir().unwrap();
    let cube = |d: f64| {
        let mut text = String::from("OFF\n8 6 0\n");
        for i in 0..8 {
            let at = |k: i32| f64::from(i >> k & 1) + d;
            text += &format!("{} {} {}\n", at(0), at(1), at(2));
        }
        text + "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n"
    };
    std::fs::write(dir.path().join("far.off"), cube(1000.0)).unwrap();
    let made = run(dir.path(), &["mesh", "far.off", "-o", "far.vtu"], 0);
    assert!(made.stderr.contains("coordinates are relative to [1000.5, 1000.5, 1000.5]"));
    run(dir.path(), &["check", "far.vtu", "--plc", "far.off"], 0);
    let own = run(dir.path(), &["mesh", "far.off", "--own-frame", "-o", "own.vtu"], 0);
    assert!(own.stderr.contains("11 bits are lost"), "{}", own.stderr);
    run(dir.path(), &["check", "own.vtu", "--plc", "far.off", "--own-frame"], 0);
    run(dir.path(), &["mesh", "far.off", "--own-frame", "--local-frame"], 2);
}

/// A `.poly` of unit cubes at distances along x, with a further vertex and a hole point.
fn cubes(dir: &Path, name: &str, distances: &[f64], [spare, hole]: [Option<[f64; 3]>; 2]) {
    let count = 8 * distances.len();
    let mut text = format!("{} 3 0 0\n", count + usize::from(spare.is_some()));
    for (n, distance) in distances.iter().enumerate() {
        for i in 0..8 {
            let at = |k: i32| f64::from(i >> k & 1);
            text += &format!("{} {} {} {}\n", 8 * n as i32 + i, at(0) + distance, at(1), at(2));
        }
    }
    spare.iter().for_each(|[x, y, z]| text += &format!("{count} {x} {y} {z}\n"));
    text += &format!("{} 0\n", 6 * distances.len());
    for first in (0..count).step_by(8) {
        for face in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            let [a, b, c, d] = face.map(|v: usize| v + first);
            text += &format!("1\n4 {a} {b} {c} {d}\n");
        }
    }
    text += &format!("{}\n", usize::from(hole.is_some()));
    hole.iter().for_each(|[x, y, z]| text += &format!("0 {x} {y} {z}\n"));
    std::fs::write(dir.join(name), text + "0\n").unwrap();
}

#[test]
fn check_says_what_becomes_of_spare_vertices() {
    let dir = tempfile::tempdir().unwrap();
    cubes(dir.path(), "in.poly", &[0.0], [Some([0.25, 0.25, 0.5]), None]);
    let told = run(dir.path(), &["check", "in.poly"], 1);
    assert!(
        told.stderr.contains("kept      1 vertex that nothing names, inside"),
        "{}",
        told.stderr
    );
    assert!(told.stderr.contains("`ltbw mesh` takes this as it is"), "{}", told.stderr);
    assert!(!told.stderr.contains("repair"), "{}", told.stderr);
    // So it does.
    run(dir.path(), &["mesh", "in.poly", "-o", "in.node"], 0);
    let points = std::fs::read_to_string(dir.path().join("in.node")).unwrap();
    assert!(points.contains("0.25 0.25 0.5"), "{points}");
    // Outside it is left out, which is a repair.
    cubes(dir.path(), "out.poly", &[0.0], [Some([0.25, 1.5, 0.5]), None]);
    let told = run(dir.path(), &["check", "out.poly"], 1);
    assert!(told.stderr.contains("repair    1 vertex left out"), "{}", told.stderr);
    assert!(told.stderr.contains("`ltbw mesh` repairs this on its way"), "{}", told.stderr);
    assert!(!told.stderr.contains("kept  "), "{}", told.stderr);
}

#[test]
fn moves_are_told_as_a_part_of_the_diagonal_that_the_input_has() {
    let dir = tempfile::tempdir().unwrap();
    cubes(dir.path(), "far.poly", &[1e12], [None; 2]);
    let told = run(dir.path(), &["check", "far.poly", "--own-frame"], 1);
    let line = told.stderr.lines().find(|l| l.starts_with("lattice ")).unwrap();
    let part = line.strip_suffix(" of the diagonal").and_then(|l| l.rsplit(' ').next()).unwrap();
    let part: f64 = part.parse().unwrap();
    // A step is 2^14: each vertex moves by at most half of that in each coordinate.
    assert!(part.is_finite() && part > 0.1 && part < 8192.0, "{line}");
}

#[test]
fn check_tells_what_mesh_refuses_and_leaves_out_though_it_is_no_defect() {
    let dir = tempfile::tempdir().unwrap();
    cubes(dir.path(), "hole.poly", &[0.0], [None, Some([0.5; 3])]);
    run(dir.path(), &["mesh", "hole.poly"], 3);
    let told = run(dir.path(), &["check", "hole.poly", "--json", "-"], 1);
    assert!(
        told.error().contains("hole.poly: there is nothing to mesh: all that"),
        "{}",
        told.stderr
    );
    let report: Value = serde_json::from_str(&told.stdout).unwrap();
    assert_eq!(report["passed"], false);
    assert_eq!(report["refused"], "domain.nothing-inside");
    // A box that is a hole beside one that is not: nothing is wrong, but six facets are no part.
    cubes(dir.path(), "beside.poly", &[0.0, 2.0], [None, Some([2.5, 0.5, 0.5])]);
    let left_out = "6 facets left out: nothing but exterior around (first: facet 6)";
    let made = run(dir.path(), &["mesh", "beside.poly"], 0);
    assert!(made.stderr.contains(&format!("note: {left_out}")), "{}", made.stderr);
    let told = run(dir.path(), &["check", "beside.poly", "--json", "-"], 0);
    assert!(told.stderr.contains(&format!("repair    {left_out}")), "{}", told.stderr);
    let report: Value = serde_json::from_str(&told.stdout).unwrap();
    assert_eq!([&report["passed"], &report["refused"]], [&Value::Bool(true), &Value::Null]);
}
