//! The Voronoi cell of a vertex, exact in its combinatorics.
//!
//! The cell's face towards a neighbour w is dual to the edge v w: its corners are the
//! circumcentres of the tetrahedra around the edge, in their cyclic order. Tetrahedra whose
//! circumspheres are the same, by the exact in-sphere test of neighbours, are one corner. What
//! remains with fewer corners than a face needs (an edge that is there only because cospherical
//! points had to be triangulated somehow) is no face and is left out. So the answer is the cell
//! of the unperturbed points: its faces do not depend on the perturbation.
//!
//! ```text
//!            t1 .-----. t0           corners t0, t1, t2, t3: counterclockwise seen from w,
//!              /   w   \             which is in front of the page; v is behind it
//!          t2 '---------' t3
//! ```

use super::Cursor;
use crate::mesh::{Mesh, Vertex};
use crate::topology::{FaceId, INFINITE, TetId, VertexId, slot_of, tet_of};
use ltbw_exact::predicates::insphere;
use ltbw_exact::predicates::orient3d;

/// `SPIN[i][j]`: slots k, l for which (i, j, k, l) is an even permutation, so that from k to l
/// turns counterclockwise about the axis from vertex i to vertex j. The diagonal is not used.
const SPIN: [[[usize; 2]; 4]; 4] = [
    [[0, 0], [2, 3], [3, 1], [1, 2]],
    [[3, 2], [0, 0], [0, 3], [2, 0]],
    [[1, 3], [3, 0], [0, 0], [0, 1]],
    [[2, 1], [0, 2], [1, 0], [0, 0]],
];

/// One face of a cell, as it lies in the buffers.
#[derive(Clone, Copy, Debug)]
struct Face {
    neighbour: Vertex,
    first: usize,
    len: usize,
    rays: Option<[TetId; 2]>,
}

/// Buffers of an answer.
#[derive(Clone, Debug, Default)]
pub(super) struct Buffers {
    faces: Vec<Face>,
    corners: Vec<TetId>,
}

impl Buffers {
    pub(super) fn memory_bytes(&self) -> usize {
        self.faces.capacity() * size_of::<Face>() + self.corners.capacity() * size_of::<TetId>()
    }
}

/// The Voronoi cell of a vertex ([`Cursor::cell`]).
#[derive(Clone, Copy, Debug)]
pub struct Cell<'c> {
    vertex: Vertex,
    bounded: bool,
    buffers: &'c Buffers,
}

/// A face of a Voronoi cell: the points as near to the vertex as to `neighbour`, and to no other
/// vertex nearer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellFace<'c> {
    /// The vertex on the other side.
    pub neighbour: Vertex,
    /// The corners, counterclockwise seen from `neighbour`: tetrahedra whose circumcentres they
    /// are (one of several cospherical ones each).
    pub corners: &'c [TetId],
    /// Two ghosts, if the face is unbounded: a ray comes from infinity, along the normal of the
    /// hull facet of the first, to the first corner; another goes from the last corner to infinity
    /// along the normal of the second.
    pub rays: Option<[TetId; 2]>,
}

impl<'c> Cell<'c> {
    /// The vertex whose cell this is.
    #[must_use]
    pub fn vertex(&self) -> Vertex {
        self.vertex
    }

    /// Is it bounded? It is if and only if the vertex is not on the convex hull's boundary.
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        self.bounded
    }

    /// The faces, in no particular order.
    #[must_use]
    pub fn faces(&self) -> CellFaces<'c> {
        CellFaces { buffers: self.buffers, next: 0 }
    }
}

/// The faces of a cell ([`Cell::faces`]).
#[derive(Clone, Debug)]
pub struct CellFaces<'c> {
    buffers: &'c Buffers,
    next: usize,
}

impl<'c> Iterator for CellFaces<'c> {
    type Item = CellFace<'c>;

    fn next(&mut self) -> Option<CellFace<'c>> {
        let face = self.buffers.faces.get(self.next)?;
        self.next += 1;
        let corners = &self.buffers.corners[face.first..face.first + face.len];
        Some(CellFace { neighbour: face.neighbour, corners, rays: face.rays })
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.buffers.faces.len() - self.next;
        (left, Some(left))
    }
}

impl ExactSizeIterator for CellFaces<'_> {}

