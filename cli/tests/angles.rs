//! `check --min-dihedral`: counts, places and exit codes, of a mesh and of one of a domain.

use crate::common::{json, read_json, run};
use crate::schema::validate;
use std::path::Path;

/// Tetrahedron 0 has one angle of 30 degrees, and none of the others is below 70; tetrahedron 1,
/// at one of its faces, is low.
fn write(dir: &Path) {
    let node = "5 3\n0 0 0 0\n1 2 -2 -2\n2 2 -2 1\n3 1 -3 1\n4 1.75 -1.5 0\n";
    std::fs::write(dir.join("one.node"), node).unwrap();
    std::fs::write(dir.join("two.node"), node).unwrap();
    std::fs::write(dir.join("one.ele"), "1 4\n0 0 1 2 3\n").unwrap();
    std::fs::write(dir.join("two.ele"), "2 4\n0 0 1 2 3\n1 0 2 1 4\n").unwrap();
    let surface =
        "OFF\n4 4 0\n0 0 0\n2 -2 -2\n2 -2 1\n1 -3 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    std::fs::write(dir.join("one.off"), surface).unwrap();
}

#[test]
fn angles_below_a_bound_are_told_and_end_with_one() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write(dir);
    // 30 degrees are not below 30 degrees, whose squared cosine is the double 3/4.
    let equal = run(dir, &["check", "one.ele", "--min-dihedral", "30"], 0);
    let line = "angles    below 30 degrees: 0 tetrahedra; least 3.0000e1 in tetrahedron 0, around \
                [1.25, -1.75, 0.0]";
    assert!(equal.stderr.lines().any(|l| l == line), "{}", equal.stderr);
    assert!(equal.stderr.contains("below 1 degree: 0 tetrahedra, below 5 degrees: 0"));
    let above = run(dir, &["check", "one.ele", "--min-dihedral", "30.0000001"], 1);
    assert_eq!(
        above.error(),
        "one.ele: 1 tetrahedron has a dihedral angle below 30.0000001 degrees"
    );
    assert!(above.stderr.contains("no defect"), "{}", above.stderr);
    let both = run(dir, &["check", "two.ele", "--min-dihedral", "30.5", "--json", "-"], 1);
    assert!(both.error().starts_with("two.ele: 2 tetrahedra have"), "{}", both.stderr);
    let report = json(&both.stdout);
    validate(&report);
    let found = &report["below_dihedral"];
    assert_eq!((&found["count"], &found["bound"]), (&2.into(), &30.5.into()));
    assert_eq!(found["tets"], serde_json::json!([0, 1]));
    assert_eq!((&found["least"]["tet"], &report["passed"]), (&1.into(), &true.into()));
    assert!(found["least"]["value"].as_f64().unwrap() < 20.0, "{found}");
    // Nothing is told, and nothing wrong, without the bound.
    let without = run(dir, &["check", "two.ele", "--json", "-"], 0);
    assert!(json(&without.stdout).get("below_dihedral").is_none());
}

#[test]
fn angles_of_a_mesh_of_a_domain_are_held_to_the_bound() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write(dir);
    let check = ["check", "one.ele", "--plc", "one.off", "--json", "-", "--min-dihedral"];
    let equal = run(dir, &[&check[..], &["30"]].concat(), 0);
    assert!(equal.stderr.contains("below 30 degrees: 0 tetrahedra; least"), "{}", equal.stderr);
    let above = run(dir, &[&check[..], &["31"]].concat(), 1);
    assert_eq!(above.error(), "one.ele: 1 tetrahedron has a dihedral angle below 31 degrees");
    for (report, count) in [(json(&equal.stdout), 0), (json(&above.stdout), 1)] {
        validate(&report);
        assert_eq!(report["below_dihedral"]["count"], count);
        assert_eq!(report["verdict"], "passed");
    }
}

#[test]
fn bounds_that_are_none_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write(dir);
    for bound in ["0", "-5", "90.5", "NaN", "inf", "x"] {
        let refused = run(dir, &["check", "one.ele", "--min-dihedral", bound], 2);
        assert!(refused.stderr.contains("--min-dihedral"), "{bound}: {}", refused.stderr);
    }
    assert_eq!(run(dir, &["check", "one.ele", "--min-dihedral", "90"], 1).code, 1);
    let domain = run(dir, &["check", "one.off", "--min-dihedral", "12"], 2);
    assert_eq!(domain.error(), "--min-dihedral is about meshes");
}

#[test]
fn angles_before_slivers_and_after_are_told_where_they_are_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    run(dir, &["generate", "wedge", "--angle", "15", "-o", "d.poly"], 0);
    let mesh = ["mesh", "d.poly", "--max-volume", "1e-3", "--excused-share", "0.05", "-o", "m.vtu"];
    let plain = run(dir, &mesh, 0);
    assert!(!plain.stderr.contains("slivers   "), "{}", plain.stderr);
    let asked = ["--json", "r.json", "--page", "p.html", "--histogram", "h.svg"];
    let told = run(dir, &[&mesh[..], &asked].concat(), 0);
    assert_eq!(told.stdout, plain.stdout);
    let quality = &read_json(dir.join("r.json"))["quality"];
    let below = |name: &str| {
        let counts = quality[name]["counts"].as_array().unwrap();
        counts[..8].iter().map(|count| count.as_u64().unwrap()).sum::<u64>()
    };
    let (before, left) = (below("least_dihedral_before"), below("least_dihedral"));
    assert!(before > left, "{before} before, {left} left");
    let text = format!("below 8 degrees: {before} before slivers were split, {left} left");
    assert!(told.stderr.contains(&format!("slivers   {text}")), "{}", told.stderr);
    for file in ["p.html", "h.svg"] {
        let picture = std::fs::read_to_string(dir.join(file)).unwrap();
        assert!(picture.contains(&text), "{file}");
        assert_eq!(picture.matches("#cc3311").count(), 8, "{file}: bars below the bound are red");
    }
    // The same counts by workers, and of the mesh as it is read.
    run(dir, &[&mesh[..], &["--workers", "3", "--json", "w.json"]].concat(), 0);
    assert_eq!(&read_json(dir.join("w.json"))["quality"], quality);
    let found = json(&run(dir, &["check", "m.vtu", "--json", "-"], 0).stdout);
    assert_eq!(found["quality"]["least_dihedral"], quality["least_dihedral"]);
    validate(&found);
    let shown = run(dir, &["check", "m.vtu", "--plc", "d.poly", "--min-dihedral", "0.01"], 0);
    assert!(shown.stderr.contains("          by smallest angle: "), "{}", shown.stderr);
}
