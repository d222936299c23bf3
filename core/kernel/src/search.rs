//! The cavity of a point found on a mesh that is only read: many may look for theirs at once.
//!
//! A [`Cavity`](crate::cavity::Cavity) marks what it has in the mesh; a search has a set of its own
//! for that. It finds the same tetrahedra in the same order.

use crate::PredicateStats;
use crate::cavity::Conflict;
use crate::geometry::SharedConflict;
use crate::mesh::Mesh;
use crate::query::set::Marks;
use crate::topology::{TetId, Topology, tet_of};
use ltbw_exact::Point;

/// One searcher's memory, and the cavity that it has found last.
#[derive(Debug, Default)]
pub struct Search {
    tets: Vec<TetId>,
    set: Marks,
    /// Predicate calls of [`Search::find`] so far.
    pub stats: PredicateStats,
}

impl Search {
    /// Finds the cavity of a point in kernel coordinates, which is no vertex, from `start`, which
    /// has to be in conflict with it; gives up where another tetrahedron of the closure is one
    /// that bars it, and returns `false`. Ends: each tetrahedron enters once.
    pub fn find<B>(&mut self, mesh: &Mesh, p: &Point, start: TetId, bars: B) -> bool
    where
        B: Fn(TetId) -> bool,
    {
        let mut stats = self.stats;
        let mut conflict = SharedConflict::new(&mesh.geometry, p, &mut stats);
        let tests = self.find_by(mesh.topology(), &mut conflict, start, bars);
        stats.insphere_calls += tests.unwrap_or(0);
        self.stats = stats;
        tests.is_some()
    }

    /// Finds the cavity by any test of conflicts, unless its closure is barred. Returns the number
    /// of tests.
    #[inline(always)]
    pub(crate) fn find_by<C: Conflict, B: Fn(TetId) -> bool>(
        &mut self,
        all: &Topology,
        by: &mut C,
        t: TetId,
        bars: B,
    ) -> Option<u64> {
        let Self { tets, set, .. } = self;
        tets.clear();
        set.clear();
        tets.push(t);
        set.insert(t);
        let (mut next, mut boundary) = (0, 0);
        while let Some(&t) = tets.get(next) {
            next += 1;
            let n = all.tet(t).neighbours().map(tet_of);
            let is_open = n.map(|other| u32::from(!set.contains(other)));
            if n.iter().zip(is_open).any(|(&other, open)| open == 1 && bars(other)) {
                return None;
            }
            let open = is_open[0] | is_open[1] << 1 | is_open[2] << 2 | is_open[3] << 3;
            let (mut inside, outside) = by.by_sphere(n);
            let unknown = !(inside | outside) & open;
            if unknown != 0 {
                inside |= by.by_points(all, n, unknown);
            }
            for (slot, &other) in n.iter().enumerate() {
                if inside & open & 1 << slot != 0 {
                    tets.push(other);
                    set.insert(other);
                    for face in all.tet(other).neighbours() {
                        by.prefetch(tet_of(face));
                        all.prefetch(tet_of(face));
                    }
                }
            }
            boundary += (open & !inside).count_ones();
        }
        Some(tets.len() as u64 + u64::from(boundary) - 1)
    }

    /// The tetrahedra of the cavity.
    pub fn tets(&self) -> &[TetId] {
        &self.tets
    }

    /// Is `t` one of them?
    #[inline]
    pub fn has(&self, t: TetId) -> bool {
        self.set.contains(t)
    }
}

impl Mesh {
    /// Is a point in kernel coordinates inside the (perturbed) circumsphere of tetrahedron `t`?
    #[doc(hidden)]
    pub fn in_conflict(&self, t: TetId, p: &Point) -> bool {
        SharedConflict::new(&self.geometry, p, &mut PredicateStats::default())
            .holds(&self.topology, t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cavity::AdmitAll;
    use crate::mesh::Vertex;
    use crate::{Builder, PointSet};
    use ltbw_generate::{PointKind, generate};

    #[test]
    fn a_search_finds_the_cavity_that_is_opened_in_its_order() {
        let mut search = Search::default();
        for kind in [PointKind::Uniform, PointKind::Grid, PointKind::Sphere] {
            let points = generate(kind, 700, 3);
            let (first, rest) = points.split_at(300);
            let set = PointSet::new(first.to_vec()).expect("points");
            let mut mesh = Builder::new().build(&set).expect("a mesh").mesh;
            for p in rest {
                // The mode of these points is the normal one: kernel coordinates are theirs.
                let from = mesh.hint();
                let Ok(open) = mesh.begin(*p, from, &mut AdmitAll) else { continue };
                let tets: Vec<TetId> = open.tets().collect();
                drop(open);
                // All of the closure is asked for, and nothing else.
                let around = tets.iter().flat_map(|&t| mesh.topology().tet(t).neighbours());
                let closure: Vec<TetId> = around.map(tet_of).chain(tets.iter().copied()).collect();
                let some = mesh.topology().iter().map(|(t, _)| t).step_by(29);
                for t in closure.iter().copied().chain(some) {
                    let is_found = search.find(&mesh, p, tets[0], |other| other == t);
                    let is_barred = t != tets[0] && closure.contains(&t);
                    assert_eq!(is_found, !is_barred, "{kind:?} {p:?} {t:?}");
                }
                assert!(search.find(&mesh, p, tets[0], |_| false));
                assert_eq!(search.tets(), tets, "{kind:?} {p:?}");
                for t in mesh.tet_ids() {
                    assert_eq!(search.has(t), tets.contains(&t), "{kind:?} {p:?}");
                    assert_eq!(mesh.in_conflict(t, p), tets.contains(&t), "{kind:?} {p:?}");
                }
                let number = mesh.num_vertices() as Vertex;
                let start = tets[0];
                _ = mesh.begin(*p, start, &mut AdmitAll).map(|open| open.fill(*p, number));
            }
        }
        assert!(search.stats.insphere_calls > 1000, "{:?}", search.stats);
    }
}
