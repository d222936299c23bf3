//! A query point among the points of a mesh, in coordinates in which the predicates are right for
//! both; point location by a remembering walk.
//!
//! Kernel coordinates are the input's times a power of two ([`Mode::Rescaled`]) or the input's
//! own. A query point that lies in the exactness window under the same scale is computed with
//! there. Any other is computed with in the input's coordinates, by the predicates for any
//! coordinates: the mesh is not touched. Points have the input's coordinates bit for bit.

use crate::mesh::Mesh;
use crate::topology::{INFINITE, TetId, VertexId, slot_of, tet_of};
use ltbw_exact::Point;
use ltbw_exact::points::{Mode, PointError};
use ltbw_exact::predicates::{Sign, distance, exact, filter, perturb};
use std::cmp::Ordering;

/// Which predicates are right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Frame {
    /// Kernel coordinates, all in the exactness window: filters need no guard.
    Window,
    /// The input's coordinates, any finite ones.
    Any,
}

/// A query point and the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target<'m> {
    mesh: &'m Mesh,
    p: Point,
    frame: Frame,
}

/// The end of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spot {
    /// In the closure of this finite tetrahedron; bit i: on the face opposite vertex i.
    Inside(TetId, u8),
    /// Strictly beyond the hull facet of this ghost.
    Outside(TetId),
}

/// The faces of a tetrahedron: opposite `i`, its vertices with the target appended in the place
/// of vertex i, so that the sign is positive for a target on the side of vertex i.
const FACES: [[usize; 3]; 4] = [[2, 1, 3], [3, 0, 2], [1, 0, 3], [0, 1, 2]];

impl<'m> Target<'m> {
    pub(super) fn new(mesh: &'m Mesh, p: Point) -> Result<Self, PointError> {
        let mode = mesh.mode();
        Ok(match mode.admit(p)? {
            Some(p) if mode != Mode::Wide => Self { mesh, p, frame: Frame::Window },
            _ => Self { mesh, p: p.map(|c| c + 0.0), frame: Frame::Any },
        })
    }

    /// A vertex in the coordinates of this target.
    #[inline(always)]
    pub(super) fn at(&self, v: VertexId) -> Point {
        let p = self.mesh.kernel_point(v);
        match self.frame {
            Frame::Window => p,
            Frame::Any => self.mesh.mode().from_kernel(p),
        }
    }

    /// Sign of orient3d of three vertices and the target.
    #[inline(always)]
    fn orient(&self, [a, b, c]: [VertexId; 3]) -> Sign {
        let p = &self.p;
        let [a, b, c] = [self.at(a), self.at(b), self.at(c)];
        let fast = match self.frame {
            Frame::Window => filter::orient3d_window(&a, &b, &c, p),
            Frame::Any => filter::orient3d_any(&a, &b, &c, p),
        };
        fast.unwrap_or_else(|| exact::orient3d(&a, &b, &c, p))
    }

    /// Compares vertices by distance from the target, then by (x, y, z).
    pub(super) fn cmp_near(&self, a: VertexId, b: VertexId) -> Ordering {
        let (a, b) = (self.at(a), self.at(b));
        let by_distance = distance::cmp_distance(&self.p, &a, &b);
        by_distance.then_with(|| ltbw_exact::predicates::cmp_xyz(&a, &b))
    }

    /// Is the target, which must not be a vertex, inside the perturbed circumsphere of `t`?
    pub(super) fn conflicts(&self, t: TetId) -> bool {
        let p = &self.p;
        let [a, b, c, d] = self.mesh.topology().tet(t).vertices();
        if d == INFINITE {
            let beyond = self.orient([a, b, c]);
            if !beyond.is_zero() {
                return beyond.is_positive();
            }
            let [a, b, c] = [a, b, c].map(|v| self.at(v));
            return perturb::side_of_circle(&a, &b, &c, p).is_positive();
        }
        if self.frame == Frame::Window
            && let Some(side) = self.mesh.cached_side(t, p)
        {
            return side.is_positive();
        }
        let [a, b, c, d] = [a, b, c, d].map(|v| self.at(v));
        perturb::side_of_sphere(&a, &b, &c, &d, p).is_positive()
    }

    /// Walks from tetrahedron `start` to the target: across a face that has the target strictly
    /// on its far side, never back through the face just crossed.
    ///
    /// In a Delaunay triangulation such a walk visits no tetrahedron twice (Edelsbrunner,
    /// Combinatorica 10, 1990); the bound only guards it.
    pub(super) fn walk(&self, start: TetId) -> Spot {
        let topology = self.mesh.topology();
        let mut t = start;
        if topology.tet(t).is_ghost() {
            t = tet_of(topology.tet(t).neighbours()[3]);
        }
        let mut entry = 4; // no face
        'walk: for _ in 0..=topology.slots() {
            let tet = topology.tet(t);
            if tet.is_ghost() {
                return Spot::Outside(t);
            }
            let v = tet.vertices();
            let mut zeros = 0u8;
            for (slot, face) in FACES.iter().enumerate() {
                // Through the face of entry the walk came from its strictly negative side.
                if slot == entry {
                    continue;
                }
                match self.orient(face.map(|k| v[k])) {
                    Sign::Positive => {}
                    Sign::Zero => zeros |= 1 << slot,
                    Sign::Negative => {
                        let next = tet.neighbours()[slot];
                        (t, entry) = (tet_of(next), slot_of(next));
                        continue 'walk;
                    }
                }
            }
            return Spot::Inside(t, zeros);
        }
        self.search()
    }

    /// Finds the target by looking at every tetrahedron: the slow twin of [`Target::walk`].
    #[cold]
    pub(super) fn search(&self) -> Spot {
        let topology = self.mesh.topology();
        let mut beyond = TetId::default();
        for (t, tet) in topology.iter() {
            let v = tet.vertices();
            if tet.is_ghost() {
                if self.orient([v[0], v[1], v[2]]).is_positive() {
                    beyond = t;
                }
                continue;
            }
            let sides = FACES.map(|f| self.orient(f.map(|k| v[k])));
            if !sides.contains(&Sign::Negative) {
                let bit = |slot: usize| u8::from(sides[slot].is_zero()) << slot;
                return Spot::Inside(t, bit(0) | bit(1) | bit(2) | bit(3));
            }
        }
        // The finite tetrahedra fill the hull: in none of them, the target is beyond a facet.
        Spot::Outside(beyond)
    }
}
