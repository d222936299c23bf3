//! The hole that a vertex leaves: its star, and the tetrahedra that are to fill it.
//!
//! The star of a vertex is opened like a cavity: its boundary is the *link* of the vertex. The hole
//! is filled from its faces inwards. In front of a face goes the tetrahedron that [`Front`] tells;
//! where two faces have the same corners they are one. All is planned before anything is written.
//!
//! Cost: one question to [`Front`] for each tetrahedron that has none on one side yet.

use super::{BoundaryFace, Cavity, OTHERS};
use crate::topology::{FaceId, INFINITE, TetId, Topology, VertexId, slot_of, tet_of};

/// Stands for the vertex at infinity among corners of the hole.
pub(crate) const BEYOND: u32 = u32::MAX;

/// Tells what lies in front of a face.
pub(crate) trait Front {
    /// The corner, by its place in `corners`, with which `face` makes a tetrahedron of the mesh to
    /// be; the corner before the face is positively oriented. `None` if the face is on the hull.
    fn apex(&mut self, corners: &[VertexId], face: [u32; 3]) -> Option<u32>;
}

/// The hole cannot be filled: no mesh that the kernel made has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Defect;

/// The other side of a face.
#[derive(Clone, Copy, Debug)]
enum Side {
    /// A face of a tetrahedron that stays.
    Outer(FaceId),
    /// A face of a planned tetrahedron, by its place.
    Planned(FaceId),
}

/// A face of what is left of the hole.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// Its corners, by place: with a point of the hole before them they are positively oriented.
    v: [u32; 3],
    behind: Side,
    is_closed: bool,
}

/// A tetrahedron to be.
#[derive(Clone, Copy, Debug)]
struct Planned {
    v: [VertexId; 4],
    /// Its neighbours among the planned ones, by place.
    n: [FaceId; 4],
}

/// A planned face that meets one that stays.
#[derive(Clone, Copy, Debug)]
struct Seam {
    planned: FaceId,
    outer: FaceId,
}

/// The filling of a hole, and the memory that it reuses.
#[derive(Debug, Default)]
pub(crate) struct Filling {
    /// The finite vertices of the link.
    corners: Vec<VertexId>,
    names: Table<1>,
    faces: Vec<Face>,
    by_corners: Table<3>,
    tets: Vec<Planned>,
    seams: Vec<Seam>,
    open: usize,
}

impl Filling {
    /// The finite vertices of the link; [`Front`] is asked by their places.
    pub(crate) fn corners(&self) -> &[VertexId] {
        &self.corners
    }

    /// The number of finite tetrahedra.
    pub(crate) fn finite(&self) -> usize {
        self.tets.iter().filter(|tet| tet.v[3] != INFINITE).count()
    }

    /// The corners of the planned tetrahedra, in the order of [`Cavity::fill_hole`].
    pub(crate) fn tets(&self) -> impl Iterator<Item = [VertexId; 4]> + '_ {
        self.tets.iter().map(|tet| tet.v)
    }

    /// Takes up the boundary of an open star.
    pub(crate) fn start(&mut self, cavity: &Cavity) -> Result<(), Defect> {
        let count = cavity.boundary.len();
        self.corners.clear();
        self.names.start(count);
        self.faces.clear();
        self.by_corners.start(4 * count);
        self.tets.clear();
        self.seams.clear();
        self.open = 0;
        for &BoundaryFace { v: [a, b, c], outer } in cavity.boundary.iter() {
            let v = [self.name(a), self.name(b), self.name(c)];
            self.meet(Face { v, behind: Side::Outer(outer), is_closed: false })?;
        }
        Ok(())
    }

    /// The place of a vertex of the link.
    #[inline(always)]
    fn name(&mut self, v: VertexId) -> u32 {
        if v == INFINITE {
            return BEYOND;
        }
        let next = self.corners.len() as u32;
        self.names.find([v.number()], next).unwrap_or_else(|| {
            self.corners.push(v);
            next
        })
    }

    /// Plans the tetrahedra of the hole. Ends: every face is met twice at most.
    pub(crate) fn plan(&mut self, front: &mut impl Front) -> Result<(), Defect> {
        let mut next = 0;
        while let Some(&Face { v: face, behind, is_closed }) = self.faces.get(next) {
            next += 1;
            // Ghosts are made from their hull facets.
            if is_closed || face[2] == BEYOND {
                continue;
            }
            let [a, b, c] = face;
            let (v, slot) = match front.apex(&self.corners, face) {
                Some(apex) => ([apex, a, b, c], 0),
                None => ([b, a, c, BEYOND], 3),
            };
            let t = TetId::at(self.tets.len());
            let corner = |k: u32| self.corners.get(k as usize).copied().unwrap_or(INFINITE);
            self.tets.push(Planned { v: v.map(corner), n: [FaceId::default(); 4] });
            self.close(next - 1);
            self.join(FaceId::new(t, slot), behind);
            for (side, others) in OTHERS.iter().enumerate().filter(|&(side, _)| side != slot) {
                // Seen from the other side; the vertex at infinity stays last.
                let [x, y, z] = others.map(|k| v[k]);
                let behind = Side::Planned(FaceId::new(t, side));
                self.meet(Face { v: [y, x, z], behind, is_closed: false })?;
            }
        }
        if self.open == 0 { Ok(()) } else { Err(Defect) }
    }

    fn close(&mut self, face: usize) {
        self.faces[face].is_closed = true;
        self.open -= 1;
    }

    /// Joins a face with one that is there already, or leaves it open.
    fn meet(&mut self, face: Face) -> Result<(), Defect> {
        let mut key = face.v;
        key.sort_unstable();
        let Some(there) = self.by_corners.find(key, self.faces.len() as u32) else {
            self.faces.push(face);
            self.open += 1;
            return Ok(());
        };
        let Face { behind, is_closed, .. } = self.faces[there as usize];
        match face.behind {
            Side::Planned(planned) if !is_closed => {
                self.close(there as usize);
                self.join(planned, behind);
                Ok(())
            }
            _ => Err(Defect),
        }
    }

    fn join(&mut self, face: FaceId, behind: Side) {
        match behind {
            Side::Outer(outer) => self.seams.push(Seam { planned: face, outer }),
            Side::Planned(other) => {
                self.tets[tet_of(face).index()].n[slot_of(face)] = other;
                self.tets[tet_of(other).index()].n[slot_of(other)] = face;
            }
        }
    }
}

