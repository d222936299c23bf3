//! Data beside the mesh in mesh files, edge lengths, and writers whose medium is full.

use ltbw_core::{BoundaryFace, CancelToken, TetMesh};
use ltbw_domain::quality::{self, Array};
use ltbw_formats as io;
use ltbw_formats::{
    DataError, Encoding, IoError, MshVersion, csv, medit, msh, npy, tetgen, vtu, xyz,
};
use std::io::{Error, ErrorKind, Write};

fn corner() -> TetMesh {
    TetMesh {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        tets: vec![[0, 1, 2, 3]],
        point_tags: Some(vec![1, 2, 3, 4]),
        tet_tags: Some(vec![7]),
        ..TetMesh::default()
    }
}

/// This mesh with two boundary faces.
fn bounded() -> TetMesh {
    TetMesh { faces: boundary(), ..corner() }
}

fn boundary() -> Vec<BoundaryFace> {
    let face = |corners, marker| BoundaryFace { corners, marker, tet: 0 };
    vec![face([0, 2, 1], -5), face([1, 2, 3], 9)]
}

#[test]
fn boundaries_are_written_where_the_format_has_a_place() {
    let dir = tempfile::tempdir().expect("a folder");
    let write = |name: &str, mesh: &TetMesh| {
        let path = dir.path().join(name);
        io::write_mesh(&path, mesh).expect("written");
        assert_eq!(io::read_mesh(&path).expect("a mesh"), *mesh, "{name}");
    };
    let text = |name: &str| std::fs::read_to_string(dir.path().join(name)).expect("a text");
    write("a.mesh", &bounded());
    assert!(text("a.mesh").ends_with("\nTriangles\n2\n1 3 2 -5\n2 3 4 9\nEnd\n"));
    write("b.mesh", &corner());
    assert!(!text("b.mesh").contains("Triangles"));
    write("a.ele", &bounded());
    assert_eq!(text("a.face"), "2 1\n0 0 2 1 -5\n1 1 2 3 9\n");
    write("b.ele", &corner());
    assert!(!dir.path().join("b.face").exists());
    std::fs::create_dir(dir.path().join("c.face")).expect("a folder");
    assert!(io::check_mesh_writable(dir.path().join("c.node")).is_err());
    assert!(io::check_mesh_writable(dir.path().join("d.node")).is_ok());
}

#[test]
fn attributes_are_kept_where_the_format_has_a_place() {
    let dir = tempfile::tempdir().expect("a folder");
    let mut mesh = walled();
    mesh.tet_attributes = Some(vec![70.0, 90.5]);
    let back = |name: &str, mesh: &TetMesh| {
        let path = dir.path().join(name);
        io::write_mesh(&path, mesh).expect("written");
        io::read_mesh_file(&path).expect("a mesh")
    };
    for name in ["a.vtu", "a.vtk"] {
        let file = back(name, &mesh);
        assert_eq!((file.mesh, file.notes), (mesh.clone(), Vec::new()), "{name}");
    }
    let file = back("a.ele", &mesh);
    // In TetGen's file they stand where regions stand without them.
    let read = (file.mesh.tet_tags, file.mesh.tet_attributes.clone());
    assert_eq!(read, (None, mesh.tet_attributes.clone()));
    let text = std::fs::read_to_string(dir.path().join("a.ele")).expect("a text");
    assert_eq!(text, "2 4 1\n0 0 1 2 3 70\n1 0 2 1 4 90.5\n");
    for name in ["a.msh", "a.mesh"] {
        let file = back(name, &mesh);
        assert_eq!((file.mesh.tet_tags, file.mesh.tet_attributes), (Some(vec![2, 1]), None));
    }
    for format in io::Format::ALL.into_iter().filter(|format| format.holds_mesh()) {
        let keeps = !matches!(format, io::Format::Msh | io::Format::Medit);
        assert_eq!(format.holds_attributes(), keeps, "{format:?}");
    }
    for (attributes, at) in [(vec![1.0], "1 tags for 2"), (vec![1.0, f64::NAN], "tetrahedron 1")] {
        mesh.tet_attributes = Some(attributes);
        let error = io::write_mesh(dir.path().join("b.vtu"), &mesh).expect_err("refused");
        assert!(error.to_string().contains(at), "{error}");
    }
}

