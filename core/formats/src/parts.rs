//! Meshes in parts: files that workers write, each its own part.
//!
//! | name | files | what they hold |
//! |---|---|---|
//! | `m.pvtu` | itself, `m_0.vtu`, `m_1.vtu` and so on | a list for ParaView, and the parts |
//! | `m_%.msh` | `m_1.msh`, `m_2.msh` and so on | Gmsh's partitions: [`msh`](crate::msh) |
//! | `m.vtkhdf` | itself | all parts, each with its slabs: [`Slabs`] |
//! | `m.mfem` | `m.000000`, `m.000001` and so on | meshes that MFEM reads together |
//!
//! A part has the points of its own tetrahedra, so that a point at the boundary between parts is in
//! several. In the `.vtu` files of a `.pvtu` each has its number in the input, `GlobalPointIds`;
//! the array `worker` of cells, `Int32`, is the number of the part, and `owner` of points that of
//! the first part which has them; the others are those of `.vtu`, as far as all parts have them.
//!
//! A process with all parts calls [`write_parts`]; one with a part of its own [`write_part`], and
//! the first of them [`write_list`]: the files get their names when all are there.
//! Source: the VTK file formats page of the VTK documentation.

use super::atomic_file::{self, AtomicFile, Needs};
use super::error::DataError;
use super::parted::{
    self, Arrays, Border, Kind, PartOf, PartSizes, Piece, borders, has_list, is_parts, part_file,
    part_files,
};
use super::vtkhdf::Slabs;
use super::{IoError, check_mesh, data_error, msh, vtu, write_error};
use ltbw_core::CancelToken;
use std::fs::OpenOptions;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Tells what would certainly keep [`write_parts`] from writing. Creates nothing.
///
/// # Errors
/// [`IoError`]: a name of no parts, a missing folder, something that is not a file.
pub fn check_parts_writable(path: impl AsRef<Path>, parts: usize) -> Result<(), IoError> {
    let path = path.as_ref();
    if !is_parts(path) {
        return Err(IoError::UnknownFormat { path: path.to_owned() });
    }
    part_files(path, parts).iter().try_for_each(|file| atomic_file::check(file))
}

/// A file that is complete, and has its name not yet. Dropping it removes it.
pub struct Unnamed(AtomicFile);

impl Unnamed {
    /// Where it is until it has its name.
    pub fn aside(&self) -> &Path {
        self.0.aside()
    }

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
/// [`IoError`] if the part is not a mesh, its border is that of another one, or the file cannot
/// hold it or be written.
pub fn write_part(
    path: impl AsRef<Path>,
    place: PartOf,
    piece: &Piece,
    border: &Border,
    cancel: &CancelToken,
) -> Result<Unnamed, IoError> {
    let path = path.as_ref();
    let Some(kind) = Kind::of(path) else {
        return Err(IoError::UnknownFormat { path: path.to_owned() });
    };
    if kind == Kind::Vtkhdf {
        return Err(IoError::UnknownFormat { path: path.to_owned() });
    }
    let name = &part_file(path, place.part);
    check_part(name, piece, border)?;
    match kind {
        Kind::Pvtu | Kind::Vtkhdf => Ok(()),
        Kind::Msh => msh::check_part(border),
        Kind::Mfem => parted::check(border),
    }
    .map_err(|reason| data_error(name, reason))?;
    let fill = |out: &mut dyn Write| match kind {
        Kind::Pvtu | Kind::Vtkhdf => vtu::write_part(out, piece, border, place.part as u32),
        Kind::Msh => msh::write_part(out, piece, border, place),
        Kind::Mfem => parted::write(out, piece, border, place),
    };
    AtomicFile::write_until(name, Needs::until(cancel), fill).map(Unnamed)
}

/// A part, and what it has in common with the others.
#[derive(Clone, Copy, Debug)]
pub struct Bordered<'a> {
    /// The part.
    pub piece: &'a Piece,
    /// Its border.
    pub border: &'a Border,
}

