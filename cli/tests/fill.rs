//! `--fill`: holes of a surface are closed where that is asked for, and the refusal says how.

use crate::common::ltbw;
use crate::readme::cylinder;

/// The cylinder without some of its triangles: the first of the wall, and the first of an end.
fn with_holes() -> String {
    let text = cylinder();
    let mut facets = text.split("facet normal").map(str::to_string).collect::<Vec<_>>();
    // The ends' triangles meet in a corner each; the wall's hole is elsewhere.
    facets.remove(4 * 20 + 1);
    facets.remove(3);
    // Cutting at the words leaves the line before in the part before.
    facets.join("facet normal")
}

#[test]
fn a_refusal_names_the_fill_that_helps_and_that_helps() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("open.stl"), with_holes()).unwrap();
    let refused = ltbw(dir.path(), &["mesh", "open.stl"]);
    assert_eq!(refused.code, 3, "{}", refused.stderr);
    assert!(refused.stderr.contains("note: --fill 3 closes its 2 holes"), "{}", refused.stderr);
    let args = ["mesh", "open.stl", "--fill", "3", "--json", "r.json", "-o", "m.vtu"];
    let run = ltbw(dir.path(), &args);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let note = "note: 2 holes of up to 3 edges closed by 2 triangles";
    assert!(run.stderr.contains(note), "{}", run.stderr);
    let report = std::fs::read_to_string(dir.path().join("r.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["refinement"]["repairs"]["filled_holes"], 2);
    assert_eq!(report["refinement"]["repairs"]["filling_facets"], 2);
    let same = ["check", "m.vtu", "--plc", "open.stl", "--fill", "3"];
    assert_eq!(ltbw(dir.path(), &same).code, 0);
    let strict = ltbw(dir.path(), &["mesh", "open.stl", "--fill", "3", "--strict"]);
    assert_eq!(strict.code, 3, "{}", strict.stderr);
}

#[test]
fn a_fill_has_limits() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("open.stl"), with_holes()).unwrap();
    for wrong in ["2", "257", "x", "-3"] {
        let run = ltbw(dir.path(), &["mesh", "open.stl", "--fill", wrong]);
        assert_eq!(run.code, 2, "{wrong}: {}", run.stderr);
    }
    let run = ltbw(dir.path(), &["mesh", "open.stl", "--fill", "3", "--exact-input"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
}
