//! Refusals of readers, and files by their paths: the branches that round trips do not take.

use ltbw_core::TetMesh;
use ltbw_formats as io;
use ltbw_formats::{DataError, ParseError, PointFile, medit, msh, npy, off, ply, stl, tetgen, vtu};
use std::path::Path;

fn says<T: std::fmt::Debug>(result: Result<T, ParseError>) -> String {
    result.expect_err("malformed").to_string()
}

#[test]
fn triangle_files_are_read_by_their_names() {
    let dir = tempfile::tempdir().expect("a folder");
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\n\
                 endloop\nendfacet\n";
    let stl = format!("solid a\n{facet}{facet}endsolid a\n");
    let files = [
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 2 0\n3 0 1 2\n"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n"),
        ("a.STL", stl.as_str()),
    ];
    for (name, text) in files {
        let path = dir.path().join(name);
        std::fs::write(&path, text).expect("a file");
        assert_eq!(io::read_points(&path).expect(name).points, corners, "{name}");
        // The same text cut short is refused with the file's name.
        std::fs::write(&path, &text[..text.len() / 2]).expect("a file");
        match io::read_points(&path) {
            // Half an .obj file is one.
            Ok(file) => assert!(name == "a.obj" && file.points == corners[..2]),
            Err(e) => {
                assert_eq!(e.code(), "io.parse");
                assert!(e.to_string().contains(name), "{e}");
            }
        }
    }
}

#[test]
fn errors_of_files_have_codes() {
    let dir = tempfile::tempdir().expect("a folder");
    let at = |name: &str| dir.path().join(name);
    let code = |result: Result<(), io::IoError>| result.expect_err("refused").code();
    assert_eq!(code(io::read_points(at("a.vtu")).map(drop)), "io.wrong-kind");
    assert_eq!(code(io::read_mesh(at("a.xyz")).map(drop)), "io.wrong-kind");
    assert_eq!(code(io::read_points(at("none.xyz")).map(drop)), "io.read");
    std::fs::create_dir(at("folder.xyz")).expect("a folder");
    let folder = io::read_points(at("folder.xyz"));
    assert!(folder.as_ref().is_err_and(|e| e.to_string().ends_with("not a regular file")));
    assert_eq!(code(folder.map(drop)), "io.read");
    let points = PointFile { points: vec![[0.0, f64::NAN, 0.0]], ..PointFile::default() };
    assert_eq!(code(io::write_points(at("a.xyz"), &points)), "io.data");
    assert_eq!(code(io::write_points(at("a.off"), &PointFile::default())), "io.read-only");
    assert_eq!(code(io::write_points(at("folder.xyz"), &PointFile::default())), "io.write");
    let nowhere = at("missing").join("a.xyz");
    let refused = io::write_points(&nowhere, &PointFile::default());
    // People are shown neither the temporary file's name nor the library's words.
    let text = refused.as_ref().map_err(ToString::to_string).expect_err("refused");
    assert!(!text.contains(".ltbw-") && text.contains("a.xyz: cannot write: "), "{text}");
    assert_eq!(code(refused), "io.write");
    let stream = io::parse_mesh("stdin", io::Format::Ele, b"");
    assert_eq!(code(stream.map(drop)), "io.several-files");
    let apart = io::parse_domain("stdin", io::Format::Poly, b"0 3 0 0\n0 0\n0\n0\n");
    assert_eq!(code(apart.map(drop)), "io.several-files");
    std::fs::write(at("b.xyz"), "1 2\n").expect("a file");
    assert_eq!(code(io::read_points(at("b.xyz")).map(drop)), "io.parse");
}

