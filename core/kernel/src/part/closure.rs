//! The closing of a cavity's closure, as far as it is the part's, at once.

use super::Part;
use crate::cavity::Cavity;
use crate::topology::{FaceId, TetId, VertexId, tet_of};
use ltbw_exact::Point;

/// What [`Part::close_all`] has closed, and where it ended.
#[derive(Clone, Debug, Default)]
pub struct Closed {
    /// All tetrahedra closed: those in conflict first.
    pub held: Vec<TetId>,
    /// How many of them are in conflict.
    pub inside: usize,
    /// The faces of those to what is not in conflict, or not known to be: the vertices, which are a
    /// positively oriented tetrahedron with the point before them, and the face seen from outside.
    pub walls: Vec<([VertexId; 3], FaceId)>,
}

impl<H: Copy + Eq, L: Copy, F: Copy> Part<H, L, F> {
    /// Closes `seed`, which is open, for `holder`; if it is in conflict with `p`, also every
    /// tetrahedron in conflict that hangs together with it here, and the neighbours of those.
    ///
    /// Nothing changes, and it returns `false`, if one of them is closed for somebody else.
    ///
    /// # Panics
    /// If `seed` is no tetrahedron.
    pub fn close_all(&mut self, seed: TetId, p: &Point, holder: H, closed: &mut Closed) -> bool {
        self.expect_live(seed);
        closed.held.clear();
        closed.walls.clear();
        closed.inside = 0;
        // Most often the point could not be inserted a moment ago: its cavity is still there.
        let found = self.blocked.take() == Some((seed, *p));
        if !found && !self.in_conflict(seed, p) {
            self.close(seed, holder, false);
            closed.held.push(seed);
            return true;
        }
        if found {
            self.check_found(seed, p, holder);
        } else if !self.find_open(seed, p, holder) {
            return false;
        }
        let Self { topology, geometry, cavity, specials, .. } = self;
        // Was `t` closed before as one of the cavity? Then the face is none of its boundary.
        let mut close = |t: TetId, inside: bool| {
            let mut sphere = geometry.sphere(t);
            let special = specials.entry(t, &mut sphere);
            if let Some((_, before)) = special.closed {
                return before;
            }
            special.closed = Some((holder, inside));
            geometry.set_sphere(t, sphere);
            closed.held.push(t);
            false
        };
        for t in cavity.tets() {
            close(t, true);
        }
        for (v, outer) in cavity.walls() {
            let u = tet_of(outer);
            if topology.tet(u).is_vacant() || !close(u, false) {
                closed.walls.push((v, outer));
            }
        }
        closed.inside = cavity.tets().count();
        // One was tested above, if it was not found before.
        geometry.stats.insphere_calls += closed.held.len() as u64 - u64::from(!found);
        true
    }

    /// In debug builds: is what was found before what would be found now?
    fn check_found(&mut self, seed: TetId, p: &Point, holder: H) {
        if cfg!(debug_assertions) {
            let found = |cavity: &Cavity| {
                (cavity.tets().collect::<Vec<_>>(), cavity.walls().collect::<Vec<_>>())
            };
            let (before, stats) = (found(&self.cavity), self.geometry.stats);
            assert!(self.find_open(seed, p, holder), "{seed}: nothing was closed");
            assert!(found(&self.cavity) == before, "{seed}: the cavity is another one now");
            self.geometry.stats = stats;
        }
    }

    /// Finds the cavity of `p` here, from `seed` on, as far as `holder` has not closed it; false if
    /// some of its closure is closed for somebody else. Nothing is marked afterwards.
    fn find_open(&mut self, seed: TetId, p: &Point, holder: H) -> bool {
        // The guard is dropped at once: nothing is filled here.
        self.begin(seed, p, Some(holder)).is_ok_and(|(_, met)| met.closed.is_none())
    }
}
