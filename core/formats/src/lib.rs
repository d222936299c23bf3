//! Readers and writers of point, domain and mesh files.
//!
//! | extension | holds | tags | module |
//! |---|---|---|---|
//! | `.npy` | points (NumPy array of shape (n, 3)) | no | [`npy`] |
//! | `.npz` | points, read only: an array of shape (n, 3) among NumPy arrays | no | [`npz`] |
//! | `.xyz` | points, one on a line | no | [`xyz`] |
//! | `.txt` | points, as `numpy.savetxt` writes them | no | [`txt`] |
//! | `.csv` | points, columns `x,y,z` | column `tag` | [`csv`] |
//! | `.ply` | points (Stanford polygons); a surface | property `tag` | [`ply`] |
//! | `.off` | a surface; points, read only: the vertices | no | [`off`] |
//! | `.obj` | a surface; points, read only: the vertices | no | [`obj`] |
//! | `.stl` | a surface; points, read only: the corners, once each | no | [`stl`] |
//! | `.poly` | domain (TetGen) | facet markers, regions | [`poly`] |
//! | `.smesh` | domain (TetGen), facets of one polygon each | facet markers, regions | [`poly`] |
//! | `.node` | points (TetGen); beside `.ele`: a mesh | markers | [`tetgen`] |
//! | `.ele` | mesh (TetGen), beside `.node` and `.face` | markers, attributes | [`tetgen`] |
//! | `.msh` | mesh (Gmsh 4.1, 2.2) | view `tag`, physical groups | [`msh`] |
//! | `.mesh` | mesh (Medit, ASCII) | references | [`medit`] |
//! | `.vtu` | mesh (VTK, text or binary) | arrays `tag`, `region`, `attribute` | [`vtu`] |
//! | `.vtk` | mesh, or a surface (VTK's legacy files) | the same | [`vtk`] |
//! | `.pvtu` | mesh in parts, `.vtu` files beside it | the same | [`pvtu`], [`write_parts`] |
//! | `_%.msh` | mesh in parts (Gmsh's partitions) | physical groups | [`msh`], [`write_parts`] |
//! | `.vtkhdf` | mesh in parts (VTK), written only | as `.vtu` | [`Slabs`], [`write_parts`] |
//! | `.mfem` | mesh in parts (MFEM), written only | attributes | [`write_parts`] |
//!
//! Readers take any bytes and never panic: each is a fuzz target. A count in a header is a claim
//! to verify, never an amount of memory to reserve. Text carries floats in the shortest form that
//! reads back to the same bits, so a round trip changes no coordinate, not even the sign of zero.
//! NaN and infinities are rejected, with their place.
//!
//! Writers write aside and rename: under the final name there is the whole file or what was
//! there before.
//!
//! Cost: reading holds the file and the result in memory; a million points of text take about
//! half a second each way. Writing formats in parallel on the current rayon pool.

#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod atomic_file;
mod carried;
pub mod csv;
mod curved;
mod domain;
mod error;
mod faces;
mod format;
mod groups;
pub mod medit;
pub mod msh;
pub mod npy;
pub mod npz;
pub mod obj;
pub mod off;
mod parted;
mod parts;
pub mod ply;
pub mod poly;
pub mod pvtu;
mod scalar;
pub mod slices;
pub mod stl;
mod streams;
mod surface;
pub mod tetgen;
mod text;
pub mod txt;
pub mod vtk;
mod vtkhdf;
pub mod vtu;
mod writer;
mod xml;
pub mod xyz;

