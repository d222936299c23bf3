//! Insertion at once: of points whose cavity is the part's own and unlocked.

use super::conflict::{Met, PartConflict};
use super::{Local, Owns, Part, unwatch};
use crate::cavity::{Cavity, Open, Setback};
use crate::sphere::Sphere;
use crate::topology::{TetId, VertexId};
use crate::transaction::{OpenCavity, Opens};
use ltbw_exact::Point;

impl<H: Copy + Eq, L: Copy, F: Copy> Opens for Part<H, L, F> {
    #[inline(always)]
    fn cavity(&self) -> &Cavity {
        &self.cavity
    }

    fn set_back(&mut self) {
        self.cavity.set_back(&mut self.topology);
    }
}

impl<H: Copy + Eq, L: Copy, F: Copy> Part<H, L, F> {
    /// Inserts `p` as vertex `v` if nothing is in the way: no proxy, no closed tetrahedron, and
    /// every new tetrahedron is the part's own. `seed` must be open and in conflict with `p`.
    ///
    /// # Panics
    /// If `seed` is no tetrahedron, or `v` no finite vertex.
    pub fn insert(
        &mut self,
        v: VertexId,
        p: &Point,
        seed: TetId,
        owns: Owns<impl Fn([VertexId; 4]) -> bool>,
    ) -> Local {
        self.expect_live(seed);
        assert!(self.is_vertex(v), "there is no finite vertex {v}");
        self.blocked = None;
        let Ok((open, met)) = self.begin(seed, p, None) else { return Local::Full };
        if let Some(t) = met.closed {
            return Local::Closed(t);
        }
        if met.blocked || !open.owner().owns_star(v, owns) {
            drop(open);
            self.blocked = Some((seed, *p));
            return Local::Blocked;
        }
        open.end(|part| part.fill(v, p, met.watched));
        Local::Inserted
    }

    /// Finds the cavity of `p` from `seed` on, and what is in its way.
    #[inline(always)]
    pub(super) fn begin(
        &mut self,
        seed: TetId,
        p: &Point,
        holder: Option<H>,
    ) -> Result<(OpenCavity<'_, Self>, Met), Setback> {
        let Self { topology, geometry, cavity, specials, .. } = self;
        let watched = specials.is_watched(geometry.sphere(seed));
        let met = Met { watched, ..Met::default() };
        let inner = geometry.conflict_of(p);
        let mut conflict = PartConflict { inner, specials, met, holder };
        cavity.expand(topology, seed, &mut conflict, &mut Open)?;
        let met = conflict.met;
        Ok((OpenCavity::new(self), met))
    }

    /// Would all tetrahedra of the star of `v` in the open cavity be the part's own?
    #[inline(always)]
    fn owns_star(&self, v: VertexId, owns: Owns<impl Fn([VertexId; 4]) -> bool>) -> bool {
        let Self { topology, cavity, home, others, .. } = self;
        // All corners of the cavity are looked at, without a branch for each: most cavities are far
        // from others. A ghost's corner at infinity may count: a closer look costs little.
        // Below 2^31, so that a sign tells a number before the range or after it.
        let (first, last) = (home.start, home.end.wrapping_sub(1));
        let strange = |w: VertexId| w.wrapping_sub(first) | last.wrapping_sub(w);
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

    /// Fills the open cavity with the star of `v`. Some of its tetrahedra may be `watched`.
    #[inline(always)]
    fn fill(&mut self, v: VertexId, p: &Point, watched: bool) {
        let Self { topology, geometry, cavity, specials, .. } = self;
        self.gone.clear();
        if watched {
            self.gone.extend(cavity.tets().filter_map(|t| unwatch(specials, geometry, t)));
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

    /// Takes the labels of the watched tetrahedra that the last successful [`Part::insert`]
    /// removed. They are not watched any more.
    pub fn take_gone(&mut self) -> std::vec::Drain<'_, L> {
        self.gone.drain(..)
    }
}