impl Cursor<'_> {
    /// The Voronoi cell of a vertex; `None` if no point of the mesh has this number. A
    /// duplicate's number stands for the vertex at its place.
    ///
    /// Cost: O(k) for k tetrahedra around the vertex, with one in-sphere test for each two.
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// // A cube and its centre, 8. The cell of the centre is an octahedron: of the bisectors with
    /// // the eight corners.
    /// let corner = |i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
    /// let mut points: Vec<_> = (0..8).map(corner).collect();
    /// points.push([0.5; 3]);
    /// let mesh = Builder::new().build(&PointSet::new(points)?)?.mesh;
    /// let queries = mesh.queries();
    /// let mut cursor = queries.cursor();
    /// let cell = cursor.cell(8).expect("a vertex");
    /// assert!(cell.is_bounded());
    /// assert_eq!(cell.faces().len(), 8);
    /// assert!(cell.faces().all(|face| face.corners.len() == 3));
    /// assert!(!cursor.cell(0).expect("a vertex").is_bounded());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn cell(&mut self, vertex: Vertex) -> Option<Cell<'_>> {
        let queries = self.queries;
        let v = queries.resolve(vertex)?;
        self.find_ring(v);
        let s = &mut self.scratch;
        s.cell.faces.clear();
        s.cell.corners.clear();
        s.vertices.clear();
        s.vertices.insert(v);
        s.vertices.insert(INFINITE);
        let mesh = queries.mesh;
        let mut bounded = true;
        for &t in &s.reached {
            let tet = mesh.topology.tet(t).vertices();
            bounded &= tet[3] != INFINITE;
            for w in tet {
                if s.vertices.insert(w) {
                    s.cell.add_face(mesh, [v, w], t, queries.number(w));
                }
            }
        }
        Some(Cell { vertex: queries.number(v), bounded, buffers: &s.cell })
    }
}

impl Buffers {
    /// Adds the face dual to the edge from v to w, which tetrahedron `start` has.
    fn add_face(&mut self, mesh: &Mesh, edge: [VertexId; 2], start: TetId, neighbour: Vertex) {
        let topology = &mesh.topology;
        // A turn about the edge, one step of which crosses the face `exit`. A ghost, if there is
        // one, is looked for first: the ghosts are two, one after the other, and an unbounded
        // face begins after them.
        let mut t = start;
        let mut exit = step(mesh, t, edge);
        for _ in 0..topology.slots() {
            let next = tet_of(exit);
            let wanted = topology.tet(t).is_ghost() && !topology.tet(next).is_ghost();
            t = next;
            exit = step(mesh, t, edge);
            if wanted || t == start {
                break;
            }
        }
        let before = tet_of(step_back(mesh, t, edge));
        let unbounded = topology.tet(before).is_ghost();
        let first = self.corners.len();
        let origin = t;
        self.corners.push(t);
        // Ends: a turn has at most as many steps as there are tetrahedra.
        for _ in 0..topology.slots() {
            let next = tet_of(exit);
            if next == origin || topology.tet(next).is_ghost() {
                break;
            }
            if !cospherical(mesh, exit, t) {
                self.corners.push(next);
            }
            t = next;
            exit = step(mesh, t, edge);
        }
        let after = tet_of(exit);
        let mut len = self.corners.len() - first;
        if !unbounded && len > 1 && cospherical(mesh, exit, t) {
            // The last corner is the first one.
            self.corners.pop();
            len -= 1;
        }
        let enough = if unbounded { len > 1 || !coplanar(mesh, before, after) } else { len > 2 };
        if enough {
            let rays = unbounded.then_some([before, after]);
            self.faces.push(Face { neighbour, first, len, rays });
        } else {
            self.corners.truncate(first);
        }
    }
}

/// Slots of v and w in a tetrahedron that has both, with those that turn about the edge.
fn spin(mesh: &Mesh, t: TetId, [v, w]: [VertexId; 2]) -> [usize; 2] {
    let tet = mesh.topology.tet(t).vertices();
    let slot = |x| tet.iter().position(|&y| y == x).unwrap_or(0);
    SPIN[slot(v)][slot(w)]
}

/// The face, seen from beyond, through which a counterclockwise turn about the edge leaves `t`.
fn step(mesh: &Mesh, t: TetId, edge: [VertexId; 2]) -> FaceId {
    mesh.topology.tet(t).neighbours()[spin(mesh, t, edge)[0]]
}

/// The face through which a clockwise turn leaves.
fn step_back(mesh: &Mesh, t: TetId, edge: [VertexId; 2]) -> FaceId {
    mesh.topology.tet(t).neighbours()[spin(mesh, t, edge)[1]]
}

/// Have the finite tetrahedron `t` and its finite neighbour at `face` the same circumsphere?
fn cospherical(mesh: &Mesh, face: FaceId, t: TetId) -> bool {
    let at = |v| mesh.kernel_point(v);
    let [a, b, c, d] = mesh.topology.tet(t).vertices().map(at);
    let apex = at(mesh.topology.tet(tet_of(face)).vertices()[slot_of(face)]);
    insphere(&a, &b, &c, &d, &apex).is_zero()
}

/// Do the facets of two neighbouring ghosts lie in one plane?
fn coplanar(mesh: &Mesh, a: TetId, b: TetId) -> bool {
    let at = |v| mesh.kernel_point(v);
    let [p, q, r, _] = mesh.topology.tet(a).vertices();
    mesh.topology.tet(b).vertices()[..3]
        .iter()
        .all(|&v| orient3d(&at(p), &at(q), &at(r), &at(v)).is_zero())
}
