//! The body of the fuzz target `formats`, here so that `cargo test` replays its corpus.

use ltbw::io::{Encoding, MeshFile, MshVersion, ParseError, PointFile};
use ltbw::io::{csv, medit, msh, npy, obj, off, ply, stl, tetgen, vtu, xyz};
use ltbw::{Point, TetMesh};

/// A reader.
type Read<File> = fn(&[u8]) -> Result<File, ParseError>;

/// The readers of points, in the order of the first byte of an input.
const POINTS: [Read<PointFile>; 8] = [
    npy::read,
    xyz::read,
    csv::read,
    tetgen::read_node,
    ply::read,
    off::read,
    obj::read,
    stl::read,
];

/// The readers of meshes, which follow.
const MESHES: [Read<MeshFile>; 4] = [medit::read, msh::read, vtu::read, tetrahedra];

/// An `.ele` file beside four points.
fn tetrahedra(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    tetgen::read_pair(b"4 3\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n", bytes)
}

/// Reads all but the first byte, which chooses the format. What can be read is written in the
/// formats that keep it, and read again.
///
/// # Panics
/// If a reader panics, gives what is not finite or not there, or if what is written does not read
/// back the same: that is the fuzzer's finding.
pub fn read_any(bytes: &[u8]) {
    let Some((&choice, bytes)) = bytes.split_first() else { return };
    let choice = usize::from(choice) % (POINTS.len() + MESHES.len());
    if let Some(read) = POINTS.get(choice) {
        match read(bytes) {
            Ok(file) => points_come_back(&file),
            Err(error) => assert!(!error.to_string().contains('\n'), "{error:?}"),
        }
    } else {
        match MESHES[choice - POINTS.len()](bytes) {
            Ok(file) => mesh_comes_back(&file.mesh),
            Err(error) => assert!(!error.to_string().contains('\n'), "{error:?}"),
        }
    }
}

fn bits(points: &[Point]) -> Vec<[u64; 3]> {
    points.iter().map(|p| p.map(f64::to_bits)).collect()
}

fn points_come_back(file: &PointFile) {
    assert!(file.points.iter().flatten().all(|c| c.is_finite()));
    let tags = file.point_tags.as_deref();
    assert!(tags.is_none_or(|t| t.len() == file.points.len()));
    let mut out = Vec::new();
    csv::write(&mut out, &file.points, tags).expect("memory");
    let back = csv::read(&out).expect("we wrote it");
    assert_eq!((bits(&back.points), &back.point_tags), (bits(&file.points), &file.point_tags));
    for encoding in [Encoding::Ascii, Encoding::Binary] {
        let mut out = Vec::new();
        // Tags may be no doubles.
        if ply::write(&mut out, &file.points, tags, encoding).is_ok() {
            let back = ply::read(&out).expect("we wrote it");
            let want = (bits(&file.points), &file.point_tags);
            assert_eq!((bits(&back.points), &back.point_tags), want);
        }
    }
}

fn mesh_comes_back(mesh: &TetMesh) {
    assert!(mesh.points.iter().flatten().all(|c| c.is_finite()));
    assert!(mesh.tets.iter().flatten().all(|&v| (v as usize) < mesh.points.len()));
    assert!(mesh.tet_tags.as_ref().is_none_or(|t| t.len() == mesh.tets.len()));
    assert!(mesh.point_tags.as_ref().is_none_or(|t| t.len() == mesh.points.len()));
    let same = |back: Result<MeshFile, ParseError>| {
        let back = back.expect("we wrote it").mesh;
        assert_eq!(bits(&back.points), bits(&mesh.points));
        assert_eq!(back.tets, mesh.tets);
        assert_eq!(back.point_tags, mesh.point_tags);
        assert_eq!(back.tet_tags, mesh.tet_tags);
    };
    let mut out = Vec::new();
    medit::write(&mut out, mesh).expect("memory");
    same(medit::read(&out));
    for encoding in [Encoding::Ascii, Encoding::Binary] {
        let mut out = Vec::new();
        vtu::write(&mut out, mesh, encoding).expect("memory");
        same(vtu::read(&out));
        for version in [MshVersion::V4_1, MshVersion::V2_2] {
            let mut out = Vec::new();
            // Tags may be no doubles.
            if msh::write(&mut out, mesh, version, encoding).is_ok() {
                same(msh::read(&out));
            }
        }
    }
}
