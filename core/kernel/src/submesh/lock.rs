//! The locking of a cavity's closure, as far as it is the submesh's, at once.

use super::Submesh;
use crate::cavity::Cavity;
use crate::topology::{FaceId, TetId, VertexId, tet_of};
use ltbw_exact::Point;

/// The tetrahedra that [`Submesh::lock_closure`] has locked, and the faces where it ended.
#[derive(Clone, Debug, Default)]
pub struct Closure {
    /// All tetrahedra locked: those in conflict first.
    pub locked: Vec<TetId>,
    /// The number of them in conflict.
    pub inside: usize,
    /// The faces of those to what is not in conflict, or not known to be: the vertices, which are a
    /// positively oriented tetrahedron with the point before them, and the face seen from outside.
    pub boundary: Vec<([VertexId; 3], FaceId)>,
}

impl<H: Copy + Eq, T: Copy, F: Copy> Submesh<H, T, F> {
    /// Locks `seed`, which is unlocked, for `holder`; if it is in conflict with `p`, also every
    /// tetrahedron in conflict that is connected with it here, and the neighbours of those.
    ///
    /// Nothing changes, and it returns `false`, if one of them is locked for another holder.
    ///
    /// # Panics
    /// If `seed` is no tetrahedron.
    pub fn lock_closure(
        &mut self,
        seed: TetId,
        p: &Point,
        holder: H,
        closure: &mut Closure,
    ) -> bool {
        self.expect_live(seed);
        closure.locked.clear();
        closure.boundary.clear();
        closure.inside = 0;
        // Most often the point could not be inserted a moment ago: its cavity is still there.
        let found = self.blocked.take() == Some((seed, *p));
        if !found && !self.in_conflict(seed, p) {
            self.lock(seed, holder, false);
            closure.locked.push(seed);
            return true;
        }
        if found {
            self.check_found(seed, p, holder);
        } else if !self.find_unlocked(seed, p, holder) {
            return false;
        }
        let Self { topology, geometry, cavity, locks, .. } = self;
        // Was `t` locked before as one of the cavity? Then the face is none of its boundary.
        let mut lock = |t: TetId, inside: bool| {
            let mut sphere = geometry.sphere(t);
            let entry = locks.entry(t, &mut sphere);
            if let Some((_, before)) = entry.lock {
                return before;
            }
            entry.lock = Some((holder, inside));
            geometry.set_sphere(t, sphere);
            closure.locked.push(t);
            false
        };
        for t in cavity.tets() {
            lock(t, true);
        }
        for (v, outer) in cavity.boundary() {
            let u = tet_of(outer);
            if topology.tet(u).is_vacant() || !lock(u, false) {
                closure.boundary.push((v, outer));
            }
        }
        closure.inside = cavity.tets().count();
        // One was tested above, if it was not found before.
        geometry.stats.insphere_calls += closure.locked.len() as u64 - u64::from(!found);
        true
    }

    /// In debug builds: is what was found before what would be found now?
    fn check_found(&mut self, seed: TetId, p: &Point, holder: H) {
        if cfg!(debug_assertions) {
            let found = |cavity: &Cavity| {
                (cavity.tets().collect::<Vec<_>>(), cavity.boundary().collect::<Vec<_>>())
            };
            let (before, stats) = (found(&self.cavity), self.geometry.stats);
            assert!(self.find_unlocked(seed, p, holder), "{seed}: nothing was locked");
            assert!(found(&self.cavity) == before, "{seed}: the cavity is another one now");
            self.geometry.stats = stats;
        }
    }

    /// Finds the cavity of `p` here, from `seed` on, as far as `holder` has not locked it; false if
    /// some of its closure is locked for another holder. Nothing is marked afterwards.
    fn find_unlocked(&mut self, seed: TetId, p: &Point, holder: H) -> bool {
        // The guard is dropped at once: nothing is filled here.
        self.begin(seed, p, Some(holder)).is_ok_and(|(_, met)| met.locked.is_none())
    }
}
