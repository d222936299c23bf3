//! The checker's input: a borrowed mesh of plain slices, and how deep to look.

/// A point: three coordinates in the units of the input.
pub type Point = [f64; 3];

/// The neighbour across a face of the hull, in adjacency lists given to the checker.
pub const NO_NEIGHBOUR: u32 = u32::MAX;

/// A borrowed view of a tetrahedral mesh, anybody's. Nothing about it is trusted: indices may be
/// out of range, coordinates may be NaN, lists may have the wrong length.
#[derive(Debug, Clone, Copy)]
pub struct Mesh<'a> {
    /// Coordinates of the points. Points that no tetrahedron uses are allowed.
    pub points: &'a [Point],
    /// Tetrahedra: four indices into `points` each.
    pub tets: &'a [[u32; 4]],
    /// Claimed adjacency: the tetrahedron opposite vertex `i` of tetrahedron `t`, or
    /// [`NO_NEIGHBOUR`]. Checked when it is given; it is not trusted, and makes the check of a
    /// good mesh several times as fast.
    pub neighbours: Option<&'a [[u32; 4]]>,
    /// Claimed facets of the hull, in any order and any vertex order. Checked when given.
    pub hull: Option<&'a [[u32; 3]]>,
}

impl<'a> Mesh<'a> {
    /// A mesh that claims no adjacency and no hull.
    pub fn new(points: &'a [Point], tets: &'a [[u32; 4]]) -> Self {
        Self { points, tets, neighbours: None, hull: None }
    }

    /// This mesh with an adjacency to check: see [`Mesh::neighbours`].
    pub fn with_neighbours(self, neighbours: &'a [[u32; 4]]) -> Self {
        Self { neighbours: Some(neighbours), ..self }
    }

    /// This mesh with hull facets to check: see [`Mesh::hull`].
    pub fn with_hull(self, hull: &'a [[u32; 3]]) -> Self {
        Self { hull: Some(hull), ..self }
    }
}

/// The depth of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Depth {
    /// Everything that the theorem of the crate documentation needs: after it a passed mesh *is*
    /// a Delaunay triangulation of its vertices. Leaves out what that theorem makes redundant
    /// (vertex links, Euler's formula), the canonical rule, and the hash.
    Fast,
    /// All levels, and the canonical hash. On a mesh that is proved from its claimed adjacency,
    /// vertex links and Euler's formula follow from the theorem.
    #[default]
    Full,
}

/// The meaning of the order of a tetrahedron's four vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum VertexOrder {
    /// All tetrahedra have the same handedness. Should all of them be negative, that is a note
    /// and no defect; otherwise each negative one is a defect.
    #[default]
    Oriented,
    /// It means nothing (scipy and Qhull write such meshes): every tetrahedron is turned to
    /// positive first. Folds are found all the same, as two tetrahedra on one side of a face.
    Any,
}

/// Options of [`check`](crate::check) and [`conforms`](crate::conforms).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// The depth of the check.
    pub depth: Depth,
    /// The meaning of the order of the vertices.
    pub vertex_order: VertexOrder,
    /// Demand that every place of `points` is a vertex of the mesh (duplicates of a vertex need
    /// not be used): "this mesh is the triangulation of all of these points".
    pub all_points: bool,
    /// Defects listed per kind; all of them are counted.
    pub max_defects: usize,
    /// Of a mesh of a domain: demand that tags are the regions' numbers. The tetrahedra that the
    /// seed of the domain's first region is in have tag 1, those of the next region the next
    /// number, and those that no seed is in have higher ones. Without it tags may be any names.
    pub numbered_regions: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            depth: Depth::Full,
            vertex_order: VertexOrder::Oriented,
            all_points: false,
            max_defects: 100,
            numbered_regions: false,
        }
    }
}

/// The four vertices of a tetrahedron with the face opposite vertex `i` turned outward, when the
/// tetrahedron is positive: `orient3d` of the face and the vertex `i` is negative.
///
/// ```text
///        3            face opposite 0: 1 2 3
///       /|\           face opposite 1: 0 3 2
///      / | \          face opposite 2: 0 1 3
///     0--|--2         face opposite 3: 0 2 1
///      \ | /
///        1
/// ```
pub(crate) const OUTWARD: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The face of `tet` opposite its vertex `i`, outward when `tet` is positive.
pub(crate) fn face(tet: &[u32; 4], i: usize) -> [u32; 3] {
    OUTWARD[i].map(|k| tet[k])
}

impl Side {
    /// The code of the face.
    pub(crate) fn code(self) -> u32 {
        (4 * self.t + self.i) as u32
    }
}

/// A face of a tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Side {
    /// The tetrahedron.
    pub(crate) t: usize,
    /// The place of the vertex opposite the face.
    pub(crate) i: usize,
}

/// Splits a face code `4 * tet + face`.
pub(crate) fn split(code: u32) -> Side {
    Side { t: (code >> 2) as usize, i: (code & 3) as usize }
}
