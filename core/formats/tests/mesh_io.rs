//! File formats: round trips on bits, and what each reader says of malformed input.

use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_formats as io;
use ltbw_formats::{
    DataError, Encoding, Format, IoError, MeshFile, MshVersion, ParseError, PointFile,
    WriteOptions, csv, medit, msh, npy, npz, tetgen, txt, vtu, xyz,
};
use proptest::prelude::*;
use std::path::Path;

use crate::strategies::{bits, float_tags, meshes, points};

type ReadPoints = fn(&[u8]) -> Result<PointFile, ParseError>;

const POINT_FORMATS: [Format; 5] =
    [Format::Npy, Format::Xyz, Format::Txt, Format::Csv, Format::Node];
const MESH_FORMATS: [Format; 4] = [Format::Ele, Format::Medit, Format::Msh, Format::Vtu];

/// Every choice that the formats leave.
const OPTIONS: [WriteOptions; 4] = [
    WriteOptions { encoding: Encoding::Binary, msh_version: MshVersion::V4_1 },
    WriteOptions { encoding: Encoding::Binary, msh_version: MshVersion::V2_2 },
    WriteOptions { encoding: Encoding::Ascii, msh_version: MshVersion::V4_1 },
    WriteOptions { encoding: Encoding::Ascii, msh_version: MshVersion::V2_2 },
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn points_survive_on_bits(points in points(), seed in any::<i64>(), tagged in any::<bool>()) {
        let dir = tempfile::tempdir().unwrap();
        let point_tags = tagged.then(|| (0..points.len() as i64).map(|i| seed ^ i).collect());
        let file = PointFile { points, point_tags, notes: Vec::new() };
        for format in POINT_FORMATS {
            let path = dir.path().join("a").with_extension(format.extension());
            io::write_points(&path, &file).unwrap();
            let back = io::read_points(&path).unwrap();
            prop_assert_eq!(bits(&back.points), bits(&file.points), "{:?}", format);
            if format.holds_point_tags() {
                prop_assert_eq!(&back.point_tags, &file.point_tags, "{:?}", format);
            }
            prop_assert!(back.notes.is_empty());
        }
    }

    #[test]
    fn meshes_survive_on_bits(mut mesh in meshes(), regions in 0..3_u8) {
        let dir = tempfile::tempdir().unwrap();
        // Any region, none but 0, or a few as Gmsh has them.
        let region = |t: i64| match regions {
            0 => t,
            1 => 0,
            _ => (t & 3) + 1,
        };
        mesh.tet_tags = mesh.tet_tags.map(|tags| tags.into_iter().map(region).collect());
        mesh.point_tags = mesh.point_tags.map(|tags| tags.into_iter().map(region).collect());
        for format in MESH_FORMATS {
            let path = dir.path().join("a").with_extension(format.extension());
            let mut want = mesh.clone();
            if format == Format::Msh && regions == 0 {
                want.point_tags = float_tags(&want.point_tags);
                want.tet_tags = float_tags(&want.tet_tags);
            }
            for options in OPTIONS {
                io::write_mesh_with(&path, &want, options).unwrap();
                let file = io::read_mesh_file(&path).unwrap();
                let back = file.mesh;
                prop_assert_eq!(bits(&back.points), bits(&want.points), "{:?}", (format, options));
                prop_assert_eq!(&back.tets, &want.tets, "{:?}", (format, options));
                prop_assert_eq!(&back.point_tags, &want.point_tags, "{:?}", (format, options));
                prop_assert_eq!(&back.tet_tags, &want.tet_tags, "{:?}", (format, options));
                prop_assert!(file.notes.is_empty(), "{:?}", file.notes);
            }
        }
        // The `.node` beside the `.ele` names the same mesh.
        prop_assert_eq!(io::read_mesh(dir.path().join("a.node")).unwrap().tets, mesh.tets);
    }

    /// Cutting, flipping and overwriting bytes of a valid file gives a mesh or an error, never a
    /// panic, and an error is one line.
    #[test]
    fn damaged_files_are_errors_of_one_line(
        mesh in meshes(),
        cut in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let points = &mesh.points;
        let tags = mesh.point_tags.as_deref();
        let file = |write: &dyn Fn(&mut Vec<u8>)| {
            let mut out = Vec::new();
            write(&mut out);
            if out.is_empty() {
                return out;
            }
            let i = at.index(out.len());
            out[i] = byte;
            let keep = cut.index(2 * out.len());
            out.truncate(keep);
            out
        };
        let mut errors: Vec<Option<ParseError>> = Vec::new();
        errors.push(npy::read(&file(&|o| npy::write(o, points, None).unwrap())).err());
        errors.push(xyz::read(&file(&|o| xyz::write(o, points, None).unwrap())).err());
        errors.push(csv::read(&file(&|o| csv::write(o, points, tags).unwrap())).err());
        let node = file(&|o| tetgen::write_node(o, points, tags).unwrap());
        errors.push(tetgen::read_node(&node).err());
        let ele = file(&|o| tetgen::write_ele(o, &mesh).unwrap());
        let mut whole = Vec::new();
        tetgen::write_node(&mut whole, points, tags).unwrap();
        errors.push(tetgen::read_pair(&whole, &ele).err());
        let corners = mesh.tets.iter().map(|&[a, b, c, _]| [a, b, c]);
        let faces: Vec<BoundaryFace> =
            corners.map(|corners| BoundaryFace { corners, marker: 1, tet: 0 }).collect();
        let face = file(&|o| tetgen::write_face(o, &faces).unwrap());
        let beside = MeshFile { mesh: mesh.clone(), ..MeshFile::default() };
        errors.push(tetgen::parse_face(&face, beside, 0).err());
        errors.push(medit::read(&file(&|o| medit::write(o, &mesh).unwrap())).err());
        let mut msh = mesh.clone();
        msh.point_tags = float_tags(&msh.point_tags);
        msh.tet_tags = float_tags(&msh.tet_tags);
        for WriteOptions { encoding, msh_version } in OPTIONS {
            let bytes = file(&|o| msh::write(o, &msh, msh_version, encoding).unwrap());
            errors.push(msh::read(&bytes).err());
            errors.push(vtu::read(&file(&|o| vtu::write(o, &mesh, encoding).unwrap())).err());
        }
        for e in errors.into_iter().flatten() {
            let text = e.to_string();
            prop_assert!(!text.contains('\n'), "{text:?}");
            prop_assert!(text.len() < 300, "{text:?}");
        }
    }

    #[test]
    fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        for read in
            [npy::read as ReadPoints, npz::read, xyz::read, txt::read, csv::read, tetgen::read_node]
        {
            let _ = read(&bytes);
        }
        let _ = (medit::read(&bytes), msh::read(&bytes), vtu::read(&bytes));
        let _ = tetgen::read_pair(&bytes, &bytes);
        let _ = tetgen::read_pair(b"1 3\n1 0 0 0\n", &bytes);
        let _ = tetgen::parse_face(&bytes, MeshFile::default(), 1);
    }
}

