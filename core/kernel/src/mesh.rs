//! A Delaunay mesh that points can be inserted into, and that can be walked over.
//!
//! Vertices have the numbers of the input points ([`Vertex`]); of equal points the smallest
//! number is a vertex, the others are its duplicates. Tetrahedra have [`TetId`]s, which are
//! stable until the next insertion or removal.

mod assembled;
#[doc(hidden)]
pub mod lanes;
mod opened;
mod room;

pub use assembled::Assembly;

use crate::PredicateStats;
use crate::cavity::hole::Filling;
use crate::cavity::{Admission, AdmitAll, Cavity, Role, Setback, Star};
use crate::geometry::{Geometry, Rim};
use crate::hash::{HashError, MeshHash, canonical_hash};
pub use crate::numbering::Duplicate;
use crate::numbering::{Numbering, VACANT};
use crate::topology::{INFINITE, TetId, Topology, VertexId, tet_of};
use crate::transaction::{OpenCavity, Opens};
use ltbw_exact::points::{Mode, PointError};
use ltbw_exact::{Point, Sign};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::OnceLock;

/// Number of a vertex: the index of its point in the input, then counting on for inserted ones.
pub type Vertex = u32;

/// The outcome of an insertion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Inserted {
    /// It is a new vertex with this number.
    Vertex(Vertex),
    /// It lies at this vertex; the mesh is unchanged.
    Duplicate(Vertex),
}

/// Why a point could not be inserted. The mesh is as it was before, bit for bit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InsertError {
    /// The point is not finite.
    #[error(transparent)]
    Point(#[from] PointError),
    /// The admission refused a tetrahedron (setback): the insertion may be tried again.
    #[error("tetrahedron {tet} was refused: the cavity was set back")]
    Refused {
        /// The tetrahedron.
        tet: TetId,
    },
    /// The mesh cannot name more tetrahedra.
    #[error("the mesh would exceed {limit} tetrahedra, hull ghosts included")]
    TooManyTets {
        /// The limit.
        limit: usize,
    },
}

/// Turns a panic of the caller's admission into a refusal, so that the cavity is set back; the
/// panic goes on after that.
struct Guarded<'a, A> {
    admission: &'a mut A,
    panic: Option<Box<dyn Any + Send>>,
}

impl<A: Admission> Admission for Guarded<'_, A> {
    fn admit(&mut self, t: TetId, role: Role) -> bool {
        // Unwind safe: the admission is not called again after a panic.
        let answer = catch_unwind(AssertUnwindSafe(|| self.admission.admit(t, role)));
        answer.unwrap_or_else(|panic| {
            self.panic = Some(panic);
            false
        })
    }
}

/// Why a point has no open cavity. The mesh is as before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum At {
    /// This vertex is at the point.
    Vertex(VertexId),
    /// The cavity was set back.
    SetBack(Setback),
}

/// The outcome for a kernel vertex.
pub(crate) enum Placed {
    New,
    At(VertexId),
}

/// The exactly Delaunay mesh of a point set.
#[derive(Debug)]
pub struct Mesh {
    pub(crate) topology: Topology,
    pub(crate) geometry: Geometry,
    pub(crate) cavity: Cavity,
    /// Public number by kernel vertex; entry 0 stands for the vertex at infinity. [`VACANT`] where
    /// a vertex was removed.
    pub(crate) numbers: Vec<Vertex>,
    /// The kernel vertices that were removed, last in first out.
    pub(crate) vacant: Vec<VertexId>,
    /// The memory of removals.
    pub(crate) filling: Filling,
    pub(crate) rim: Rim,
    pub(crate) duplicates: Vec<Duplicate>,
    mode: Mode,
    /// Number that the next inserted point gets.
    pub(crate) next_number: Vertex,
    /// The start of the next walk.
    hint: TetId,
    /// Made as somebody asks for it.
    pub(crate) numbering: OnceLock<Numbering>,
}

/// A corner of the first tetrahedron.
#[derive(Clone, Copy)]
pub(crate) struct Corner {
    /// Kernel coordinates.
    pub(crate) p: Point,
    pub(crate) number: Vertex,
}

impl Opens for Mesh {
    #[inline(always)]
    fn cavity(&self) -> &Cavity {
        &self.cavity
    }

    fn set_back(&mut self) {
        self.cavity.set_back(&mut self.topology);
    }
}

