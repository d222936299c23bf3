//! Taking back the last insertions of a mesh: what a joint step of the refinement needs, which may
//! find that it cannot be completed.
//!
//! Insertions are taken back in the opposite order. Afterwards the mesh has the tetrahedra, in
//! their slots, that it had before; slots that were fresh are free, and arrays do not shrink (I7).

use crate::Point;
use crate::mesh::{Mesh, Vertex};
use crate::sphere::Sphere;
use crate::topology::{FaceId, INFINITE, TetId, VertexId};
use crate::transaction::OpenCavity;

/// A tetrahedron of a cavity as it was.
#[derive(Clone, Copy, Debug)]
struct Before {
    t: TetId,
    v: [VertexId; 4],
    n: [FaceId; 4],
    sphere: Sphere,
}

/// An insertion that can be taken back.
#[derive(Debug)]
pub struct Undo {
    cavity: Vec<Before>,
    created: Vec<TetId>,
}

impl Undo {
    /// The slots of the cavity.
    pub fn cavity(&self) -> impl Iterator<Item = TetId> + '_ {
        self.cavity.iter().map(|before| before.t)
    }

    /// The slots of the star, those of ghosts among them.
    pub fn created(&self) -> impl Iterator<Item = TetId> + '_ {
        self.created.iter().copied()
    }

    /// The vertices that the tetrahedra of the cavity had.
    pub fn cavity_vertices(&self) -> impl Iterator<Item = [VertexId; 4]> + '_ {
        self.cavity.iter().map(|before| before.v)
    }
}

impl OpenCavity<'_, Mesh> {
    /// [`OpenCavity::fill`], with what is needed to take it back.
    #[doc(hidden)]
    pub fn fill_for_now(self, p: Point, number: Vertex) -> (VertexId, Undo) {
        let mesh = self.owner();
        let before = |t: TetId| {
            let tet = mesh.topology.tet(t);
            let (v, n) = (tet.vertices(), tet.neighbours());
            Before { t, v, n, sphere: mesh.geometry.sphere(t) }
        };
        let cavity = self.tets().map(before).collect();
        self.end(|mesh| {
            let v = mesh.fill(p, number);
            (v, Undo { cavity, created: mesh.cavity().star().tets.to_vec() })
        })
    }
}

impl Mesh {
    /// Takes back the last insertion that is still there.
    #[doc(hidden)]
    pub fn take_back(&mut self, undo: &Undo) {
        let Undo { cavity, created } = undo;
        let star = created.iter().filter(|&&t| self.topology.tet(t).is_ghost()).count();
        let ghosts = cavity.iter().filter(|before| before.v[3] == INFINITE).count();
        let vertex = created.first().map(|&t| self.topology.tet(t).vertices()[0]);
        // The slots of the cavity were used first, then others taken, or the rest released.
        for &t in created.iter().skip(cavity.len()).rev() {
            self.topology.release(t);
        }
        for before in cavity.iter().skip(created.len()).rev() {
            let slot = self.topology.take();
            debug_assert_eq!(slot, before.t, "slots are taken back in the opposite order");
        }
        for before in cavity {
            self.topology.put(before.t, before.v, before.n);
        }
        for before in cavity {
            for (slot, &face) in before.n.iter().enumerate() {
                self.topology.point_to(face, FaceId::new(before.t, slot));
            }
            self.geometry.set_sphere(before.t, before.sphere);
        }
        self.topology.add_ghosts(ghosts as isize - star as isize);
        vertex.into_iter().for_each(|v| self.leave(v));
        self.renumbered();
        self.set_hint(cavity.first().map(|before| before.t).unwrap_or_default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cavity::AdmitAll;
    use crate::invariants::check_all;
    use crate::mesh::At;
    use crate::{Builder, PointSet};

    #[test]
    fn insertions_taken_back_leave_the_mesh_as_it_was() {
        let mut s = 5u64;
        let mut next = move || {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (s >> 44) as f64
        };
        let points: Vec<Point> = (0..400).map(|_| [(); 3].map(|()| next())).collect();
        let set = PointSet::new(points).expect("points");
        let mut mesh = Builder::new().build(&set).expect("a mesh").mesh;
        let cells = |mesh: &Mesh| {
            let mut cells: Vec<_> = mesh.topology.iter().map(|(t, tet)| (t, *tet)).collect();
            cells.sort_unstable_by_key(|c| c.0);
            cells
        };
        for round in 1..40 {
            if round % 8 == 0 {
                // A place of a vertex is free.
                let (v, _) = mesh.vertices().nth(round).expect("a vertex");
                mesh.remove(v).expect("it may go");
            }
            let (before, vertices) = (cells(&mesh), mesh.num_vertices());
            let mut done = Vec::new();
            for _ in 0..round {
                let p = [(); 3].map(|()| 2.0 * next() - 500_000.0);
                let from = mesh.hint();
                let number = mesh.next_number + done.len() as Vertex;
                match mesh.begin(p, from, &mut AdmitAll) {
                    Ok(open) => done.push(open.fill_for_now(p, number).1),
                    Err(at) => assert!(matches!(at, At::Vertex(_)), "room"),
                }
            }
            assert_ne!(cells(&mesh), before);
            done.iter().rev().for_each(|undo| mesh.take_back(undo));
            assert_eq!((cells(&mesh), mesh.num_vertices()), (before, vertices));
            check_all(&mesh).expect("invariants");
            let p = [(); 3].map(|()| next());
            mesh.insert(p).expect("a vertex");
        }
    }
}
