//! All JSON that the program writes names its schema and is as `docs/schema` has it: nothing is
//! missing, and no field is written that its schema does not have.

use crate::common::ltbw;
use crate::schema::{all, faults, validate};
use serde_json::{Value, json};
use std::path::Path;

/// Runs the program, which may find defects, and validates the JSON that it wrote to `file`.
fn written(dir: &Path, args: &[&str], file: &str) -> Value {
    let run = ltbw(dir, args);
    assert!(run.code == 0 || run.code == 1, "{args:?}: {}", run.stderr);
    let text = std::fs::read_to_string(dir.join(file)).unwrap();
    let value: Value = serde_json::from_str(&text).unwrap();
    validate(&value);
    value
}

fn generate(dir: &Path, words: &str) {
    let words: Vec<&str> = std::iter::once("generate").chain(words.split(' ')).collect();
    let run = ltbw(dir, &words);
    assert_eq!(run.code, 0, "{}", run.stderr);
}

#[test]
fn schemas_are_named_after_what_they_describe() {
    let schemas = all();
    let names: Vec<&str> = schemas.iter().map(|s| s["title"].as_str().unwrap()).collect();
    let expected = ["cert", "conformity", "domain", "progress", "report", "simulation", "trace"];
    assert_eq!(names, expected.map(|name| format!("ltbw.{name}/1")));
}

#[test]
fn reports_of_points_are_as_their_schema_has_them() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    generate(dir, "uniform 3000 -o p.npy");
    let one = written(dir, &["delaunay", "p.npy", "-o", "m.vtu", "--json", "r.json"], "r.json");
    assert_eq!((&one["schema"], &one["workers"]), (&"ltbw.report/1".into(), &json!([])));
    assert_eq!(one["certificate"]["schema"], "ltbw.cert/1");
    let threads = ["delaunay", "p.npy", "--threads", "2", "--check", "full"];
    let two = [&threads[..], &["--json", "t.json", "--trace", "trace.json"]].concat();
    assert!(written(dir, &two, "t.json")["parallel"].is_object());
    let trace: Value =
        serde_json::from_str(&std::fs::read_to_string(dir.join("trace.json")).unwrap()).unwrap();
    assert_eq!(trace["otherData"]["schema"], "ltbw.trace/1");
    validate(&trace);
    // The same points four times; a defect has its place in the certificate.
    std::fs::write(dir.join("q.xyz"), "0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 1\n").unwrap();
    let off = written(
        dir,
        &["delaunay", "q.xyz", "-o", "q.ele", "--check", "off", "--json", "r.json"],
        "r.json",
    );
    assert_eq!((&off["certificate"], &off["input"]["duplicates"]), (&Value::Null, &json!(1)));
    written(dir, &["check", "m.vtu", "--json", "c.json"], "c.json");
    let nodes = "5 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 0 0 -1\n";
    std::fs::write(dir.join("bad.node"), nodes).unwrap();
    std::fs::write(dir.join("bad.ele"), "2 4 0\n0 0 1 2 3\n1 0 1 2 4\n").unwrap();
    let bad = written(dir, &["check", "bad.ele", "--json", "c.json"], "c.json");
    assert!(!bad["defects"].as_array().unwrap().is_empty(), "{bad}");
}

#[test]
fn reports_of_domains_are_as_their_schema_has_them() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    generate(dir, "wedge --angle 5 -o d.poly");
    let args = ["mesh", "d.poly", "--max-volume", "1e-3", "-o", "d.vtu"];
    let report = written(dir, &[&args[..], &["--json", "r.json"]].concat(), "r.json");
    assert_eq!(report["certificate"]["schema"], "ltbw.conformity/1");
    assert!(report["quality"].is_object() && report["refinement"].is_object());
    let refinement = &report["refinement"];
    let tets = |value: &Value| value["tets"].as_u64().unwrap();
    let at = ["corners", "segments", "elsewhere"].map(|name| &refinement["excused_at"][name]);
    let all = refinement["excused_at"]["by_reason"].as_array().unwrap();
    assert_eq!(at.iter().map(|sum| tets(sum)).sum::<u64>(), refinement["excused"]);
    assert_eq!(all.iter().map(tets).sum::<u64>(), refinement["excused"]);
    let volume: f64 = at.iter().filter_map(|sum| sum["volume"].as_f64()).sum();
    assert!(volume > 0.0, "{report}");
    let share = &refinement["excused_at"]["share"];
    assert!(share.as_f64().is_some_and(|share| 0.0 < share && share <= 1.0), "{report}");
    let before = report["quality"]["least_dihedral_before"]["counts"].as_array().unwrap();
    let after = report["quality"]["least_dihedral"]["counts"].as_array().unwrap();
    let sum = |counts: &[Value]| counts.iter().filter_map(Value::as_u64).sum::<u64>();
    assert_eq!(sum(after), report["mesh"]["tets"]);
    assert!(sum(&before[..8]) > sum(&after[..8]), "{report}");
    // Without slivers there is no before; a mesh that is gone on with has a report, too.
    std::fs::write(dir.join("marks.txt"), "0\n").unwrap();
    let refine = ["refine", "d.vtu", "--mark", "marks.txt", "--min-dihedral", "0"];
    let finer = written(dir, &[&refine[..], &["--json", "r.json"]].concat(), "r.json");
    assert_eq!(finer["command"], "refine");
    assert_eq!(finer["quality"]["least_dihedral_before"], Value::Null);
    let plc = ["check", "d.vtu", "--plc", "d.poly", "--max-volume", "1e-9", "--json", "c.json"];
    let certificate = written(dir, &plc, "c.json");
    assert!(!certificate["breaches"].as_array().unwrap().is_empty());
    written(dir, &["check", "d.poly", "--json", "d.json"], "d.json");
    // A vertex too many, a tetrahedron without a side, and coordinates off the lattice.
    let off = "OFF\n5 3 0\n0 0 0\n0.1 0 0\n0 0.3 0\n0 0 0.7\n9 9 9\n3 0 1 2\n3 0 1 3\n3 1 2 3\n";
    std::fs::write(dir.join("open.off"), off).unwrap();
    let open = written(dir, &["check", "open.off", "--json", "d.json"], "d.json");
    assert_eq!(open["passed"], false);
    assert!(!open["defects"].as_array().unwrap().is_empty() && !open["kinds"][0].is_null());
}