/// Arrays of the same name that are something else stay what they were: not read, with a note.
#[test]
fn other_arrays_of_that_name_are_passed_over() {
    let mut bytes = Vec::new();
    let mesh = TetMesh { tet_attributes: Some(vec![1.5]), ..corner() };
    vtu::write(&mut bytes, &mesh, Encoding::Ascii).expect("memory");
    let text = String::from_utf8(bytes).expect("text");
    let ours = "type=\"Float64\" Name=\"attribute\"";
    assert!(vtu::read(text.as_bytes()).expect("a mesh").mesh == mesh && text.contains(ours));
    let other = "type=\"Float64\" Name=\"attribute\" NumberOfComponents=\"3\"";
    for other in [other, "type=\"Int64\" Name=\"attribute\""] {
        let file = vtu::read(text.replace(ours, other).as_bytes()).expect("a mesh");
        assert_eq!((file.mesh.tet_attributes, file.notes.len()), (None, 1), "{other}");
    }
}

/// Two tetrahedra with boundary triangles of every kind of marker, one between the two.
fn walled() -> TetMesh {
    let mut mesh = corner();
    mesh.points.push([0.0, 0.0, -1.0]);
    mesh.tets.push([0, 2, 1, 4]);
    mesh.point_tags = None;
    mesh.tet_tags = Some(vec![2, 1]);
    let face = |corners, marker, tet| BoundaryFace { corners, marker, tet };
    mesh.faces = vec![
        face([0, 2, 1], 12, 0),
        face([1, 2, 3], 0, 0),
        face([0, 1, 3], -3, 0),
        face([1, 0, 4], i64::from(i32::MAX) + 1, 1),
        face([2, 1, 4], 1, 1),
    ];
    mesh
}

#[test]
fn boundaries_are_read_back() {
    let dir = tempfile::tempdir().expect("a folder");
    let mesh = walled();
    for (name, encoding, msh_version) in [
        ("a.vtu", Encoding::Ascii, MshVersion::V4_1),
        ("b.vtu", Encoding::Binary, MshVersion::V4_1),
        ("c.mesh", Encoding::Ascii, MshVersion::V4_1),
        ("d.msh", Encoding::Ascii, MshVersion::V4_1),
        ("e.msh", Encoding::Binary, MshVersion::V4_1),
        ("f.msh", Encoding::Ascii, MshVersion::V2_2),
        ("g.msh", Encoding::Binary, MshVersion::V2_2),
        ("h.ele", Encoding::Ascii, MshVersion::V4_1),
        ("i.node", Encoding::Ascii, MshVersion::V4_1),
        ("j.vtk", Encoding::Ascii, MshVersion::V4_1),
        ("k.vtk", Encoding::Binary, MshVersion::V4_1),
    ] {
        let path = dir.path().join(name);
        let options = io::WriteOptions { encoding, msh_version };
        io::write_mesh_with(&path, &mesh, options).expect("written");
        let read = io::read_mesh_file(&path).expect("a mesh");
        // Version 4.1 of `.msh` has elements by group; their numbers tell the order.
        assert_eq!(read.mesh, mesh, "{name}");
        assert_eq!(read.notes, [] as [&str; 0], "{name}");
    }
    let text = std::fs::read_to_string(dir.path().join("d.msh")).expect("a text");
    assert!(text.contains("$PhysicalNames\n5\n2 2 \"marker -3\"\n2 3 \"marker 0\"\n"), "{text}");
}

