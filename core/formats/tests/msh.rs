//! `.msh`: files as others write them, the form in which regions are written, malformed input.

use ltbw_core::TetMesh;
use ltbw_formats::{Encoding, MshVersion, msh};

const ENCODINGS: [Encoding; 2] = [Encoding::Binary, Encoding::Ascii];
const VERSIONS: [MshVersion; 2] = [MshVersion::V4_1, MshVersion::V2_2];

/// Numbers of nodes with gaps, two volumes (the first in two groups), triangles, a view that is
/// not known, and element numbers out of turn.
const V4: &str = "$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
1
3 7 \"rock $\"
$EndPhysicalNames
$Entities
1 0 1 2
5 0 0 0 0
6 0 0 0 1 1 1 1 9 1 5
1 0 0 0 1 1 1 2 7 8 1 6
2 0 0 0 1 1 1 0 0
$EndEntities
$Nodes
2 5 1 90
0 5 0 1
90
0 0 0
3 1 1 4
20
1
3
4
1 0 0 .5 .5 .5
0 1 0 .5 .5 .5
0 0 1 .5 .5 .5
1 1 1.5 .5 .5 .5
$EndNodes
$Elements
3 4 1 9
2 6 2 1
1 20 1 3
3 2 4 1
9 20 1 3 4
3 1 4 2
3 90 20 1 3
2 90 1 20 3
$EndElements
$NodeData
1
\"speed\"
1
0
3
0
1
1
1 5
$EndNodeData
";

#[test]
fn version_4_as_gmsh_writes_it() {
    let file = msh::read(V4.as_bytes()).unwrap();
    let mesh = file.mesh;
    assert_eq!(mesh.points.len(), 5);
    assert_eq!(mesh.points[4], [1.0, 1.0, 1.5]);
    // By number: 2, 3, 9.
    assert_eq!(mesh.tets, [[0, 2, 1, 3], [0, 1, 2, 3], [1, 2, 3, 4]]);
    assert_eq!(mesh.tet_tags, Some(vec![7, 7, 0]));
    assert_eq!(mesh.point_tags, None);
    assert_eq!(mesh.faces.len(), 1, "{:?}", mesh.faces);
    assert_eq!(file.notes.len(), 2, "{:?}", file.notes);
    let name = &file.names[0];
    assert_eq!((file.names.len(), name.dimension, name.group), (1, 3, 7), "{name:?}");
    // Without groups the two volumes are regions.
    let plain = V4.replace("1 0 0 0 1 1 1 2 7 8 1 6", "1 0 0 0 1 1 1 0 0");
    assert_eq!(msh::read(plain.as_bytes()).unwrap().mesh.tet_tags, Some(vec![1, 1, 2]));
}

const V2: &str = "$MeshFormat\r
2.2 0 8\r
$EndMeshFormat\r
$Nodes\r
4\r
1 0 0 0\r
2 1 0 0\r
4 0 1 0\r
3 0 0 1\r
$EndNodes\r
$Elements\r
3\r
1 2 2 9 1 1 2 3\r
2 4 4 5 1 1 1 1 2 4 3\r
3 4 0 1 2 3 4\r
$EndElements\r
$ElementData\r
1\r
region\r
0\r
3\r
0\r
1\r
2\r
2 -3\r
3 4.0\r
$EndElementData\r
";

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

#[test]
fn version_2_as_gmsh_writes_it() {
    let file = msh::read(V2.as_bytes()).unwrap();
    assert_eq!(file.mesh.tets, [[0, 1, 2, 3], [0, 1, 3, 2]]);
    assert_eq!(file.mesh.tet_tags, Some(vec![-3, 4]));
    let triangle = &file.mesh.faces[0];
    assert_eq!((triangle.marker, triangle.tet), (9, 0), "{triangle:?}");
    assert_eq!(sorted(triangle.corners), [0, 1, 3]);
    assert_eq!(file.notes, Vec::<String>::new());
    // The view comes before the groups, but only if it is integers.
    let half = msh::read(V2.replace("4.0", "4.5").as_bytes()).unwrap();
    assert_eq!(half.mesh.tet_tags, Some(vec![5, 0]));
    assert_eq!(half.notes.len(), 1);
}

fn square(tags: &[i64]) -> TetMesh {
    TetMesh {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]],
        tets: [[0, 1, 2, 3], [1, 2, 3, 4], [3, 2, 1, 0], [4, 3, 2, 1]][..tags.len()].to_vec(),
        point_tags: None,
        tet_tags: Some(tags.to_vec()),
        ..TetMesh::default()
    }
}

fn written(mesh: &TetMesh, version: MshVersion, encoding: Encoding) -> Vec<u8> {
    let mut out = Vec::new();
    msh::write(&mut out, mesh, version, encoding).expect("tags fit");
    out
}

#[test]
fn regions_are_groups_where_gmsh_allows_it() {
    let cases: [(&[i64], bool); 4] = [
        (&[7, 3, 7, i64::from(i32::MAX)], false),
        (&[0, 3], true),
        (&[-1, 3], true),
        (&[1 << 31], true),
    ];
    for version in VERSIONS {
        for (tags, view) in cases {
            let text = String::from_utf8(written(&square(tags), version, Encoding::Ascii)).unwrap();
            assert_eq!(text.contains("$ElementData"), view, "{tags:?}");
            assert_eq!(msh::read(text.as_bytes()).unwrap().mesh, square(tags));
        }
    }
    for encoding in ENCODINGS {
        let error = msh::write(&mut Vec::new(), &square(&[i64::MAX]), VERSIONS[0], encoding);
        assert_eq!(
            error.unwrap_err().to_string(),
            "tetrahedron 0 has the tag 9223372036854775807, which this format cannot hold exactly"
        );
    }
}

