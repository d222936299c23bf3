//! Conversion keeps what the other format has a place for, and names on stderr what it has not.

use crate::common::ltbw;
use std::collections::HashSet;
use std::path::Path;

/// The lines of stderr that tell of a loss, or of what was not read.
fn notes(dir: &Path, args: &[&str]) -> Vec<String> {
    let run = ltbw(dir, args);
    assert_eq!(run.code, 0, "{args:?}: {}", run.stderr);
    run.stderr.lines().filter(|line| line.starts_with("note: ")).map(str::to_owned).collect()
}

fn read(dir: &Path, name: &str) -> ltbw::io::MeshFile {
    ltbw::io::read_mesh_file(dir.join(name)).unwrap()
}

/// A mesh with several regions and boundary triangles with several markers, in `m.vtu`.
fn meshed(dir: &Path) {
    let domain = ["generate", "two-material", "-o", "d.poly"];
    for args in [&domain[..], &["mesh", "d.poly", "-o", "m.vtu"]] {
        assert_eq!(ltbw(dir, args).code, 0);
    }
}

/// Boundary triangles with their markers, in an order of their own.
fn markers(file: &ltbw::io::MeshFile) -> Vec<([u32; 3], i64)> {
    let sorted = |face: &ltbw::BoundaryFace| {
        let mut corners = face.corners;
        corners.sort_unstable();
        (corners, face.marker)
    };
    let mut list: Vec<([u32; 3], i64)> = file.mesh.faces.iter().map(sorted).collect();
    list.sort_unstable();
    list
}

#[test]
fn boundary_and_regions_survive_in_every_format_of_meshes() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    meshed(dir);
    let first = read(dir, "m.vtu");
    let different: HashSet<i64> = first.mesh.faces.iter().map(|face| face.marker).collect();
    assert!(different.len() >= 2, "markers {different:?}");
    let regions: HashSet<i64> = first.mesh.tet_tags.iter().flatten().copied().collect();
    assert!(regions.len() >= 2, "regions {regions:?}");
    // The figures of tetrahedra are not tags.
    assert_eq!(notes(dir, &["convert", "m.vtu", "a.vtu"]).len(), 1);
    for name in ["b.vtk", "b.msh", "b.mesh", "b.vtu", "b.ele"] {
        // There, and from there on.
        for (from, to) in [("a.vtu", name), (name, "c.vtu")] {
            assert_eq!(notes(dir, &["convert", from, to]), [""; 0], "{from} {to}");
            let back = read(dir, to);
            assert_eq!(markers(&back), markers(&first), "{from} {to}");
            assert_eq!(back.mesh.tet_tags, first.mesh.tet_tags, "{from} {to}");
        }
    }
    let rows = first.mesh.faces.iter().zip(0..).map(|(face, row)| {
        let [a, b, c] = face.corners;
        format!("{row} {a} {b} {c} {}\n", face.marker)
    });
    let face = std::fs::read_to_string(dir.join("b.face")).unwrap();
    assert_eq!(face, format!("{} 1\n{}", first.mesh.faces.len(), rows.collect::<String>()));
    let lost = notes(dir, &["convert", "a.vtu", "b.xyz"]);
    assert_eq!(lost.len(), 2, "{lost:?}");
    assert!(lost[0].ends_with("tetrahedra are not kept: this format holds points"));
    assert!(lost[1].ends_with("boundary triangles are not kept: this format holds points"));
}

