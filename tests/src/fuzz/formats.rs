//! `formats`: bytes to a file of any format.
//!
//! The first byte chooses the reader, the others are the file. For several (`.node`, `.ele` and
//! `.face`; `.node` and `.poly`; `.pvtu` and its pieces) they are the one, a line `%`, and the
//! next.

use ltbw::domain::Domain;
use ltbw::io::{DomainFile, Encoding, Format, MeshFile, MshVersion, ParseError, PointFile};
use ltbw::io::{csv, medit, msh, npy, npz, obj, off, ply, poly, pvtu, stl, tetgen, txt};
use ltbw::io::{vtk, vtu, xyz};
use ltbw::{BoundaryFace, Point, TetMesh};

/// A reader.
type Read<File> = fn(&[u8]) -> Result<File, ParseError>;

/// The readers of points, in the order of the first byte of an input.
const POINTS: [(Format, Read<PointFile>); 10] = [
    (Format::Npy, npy::read),
    (Format::Xyz, xyz::read),
    (Format::Csv, csv::read),
    (Format::Node, tetgen::read_node),
    (Format::Ply, ply::read),
    (Format::Off, off::read),
    (Format::Obj, obj::read),
    (Format::Stl, stl::read),
    (Format::Txt, txt::read),
    (Format::Npz, npz::read),
];

/// The readers of meshes, which follow.
const MESHES: [(Format, Read<MeshFile>); 7] = [
    (Format::Medit, medit::read),
    (Format::Msh, msh::read),
    (Format::Vtu, vtu::read),
    (Format::Ele, tetrahedra),
    (Format::Node, pair),
    (Format::Vtk, vtk::read),
    (Format::Pvtu, pieces),
];

/// The readers of domains, the last.
const DOMAINS: [(Format, Read<DomainFile>); 9] = [
    (Format::Poly, poly::read_poly),
    (Format::Smesh, poly::read_smesh),
    (Format::Off, off::read_domain),
    (Format::Obj, obj::read_domain),
    (Format::Stl, stl::read_domain),
    (Format::Ply, ply::read_domain),
    (Format::Poly, node_and_poly),
    (Format::Smesh, node_and_smesh),
    (Format::Vtk, vtk::read_domain),
];

/// An `.ele` file, and perhaps a `.face` file, beside four points.
fn tetrahedra(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    beside(b"4 3\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n", bytes)
}

/// An `.ele` file beside points, and the `.face` file behind it, if there is one.
fn beside(node: &[u8], bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let (ele, face) = halves(bytes);
    let first = tetgen::parse_node(node)?.first;
    let file = tetgen::read_pair(node, ele)?;
    if face.is_empty() { Ok(file) } else { tetgen::parse_face(face, file, first) }
}

/// The bytes before the first line `%`, and those after it.
fn halves(bytes: &[u8]) -> (&[u8], &[u8]) {
    const BETWEEN: &[u8] = b"\n%\n";
    let at = bytes.windows(BETWEEN.len()).position(|w| w == BETWEEN).unwrap_or(bytes.len());
    let (first, rest) = bytes.split_at(at);
    (first, rest.get(BETWEEN.len()..).unwrap_or_default())
}

fn pair(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let (node, others) = halves(bytes);
    beside(node, others)
}

/// A list of pieces, and the pieces in their order, as far as there are any.
fn pieces(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let (list, mut rest) = halves(bytes);
    let mut whole = pvtu::Join::default();
    for _ in pvtu::sources(list)? {
        let (piece, others) = halves(rest);
        whole.add(vtu::read(piece)?)?;
        rest = others;
    }
    Ok(whole.finish())
}

fn node_and_poly(bytes: &[u8]) -> Result<DomainFile, ParseError> {
    let (node, poly) = halves(bytes);
    poly::read_poly_with(poly, tetgen::parse_node(node)?)
}

fn node_and_smesh(bytes: &[u8]) -> Result<DomainFile, ParseError> {
    let (node, smesh) = halves(bytes);
    poly::read_smesh_with(smesh, tetgen::parse_node(node)?)
}

/// The readers of each list that were there when the corpus was begun: they keep their bytes, which
/// are those below `LATER`.
const FIRST: [usize; 3] = [8, 5, 8];
const LATER: usize = 231;

