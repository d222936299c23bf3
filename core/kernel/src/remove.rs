//! A vertex taken out of a mesh: its star is replaced by tetrahedra of its neighbours.
//!
//! The mesh of the points that are left has every tetrahedron of this one that has not the vertex.
//! The hole is filled with tetrahedra whose corners are all neighbours of the vertex, and which are
//! Delaunay among them: the mesh is one function of its points, ties included, and in the order by
//! which ties are decided a point less changes nothing among the others.

use crate::build::{Budget, BuildError, Builder, Outcome};
use crate::cavity::OTHERS;
use crate::cavity::hole::{Defect, Front};
use crate::geometry::InFront;
use crate::locate::walk_to;
use crate::mesh::{Mesh, Vertex};
use crate::numbering::VACANT;
use crate::topology::{FaceId, TetId, VertexId, slot_of, tet_of};
use crate::transaction::OpenCavity;
use ltbw_exact::{Point, PointSet};
use std::collections::HashMap;

/// Of larger links the corners are meshed apart: a search among them takes the square of them.
const LARGE: usize = 256;
/// They are not where their mesh has more tetrahedra for each of them.
const MOST_TETS: usize = 32;

/// Why a vertex could not be removed. The mesh is as it was before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RemoveError {
    /// No point of the mesh has this number.
    #[error("no point of the mesh has the number {vertex}")]
    Unknown {
        /// The number.
        vertex: Vertex,
    },
    /// The other points have no mesh.
    #[error(
        "without vertex {vertex} there is no mesh: the {left} others are fewer than 4 or lie in \
         one plane"
    )]
    Flat {
        /// The vertex.
        vertex: Vertex,
        /// The number of other vertices.
        left: usize,
    },
    /// The mesh cannot name more tetrahedra.
    #[error("the mesh would exceed {limit} tetrahedra, hull ghosts included")]
    TooManyTets {
        /// The limit.
        limit: usize,
    },
    /// The mesh is not Delaunay around the vertex; none is so that the kernel made.
    #[error("the mesh is not Delaunay around vertex {vertex}")]
    Damaged {
        /// The vertex.
        vertex: Vertex,
    },
}

impl Mesh {
    /// Removes the vertex with the number `v`, and with it all points at its place: the number of
    /// a duplicate stands for the vertex there. The mesh is that of the other points then, hash by
    /// hash. Other vertices keep their numbers, and no point gets this one again.
    ///
    /// Cost: a walk from the last insertion or removal, then O(d t) for a star with d corners that
    /// is replaced by t tetrahedra; if d is above 256, the time and memory of a build of d points.
    /// No memory is taken for smaller stars once such were met. O(n) time and 4 bytes per vertex
    /// once, as [`Mesh::point`] takes; a look at all duplicates, where there are any.
    ///
    /// # Errors
    /// [`RemoveError`]: the mesh is as before.
    ///
    /// ```
    /// # use ltbw_core::{Builder, Inserted, RemoveError};
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// let mut mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// let hash = mesh.hash()?;
    /// assert_eq!(mesh.insert([0.5; 3])?, Inserted::Vertex(8));
    /// mesh.remove(8)?;
    /// assert_eq!(mesh.hash()?, hash);
    /// assert_eq!(mesh.remove(8), Err(RemoveError::Unknown { vertex: 8 }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn remove(&mut self, v: Vertex) -> Result<(), RemoveError> {
        let k = self.numbering().get(v).ok_or(RemoveError::Unknown { vertex: v })?;
        let number = self.numbers[k.index()];
        self.take_out(k)?;
        if self.duplicates.iter().any(|duplicate| duplicate.kept == number) {
            let mut all = std::mem::take(&mut self.duplicates);
            let gone = all.extract_if(.., |duplicate| duplicate.kept == number);
            gone.for_each(|duplicate| self.forget(duplicate.number));
            self.duplicates = all;
        }
        Ok(())
    }

    /// Numbers all points from 0 on, in the order that they have, so that no number is without a
    /// point; returns the numbers before.
    ///
    /// Cost: O(n log n).
    ///
    /// ```
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// let mut mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// mesh.remove(2)?;
    /// assert_eq!(mesh.renumber(), [0, 1, 3, 4, 5, 6, 7]);
    /// assert_eq!(mesh.point(2), Some([1.0, 1.0, 0.0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn renumber(&mut self) -> Vec<Vertex> {
        let there = self.numbers.iter().skip(1).copied().filter(|&number| number != VACANT);
        let duplicates = self.duplicates.iter().map(|duplicate| duplicate.number);
        let mut before: Vec<Vertex> = there.chain(duplicates).collect();
        before.sort_unstable();
        let now = |number: &mut Vertex| {
            if let Ok(place) = before.binary_search(number) {
                *number = place as Vertex;
            }
        };
        // A vacant number is none of them.
        self.numbers.iter_mut().skip(1).for_each(now);
        for duplicate in &mut self.duplicates {
            now(&mut duplicate.number);
            now(&mut duplicate.kept);
        }
        self.next_number = before.len() as Vertex;
        self.renumbered();
        before
    }

    /// Says that a kernel vertex is in no tetrahedron any more. The last one is as if it had never
    /// been, so that what is undone leaves no gaps.
    pub(crate) fn leave(&mut self, v: VertexId) {
        if v.index() + 1 == self.numbers.len() {
            self.numbers.pop();
            return;
        }
        self.numbers[v.index()] = VACANT;
        self.vacant.push(v);
    }

    /// Enters vertices that no tetrahedron has yet, with numbers from `first` on. They follow each
    /// other behind all others, whatever places are vacant.
    pub(crate) fn enter_in_a_row(&mut self, first: Vertex, points: impl Iterator<Item = Point>) {
        let vacant = std::mem::take(&mut self.vacant);
        for (p, k) in points.zip(0..) {
            self.enter(p, first.wrapping_add(k));
        }
        self.vacant = vacant;
    }

    fn forget(&mut self, number: Vertex) {
        if let Some(numbering) = self.numbering.get_mut() {
            numbering.forget(number);
        }
    }

    /// Removes a kernel vertex: its star is replaced with tetrahedra that have it not, which are
    /// then the star of the cavity. The next vertex that is entered gets its place.
    ///
    /// # Errors
    /// [`RemoveError`]: the mesh is as before.
    #[doc(hidden)]
    pub fn take_out(&mut self, v: VertexId) -> Result<(), RemoveError> {
        let vertex = self.numbers[v.index()];
        let damaged = |_: Defect| RemoveError::Damaged { vertex };
        let hint = self.hint();
        let Self { topology, geometry, cavity, .. } = self;
        let start = walk_to(topology, geometry, hint, v).ok_or(Defect).map_err(damaged)?;
        cavity.open_star(topology, v, start);
        let mut open = OpenCavity::new(self);
        let Self { topology, geometry, cavity, filling, rim, .. } = open.owner_mut();
        filling.start(cavity).map_err(damaged)?;
        let p = *geometry.point(v);
        let mut apart = None;
        if filling.corners().len() > LARGE {
            apart = Apart::new(filling.corners().iter().map(|&v| *geometry.point(v)).collect());
        }
        let is_apart = apart.is_some();
        match apart {
            Some(mut apart) => filling.plan(&mut apart),
            None => {
                let mut front = InFront::new(geometry, rim, filling.corners(), &p);
                filling.plan(&mut front)
            }
        }
        .map_err(damaged)?;
        let finite = topology.len() - topology.ghosts();
        if finite + filling.finite() == cavity.finite() {
            return Err(RemoveError::Flat { vertex, left: open.owner().num_vertices() - 1 });
        }
        if !cavity.has_room_for(topology, filling) {
            return Err(RemoveError::TooManyTets { limit: topology.limit() });
        }
        let hint = open.end(|mesh| {
            let Self { topology, geometry, cavity, filling, rim, .. } = mesh;
            let made = cavity.fill_hole(topology, filling);
            geometry.reserve_spheres(topology.slots());
            for (k, (&t, corners)) in made.iter().zip(filling.tets()).enumerate() {
                let known = rim.spheres.get(k).copied().filter(|_| !is_apart);
                let sphere = known.unwrap_or_else(|| geometry.compute_sphere(corners));
                geometry.set_sphere(t, sphere);
            }
            made.first().copied().unwrap_or_default()
        });
        self.set_hint(hint);
        self.leave(v);
        self.forget(vertex);
        Ok(())
    }
}