#[test]
fn bytes_are_written_aside_like_everything_else() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("report");
    io::check_bytes_writable(&path).expect("a free name");
    assert_eq!(std::fs::read_dir(dir.path()).expect("a folder").count(), 0, "checking writes");
    io::write_bytes(&path, b"one").expect("written");
    io::write_bytes(&path, b"two").expect("written again");
    assert_eq!(std::fs::read(&path).expect("a file"), b"two");
    assert_eq!(std::fs::read_dir(dir.path()).expect("a folder").count(), 1);
    assert!(io::check_bytes_writable(dir.path()).is_err());
    assert!(io::check_bytes_writable(path.join("below a file")).is_err());
    assert!(io::write_bytes(path.join("below a file"), b"").is_err());
    assert!(io::check_mesh_writable(path.with_extension("vtu")).is_ok());
    assert!(io::check_mesh_writable(dir.path().join("none").join("a.vtu")).is_err());
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_not_written() {
    assert!(io::write_bytes(Path::new("/dev/null"), b"").is_err());
    assert!(io::check_bytes_writable(Path::new("/dev/null")).is_err());
}

#[test]
fn names_without_a_folder_are_names_here() {
    assert!(io::check_bytes_writable(Path::new("no-such-file-of-this-test")).is_ok());
}

#[test]
fn a_mesh_names_its_files() {
    let names = |name: &str| -> Vec<String> {
        let files = io::mesh_files(Path::new(name));
        files.iter().map(|file| file.to_string_lossy().into_owned()).collect()
    };
    assert_eq!(names("d/a.vtu"), ["d/a.vtu"]);
    assert_eq!(names("d/a.ele"), ["d/a.node", "d/a.ele", "d/a.face"]);
    assert_eq!(names("d/a.NODE"), ["d/a.NODE", "d/a.ele", "d/a.face"]);
    assert_eq!(names("a.unknown"), ["a.unknown"]);
}

#[test]
fn malformed_ply_headers() {
    let read = |header: &str| ply::read(format!("ply\n{header}end_header\n").as_bytes());
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    assert_eq!(
        says(read(&format!("format ascii 1.0\nelement vertex 0\n{xyz}property float x\n"))),
        "line 7: the same property twice"
    );
    assert_eq!(says(read("element vertex 0\n")), "header: there is no line `format`");
    assert_eq!(
        says(read("format ascii 1.0\nelement face 0\nproperty list float int i\n")),
        "line 4: the length of a list is an integer"
    );
}

#[test]
fn ply_numbers_of_every_type() {
    let types = ["char", "uint8", "int16", "ushort", "int", "uint", "uint32", "int64", "uint64"];
    for kind in types {
        let header = format!(
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty {kind} x\nproperty float32 y\n\
             property double z\nend_header\n7 0.5 0.25\n"
        );
        assert_eq!(ply::read(header.as_bytes()).expect(kind).points, [[7.0, 0.5, 0.25]]);
    }
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uint x\n\
                      property uint64 y\nproperty int64 z\nend_header\n"
        .to_vec();
    bytes.extend(u32::MAX.to_le_bytes());
    bytes.extend((1u64 << 63).to_le_bytes());
    bytes.extend((-3i64).to_le_bytes());
    let points = ply::read(&bytes).expect("binary").points;
    assert_eq!(points, [[4294967295.0, 9223372036854775808.0, -3.0]]);
}

#[test]
fn malformed_stl_and_off() {
    let long = "solid\nfacet\nouter loop\nvertex 0 0 0 0\n";
    assert_eq!(says(stl::read(long.as_bytes())), "line 4: expected 4 values, found more");
    assert_eq!(says(off::read(b"OFF\n1 0 0 0\n0 0 0\n")), "line 2: expected 3 values, found more");
}

