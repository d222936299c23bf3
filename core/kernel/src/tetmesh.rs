//! A plain tetrahedral mesh: what files carry.

use ltbw_exact::Point;

/// A tetrahedral mesh with optional tags and boundary faces, as files carry it.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TetMesh {
    /// Vertex coordinates.
    pub points: Vec<Point>,
    /// Tetrahedra: four indices into `points` each, positively oriented in our own output.
    pub tets: Vec<[u32; 4]>,
    /// One tag per point (boundary markers), if the file has them.
    pub point_tags: Option<Vec<i64>>,
    /// One tag per tetrahedron (regions), if the file has them.
    pub tet_tags: Option<Vec<i64>>,
    /// One attribute per tetrahedron: that of its region, if the domain gives regions attributes.
    #[cfg_attr(feature = "serde", serde(default))]
    pub tet_attributes: Option<Vec<f64>>,
    /// Triangles of the boundary and of walls inside, with the markers of their facets; none where
    /// nothing is known of facets.
    #[cfg_attr(feature = "serde", serde(default))]
    pub faces: Vec<BoundaryFace>,
}

/// A triangle of a mesh's boundary, or of a wall inside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoundaryFace {
    /// Three indices of points, turning counter-clockwise when seen from outside its tetrahedron.
    pub corners: [u32; 3],
    /// The marker of the facet that it is part of.
    pub marker: i64,
    /// The tetrahedron that it is a face of, by its place in the mesh's list.
    pub tet: usize,
}
