//! The cavity of a point: found by breadth-first search, admitted tetrahedron by tetrahedron,
//! then starred from the point. It never sees a coordinate: geometry is behind `Conflict`.
//!
//! The *cavity* of p is the set of tetrahedra in conflict with p; its *ring* is the set of their
//! face neighbours outside it; both together are the *closure* (paper, section 3; the ring is of
//! face neighbours, see `docs/algorithm.md`). An [`Admission`] is asked before each of them is
//! taken and may refuse; then the mesh is as it was, bit for bit (*setback*).
//!
//! Cost: O(cavity) expected. Cavities of up to 64 boundary vertices are starred by a table of
//! directed edges, larger ones by a hash table.

pub(crate) mod hole;
mod reopen;

use crate::edges::{EdgeTable, Met};
use crate::topology::{FaceId, Full, INFINITE, TetId, Topology, VertexId, tet_of};

/// Decides which tetrahedra conflict with the point in work.
pub(crate) trait Conflict {
    /// A hint that `t` will be asked about soon.
    fn prefetch(&self, t: TetId);

    /// The conflicts of four tetrahedra as far as they are certain at once, as bit masks `(inside,
    /// outside)`. Those in neither mask are asked for with [`Conflict::by_points`].
    fn by_sphere(&self, tets: [TetId; 4]) -> (u32, u32);

    /// Which of the four tetrahedra in the mask `unknown` are in conflict, as a bit mask.
    fn by_points(&mut self, topology: &Topology, tets: [TetId; 4], unknown: u32) -> u32;

    /// Is the point inside the (perturbed) circumsphere of tetrahedron `t`?
    fn in_conflict(&mut self, topology: &Topology, t: TetId) -> bool;
}

/// Why a tetrahedron is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Role {
    /// It conflicts with the point and will be deleted.
    Cavity,
    /// It is a face neighbour of the cavity and stays.
    Ring,
}

/// Says whether a tetrahedron may be taken into the closure of a cavity.
///
/// A ring tetrahedron with several faces on the cavity is asked for once per face.
pub trait Admission {
    /// May tetrahedron `t` be taken? `false` sets the cavity back.
    fn admit(&mut self, t: TetId, role: Role) -> bool;
}

/// Admits everything: the sequential kernel. Compiles to nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct AdmitAll;

impl Admission for AdmitAll {
    #[inline(always)]
    fn admit(&mut self, _: TetId, _: Role) -> bool {
        true
    }
}

impl<F: FnMut(TetId, Role) -> bool> Admission for F {
    fn admit(&mut self, t: TetId, role: Role) -> bool {
        self(t, role)
    }
}

/// Why a cavity could not be filled. The mesh is as before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setback {
    /// The admission refused this tetrahedron.
    Refused(TetId),
    /// No more slots.
    Full,
}

/// Cavities with at most this many boundary vertices use the adjacency table.
pub(crate) const SMALL: usize = 64;
/// A closed triangulated surface with f faces has f / 2 + 2 vertices (Euler, sphere).
pub(crate) const SMALL_BOUNDARY: usize = 2 * SMALL - 4;
/// Bits of a local number in an entry of [`Cavity::local`].
const LOCAL_BITS: u32 = 7;
/// `OTHERS[i]`: the slots other than i in the order in which (p, others) is positively oriented
/// when p stands for vertex i of a positively oriented tetrahedron. Slot 3 stays last, and so
/// does the vertex at infinity.
pub const OTHERS: [[usize; 3]; 4] = [[1, 2, 3], [2, 0, 3], [0, 1, 3], [1, 0, 2]];

/// A face of the cavity's boundary.
#[derive(Clone, Copy, Debug, Default)]
struct BoundaryFace {
    /// Its vertices: with the point before them they are a positively oriented tetrahedron.
    v: [VertexId; 3],
    /// The face seen from outside the cavity.
    outer: FaceId,
}

