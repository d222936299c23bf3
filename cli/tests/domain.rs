//! `generate` and `check` of domains, and `convert` between their formats.

use crate::common::{self, Run, run};
use serde_json::Value;

fn json(run: &Run) -> Value {
    common::json(&run.stdout)
}

#[test]
fn the_model_problem_is_generated_and_sound() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), &["generate", "cube-octahedron", "-o", "m.poly"], 0);
    let checked = run(dir.path(), &["check", "m.poly", "--json", "-"], 0);
    let report = json(&checked);
    assert_eq!(report["schema"], "ltbw.domain/1");
    assert_eq!(report["passed"], true);
    assert_eq!(report["domain"]["volume_exact"], "47/48");
    assert_eq!(report["domain"]["facets"], 14);
    assert_eq!(report["lattice"]["moved"], 0);
    assert!(checked.stderr.contains("cells     2 bounded, 1 of them filled"), "{}", checked.stderr);
    // As surfaces, the orientation says where the hole is.
    for name in ["m.smesh", "m.off", "m.obj", "m.stl", "m.ply"] {
        run(dir.path(), &["convert", "m.poly", name], 0);
        let report = json(&run(dir.path(), &["check", name, "--json", "-"], 0));
        assert_eq!(report["domain"]["volume_exact"], "47/48", "{name}");
    }
    for kind in ["gear", "tee", "wedge", "spike", "schoenhardt", "two-material", "voxels"] {
        run(dir.path(), &["generate", kind, "-o", "k.poly"], 0);
        run(dir.path(), &["check", "k.poly"], 0);
    }
}

#[test]
fn bad_domains_are_told_and_end_with_1() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), &["generate", "cube-in-cube", "-o", "m.off"], 0);
    let text = std::fs::read_to_string(dir.path().join("m.off")).unwrap();
    // Without a lid.
    let open = text.replace("OFF\n16 12 0", "OFF\n16 11 0").replace("4 4 5 7 6\n", "");
    std::fs::write(dir.path().join("open.off"), open).unwrap();
    let told = run(dir.path(), &["check", "open.off"], 1);
    assert_eq!(told.error(), "open.off: defects: 4 domain.leak");
    assert!(
        told.stderr.contains("domain.leak: an edge with a facet on one side only: edge 4-5, facet"),
        "{}",
        told.stderr
    );
    let report = json(&run(dir.path(), &["check", "open.off", "--json", "-"], 1));
    assert_eq!(report["defect_counts"]["domain.leak"], 4);
    assert_eq!(report["defects"][0]["severity"], "error");
    assert_eq!(report["defects"][0]["at"][0].as_array().unwrap().len(), 3);
    // The inner cube moved through a wall.
    let crossing = text.replace("0.3125", "-0.5");
    std::fs::write(dir.path().join("cross.off"), crossing).unwrap();
    let told = run(dir.path(), &["check", "cross.off"], 1);
    assert!(told.error().contains("domain.intersection"), "{}", told.stderr);
}

#[test]
fn features_below_the_lattice_are_named() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), &["generate", "cube-in-cube", "-o", "m.poly"], 0);
    let text = std::fs::read_to_string(dir.path().join("m.poly")).unwrap();
    let thin = text.replace("0.6875\n", "0.999999999\n");
    assert_ne!(thin, text);
    std::fs::write(dir.path().join("thin.poly"), thin).unwrap();
    let report = json(&run(dir.path(), &["check", "thin.poly", "--json", "-"], 1));
    assert_eq!(report["defects"].as_array().unwrap().len(), 0);
    assert_eq!(report["snapped_defect_counts"]["domain.overlap"], 1);
    assert_eq!(report["lattice"]["moved"], 4);
    // Off the lattice, but sound on it: told, and refused on request.
    run(dir.path(), &["generate", "gear", "-o", "g.poly"], 0);
    let told = run(dir.path(), &["check", "g.poly"], 0);
    assert!(told.stderr.contains("vertices move, the farthest is vertex "), "{}", told.stderr);
    let refused = run(dir.path(), &["check", "g.poly", "--exact-input"], 3);
    assert!(
        refused.error().contains("are not on the lattice of step 1.4901161193847656e-8"),
        "{}",
        refused.stderr
    );
    run(dir.path(), &["check", "m.poly", "--exact-input"], 0);
}

#[test]
fn what_cannot_be_read_ends_with_3() {
    let dir = tempfile::tempdir().unwrap();
    let reject = |name: &str, content: &[u8]| {
        std::fs::write(dir.path().join(name), content).unwrap();
        run(dir.path(), &["check", name], 3).error().to_owned()
    };
    assert_eq!(reject("a.poly", b""), "a.poly: line 1: no header");
    assert_eq!(
        reject("a.off", b"\x00garbage"),
        "a.off: line 1: `?garbage` is no header of an OFF file"
    );
    assert_eq!(reject("a.obj", b"v 0 0 nan\n"), "a.obj: line 1: `nan` is not a finite number");
    assert_eq!(reject("b.obj", b"v 0 0 0\n"), "b.obj: the domain has no facets");
    assert_eq!(reject("a.stl", b"solid a\nendsolid a\n"), "a.stl: the domain has no facets");
    let huge =
        "OFF\n4 4 0\n0 0 0\n1e300 0 0\n0 1e300 0\n0 0 1e300\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    assert!(reject("h.off", huge.as_bytes()).starts_with("h.off: the largest coordinate is 1e300"));
    assert!(
        run(dir.path(), &["check", "none.stl"], 3).error().starts_with("none.stl: cannot read")
    );
}

#[test]
fn usage_of_generate_and_convert() {
    let dir = tempfile::tempdir().unwrap();
    let usage = |args: &[&str]| run(dir.path(), args, 2).error().to_owned();
    assert_eq!(
        usage(&["generate", "wedge", "--angle", "200", "-o", "w.poly"]),
        "a wedge has an angle above 0 and below 180 degrees, not 200"
    );
    assert!(
        usage(&["generate", "gear", "-o", "w.xyz"])
            .contains("this format holds points, but a domain is wanted")
    );
    assert!(
        usage(&["generate", "uniform", "-o", "w.poly"])
            .contains("this format holds a domain, but points are wanted")
    );
    run(dir.path(), &["generate", "gear", "-o", "g.poly"], 0);
    assert!(
        usage(&["convert", "g.poly", "g.vtu"]).contains("a domain is neither points nor a mesh")
    );
    run(dir.path(), &["generate", "uniform", "9", "-o", "p.xyz"], 0);
    assert!(usage(&["convert", "p.xyz", "p.poly"]).contains("points are no domain"));
    let lost = run(dir.path(), &["convert", "g.poly", "g.stl"], 0);
    assert!(lost.stderr.contains("markers of facets are not kept"), "{}", lost.stderr);
}
