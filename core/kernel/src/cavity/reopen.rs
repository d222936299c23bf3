//! A cavity opened again: of what was found for a point earlier, only what has changed since then
//! is looked at.
//!
//! A tetrahedron that is where it was is in conflict if it was, whatever was inserted since: so its
//! slot tells, without its sphere.

use super::{Admission, BoundaryFace, Cavity, Conflict, OTHERS, Role, Setback};
use crate::topology::{INFINITE, TetId, Topology, tet_of};

impl Cavity {
    /// Opens a cavity, of which `tets` are what a search has found earlier; `changed` says of a
    /// slot whether it was written since then. Says whether the closure is as it was: then boundary
    /// faces are in the order of that search. `None` if all of the list has changed: there is
    /// nothing to start from, and the mesh is as before.
    ///
    /// Ends: each tetrahedron enters once.
    ///
    /// # Errors
    /// The mesh is full, or a slot of the list or beside the cavity is not admitted; it is not
    /// looked at then. The mesh is as before.
    pub(crate) fn reopen<C: Conflict, A: Admission>(
        &mut self,
        topology: &mut Topology,
        tets: &[TetId],
        conflict: &mut C,
        changed: &impl Fn(TetId) -> bool,
        admission: &mut A,
    ) -> Result<Option<bool>, Setback> {
        self.tets.clear();
        self.boundary.clear();
        self.ghosts = 0;
        self.tests = 0;
        if let Some(&t) = tets.iter().find(|&&t| !admission.admit(t, Role::Cavity)) {
            return Err(Setback::Refused(t));
        }
        for list in tets.chunks(4) {
            let (mut four, mut mask) = ([TetId::default(); 4], 0);
            for (k, &t) in list.iter().enumerate() {
                let stays = !topology.tet(t).is_free() && !changed(t);
                four[k] = t;
                mask |= u32::from(stays) << k;
                topology.mark_if(t, stays);
            }
            self.tets.push_some(four, mask);
        }
        if self.tets.is_empty() {
            return Ok(None);
        }
        let mut is_same = self.tets.len() == tets.len();
        let mut next = 0;
        while next < self.tets.len() {
            let t = self.tets[next];
            next += 1;
            let tet = *topology.tet(t);
            let (v, n) = (tet.vertices(), tet.neighbours());
            self.ghosts += usize::from(v[3] == INFINITE);
            let refused = n.map(tet_of).into_iter().find(|&t| !admission.admit(t, Role::Ring));
            if let Some(t) = refused {
                self.set_back(topology);
                return Err(Setback::Refused(t));
            }
            let (mut open, mut fresh) = (0, 0);
            for (slot, &face) in n.iter().enumerate() {
                let other = tet_of(face);
                let is_open = u32::from(!topology.tet(other).is_marked());
                open |= is_open << slot;
                fresh |= (is_open & u32::from(changed(other))) << slot;
            }
            let mut take = 0;
            if fresh != 0 {
                is_same = false;
                self.tests += fresh.count_ones() as usize;
                let (inside, outside) = conflict.by_sphere(n.map(tet_of));
                let unknown = !(inside | outside) & fresh;
                take = inside & fresh;
                if unknown != 0 {
                    take |= conflict.by_points(topology, n.map(tet_of), unknown) & fresh;
                }
                for (slot, &face) in n.iter().enumerate() {
                    topology.mark_if(tet_of(face), take >> slot & 1 == 1);
                }
                self.tets.push_some(n.map(tet_of), take);
            }
            let border =
                |slot: usize| BoundaryFace { v: OTHERS[slot].map(|k| v[k]), outer: n[slot] };
            self.boundary.push_some([border(0), border(1), border(2), border(3)], open & !take);
        }
        // Not of a point: all tetrahedra of a mesh.
        if self.boundary.is_empty() {
            self.set_back(topology);
            return Ok(None);
        }
        self.make_room(topology)?;
        Ok(Some(is_same))
    }
}

#[cfg(test)]
mod tests {
    use crate::cavity::AdmitAll;
    use crate::mesh::{Mesh, Vertex};
    use crate::topology::TetId;
    use crate::{Builder, Point, PointSet};
    use std::collections::BTreeSet;

    fn mesh_and_points(count: usize) -> (Mesh, Vec<Point>) {
        let mut s = 7u64;
        let mut next = move || {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (s >> 44) as f64
        };
        let mut points: Vec<Point> = (0..300 + count).map(|_| [(); 3].map(|()| next())).collect();
        let rest = points.split_off(300);
        let set = PointSet::new(points).expect("points");
        (Builder::new().build(&set).expect("a mesh").mesh, rest)
    }

    fn cavity_of(mesh: &mut Mesh, p: &Point) -> Vec<TetId> {
        let from = mesh.hint();
        mesh.begin(*p, from, &mut AdmitAll).expect("a new point").tets().collect()
    }

    #[test]
    fn a_cavity_opened_again_is_the_one_that_was_found() {
        let (mut mesh, points) = mesh_and_points(300);
        for p in points {
            let from = mesh.hint();
            let open = mesh.begin(p, from, &mut AdmitAll).expect("a new point");
            let tets: Vec<TetId> = open.tets().collect();
            let boundary: Vec<_> = open.owner().cavity().boundary().collect();
            drop(open);
            let number = mesh.num_vertices() as Vertex;
            let again = mesh.reopen(&p, &tets, &|_| false).expect("room");
            let (open, is_same) = again.expect("nothing has changed");
            assert!(is_same && open.tets().eq(tets.iter().copied()));
            assert!(open.owner().cavity().boundary().eq(boundary.iter().copied()));
            assert_eq!(open.owner().cavity().tests(), 0);
            open.fill(p, number);
        }
        crate::invariants::check_all(&mesh).expect("invariants");
    }

    #[test]
    fn what_has_changed_since_is_found() {
        let (mut mesh, points) = mesh_and_points(400);
        let (mut kept, mut gone) = ([0; 2], 0);
        // As many points as that have cavities that meet.
        for chosen in points.chunks(40) {
            let found: Vec<_> = chosen.iter().map(|p| cavity_of(&mut mesh, p)).collect();
            let mut written = BTreeSet::<TetId>::new();
            for (p, tets) in chosen.iter().zip(found) {
                let now: BTreeSet<TetId> = cavity_of(&mut mesh, p).into_iter().collect();
                let before = mesh.topology().clone();
                let number = mesh.num_vertices() as Vertex;
                let changed = |t: TetId| written.contains(&t);
                let again = mesh.reopen(p, &tets, &changed).expect("room");
                let all = again.map(|(open, is_same)| (is_same, open.tets().collect()));
                assert!(*mesh.topology() == before, "set back");
                match all {
                    Some((is_same, all)) => {
                        let all: Vec<TetId> = all;
                        kept[usize::from(is_same)] += 1;
                        assert_eq!((all.len(), BTreeSet::from_iter(all)), (now.len(), now));
                        let again = mesh.reopen(p, &tets, &changed).expect("room");
                        again.expect("as before").0.fill(*p, number);
                    }
                    None => {
                        assert!(tets.iter().all(|&t| changed(t)) && !now.is_empty());
                        gone += 1;
                        let from = mesh.hint();
                        mesh.begin(*p, from, &mut AdmitAll).expect("a new point").fill(*p, number);
                    }
                }
                written.extend(mesh.cavity().star().tets);
                written.extend(mesh.cavity().freed());
            }
        }
        assert!(kept[0] > 50 && kept[1] > 50 && gone > 0, "{kept:?} {gone}");
        crate::invariants::check_all(&mesh).expect("invariants");
    }
}
