//! Questions to a mesh that does not change: many threads may ask at once.
//!
//! [`Mesh::queries`] computes, once and in O(n), what the kernel does not keep: the vertex of a
//! public number and a tetrahedron at each vertex. A [`Cursor`] is the scratch memory of one
//! thread: the place where the last walk ended and some buffers. A cursor allocates only when a
//! buffer has to grow; once warm, no query allocates, whatever the coordinates. (Alone
//! [`Queries::circumcentre`] does, for a nearly flat tetrahedron.)
//!
//! Query points are in the input's coordinates, any finite ones; a point outside the exactness
//! window of the mesh is answered as exactly as any other, more slowly. Every answer but
//! [`Queries::circumcentre`] is exact.
//!
//! ```
//! use ltbw_generate::{PointKind, generate};
//! use ltbw_core::query::Location;
//! use ltbw_core::Builder;
//! use ltbw_exact::PointSet;
//! use rayon::prelude::*;
//!
//! let points = generate(PointKind::Uniform, 1000, 1);
//! let mesh = Builder::new().build(&PointSet::new(points.clone())?)?.mesh;
//! let queries = mesh.queries();
//! let found: Result<Vec<Location>, _> = points
//!     .par_iter()
//!     .map_init(|| queries.cursor(), |cursor, &p| cursor.locate(p))
//!     .collect();
//! assert!(found?.iter().zip(0..).all(|(&at, v)| at == Location::Vertex(v)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod circumcentre;
mod region;
pub(crate) mod set;
mod star;
mod target;
mod voronoi;

pub use circumcentre::Circumcentre;
pub use region::{ConflictRegion, Conflicts, RegionFace};
pub use star::Edges;
pub use voronoi::{Cell, CellFace, CellFaces};

use crate::mesh::{Mesh, Vertex};
use crate::numbering::Numbering;
use crate::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;
use ltbw_exact::points::PointError;
use set::Marks;
use target::{Spot, Target};

/// The simplex of a mesh that holds a point, or its place outside.
///
/// It depends on the mesh and the point alone, but for `tet` of [`Location::Edge`] and
/// [`Location::Facet`], which is one of several, and the facet of [`Location::OutsideHull`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Location {
    /// At a vertex.
    Vertex(Vertex),
    /// Inside an edge.
    Edge {
        /// Its ends, ascending.
        ends: [Vertex; 2],
        /// A finite tetrahedron with this edge.
        tet: TetId,
    },
    /// Inside a triangle.
    Facet {
        /// Its corners, ascending.
        corners: [Vertex; 3],
        /// A finite tetrahedron with this triangle.
        tet: TetId,
    },
    /// Inside a tetrahedron.
    Tet(TetId),
    /// Outside the convex hull.
    OutsideHull {
        /// A hull facet that the point lies strictly beyond; seen from the point its corners
        /// turn counterclockwise.
        facet: [Vertex; 3],
        /// The ghost of that facet in [`Mesh::topology`].
        ghost: TetId,
    },
}

impl Mesh {
    /// Prepares for questions to this mesh, which cannot change meanwhile.
    ///
    /// Cost: O(n) time, 8 bytes per vertex; O(n log n) and 12 bytes if few numbers have a vertex.
    /// Half of it is that of [`Mesh::point`], and stays with the mesh.
    #[must_use]
    pub fn queries(&self) -> Queries<'_> {
        Queries::new(self)
    }
}

/// A mesh, with what questions to it need: shared by all threads ([module](self)).
#[derive(Debug)]
pub struct Queries<'m> {
    mesh: &'m Mesh,
    kernel: &'m Numbering,
    /// A finite tetrahedron at each kernel vertex; that of entry 0 has any.
    incident: Vec<TetId>,
}

