//! `.pvtu`: a mesh in several parts, each a `.vtu` file of its own beside it.
//!
//! `m.pvtu` lists `m_0.vtu`, `m_1.vtu` and so on; ParaView opens it as one mesh. A part has the
//! points of its own tetrahedra, so that a point at the boundary between parts is in several, each
//! time under its number in the whole, `GlobalPointIds`. The array `worker` of cells, `Int32`, is
//! the number of the part; the others are those of `.vtu`, as far as all parts have them.
//!
//! A process with all parts calls [`write_parts`]; one with a part of its own [`write_part`], and
//! the first of them [`write_list`]: the files get their names when all are there.
//! Source: the VTK file formats page of the VTK documentation.

use super::atomic_file::{self, AtomicFile, Needs};
use super::error::DataError;
use super::{IoError, check_mesh, data_error, vtu};
use ltbw_core::{CancelToken, TetMesh};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Does the extension of `path` say that it lists parts?
pub fn is_parts(path: impl AsRef<Path>) -> bool {
    let path = path.as_ref();
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("pvtu"))
}

/// The files that [`write_parts`] writes for `path`: the list, then its parts.
pub fn part_files(path: impl AsRef<Path>, parts: usize) -> Vec<PathBuf> {
    let path = path.as_ref();
    let stem = path.file_stem().unwrap_or_default().to_os_string();
    let part = |k| {
        let mut name = stem.clone();
        name.push(format!("_{k}.vtu"));
        path.with_file_name(name)
    };
    std::iter::once(path.to_owned()).chain((0..parts).map(part)).collect()
}

/// Tells what would certainly keep [`write_parts`] from writing. Creates nothing.
///
/// # Errors
/// [`IoError`]: an extension that is not `.pvtu`, a missing folder, something that is not a file.
pub fn check_parts_writable(path: impl AsRef<Path>, parts: usize) -> Result<(), IoError> {
    let path = path.as_ref();
    if !is_parts(path) {
        return Err(IoError::UnknownFormat { path: path.to_owned() });
    }
    part_files(path, parts).iter().try_for_each(|file| atomic_file::check(file))
}

/// A part of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Its tetrahedra with their points.
    pub mesh: TetMesh,
    /// For each point its number in the whole mesh.
    pub numbers: Vec<u32>,
}

/// The place of a part among all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartOf {
    /// Its number, from 0.
    pub part: usize,
    /// Number of parts.
    pub of: usize,
}

/// The arrays that all parts have, beside those that every part has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Arrays {
    /// `tag` of points.
    pub tags: bool,
    /// `region` of cells.
    pub regions: bool,
    /// `marker` of cells.
    pub markers: bool,
    /// `attribute` of cells.
    pub attributes: bool,
}

impl Arrays {
    fn of(parts: &[Piece]) -> Self {
        let all =
            |has: fn(&TetMesh) -> bool| !parts.is_empty() && parts.iter().all(|p| has(&p.mesh));
        Self {
            tags: all(|mesh| mesh.point_tags.is_some()),
            regions: all(|mesh| mesh.tet_tags.is_some()),
            markers: all(|mesh| !mesh.faces.is_empty()),
            attributes: all(|mesh| mesh.tet_attributes.is_some()),
        }
    }
}

/// A file that is complete, and has its name not yet. Dropping it removes it.
pub struct Unnamed(AtomicFile);

impl Unnamed {
    /// Gives it its name, replacing what had it.
    ///
    /// # Errors
    /// [`IoError`] if the system does not let it.
    pub fn publish(self) -> Result<(), IoError> {
        self.0.publish()
    }
}

/// Writes one part of a mesh in parts, until the token says otherwise.
///
/// # Errors
/// [`IoError`] if the part is not a mesh, or the file cannot be written.
pub fn write_part(
    path: impl AsRef<Path>,
    PartOf { part, of }: PartOf,
    piece: &Piece,
    cancel: &CancelToken,
) -> Result<Unnamed, IoError> {
    let files = part_files(path, of);
    let Some(name) = files.get(part + 1) else {
        return Err(IoError::UnknownFormat { path: files[0].clone() });
    };
    check_mesh(&piece.mesh).map_err(|r| data_error(name, r))?;
    let (tags, count) = (piece.numbers.len(), piece.mesh.points.len());
    if tags != count {
        return Err(data_error(name, DataError::Tags { what: "points", tags, count }));
    }
    let fill = |out: &mut dyn Write| vtu::write_part(out, &piece.mesh, &piece.numbers, part as i32);
    AtomicFile::write_until(name, Needs::until(cancel), fill).map(Unnamed)
}

