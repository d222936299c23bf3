//! A mesh as plain arrays.

use crate::mesh::Mesh;
use crate::tetmesh::TetMesh;
use ltbw_exact::Point;

impl Mesh {
    /// Coordinates by number, as the corners of tetrahedra name them: those of the input, then of
    /// points that came later. A duplicate has the coordinates of the vertex at its place; a point
    /// that a build did not reach has NaN.
    pub fn points(&self) -> Vec<Point> {
        let count = self.duplicates.iter().map(|&(d, _)| d + 1).max().unwrap_or(0);
        let mut points = vec![[f64::NAN; 3]; self.next_number.max(count) as usize];
        for (v, p) in self.vertices() {
            points[v as usize] = p;
        }
        for &(duplicate, kept) in &self.duplicates {
            points[duplicate as usize] = points[kept as usize];
        }
        points
    }

    /// The mesh as plain arrays, with the input's numbering: a duplicate keeps its number and is
    /// in no tetrahedron. A point that a cancelled build did not reach has NaN coordinates here.
    pub fn to_tet_mesh(&self) -> TetMesh {
        TetMesh { points: self.points(), tets: self.tets().collect(), ..TetMesh::default() }
    }
}
