//! `ltbw refine`, and points given to `ltbw mesh`.

use crate::common::{read_json, run};
use crate::schema::validate;
use serde_json::Value;
use std::collections::BTreeSet;
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
fn a_certificate_names_all_that_a_mesh_was_gone_on_with() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    model(dir);
    std::fs::write(dir.join("marks.txt"), "0\n").unwrap();
    std::fs::write(dir.join("p.xyz"), "0.1 0.1 0.1\n").unwrap();
    let beside = ["--plc", "d.poly", "--mark", "marks.txt", "--points", "p.xyz"];
    let args = [&["refine", "m.vtu", "-o", "k.vtu", "--json", "r.json"][..], &beside].concat();
    run(dir, &args, 0);
    validate(&read_json(dir.join("r.json")));
    let inputs = ["m.vtu", "d.poly", "marks.txt", "p.xyz"].map(|file| ["--input", file]).concat();
    let check = [&["check", "k.vtu", "--certificate", "r.json"][..], &inputs].concat();
    let same = run(dir, &check, 0);
    assert!(same.stderr.contains("4 of 4 inputs"), "{}", same.stderr);
    assert!(same.stderr.contains("slivers   below 8 degrees: "), "{}", same.stderr);
    std::fs::write(dir.join("marks.txt"), "1\n").unwrap();
    let other = run(dir, &check, 1);
    assert!(other.stderr.contains("differs   input: marks.txt"), "{}", other.stderr);
}

#[test]
fn a_mesh_of_any_kind_is_refused_by_name_or_gone_on_with() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let corner = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
    let write = |file: &str, points: &str, cells: &[&str]| {
        let (count, words) = (points.lines().count(), cells.join(" ").split(' ').count());
        let of = |cell: &&str| if cell.starts_with('8') { "12" } else { "10" };
        let types: Vec<&str> = cells.iter().map(of).collect();
        let text = format!(
            "# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\n\
             POINTS {count} double\n{points}CELLS {} {words}\n{}\nCELL_TYPES {}\n{}\n",
            cells.len(),
            cells.join("\n"),
            cells.len(),
            types.join("\n")
        );
        std::fs::write(dir.join(file), text).unwrap();
    };
    let cube = format!("{corner}1 1 0\n1 1 1\n0 1 1\n1 0 1\n");
    write("hex.vtk", &cube, &["8 0 1 4 2 3 7 5 6"]);
    write("two.vtk", &format!("{corner}5 0 0\n6 0 0\n5 1 0\n5 0 1\n"), &["4 0 1 2 3", "4 4 5 6 7"]);
    let cross = format!("{corner}0.1 0.1 0.1\n1.1 0.1 0.1\n0.1 1.1 0.1\n0.1 0.1 1.1\n");
    write("cross.vtk", &cross, &["4 0 1 2 3", "4 4 5 6 7"]);
    let inside = format!("{corner}-9 -9 -9\n30 -9 -9\n-9 30 -9\n-9 -9 30\n");
    write("inside.vtk", &inside, &["4 0 1 2 3", "4 4 5 6 7"]);
    write("same.vtk", corner, &["4 0 1 2 3", "4 0 1 2 3"]);
    write("flat.vtk", &format!("{corner}1 1 0\n"), &["4 0 1 2 3", "4 0 1 2 4"]);
    for (file, code, told) in [
        ("hex.vtk", 3, "not supported: cell 0 of VTK type 12"),
        ("cross.vtk", 3, "the boundary of the mesh is no domain: defects: "),
        ("inside.vtk", 3, "they overlap, or the boundary touches itself"),
        ("same.vtk", 3, "tetrahedra 0 and 1 overlap at a triangle at "),
        ("flat.vtk", 3, "tetrahedron 1 is flat"),
        ("two.vtk", 0, "2 tetrahedra inside, 2 regions"),
    ] {
        let run = run(dir, &["refine", file, "--delaunay", "-o", "o.vtu"], code);
        assert!(run.stderr.contains(told), "{file}: {}", run.stderr);
        assert_eq!(dir.join("o.vtu").exists(), code == 0, "{file}");
    }
    for (args, code, told) in [
        (["--min-dihedral", "12.5"], 2, "between 0 (none) and 12 degrees"),
        (["--min-dihedral", "NaN"], 2, "between 0 (none) and 12 degrees"),
        (["--simplify", "0.01"], 2, "--simplify: the vertices of the mesh are kept"),
        (["--repair", "3"], 2, "the tolerance 3e0 is not between 0 and"),
        (["--max-volume", "0"], 2, "the bound max-volume = 0e0 cannot be met"),
    ] {
        let refused = run(dir, &[&["refine", "two.vtk"][..], &args].concat(), code);
        assert!(refused.error().contains(told), "{args:?}: {}", refused.stderr);
    }
    let args = ["refine", "two.vtk", "--max-volume", "1e-4", "--max-points", "20", "-o", "b.vtu"];
    let ended = run(dir, &args, 4);
    assert!(ended.error().starts_with("budget used up: "), "{}", ended.stderr);
    assert!(dir.join("b.vtu").exists());
}