/// The mesh of the corners of a large hole.
struct Apart {
    /// `None` if they lie in one plane: then all faces of the hole are on the hull.
    mesh: Option<Mesh>,
    /// Its faces by their corners, ascending.
    faces: HashMap<[u32; 3], FaceId>,
}

impl Apart {
    /// `None` if the mesh is too large.
    fn new(corners: Vec<Point>) -> Option<Self> {
        let most = MOST_TETS * corners.len();
        let budget = Budget { max_tets: Some(most as u64), ..Budget::default() };
        let mesh = match Builder::new().budget(budget).build(&PointSet::new(corners).ok()?) {
            Ok(built) if built.outcome == Outcome::Complete => built.mesh,
            Err(BuildError::Coplanar { .. }) => {
                return Some(Self { mesh: None, faces: HashMap::new() });
            }
            _ => return None,
        };
        let mut faces = HashMap::with_capacity(2 * mesh.num_tets());
        for t in mesh.tet_ids() {
            for slot in 0..4 {
                let mut key = Self::face(&mesh, t, slot);
                key.sort_unstable();
                faces.insert(key, FaceId::new(t, slot));
            }
        }
        Some(Self { mesh: Some(mesh), faces })
    }

    /// The face of a finite tetrahedron opposite a vertex, which before it is positively oriented.
    fn face(mesh: &Mesh, t: TetId, slot: usize) -> [u32; 3] {
        let corners = mesh.topology.tet(t).vertices();
        OTHERS[slot].map(|k| mesh.numbers[corners[k].index()])
    }
}

impl Front for Apart {
    fn apex(&mut self, _: &[VertexId], face: [u32; 3]) -> Option<u32> {
        let mesh = self.mesh.as_ref()?;
        let mut key = face;
        key.sort_unstable();
        let &there = self.faces.get(&key)?;
        let across = mesh.topology.tet(tet_of(there)).neighbours()[slot_of(there)];
        let [a, b, c] = face;
        let is_turned = |side: &FaceId| {
            let there = Self::face(mesh, tet_of(*side), slot_of(*side));
            [[a, b, c], [b, c, a], [c, a, b]].contains(&there)
        };
        let is_finite = |side: &FaceId| !mesh.topology.tet(tet_of(*side)).is_ghost();
        let side = [there, across].into_iter().filter(is_finite).find(is_turned)?;
        let apex = mesh.topology.tet(tet_of(side)).vertices()[slot_of(side)];
        Some(mesh.numbers[apex.index()])
    }
}