/// The error that a reader answers with.
fn says<T: std::fmt::Debug>(result: Result<T, ParseError>) -> String {
    result.expect_err("malformed input").to_string()
}

#[test]
fn malformed_xyz() {
    assert_eq!(says(xyz::read(b"0 0 0\n\n1 2\n")), "line 3: expected 3 values, found 2");
    assert_eq!(says(xyz::read(b"1 2 NaN")), "line 1: `NaN` is not a finite number");
    assert_eq!(says(xyz::read(b"1 2 -inf")), "line 1: `-inf` is not a finite number");
    assert_eq!(says(xyz::read(b"1 2 1e999")), "line 1: `1e999` is not a finite number");
    assert_eq!(says(xyz::read(b"# c\nx y z")), "line 2: `x` is not a number");
    assert_eq!(
        says(xyz::read(b"\x00\xff\xfe junk")),
        "line 1: `?\u{fffd}\u{fffd}` is not a number"
    );
    assert_eq!(xyz::read(b"1 2 3 9 9\n").unwrap().notes.len(), 1);
    let long = says(xyz::read(&[b'z'; 5000]));
    assert!(long.len() < 100, "{long}");
}

#[test]
fn malformed_csv() {
    assert_eq!(says(csv::read(b"x,y,z\n1,2,3\n1,2\n")), "line 3: expected 3 values, found 2");
    assert_eq!(says(csv::read(b"1,2,3\n1,,3\n")), "line 2: `` is not a number");
    assert_eq!(says(csv::read(b"x,y,z\n1,2,inf\n")), "line 2: `inf` is not a finite number");
    assert_eq!(says(csv::read(b"garbage\n")), "line 1: `garbage` is not a number");
    assert_eq!(
        says(csv::read(b"x,y,z,tag\n1,2,3,1.5\n")),
        "line 2: `1.5` is not an integer that fits"
    );
}

