//! `ltbw refine`, and points given to `ltbw mesh`.

use crate::common::{read_json, run};
use std::path::Path;

fn hash(stdout: &str) -> String {
    stdout.trim().to_owned()
}

fn model(dir: &Path) -> String {
    run(dir, &["generate", "cube-octahedron", "-o", "d.poly"], 0);
    let outputs = ["-o", "m.vtu", "-o", "m.msh", "-o", "m.ele", "-o", "m.mesh"];
    let args = [&["mesh", "d.poly", "--max-volume", "1e-2"][..], &outputs].concat();
    hash(&run(dir, &args, 0).stdout)
}

#[test]
fn a_mesh_is_gone_on_with_from_every_format() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let before = model(dir);
    let mut finer = Vec::new();
    for mesh in ["m.vtu", "m.msh", "m.ele", "m.mesh"] {
        let same = run(dir, &["refine", mesh, "--max-volume", "1e-2"], 0);
        assert_eq!(hash(&same.stdout), before, "{mesh}");
        let args = ["refine", mesh, "--max-volume", "3e-3", "-o", "f.vtu", "--json", "r.json"];
        finer.push(hash(&run(dir, &args, 0).stdout));
        run(dir, &["check", "f.vtu", "--plc", "d.poly", "--max-volume", "3e-3"], 0);
    }
    assert!(finer.iter().all(|other| *other == finer[0] && *other != before), "{finer:?}");
    let report = read_json(dir.join("r.json"));
    assert_eq!((&report["command"], &report["outcome"]), (&"refine".into(), &"met".into()));
    assert_eq!(report["certificate"]["passed"], true);
    // With its domain, by workers.
    let domain = ["refine", "m.vtu", "--plc", "d.poly", "--max-volume", "3e-3"];
    let crew = [&domain[..], &["--workers", "3"]].concat();
    let [one, crew] = [&domain[..], &crew].map(|args| hash(&run(dir, args, 0).stdout));
    assert_eq!(one, crew);
    // The markers of the boundary are kept: half the volume of marked tetrahedra.
    std::fs::write(dir.join("marks.txt"), "0 # the first\n5\n").unwrap();
    let args = ["refine", "m.vtu", "--mark", "marks.txt", "-o", "k.vtu"];
    assert_ne!(hash(&run(dir, &args, 0).stdout), before);
    run(dir, &["check", "k.vtu", "--plc", "d.poly"], 0);
}

#[test]
fn what_is_no_mesh_or_no_size_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    model(dir);
    for (marks, told) in [("", "names no tetrahedron"), ("999999", "no tetrahedron 999999")] {
        std::fs::write(dir.join("marks.txt"), marks).unwrap();
        let refused = run(dir, &["refine", "m.vtu", "--mark", "marks.txt"], 2);
        assert!(refused.error().contains(told), "{}", refused.stderr);
    }
    std::fs::write(dir.join("s.mtr"), "1 1\n0.1\n").unwrap();
    let refused = run(dir, &["refine", "m.vtu", "--sizes", "s.mtr"], 2);
    assert!(refused.error().contains("1 sizes for"), "{}", refused.stderr);
    let node = "6 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 0.25 0.25 -0.125\n5 3 3 3\n";
    std::fs::write(dir.join("n.node"), node).unwrap();
    std::fs::write(dir.join("n.ele"), "2 4 0\n0 0 1 2 3\n1 0 2 1 4\n").unwrap();
    let refused = run(dir, &["refine", "n.ele", "-o", "n.vtu"], 3);
    let told = "not Delaunay: vertex 4 at [0.25, 0.25, -0.125] is inside the circumsphere";
    assert!(refused.error().contains(told), "{}", refused.stderr);
    run(dir, &["refine", "n.ele", "--delaunay", "-o", "n.vtu"], 0);
    run(dir, &["check", "n.vtu"], 0);
    std::fs::write(dir.join("n.ele"), "0 4 0\n").unwrap();
    let refused = run(dir, &["refine", "n.ele"], 3);
    assert!(refused.error().contains("no tetrahedra"), "{}", refused.stderr);
}

#[test]
fn points_given_to_a_domain_are_vertices() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    run(dir, &["generate", "l-block", "-o", "d.poly"], 0);
    let points = "0.25 0.25 0.25\n0.3 0.3 0\n0.3 0 0\n9 9 9\n0 0 0\n";
    std::fs::write(dir.join("p.xyz"), points).unwrap();
    let args = ["mesh", "d.poly", "--points", "p.xyz", "-o", "m.vtu", "--json", "r.json"];
    let made = run(dir, &args, 0);
    let told = "given     3 points: 1 inside, 1 on facets, 1 on edges; 1 are at a vertex";
    assert!(made.stderr.contains(told), "{}", made.stderr);
    assert!(made.stderr.contains("note: 1 point left out: outside"), "{}", made.stderr);
    assert_eq!(read_json(dir.join("r.json"))["refinement"]["given_points"]["on_facets"], 1);
    run(dir, &["check", "m.vtu", "--plc", "d.poly", "--points", "p.xyz"], 0);
    std::fs::write(dir.join("q.xyz"), "0.25 0.25 0.2501\n").unwrap();
    let missing = run(dir, &["check", "m.vtu", "--plc", "d.poly", "--points", "q.xyz"], 1);
    assert!(missing.stderr.contains("VertexMissing"), "{}", missing.stderr);
    run(dir, &[&args[..], &["--strict"]].concat(), 3);
}
