//! Groups of faces that surfaces have, and the names of groups that meshes have.

use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_formats::{DomainFile, Encoding, Format, GroupName, MeshWriter, WriteOptions};
use ltbw_formats::{parse_domain, parse_mesh};

fn surface(format: Format, text: &str) -> DomainFile {
    parse_domain("a", format, text.as_bytes()).expect(text)
}

fn markers(file: &DomainFile) -> Vec<i32> {
    file.domain.facets.iter().map(|f| f.marker).collect()
}

/// Dimension, number and name of each name.
fn names(all: &[GroupName]) -> Vec<String> {
    all.iter().map(|n| format!("{} {} {}", n.dimension, n.group, n.name)).collect()
}

fn solid(name: &str, z: u32) -> String {
    format!(
        "solid {name}\nfacet normal 0 0 1\nouter loop\nvertex 0 0 {z}\nvertex 1 0 {z}\n\
         vertex 0 1 {z}\nendloop\nendfacet\nendsolid {name}\n"
    )
}

#[test]
fn solids_of_a_text_are_groups() {
    let file = surface(Format::Stl, &(solid("the top", 1) + &solid("", 0) + &solid("the top", 2)));
    assert_eq!(markers(&file), [1, 2, 1]);
    assert_eq!(names(&file.names), ["2 1 the top", "2 2 solid 2"]);
    let one = surface(Format::Stl, &solid("bracket", 1));
    assert_eq!((markers(&one), names(&one.names)), (vec![0], vec!["3 1 bracket".to_owned()]));
}

#[test]
fn groups_and_materials_of_objects_are_groups() {
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let file = surface(
        Format::Obj,
        &format!("{points}f 1 2 3\ng lid  side\nf 1 2 3\nusemtl steel\nf 1 2 3\no body\nf 1 2 3\n"),
    );
    assert_eq!(markers(&file), [0, 1, 2, 3]);
    assert_eq!(names(&file.names), ["2 1 lid side", "2 2 lid side/steel", "2 3 body/steel"]);
    assert!(file.notes.is_empty(), "{:?}", file.notes);
    let plain = surface(Format::Obj, &format!("{points}usemtl steel\nf 1 2 3\nf 1 2 3\n"));
    assert_eq!(markers(&plain), [0, 0]);
}

#[test]
fn colours_and_numbers_of_faces_are_groups() {
    let points = "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n";
    let file = surface(
        Format::Off,
        &format!("{points}3 0 1 2 255 0 0\n3 0 1 2\n3 0 1 2  255 0 0 # red\n"),
    );
    assert_eq!(
        (markers(&file), names(&file.names)),
        (vec![1, 0, 1], vec!["2 1 colour 255 0 0".into()])
    );
    let ply = |properties: &str, rows: &str| {
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                    property float z\nelement face 2\nproperty list uchar int vertex_indices\n";
        let text = format!("{head}{properties}end_header\n0 0 0\n1 0 0\n0 1 0\n{rows}");
        surface(Format::Ply, &text)
    };
    let colours = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let file = ply(colours, "3 0 1 2 9 8 7\n3 0 1 2 1 2 3\n");
    assert_eq!(names(&file.names), ["2 1 colour 9 8 7", "2 2 colour 1 2 3"]);
    let file =
        ply(&format!("property int label\n{colours}"), "3 0 1 2 5 9 8 7\n3 0 1 2 -4 1 2 3\n");
    assert_eq!(names(&file.names), ["2 1 label 5", "2 2 label -4"]);
    let file = ply("property int marker\nproperty int label\n", "3 0 1 2 5 9\n3 0 1 2 -4 8\n");
    assert_eq!((markers(&file), names(&file.names)), (vec![5, -4], Vec::new()));
}

#[test]
fn names_survive_in_vtu_and_msh() {
    let face = BoundaryFace { corners: [0, 2, 1], marker: 7, tet: 0 };
    let mesh = TetMesh {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        tets: vec![[0, 1, 2, 3]],
        tet_tags: Some(vec![2]),
        faces: vec![face],
        ..TetMesh::default()
    };
    let name = |dimension, group, name: &str| GroupName { dimension, group, name: name.into() };
    let all = [name(2, 7, "in & <out>"), name(3, 2, "steel")];
    for format in [Format::Vtu, Format::Msh] {
        for encoding in [Encoding::Binary, Encoding::Ascii] {
            let options = WriteOptions { encoding, ..WriteOptions::default() };
            let mut bytes = Vec::new();
            let writer = MeshWriter::new(&mesh).names(&all).options(options);
            writer.write_to(&mut bytes, "a", format).expect("memory");
            let file = parse_mesh("a", format, &bytes).expect("a mesh");
            assert_eq!((&file.mesh, &file.names[..], file.notes.len()), (&mesh, &all[..], 0));
        }
    }
    // A volume without a name has one in the file, and none again when it is read.
    let mut bytes = Vec::new();
    let options = WriteOptions { encoding: Encoding::Ascii, ..WriteOptions::default() };
    let writer = MeshWriter::new(&mesh).options(options);
    writer.write_to(&mut bytes, "a", Format::Msh).expect("memory");
    let text = String::from_utf8(bytes.clone()).expect("text");
    assert!(text.contains("$PhysicalNames\n1\n3 2 \"volume 2\"\n$EndPhysicalNames\n"), "{text}");
    assert_eq!(parse_mesh("a", Format::Msh, &bytes).expect("a mesh").names, []);
}

#[test]
fn field_data_that_is_no_name_is_told() {
    let grid = "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"/></UnstructuredGrid></VTKFile>";
    let array = |kind: &str, values: &str| {
        format!(
            "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><FieldData><DataArray \
             type=\"{kind}\" Name=\"a\" NumberOfTuples=\"2\" format=\"ascii\">{values}</DataArray>\
             </FieldData>{grid}"
        )
    };
    for (kind, values, found) in [
        ("Int64", "4 2", 1),
        ("Int32", "4 1", 0),
        ("Int64", "4 2 1", 0),
        ("Int64", "x 2 y z", 0),
        ("Int64", "", 0),
        ("Float64", "4 2", 0),
    ] {
        let file = parse_mesh("a", Format::Vtu, array(kind, values).as_bytes()).expect(values);
        assert_eq!((file.names.len(), file.notes.len()), (found, 1 - found), "{values}");
    }
}