/// Writes the list of all parts.
///
/// # Errors
/// [`IoError`] if the file cannot be written.
pub fn write_list(
    path: impl AsRef<Path>,
    parts: usize,
    arrays: Arrays,
) -> Result<Unnamed, IoError> {
    let files = part_files(path, parts);
    AtomicFile::write(&files[0], |out| list(out, &files[1..], arrays)).map(Unnamed)
}

/// Writes a mesh in parts. All or none of the files get their names, as far as the system lets.
///
/// # Errors
/// [`IoError`] if a part is not a mesh, or a file cannot be written.
pub fn write_parts(path: impl AsRef<Path>, parts: &[Piece]) -> Result<(), IoError> {
    write_parts_until(path, parts, &CancelToken::new())
}

/// Writes a mesh as [`write_parts`] does, until the token says otherwise: no file gets its name
/// then.
///
/// # Errors
/// As [`write_parts`], and [`IoError::Cancelled`].
pub fn write_parts_until(
    path: impl AsRef<Path>,
    parts: &[Piece],
    cancel: &CancelToken,
) -> Result<(), IoError> {
    let (path, of) = (path.as_ref(), parts.len());
    check_parts_writable(path, of)?;
    let pieces = parts.iter().enumerate();
    let written = pieces.map(|(part, piece)| write_part(path, PartOf { part, of }, piece, cancel));
    let mut written: Vec<Unnamed> = written.collect::<Result<_, _>>()?;
    written.push(write_list(path, of, Arrays::of(parts))?);
    // The first of them looks at the token; after it all get their names.
    let mut written = written.into_iter();
    written.next().map_or(Ok(()), |first| first.0.publish_unless(cancel))?;
    written.try_for_each(Unnamed::publish)
}

