//! Files that carry the hash of their mesh are read as those without.

use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_formats::{
    Encoding, Format, MeshWriter, MshVersion, WriteOptions, carried_hash, parse_mesh,
};

/// A mesh of one tetrahedron with all kinds of tags.
fn mesh() -> TetMesh {
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let face = BoundaryFace { corners: [0, 2, 1], marker: 0, tet: 0 };
    TetMesh {
        points,
        tets: vec![[0, 1, 2, 3]],
        point_tags: Some(vec![1, 2, 3, 4]),
        tet_tags: Some(vec![7]),
        faces: vec![face],
        ..TetMesh::default()
    }
}

#[test]
fn a_file_with_the_hash_holds_the_same_mesh() {
    let (mesh, hash) = (mesh(), "0123456789abcdef".repeat(4));
    for format in [Format::Vtu, Format::Msh, Format::Vtk, Format::Medit] {
        for encoding in [Encoding::Ascii, Encoding::Binary] {
            for msh_version in [MshVersion::V4_1, MshVersion::V2_2] {
                let options = WriteOptions { encoding, msh_version };
                let bytes = |writer: MeshWriter<'_>| {
                    let mut bytes = Vec::new();
                    writer
                        .options(options)
                        .write_to(&mut bytes, "memory", format)
                        .expect("written");
                    bytes
                };
                let plain = bytes(MeshWriter::new(&mesh));
                let carrying = bytes(MeshWriter::new(&mesh).hash(&hash));
                let read = |bytes: &[u8]| parse_mesh("memory", format, bytes).expect("a mesh");
                assert_eq!(read(&plain), read(&carrying), "{format:?} {options:?}");
                assert_eq!(carried_hash(format, &plain), None);
                let is_carried = matches!(format, Format::Vtu | Format::Msh);
                assert_eq!(carried_hash(format, &carrying), is_carried.then(|| hash.clone()));
                assert_eq!(plain == carrying, !is_carried, "{format:?}");
            }
        }
    }
}
