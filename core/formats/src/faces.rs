//! Triangles of a mesh file: which of them are faces of tetrahedra, and of which.

use ltbw_core::{BoundaryFace, TetMesh};
use ltbw_exact::predicates::{Sign, orient3d};
use std::collections::HashMap;

/// The slots of a tetrahedron's corners without one each.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];

/// A triangle of a mesh file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Marked {
    pub(crate) corners: [u32; 3],
    pub(crate) marker: i64,
}

/// Gives triangles the tetrahedra that they are faces of.
///
/// Of two tetrahedra it is the one that the triangle points out of; a triangle that points out of
/// none is turned round. The note tells how many are faces of no tetrahedron: these are left out.
pub(crate) fn owned(mesh: &TetMesh, triangles: &[Marked]) -> (Vec<BoundaryFace>, Option<String>) {
    // For each triangle, by its sorted corners, the tetrahedra at it.
    let mut owners: HashMap<[u32; 3], [Option<usize>; 2]> =
        triangles.iter().map(|t| (sorted(t.corners), [None; 2])).collect();
    for (t, tet) in mesh.tets.iter().enumerate().filter(|_| !triangles.is_empty()) {
        for face in FACES {
            if let Some(pair) = owners.get_mut(&sorted(face.map(|k| tet[k]))) {
                let place = usize::from(pair[0].is_some());
                pair[place] = Some(t);
            }
        }
    }
    let mut faces = Vec::with_capacity(triangles.len());
    for &Marked { corners, marker } in triangles {
        let pair = owners.get(&sorted(corners)).copied().unwrap_or_default();
        let first = pair.into_iter().flatten().find(|&t| points_out(mesh, corners, t));
        let [a, b, c] = corners;
        let owner = first.map(|t| (corners, t)).or(pair[0].map(|t| ([a, c, b], t)));
        faces.extend(owner.map(|(corners, tet)| BoundaryFace { corners, marker, tet }));
    }
    let lost = triangles.len() - faces.len();
    let note = format!("{lost} triangles that are faces of no tetrahedron are not read");
    (faces, (lost > 0).then_some(note))
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// Does a face of a tetrahedron turn counterclockwise seen from outside?
fn points_out(mesh: &TetMesh, corners: [u32; 3], tet: usize) -> bool {
    let at = |v: u32| mesh.points.get(v as usize);
    let apex = mesh.tets[tet].into_iter().find(|v| !corners.contains(v));
    let [a, b, c] = corners.map(at);
    match (a, b, c, apex.and_then(at)) {
        (Some(a), Some(b), Some(c), Some(d)) => orient3d(a, b, c, d) == Sign::Negative,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_find_their_tetrahedra() {
        let points = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ];
        let mesh = TetMesh { points, tets: vec![[0, 1, 2, 3], [0, 2, 1, 4]], ..TetMesh::default() };
        // Between the two, from either side; a face turned the wrong way; one of no tetrahedron.
        let given =
            [([0, 2, 1], 5), ([0, 1, 2], 6), ([0, 1, 3], 7), ([0, 3, 1], 8), ([1, 3, 4], 9)]
                .map(|(corners, marker)| Marked { corners, marker });
        let (faces, note) = owned(&mesh, &given);
        let face = |corners, marker, tet| BoundaryFace { corners, marker, tet };
        let expected = [
            face([0, 2, 1], 5, 0),
            face([0, 1, 2], 6, 1),
            face([0, 1, 3], 7, 0),
            face([0, 1, 3], 8, 0),
        ];
        assert_eq!(faces, expected);
        assert!(note.is_some_and(|n| n.starts_with("1 triangles")));
        assert_eq!(owned(&mesh, &[]), (Vec::new(), None));
    }
}
