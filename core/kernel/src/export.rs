//! A mesh as plain arrays.

use crate::mesh::{Duplicate, Mesh, Vertex};
use crate::tetmesh::TetMesh;
use ltbw_exact::Point;

impl Mesh {
    /// The coordinates of a vertex (or a duplicate), as they were given; `None` if no point of the
    /// mesh has this number.
    ///
    /// Cost: O(1), and O(n) time and 4 bytes per vertex once, at the first question; O(log n), and
    /// O(n log n) and 8 bytes, if few numbers have a vertex. Points inserted later keep that.
    ///
    /// ```
    /// # use ltbw_core::{Builder, Inserted};
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// let mut mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// assert_eq!(mesh.point(6), Some([0.0, 1.0, 1.0]));
    /// assert_eq!(mesh.point(8), None);
    /// assert_eq!(mesh.insert([0.5; 3])?, Inserted::Vertex(8));
    /// assert_eq!(mesh.point(8), Some([0.5; 3]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn point(&self, v: Vertex) -> Option<Point> {
        let k = self.numbering().get(v)?;
        Some(self.mode().from_kernel(self.kernel_point(k)))
    }

    /// Coordinates by number, as the corners of tetrahedra name them: those of the input, then of
    /// points that came later. A duplicate has the coordinates of the vertex at its place; a point
    /// that a build did not reach has NaN.
    pub fn points(&self) -> Vec<Point> {
        let count = self.duplicates.iter().map(|d| d.number + 1).max().unwrap_or(0);
        let mut points = vec![[f64::NAN; 3]; self.next_number.max(count) as usize];
        for (v, p) in self.vertices() {
            points[v as usize] = p;
        }
        for &Duplicate { number, kept } in &self.duplicates {
            points[number as usize] = points[kept as usize];
        }
        points
    }

    /// The mesh as plain arrays, with the input's numbering: a duplicate keeps its number and is
    /// in no tetrahedron. A point that a cancelled build did not reach has NaN coordinates here.
    pub fn to_tet_mesh(&self) -> TetMesh {
        TetMesh { points: self.points(), tets: self.tets().collect(), ..TetMesh::default() }
    }
}

#[cfg(feature = "ndarray")]
impl Mesh {
    /// [`Mesh::points`] as an array of shape (n, 3) (feature `ndarray`).
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// let cube = ndarray::Array2::from_shape_fn((8, 3), |(i, k)| (i >> k & 1) as f64);
    /// let mesh = Builder::new().build(&PointSet::try_from(cube.view())?)?.mesh;
    /// assert_eq!(mesh.points_array(), cube);
    /// assert_eq!(mesh.simplices_array().dim(), (mesh.num_tets(), 4));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn points_array(&self) -> ndarray::Array2<f64> {
        ltbw_exact::interop::to_ndarray(self.points())
    }

    /// [`Mesh::tets`] as an array of shape (m, 4) (feature `ndarray`): rows of
    /// [`Mesh::points_array`] by number.
    #[must_use]
    pub fn simplices_array(&self) -> ndarray::Array2<Vertex> {
        ltbw_exact::interop::to_ndarray(self.tets().collect())
    }
}