use atomic_file::{AtomicFile, Needs};
pub use carried::carried_hash;
pub use domain::{
    check_domain_writable, domain_files, not_kept, read_domain, read_domain_by, write_domain,
    write_domain_until, write_domain_with,
};
pub use error::{BorderError, DataError, IoError, ParseError, Place, Reason};
pub use format::{Encoding, Format, MshVersion, WriteOptions};
use ltbw_core::{BoundaryFace, CancelToken, TetMesh};
use ltbw_domain::{Domain, Given};
use ltbw_exact::Point;
pub use parted::{
    Arrays, Border, Bordering, Common, Ghost, GhostPoint, PartOf, PartSizes, Piece, Words, borders,
    has_list, has_slabs, is_parts, part_files, parts_hold_exterior, parts_hold_tags,
};
pub use parts::{
    Bordered, Unnamed, begin_slabs, check_parts_writable, write_list, write_part, write_parts,
    write_parts_until, write_slabs,
};
use std::io::Write;
use std::path::{Path, PathBuf};
pub use streams::{
    check_domain_stream, check_mesh_stream, check_points_stream, parse_domain, parse_mesh,
    parse_points, write_domain_to, write_points_to,
};
pub use vtkhdf::Slabs;
pub use writer::MeshWriter;

/// Points as files carry them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointFile {
    /// Coordinates, in the order of the file.
    pub points: Vec<Point>,
    /// One tag per point (boundary markers), if the file has them.
    pub point_tags: Option<Vec<i64>>,
    /// The parts of the file that were not read, in words for people.
    pub notes: Vec<String>,
}

/// A mesh as files carry it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshFile {
    /// The mesh; its boundary faces are the triangles of the file that are faces of tetrahedra.
    pub mesh: TetMesh,
    /// Names of regions and of markers of boundary triangles (`.msh`, `.vtu`).
    pub names: Vec<GroupName>,
    /// The parts of the file that were not read, in words for people.
    pub notes: Vec<String>,
}

/// A mesh with a number at each of its points: the field of a solution.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointField {
    /// The mesh.
    pub mesh: TetMesh,
    /// The numbers, in the order of its points.
    pub values: Vec<f64>,
}

/// The name of a group of tetrahedra or of boundary triangles, or of facets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupName {
    /// 3 for tetrahedra, 2 for triangles.
    pub dimension: u8,
    /// The region, or the marker.
    pub group: i64,
    /// The name.
    pub name: String,
}

/// A domain as files carry it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DomainFile {
    /// The domain.
    pub domain: Domain,
    /// The facets are a surface whose orientation says what is inside: formats without hole points.
    pub oriented: bool,
    /// Names of markers of facets, and of the volume, where the file has some: solids of `.stl`,
    /// groups and materials of `.obj`, colours of `.off` and `.ply`.
    pub names: Vec<GroupName>,
    /// The parts of the file that were not read, in words for people.
    pub notes: Vec<String>,
}

impl Given for DomainFile {
    fn domain(&self) -> &Domain {
        &self.domain
    }

    fn is_surface(&self) -> bool {
        self.oriented
    }
}

/// Reads a point file: `.npy`, `.npz`, `.xyz`, `.txt`, `.csv`, `.node`, `.ply`, `.off`, `.obj` or
/// `.stl`.
pub fn read_points(path: impl AsRef<Path>) -> Result<PointFile, IoError> {
    read_points_by(path, &mut load)
}

/// Reads a point file as [`read_points`] does, with bytes that `load` gives.
pub fn read_points_by(path: impl AsRef<Path>, load: &mut Load<'_>) -> Result<PointFile, IoError> {
    let path = path.as_ref();
    let format = Format::from_path(path)?;
    if !format.holds_points() {
        return Err(wrong_kind(path, format, "points are"));
    }
    parse_points(path, format, &load(path)?)
}

/// Reads a mesh file: `.vtu`, `.vtk`, `.msh`, `.mesh`, or the pair `.ele` and `.node` (named by
/// either) with the `.face` file beside it, if there is one; or `.pvtu` with its pieces.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<TetMesh, IoError> {
    let path = path.as_ref();
    read_mesh_file(path).map(|f| f.mesh)
}

/// Reads a mesh file as [`read_mesh`] does, and tells what in it was not read.
pub fn read_mesh_file(path: impl AsRef<Path>) -> Result<MeshFile, IoError> {
    read_mesh_by(path, &mut load)
}

/// A way to the bytes of a file: [`read_bytes`], or one that looks at them, too. A file of several
/// is asked for one after the other.
pub type Load<'a> = dyn FnMut(&Path) -> Result<Vec<u8>, IoError> + 'a;