impl Cavity {
    /// Opens the star of vertex `v`, which tetrahedron `start` has, as a cavity.
    ///
    /// Afterwards its tetrahedra are marked: call [`Cavity::fill_hole`] or [`Cavity::set_back`].
    /// Ends: each tetrahedron enters once.
    pub(crate) fn open_star(&mut self, topology: &mut Topology, v: VertexId, start: TetId) {
        self.tets.clear();
        self.boundary.clear();
        (self.ghosts, self.tests) = (0, 0);
        topology.mark(start);
        self.tets.push_some([start; 4], 1);
        let mut next = 0;
        while let Some(&t) = self.tets.get(next) {
            next += 1;
            let tet = *topology.tet(t);
            let (corners, n) = (tet.vertices(), tet.neighbours());
            self.ghosts += usize::from(corners[3] == INFINITE);
            for (slot, &face) in n.iter().enumerate() {
                if corners[slot] == v {
                    let link = OTHERS[slot].map(|k| corners[k]);
                    self.boundary.push_some([BoundaryFace { v: link, outer: face }; 4], 1);
                } else if !topology.tet(tet_of(face)).is_marked() {
                    topology.mark(tet_of(face));
                    self.tets.push_some([tet_of(face); 4], 1);
                    for beyond in topology.tet(tet_of(face)).neighbours() {
                        topology.prefetch(tet_of(beyond));
                    }
                }
            }
        }
    }

    /// The number of finite tetrahedra of the open cavity.
    pub(crate) fn finite(&self) -> usize {
        self.tets.len() - self.ghosts
    }

    /// Are there slots for what was planned?
    pub(crate) fn has_room_for(&self, topology: &Topology, filling: &Filling) -> bool {
        topology.reserve(filling.tets.len().saturating_sub(self.tets.len())).is_ok()
    }

    /// Replaces the open star by what was planned, for which there has to be room; returns the
    /// slots, in the order of the plan. The star's slots are reused first.
    pub(crate) fn fill_hole(&mut self, topology: &mut Topology, filling: &Filling) -> &[TetId] {
        let Filling { tets, seams, .. } = filling;
        let reused = self.tets.len().min(tets.len());
        self.created.clear();
        self.created.extend_from_slice(&self.tets[..reused]);
        self.created.extend((reused..tets.len()).map(|_| topology.take()));
        let created = &self.created;
        let placed = |face: FaceId| FaceId::new(created[tet_of(face).index()], slot_of(face));
        topology.add_ghosts(-(self.ghosts as isize));
        for (&t, tet) in created.iter().zip(tets) {
            topology.write(t, tet.v, tet.n.map(placed));
        }
        for &Seam { planned, outer } in seams {
            topology.link(placed(planned), outer);
        }
        for &t in &self.tets[reused..] {
            topology.release(t);
        }
        // The tetrahedra made are no star.
        self.rim_len = 0;
        created
    }
}

/// Numbers by sets of `N` others: a hash table with linear probing, at most half full.
#[derive(Debug)]
struct Table<const N: usize> {
    entries: Vec<Entry<N>>,
    used: usize,
}

#[derive(Clone, Copy, Debug)]
struct Entry<const N: usize> {
    key: [u32; N],
    /// [`NONE`] where there is no entry.
    value: u32,
}

const NONE: u32 = u32::MAX;

impl<const N: usize> Default for Table<N> {
    fn default() -> Self {
        Self { entries: Vec::new(), used: 0 }
    }
}

impl<const N: usize> Table<N> {
    const EMPTY: Entry<N> = Entry { key: [0; N], value: NONE };

    /// Forgets all, and makes room for `count` entries.
    fn start(&mut self, count: usize) {
        self.used = 0;
        self.entries.clear();
        self.entries.resize((2 * count).next_power_of_two().max(16), Self::EMPTY);
    }

    /// The place of `key`, or where it belongs.
    #[inline(always)]
    fn place(&self, key: &[u32; N]) -> usize {
        let mix = |sum: u64, &k: &u32| (sum ^ u64::from(k)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let hash = key.iter().fold(0, mix);
        let last = self.entries.len() - 1;
        let mut place = (hash >> 32) as usize & last;
        // Ends: at most half of the places are taken.
        while self.entries[place].value != NONE && self.entries[place].key != *key {
            place = (place + 1) & last;
        }
        place
    }

    /// The value of `key`; if it has none it gets `value`.
    #[inline]
    fn find(&mut self, key: [u32; N], value: u32) -> Option<u32> {
        let place = self.place(&key);
        let found = self.entries[place].value;
        if found != NONE {
            return Some(found);
        }
        self.entries[place] = Entry { key, value };
        self.used += 1;
        if 2 * self.used > self.entries.len() {
            self.grow();
        }
        None
    }

    #[cold]
    fn grow(&mut self) {
        let mut larger = Self::default();
        larger.start(2 * self.used);
        for entry in self.entries.iter().filter(|entry| entry.value != NONE) {
            let place = larger.place(&entry.key);
            larger.entries[place] = *entry;
        }
        larger.used = self.used;
        *self = larger;
    }
}
