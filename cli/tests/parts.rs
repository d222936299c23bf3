//! Parts of surfaces: markers, names and what is told of them.

use crate::common::ltbw;
use crate::schema::validate;
use serde_json::Value;
use std::path::Path;

/// A closed prism of `n` sides as an `.stl` file; its sides, bottom and top are solids of their own
/// if `names` are given.
fn prism(path: &Path, n: u32, names: Option<[&str; 3]>) {
    let rim = |k: u32, z: f64| {
        let angle = std::f64::consts::TAU * f64::from(k % n) / f64::from(n);
        [angle.cos(), angle.sin(), z]
    };
    let mut all = [const { Vec::new() }; 3];
    for k in 0..n {
        let [a, b, c, d] = [rim(k, 0.0), rim(k + 1, 0.0), rim(k, 2.0), rim(k + 1, 2.0)];
        all[0].extend([[a, b, d], [a, d, c]]);
        all[1].push([b, a, [0.0; 3]]);
        all[2].push([c, d, [0.0, 0.0, 2.0]]);
    }
    let corner = |p: &[f64; 3]| format!("vertex {} {} {}\n", p[0] as f32, p[1] as f32, p[2] as f32);
    let facet = |t: &[[f64; 3]; 3]| {
        let corners: String = t.iter().map(corner).collect();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let part = |(own, name): (&Vec<_>, &str)| {
        let facets: String = own.iter().map(facet).collect();
        format!("solid {name}\n{facets}endsolid {name}\n")
    };
    let text: String = all.iter().zip(names.unwrap_or(["part"; 3])).map(part).collect();
    let joined = text.replace("endsolid part\nsolid part\n", "");
    std::fs::write(path, joined).unwrap();
}

#[test]
fn a_cylinder_has_three_parts_with_names_and_one_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    prism(&dir.join("c.stl"), 24, None);
    prism(&dir.join("n.stl"), 24, Some(["side", "bottom", "the top"]));
    let run = ltbw(dir, &["mesh", "c.stl", "-o", "c.msh", "-o", "c.vtu", "--json", "c.json"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let told: Vec<&str> = run.stderr.lines().filter(|line| line.starts_with("part ")).collect();
    assert_eq!(told.len(), 3, "{told:?}");
    assert!(told[0].starts_with("part 1    area 12.53") && told[0].contains(", round, 48 facets"));
    assert!(told[1].contains("(-1 -1 0) to (1 1 0), normal (0 0 -1), 24 facets"), "{}", told[1]);
    let report: Value =
        serde_json::from_str(&std::fs::read_to_string(dir.join("c.json")).unwrap()).unwrap();
    validate(&report);
    let parts = report["refinement"]["parts"].as_array().unwrap();
    assert_eq!(parts.len(), 3);
    assert_eq!(parts[2]["normal"], serde_json::json!([0.0, 0.0, 1.0]));
    let file = ltbw::io::read_mesh_file(dir.join("c.msh")).unwrap();
    let names: Vec<&str> = file.names.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names, ["part", "part 1", "part 2", "part 3"], "the solid is the volume");
    for face in &file.mesh.faces {
        let heights = face.corners.map(|v| file.mesh.points[v as usize][2]);
        let wanted = match heights.iter().sum::<f64>() {
            0.0 => 2,
            6.0 => 3,
            _ => 1,
        };
        assert_eq!(face.marker, wanted);
    }
    // The mesh is what it is, whatever the parts are.
    let none = ltbw(dir, &["mesh", "c.stl", "--feature-angle", "0", "-o", "z.vtu"]);
    let named = ltbw(dir, &["mesh", "n.stl", "-o", "n.vtu"]);
    assert_eq!((&none.stdout, &named.stdout), (&run.stdout, &run.stdout));
    assert!(!none.stderr.contains("part 1"), "{}", none.stderr);
    assert!(named.stderr.contains("part 3    \"the top\": area 3.1"), "{}", named.stderr);
    let file = ltbw::io::read_mesh_file(dir.join("n.vtu")).unwrap();
    let names: Vec<&str> = file.names.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names, ["side", "bottom", "the top"]);
}

#[test]
fn angles_that_are_none_are_refused_and_markers_go_before() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    prism(&dir.join("c.stl"), 6, None);
    for wrong in ["-1", "91", "NaN", "x"] {
        let run = ltbw(dir, &["mesh", "c.stl", "--feature-angle", wrong]);
        assert_eq!(run.code, 2, "{wrong}");
    }
    // Sides of a hexagon meet at 60 degrees.
    let count = |angle: &str| {
        let run = ltbw(dir, &["mesh", "c.stl", "--feature-angle", angle]);
        run.stderr.lines().filter(|line| line.starts_with("part ")).count()
    };
    assert_eq!([count("59"), count("61")], [8, 3]);
    prism(&dir.join("n.stl"), 6, Some(["a", "b", "c"]));
    let run = ltbw(dir, &["mesh", "n.stl", "--feature-angle", "30"]);
    assert!(run.stderr.contains("--feature-angle: its facets have markers"), "{}", run.stderr);
}