#[test]
fn big_endian_files() {
    let mut bytes = b"$MeshFormat\n2.2 1 8\n\x00\x00\x00\x01\n$EndMeshFormat\n$Nodes\n4\n".to_vec();
    for (i, p) in square(&[]).points[..4].iter().enumerate() {
        bytes.extend((i as i32 + 1).to_be_bytes());
        p.iter().for_each(|c| bytes.extend(c.to_be_bytes()));
    }
    bytes.extend(b"\n$EndNodes\n$Elements\n2\n");
    // A row of one triangle, one of one tetrahedron with the tags 8 and 1.
    for n in [2, 1, 0, 1, 1, 2, 3, 4, 1, 2, 2, 8, 1, 1, 2, 3, 4_i32] {
        bytes.extend(n.to_be_bytes());
    }
    bytes.extend(b"\n$EndElements\n");
    let file = msh::read(&bytes).unwrap();
    assert_eq!(file.mesh.tets, [[0, 1, 2, 3]]);
    assert_eq!(file.mesh.tet_tags, Some(vec![8]));
}

#[test]
fn malformed() {
    let says = |bytes: &[u8]| msh::read(bytes).expect_err("malformed").to_string();
    let v4 = |from: &str, to: &str| {
        assert!(V4.contains(from), "{from}");
        says(V4.replacen(from, to, 1).as_bytes())
    };
    assert_eq!(says(b""), "line 1: not a Gmsh mesh");
    assert_eq!(
        v4("4.1 0 8", "4.0 0 8"),
        "line 2: not supported: version 4.0; 4.1 and 2.2 are read"
    );
    assert_eq!(v4("4.1 0 8", "4.1 0"), "line 2: expected version, file type and data size");
    assert_eq!(v4("4.1 0 8", "4.1 1 8"), "byte 20: the number that tells the byte order is not 1");
    assert_eq!(
        v4("$EndEntities", "$EndNodes"),
        "line 14: `$EndNodes` where `$EndEntities` was expected"
    );
    assert_eq!(v4("0 1 0 .5", "0 nan 0 .5"), "line 26: `nan` is not a finite number");
    assert_eq!(v4("\n90\n", "\n3\n"), "line 28: two nodes have the number 3");
    assert_eq!(v4("2 5 1 90", "2 6 1 90"), "line 28: 5 nodes, where 6 are announced");
    assert_eq!(
        v4("3 1 1 4\n", "3 1 1 1000000000000000000\n"),
        "line 25: `.5` is not an integer that fits"
    );
    assert_eq!(
        v4("9 20 1 3 4", "9 20 1 3 5"),
        "line 35: element 9 names node 5, which is not there"
    );
    assert_eq!(v4("3 2 4 1", "3 2 5 1"), "line 34: not supported: elements of type 5");
    assert_eq!(v4("3 4 1 9", "3 5 1 9"), "line 38: 4 elements, where 5 are announced");
    assert_eq!(v4("3 4 1 9", "3 -4 1 9"), "line 31: `-4` is not an integer that fits");
    assert_eq!(v4("$Nodes", "$Knots"), "line 15: the file ends inside `$Knots`");
    let cut = &V4[..V4.find("$Elements").unwrap() + 30];
    assert_eq!(says(cut.as_bytes()), "line 33: the file ends inside a section");
    assert_eq!(
        says(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\nhm\n"),
        "line 4: `hm` where a section was expected"
    );
    assert_eq!(
        says(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"),
        "end of file: there is no section `$Nodes`"
    );
    let twice = V2.to_owned() + "$Nodes\n0\n$EndNodes\n";
    assert_eq!(says(twice.as_bytes()), "line 28: not supported: a second section `$Nodes`");
    assert!(says(V2.replacen("$Nodes", "$Elements", 1).as_bytes()).contains("before `$Nodes`"));
    // Counts in binary files: of nodes, of elements in a row.
    for version in VERSIONS {
        let whole = written(&square(&[1, 2]), version, Encoding::Binary);
        for start in 40..whole.len() - 8 {
            let mut bytes = whole.clone();
            bytes[start..start + 8].fill(0xff);
            if let Err(error) = msh::read(&bytes) {
                assert!(error.to_string().len() < 200, "{error}");
            }
            assert!(msh::read(&whole[..start]).is_err(), "{start}");
        }
    }
}

/// A name of an empty group says nothing of the geometrical entity that has its number.
#[test]
fn names_of_groups_do_not_name_entities() {
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"steel\"\n\
                $EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n\
                $EndNodes\n$Elements\n2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 2 1 3 2 5\n$EndElements\n";
    let file = msh::read(text.as_bytes()).unwrap();
    assert_eq!((file.mesh.tet_tags, file.names), (Some(vec![1, 2]), vec![]));
    assert_eq!(file.notes, ["names of physical groups without tetrahedra are not read"]);
}