#[test]
fn malformed_npy() {
    let mut whole = Vec::new();
    npy::write(&mut whole, &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], None).unwrap();
    let short = &whole[..whole.len() - 1];
    assert_eq!(
        says(npy::read(short)),
        "end of file: the file announces 2 points, but ends after 1"
    );
    let mut long = whole.clone();
    long.push(0);
    assert_eq!(says(npy::read(&long)), "end of file: unexpected data after the last point");
    let mut nan = whole.clone();
    let last = nan.len() - 8;
    nan[last..].copy_from_slice(&f64::NAN.to_le_bytes());
    assert_eq!(says(npy::read(&nan)), "point 1: `NaN` is not a finite number");
    assert_eq!(says(npy::read(b"PK\x03\x04")), "header: not a NumPy file");
    assert_eq!(says(npy::read(&whole[..30])), "header: the file ends inside the header");
    let edit = |from: &str, to: &str| {
        let text: Vec<u8> = whole[..128].to_vec();
        let text = String::from_utf8_lossy(&text[10..]).replacen(from, to, 1);
        let mut out = whole[..8].to_vec();
        out.extend((text.len() as u16).to_le_bytes());
        out.extend(text.as_bytes());
        out.extend(&whole[128..]);
        says(npy::read(&out))
    };
    assert_eq!(edit("(2, 3)", "(3, 2)"), "header: the shape is (3, 2), not (n, 3)");
    assert_eq!(
        edit("(2, 3)", "(1000000000000000000, 3)"),
        "end of file: the file announces 1000000000000000000 points, but ends after 2"
    );
    assert_eq!(
        edit("(2, 3)", "(18446744073709551615, 3)"),
        "end of file: the file announces 18446744073709551615 points, but ends after 2"
    );
    assert!(edit("<f8", "<c16").starts_with("header: not supported: values of type `<c16`"));
    assert_eq!(edit("'shape'", "'shade'"), "header: unknown key `shade`");
}