/// Reads a mesh file as [`read_mesh_file`] does, with bytes that `load` gives.
pub fn read_mesh_by(path: impl AsRef<Path>, load: &mut Load<'_>) -> Result<MeshFile, IoError> {
    let path = path.as_ref();
    match Format::from_path(path)? {
        Format::Node | Format::Ele => read_pair(path, load),
        Format::Pvtu => pvtu::read(path, load),
        Format::Msh if is_parts(path) => msh::read_parts(path, load),
        format if format.holds_mesh() => parse_mesh(path, format, &load(path)?),
        format => Err(wrong_kind(path, format, "a mesh is")),
    }
}

/// Reads edge lengths at points: an `.mtr` file, whatever its extension.
pub fn read_sizes(path: impl AsRef<Path>) -> Result<Vec<f64>, IoError> {
    read_sizes_by(path, &mut load)
}

/// Reads edge lengths as [`read_sizes`] does, with bytes that `load` gives.
pub fn read_sizes_by(path: impl AsRef<Path>, load: &mut Load<'_>) -> Result<Vec<f64>, IoError> {
    let path = path.as_ref();
    tetgen::read_mtr(&load(path)?).map_err(|error| parse_error(path, error))
}

/// Reads a mesh with an array of its points: a `.vtu` file, with bytes that `load` gives. Without a
/// name its only array of points with one float each.
pub fn read_field_by(
    path: impl AsRef<Path>,
    name: Option<&str>,
    load: &mut Load<'_>,
) -> Result<PointField, IoError> {
    let path = path.as_ref();
    vtu::read_field(&load(path)?, name).map_err(|error| parse_error(path, error))
}

