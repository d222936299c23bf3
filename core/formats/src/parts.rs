//! `.pvtu`: a mesh in several parts, each a `.vtu` file of its own beside it.
//!
//! `m.pvtu` lists `m_0.vtu`, `m_1.vtu` and so on; ParaView opens it as one mesh. A part has the
//! points of its own tetrahedra, so that a point at the boundary between parts is in several. The
//! array `worker` of cells, `Int32`, is the number of the part; the others are those of `.vtu`, as
//! far as all parts have them.
//! Source: the VTK file formats page of the VTK documentation.

use super::atomic_file::{self, AtomicFile, Needs};
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

/// Writes a mesh in parts. All or none of the files get their names, as far as the system lets.
///
/// # Errors
/// [`IoError`] if a part is not a mesh, or a file cannot be written.
pub fn write_parts(path: impl AsRef<Path>, parts: &[TetMesh]) -> Result<(), IoError> {
    write_parts_until(path, parts, &CancelToken::new())
}

/// Writes a mesh as [`write_parts`] does, until the token says otherwise: no file gets its name
/// then.
///
/// # Errors
/// As [`write_parts`], and [`IoError::Cancelled`].
pub fn write_parts_until(
    path: impl AsRef<Path>,
    parts: &[TetMesh],
    cancel: &CancelToken,
) -> Result<(), IoError> {
    let path = path.as_ref();
    check_parts_writable(path, parts.len())?;
    let files = part_files(path, parts.len());
    let (list, names) = files.split_at(1);
    let mut written = Vec::new();
    for (worker, (part, name)) in (0..).zip(parts.iter().zip(names)) {
        check_mesh(part).map_err(|r| data_error(name, r))?;
        let fill = |out: &mut dyn Write| vtu::write_part(out, part, worker);
        written.push(AtomicFile::write_until(name, Needs::until(cancel), fill)?);
    }
    let index = AtomicFile::write(&list[0], |out| write_list(out, names, parts))?;
    // The first of them looks at the token; after it all get their names.
    let mut written = written.into_iter();
    written.next().map_or(Ok(()), |first| first.publish_unless(cancel))?;
    written.try_for_each(AtomicFile::publish)?;
    index.publish()
}

fn write_list(out: &mut dyn Write, names: &[PathBuf], parts: &[TetMesh]) -> std::io::Result<()> {
    let all = |has: fn(&TetMesh) -> bool| !parts.is_empty() && parts.iter().all(has);
    let tagged = all(|part| part.point_tags.is_some());
    out.write_all(
        b"<?xml version=\"1.0\"?>\n\
          <VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
          header_type=\"UInt64\">\n\
          <PUnstructuredGrid GhostLevel=\"0\">\n\
          <PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n\
          </PPoints>\n",
    )?;
    if tagged {
        out.write_all(
            b"<PPointData Scalars=\"tag\">\n<PDataArray type=\"Int64\" Name=\"tag\"/>\n\
              </PPointData>\n",
        )?;
    }
    out.write_all(b"<PCellData>\n")?;
    let arrays = [
        ("Int64", "region", all(|part| part.tet_tags.is_some())),
        ("Int64", "marker", all(|part| !part.faces.is_empty())),
        ("Float64", "attribute", all(|part| part.tet_attributes.is_some())),
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
        let part = TetMesh {
            points: corners.to_vec(),
            tets: vec![[0, 1, 2, 3]],
            point_tags: Some(vec![1, 2, 3, 4]),
            ..TetMesh::default()
        };
        let empty = TetMesh { point_tags: Some(Vec::new()), ..TetMesh::default() };
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
        assert_eq!(read("a&b_0.vtu"), part);
        assert_eq!(read("a&b_1.vtu").tets, empty.tets);
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let refused = |name: &str, parts: &[TetMesh]| {
            write_parts(folder.path().join(name), parts).expect_err("refused")
        };
        assert!(matches!(refused("m.vtu", &[]), IoError::UnknownFormat { .. }));
        let broken = TetMesh { tets: vec![[0, 1, 2, 3]], ..TetMesh::default() };
        refused("m.pvtu", &[broken]);
        std::fs::create_dir(folder.path().join("n_0.vtu")).expect("a folder");
        refused("n.pvtu", &[TetMesh::default()]);
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
        for parts in [[TetMesh::default(), tagged.clone()], [tagged.clone(), tagged]] {
            let mut whole = Vec::new();
            write_list(&mut whole, &names, &parts).expect("room enough");
            let has_all = parts[0].tet_tags.is_some();
            let text = String::from_utf8(whole.clone()).expect("text");
            for name in ["tag", "region", "attribute"] {
                assert_eq!(text.contains(&format!("Name=\"{name}\"")), has_all, "{name}");
            }
            assert!(text.contains("Name=\"worker\"") && !text.contains("Name=\"marker\""));
            for room in 0..whole.len() {
                let mut medium = vec![0; room];
                let error = write_list(&mut medium.as_mut_slice(), &names, &parts);
                assert_eq!(error.expect_err("no room").kind(), std::io::ErrorKind::WriteZero);
            }
        }
    }
}
