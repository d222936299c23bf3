//! The closing of a cavity's closure, as far as it is the part's, at once.

use super::{Part, PartConflict};
use crate::Point;
use crate::cavity::Open;
use crate::topology::{FaceId, TetId, VertexId, tet_of};

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

impl<H: Copy + Eq, L: Copy> Part<H, L> {
    /// Closes `seed`, which is open, for `holder`; if it is in conflict with `p`, also every
    /// tetrahedron in conflict that hangs together with it here, and the neighbours of those.
    ///
    /// Nothing changes, and it returns `false`, if one of them is closed for somebody else.
    pub fn close_all(&mut self, seed: TetId, p: &Point, holder: H, closed: &mut Closed) -> bool {
        closed.held.clear();
        closed.walls.clear();
        closed.inside = 0;
        if !self.in_conflict(seed, p) {
            self.close(seed, holder, false);
            closed.held.push(seed);
            return true;
        }
        let Self { topology, geometry, cavity, specials, .. } = self;
        let mut conflict = PartConflict {
            specials,
            met: false,
            blocked: false,
            closed: None,
            holder: Some(holder),
            inner: geometry.conflict_of(p),
        };
        if cavity.expand(topology, seed, &mut conflict, &mut Open).is_err() {
            return false;
        }
        if conflict.closed.is_some() {
            cavity.set_back(topology);
            return false;
        }
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
            if topology.tet(u).is_proxy() || !close(u, false) {
                closed.walls.push((v, outer));
            }
        }
        closed.inside = cavity.tets().count();
        cavity.set_back(topology);
        // One was tested above.
        geometry.stats.insphere_calls += closed.held.len() as u64 - 1;
        true
    }
}