impl<'m> Queries<'m> {
    fn new(mesh: &'m Mesh) -> Self {
        let mut incident = vec![TetId::default(); mesh.numbers.len()];
        for (t, tet) in mesh.topology.iter().filter(|(_, tet)| !tet.is_ghost()) {
            for v in [INFINITE].into_iter().chain(tet.vertices()) {
                incident[v.index()] = t;
            }
        }
        Self { mesh, kernel: mesh.numbering(), incident }
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &'m Mesh {
        self.mesh
    }

    /// Scratch memory for one thread's questions.
    #[must_use]
    pub fn cursor(&self) -> Cursor<'_> {
        Cursor {
            queries: self,
            hint: self.incident.first().copied().unwrap_or_default(),
            scratch: Scratch::default(),
        }
    }

    /// The kernel vertex of a public number; a duplicate's number stands for the vertex at its
    /// place. `None` if no point of the mesh has it.
    fn resolve(&self, v: Vertex) -> Option<VertexId> {
        self.kernel.get(v)
    }

    /// The public number of a finite kernel vertex.
    #[inline(always)]
    fn number(&self, v: VertexId) -> Vertex {
        self.mesh.numbers[v.index()]
    }

    /// The coordinates of a vertex (or a duplicate), as they were given; `None` if no point of
    /// the mesh has this number.
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// # let mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// assert_eq!(mesh.queries().point(6), Some([0.0, 1.0, 1.0]));
    /// assert_eq!(mesh.queries().point(8), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn point(&self, v: Vertex) -> Option<Point> {
        let k = self.resolve(v)?;
        Some(self.mesh.mode().from_kernel(self.mesh.kernel_point(k)))
    }

    /// The vertex that stands for a number: itself, or the vertex at a duplicate's place.
    #[must_use]
    pub fn vertex(&self, v: Vertex) -> Option<Vertex> {
        self.resolve(v).map(|k| self.number(k))
    }

    /// Bytes held beside the large arrays of the mesh ([`Mesh::memory_bytes`]).
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.kernel.memory_bytes() + self.incident.capacity() * size_of::<TetId>()
    }
}

/// Buffers that queries reuse.
#[derive(Clone, Debug, Default)]
struct Scratch {
    /// Tetrahedra reached, ghosts included.
    reached: Vec<TetId>,
    /// The set of `reached`.
    tets: Marks,
    /// Finite tetrahedra of the answer.
    finite: Vec<TetId>,
    /// The set of vertices found.
    vertices: Marks,
    /// Vertices found, as kernel numbers.
    ring: Vec<VertexId>,
    /// Vertices of the answer.
    numbers: Vec<Vertex>,
    region: region::Buffers,
    cell: voronoi::Buffers,
}

/// One thread's place in a mesh and its scratch memory ([module](self)).
///
/// A walk starts where the last one ended: ask for points in an order in which neighbours follow
/// each other ([`crate::order::hilbert`]) and a walk takes a few steps.
#[derive(Clone, Debug)]
pub struct Cursor<'q> {
    queries: &'q Queries<'q>,
    hint: TetId,
    scratch: Scratch,
}