/// Programs that ignore the numbers of elements in views take one value for each, in their order.
#[test]
fn a_view_of_regions_has_a_value_for_each_element_in_their_order() {
    let mut mesh = walled();
    mesh.tet_tags = Some(vec![9, 0]);
    for (version, numbers) in
        [(MshVersion::V4_1, [1, 2, 5, 4, 7, 3, 6]), (MshVersion::V2_2, [1, 2, 3, 4, 5, 6, 7])]
    {
        let mut bytes = Vec::new();
        msh::write(&mut bytes, &mesh, version, Encoding::Ascii).expect("written");
        let text = String::from_utf8(bytes.clone()).expect("a text");
        let (_, view) = text.split_once("\"region\"\n1\n0\n3\n0\n1\n").expect("a view");
        let rows: Vec<String> = numbers
            .iter()
            .map(|&n| format!("{n} {}\n", if matches!(n, 2 | 6 | 7) { 0 } else { 9 }))
            .collect();
        assert_eq!(view, format!("7\n{}$EndElementData\n", rows.concat()), "{version:?}");
        let read = msh::read(&bytes).expect("a mesh");
        assert_eq!(read.mesh, mesh);
    }
}

#[test]
fn faces_beside_tetrahedra_are_read_in_every_form() {
    let dir = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).expect(name);
    let path = dir.path().join("a.ele");
    write("a.node", "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n");
    write("a.ele", "1 4\n1 1 2 3 4\n");
    assert_eq!(io::read_mesh_file(&path).expect("no faces").mesh.faces, []);
    let face = |corners, marker| BoundaryFace { corners, marker, tet: 0 };
    let beyond = "tetrahedra of triangles are not read";
    let quadratic = "of 1 triangles of higher order the corners alone are read";
    let lost = "1 triangles that are faces of no tetrahedron are not read";
    for (text, expected, notes) in [
        ("2 1 # a comment\n1 1 3 2 -5\n2 2 3 4 9\n", boundary(), vec![]),
        ("2 1\n0 1 2 3 -5\n1 2 3 4 9\n", boundary(), vec![]),
        ("1 0\n1 1 3 2\n", vec![face([0, 2, 1], 0)], vec![]),
        ("1\n1 1 3 2\n", vec![face([0, 2, 1], 0)], vec![]),
        ("1 1\n1 1 3 2 7 1 -1\n", vec![face([0, 2, 1], 7)], vec![beyond]),
        ("1 1\n1 1 3 2 4 4 4 7\n", vec![face([0, 2, 1], 7)], vec![quadratic]),
        ("2 1\n1 1 3 2 4\n2 1 1 2 4\n", vec![face([0, 2, 1], 4)], vec![lost]),
        ("0 1\n", vec![], vec![]),
    ] {
        write("a.face", text);
        let file = io::read_mesh_file(&path).expect(text);
        assert_eq!(file.mesh.faces, expected, "{text}");
        assert_eq!(file.notes, notes, "{text}");
    }
    for (text, said) in [
        ("", "line 1: no header"),
        ("1 2\n", "line 1: not supported: 2 markers for each triangle"),
        ("1 1 1\n", "line 1: not supported: a header of more than two values"),
        ("2 1\n1 1 2 3 4\n", "line 3: the file announces 2 triangles, but ends after 1"),
        (
            "18446744073709551615 1\n",
            "line 2: the file announces 18446744073709551615 triangles, \
                                      but ends after 0",
        ),
        ("1 1\n1 1 2 3 4\n2 1 2 3 4\n", "line 3: unexpected data after the last triangle"),
        ("1 1\n1 1 2 5 4\n", "line 2: triangle 1 names point 5, but points are numbered 1 to 4"),
        ("1 1\n1 1 2 0 4\n", "line 2: triangle 1 names point 0, but points are numbered 1 to 4"),
        ("2 1\n1 1 2 3 4\n3 1 2 3 4\n", "line 3: triangle number 3, where 2 was expected"),
        ("1 1\n1 1 2 3\n", "line 2: expected 5 values, found 4"),
        ("1 1\n1 1 2 3 4 5\n", "line 2: expected 5 values, found more"),
        ("2 1\n1 1 2 3 4\n2 1 2 3\n", "line 3: expected 5 values, found 4"),
        ("1 1\n1 1 2 3 x\n", "line 2: `x` is not an integer that fits"),
    ] {
        write("a.face", text);
        let error = io::read_mesh_file(&path).expect_err(text).to_string();
        assert!(error.ends_with(&format!("a.face: {said}")), "{text}: {error}");
    }
    std::fs::remove_file(dir.path().join("a.face")).expect("removed");
    std::fs::create_dir(dir.path().join("a.face")).expect("a folder");
    assert_eq!(io::read_mesh_file(&path).expect_err("a folder").code(), "io.read");
}