#[test]
fn malformed_node_and_ele() {
    let node = |text: &str| says(tetgen::read_node(text.as_bytes()));
    assert_eq!(node(""), "line 1: no header");
    assert_eq!(node("2 2 0 0\n"), "line 1: not supported: points in 2 dimensions");
    assert_eq!(
        node("1000000000000000000 3 0 0\n1 0 0 0\n"),
        "line 3: the file announces 1000000000000000000 points, but ends after 1"
    );
    assert_eq!(node("2 3 0 0\n1 0 0 0\n3 0 0 0\n"), "line 3: point number 3, where 2 was expected");
    assert_eq!(node("1 3 1 1\n1 0 0 0 5\n"), "line 2: expected 6 values, found 5");
    assert_eq!(node("1 3\n1 0 0 0 5\n"), "line 2: expected 4 values, found more");
    assert_eq!(node("1 3\n0 0 0 nan\n"), "line 2: `nan` is not a finite number");
    assert_eq!(node("1 3\n0 0 0 0\n1 0 0 0\n"), "line 3: unexpected data after the last point");

    let points =
        "# four\n4 3 1 1 # header\n1 0 0 0 .5 7\n2 1 0 0 .5 8\n3 0 1 0 .5 9\n4 0 0 1 .5 -1";
    let pair = |ele: &str| tetgen::read_pair(points.as_bytes(), ele.as_bytes());
    let mesh = pair("1 4 1\n1 1 2 3 4 2.0\n").unwrap();
    assert_eq!(mesh.mesh.tets, [[0, 1, 2, 3]]);
    assert_eq!(mesh.mesh.point_tags, Some(vec![7, 8, 9, -1]));
    assert_eq!(mesh.mesh.tet_tags, Some(vec![2]));
    assert_eq!(mesh.notes, ["attributes of points are not read"]);
    assert_eq!(pair("1 4 1\n1 1 2 3 4 2.5\n").unwrap().mesh.tet_tags, None);
    assert_eq!(
        says(pair("1 4 0\n1 0 1 2 3\n")),
        "line 2: tetrahedron 1 names point 0, but points are numbered 1 to 4"
    );
    assert_eq!(
        says(pair("1 5 0\n")),
        "line 1: not supported: 5 corners and 0 attributes for each tetrahedron"
    );
    assert_eq!(says(pair("1 4\n1 1 2 3\n")), "line 2: expected 5 values, found 4");
    assert_eq!(
        says(pair("99999999999 4\n")),
        "line 2: the file announces 99999999999 tetrahedra, but ends after 0"
    );
}

#[test]
fn malformed_medit() {
    let head = "MeshVersionFormatted 2\nDimension 3\n";
    let read = |text: &str| medit::read(format!("{head}{text}").as_bytes());
    assert_eq!(says(read("Vertices 1\n0 0 0 0\n")), "line 4: the file ends without `End`");
    assert_eq!(
        says(read("Vertices 1000000000000000000\n0 0 0 0\n")),
        "line 4: the file announces 1000000000000000000 vertices, but ends after 1"
    );
    assert_eq!(says(read("Vertices 2\n0 0 0 0\n0 0\n")), "line 5: the file ends inside `Vertices`");
    assert_eq!(says(read("Vertices 1\n0 0 nan 0\nEnd")), "line 4: `nan` is not a finite number");
    assert_eq!(
        says(read("Vertices 1\n0 0 0 0\nTetrahedra\n1\n1 1 1 2 0\nEnd")),
        "line 5: tetrahedron 1 names point 2, but points are numbered 1 to 1"
    );
    assert_eq!(says(read("Hexahedra\n1\n")), "line 3: not supported: this section `Hexahedra`");
    assert_eq!(says(read("17\n")), "line 3: `17` where a keyword was expected");
    assert_eq!(says(medit::read(b"Dimension 2")), "line 1: not supported: points in 2 dimensions");
    let other = read("Vertices 1\n0 0 0 3\nTriangles 1\n1 1 1 0\nEnd\n").unwrap();
    assert_eq!(other.notes, ["1 triangles that are faces of no tetrahedron are not read"]);
    assert_eq!(other.mesh.point_tags, Some(vec![3]));
}

/// A `.vtu` file with the given piece attributes and arrays.
fn grid(counts: (&str, &str), coordinates: &str, cells: [&str; 3]) -> Vec<u8> {
    let array = |name: &str, text: &str| {
        format!("<DataArray type='Int64' Name='{name}' format='ascii'>{text}</DataArray>\n")
    };
    format!(
        "<?xml version='1.0'?>\n<VTKFile type='UnstructuredGrid'><UnstructuredGrid>\n\
         <Piece NumberOfPoints='{}' NumberOfCells='{}'>\n\
         <Points><DataArray type='Float64' NumberOfComponents='3' format='ascii'>{}</DataArray>\
         </Points>\n<Cells>\n{}{}{}</Cells></Piece></UnstructuredGrid></VTKFile>",
        counts.0,
        counts.1,
        coordinates,
        array("connectivity", cells[0]),
        array("offsets", cells[1]),
        array("types", cells[2])
    )
    .into_bytes()
}