/// Attributes are what users tell materials by; numbers of regions are ours.
#[test]
fn attributes_of_regions_reach_the_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    meshed(dir);
    let plain = std::fs::read_to_string(dir.join("d.poly")).unwrap();
    // The attributes of this domain are the numbers of its regions, which tell all.
    assert_eq!(read(dir, "m.vtu").mesh.tet_attributes, None);
    let mut regions = plain.lines().rev().take(2).map(str::to_owned).collect::<Vec<_>>();
    let mut text = plain.clone();
    for (row, attribute) in regions.iter_mut().rev().zip(["70", "90.5"]) {
        let mut words: Vec<&str> = row.split(' ').collect();
        words[4] = attribute;
        text = text.replace(&*row, &words.join(" "));
    }
    std::fs::write(dir.join("a.poly"), text).unwrap();
    let mesh = |output: &str| notes(dir, &["mesh", "a.poly", "-o", output]);
    let first = |name: &str| {
        let values = read(dir, name).mesh.tet_attributes.unwrap();
        let different: HashSet<u64> = values.iter().map(|value| value.to_bits()).collect();
        assert_eq!(different, HashSet::from([70.0_f64.to_bits(), 90.5_f64.to_bits()]), "{name}");
        values
    };
    assert_eq!((mesh("a.vtu"), mesh("a.vtk")), (Vec::new(), Vec::new()));
    assert_eq!(first("a.vtu"), first("a.vtk"));
    assert_eq!(read(dir, "a.vtu").mesh.tet_tags, read(dir, "a.vtk").mesh.tet_tags);
    let told = mesh("a.ele");
    assert_eq!(told, ["note: a.ele: attributes of regions stand in place of their numbers"]);
    assert_eq!(first("a.ele"), first("a.vtu"));
    let lost = "attributes of regions are not kept: this format has no place for them";
    for (name, other) in [("a.msh", "b.msh"), ("a.mesh", "b.mesh")] {
        assert_eq!(mesh(name), [format!("note: {name}: {lost}")]);
        let told = notes(dir, &["convert", "a.vtu", other]);
        assert!(told.contains(&format!("note: {other}: {lost}")), "{told:?}");
    }
    assert_eq!(notes(dir, &["convert", "a.ele", "c.vtu"]), [""; 0]);
    assert_eq!(first("c.vtu"), first("a.vtu"));
    let exterior = ["mesh", "a.poly", "--keep-exterior", "-o", "e.ele"];
    assert_eq!(notes(dir, &exterior).len(), 1);
    for name in ["a.ele", "c.vtu", "e.ele"] {
        assert_eq!(ltbw(dir, &["check", name, "--plc", "a.poly"]).code, 0, "{name}");
    }
    // One hash, whatever the attributes are.
    let hashes = ["a.poly", "d.poly"].map(|name| ltbw(dir, &["mesh", name]).stdout);
    assert_eq!(hashes[0], hashes[1]);
}

#[test]
fn names_of_groups_survive_in_msh_and_vtu_and_are_told_elsewhere() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 4 \"inlet wall\"\n\
                3 7 \"steel\"\n1 9 \"edge\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n\
                3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n2\n1 2 2 4 1 1 3 2\n2 4 2 7 1 1 2 3 4\n\
                $EndElements\n";
    std::fs::write(dir.join("g.msh"), text).unwrap();
    let named = [(2, 4, "inlet wall"), (3, 7, "steel")];
    for (output, options) in
        [("a.msh", &[][..]), ("b.msh", &["--msh2"]), ("c.msh", &["--ascii"]), ("a.vtu", &[])]
    {
        let args = [&["convert", "g.msh", output][..], options].concat();
        let told = notes(dir, &args);
        assert_eq!(told.len(), 1, "the name of the curve: {told:?}");
        let file = read(dir, output);
        let names = file.names.iter().map(|n| (n.dimension, n.group, n.name.as_str()));
        assert_eq!(names.collect::<Vec<_>>(), named, "{output}");
        assert_eq!((file.mesh.faces[0].marker, file.mesh.tet_tags), (4, Some(vec![7])));
        assert!(file.notes.is_empty(), "{:?}", file.notes);
    }
    for output in ["a.vtk", "a.mesh", "a.ele", "a.xyz"] {
        let told = notes(dir, &["convert", "a.msh", output]);
        let text = "names of groups are not kept: this format has no place for them";
        assert!(told.iter().any(|note| note.ends_with(text)), "{output}: {told:?}");
    }
}

/// Names of groups that are empty in the mesh, or cannot be groups: some tetrahedra are in none, a
/// triangle of the surface is no face, and a marker that no group can have needs a free one.
#[test]
fn names_survive_where_groups_do_not() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 \"inlet\"\n\
                2 4 \"wall\"\n3 7 \"steel\"\n3 8 \"air\"\n$EndPhysicalNames\n$Nodes\n5\n\
                1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n$EndNodes\n$Elements\n5\n\
                1 2 2 1 1 3 4 5\n2 2 2 4 1 1 2 4\n3 2 2 0 1 2 3 4\n4 4 2 7 1 1 2 3 4\n\
                5 4 2 0 1 1 3 2 5\n$EndElements\n";
    std::fs::write(dir.join("g.msh"), text).unwrap();
    let named = [(2, 1, "inlet"), (2, 4, "wall"), (3, 7, "steel"), (3, 8, "air")];
    for (output, options) in
        [("a.msh", &[][..]), ("b.msh", &["--msh2"]), ("c.msh", &["--ascii"]), ("a.vtu", &[])]
    {
        let args = [&["convert", "g.msh", output][..], options].concat();
        let told = notes(dir, &args);
        let lost = "1 triangles that are faces of no tetrahedron are not read";
        assert!(told.len() == 1 && told[0].ends_with(lost), "{told:?}");
        let file = read(dir, output);
        let names = file.names.iter().map(|n| (n.dimension, n.group, n.name.as_str()));
        assert_eq!(names.collect::<Vec<_>>(), named, "{output}");
        let markers: Vec<i64> = file.mesh.faces.iter().map(|face| face.marker).collect();
        assert_eq!((markers, file.mesh.tet_tags), (vec![4, 0], Some(vec![7, 0])), "{output}");
        assert!(file.notes.is_empty(), "{:?}", file.notes);
    }
}