/// The list of readers that a byte chooses (0: points, 1: meshes, 2: domains), and the place in it.
fn reader(byte: u8) -> (usize, usize) {
    let lengths = [POINTS.len(), MESHES.len(), DOMAINS.len()];
    let byte = usize::from(byte);
    let (starts, ends) = match byte < LATER {
        true => ([0; 3], FIRST),
        false => (FIRST, lengths),
    };
    let places = (0..3).flat_map(|list| (starts[list]..ends[list]).map(move |k| (list, k)));
    let places: Vec<(usize, usize)> = places.collect();
    places[byte % LATER % places.len()]
}

/// Reads all but the first byte, which chooses the format. What can be read is written in the
/// formats that keep it, and read again.
///
/// # Panics
/// If a reader panics, gives what is not finite or not there, or if what is written does not read
/// back the same.
pub fn formats(bytes: &[u8]) {
    let Some((&choice, bytes)) = bytes.split_first() else { return };
    let error = match reader(choice) {
        (0, k) => (POINTS[k].1)(bytes).map(|file| points_come_back(&file)).err(),
        (1, k) => (MESHES[k].1)(bytes).map(|file| mesh_comes_back(&file.mesh)).err(),
        (_, k) => (DOMAINS[k].1)(bytes).map(|file| domain_comes_back(&file.domain)).err(),
    };
    if let Some(error) = error {
        assert!(!error.to_string().contains('\n'), "{error:?}");
    }
}

fn bits(points: &[Point]) -> Vec<[u64; 3]> {
    points.iter().map(|p| p.map(f64::to_bits)).collect()
}

fn points_come_back(file: &PointFile) {
    assert!(file.points.iter().flatten().all(|c| c.is_finite()));
    let tags = file.point_tags.as_deref();
    assert!(tags.is_none_or(|t| t.len() == file.points.len()));
    let same = |back: Result<PointFile, ParseError>, tags: &Option<Vec<i64>>| {
        let back = back.expect("we wrote it");
        assert_eq!((bits(&back.points), &back.point_tags), (bits(&file.points), tags));
    };
    let mut out = Vec::new();
    csv::write(&mut out, &file.points, tags).expect("memory");
    same(csv::read(&out), &file.point_tags);
    let mut out = Vec::new();
    tetgen::write_node(&mut out, &file.points, tags).expect("memory");
    same(tetgen::read_node(&out), &file.point_tags);
    // These have no place for tags.
    let mut out = Vec::new();
    npy::write(&mut out, &file.points, tags).expect("memory");
    same(npy::read(&out), &None);
    let mut out = Vec::new();
    xyz::write(&mut out, &file.points, tags).expect("memory");
    same(xyz::read(&out), &None);
    let mut out = Vec::new();
    txt::write(&mut out, &file.points, tags).expect("memory");
    same(txt::read(&out), &None);
    for encoding in [Encoding::Ascii, Encoding::Binary] {
        let mut out = Vec::new();
        // Tags may be no doubles.
        if ply::write(&mut out, &file.points, tags, encoding).is_ok() {
            same(ply::read(&out), &file.point_tags);
        }
    }
}

/// Boundary faces as a set: those of flat tetrahedra have no outer side to turn to.
fn boundary(mesh: &TetMesh) -> Vec<([u32; 3], i64)> {
    let sorted = |face: &BoundaryFace| {
        let mut corners = face.corners;
        corners.sort_unstable();
        (corners, face.marker)
    };
    let mut all: Vec<_> = mesh.faces.iter().map(sorted).collect();
    all.sort_unstable();
    all
}