/// A `.face` file that is there is read with the mesh: it must not be that of another.
#[test]
fn faces_of_another_mesh_do_not_stay() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("a.ele");
    io::write_mesh(&path, &walled()).expect("written");
    io::write_mesh(&path, &corner()).expect("written");
    let file = io::read_mesh_file(&path).expect("a mesh");
    assert_eq!((file.mesh, file.notes), (corner(), vec![]));
    let text = std::fs::read_to_string(dir.path().join("a.face")).expect("a text");
    assert_eq!(text, "0 1\n");
}

#[test]
fn figures_and_faces_must_be_of_the_mesh() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("a.vtu");
    let reason = |mesh: &TetMesh, values: &[Array]| match io::MeshWriter::new(mesh)
        .values(values)
        .write(&path)
    {
        Err(IoError::Data { reason, .. }) => reason,
        other => panic!("{other:?}"),
    };
    let error = reason(&corner(), &[Array { name: "volume", values: vec![1.0, 2.0] }]);
    assert_eq!(error, DataError::Tags { what: "tetrahedra", tags: 2, count: 1 });
    for wrong in [
        BoundaryFace { corners: [0, 1, 4], marker: 0, tet: 0 },
        BoundaryFace { corners: [0, 1, 2], marker: 0, tet: 1 },
    ] {
        let faces = [boundary(), vec![wrong]].concat();
        assert_eq!(reason(&TetMesh { faces, ..corner() }, &[]), DataError::Face { face: 2 });
    }
    assert!(!path.exists());
}

/// Files that were there before stay, in files of one part and of several.
#[test]
fn a_cancelled_mesh_is_not_written() {
    let dir = tempfile::tempdir().expect("a folder");
    let mesh = TetMesh { tets: vec![[0, 1, 2, 3]; 200_000], tet_tags: None, ..bounded() };
    let token = CancelToken::new();
    for (name, is_there) in [("a.vtu", false), ("a.msh", true), ("a.ele", false), ("a.vtk", true)] {
        let path = dir.path().join(name);
        if is_there {
            std::fs::write(&path, "old").expect("written");
        }
        token.cancel();
        let error = io::MeshWriter::new(&mesh).cancel(&token).write(&path).expect_err("cancelled");
        assert!(matches!(&error, IoError::Cancelled { path: p } if *p == path), "{error}");
        assert_eq!(error.code(), "io.cancelled");
        assert_eq!(std::fs::read(&path).ok(), is_there.then(|| b"old".to_vec()), "{name}");
    }
    assert_eq!(std::fs::read_dir(dir.path()).expect("a folder").count(), 2);
    let path = dir.path().join("b.mesh");
    io::MeshWriter::new(&bounded()).cancel(&CancelToken::new()).write(&path).expect("written");
    assert_eq!(io::read_mesh(&path).expect("a mesh"), bounded());
}