impl OpenCavity<'_, Mesh> {
    /// Fills the cavity with the star of its point; returns the new vertex.
    #[inline(always)]
    pub fn fill(self, p: Point, number: Vertex) -> VertexId {
        self.end(|mesh| mesh.fill(p, number))
    }
}

impl Mesh {
    /// The mesh of one tetrahedron; `corners` are positively oriented kernel coordinates.
    pub(crate) fn start(
        mut geometry: Geometry,
        mode: Mode,
        corners: [Corner; 4],
        tets: usize,
    ) -> Self {
        let mut topology = Topology::with_capacity(tets);
        let mut numbers = vec![VACANT];
        for Corner { p, number } in corners {
            geometry.push(p);
            numbers.push(number);
        }
        let corner = [1, 2, 3, 4].map(VertexId::new);
        topology.start(corner);
        geometry.created(
            topology.slots(),
            &Star { tets: &[TetId::default()], rim: &corner[..3], faces: &[[0, 1, 2, 0]] },
            &corners[3].p,
        );
        Self {
            topology,
            geometry,
            cavity: Cavity::default(),
            numbers,
            vacant: Vec::new(),
            filling: Filling::default(),
            rim: Rim::default(),
            duplicates: Vec::new(),
            mode,
            next_number: 0,
            hint: TetId::default(),
            numbering: OnceLock::new(),
        }
    }

    /// Inserts a point given in kernel coordinates, as public number `number`.
    #[inline]
    pub(crate) fn place<A: Admission>(
        &mut self,
        p: Point,
        number: Vertex,
        admission: &mut A,
    ) -> Result<Placed, Setback> {
        match self.begin(p, self.hint, admission) {
            Ok(open) => {
                open.fill(p, number);
                Ok(Placed::New)
            }
            Err(At::Vertex(v)) => Ok(Placed::At(v)),
            Err(At::SetBack(setback)) => Err(setback),
        }
    }

    /// Counts predicate calls that were made beside the mesh.
    #[doc(hidden)]
    pub fn add_stats(&mut self, stats: PredicateStats) {
        self.geometry.stats += stats;
    }

    /// Fills the open cavity with the star of its point; returns the new vertex.
    #[inline]
    pub(crate) fn fill(&mut self, p: Point, number: Vertex) -> VertexId {
        let v = self.enter(p, number);
        self.fill_with(v, p);
        v
    }

    /// Enters a vertex that no tetrahedron has yet.
    #[inline(always)]
    pub(crate) fn enter(&mut self, p: Point, number: Vertex) -> VertexId {
        let v = self.vacant.pop().unwrap_or(VertexId::at(self.numbers.len()));
        self.geometry.put_point(v, p);
        match self.numbers.get_mut(v.index()) {
            Some(place) => *place = number,
            None => self.numbers.push(number),
        }
        if let Some(numbering) = self.numbering.get_mut()
            && !numbering.note(number, v)
        {
            self.renumbered();
        }
        v
    }

    /// Fills the open cavity of the point `p` with the star of vertex `v`, which is there.
    #[inline(always)]
    pub(crate) fn fill_with(&mut self, v: VertexId, p: Point) {
        self.cavity.reserve_vertices(self.numbers.len());
        self.hint = self.cavity.fill(&mut self.topology, v);
        self.geometry.created(self.topology.slots(), &self.cavity.star(), &p);
        self.geometry.stats.insphere_calls += self.cavity.tests() as u64;
    }

    /// The open cavity, or the last one filled.
    #[doc(hidden)]
    pub fn cavity(&self) -> &Cavity {
        &self.cavity
    }

    /// Starts the next walk at a tetrahedron.
    pub(crate) fn set_hint(&mut self, t: TetId) {
        self.hint = t;
    }

    /// A tetrahedron of the last star.
    #[doc(hidden)]
    pub fn hint(&self) -> TetId {
        self.hint
    }

    /// Says that kernel coordinates are the input's times 2^`exponent`. The caller has made the
    /// mesh of coordinates scaled so, all inside the exactness window.
    #[doc(hidden)]
    pub fn scaled_by(&mut self, exponent: i32) {
        self.mode = Mode::Rescaled { exponent };
    }

    /// Inserts one point.
    ///
    /// Cost: a walk from the last insertion, then O(cavity). A point outside the exactness window
    /// switches the mesh to the big-integer mode, for good.
    pub fn insert(&mut self, p: Point) -> Result<Inserted, InsertError> {
        self.insert_with(p, &mut AdmitAll)
    }