#[test]
fn malformed_tetgen_headers_and_rows() {
    let node = |text: &str| says(tetgen::read_node(text.as_bytes()));
    assert_eq!(node("1 3 0 0 0\n"), "line 1: expected 4 values, found more");
    assert_eq!(
        node("1 3 0 2\n"),
        "line 1: not supported: 0 attributes and 2 markers for each point"
    );
    let nodes = b"4 3\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n";
    let pair = |ele: &str| tetgen::read_pair(nodes, ele.as_bytes());
    // The last attribute is the region; those before it are numbers that are not kept.
    let file = pair("1 4 2\n0 0 1 2 3 0.125 7\n").expect("two attributes");
    assert_eq!(file.mesh.tet_tags, Some(vec![7]));
    assert_eq!(file.notes, ["attributes of tetrahedra before the last are not read"]);
    let file = pair("2 4 1\n0 0 1 2 3 70\n1 0 1 2 3 90.5\n").expect("an attribute");
    assert_eq!((file.mesh.tet_tags, file.notes.len()), (None, 0));
    assert_eq!(file.mesh.tet_attributes, Some(vec![70.0, 90.5]));
    assert_eq!(says(pair("1 4 1\n0 0 1 2 3 nan\n")), "line 2: `nan` is not a finite number");
    assert_eq!(says(pair("1 4 2\n0 0 1 2 3 x 7\n")), "line 2: `x` is not a number");
    assert_eq!(
        says(pair("1 4\n0 0 1 2 3\n1 0 1 2 3\n")),
        "line 3: unexpected data after the last tetrahedron"
    );
    let quadratic = pair("1 10\n0 0 1 2 3 0 0 0 0 0 0\n").expect("ten corners");
    assert_eq!(quadratic.mesh.tets, [[0, 1, 2, 3]]);
    assert_eq!(quadratic.notes, ["of 1 tetrahedra of higher order the corners alone are read"]);
}

#[test]
fn malformed_medit_ends() {
    let head = "MeshVersionFormatted 2\nDimension 3\n";
    let read = |text: &str| says(medit::read(format!("{head}{text}").as_bytes()));
    assert_eq!(
        read("Vertices 1\n0 0 0 0\nEnd\nmore\n"),
        "line 6: unexpected data after the last section"
    );
    assert_eq!(read("End\n"), "line 3: there is no section `Vertices`");
}

#[test]
fn npy_headers_need_every_key() {
    let header = "{'descr': '<f8', 'fortran_order': False, }\n";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    assert_eq!(says(npy::read(&bytes)), "header: `descr`, `fortran_order` or `shape` is missing");
    // `=`, `|` or nothing: the machine's own byte order.
    for kind in ["=f8", "|f8", "f8"] {
        let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (1, 3)}}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        for c in [1.5f64, -2.0, 1e300] {
            bytes.extend(c.to_ne_bytes());
        }
        assert_eq!(npy::read(&bytes).expect(kind).points, [[1.5, -2.0, 1e300]]);
    }
}

/// A `.vtu` file of two pieces; each argument is put into both, the tags into the first alone.
fn two_pieces(tags: &str, extra: &str) -> String {
    let piece = |tags: &str| {
        format!(
            "<Piece NumberOfPoints='4' NumberOfCells='1'><PointData>{tags}</PointData><Points>\
             <DataArray NumberOfComponents='3' format='ascii'>0 0 0 1 0 0 0 1 0 0 0 1</DataArray>\
             {extra}</Points><Cells><DataArray Name='connectivity' format='ascii'>0 1 2 3\
             </DataArray><DataArray Name='offsets' format='ascii'>4</DataArray><DataArray \
             Name='types' format='ascii'>10</DataArray></Cells></Piece>"
        )
    };
    format!(
        "<VTKFile type='UnstructuredGrid'><UnstructuredGrid>{}{}</UnstructuredGrid></VTKFile>",
        piece(tags),
        piece("")
    )
}

#[test]
fn malformed_vtu_pieces() {
    let says = |text: &str| says(vtu::read(text.as_bytes()));
    let tags = "<DataArray Name='tag' format='ascii'>1 2 3 4</DataArray>";
    assert!(vtu::read(two_pieces("", "").as_bytes()).is_ok());
    assert_eq!(says(&two_pieces(tags, "")), "line 1: only some pieces have tags");
    assert_eq!(says(&two_pieces(&tags.repeat(2), "")), "line 1: the same array twice in a piece");
    let cdata = two_pieces("", "").replace("0 1 2 3", "<![CDATA[0 1 2 3]]>");
    assert_eq!(says(&cdata), "line 1: not supported: CDATA or entities in an array");
    let short = two_pieces("", "").replace("0 0 1</DataArray>", "0 0</DataArray>");
    assert_eq!(says(&short), "line 1: expected 3 values, found 2");
    let tags = tags.replace("1 2 3 4", "1 2 3");
    assert_eq!(
        says(&two_pieces(&tags, "")),
        "line 1: the file announces 4 values in `tag`, but ends after 3"
    );
}