/// A cube by TetGen 1.5 (`-pfg`): its points from 1, tetrahedra, all their triangles, and these as
/// its `.mesh` file has them.
const TETGEN: [&str; 4] = [
    "8  3  0  0\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n\
     # Generated by tetgen -Qpfg cube.poly\n",
    "6  4  0\n1 1 4 8 3\n2 1 8 5 7\n3 6 1 5 7\n4 1 8 7 3\n5 6 1 7 2\n6 7 1 3 2\n",
    "18  1\n1 3 8 4 15\n2 3 1 8 0\n3 4 1 3 11\n4 4 8 1 16\n5 7 5 8 12\n6 7 1 5 0\n7 8 1 7 0\n\
     8 8 5 1 16\n9 7 6 5 12\n10 1 6 7 0\n11 1 5 6 13\n12 3 7 8 15\n13 3 1 7 0\n14 2 7 1 0\n\
     15 2 6 7 14\n16 1 6 2 13\n17 2 3 1 11\n18 2 7 3 14\n",
    "MeshVersionFormatted 1\n\nDimension\n3\n\n# Set of mesh vertices\nVertices\n8\n0 0 0 0\n\
     1 0 0 0\n1 1 0 0\n0 1 0 0\n0 0 1 0\n1 0 1 0\n1 1 1 0\n0 1 1 0\n\n# Set of Triangles\n\
     Triangles\n18\n3 8 4 15\n3 1 8 0\n4 1 3 11\n4 8 1 16\n7 5 8 12\n7 1 5 0\n8 1 7 0\n\
     8 5 1 16\n7 6 5 12\n1 6 7 0\n1 5 6 13\n3 7 8 15\n3 1 7 0\n2 7 1 0\n2 6 7 14\n1 6 2 13\n\
     2 3 1 11\n2 7 3 14\n\nTetrahedra\n6\n1 4 8 3 0\n1 8 5 7 0\n6 1 5 7 0\n1 8 7 3 0\n\
     6 1 7 2 0\n7 1 3 2 0\n\nCorners\n1\n1\n\nEnd\n",
];

#[test]
fn meshes_of_tetgen_are_gone_on_with() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    for (file, text) in ["t.node", "t.ele", "t.face", "all.mesh"].into_iter().zip(TETGEN) {
        std::fs::write(dir.join(file), text).unwrap();
    }
    // All triangles are listed: those inside are no walls.
    let mut finer = Vec::new();
    for mesh in ["t.ele", "all.mesh"] {
        let args = ["refine", mesh, "--max-volume", "0.02", "-o", "f.vtu", "--json", "r.json"];
        let made = run(dir, &args, 0);
        let told = format!("{mesh}: 8 vertices, 6 facets, 0 holes, 0 regions");
        assert!(made.stderr.contains(&told), "{}", made.stderr);
        assert_eq!(read_json(dir.join("r.json"))["refinement"]["regions"][1], Value::Null);
        finer.push(hash(&made.stdout));
        let faces = ltbw::io::read_mesh(dir.join("f.vtu")).unwrap().faces;
        let markers: BTreeSet<i64> = faces.iter().map(|face| face.marker).collect();
        assert_eq!(markers, (11..17).collect(), "{mesh}");
    }
    assert_eq!(finer[0], finer[1]);
    // One of them has a marker, and is a wall.
    let walled = TETGEN[2].replace("\n7 8 1 7 0\n", "\n7 8 1 7 9\n");
    std::fs::write(dir.join("t.face"), walled).unwrap();
    let args = ["refine", "t.ele", "--max-volume", "0.02", "-o", "f.vtu"];
    run(dir, &args, 0);
    let faces = ltbw::io::read_mesh(dir.join("f.vtu")).unwrap().faces;
    assert!(faces.iter().any(|face| face.marker == 9));
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
    assert!(refused.error().ends_with("; --delaunay takes its vertices and boundary"));
    run(dir, &["refine", "n.ele", "--delaunay", "-o", "n.vtu"], 0);
    run(dir, &["check", "n.vtu"], 0);
    std::fs::write(dir.join("n.ele"), "0 4 0\n").unwrap();
    let refused = run(dir, &["refine", "n.ele"], 3);
    assert!(refused.error().contains("no tetrahedra"), "{}", refused.stderr);
}