fn list(out: &mut dyn Write, names: &[PathBuf], arrays: Arrays) -> std::io::Result<()> {
    let (scalars, tag) = match arrays.tags {
        true => (" Scalars=\"tag\"", "<PDataArray type=\"Int64\" Name=\"tag\"/>\n"),
        false => ("", ""),
    };
    write!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n\
         <PUnstructuredGrid GhostLevel=\"0\">\n\
         <PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n\
         </PPoints>\n\
         <PPointData{scalars} GlobalIds=\"GlobalPointIds\">\n{tag}\
         <PDataArray type=\"Int64\" IdType=\"1\" Name=\"GlobalPointIds\"/>\n</PPointData>\n"
    )?;
    out.write_all(b"<PCellData>\n")?;
    let arrays = [
        ("Int64", "region", arrays.regions),
        ("Int64", "marker", arrays.markers),
        ("Float64", "attribute", arrays.attributes),
        ("Int32", "worker", true),
    ];
    for (kind, name, _) in arrays.iter().filter(|array| array.2) {
        writeln!(out, "<PDataArray type=\"{kind}\" Name=\"{name}\"/>")?;
    }
    out.write_all(b"</PCellData>\n")?;
    for name in names {
        let name = name.file_name().unwrap_or_default().to_string_lossy();
        let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        writeln!(out, "<Piece Source=\"{name}\"/>")?;
    }
    out.write_all(b"</PUnstructuredGrid>\n</VTKFile>\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_named_after_the_list() {
        let files = part_files(Path::new("a/m.x.pvtu"), 2);
        let names: Vec<_> = files.iter().map(|f| f.to_string_lossy().into_owned()).collect();
        assert_eq!(names, ["a/m.x.pvtu", "a/m.x_0.vtu", "a/m.x_1.vtu"]);
    }

    #[test]
    fn parts_are_written_and_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a&b.pvtu");
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mesh = TetMesh {
            points: corners.to_vec(),
            tets: vec![[0, 1, 2, 3]],
            point_tags: Some(vec![1, 2, 3, 4]),
            ..TetMesh::default()
        };
        let part = Piece { mesh: mesh.clone(), numbers: vec![7, 9, 8, 1 << 31] };
        let none = TetMesh { point_tags: Some(Vec::new()), ..TetMesh::default() };
        let empty = Piece { mesh: none, numbers: Vec::new() };
        write_parts(&path, &[part.clone(), empty.clone()]).expect("written");
        let list = std::fs::read_to_string(&path).expect("a list");
        assert!(list.contains("<Piece Source=\"a&amp;b_0.vtu\"/>"), "{list}");
        assert!(list.contains("Name=\"tag\""), "{list}");
        assert!(list.contains("<PDataArray type=\"Int32\" Name=\"worker\"/>"), "{list}");
        // The last array of the second part: one number of four bytes for each tetrahedron.
        let second = folder.path().join("c_1.vtu");
        write_parts(folder.path().join("c.pvtu"), &[empty.clone(), part.clone()]).expect("written");
        let bytes = std::fs::read(&second).expect("a part");
        let end = bytes.windows(16).rposition(|w| w == b"\n</AppendedData>").expect("an end");
        assert_eq!(bytes[end - 12..end], [4, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
        let read = |name| crate::read_mesh(folder.path().join(name)).expect("a part");
        assert_eq!(read("a&b_0.vtu"), mesh);
        assert_eq!(read("a&b_1.vtu").tets, empty.mesh.tets);
        // The numbers stand after the tags, whose last one is 4.
        let ids = [4_i64, 32, 7, 9, 8, 1 << 31].map(i64::to_le_bytes).concat();
        assert!(bytes.windows(ids.len()).any(|window| window == ids), "the numbers of points");
        let head = String::from_utf8_lossy(&bytes);
        let section = "<PointData Scalars=\"tag\" GlobalIds=\"GlobalPointIds\">";
        let array = "<DataArray type=\"Int64\" IdType=\"1\" Name=\"GlobalPointIds\" format=";
        assert!(head.contains(section) && head.contains(array), "{head}");
        assert!(list.contains("<PDataArray type=\"Int64\" IdType=\"1\" Name=\"GlobalPointIds\"/>"));
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let refused = |name: &str, parts: &[Piece]| {
            write_parts(folder.path().join(name), parts).expect_err("refused")
        };
        assert!(matches!(refused("m.vtu", &[]), IoError::UnknownFormat { .. }));
        let broken = TetMesh { tets: vec![[0, 1, 2, 3]], ..TetMesh::default() };
        refused("m.pvtu", &[Piece { mesh: broken, numbers: Vec::new() }]);
        refused("m.pvtu", &[Piece { mesh: TetMesh::default(), numbers: vec![0] }]);
        std::fs::create_dir(folder.path().join("n_0.vtu")).expect("a folder");
        refused("n.pvtu", &[Piece::default()]);
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }

    #[test]
    fn a_list_without_room_is_an_error_at_every_byte() {
        let names = [PathBuf::from("m_0.vtu"), PathBuf::from("m_1.vtu")];
        let tagged = TetMesh {
            point_tags: Some(Vec::new()),
            tet_tags: Some(Vec::new()),
            tet_attributes: Some(Vec::new()),
            ..TetMesh::default()
        };
        let [none, tagged] =
            [TetMesh::default(), tagged].map(|mesh| Piece { mesh, numbers: Vec::new() });
        for (parts, has_all) in [([none, tagged.clone()], false), ([tagged.clone(), tagged], true)]
        {
            let arrays = Arrays::of(&parts);
            let mut whole = Vec::new();
            list(&mut whole, &names, arrays).expect("room enough");
            let text = String::from_utf8(whole.clone()).expect("text");
            for name in ["tag", "region", "attribute"] {
                assert_eq!(text.contains(&format!("Name=\"{name}\"")), has_all, "{name}");
            }
            assert!(text.contains("Name=\"worker\"") && !text.contains("Name=\"marker\""));
            for room in 0..whole.len() {
                let mut medium = vec![0; room];
                let error = list(&mut medium.as_mut_slice(), &names, arrays);
                assert_eq!(error.expect_err("no room").kind(), std::io::ErrorKind::WriteZero);
            }
        }
    }
}