#[test]
fn what_surfaces_have_no_place_for_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let poly = "8 3 0 0\n0 0 0 0\n1 4 0 0\n2 0 4 0\n3 0 0 4\n4 1 1 1\n5 1.2 1 1\n6 1 1.2 1\n\
                7 1 1 1.2\n9 1\n1 0 2\n3 0 2 1\n1 0 2\n3 0 1 3\n1 0 2\n3 1 2 3\n1 0 2\n3 2 0 3\n\
                1 0 2\n3 4 6 5\n1 0 2\n3 4 5 7\n1 0 2\n3 5 6 7\n1 0 2\n3 6 4 7\n1 0 2\n2 0 4\n\
                1\n0 1.05 1.05 1.05\n1\n0 0.1 0.1 0.1 5 -1\n";
    std::fs::write(dir.join("d.poly"), poly).unwrap();
    for output in ["d.off", "d.obj", "d.stl", "d.ply", "d.vtk"] {
        let told = notes(dir, &["convert", "d.poly", output]).join("\n");
        for lost in ["holes are", "regions are", "free-standing segments are"] {
            assert!(told.contains(&format!("{lost} not kept")), "{output}: {told}");
        }
        let keeps_markers = matches!(output, "d.ply" | "d.vtk");
        assert_eq!(told.contains("markers of facets are not kept"), !keeps_markers, "{told}");
    }
    assert_eq!(notes(dir, &["convert", "d.poly", "e.poly"]), [""; 0]);
    assert_eq!(ltbw(dir, &["generate", "uniform", "20", "-o", "p.node"]).code, 0);
    std::fs::write(dir.join("t.csv"), "x,y,z,tag\n0,0,0,1\n").unwrap();
    for output in ["t.npy", "t.xyz", "t.txt"] {
        let told = notes(dir, &["convert", "t.csv", output]);
        assert!(told[0].ends_with("tags are not kept: this format has no place for them"));
    }
    assert_eq!(notes(dir, &["convert", "t.csv", "t.ply"]), [""; 0]);
}

/// B5: a cube with a cube-shaped void stays one: the volume is that of the surface.
#[test]
fn voids_of_surfaces_become_hole_points() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let tetrahedron = |scale: f64, at: f64, flip: bool, first: usize| {
        let p = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let point = |c: [f64; 3]| {
            let [x, y, z] = c.map(|v| v * scale + at);
            format!("{x} {y} {z}\n")
        };
        let face = |[a, b, c]: [usize; 3]| {
            let [b, c] = if flip { [c, b] } else { [b, c] };
            format!("3 {} {} {}\n", a + first, b + first, c + first)
        };
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        (p.map(point).concat(), faces.map(face).concat())
    };
    let (outer, inner) = (tetrahedron(8.0, 0.0, false, 0), tetrahedron(1.0, 1.0, true, 4));
    let text = format!("OFF\n8 8 0\n{}{}{}{}", outer.0, inner.0, outer.1, inner.1);
    std::fs::write(dir.join("d.off"), text).unwrap();
    let told = notes(dir, &["convert", "d.off", "d.poly"]);
    assert_eq!(told, ["note: d.poly: a hole point is added in each of 1 voids"]);
    let volume = |name: &str| {
        let run = ltbw(dir, &["check", name, "--json", "-"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        json["domain"]["volume"].as_f64().unwrap()
    };
    assert_eq!(volume("d.off"), volume("d.poly"));
    assert!((volume("d.off") - 511.0 / 6.0).abs() < 1e-9);
}
