//! The parts of a mesh that workers have, each as a mesh of its own.

use ltbw::io::Piece;
use ltbw::{BoundaryFace, TetMesh};

/// The parts of a mesh by the worker, of `count`, of each tetrahedron. One may be empty.
pub(crate) fn parts_of(mesh: &TetMesh, owners: &[u32], count: usize) -> Vec<Piece> {
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
    let of_part = |(list, faces): (Vec<usize>, Vec<BoundaryFace>)| {
        let mut part = part_of(mesh, list.iter().map(|&tet| mesh.tets[tet]).collect(), faces);
        part.mesh.tet_tags =
            mesh.tet_tags.as_ref().map(|all| list.iter().map(|&tet| all[tet]).collect());
        part.mesh.tet_attributes =
            mesh.tet_attributes.as_ref().map(|all| list.iter().map(|&tet| all[tet]).collect());
        part
    };
    lists.into_iter().zip(faces).map(of_part).collect()
}

/// Some tetrahedra of a mesh with their points alone, in the order of the mesh, and some of their
/// faces, whose corners are still numbers of the mesh.
pub(crate) fn part_of(
    mesh: &TetMesh,
    mut tets: Vec<[u32; 4]>,
    mut faces: Vec<BoundaryFace>,
) -> Piece {
    let mut used: Vec<u32> = tets.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    // Every corner is among those used: a face is one of a tetrahedron of the part.
    let place = |v: u32| used.binary_search(&v).unwrap_or_default() as u32;
    tets.iter_mut().for_each(|tet| *tet = tet.map(place));
    faces.iter_mut().for_each(|face| face.corners = face.corners.map(place));
    let tags = |all: &Vec<i64>| used.iter().map(|&v| all[v as usize]).collect();
    let mesh = TetMesh {
        points: used.iter().map(|&v| mesh.points[v as usize]).collect(),
        tets,
        point_tags: mesh.point_tags.as_ref().map(tags),
        faces,
        ..TetMesh::default()
    };
    Piece { mesh, numbers: used }
}