    /// Inserts one point; `admission` is asked before each tetrahedron of the closure is taken.
    ///
    /// Refused, the mesh is as before, bit for bit, and the insertion may be tried again. If the
    /// admission panics, the cavity is set back first: the mesh is as before then, too.
    ///
    /// Cost: that of [`Mesh::insert`]; a point outside the exactness window copies the coordinates
    /// and cached spheres, O(n), once per try.
    pub fn insert_with<A: Admission>(
        &mut self,
        p: Point,
        admission: &mut A,
    ) -> Result<Inserted, InsertError> {
        let number = self.next_number;
        if number as usize >= ltbw_exact::points::MAX_POINTS {
            let count = number as usize + 1;
            return Err(PointError::TooMany { count, limit: ltbw_exact::points::MAX_POINTS }.into());
        }
        let mut guarded = Guarded { admission, panic: None };
        let placed = match self.mode.admit(p)? {
            Some(kernel) => self.place(kernel, number, &mut guarded),
            None => {
                let saved = (self.geometry.clone(), self.mode);
                let kernel = self.widen(p);
                let placed = self.place(kernel, number, &mut guarded);
                if placed.is_err() {
                    (self.geometry, self.mode) = saved;
                }
                placed
            }
        };
        if let Some(panic) = guarded.panic {
            resume_unwind(panic);
        }
        match placed {
            Ok(Placed::New) => {
                self.next_number += 1;
                Ok(Inserted::Vertex(number))
            }
            Ok(Placed::At(v)) => Ok(Inserted::Duplicate(self.numbers[v.index()])),
            Err(Setback::Refused(tet)) => Err(InsertError::Refused { tet }),
            Err(Setback::Full) => Err(InsertError::TooManyTets { limit: self.topology.limit() }),
        }
    }

    /// Switches to the big-integer mode and returns `p` in its coordinates: the input's own.
    fn widen(&mut self, p: Point) -> Point {
        let mode = self.mode;
        self.geometry.widen(|q| mode.from_kernel(*q));
        self.mode = Mode::Wide;
        p.map(|c| c + 0.0)
    }

    /// Number of vertices: distinct points.
    pub fn num_vertices(&self) -> usize {
        self.numbers.len() - 1 - self.vacant.len()
    }

    /// Number of finite tetrahedra.
    pub fn num_tets(&self) -> usize {
        self.topology.len() - self.topology.ghosts()
    }

    /// Number of hull facets (triangles).
    pub fn num_hull_faces(&self) -> usize {
        self.topology.ghosts()
    }

    /// Bytes held by the mesh's large arrays.
    pub fn memory_bytes(&self) -> usize {
        self.topology.memory_bytes()
            + self.geometry.memory_bytes()
            + self.numbers.capacity() * size_of::<Vertex>()
            + self.vacant.capacity() * size_of::<VertexId>()
    }

    /// Predicate calls so far.
    pub fn predicate_stats(&self) -> PredicateStats {
        self.geometry.stats
    }

    /// The mode of computing with the points.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The combinatorial mesh, ghosts included, in kernel vertex numbers.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Coordinates, as the kernel computes with them, of a finite kernel vertex.
    #[doc(hidden)]
    #[inline]
    pub fn kernel_point(&self, v: VertexId) -> Point {
        *self.geometry.point(v)
    }

    /// Sets the number that the next inserted point gets.
    #[doc(hidden)]
    pub fn set_next_number(&mut self, next: Vertex) {
        self.next_number = next;
    }

    /// Public number by kernel vertex; entry 0 stands for the vertex at infinity.
    #[doc(hidden)]
    pub fn numbers(&self) -> &[Vertex] {
        &self.numbers
    }

    /// Public numbers, to be changed: those of finite vertices have to stay different.
    #[doc(hidden)]
    pub fn numbers_mut(&mut self) -> &mut [Vertex] {
        self.renumbered();
        &mut self.numbers
    }

    /// Kernel vertices by public number.
    pub(crate) fn numbering(&self) -> &Numbering {
        self.numbering.get_or_init(|| Numbering::new(&self.numbers, &self.duplicates))
    }

    /// Some vertices have other numbers than before.
    pub(crate) fn renumbered(&mut self) {
        self.numbering.take();
    }

