//! Insertion at once: of points whose cavity is the submesh's own and unlocked.

use super::access::{Met, SubmeshConflict};
use super::{Insert, Owns, Submesh, untag};
use crate::cavity::{AdmitAll, Cavity, Setback};
use crate::search::Search;
use crate::sphere::Sphere;
use crate::topology::{TetId, Topology, VertexId, tet_of};
use crate::transaction::{OpenCavity, Opens};
use ltbw_exact::Point;
use std::collections::BTreeSet;

/// The outcome of an earlier search for a point's cavity.
#[derive(Debug)]
pub struct Earlier<'e, C> {
    /// A tetrahedron in conflict with the point.
    pub seed: TetId,
    /// The tetrahedra that [`Submesh::search`] has found; it may be none.
    pub found: &'e [TetId],
    /// Says of a slot whether a tetrahedron was written to it since then.
    pub changed: &'e C,
}

impl<H: Copy + Eq, T: Copy, F: Copy> Opens for Submesh<H, T, F> {
    #[inline(always)]
    fn cavity(&self) -> &Cavity {
        &self.cavity
    }

    fn set_back(&mut self) {
        self.cavity.set_back(&mut self.topology);
    }
}

impl<H: Copy + Eq, T: Copy, F: Copy> Submesh<H, T, F> {
    /// Inserts `p` as vertex `v` if nothing is in the way: no far face, no locked tetrahedron, and
    /// every new tetrahedron is the submesh's own. `seed` must be unlocked and in conflict with
    /// `p`.
    ///
    /// # Panics
    /// If `seed` is no tetrahedron, or `v` no finite vertex.
    pub fn insert(
        &mut self,
        v: VertexId,
        p: &Point,
        seed: TetId,
        owns: Owns<impl Fn([VertexId; 4]) -> bool>,
    ) -> Insert<TetId> {
        self.insert_seeing(v, p, seed, owns, |_, _| {})
    }

    /// Inserts, showing `see` the cavity before it is filled: the k-th face of its boundary becomes
    /// one of the k-th tetrahedron of [`Submesh::made_at_once`].
    ///
    /// # Panics
    /// If `seed` is no tetrahedron, or `v` no finite vertex.
    pub fn insert_seeing(
        &mut self,
        v: VertexId,
        p: &Point,
        seed: TetId,
        owns: Owns<impl Fn([VertexId; 4]) -> bool>,
        see: impl FnOnce(&Topology, &Cavity),
    ) -> Insert<TetId> {
        self.expect_live(seed);
        assert!(self.is_vertex(v), "there is no finite vertex {v}");
        self.blocked = None;
        let Ok((open, met)) = self.begin(seed, p, None) else { return Insert::Full };
        if let Some(t) = met.locked {
            return Insert::Locked(t);
        }
        if met.blocked || !open.owner().owns_star(v, owns) {
            drop(open);
            self.blocked = Some((seed, *p));
            return Insert::Blocked;
        }
        let Self { topology, cavity, .. } = open.owner();
        see(topology, cavity);
        open.end(|submesh| submesh.fill(v, p, met.tagged));
        Insert::Done
    }

    /// Inserts a point that [`Submesh::search`] was asked for earlier. `false` if it is not
    /// inserted so, though it may be from its seed on: where much has changed, and where something
    /// may be in the way. The submesh is as before then.
    ///
    /// # Panics
    /// If [`Earlier::found`] names what is no slot, or `v` is no finite vertex.
    pub fn insert_again(
        &mut self,
        v: VertexId,
        p: &Point,
        earlier: &Earlier<'_, impl Fn(TetId) -> bool>,
        owns: Owns<impl Fn([VertexId; 4]) -> bool>,
        see: impl FnOnce(&Topology, &Cavity),
    ) -> bool {
        let &Earlier { seed, found, changed } = earlier;
        found.iter().for_each(|&t| self.expect_slot(t));
        assert!(self.is_vertex(v), "there is no finite vertex {v}");
        let stats = self.geometry.stats;
        let search = |by: &mut Search| {
            self.search(seed, p, by).then(|| by.tets().iter().copied().collect::<BTreeSet<_>>())
        };
        let now = cfg!(debug_assertions).then(Search::default).as_mut().and_then(search);
        self.geometry.stats = stats;
        self.blocked = None;
        let Self { topology, geometry, cavity, locks, .. } = self;
        let (inner, met) = (geometry.conflict_of(p), Met::default());
        let mut conflict = SubmeshConflict { inner, locks, met, holder: None };
        let again = cavity.reopen(topology, found, &mut conflict, changed, &mut AdmitAll);
        let Met { tagged, blocked, locked } = conflict.met;
        if !matches!(again, Ok(Some(_))) {
            return false;
        }
        let open = OpenCavity::new(self);
        let Self { topology, geometry, cavity, locks, .. } = open.owner();
        // A slot that has become a far face since then is met, too.
        let bars = |t| topology.tet(t).is_vacant() || locks.get(geometry.sphere(t)).is_some();
        let outer = cavity.boundary().map(|(_, outer)| tet_of(outer));
        let is_barred = cavity.tets().chain(outer).any(bars);
        if is_barred || tagged || blocked || locked.is_some() || !open.owner().owns_star(v, owns) {
            return false;
        }
        debug_assert!(now.is_none_or(|now| now == cavity.tets().collect()));
        see(topology, cavity);
        open.end(|submesh| submesh.fill(v, p, false));
        true
    }