/// Makes sure that a part is a mesh, and the border its own.
fn check_part(name: &Path, piece: &Piece, border: &Border) -> Result<(), IoError> {
    check_mesh(&piece.mesh).map_err(|r| data_error(name, r))?;
    let count = piece.mesh.points.len();
    for tags in [piece.numbers.len(), border.numbers.len()] {
        if tags != count {
            return Err(data_error(name, DataError::Tags { what: "points", tags, count }));
        }
    }
    Ok(())
}

/// Begins a file of which each part has its slabs ([`has_slabs`](crate::has_slabs)): all of
/// them write into it with [`write_slabs`] before it gets its name.
///
/// # Errors
/// [`IoError`] if the file cannot be written.
pub fn begin_slabs(path: impl AsRef<Path>, slabs: &Slabs) -> Result<Unnamed, IoError> {
    let path = path.as_ref();
    let file = AtomicFile::write(path, |out| slabs.write_head(out))?;
    let opened = OpenOptions::new().write(true).open(file.aside());
    let length = opened.and_then(|file| file.set_len(slabs.length()));
    length.map_err(|error| write_error(path, error))?;
    Ok(Unnamed(file))
}

/// Writes the slabs of a part into a file that was begun, where it is until it has the name `path`.
///
/// # Errors
/// [`IoError`] if the part is not a mesh, its border is that of another one, or the file cannot be
/// written.
pub fn write_slabs(
    path: impl AsRef<Path>,
    aside: &Path,
    slabs: &Slabs,
    part: usize,
    own: Bordered<'_>,
) -> Result<(), IoError> {
    let path = path.as_ref();
    let Bordered { piece, border } = own;
    check_part(path, piece, border)?;
    let write = || {
        let file = OpenOptions::new().write(true).open(aside)?;
        let mut out = BufWriter::with_capacity(1 << 20, file);
        slabs.write_slabs(&mut out, part, piece, border)?;
        out.get_ref().sync_all()
    };
    write().map_err(|error| write_error(path, error))
}

/// Writes the list of all parts, where there is one ([`has_list`]).
///
/// # Errors
/// [`IoError`] if the file cannot be written.
pub fn write_list(
    path: impl AsRef<Path>,
    parts: usize,
    arrays: Arrays,
) -> Result<Unnamed, IoError> {
    let path = path.as_ref();
    let names: Vec<PathBuf> = (0..parts).map(|part| part_file(path, part)).collect();
    AtomicFile::write(path, |out| list(out, &names, arrays)).map(Unnamed)
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
    let borders = borders(parts).map_err(|error| data_error(path, error.into()))?;
    if Kind::of(path) == Some(Kind::Vtkhdf) {
        for (piece, border) in parts.iter().zip(&borders) {
            check_part(path, piece, border)?;
        }
        let slabs = Slabs::new(parts.iter().map(PartSizes::of).collect(), Arrays::of(parts));
        let fill = |out: &mut dyn Write| slabs.write(out, parts, &borders);
        let file = AtomicFile::write_until(path, Needs::until(cancel), fill)?;
        return file.publish_unless(cancel);
    }
    let mut written = Vec::with_capacity(of + 1);
    for (part, (piece, border)) in parts.iter().zip(&borders).enumerate() {
        written.push(write_part(path, PartOf { part, of }, piece, border, cancel)?);
    }
    if has_list(path) {
        written.push(write_list(path, of, Arrays::of(parts))?);
    }
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
         <PDataArray type=\"Int64\" IdType=\"1\" Name=\"GlobalPointIds\"/>\n\
         <PDataArray type=\"Int32\" Name=\"owner\"/>\n</PPointData>\n"
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
    use ltbw_core::TetMesh;

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
        let part = Piece { mesh: mesh.clone(), numbers: vec![7, 8, 9, 1 << 31] };
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
        let ids = [4_i64, 32, 7, 8, 9, 1 << 31].map(i64::to_le_bytes).concat();
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
