//! Point location in a submesh: where walks start, and what they meet.

use super::access::LockFilter;
use super::{PLACES, Submesh, Walk};
use crate::locate::{Found, walk_through};
use crate::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;

/// Places on either side that are looked at for a start.
const SPREAD: usize = 2;
/// Places that are looked at for other starts, when a walk has met a far face.
const WIDE_SPREAD: usize = 16;
/// The number of other starts that are tried then.
const TRIES: usize = 4;
/// Vertices that differ by less than this are likely to be near each other.
const NEAR: u32 = 64;

impl<H: Copy + Eq, T: Copy, F: Copy> Submesh<H, T, F> {
    /// Walks towards `p`, which is to be vertex `v` (or 0, if it has no number yet), from `start`
    /// if that is a tetrahedron here, else from one made lately near by. Such a walk is free to
    /// start elsewhere when it meets a far face: the submesh need not be convex, and steps here
    /// cost less than to ask another.
    pub fn walk(&mut self, v: VertexId, p: &Point, start: Option<TetId>) -> Walk<TetId, F> {
        let start = start.filter(|&t| self.is_live(t));
        let free = start.is_none();
        let Some(start) = start.or_else(|| self.near(v)).or_else(|| self.unlocked_hint()) else {
            return Walk::NoTets;
        };
        let stop = self.walk_from(p, start);
        if !free || !matches!(stop, Walk::Exits(_)) {
            return stop;
        }
        let others: Vec<TetId> = self
            .around(v, WIDE_SPREAD)
            .filter(|&t| t != start && self.is_live(t) && !self.is_locked(t))
            .take(TRIES)
            .collect();
        for t in others {
            let stop = self.walk_from(p, t);
            if !matches!(stop, Walk::Exits(_)) {
                return stop;
            }
        }
        stop
    }

    /// Walks towards `p` from tetrahedron `start`.
    pub(super) fn walk_from(&mut self, p: &Point, start: TetId) -> Walk<TetId, F> {
        let Self { topology, geometry, locks, far, steps, .. } = self;
        let mut conflict = geometry.conflict_of(p);
        // A walk that comes in through a hull facet ends there. From a ghost a walk goes to the
        // facet's other side first, perhaps to where it came from, and so on without end.
        if topology.tet(start).is_ghost() && !locks.is_locked(conflict.geometry().sphere(start)) {
            let [a, b, c, _] = topology.tet(start).vertices();
            if conflict.geometry().orient([a, b, c], p).is_positive() {
                return Walk::At(start);
            }
        }
        match walk_through(topology, &mut conflict, start, &LockFilter(locks), steps) {
            Found::Conflict(t) | Found::Outside(t) => Walk::At(t),
            Found::Barred(t) if topology.tet(t).is_vacant() => {
                far.get(geometry.sphere(t)).map_or(Walk::NoTets, Walk::Exits)
            }
            Found::Barred(t) => Walk::Locked(t),
            Found::Inside(t) => {
                let corners = topology.tet(t).vertices();
                let here = corners.iter().find(|&&v| *geometry.point(v) == *p);
                here.map_or(Walk::At(t), |&v| Walk::Duplicate(v))
            }
        }
    }

    /// The tetrahedron made last, if that was near vertex `v`; else the unlocked one of some made
    /// lately near by that has the nearest vertex.
    fn near(&self, v: VertexId) -> Option<TetId> {
        let unlocked = |t: TetId| self.is_live(t) && !self.is_locked(t);
        if v.number().abs_diff(self.last.number()) < NEAR && unlocked(self.hints[0]) {
            return Some(self.hints[0]);
        }
        let around = self.around(v, SPREAD);
        let far = |t: TetId| {
            let corners = self.topology.tet(t).vertices();
            corners.into_iter().map(|w| w.number().abs_diff(v.number())).min()
        };
        around.filter(|&t| unlocked(t)).min_by_key(|&t| far(t))
    }

    /// The entry of vertex `v` in `places`. Vertices far apart may share one.
    pub(super) fn place(&self, v: VertexId) -> usize {
        (v.number() / self.grain) as usize % PLACES
    }

    /// The entries at most `spread` places from vertex `v`, the nearest first.
    pub(super) fn around(&self, v: VertexId, spread: usize) -> impl Iterator<Item = TetId> + '_ {
        let place = self.place(v);
        let both = (1..=spread).flat_map(|k| [PLACES - k, k]);
        std::iter::once(0).chain(both).map(move |k| self.places[(place + k) % PLACES])
    }

    /// An unlocked tetrahedron made lately, else a locked one, else any.
    pub(super) fn unlocked_hint(&self) -> Option<TetId> {
        let live = || self.hints.iter().copied().filter(|&t| self.is_live(t));
        live()
            .find(|t| !self.is_locked(*t))
            .or_else(|| live().next())
            .or_else(|| self.tets().next().map(|(t, _)| t))
    }

    /// Remembers a tetrahedron that did not come from an insertion.
    pub(super) fn hint(&mut self, t: TetId, v: [VertexId; 4]) {
        self.hints[1..].rotate_right(1);
        self.hints[1] = t;
        for w in v.into_iter().filter(|&w| w != INFINITE) {
            let place = self.place(w);
            self.places[place] = t;
        }
    }
}