#[test]
fn figures_of_tetrahedra_have_names() {
    let TetMesh { points, tets, .. } = corner();
    let arrays = quality::arrays(&points, &tets);
    let one = |name: &str| {
        let Array { values, .. } = arrays.iter().find(|a| a.name == name).expect("a figure");
        assert_eq!(values.len(), 1, "{name}");
        values[0]
    };
    // Circumradius sqrt(3)/2, shortest edge 1; three right angles, three of arccos 1/sqrt(3).
    assert!((one("radius_edge") - 0.75f64.sqrt()).abs() < 1e-15);
    assert!((one("volume") - 1.0 / 6.0).abs() < 1e-15);
    assert!((one("dihedral_min") - (1.0 / 3f64.sqrt()).acos().to_degrees()).abs() < 1e-12);
    assert!((one("dihedral_max") - 90.0).abs() < 1e-12);
    assert_eq!(arrays.len(), 4);
}

#[test]
fn sizes_are_read_and_refused() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("a.mtr");
    let read = |text: &str| {
        std::fs::write(&path, text).expect("written");
        io::read_sizes(&path)
    };
    assert_eq!(read("# three\n3 1\n0.5\n1e-3 # fine\n\n2\n").expect("sizes"), [0.5, 1e-3, 2.0]);
    assert_eq!(read("0 1\n").expect("no sizes"), []);
    let says = |text: &str| match read(text) {
        Err(IoError::Parse { error, .. }) => error.to_string(),
        other => panic!("{other:?}"),
    };
    assert!(says("1 2\n1 2\n").contains("2 values for a point; only one is understood"));
    assert_eq!(says("1 1\nx\n"), "line 2: `x` is not a number");
    assert_eq!(says("1 1\n1 2\n"), "line 2: expected 1 values, found more");
    assert_eq!(says("1 1\n1\n2\n"), "line 3: unexpected data after the last size");
    assert!(says("2 1\n1\n").contains("2 sizes"), "{}", says("2 1\n1\n"));
    assert!(matches!(io::read_sizes(dir.path().join("none")), Err(IoError::Read { .. })));
}

/// A medium that takes `room` bytes and is full then.
struct Medium {
    room: usize,
}

impl Write for Medium {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match self.room.min(bytes.len()) {
            0 if !bytes.is_empty() => Err(Error::from(ErrorKind::StorageFull)),
            taken => {
                self.room -= taken;
                Ok(taken)
            }
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Wherever the medium is full, the writer says so; no failure is swallowed.
#[test]
fn a_full_medium_is_an_error_at_every_byte() {
    let mesh = bounded();
    let values = [Array { name: "volume", values: vec![0.5] }];
    let tags = mesh.point_tags.as_deref();
    let (points, mesh) = (&mesh.points, &mesh);
    type Writer<'a> = Box<dyn Fn(&mut dyn Write) -> std::io::Result<()> + 'a>;
    let mut writers: Vec<Writer<'_>> = vec![
        Box::new(|out| npy::write(out, points, tags)),
        Box::new(|out| xyz::write(out, points, tags)),
        Box::new(|out| csv::write(out, points, tags)),
        Box::new(|out| tetgen::write_node(out, points, tags)),
        Box::new(|out| tetgen::write_ele(out, mesh)),
        Box::new(|out| tetgen::write_face(out, &mesh.faces)),
        Box::new(|out| medit::write(out, mesh)),
    ];
    for encoding in [Encoding::Ascii, Encoding::Binary] {
        let values = &values;
        writers.push(Box::new(move |out| vtu::write_with(out, mesh, values, encoding)));
        for version in [MshVersion::V2_2, MshVersion::V4_1] {
            writers.push(Box::new(move |out| msh::write(out, mesh, version, encoding)));
        }
    }
    for (k, write) in writers.iter().enumerate() {
        let mut whole = Vec::new();
        write(&mut whole).expect("room enough");
        for room in 0..whole.len() {
            let error = write(&mut Medium { room }).expect_err("no room");
            assert_eq!(error.kind(), ErrorKind::StorageFull, "writer {k}, {room} bytes");
        }
        write(&mut Medium { room: whole.len() }).expect("just enough");
    }
}