#[test]
fn malformed_vtu() {
    let xyz = "0 0 0 1 0 0 0 1 0 0 0 1";
    let good = grid(("4", "2"), xyz, ["0 1 2 3 0 1 2", "4 7", "10 5"]);
    let file = vtu::read(&good).unwrap();
    assert_eq!(file.mesh.tets, [[0, 1, 2, 3]]);
    assert_eq!(file.notes, [] as [&str; 0]);
    assert_eq!(file.mesh.faces.len(), 1);
    let line = grid(("4", "2"), xyz, ["0 1 2 3 0 1", "4 6", "10 3"]);
    let note = "cells that are neither tetrahedra nor triangles are not read";
    assert_eq!(vtu::read(&line).unwrap().notes, [note]);
    let says = |counts, xyz, cells| says(vtu::read(&grid(counts, xyz, cells)));
    assert_eq!(
        says(("1000000000000000000", "0"), xyz, ["", "", ""]),
        "line 3: the file announces 1000000000000000000 points, but ends after 4"
    );
    assert_eq!(
        says(("4", "1"), xyz, ["0 1 2 4", "4", "10"]),
        "line 3: cell 0 names point 4, but points are numbered 0 to 3"
    );
    assert_eq!(says(("4", "1"), xyz, ["0 1 2", "3", "10"]), "line 3: cell 0 has 3 corners, not 4");
    assert_eq!(
        says(("4", "1"), xyz, ["0 1 2 3", "9", "10"]),
        "line 3: cell 0 has the offsets (0, 9) in a connectivity of 4 values"
    );
    assert_eq!(
        says(("4", "1"), xyz, ["0 1 2 3", "4", "12"]),
        "line 3: not supported: cell 0 of VTK type 12"
    );
    assert_eq!(says(("4", "0"), "0 0 nan", ["", "", ""]), "line 4: `nan` is not a finite number");
    assert_eq!(says(("-1", "0"), xyz, ["", "", ""]), "line 3: `-1` is not an integer that fits");
    let read = |text: &str| vtu::read(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        read("<VTKFile type='UnstructuredGrid'>"),
        "line 1: the file ends before the end of a VTKFile element"
    );
    assert_eq!(
        read("<VTKFile type='PolyData'/>"),
        "line 1: not supported: a VTK file of type `PolyData`"
    );
    assert_eq!(read("<html></html>"), "line 1: not a VTK file");
    assert!(read("<VTKFile type='UnstructuredGrid'></Piece>").contains("not well-formed XML"));
    let text = String::from_utf8(good).unwrap();
    let appended = text.replace("format='ascii'", "type='Float64' format='appended' offset='0'");
    assert_eq!(read(&appended), "line 4: there is no appended data");
    assert_eq!(
        read(&text.replace("'ascii'", "'morse' type='Int8'")),
        "line 4: not supported: an array in format `morse`"
    );
    assert_eq!(
        read(&text.replace("'ascii'", "'binary' type='no'")),
        "line 4: the file announces 3543485907 bytes of an array, but ends after 5"
    );
    assert_eq!(vtu::read(b"\xff").unwrap_err().to_string(), "line 1: not UTF-8 text");
}

/// VTK writes such elements into arrays.
#[test]
fn text_of_elements_inside_an_array_is_no_value() {
    let key = "<InformationKey name='L2_NORM_RANGE'><Value index='0'>7</Value></InformationKey>\n";
    let xyz = format!("0 0 0 1 0 0 {key} 0 1 0 0 0 1 {key}");
    let file = vtu::read(&grid(("4", "1"), &xyz, ["0 1 2 3", "4", "10"])).unwrap();
    assert_eq!(file.mesh.points.len(), 4);
    assert_eq!(file.mesh.points[2], [0.0, 1.0, 0.0]);
}

