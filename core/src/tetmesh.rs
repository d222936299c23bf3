//! A plain tetrahedral mesh: what files carry.

use crate::Point;

/// A tetrahedral mesh with optional integer tags, as files carry it.
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
}
