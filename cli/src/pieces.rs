//! The parts of a refined domain that workers have, each as a mesh of its own.

use crate::outcome::Failure;
use ltbw::io;
use ltbw::{BoundaryFace, TetMesh};
use std::path::PathBuf;

/// Writes a mesh in parts, one for each worker, or one alone. Returns all files.
pub(crate) fn write_parts(
    paths: &[PathBuf],
    mesh: &TetMesh,
    owners: &[u32],
    workers: usize,
) -> Result<Vec<PathBuf>, Failure> {
    if paths.is_empty() {
        return Ok(Vec::new());
    }
    let one = vec![0; mesh.tets.len()];
    let owners = if owners.is_empty() { &one } else { owners };
    let parts = parts_of(mesh, owners, workers.max(1));
    let mut written = Vec::new();
    for path in paths {
        io::write_parts(path, &parts).map_err(Failure::Write)?;
        written.extend(io::part_files(path, parts.len()));
    }
    Ok(written)
}

/// The parts of a mesh by the worker, of `count`, of each tetrahedron. One may be empty.
fn parts_of(mesh: &TetMesh, owners: &[u32], count: usize) -> Vec<TetMesh> {
    let mut lists: Vec<Vec<usize>> = vec![Vec::new(); count];
    for (tet, &owner) in owners.iter().enumerate() {
        lists[owner as usize].push(tet);
    }
    // The place of each tetrahedron in its part.
    let mut places = vec![0; mesh.tets.len()];
    let mut faces: Vec<Vec<BoundaryFace>> = vec![Vec::new(); count];
    for list in &lists {
        list.iter().enumerate().for_each(|(place, &tet)| places[tet] = place);
    }
    for face in &mesh.faces {
        let own = BoundaryFace { tet: places[face.tet], ..*face };
        faces[owners[face.tet] as usize].push(own);
    }
    let parts = lists.into_iter().zip(faces);
    parts.map(|(list, faces)| part_of(mesh, &list, faces)).collect()
}

/// Some tetrahedra of a mesh with their points alone, and their faces, whose corners are still
/// numbers of the mesh.
fn part_of(mesh: &TetMesh, list: &[usize], mut faces: Vec<BoundaryFace>) -> TetMesh {
    let mut used: Vec<u32> = list.iter().flat_map(|&tet| mesh.tets[tet]).collect();
    used.sort_unstable();
    used.dedup();
    // Every corner is among those used: a face is one of a tetrahedron of the part.
    let place = |v: u32| used.binary_search(&v).unwrap_or_default() as u32;
    faces.iter_mut().for_each(|face| face.corners = face.corners.map(place));
    TetMesh {
        points: used.iter().map(|&v| mesh.points[v as usize]).collect(),
        tets: list.iter().map(|&tet| mesh.tets[tet].map(place)).collect(),
        point_tags: mesh.point_tags.as_ref().map(|all| of(&used, |&v| all[v as usize])),
        tet_tags: mesh.tet_tags.as_ref().map(|all| of(list, |&tet| all[tet])),
        tet_attributes: mesh.tet_attributes.as_ref().map(|all| of(list, |&tet| all[tet])),
        faces,
    }
}

fn of<T, U>(list: &[T], value: impl Fn(&T) -> U) -> Vec<U> {
    list.iter().map(value).collect()
}