fn mesh_comes_back(mesh: &TetMesh) {
    assert!(mesh.points.iter().flatten().all(|c| c.is_finite()));
    assert!(mesh.tets.iter().flatten().all(|&v| (v as usize) < mesh.points.len()));
    assert!(mesh.tet_tags.as_ref().is_none_or(|t| t.len() == mesh.tets.len()));
    assert!(mesh.point_tags.as_ref().is_none_or(|t| t.len() == mesh.points.len()));
    let attributes = mesh.tet_attributes.as_ref();
    assert!(attributes.is_none_or(|t| t.len() == mesh.tets.len()));
    assert!(attributes.is_none_or(|t| t.iter().all(|value| value.is_finite())));
    let same = |back: Result<MeshFile, ParseError>| {
        let back = back.expect("we wrote it").mesh;
        assert_eq!(bits(&back.points), bits(&mesh.points));
        assert_eq!(back.tets, mesh.tets);
        assert_eq!(back.point_tags, mesh.point_tags);
        assert_eq!(back.tet_tags, mesh.tet_tags);
        assert_eq!(boundary(&back), boundary(mesh));
    };
    let mut out = Vec::new();
    medit::write(&mut out, mesh).expect("memory");
    same(medit::read(&out));
    let (mut node, mut ele) = (Vec::new(), Vec::new());
    tetgen::write_node(&mut node, &mesh.points, mesh.point_tags.as_deref()).expect("memory");
    // Attributes would take the place of tags.
    let plain = TetMesh { tet_attributes: None, ..mesh.clone() };
    tetgen::write_ele(&mut ele, &plain).expect("memory");
    let mut face = Vec::new();
    tetgen::write_face(&mut face, &mesh.faces).expect("memory");
    let first = tetgen::parse_node(&node).expect("we wrote it").first;
    same(tetgen::read_pair(&node, &ele).and_then(|file| tetgen::parse_face(&face, file, first)));
    for encoding in [Encoding::Ascii, Encoding::Binary] {
        let mut out = Vec::new();
        vtu::write(&mut out, mesh, encoding).expect("memory");
        let back = vtu::read(&out);
        assert_eq!(back.as_ref().expect("we wrote it").mesh.tet_attributes.as_ref(), attributes);
        same(back);
        let mut out = Vec::new();
        vtk::write_with(&mut out, mesh, &[], encoding).expect("memory");
        same(vtk::read(&out));
        for version in [MshVersion::V4_1, MshVersion::V2_2] {
            let mut out = Vec::new();
            // Tags may be no doubles.
            if msh::write(&mut out, mesh, version, encoding).is_ok() {
                same(msh::read(&out));
            }
        }
    }
}

/// Whatever was read has a sound structure or is refused for it, and `.poly` keeps all of it.
fn domain_comes_back(domain: &Domain) {
    if let Err(error) = domain.check_structure() {
        assert!(!error.to_string().contains('\n'), "{error:?}");
        return;
    }
    let mut out = Vec::new();
    poly::write_poly(&mut out, domain).expect("memory");
    let back = poly::read_poly(&out).expect("we wrote it").domain;
    assert_eq!(&back, domain);
    assert_eq!(bits(&back.vertices), bits(&domain.vertices));
    let mut out = Vec::new();
    // A facet may be no single polygon.
    if poly::write_smesh(&mut out, domain).is_ok() {
        assert_eq!(&poly::read_smesh(&out).expect("we wrote it").domain, domain);
    }
}

#[cfg(test)]
mod tests {
    use super::{DOMAINS, Format, MESHES, POINTS, reader};

    #[test]
    fn every_reader_has_a_byte_and_the_first_keep_theirs() {
        let chosen: std::collections::BTreeSet<_> = (0..=255).map(reader).collect();
        assert_eq!(chosen.len(), POINTS.len() + MESHES.len() + DOMAINS.len());
        let first = [0, 7, 8, 12, 13, 20, 21, 230].map(reader);
        assert_eq!(first, [(0, 0), (0, 7), (1, 0), (1, 4), (2, 0), (2, 7), (0, 0), (2, 7)]);
    }

    /// A new format without a reader here would never be fuzzed.
    #[test]
    fn every_extension_has_its_readers() {
        for format in Format::ALL {
            let points = POINTS.iter().any(|(f, _)| *f == format);
            let meshes = MESHES.iter().any(|(f, _)| *f == format);
            let domains = DOMAINS.iter().any(|(f, _)| *f == format);
            assert_eq!(domains, format.holds_domain(), "{format:?}");
            assert_eq!(points, format.holds_points(), "{format:?}");
            assert_eq!(meshes, format.holds_mesh(), "{format:?}");
        }
    }
}
