//! Parts of a mesh, and the names of their files.

use ltbw_core::TetMesh;
use std::path::{Path, PathBuf};

/// A part of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Its tetrahedra with their points.
    pub mesh: TetMesh,
    /// For each point its number in the input of the whole mesh, ascending.
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

/// The size of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartSizes {
    /// Points.
    pub points: u64,
    /// Tetrahedra.
    pub tets: u64,
    /// Boundary faces.
    pub faces: u64,
}

impl PartSizes {
    /// The size of this part.
    pub fn of(piece: &Piece) -> Self {
        let TetMesh { points, tets, faces, .. } = &piece.mesh;
        let [points, tets, faces] = [points.len(), tets.len(), faces.len()].map(|n| n as u64);
        Self { points, tets, faces }
    }
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
    pub(crate) fn of(parts: &[Piece]) -> Self {
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

/// The formats of meshes in parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Pvtu,
    Msh,
    Mfem,
    Vtkhdf,
}

impl Kind {
    /// The format that a name asks for.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let is =
            |extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        match () {
            () if is("pvtu") => Some(Self::Pvtu),
            () if is("vtkhdf") => Some(Self::Vtkhdf),
            () if is("mfem") => Some(Self::Mfem),
            () if is("msh") && stem.ends_with("_%") => Some(Self::Msh),
            () => None,
        }
    }
}

/// Does the name of `path` say that a mesh is written there in parts?
pub fn is_parts(path: impl AsRef<Path>) -> bool {
    Kind::of(path.as_ref()).is_some()
}

/// Is there, beside the parts, a list of them, which has the name itself?
pub fn has_list(path: impl AsRef<Path>) -> bool {
    Kind::of(path.as_ref()) == Some(Kind::Pvtu)
}

/// Do all parts write into one file?
pub fn has_slabs(path: impl AsRef<Path>) -> bool {
    Kind::of(path.as_ref()) == Some(Kind::Vtkhdf)
}

/// A mesh in parts whose arrays hold any number?
fn holds_any(path: &Path) -> bool {
    matches!(Kind::of(path), Some(Kind::Pvtu | Kind::Vtkhdf))
}

/// Is there a number for the exterior, region 0?
pub fn parts_hold_exterior(path: impl AsRef<Path>) -> bool {
    holds_any(path.as_ref())
}

/// Do tags of points survive there?
pub fn parts_hold_tags(path: impl AsRef<Path>) -> bool {
    holds_any(path.as_ref())
}

/// The files that [`write_parts`](crate::write_parts) writes for `path`: the list, if there is one,
/// then the parts.
pub fn part_files(path: impl AsRef<Path>, parts: usize) -> Vec<PathBuf> {
    let path = path.as_ref();
    if has_slabs(path) {
        return vec![path.to_owned()];
    }
    let list = has_list(path).then(|| path.to_owned());
    list.into_iter().chain((0..parts).map(|part| part_file(path, part))).collect()
}

/// The file of a part.
pub(crate) fn part_file(path: &Path, part: usize) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    match Kind::of(path) {
        Some(Kind::Msh) => {
            let stem = name.to_string_lossy().into_owned();
            let stem = stem.strip_suffix('%').unwrap_or(&stem);
            name = format!("{stem}{}.msh", part + 1).into();
        }
        Some(Kind::Mfem) => name.push(format!(".{part:06}")),
        _ => name.push(format!("_{part}.vtu")),
    }
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_named_after_the_list() {
        let files = part_files(Path::new("a/m.x.pvtu"), 2);
        let names: Vec<_> = files.iter().map(|f| f.to_string_lossy().into_owned()).collect();
        assert_eq!(names, ["a/m.x.pvtu", "a/m.x_0.vtu", "a/m.x_1.vtu"]);
        let of = |name: &str| part_files(Path::new(name), 2);
        assert_eq!(of("a/m_%.MSH"), [Path::new("a/m_1.msh"), Path::new("a/m_2.msh")]);
        assert_eq!(of("a/m.mfem"), [Path::new("a/m.000000"), Path::new("a/m.000001")]);
        assert_eq!(of("a/m.vtkhdf"), [Path::new("a/m.vtkhdf")]);
        assert!(!is_parts("m.msh") && !is_parts("m%.msh") && !is_parts("m_%.vtu"));
    }
}