#[test]
fn the_timeline_of_rounds_is_as_its_schema_has_it() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    generate(dir, "cube-octahedron -o d.poly");
    let args = ["mesh", "d.poly", "--max-volume", "1e-4", "--trace", "t.json"];
    let report = [&args[..], &["--json", "r.json"]].concat();
    let report = written(dir, &report, "r.json");
    let trace: Value =
        serde_json::from_str(&std::fs::read_to_string(dir.join("t.json")).unwrap()).unwrap();
    validate(&trace);
    let events = trace["traceEvents"].as_array().unwrap();
    let inserted = events.iter().filter(|e| e["name"].as_str().unwrap().starts_with("insert"));
    let points = |e: &Value| e["args"]["points"].as_u64().unwrap();
    let all: Vec<u64> = inserted.map(points).collect();
    let rounds = &report["refinement"]["rounds"];
    assert_eq!(all.iter().filter(|&&n| n > 0).count() as u64, rounds["rounds"].as_u64().unwrap());
    assert_eq!(all.iter().sum::<u64>(), rounds["points"].as_u64().unwrap());
    let ends: Vec<f64> = events[2..].iter().map(|e| e["ts"].as_f64().unwrap()).collect();
    assert!(ends.is_sorted(), "{ends:?}");
}

#[test]
fn reports_of_simulations_and_lines_of_progress_are_as_their_schemas_have_them() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let args = ["simulate", "--points", "600", "--processors", "3", "--slow", "2"];
    let report = written(dir, &[&args[..], &["--json", "s.json"]].concat(), "s.json");
    assert_eq!(report["schema"], "ltbw.simulation/1");
    generate(dir, "cube-octahedron -o d.poly");
    let rounds =
        "simulate --domain d.poly --max-volume 2e-3 --start 50 --processors 3 --json r.json";
    let rounds: Vec<&str> = rounds.split(' ').collect();
    assert_eq!(written(dir, &rounds, "r.json")["input"]["domain"], "d.poly");
    generate(dir, "uniform 2000 -o p.npy");
    for args in [
        &["mesh", "d.poly", "--max-volume", "1e-3", "-o", "d.vtu"][..],
        &["delaunay", "p.npy", "-o", "m.vtu"],
        &["check", "m.vtu"],
        &["convert", "m.vtu", "m.msh"],
        &["check", "d.vtu", "--plc", "d.poly"],
        &args,
    ] {
        let run = ltbw(dir, &[args, &["--progress", "json"]].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        let lines: Vec<&str> = run.stderr.lines().filter(|line| line.starts_with('{')).collect();
        assert!(!lines.is_empty(), "{args:?}");
        lines.iter().for_each(|line| validate(&serde_json::from_str(line).unwrap()));
        // Quiet means no words for people: a program reads the lines.
        let run = ltbw(dir, &[args, &["--progress", "json", "-q"]].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(!run.stderr.is_empty() && run.stderr.lines().all(|line| line.starts_with('{')));
    }
    let run = ltbw(dir, &["delaunay", "no.npy", "--progress", "json", "-q"]);
    assert_eq!(
        (run.code, run.error()),
        (3, "no.npy: cannot read: No such file or directory (os error 2)")
    );
}

#[test]
fn what_a_schema_does_not_have_is_found() {
    let good = json!({ "schema": "ltbw.progress/1", "phase": "read", "done": 1, "total": null });
    assert_eq!(faults(&good), Vec::<String>::new());
    for (field, wrong) in
        [("done", json!(-1)), ("done", json!("1")), ("phase", json!("rest")), ("other", json!(1))]
    {
        let mut bad = good.clone();
        bad[field] = wrong;
        assert_eq!(faults(&bad).len(), 1, "{bad}");
    }
    let mut short = good;
    short.as_object_mut().unwrap().remove("total");
    assert_eq!(faults(&short).len(), 1);
    assert_eq!(faults(&json!({ "schema": "ltbw.nothing/1" })).len(), 1);
}