/// A list that grows without a branch per entry.
#[derive(Clone, Debug, Default)]
struct Buffer<T> {
    data: Vec<T>,
    len: usize,
}

impl<T: Copy + Default> Buffer<T> {
    /// Appends those of `entries` whose bit is set in `mask`.
    #[inline(always)]
    fn push_some(&mut self, entries: [T; 4], mask: u32) {
        if self.data.len() < self.len + 4 {
            self.grow();
        }
        let room = &mut self.data[self.len..self.len + 4];
        let mut count = 0;
        for (slot, entry) in entries.into_iter().enumerate() {
            room[count & 3] = entry;
            count += (mask >> slot & 1) as usize;
        }
        self.len += count;
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        self.data.resize(2 * self.len + 64, T::default());
    }

    #[inline(always)]
    fn clear(&mut self) {
        self.len = 0;
    }
}

impl<T> std::ops::Deref for Buffer<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.data[..self.len]
    }
}

/// The star around a new vertex, in local numbers: what geometry needs to cache spheres.
#[derive(Debug)]
pub struct Star<'a> {
    /// The new tetrahedra.
    pub tets: &'a [TetId],
    /// The vertices of the cavity's boundary, by local number; empty for a large cavity.
    pub rim: &'a [VertexId],
    /// Per new tetrahedron: local numbers of its vertices other than the new one.
    pub faces: &'a [[u8; 4]],
}

/// The cavity in work, and the scratch memory that it reuses.
#[derive(Debug)]
pub struct Cavity {
    tets: Buffer<TetId>,
    boundary: Buffer<BoundaryFace>,
    created: Vec<TetId>,
    /// Ghosts among `tets`.
    ghosts: usize,
    /// Conflict tests that the last search made.
    tests: usize,
    /// Per vertex: `stamp << LOCAL_BITS | local number` of the last cavity that met it.
    local: Vec<u32>,
    stamp: u32,
    rim: [VertexId; 2 * SMALL],
    rim_len: usize,
    faces: [[u8; 4]; 2 * SMALL],
    /// `table[a * SMALL + b]`: the new face on the boundary edge from a to b (local numbers).
    table: Box<[FaceId; SMALL * SMALL]>,
    /// The boundary edges of a large cavity, with the new faces on them.
    edges: EdgeTable,
}

impl Default for Cavity {
    fn default() -> Self {
        Self {
            tets: Buffer::default(),
            boundary: Buffer::default(),
            created: Vec::new(),
            ghosts: 0,
            tests: 0,
            local: Vec::new(),
            stamp: 0,
            rim: [INFINITE; 2 * SMALL],
            rim_len: 0,
            faces: [[0; 4]; 2 * SMALL],
            table: Box::new([FaceId::default(); SMALL * SMALL]),
            edges: EdgeTable::default(),
        }
    }
}

impl Cavity {
    /// A cavity with room for local numbers of `vertices` vertices, whose memory is taken when it
    /// is first written to.
    pub(crate) fn for_vertices(vertices: usize) -> Self {
        Self { local: vec![0; vertices], ..Self::default() }
    }

