//! The file formats, by the extensions of their files, and the choices that they leave.

use super::IoError;
use std::path::Path;

/// A file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// NumPy array.
    Npy,
    /// NumPy arrays in a ZIP archive. As points: read only.
    Npz,
    /// Coordinates separated by blanks.
    Xyz,
    /// Coordinates separated by blanks or commas, as `numpy.savetxt` writes them.
    Txt,
    /// Comma- or semicolon-separated columns.
    Csv,
    /// Stanford polygons.
    Ply,
    /// Geomview objects. As points: read only.
    Off,
    /// Wavefront objects. As points: read only.
    Obj,
    /// Triangles for stereolithography. As points: read only.
    Stl,
    /// TetGen domain.
    Poly,
    /// TetGen domain of simple facets.
    Smesh,
    /// TetGen points.
    Node,
    /// TetGen tetrahedra, beside a `.node` file.
    Ele,
    /// Medit ASCII mesh.
    Medit,
    /// Gmsh mesh.
    Msh,
    /// VTK unstructured grid.
    Vtu,
    /// VTK unstructured grid in pieces, `.vtu` files beside the list of them.
    Pvtu,
    /// VTK legacy file: an unstructured grid, or a surface.
    Vtk,
}

/// Extensions of files of CAD systems.
const CAD: [&str; 6] = ["step", "stp", "iges", "igs", "brep", "sldprt"];

impl Format {
    /// Every format.
    pub const ALL: [Format; 18] = [
        Format::Npy,
        Format::Npz,
        Format::Xyz,
        Format::Txt,
        Format::Csv,
        Format::Ply,
        Format::Off,
        Format::Obj,
        Format::Stl,
        Format::Poly,
        Format::Smesh,
        Format::Node,
        Format::Ele,
        Format::Medit,
        Format::Msh,
        Format::Vtu,
        Format::Pvtu,
        Format::Vtk,
    ];

    /// The format that the extension of `path` names; upper and lower case are the same.
    pub fn from_path(path: &Path) -> Result<Self, IoError> {
        let extension = path.extension().unwrap_or_default();
        Self::ALL.into_iter().find(|f| extension.eq_ignore_ascii_case(f.extension())).ok_or_else(
            || {
                let is_cad = CAD.into_iter().any(|cad| extension.eq_ignore_ascii_case(cad));
                let path = path.to_owned();
                if is_cad { IoError::Cad { path } } else { IoError::UnknownFormat { path } }
            },
        )
    }

    /// Its extension, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Npy => "npy",
            Format::Npz => "npz",
            Format::Xyz => "xyz",
            Format::Txt => "txt",
            Format::Csv => "csv",
            Format::Ply => "ply",
            Format::Off => "off",
            Format::Obj => "obj",
            Format::Stl => "stl",
            Format::Poly => "poly",
            Format::Smesh => "smesh",
            Format::Node => "node",
            Format::Ele => "ele",
            Format::Medit => "mesh",
            Format::Msh => "msh",
            Format::Vtu => "vtu",
            Format::Pvtu => "pvtu",
            Format::Vtk => "vtk",
        }
    }

    /// Whether a file of this format can hold points alone.
    pub fn holds_points(self) -> bool {
        self.is_read_only()
            || matches!(
                self,
                Format::Npy | Format::Xyz | Format::Txt | Format::Csv | Format::Ply | Format::Node
            )
    }

    /// Whether a file of this format (with its companion) can hold a mesh.
    pub fn holds_mesh(self) -> bool {
        matches!(
            self,
            Format::Node
                | Format::Ele
                | Format::Medit
                | Format::Msh
                | Format::Vtu
                | Format::Pvtu
                | Format::Vtk
        )
    }

    /// Whether a file of this format can hold a domain.
    pub fn holds_domain(self) -> bool {
        matches!(self, Format::Poly | Format::Smesh) || self.holds_surface()
    }

    /// Whether a file of this format can hold a surface: a domain of polygons alone, without
    /// points that say where holes and regions are. Its facets are oriented.
    pub fn holds_surface(self) -> bool {
        matches!(self, Format::Off | Format::Obj | Format::Stl | Format::Ply | Format::Vtk)
    }

    /// Whether points are read from files of this format, but not written to them.
    pub fn is_read_only(self) -> bool {
        matches!(self, Format::Npz | Format::Off | Format::Obj | Format::Stl)
    }

    /// Whether names of regions and of markers survive in this format.
    pub fn holds_names(self) -> bool {
        matches!(self, Format::Msh | Format::Vtu)
    }

    /// Whether attributes of regions survive in this format.
    pub fn holds_attributes(self) -> bool {
        matches!(self, Format::Node | Format::Ele | Format::Vtu | Format::Pvtu | Format::Vtk)
    }

    /// Whether point tags survive in this format.
    pub fn holds_point_tags(self) -> bool {
        !self.is_read_only() && !matches!(self, Format::Npy | Format::Xyz | Format::Txt)
    }
}

/// The encoding of numbers where a format knows text and binary.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Binary, little endian.
    #[default]
    Binary,
    /// Text.
    Ascii,
}

/// The versions of `.msh` that are read and written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum MshVersion {
    /// 4.1, since Gmsh 4.2 of 2019.
    #[default]
    V4_1,
    /// 2.2, which many programs that read Gmsh's files ask for.
    V2_2,
}
/// Choices that some formats leave to the writer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct WriteOptions {
    /// Text or binary numbers, in `.ply`, `.msh`, `.vtu` and `.vtk`.
    pub encoding: Encoding,
    /// Which version of `.msh`.
    pub msh_version: MshVersion,
}