fn read_pair(path: &Path, load: &mut Load<'_>) -> Result<MeshFile, IoError> {
    let (node_path, ele_path) = pair(path);
    let face_path = face_path(path);
    let node = tetgen::parse_node(&load(&node_path)?).map_err(|e| parse_error(&node_path, e))?;
    let first = node.first;
    let file = tetgen::parse_ele(&load(&ele_path)?, node).map_err(|e| parse_error(&ele_path, e))?;
    match load(&face_path) {
        Ok(bytes) => {
            tetgen::parse_face(&bytes, file, first).map_err(|e| parse_error(&face_path, e))
        }
        Err(IoError::Read { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
            Ok(file)
        }
        Err(error) => Err(error),
    }
}

/// The `.node` and `.ele` files of the mesh that either of them names.
fn pair(path: &Path) -> (PathBuf, PathBuf) {
    let other = |extension: &str| {
        let own = path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
        if own { path.to_owned() } else { path.with_extension(extension) }
    };
    (other("node"), other("ele"))
}

/// Writes points and their tags with the default [`WriteOptions`].
/// The formats `.npy`, `.xyz` and `.txt` have no place for tags.
pub fn write_points(path: impl AsRef<Path>, file: &PointFile) -> Result<(), IoError> {
    let path = path.as_ref();
    write_points_with(path, file, WriteOptions::default())
}

/// Writes points as [`write_points`] does, with a choice where the format leaves one.
pub fn write_points_with(
    path: impl AsRef<Path>,
    file: &PointFile,
    options: WriteOptions,
) -> Result<(), IoError> {
    write_points_until(path, file, options, &CancelToken::new())
}

/// Writes points as [`write_points_with`] does, until the token says otherwise: the file does not
/// get its name then.
///
/// # Errors
/// As [`write_points_with`], and [`IoError::Cancelled`].
pub fn write_points_until(
    path: impl AsRef<Path>,
    file: &PointFile,
    options: WriteOptions,
    cancel: &CancelToken,
) -> Result<(), IoError> {
    let path = path.as_ref();
    let format = writable(path, true)?;
    streams::points_ready(path, format, file)?;
    let fill = |out: &mut dyn Write| streams::put_points(out, format, file, options);
    AtomicFile::write_until(path, Needs::until(cancel), fill)?.publish_unless(cancel)
}

/// Writes a mesh with its tags and boundary faces, with the default [`WriteOptions`]: `.vtu`,
/// `.vtk`, `.msh`, `.mesh`, or the pair `.ele` and `.node` (named by either) with `.face` beside.
/// [`MeshWriter`] writes figures and names with it.
pub fn write_mesh(path: impl AsRef<Path>, mesh: &TetMesh) -> Result<(), IoError> {
    MeshWriter::new(mesh).write(path)
}

/// Writes a mesh as [`write_mesh`] does, with a choice where the format leaves one.
pub fn write_mesh_with(
    path: impl AsRef<Path>,
    mesh: &TetMesh,
    options: WriteOptions,
) -> Result<(), IoError> {
    MeshWriter::new(mesh).options(options).write(path)
}

/// The format of `path`, if points (or else meshes) can be written in it.
fn writable(path: &Path, points: bool) -> Result<Format, IoError> {
    let format = Format::from_path(path)?;
    // Parts are written by [`write_parts`].
    let whole = format.holds_mesh() && format != Format::Pvtu;
    let holds = if points { format.holds_points() } else { whole };
    if !holds {
        Err(wrong_kind(path, format, if points { "points are" } else { "a mesh is" }))
    } else if format.is_read_only() {
        Err(IoError::ReadOnly { path: path.to_owned() })
    } else {
        Ok(format)
    }
}

/// The `.face` file of the mesh that an `.ele` or `.node` file names.
fn face_path(path: &Path) -> PathBuf {
    path.with_extension("face")
}

/// Tells, before long work starts, what would certainly keep points from being written to
/// `path`: an extension that is unknown or holds no points, a folder that is missing or takes no
/// file, or something under that name that is not a file. Leaves nothing behind.
pub fn check_points_writable(path: impl AsRef<Path>) -> Result<(), IoError> {
    let path = path.as_ref();
    writable(path, true)?;
    atomic_file::check(path)
}

/// Tells what would certainly keep a mesh from being written, as [`check_points_writable`] does
/// for points.
pub fn check_mesh_writable(path: impl AsRef<Path>) -> Result<(), IoError> {
    let path = path.as_ref();
    match writable(path, false)? {
        Format::Node | Format::Ele => {
            let (node, ele) = pair(path);
            atomic_file::check(&node)?;
            atomic_file::check(&ele)?;
            atomic_file::check(&face_path(path))
        }
        _ => atomic_file::check(path),
    }
}

/// Tells what would certainly keep [`write_bytes`] from writing to `path`, whatever its extension.
pub fn check_bytes_writable(path: impl AsRef<Path>) -> Result<(), IoError> {
    let path = path.as_ref();
    atomic_file::check(path)
}

/// The files that [`read_mesh`] may read for `path`, and [`write_mesh`] write: itself, with the
/// pieces that it lists, or the `.node`, `.ele` and `.face` files that it names.
pub fn mesh_files(path: impl AsRef<Path>) -> Vec<PathBuf> {
    let path = path.as_ref();
    match Format::from_path(path) {
        Ok(Format::Node | Format::Ele) => {
            let (node, ele) = pair(path);
            vec![node, ele, face_path(path)]
        }
        Ok(Format::Pvtu) => {
            // A list that cannot be read names no other file.
            let pieces = load(path).ok().and_then(|list| pvtu::piece_files(path, &list).ok());
            std::iter::once(path.to_owned()).chain(pieces.unwrap_or_default()).collect()
        }
        // Each of them says how many there are.
        Ok(Format::Msh) if is_parts(path) => {
            let file = |part: usize| part_files(path, part + 1).pop();
            (0_usize..).map_while(file).take_while(|file| file.exists()).collect()
        }
        _ => vec![path.to_owned()],
    }
}

/// Writes `bytes` to any file the way all files of this module are written: aside, then renamed.
pub fn write_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), IoError> {
    write_with(path, |out| out.write_all(bytes))
}