#[test]
fn pieces_are_joined() {
    let piece = |tag: i64| {
        format!(
            "<Piece NumberOfPoints='4' NumberOfCells='1'><PointData><DataArray Name='tag' \
             format='ascii'>{tag} 0 0 0</DataArray></PointData><Points><DataArray \
             NumberOfComponents='3' format='ascii'>0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>\
             <Cells><DataArray Name='connectivity' format='ascii'>0 1 2 3</DataArray><DataArray \
             Name='offsets' format='ascii'>4</DataArray><DataArray Name='types' \
             format='ascii'>10</DataArray></Cells></Piece>"
        )
    };
    let text = format!(
        "<VTKFile type='UnstructuredGrid'><UnstructuredGrid>{}{}</UnstructuredGrid></VTKFile>",
        piece(5),
        piece(6)
    );
    let mesh = vtu::read(text.as_bytes()).unwrap().mesh;
    assert_eq!(mesh.tets, [[0, 1, 2, 3], [4, 5, 6, 7]]);
    assert_eq!(mesh.point_tags, Some(vec![5, 0, 0, 0, 6, 0, 0, 0]));
}

#[test]
fn names_of_files() {
    assert_eq!(Format::from_path(Path::new("a/B.VTU")).unwrap(), Format::Vtu);
    for name in ["a", "a.dat", ".npy", "a.npy.gz", ""] {
        let e = Format::from_path(Path::new(name)).unwrap_err();
        assert_eq!(e.code(), "io.unknown-format", "{name}");
        assert!(e.to_string().starts_with(&format!("{name}: unknown extension")));
    }
    let missing = io::read_points(Path::new("no/such.xyz")).unwrap_err().to_string();
    assert!(missing.starts_with("no/such.xyz: cannot read: "), "{missing}");
    let e = io::read_points(Path::new("a.vtu")).unwrap_err();
    assert_eq!(e.to_string(), "a.vtu: this format holds a mesh, but points are wanted");
    assert!(matches!(io::read_mesh(Path::new("a.xyz")), Err(IoError::WrongKind { .. })));
}

#[test]
fn writers_refuse_what_would_not_come_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vtu");
    let mesh =
        TetMesh { points: vec![[0.0; 3]; 4], tets: vec![[0, 1, 2, 4]], ..TetMesh::default() };
    let reason = |mesh: &TetMesh| match io::write_mesh(&path, mesh) {
        Err(IoError::Data { reason, .. }) => reason,
        other => panic!("{other:?}"),
    };
    assert_eq!(reason(&mesh), DataError::Index { tet: 0, point: 4, points: 4 });
    let mesh = TetMesh { point_tags: Some(vec![1]), tets: vec![], ..mesh };
    assert!(matches!(reason(&mesh), DataError::Tags { tags: 1, count: 4, .. }));
    let mesh = TetMesh { points: vec![[0.0, f64::INFINITY, 0.0]], ..TetMesh::default() };
    assert!(matches!(reason(&mesh), DataError::NotFinite { point: 0, .. }));
    assert!(!path.exists());
}

#[test]
fn a_pair_is_written_whole_or_not_at_all() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("a.ele")).unwrap();
    let mesh = TetMesh::default();
    let e = io::write_mesh(dir.path().join("a.node"), &mesh).unwrap_err();
    assert_eq!(e.code(), "io.write");
    assert!(!dir.path().join("a.node").exists());
    assert!(io::check_mesh_writable(dir.path().join("a.node")).is_err());
    assert!(io::check_points_writable(dir.path().join("a.node")).is_ok());
    assert!(io::check_points_writable(dir.path().join("a.vtu")).is_err());
    assert!(io::check_mesh_writable(dir.path().join("a.xyz")).is_err());
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
}