    /// Searches the cavity of `p`, from `seed` on, which must be in conflict with it. `false` if
    /// something is in the way of its filling: a far face, or a locked tetrahedron.
    ///
    /// # Panics
    /// If `seed` is no tetrahedron.
    pub fn search(&mut self, seed: TetId, p: &Point, search: &mut Search) -> bool {
        self.expect_live(seed);
        if self.is_locked(seed) {
            return false;
        }
        let Self { topology, geometry, locks, .. } = self;
        let (inner, met) = (geometry.conflict_of(p), Met::default());
        let mut conflict = SubmeshConflict { inner, locks, met, holder: None };
        let tests = search.find_by(topology, &mut conflict, seed, |_| false);
        let Met { blocked, locked, .. } = conflict.met;
        geometry.stats.insphere_calls += tests.unwrap_or(0);
        locked.is_none() && !blocked
    }

    /// Finds the cavity of `p` from `seed` on, and what is in its way.
    #[inline(always)]
    pub(super) fn begin(
        &mut self,
        seed: TetId,
        p: &Point,
        holder: Option<H>,
    ) -> Result<(OpenCavity<'_, Self>, Met), Setback> {
        let Self { topology, geometry, cavity, locks, .. } = self;
        let tagged = locks.is_tagged(geometry.sphere(seed));
        let (inner, met) = (geometry.conflict_of(p), Met { tagged, ..Met::default() });
        let mut conflict = SubmeshConflict { inner, locks, met, holder };
        cavity.expand::<_, _, false>(topology, seed, &mut conflict, &mut AdmitAll)?;
        let met = conflict.met;
        Ok((OpenCavity::new(self), met))
    }

    /// Would all tetrahedra of the star of `v` in the open cavity be the submesh's own?
    #[inline(always)]
    fn owns_star(&self, v: VertexId, owns: Owns<impl Fn([VertexId; 4]) -> bool>) -> bool {
        let Self { topology, cavity, own, others, .. } = self;
        // All corners of the cavity are looked at, without a branch for each: most cavities are far
        // from others. A ghost's corner at infinity may count: a closer look costs little.
        // Below 2^31, so that a sign tells a number before the range or after it.
        let (first, last) = (own.start.number(), own.end.number().wrapping_sub(1));
        let strange = |w: VertexId| w.number().wrapping_sub(first) | last.wrapping_sub(w.number());
        let border = || {
            let signs = cavity.tets().fold([strange(v); 4], |signs, t| {
                let w = topology.tet(t).vertices();
                [0, 1, 2, 3].map(|k| signs[k] | strange(w[k]))
            });
            signs.into_iter().any(|sign| sign >> 31 == 1)
        };
        match owns {
            Owns::All => true,
            Owns::None => false,
            Owns::By(owns) => {
                !*others || !border() || cavity.faces().all(|[a, b, c]| owns([v, a, b, c]))
            }
        }
    }

    /// Fills the open cavity with the star of `v`. Some of its tetrahedra may be `tagged`.
    #[inline(always)]
    fn fill(&mut self, v: VertexId, p: &Point, tagged: bool) {
        let Self { topology, geometry, cavity, locks, .. } = self;
        self.removed_tags.clear();
        if tagged {
            self.removed_tags.extend(cavity.tets().filter_map(|t| untag(locks, geometry, t)));
        }
        geometry.set_point(v, *p);
        let hint = cavity.fill(topology, v);
        // A free slot has no sphere.
        cavity.freed().iter().for_each(|&t| geometry.set_sphere(t, Sphere::UNKNOWN));
        let star = cavity.star();
        geometry.created(topology.slots(), &star, p);
        geometry.stats.insphere_calls += cavity.tests() as u64;
        self.made += star.tets.len() as u64;
        self.hints[0] = hint;
        self.last = v;
        let place = self.place(v);
        self.places[place] = hint;
    }

    /// The tetrahedra that the last successful [`Submesh::insert`] has made.
    pub fn made_at_once(&self) -> &[TetId] {
        self.cavity.star().tets
    }

    /// Takes the tags of the tagged tetrahedra that the last successful [`Submesh::insert`]
    /// removed. They are not tagged any more.
    pub fn take_removed_tags(&mut self) -> std::vec::Drain<'_, T> {
        self.removed_tags.drain(..)
    }
}