#[test]
fn vertices_inside_move_alike_by_workers() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let plain = model(dir);
    let args = ["mesh", "d.poly", "--max-volume", "1e-2", "--smooth", "2", "-o", "s.vtu"];
    let moved = run(dir, &args, 0);
    assert!(moved.stderr.contains("\nsmoothed  "), "{}", moved.stderr);
    let crew = run(dir, &[&args[..], &["--workers", "2", "--json", "r.json"]].concat(), 0);
    assert_eq!(moved.stdout, crew.stdout);
    assert_ne!(hash(&moved.stdout), plain);
    let report = read_json(dir.join("r.json"));
    assert!(report["refinement"]["moved"].as_u64() > Some(0), "{report}");
    assert_eq!(report["certificate"]["binding"]["options"]["smooth"], "2");
    let bounds = ["--max-volume", "1e-2", "--radius-edge", "2"];
    run(dir, &[&["check", "s.vtu", "--plc", "d.poly"], &bounds[..]].concat(), 0);
    run(dir, &["mesh", "d.poly", "--smooth", "17"], 2);
}

/// A `.vtu` as text with an array of lengths at its points: those of a linear function.
fn with_solution(dir: &Path, from: &str, to: &str, names: &[&str]) {
    run(dir, &["convert", from, "ascii.vtu", "--ascii"], 0);
    let text = std::fs::read_to_string(dir.join("ascii.vtu")).unwrap();
    let points = ltbw::io::read_mesh(dir.join(from)).unwrap().points;
    let values: Vec<String> = points.iter().map(|p| format!("{}", 0.12 + 0.1 * p[0])).collect();
    let array = |name: &&str| {
        let head = format!("<DataArray type=\"Float64\" Name=\"{name}\" format=\"ascii\">");
        format!("{head}{}</DataArray>", values.join(" "))
    };
    let arrays: Vec<String> = names.iter().map(array).collect();
    let section = format!("<PointData>{}</PointData>\n<Points>", arrays.concat());
    assert_eq!(text.matches("<Points>").count(), 1);
    std::fs::write(dir.join(to), text.replace("<Points>", &section)).unwrap();
}

#[test]
fn sizes_are_those_of_a_solution() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    model(dir);
    with_solution(dir, "m.vtu", "s.vtu", &["h"]);
    with_solution(dir, "m.vtu", "two.vtu", &["error", "h"]);
    let points = ltbw::io::read_mesh(dir.join("m.vtu")).unwrap().points;
    let lines: Vec<String> = points.iter().map(|p| format!("{}\n", 0.12 + 0.1 * p[0])).collect();
    std::fs::write(dir.join("s.mtr"), format!("{} 1\n{}", lines.len(), lines.concat())).unwrap();
    // Of a mesh that is gone on with, and of a domain that is meshed anew.
    let refine = |sizes: &str| hash(&run(dir, &["refine", "m.vtu", "--sizes", sizes], 0).stdout);
    let expected = refine("s.mtr");
    assert_eq!(["s.vtu", "s.vtu:h", "two.vtu:h"].map(refine), [(); 3].map(|()| expected.clone()));
    let mesh = |args: &[&str]| hash(&run(dir, &[&["mesh", "d.poly"], args].concat(), 0).stdout);
    let fresh = mesh(&["--sizes", "s.mtr", "--background", "m.vtu"]);
    assert_eq!(mesh(&["--sizes", "two.vtu:h", "--json", "r.json"]), fresh);
    let options = &read_json(dir.join("r.json"))["certificate"]["binding"]["options"];
    assert_eq!(options["sizes_field"], "h");
    for (args, code, told) in [
        (["refine", "m.vtu", "--sizes", "two.vtu"], 3, "one has to be named"),
        (["refine", "m.vtu", "--sizes", "s.vtu:g"], 3, "points without the array `g`"),
        (["refine", "f.ele", "--sizes", "s.vtu"], 2, "sizes for"),
        (["mesh", "d.poly", "--sizes", "m.vtu"], 3, "points without an array of floats"),
    ] {
        if args[1] == "f.ele" {
            run(dir, &["mesh", "d.poly", "-o", "f.ele"], 0);
        }
        let refused = run(dir, &args, code);
        assert!(refused.error().contains(told), "{args:?}: {}", refused.stderr);
    }
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