impl<'q> Cursor<'q> {
    /// Locates a point, exactly.
    ///
    /// Cost: O(1) expected near the last point asked for, else a walk of O(n^(1/3)) steps for
    /// uniform points.
    ///
    /// # Errors
    /// [`PointError::NotFinite`], with index 0.
    ///
    /// ```
    /// use ltbw_core::query::Location;
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// # let mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// let queries = mesh.queries();
    /// let mut cursor = queries.cursor();
    /// assert_eq!(cursor.locate([1.0, 1.0, 0.0])?, Location::Vertex(3));
    /// assert!(matches!(cursor.locate([0.5, 0.0, 0.0])?, Location::Edge { ends: [0, 1], .. }));
    /// assert!(matches!(cursor.locate([0.4, 0.3, 0.2])?, Location::Tet(_)));
    /// assert!(matches!(cursor.locate([0.5, 1e300, 0.5])?, Location::OutsideHull { .. }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn locate(&mut self, p: Point) -> Result<Location, PointError> {
        let target = Target::new(self.queries.mesh, p)?;
        Ok(self.queries.location(self.walk(&target)))
    }

    /// The slow twin of [`Cursor::locate`]: looks at every tetrahedron. For tests.
    #[doc(hidden)]
    pub fn locate_by_search(&self, p: Point) -> Result<Location, PointError> {
        let target = Target::new(self.queries.mesh, p)?;
        Ok(self.queries.location(target.search()))
    }

    fn walk(&mut self, target: &Target<'_>) -> Spot {
        let spot = target.walk(self.hint);
        let (Spot::Inside(t, _) | Spot::Outside(t)) = spot;
        self.hint = t;
        spot
    }

    /// The vertex nearest to a point, exactly; of several equally near ones the smallest by
    /// (x, y, z).
    ///
    /// Goes from vertex to nearer neighbour until there is none. The answer is the nearest of
    /// all: the Voronoi cell of a vertex is cut out by the bisectors with its Delaunay
    /// neighbours, so a point outside the cell is nearer to one of them. Equally near vertices
    /// are corners of one polytope inscribed in an empty sphere, whose edges are all in the mesh,
    /// and no corner but the least by (x, y, z) is a local minimum. Each step is to a strictly
    /// smaller vertex, so it ends.
    ///
    /// # Errors
    /// [`PointError::NotFinite`], with index 0.
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// # let mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// let queries = mesh.queries();
    /// let mut cursor = queries.cursor();
    /// assert_eq!(cursor.nearest([0.9, 0.1, 0.2])?, 1);
    /// assert_eq!(cursor.nearest([0.5, 0.5, 7.0])?, 4, "of four, the smallest by (x, y, z)");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn nearest(&mut self, p: Point) -> Result<Vertex, PointError> {
        let target = Target::new(self.queries.mesh, p)?;
        let (Spot::Inside(t, _) | Spot::Outside(t)) = self.walk(&target);
        let mut best = INFINITE;
        for v in self.queries.mesh.topology.tet(t).vertices() {
            if v != INFINITE && (best == INFINITE || target.cmp_near(v, best).is_lt()) {
                best = v;
            }
        }
        loop {
            let here = best;
            self.find_ring(here);
            for &v in &self.scratch.ring {
                if target.cmp_near(v, best).is_lt() {
                    best = v;
                }
            }
            if best == here {
                return Ok(self.queries.number(best));
            }
        }
    }

    /// Bytes of scratch memory held.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        let s = &self.scratch;
        let words =
            s.reached.capacity() + s.finite.capacity() + s.ring.capacity() + s.numbers.capacity();
        words * size_of::<u32>()
            + s.tets.memory_bytes()
            + s.vertices.memory_bytes()
            + s.region.memory_bytes()
            + s.cell.memory_bytes()
    }
}

impl Queries<'_> {
    /// A spot in public numbers.
    fn location(&self, spot: Spot) -> Location {
        let (tet, zeros) = match spot {
            Spot::Inside(t, zeros) => (t, zeros),
            Spot::Outside(ghost) => return self.beyond(ghost),
        };
        let v = self.mesh.topology.tet(tet).vertices().map(|v| self.number(v));
        // The point lies on the faces opposite the slots in `zeros`: in the hull of the others.
        let mut others = (0..4).filter(|slot| zeros >> slot & 1 == 0).map(|slot| v[slot]);
        let mut next = || others.next().unwrap_or(Vertex::MAX);
        match zeros.count_ones() {
            0 => Location::Tet(tet),
            1 => {
                let mut corners = [next(), next(), next()];
                corners.sort_unstable();
                Location::Facet { corners, tet }
            }
            2 => {
                let mut ends = [next(), next()];
                ends.sort_unstable();
                Location::Edge { ends, tet }
            }
            _ => Location::Vertex(next()),
        }
    }

    fn beyond(&self, ghost: TetId) -> Location {
        let [a, b, c, _] = self.mesh.topology.tet(ghost).vertices();
        Location::OutsideHull { facet: [a, b, c].map(|v| self.number(v)), ghost }
    }
}