    /// The tetrahedra of the cavity that was found last.
    pub fn tets(&self) -> std::iter::Copied<std::slice::Iter<'_, TetId>> {
        self.tets.iter().copied()
    }

    /// The vertices of the boundary faces that were found last; the point in
    /// front of them makes a positively oriented tetrahedron.
    pub fn faces(&self) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        self.boundary.iter().map(|border| border.v)
    }

    /// The slots that the last [`Cavity::fill`] did not use again.
    pub(crate) fn freed(&self) -> &[TetId] {
        &self.tets[self.boundary.len().min(self.tets.len())..]
    }

    /// The star that was made last.
    #[inline(always)]
    pub fn star(&self) -> Star<'_> {
        Star {
            tets: &self.created,
            rim: &self.rim[..self.rim_len],
            faces: &self.faces[..self.created.len().min(2 * SMALL)],
        }
    }

    /// The boundary faces of the open cavity: each one's vertices, which are a positively oriented
    /// tetrahedron with the point before them, and the face seen from outside. After the filling
    /// the k-th belongs to the k-th tetrahedron of the star.
    pub fn boundary(&self) -> impl Iterator<Item = ([VertexId; 3], FaceId)> + '_ {
        self.boundary.iter().map(|w| (w.v, w.outer))
    }

    /// Number of conflict tests that the last search made.
    #[inline(always)]
    pub(crate) fn tests(&self) -> usize {
        self.tests
    }

    /// Finds the cavity of `point` from `start`, which must be in conflict with it.
    ///
    /// Afterwards the cavity's tetrahedra are marked: call [`Cavity::fill`] or
    /// [`Cavity::set_back`]. Refused, the mesh is as before. Ends: each tetrahedron enters once.
    /// `FAR`: neighbours are far apart in memory, and fetched as soon as they are known.
    #[inline(never)]
    pub(crate) fn expand<C: Conflict, A: Admission, const FAR: bool>(
        &mut self,
        topology: &mut Topology,
        start: TetId,
        conflict: &mut C,
        admission: &mut A,
    ) -> Result<(), Setback> {
        self.tets.clear();
        self.boundary.clear();
        self.ghosts = 0;
        if !admission.admit(start, Role::Cavity) {
            return Err(Setback::Refused(start));
        }
        topology.mark(start);
        self.tets.push_some([start; 4], 1);
        let (mut next, mut ahead) = (0, 1);
        while next < self.tets.len() {
            let t = self.tets[next];
            next += 1;
            ahead = if FAR { ahead } else { next };
            // The next one's neighbours, and those of all that follow if they are far apart.
            while let Some(&t) = self.tets.get(ahead).filter(|_| FAR || ahead == next) {
                ahead += 1;
                for face in topology.tet(t).neighbours() {
                    conflict.prefetch(tet_of(face));
                    topology.prefetch(tet_of(face));
                }
            }
            let tet = *topology.tet(t);
            let (v, n) = (tet.vertices(), tet.neighbours());
            self.ghosts += usize::from(v[3] == INFINITE);
            let mut open = 0;
            for (slot, &face) in n.iter().enumerate() {
                open |= u32::from(!topology.tet(tet_of(face)).is_marked()) << slot;
            }
            let (mut inside, outside) = conflict.by_sphere(n.map(tet_of));
            let unknown = !(inside | outside) & open;
            if unknown != 0 {
                inside |= conflict.by_points(topology, n.map(tet_of), unknown);
            }
            let (take, leave) = (inside & open, !inside & open);
            for (slot, &face) in n.iter().enumerate().filter(|&(slot, _)| open >> slot & 1 == 1) {
                let role = if take >> slot & 1 == 1 { Role::Cavity } else { Role::Ring };
                if !admission.admit(tet_of(face), role) {
                    self.set_back(topology);
                    return Err(Setback::Refused(tet_of(face)));
                }
            }
            // Whether a neighbour is in the cavity is nearly random: no branch depends on it.
            for (slot, &face) in n.iter().enumerate() {
                topology.mark_if(tet_of(face), take >> slot & 1 == 1);
            }
            self.tets.push_some(n.map(tet_of), take);
            let border =
                |slot: usize| BoundaryFace { v: OTHERS[slot].map(|k| v[k]), outer: n[slot] };
            self.boundary.push_some([border(0), border(1), border(2), border(3)], leave);
        }
        self.tests = self.tets.len() + self.boundary.len() - 1;
        self.make_room(topology)
    }

    /// Makes sure that there are slots for the star; else the cavity is set back.
    fn make_room(&mut self, topology: &mut Topology) -> Result<(), Setback> {
        let fresh = self.boundary.len().saturating_sub(self.tets.len());
        if topology.reserve(fresh) == Err(Full) {
            self.set_back(topology);
            return Err(Setback::Full);
        }
        Ok(())
    }

    /// Gives the cavity up: the mesh is as before [`Cavity::expand`], bit for bit. Its faces can
    /// still be read.
    pub(crate) fn set_back(&mut self, topology: &mut Topology) {
        for &t in self.tets.iter() {
            topology.unmark(t);
        }
    }

    /// Replaces the cavity by the star of the point; returns one of its tetrahedra.
    ///
    /// The cavity's slots are reused first.
    #[inline(never)]
    pub(crate) fn fill(&mut self, topology: &mut Topology, point: VertexId) -> TetId {
        let reused = self.tets.len().min(self.boundary.len());
        self.created.clear();
        self.created.extend_from_slice(&self.tets[..reused]);
        for _ in reused..self.boundary.len() {
            self.created.push(topology.take());
        }
        if self.boundary.len() <= SMALL_BOUNDARY {
            self.fill_small(topology, point);
        } else {
            self.fill_large(topology, point);
        }
        for &t in &self.tets[reused..] {
            topology.release(t);
        }
        let ghosts = self.boundary.iter().filter(|w| w.v[2] == INFINITE).count();
        topology.add_ghosts(ghosts as isize - self.ghosts as isize);
        self.created[self.created.len() - 1]
    }

    /// Writes the star with the adjacency table. Every boundary edge is passed once in each
    /// direction: each new tetrahedron stores its faces under its own direction, then finds its
    /// neighbours under the opposite one. No search and no branch.
    #[inline(never)]
    fn fill_small(&mut self, topology: &mut Topology, point: VertexId) {
        if self.stamp == u32::MAX >> LOCAL_BITS {
            self.local.fill(0);
            self.stamp = 0;
        }
        self.stamp += 1;
        let base = self.stamp << LOCAL_BITS;
        let Self { boundary, created, local, rim, faces, table, .. } = self;
        let table = &mut **table;
        let at = |a: u8, b: u8| (a as usize % SMALL) * SMALL + b as usize % SMALL;
        let mut count = 0u32;
        let mut name = |v: VertexId| {
            let entry = &mut local[v.index()];
            let fresh = *entry < base;
            *entry = if fresh { base | count } else { *entry };
            rim[count as usize % (2 * SMALL)] = v;
            count += u32::from(fresh);
            (*entry & ((1 << LOCAL_BITS) - 1)) as u8
        };
        for ((border, &t), face) in boundary.iter().zip(&*created).zip(&mut *faces) {
            let [a, b, c] = [name(border.v[0]), name(border.v[1]), name(border.v[2])];
            table[at(a, b)] = FaceId::new(t, 3);
            table[at(b, c)] = FaceId::new(t, 1);
            table[at(c, a)] = FaceId::new(t, 2);
            *face = [a, b, c, 0];
        }
        self.rim_len = count as usize;
        for ((border, &t), &[a, b, c, _]) in boundary.iter().zip(&*created).zip(&*faces) {
            let [x, y, z] = border.v;
            let n = [border.outer, table[at(c, b)], table[at(a, c)], table[at(b, a)]];
            topology.put(t, [point, x, y, z], n);
        }
    }

    /// Writes the star of a large cavity: every boundary edge joins two new faces.
    #[cold]
    fn fill_large(&mut self, topology: &mut Topology, point: VertexId) {
        self.rim_len = 0;
        self.edges.start(self.boundary.len());
        for (border, &t) in self.boundary.iter().zip(&self.created) {
            let [a, b, c] = border.v;
            topology.put(t, [point, a, b, c], [border.outer; 4]);
            for (p, q, slot) in [(a, b, 3), (b, c, 1), (c, a, 2)] {
                let face = FaceId::new(t, slot);
                if let Met::Face(other) = self.edges.meet(p.number(), q.number(), face) {
                    topology.link(other, face);
                }
            }
        }
    }

    /// Makes room for local numbers of `vertices` vertices (the one at infinity included).
    #[inline(always)]
    pub(crate) fn reserve_vertices(&mut self, vertices: usize) {
        if self.local.len() < vertices {
            // Numbers of earlier cavities are not needed: memory that nobody has touched yet.
            (self.local, self.stamp) = (vec![0; vertices.next_power_of_two()], 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::invariants::{check_i1, check_i2, check_i3, check_i4};

    /// A conflict with one tetrahedron and no other.
    struct Only(TetId);

    impl Conflict for Only {
        fn prefetch(&self, _: TetId) {}

        fn by_sphere(&self, tets: [TetId; 4]) -> (u32, u32) {
            // Says nothing of the last one.
            let inside = (0..3).filter(|&k| tets[k] == self.0).map(|k| 1 << k).sum::<u32>();
            (inside, !inside & 7)
        }

        fn by_points(&mut self, _: &Topology, tets: [TetId; 4], unknown: u32) -> u32 {
            (0..4).filter(|&k| unknown >> k & 1 == 1 && tets[k] == self.0).map(|k| 1 << k).sum()
        }

        fn in_conflict(&mut self, _: &Topology, t: TetId) -> bool {
            t == self.0
        }
    }

    type Both<'b> = (&'b mut Cavity, &'b mut Topology);

    fn open((own, all): Both<'_>, t: TetId, by: &mut impl Admission) -> Result<(), Setback> {
        own.expand::<_, _, true>(all, t, &mut Only(t), by)
    }

    /// Splits a tetrahedron `count` times, with a cavity whose stamp starts at `stamp`.
    fn split(count: u32, stamp: u32) -> Topology {
        let mut topology = Topology::default();
        topology.start([1, 2, 3, 4].map(VertexId::new));
        let mut cavity = Cavity { stamp, ..Cavity::default() };
        let mut t = TetId::default();
        for v in 5..5 + count {
            cavity.reserve_vertices(v as usize + 1);
            open((&mut cavity, &mut topology), t, &mut AdmitAll).expect("all are admitted");
            assert_eq!((cavity.tets.len(), cavity.boundary.len(), cavity.tests()), (1, 4, 4));
            t = cavity.fill(&mut topology, VertexId::new(v));
            assert_eq!((cavity.star().tets.len(), cavity.star().rim.len()), (4, 4));
        }
        for check in [check_i1, check_i2, check_i3, check_i4] {
            check(&topology).expect("an invariant");
        }
        assert_eq!((topology.len(), topology.ghosts()), (5 + 3 * count as usize, 4));
        topology
    }

    /// Local numbers of old cavities are told from new ones by a stamp, which starts again when
    /// its bits are used up.
    #[test]
    fn the_stamp_wraps_around() {
        let last = u32::MAX >> LOCAL_BITS;
        let expected = split(12, 0);
        for stamp in [1, last - 12, last - 11, last - 5, last - 1, last] {
            assert!(split(12, stamp) == expected, "from {stamp}");
        }
    }

    #[test]
    fn what_conflicts_is_decided_once_and_only_if_open() {
        let mut topology = Topology::default();
        topology.start([1, 2, 3, 4].map(VertexId::new));
        let before = topology.clone();
        let (first, mut asked) = (TetId::default(), Vec::new());
        let mut admission = |t: TetId, role: Role| {
            asked.push((t, role));
            true
        };
        let mut cavity = Cavity::default();
        open((&mut cavity, &mut topology), first, &mut admission).expect("admitted");
        let ring = topology.tet(first).neighbours().map(|n| (tet_of(n), Role::Ring));
        assert_eq!(asked, [vec![(first, Role::Cavity)], ring.to_vec()].concat());
        assert!(topology.tet(first).is_marked());
        cavity.set_back(&mut topology);
        assert!(topology == before);
        let mut no_ring = |_, role| role == Role::Cavity;
        let refused = open((&mut cavity, &mut topology), first, &mut no_ring);
        assert_eq!(refused, Err(Setback::Refused(ring[0].0)));
        assert!(topology == before);
    }
}
