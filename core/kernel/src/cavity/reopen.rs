//! A cavity opened again, without a search: what was found for a point serves until something
//! changes in the closure.

use super::{Admission, Cavity, OTHERS, Role, Setback, Wall};
use crate::topology::{INFINITE, TetId, Topology, tet_of};

impl Cavity {
    /// Opens the cavity `tets` again, which an earlier [`Cavity::expand`] found for a point. The
    /// admission says of each tetrahedron of the closure that it has not changed since then.
    ///
    /// All is as after that search, walls in the same order. Refused, the mesh is as before.
    pub(crate) fn reopen<A: Admission>(
        &mut self,
        topology: &mut Topology,
        tets: &[TetId],
        admission: &mut A,
    ) -> Result<(), Setback> {
        self.tets.clear();
        self.walls.clear();
        self.ghosts = 0;
        for &t in tets {
            if topology.tet(t).is_free() || !admission.admit(t, Role::Cavity) {
                return Err(Setback::Refused(t));
            }
        }
        for list in tets.chunks(4) {
            let mut four = [0; 4];
            four[..list.len()].copy_from_slice(list);
            self.tets.push_some(four, (1 << list.len()) - 1);
            list.iter().for_each(|&t| topology.mark(t));
        }
        for &t in tets {
            let tet = *topology.tet(t);
            let (v, n) = (tet.vertices(), tet.neighbours());
            self.ghosts += usize::from(v[3] == INFINITE);
            let mut leave = 0;
            let mut refused = None;
            for (slot, &face) in n.iter().enumerate() {
                let is_wall = !topology.tet(tet_of(face)).is_marked();
                leave |= u32::from(is_wall) << slot;
                if is_wall && !admission.admit(tet_of(face), Role::Ring) {
                    refused = Some(tet_of(face));
                }
            }
            if let Some(refused) = refused {
                self.set_back(topology);
                return Err(Setback::Refused(refused));
            }
            let wall = |slot: usize| Wall { v: OTHERS[slot].map(|k| v[k]), outer: n[slot] };
            self.walls.push_some([wall(0), wall(1), wall(2), wall(3)], leave);
        }
        self.make_room(topology)
    }
}

#[cfg(test)]
mod tests {
    use crate::cavity::{Open, Role, Setback};
    use crate::mesh::{Mesh, Vertex};
    use crate::topology::TetId;
    use crate::{Builder, Point, PointSet};

    fn mesh_and_points() -> (Mesh, Vec<Point>) {
        let mut s = 7u64;
        let mut next = move || {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (s >> 44) as f64
        };
        let mut points: Vec<Point> = (0..600).map(|_| [(); 3].map(|()| next())).collect();
        let rest = points.split_off(300);
        let set = PointSet::new(points).expect("points");
        (Builder::new().build(&set).expect("a mesh").mesh, rest)
    }

    #[test]
    fn a_cavity_opened_again_is_the_one_that_was_found() {
        let (mut mesh, points) = mesh_and_points();
        for p in points {
            let from = mesh.hint();
            let open = mesh.begin(p, from, &mut Open).expect("a new point");
            let tets: Vec<TetId> = open.tets().collect();
            let walls: Vec<_> = open.owner().cavity().walls().collect();
            drop(open);
            let number = mesh.num_vertices() as Vertex;
            let open = mesh.reopen(&tets, &mut Open).expect("nothing has changed");
            assert!(open.tets().eq(tets.iter().copied()));
            assert!(open.owner().cavity().walls().eq(walls.iter().copied()));
            open.fill(p, number);
        }
        crate::invariants::check_all(&mesh).expect("invariants");
    }

    #[test]
    fn a_refused_one_leaves_the_mesh_as_it_was() {
        let (mut mesh, points) = mesh_and_points();
        let before = mesh.topology().clone();
        for p in &points[..40] {
            let from = mesh.hint();
            let open = mesh.begin(*p, from, &mut Open).expect("a new point");
            let tets: Vec<TetId> = open.tets().collect();
            drop(open);
            let mut closure = Vec::new();
            let mut note = |t: TetId, role: Role| {
                closure.push((t, role));
                true
            };
            drop(mesh.reopen(&tets, &mut note).expect("nothing has changed"));
            assert!(closure.iter().any(|&(_, role)| role == Role::Ring));
            for (changed, _) in closure {
                let refused = mesh.reopen(&tets, &mut |t: TetId, _: Role| t != changed).err();
                assert_eq!(refused, Some(Setback::Refused(changed)));
                assert!(*mesh.topology() == before);
            }
        }
    }
}