/// As [`write_bytes`], of bytes that come one after the other: an error of `write` leaves the file
/// as it was.
pub fn write_with(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), IoError> {
    AtomicFile::write(path.as_ref(), |out| write(out))?.publish()
}

/// All bytes of a file, whatever its extension. A folder and a device are refused.
pub fn read_bytes(path: impl AsRef<Path>) -> Result<Vec<u8>, IoError> {
    load(path.as_ref())
}

fn load(path: &Path) -> Result<Vec<u8>, IoError> {
    let read = || {
        // A device may never end; a folder is no file.
        if std::fs::metadata(path)?.is_file() {
            std::fs::read(path)
        } else {
            Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, "not a regular file"))
        }
    };
    read().map_err(|source| IoError::Read { path: path.to_owned(), source })
}

fn check_points(points: &[Point], tags: Option<&[i64]>) -> Result<(), DataError> {
    if let Some(point) = points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        return Err(DataError::NotFinite { point, at: points[point] });
    }
    check_tags("points", tags, points.len())
}

fn check_tags<T>(what: &'static str, tags: Option<&[T]>, count: usize) -> Result<(), DataError> {
    match tags {
        Some(t) if t.len() != count => Err(DataError::Tags { what, tags: t.len(), count }),
        _ => Ok(()),
    }
}

/// Checks that every tag is exactly a double: formats without 64-bit integers carry them so.
fn check_float_tags(what: &'static str, tags: Option<&[i64]>) -> Result<(), DataError> {
    let inexact = |&t: &i64| scalar::exact_float(i128::from(t)).is_err();
    match tags.and_then(|tags| Some((tags, tags.iter().position(inexact)?))) {
        Some((tags, number)) => Err(DataError::TagRange { what, number, tag: tags[number] }),
        None => Ok(()),
    }
}

/// [`check_float_tags`] for writers, which know no path.
fn float_tags(what: &'static str, tags: Option<&[i64]>) -> std::io::Result<()> {
    let invalid = |e| std::io::Error::new(std::io::ErrorKind::InvalidInput, e);
    check_float_tags(what, tags).map_err(invalid)
}

fn check_mesh(mesh: &TetMesh) -> Result<(), DataError> {
    let points = mesh.points.len();
    check_points(&mesh.points, mesh.point_tags.as_deref())?;
    check_tags("tetrahedra", mesh.tet_tags.as_deref(), mesh.tets.len())?;
    let attributes = mesh.tet_attributes.as_deref();
    check_tags("tetrahedra", attributes, mesh.tets.len())?;
    if let Some(tet) = attributes.and_then(|a| a.iter().position(|value| !value.is_finite())) {
        return Err(DataError::Attribute { tet });
    }
    for (tet, corners) in mesh.tets.iter().enumerate() {
        if let Some(&point) = corners.iter().find(|&&v| v as usize >= points) {
            return Err(DataError::Index { tet, point, points });
        }
    }
    let known = |f: &BoundaryFace| {
        f.tet < mesh.tets.len() && f.corners.iter().all(|&corner| (corner as usize) < points)
    };
    match mesh.faces.iter().position(|f| !known(f)) {
        Some(face) => Err(DataError::Face { face }),
        None => Ok(()),
    }
}

fn wrong_kind(path: &Path, format: Format, wanted: &'static str) -> IoError {
    let holds = match (format.holds_mesh(), format.holds_points(), format.holds_domain()) {
        _ if format == Format::Pvtu => "a mesh in parts",
        (_, true, true) => "a surface or points",
        (_, true, false) => "points",
        (true, ..) => "a mesh",
        _ => "a domain",
    };
    IoError::WrongKind { path: path.to_owned(), holds, wanted }
}

fn parse_error(path: &Path, error: ParseError) -> IoError {
    IoError::Parse { path: path.to_owned(), error }
}

fn write_error(path: &Path, source: std::io::Error) -> IoError {
    IoError::Write { path: path.to_owned(), source }
}

fn data_error(path: &Path, reason: DataError) -> IoError {
    IoError::Data { path: path.to_owned(), reason }
}

/// Examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
