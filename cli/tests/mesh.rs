//! `ltbw mesh` and `ltbw check --plc`, from file to file.

use crate::common::{ltbw, names};
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

#[test]
fn files_carry_quality_regions_and_the_markers_of_facets() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    // Two unit cubes; the wall between them has a marker of its own, and so has the bottom.
    assert_eq!(ltbw(dir, &["generate", "two-material", "-o", "t.poly"]).code, 0);
    let outputs = ["-o", "t.vtu", "-o", "t.mesh", "-o", "t.ele", "--page", "t.html"];
    let run = ltbw(dir, &[&["mesh", "t.poly", "--max-volume", "0.02"], &outputs[..]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let read = |name: &str| std::fs::read_to_string(dir.join(name)).unwrap();
    let faces: Vec<Vec<i64>> = read("t.face")
        .lines()
        .map(|line| line.split(' ').map(|w| w.parse().unwrap()).collect())
        .collect();
    assert_eq!(faces[0], [faces.len() as i64 - 1, 1]);
    let mut markers: Vec<i64> = faces[1..].iter().map(|f| f[4]).collect();
    markers.sort_unstable();
    markers.dedup();
    let poly = read("t.poly");
    assert!(markers.len() > 1, "{markers:?} of {poly}");
    // The same triangles in Medit's file, numbered from 1.
    let medit = read("t.mesh");
    let triangles = medit.split("Triangles\n").nth(1).unwrap().lines().skip(1);
    let triangles = triangles.take_while(|line| *line != "End");
    let same = triangles.zip(&faces[1..]).filter(|(line, face)| {
        let row: Vec<i64> = line.split(' ').map(|w| w.parse().unwrap()).collect();
        row == [face[1] + 1, face[2] + 1, face[3] + 1, face[4]]
    });
    assert_eq!(same.count(), faces.len() - 1);
    let vtu = std::fs::read(dir.join("t.vtu")).unwrap();
    let head = String::from_utf8_lossy(&vtu[..2000.min(vtu.len())]).into_owned();
    for name in ["region", "marker", "radius_edge", "volume", "dihedral_min", "dihedral_max"] {
        assert!(head.contains(&format!("Name=\"{name}\"")), "{name}: {head}");
    }
    assert!(read("t.html").contains("</html>"));
    for mesh in ["t.vtu", "t.mesh", "t.ele"] {
        let run = ltbw(dir, &["check", mesh, "--plc", "t.poly", "--max-volume", "0.02"]);
        assert_eq!(run.code, 0, "{mesh}: {}", run.stderr);
    }
}

/// The number of tetrahedra that a run says.
fn tets(stderr: &str) -> usize {
    let line = stderr.lines().find(|l| l.starts_with("mesh ")).unwrap();
    line.split(' ').rev().nth(4).unwrap().parse().unwrap()
}

#[test]
fn sizes_are_constant_at_vertices_or_of_a_background_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let cube = "8 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 1 1 0\n4 0 0 1\n5 1 0 1\n6 0 1 1\n7 1 1 1\n\
                6 0\n1\n4 0 1 3 2\n1\n4 4 5 7 6\n1\n4 0 1 5 4\n1\n4 2 3 7 6\n1\n4 0 2 6 4\n\
                1\n4 1 3 7 5\n0\n0\n";
    std::fs::write(dir.join("c.poly"), cube).unwrap();
    let mesh = |more: &[&str]| {
        let run = ltbw(dir, &[&["mesh", "c.poly"], more].concat());
        assert_eq!(run.code, 0, "{more:?}: {}", run.stderr);
        tets(&run.stderr)
    };
    let (none, fine) = (mesh(&[]), mesh(&["--size", "0.1"]));
    // Regular tetrahedra of this edge fill the cube 8,485 times.
    assert!(none < 100 && (7637..11_455).contains(&fine), "{none} {fine}");
    // The same everywhere is the same; finer at one vertex is in between.
    std::fs::write(dir.join("even.mtr"), format!("8 1\n{}", "0.1\n".repeat(8))).unwrap();
    assert_eq!(mesh(&["--sizes", "even.mtr"]), fine);
    std::fs::write(dir.join("one.mtr"), format!("8 1\n0.1\n{}", "0.9\n".repeat(7))).unwrap();
    let graded = mesh(&["--sizes", "one.mtr", "-o", "g.ele"]);
    assert!((none..fine / 2).contains(&graded), "{graded}");
    // The graded mesh as a background: one size for each of its points.
    let points = std::fs::read_to_string(dir.join("g.node")).unwrap();
    let count = points.split(' ').next().unwrap().parse::<usize>().unwrap();
    std::fs::write(dir.join("g.mtr"), format!("{count} 1\n{}", "0.1\n".repeat(count))).unwrap();
    assert_eq!(mesh(&["--sizes", "g.mtr", "--background", "g.ele"]), fine);
    let refused: [(&[&str], i32, &str); 5] = [
        (&["--size", "0"], 2, "positive"),
        (&["--background", "g.ele"], 2, "sizes"),
        (&["--sizes", "g.mtr"], 2, "for 8 points"),
        (&["--sizes", "c.poly"], 3, "c.poly"),
        (&["--sizes", "bad.mtr"], 3, "size 7 is -1.0"),
    ];
    std::fs::write(dir.join("bad.mtr"), format!("8 1\n{}-1\n", "0.1\n".repeat(7))).unwrap();
    for (args, code, word) in refused {
        let run = ltbw(dir, &[&["mesh", "c.poly"], args].concat());
        assert_eq!(run.code, code, "{args:?}: {}", run.stderr);
        assert!(run.stderr.contains(word), "{args:?}: {}", run.stderr);
    }
}