#[test]
fn vtu_counts_and_offsets_are_claims() {
    let says = |text: &str| says(vtu::read(text.as_bytes()));
    let good = two_pieces("", "");
    assert_eq!(
        says(&good.replace("0 1 2 3", "0 1 2 3 0 1 2 3").replace(">4<", ">4 8<")),
        "line 1: 2 values in `offsets`, where 1 are announced"
    );
    let appended = good
        .replacen(
            "NumberOfComponents='3' format='ascii'",
            "NumberOfComponents='3' type='Float64' format='appended' offset='99'",
            1,
        )
        .replace("</VTKFile>", "<AppendedData encoding='raw'>_abc</AppendedData></VTKFile>");
    assert_eq!(
        says(&appended),
        "line 1: the file announces 99 bytes of appended data, but ends after 28"
    );
}

/// Gmsh's numbers of element types with the nodes of each ("MSH file format").
const GMSH_TYPES: [(u32, usize); 22] = [
    (15, 1),
    (1, 2),
    (8, 3),
    (26, 4),
    (27, 5),
    (28, 6),
    (2, 3),
    (3, 4),
    (9, 6),
    (10, 9),
    (16, 8),
    (20, 9),
    (21, 10),
    (22, 12),
    (23, 15),
    (24, 15),
    (25, 21),
    (4, 4),
    (11, 10),
    (29, 20),
    (30, 35),
    (31, 56),
];

#[test]
fn gmsh_elements_have_their_numbers_of_nodes() {
    let file = |kind: u32, nodes: usize| {
        let names: Vec<String> = (0..nodes).map(|n| (n % 4 + 1).to_string()).collect();
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n\
             4 0 0 1\n$EndNodes\n$Elements\n2\n1 4 0 1 2 3 4\n2 {kind} 0 {}\n$EndElements\n",
            names.join(" ")
        )
    };
    for (kind, nodes) in GMSH_TYPES {
        let read = msh::read(file(kind, nodes).as_bytes());
        let found = read.unwrap_or_else(|e| panic!("type {kind}: {e}"));
        let tets = if matches!(kind, 4 | 11 | 29..=31) { 2 } else { 1 };
        assert_eq!(found.mesh.tets, vec![[0, 1, 2, 3]; tets], "type {kind}");
        let triangles = usize::from(matches!(kind, 2 | 9 | 20..=25));
        assert_eq!(found.mesh.faces.len(), triangles, "type {kind}");
        // Of the plain ones everything is read.
        let notes = usize::from(!matches!(kind, 2 | 4));
        assert_eq!(found.notes.len(), notes, "type {kind}: {:?}", found.notes);
        for wrong in [nodes - 1, nodes + 1] {
            assert!(msh::read(file(kind, wrong).as_bytes()).is_err(), "type {kind}, {wrong} nodes");
        }
    }
    for kind in [5, 6, 7, 12, 92] {
        let error = says(msh::read(file(kind, 8).as_bytes()));
        assert_eq!(error, format!("line 14: not supported: elements of type {kind}"));
    }
}

#[test]
fn malformed_gmsh_heads_and_views() {
    assert_eq!(
        says(msh::read(b"$MeshFormat\n4.1 1 7\n")),
        "line 2: not supported: a data size of 7"
    );
    let empty = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n0\n$EndNodes\n$Elements\n0\n\
                 $EndElements\n";
    let view = "$NodeData\n1\n\"tag\"\n1\n0\n1\n0\n$EndNodeData\n";
    assert!(msh::read(empty.as_bytes()).is_ok());
    let error = says(msh::read([empty, view].concat().as_bytes()));
    assert!(error.ends_with(": a view without its number of values"), "{error}");
}

#[test]
fn tags_must_be_as_many_as_points() {
    let dir = tempfile::tempdir().expect("a folder");
    let mesh = TetMesh { points: vec![[0.0; 3]], point_tags: Some(vec![]), ..TetMesh::default() };
    match io::write_mesh(dir.path().join("a.vtu"), &mesh) {
        Err(io::IoError::Data { reason: DataError::Tags { tags: 0, count: 1, .. }, .. }) => {}
        other => panic!("{other:?}"),
    }
}