    /// The public number of a finite kernel vertex.
    pub fn number(&self, v: VertexId) -> Option<Vertex> {
        if v == INFINITE { None } else { self.numbers.get(v.index()).copied() }
    }

    /// The side of `t`'s cached sphere on which a point in kernel coordinates lies, if it tells.
    pub(crate) fn cached_side(&self, t: TetId, p: &Point) -> Option<Sign> {
        self.geometry.cached_side(t, p)
    }

    /// The cached spheres, to the bit: for tests that a refusal leaves no trace.
    #[doc(hidden)]
    pub fn spheres_fingerprint(&self) -> Vec<[u32; 4]> {
        self.geometry.spheres_fingerprint()
    }

    /// All vertices with their coordinates, in no particular order.
    pub fn vertices(&self) -> impl Iterator<Item = (Vertex, Point)> + '_ {
        let points = self.geometry.points();
        let vertices = self.numbers.iter().zip(points).skip(1);
        let there = vertices.filter(|&(&number, _)| number != VACANT);
        there.map(|(&number, p)| (number, self.mode.from_kernel(*p)))
    }

    /// The duplicates, ascending.
    pub fn duplicates(&self) -> &[Duplicate] {
        &self.duplicates
    }

    /// The finite tetrahedra, by id.
    pub fn tet_ids(&self) -> impl Iterator<Item = TetId> + '_ {
        self.topology.finite().map(|(t, _)| t)
    }

    /// The vertices of a finite tetrahedron, positively oriented; `None` if `t` is not one.
    pub fn tet(&self, t: TetId) -> Option<[Vertex; 4]> {
        if t.index() >= self.topology.slots() {
            return None;
        }
        let tet = self.topology.tet(t);
        let finite = !tet.is_free() && !tet.is_ghost();
        finite.then(|| tet.vertices().map(|v| self.numbers[v.index()]))
    }

    /// The neighbour of tetrahedron `t` opposite its vertex `slot`: `None` on the hull, or if
    /// there is no such tetrahedron or slot.
    pub fn neighbour(&self, t: TetId, slot: usize) -> Option<TetId> {
        self.tet(t)?;
        let u = tet_of(*self.topology.tet(t).neighbours().get(slot)?);
        (!self.topology.tet(u).is_ghost()).then_some(u)
    }

    /// The finite tetrahedra, positively oriented.
    pub fn tets(&self) -> impl Iterator<Item = [Vertex; 4]> + '_ {
        self.topology.finite().map(|(_, t)| t.vertices().map(|v| self.numbers[v.index()]))
    }

    /// The hull facets; seen from outside their vertices turn counterclockwise.
    pub fn hull_facets(&self) -> impl Iterator<Item = [Vertex; 3]> + '_ {
        self.topology.iter().filter(|(_, t)| t.is_ghost()).map(|(_, t)| {
            let [a, b, c, _] = t.vertices().map(|v| self.numbers[v.index()]);
            [a, b, c]
        })
    }

    /// Every triangle once, hull facets included.
    pub fn faces(&self) -> impl Iterator<Item = [Vertex; 3]> + '_ {
        self.topology.finite().flat_map(move |(id, t)| {
            let (v, n) = (t.vertices().map(|v| self.numbers[v.index()]), t.neighbours());
            (0..4).filter_map(move |slot| {
                let u = tet_of(n[slot]);
                // A face of two finite tetrahedra is given by the one with the smaller id.
                let ours = u > id || self.topology.tet(u).is_ghost();
                ours.then(|| match slot {
                    0 => [v[1], v[3], v[2]],
                    1 => [v[0], v[2], v[3]],
                    2 => [v[0], v[3], v[1]],
                    _ => [v[0], v[1], v[2]],
                })
            })
        })
    }

    /// The canonical mesh hash `ltbw.mesh/1` ([`crate::hash`]).
    pub fn hash(&self) -> Result<MeshHash, HashError> {
        let points = self.geometry.points();
        let points = points.get(1..self.numbers.len()).unwrap_or_default();
        let points: Vec<Point> = points.iter().map(|&p| self.mode.from_kernel(p)).collect();
        let finite = self.topology.finite();
        let tets: Vec<[u32; 4]> =
            finite.map(|(_, t)| t.vertices().map(|v| v.number() - 1)).collect();
        canonical_hash(&points, &tets)
    }
}
