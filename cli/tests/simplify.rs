//! `--simplify`, and what is said of surfaces of needles.

use crate::common::{ltbw, run};
use ltbw::io;
use ltbw_generate::surfaces::globe;
use serde_json::Value;

fn report(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_surface_of_needles_is_named_with_what_helps_and_that_helps() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    // Fans of a hundred needles at both poles.
    io::write_domain(dir.join("g.off"), &globe(9, 100, 0.0, 1)).unwrap();
    let told = ltbw(dir, &["mesh", "g.off", "--max-points", "10", "--check", "off"]);
    let line = told.stderr.lines().find(|line| line.contains("below 5 degrees")).unwrap();
    assert!(line.starts_with("note: 1400 triangles, "), "{line}");
    let (_, help) = line.split_once("`--simplify ").unwrap();
    let (tolerance, rest) = help.split_once("` would leave ").unwrap();
    let left: u64 = rest.split(';').next().unwrap().parse().unwrap();
    assert!(left < 700, "{line}");
    let args = ["mesh", "g.off", "--simplify", tolerance, "-o", "g.vtu", "--json", "-"];
    let helped = ltbw(dir, &args);
    // At the poles there are angles below 14.5 degrees, still.
    assert!(helped.code < 2, "{}", helped.stderr);
    assert!(!helped.stderr.contains("below 5 degrees"), "{}", helped.stderr);
    let simplified = &report(&helped.stdout)["refinement"]["simplified"];
    let [before, after] =
        ["triangles_before", "triangles"].map(|n| simplified[n].as_u64().unwrap());
    assert_eq!([before, after], [1400, left]);
    let bound = ["from_before", "from_after"].map(|n| simplified[n].as_f64().unwrap());
    let tolerance_number: f64 = tolerance.parse().unwrap();
    assert!(bound.iter().all(|&far| far > 0.0 && far <= tolerance_number), "{bound:?}");
    assert!(helped.stderr.contains("simple    1400 triangles became "), "{}", helped.stderr);
    // The mesh is one of the simplified surface.
    run(dir, &["check", "g.vtu", "--plc", "g.off", "--simplify", tolerance], 0);
    run(dir, &["check", "g.vtu", "--plc", "g.off"], 1);
}

#[test]
fn tolerances_of_simplification_that_make_no_sense_are_usage_errors() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), &["generate", "tee", "-o", "t.off"], 0);
    let usage = |value: &str| {
        run(dir.path(), &["mesh", "t.off", "--simplify", value], 2).error().to_owned()
    };
    assert!(usage("-1").starts_with("--simplify -1: "));
    assert!(usage("NaN").starts_with("--simplify NaN: "));
    assert!(usage("inf").starts_with("--simplify inf: "));
    assert!(usage("1").contains("the tolerance 1e0 of simplification is not between 0 and "));
    let idle = run(dir.path(), &["mesh", "t.off", "--simplify", "0", "--json", "-"], 0);
    assert!(report(&idle.stdout)["refinement"]["simplified"].is_null());
}
