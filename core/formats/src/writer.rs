//! Meshes on their way to files and streams.

use crate::atomic_file::{AtomicFile, Needs};
use crate::{
    DataError, Format, GroupName, IoError, MeshFile, WriteOptions, check_mesh, check_mesh_stream,
    data_error, face_path, medit, msh, pair, tetgen, vtk, vtu, writable, write_error,
};
use ltbw_core::{CancelToken, TetMesh};
use ltbw_domain::quality::Array;
use std::io::Write;
use std::path::Path;

/// A mesh to be written, and what goes with it.
///
/// The mesh itself has tags, attributes and boundary faces. `.vtu` has a place for all of it, and
/// `.vtk` for all but names; `.mesh` and `.ele` (with `.node` and `.face` beside it) for tags and
/// faces; `.msh` for names, too. An `.ele` file has attributes in place of tags if there are some.
///
/// ```no_run
/// use ltbw_core::TetMesh;
/// use ltbw_domain::quality;
/// use ltbw_formats::{IoError, MeshWriter};
///
/// fn with_quality(mesh: &TetMesh) -> Result<(), IoError> {
///     let figures = quality::arrays(&mesh.points, &mesh.tets);
///     MeshWriter::new(mesh).values(&figures).write("mesh.vtu")
/// }
/// ```
#[derive(Debug, Clone, Copy)]
#[must_use]
pub struct MeshWriter<'a> {
    mesh: &'a TetMesh,
    values: &'a [Array],
    names: &'a [GroupName],
    hash: Option<&'a str>,
    options: WriteOptions,
    cancel: Option<&'a CancelToken>,
}

impl<'a> MeshWriter<'a> {
    /// A mesh with nothing but its own tags and faces, and the default [`WriteOptions`].
    pub fn new(mesh: &'a TetMesh) -> Self {
        let options = WriteOptions::default();
        Self { mesh, values: &[], names: &[], hash: None, options, cancel: None }
    }

    /// Figures of the tetrahedra, such as those of
    /// [`quality::arrays`](ltbw_domain::quality::arrays).
    pub fn values(self, values: &'a [Array]) -> Self {
        Self { values, ..self }
    }

    /// Names of regions and of markers.
    pub fn names(self, names: &'a [GroupName]) -> Self {
        Self { names, ..self }
    }

    /// The canonical hash of the mesh, which `.vtu` and `.msh` files carry:
    /// [`carried_hash`](crate::carried_hash) finds it. It may be that of the inside, of a mesh that
    /// is written with its exterior.
    pub fn hash(self, hash: &'a str) -> Self {
        Self { hash: Some(hash), ..self }
    }

    /// A choice where the format leaves one.
    pub fn options(self, options: WriteOptions) -> Self {
        Self { options, ..self }
    }

    /// A token by which another thread ends the writing of files: none gets its final name then.
    pub fn cancel(self, token: &'a CancelToken) -> Self {
        Self { cancel: Some(token), ..self }
    }

    /// Writes to a file; its extension tells the format.
    ///
    /// # Errors
    /// [`IoError`] with `path`: an extension of no mesh, data that the format cannot hold, a file
    /// that cannot be written, or [`IoError::Cancelled`].
    pub fn write(self, path: impl AsRef<Path>) -> Result<(), IoError> {
        let path = path.as_ref();
        let format = writable(path, false)?;
        self.ready(path, format)?;
        match format {
            Format::Node | Format::Ele => self.write_pair(path),
            _ => {
                let file =
                    AtomicFile::write_until(path, self.needs(), |out| self.put(out, format))?;
                self.still(path)?;
                file.publish()
            }
        }
    }

    /// Writes to a stream in a format of one file; `name` stands in messages only.
    ///
    /// # Errors
    /// [`IoError`] with `name`: a format of several files, data that it cannot hold, or what `out`
    /// says.
    pub fn write_to(
        self,
        out: &mut dyn Write,
        name: impl AsRef<Path>,
        format: Format,
    ) -> Result<(), IoError> {
        let name = name.as_ref();
        check_mesh_stream(name, format)?;
        self.ready(name, format)?;
        self.put(out, format).map_err(|source| write_error(name, source))
    }

    /// The token that ends the writing, and the memory that the lists of a format take: of each
    /// tetrahedron, point and face about as much as the mesh itself has.
    fn needs(&self) -> Needs<'a> {
        let TetMesh { points, tets, faces, .. } = self.mesh;
        let memory = 32 * (points.len() + tets.len()) + 48 * faces.len();
        Needs { cancel: self.cancel, memory }
    }

    /// Was the writing not cancelled?
    fn still(&self, path: &Path) -> Result<(), IoError> {
        match self.cancel.is_some_and(CancelToken::is_cancelled) {
            true => Err(IoError::Cancelled { path: path.to_owned() }),
            false => Ok(()),
        }
    }

    /// Checks that the format can hold the data.
    fn ready(&self, name: &Path, format: Format) -> Result<(), IoError> {
        let tets = self.mesh.tets.len();
        let values = match self.values.iter().find(|array| array.values.len() != tets) {
            Some(Array { values, .. }) => {
                Err(DataError::Tags { what: "tetrahedra", tags: values.len(), count: tets })
            }
            None => Ok(()),
        };
        check_mesh(self.mesh)
            .and(values)
            .and_then(|()| if format == Format::Msh { msh::check(self.mesh) } else { Ok(()) })
            .map_err(|reason| data_error(name, reason))
    }

    /// Writes a mesh for which [`MeshWriter::ready`] had no complaint, in a format of one file.
    fn put(&self, out: &mut dyn Write, format: Format) -> std::io::Result<()> {
        let Self { mesh, values, names, hash, options, .. } = *self;
        match format {
            Format::Msh => msh::write_hashed(out, mesh, names, hash, options),
            Format::Medit => medit::write(out, mesh),
            Format::Vtk => vtk::write_with(out, mesh, values, options.encoding),
            _ => {
                let beside = vtu::Beside { hash, names };
                vtu::write_beside(out, mesh, values, beside, options.encoding)
            }
        }
    }

    /// Writes `.node`, `.ele`, and `.face` where there are boundary faces.
    fn write_pair(&self, path: &Path) -> Result<(), IoError> {
        let mesh = self.mesh;
        let aside = |path: &Path, fill: &dyn Fn(&mut dyn Write) -> std::io::Result<()>| {
            AtomicFile::write_until(path, self.needs(), fill)
        };
        let (node_path, ele_path) = pair(path);
        let ele = aside(&ele_path, &|out| tetgen::write_ele(out, mesh))?;
        let tags = mesh.point_tags.as_deref();
        let node = aside(&node_path, &|out| tetgen::write_node(out, &mesh.points, tags))?;
        let face_path = face_path(path);
        // Faces of another mesh must not stay beside this one.
        let face = match mesh.faces.as_slice() {
            [] if !face_path.exists() => None,
            faces => Some(aside(&face_path, &|out| tetgen::write_face(out, faces))?),
        };
        self.still(path)?;
        node.publish()?;
        // A `.node` of this mesh beside an `.ele` of another would be worse than none.
        ele.publish().inspect_err(|_| drop(std::fs::remove_file(&node_path)))?;
        let published = face.map_or(Ok(()), AtomicFile::publish);
        published.inspect_err(|_| drop(std::fs::remove_file(&face_path)))
    }
}

impl MeshFile {
    /// The mesh to be written as it was read, with the names of its groups.
    pub fn writer(&self) -> MeshWriter<'_> {
        MeshWriter::new(&self.mesh).names(&self.names)
    }
}
