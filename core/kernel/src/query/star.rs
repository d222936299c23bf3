//! The surroundings of a vertex: its star, its neighbours; the edges of a mesh.

use super::{Cursor, Queries};
use crate::mesh::{Mesh, Vertex};
use crate::numbering::VACANT;
use crate::topology::{INFINITE, TetId, VertexId, tet_of};

impl<'q> Cursor<'q> {
    /// Puts the tetrahedra around a kernel vertex, ghosts included, into `reached`.
    ///
    /// Ends: each tetrahedron enters once. Cost: O(star).
    pub(super) fn find_star(&mut self, v: VertexId) {
        let topology = &self.queries.mesh.topology;
        let s = &mut self.scratch;
        s.reached.clear();
        s.tets.clear();
        let first = self.queries.incident[v.index()];
        s.tets.insert(first);
        s.reached.push(first);
        let mut next = 0;
        while next < s.reached.len() {
            let tet = topology.tet(s.reached[next]);
            next += 1;
            for (&w, &n) in tet.vertices().iter().zip(&tet.neighbours()) {
                // The faces at v are those opposite another vertex.
                if w != v && s.tets.insert(tet_of(n)) {
                    s.reached.push(tet_of(n));
                }
            }
        }
    }

    /// Puts the finite neighbours of a kernel vertex into `ring`, each once.
    pub(super) fn find_ring(&mut self, v: VertexId) {
        self.find_star(v);
        let s = &mut self.scratch;
        s.ring.clear();
        s.vertices.clear();
        s.vertices.insert(v);
        s.vertices.insert(INFINITE);
        for &t in &s.reached {
            for w in self.queries.mesh.topology.tet(t).vertices() {
                if s.vertices.insert(w) {
                    s.ring.push(w);
                }
            }
        }
    }

    /// The finite tetrahedra around a vertex, ascending; `None` if no point of the mesh has this
    /// number. A duplicate's number stands for the vertex at its place.
    ///
    /// Cost: O(k log k) for k tetrahedra.
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// # let mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// let queries = mesh.queries();
    /// let mut cursor = queries.cursor();
    /// let star = cursor.star(7).expect("a vertex of the cube");
    /// assert!(star.iter().all(|&t| mesh.tet(t).is_some_and(|tet| tet.contains(&7))));
    /// assert_eq!(cursor.star(8), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn star(&mut self, v: Vertex) -> Option<&[TetId]> {
        let v = self.queries.resolve(v)?;
        self.find_star(v);
        let topology = &self.queries.mesh.topology;
        let s = &mut self.scratch;
        s.finite.clear();
        s.finite.extend(s.reached.iter().filter(|&&t| !topology.tet(t).is_ghost()));
        s.finite.sort_unstable();
        Some(&s.finite)
    }

    /// The vertices that share an edge with a vertex, ascending; `None` if no point of the mesh
    /// has this number. A duplicate's number stands for the vertex at its place.
    ///
    /// Cost: O(k log k) for k tetrahedra around it.
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// # let mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// let queries = mesh.queries();
    /// let mut cursor = queries.cursor();
    /// let near = cursor.neighbours(0).expect("a vertex of the cube");
    /// assert!([1, 2, 4].iter().all(|v| near.contains(v)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn neighbours(&mut self, v: Vertex) -> Option<&[Vertex]> {
        let v = self.queries.resolve(v)?;
        self.find_ring(v);
        let queries = self.queries;
        let s = &mut self.scratch;
        s.numbers.clear();
        s.numbers.extend(s.ring.iter().map(|&w| queries.number(w)));
        s.numbers.sort_unstable();
        Some(&s.numbers)
    }

    /// Does a vertex lie on the boundary of the convex hull? `None` if no point of the mesh has
    /// this number.
    ///
    /// Cost: O(k) for k tetrahedra around it.
    pub fn is_on_hull(&mut self, v: Vertex) -> Option<bool> {
        let v = self.queries.resolve(v)?;
        self.find_star(v);
        let topology = &self.queries.mesh.topology;
        Some(self.scratch.reached.iter().any(|&t| topology.tet(t).is_ghost()))
    }

    /// The edges of the mesh, each once, its ends ascending; in no particular order.
    ///
    /// Cost: O(tetrahedra) for all of them.
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// # let mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// // Euler's formula of a ball: V - E + F - T = 1.
    /// let edges = mesh.queries().cursor().edges().count();
    /// assert_eq!(8 + mesh.faces().count(), edges + mesh.num_tets() + 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn edges(&mut self) -> Edges<'_, 'q> {
        self.scratch.ring.clear();
        Edges { cursor: self, v: INFINITE, next: 0 }
    }
}

/// The edges of a mesh ([`Cursor::edges`]).
#[derive(Debug)]
pub struct Edges<'c, 'q> {
    cursor: &'c mut Cursor<'q>,
    /// The kernel vertex whose neighbours are in the ring; those behind it are its edges.
    v: VertexId,
    next: usize,
}

impl Iterator for Edges<'_, '_> {
    type Item = [Vertex; 2];

    /// Ends: past the last vertex.
    fn next(&mut self) -> Option<Self::Item> {
        let queries = self.cursor.queries;
        loop {
            while let Some(&w) = self.cursor.scratch.ring.get(self.next) {
                self.next += 1;
                if w > self.v {
                    let [a, b] = [self.v, w].map(|v| queries.number(v));
                    return Some([a.min(b), a.max(b)]);
                }
            }
            let next = self.v.index() + 1;
            if next >= queries.incident.len() {
                return None;
            }
            self.v = VertexId::at(next);
            self.next = 0;
            if queries.mesh.numbers[next] == VACANT {
                self.cursor.scratch.ring.clear();
            } else {
                self.cursor.find_ring(self.v);
            }
        }
    }
}

impl Queries<'_> {
    /// The hull facets, each once; seen from outside their vertices turn counterclockwise.
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// # let mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// assert_eq!(mesh.queries().hull().count(), 12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn hull(&self) -> impl Iterator<Item = [Vertex; 3]> + '_ {
        Mesh::hull_facets(self.mesh)
    }
}
