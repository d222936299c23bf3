//! The triangulation of a facet, kept up to date without a two-dimensional mesh.
//!
//! For a point p of facet f, a subface of f is in f's planar cavity of p exactly if both its
//! tetrahedra are in the cavity of p: the perturbed circumsphere of a tetrahedron on the subface
//! meets the plane in the subface's perturbed circumcircle. So the planar cavity is the subfaces of
//! f inside the open cavity, and those missing subfaces of f whose perturbed circle holds p, as far
//! as they can be reached from where p is without crossing a subsegment. (Subsegments that wait for
//! their repair make f's triangulation a constrained Delaunay one for a while.) p joined to the rim
//! of the planar cavity are the new subfaces.

use super::carrier::Carrier;
use super::measure::in_equatorial_ball;
use super::state::{State, Touched};
use super::table::sides;
use ltbw_core::topology::VertexId;
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, coplanar_orient, perturb};
use std::cell::Cell;

/// The change of one facet's triangulation.
#[derive(Debug)]
pub(crate) struct Change {
    pub(crate) facet: u32,
    /// Subfaces that go.
    pub(crate) removed: Vec<[VertexId; 3]>,
    /// Edges that the new point is joined to.
    pub(crate) rim: Vec<[VertexId; 2]>,
    /// Of a patch: walls whose tetrahedra do not inherit their label, and the label they get.
    pub(crate) relabelled: Vec<(usize, u32)>,
    /// Of a patch: walls that become subfaces.
    pub(crate) raised: Vec<(usize, [VertexId; 3])>,
}

impl Change {
    /// No change.
    pub(crate) fn of(facet: u32) -> Self {
        let (removed, rim, relabelled, raised) = Default::default();
        Self { facet, removed, rim, relabelled, raised }
    }
}

/// Where the search for a planar cavity starts.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Seed {
    /// At the subfaces along the subsegment that is split.
    Along([VertexId; 2]),
    /// At the subface that is split.
    At([VertexId; 3]),
}

/// Subfaces of a facet by their sides.
struct Sides {
    /// Each side with the place of a subface that has it, sorted.
    all: Vec<([VertexId; 2], u32)>,
    /// Sides that were looked at so far.
    steps: Cell<u64>,
}

impl Sides {
    fn of(subfaces: &[[VertexId; 3]]) -> Self {
        let own = |(k, s): (u32, &[VertexId; 3])| sides(*s).map(|(side, _)| (side, k));
        let mut all: Vec<_> = (0..).zip(subfaces).flat_map(own).collect();
        all.sort_unstable();
        Self { all, steps: Cell::new(0) }
    }

    /// The places of the subfaces at a side, ascending.
    fn at(&self, side: [VertexId; 2]) -> impl Iterator<Item = usize> + '_ {
        let first = self.all.partition_point(|(other, _)| *other < side);
        let own = self.all[first..].iter().take_while(move |(other, _)| *other == side);
        own.map(|&(_, k)| {
            self.steps.set(self.steps.get() + 1);
            k as usize
        })
    }

    /// The places of what is reached from some subfaces without crossing what is `closed`, breadth
    /// first.
    fn reached(
        &self,
        subfaces: &[[VertexId; 3]],
        mut list: Vec<usize>,
        closed: impl Fn([VertexId; 2]) -> bool,
    ) -> Vec<usize> {
        let mut taken = vec![false; subfaces.len()];
        list.iter().for_each(|&k| taken[k] = true);
        // Each subface enters once.
        let mut next = 0;
        while let Some(&k) = list.get(next) {
            next += 1;
            for (side, _) in sides(subfaces[k]).into_iter().filter(|(side, _)| !closed(*side)) {
                let others = self.at(side).filter(|&l| !std::mem::replace(&mut taken[l], true));
                list.extend(others);
            }
        }
        list
    }
}

impl State {
    /// The change that `p`, in whose cavity the boundary is `touched`, makes to the triangulation
    /// of facet `f`; `None` if `p` does not see its whole rim, which means that it lies elsewhere.
    pub(crate) fn plan(&self, touched: &Touched, f: u32, p: &Point, seed: Seed) -> Option<Change> {
        let mut candidates: Vec<[VertexId; 3]> =
            touched.inner.iter().filter(|(_, g)| *g == f).map(|(s, _)| *s).collect();
        let missing = self.missing_near(f, p);
        candidates.extend(missing.into_iter().filter(|s| self.conflicts(f, *s, p, seed)));
        let starts = |k: &usize| match seed {
            Seed::Along([a, b]) => candidates[*k].contains(&a) && candidates[*k].contains(&b),
            Seed::At(target) => candidates[*k] == target,
        };
        let starts = (0..candidates.len()).filter(starts).collect();
        let closed = |side| self.segments.contains_key(&side);
        let list = Sides::of(&candidates).reached(&candidates, starts, closed);
        let removed: Vec<[VertexId; 3]> = list.iter().map(|&k| candidates[k]).collect();
        self.rim(f, &removed, p, seed).map(|rim| Change { removed, rim, ..Change::of(f) })
    }

    /// Is `p` in the perturbed circle of a missing subface, or on its edge that is split?
    fn conflicts(&self, f: u32, s: [VertexId; 3], p: &Point, seed: Seed) -> bool {
        if let Seed::Along([x, y]) = seed
            && s.contains(&x)
            && s.contains(&y)
        {
            return true;
        }
        let [a, b, c] = s.map(|v| self.at(v));
        match self.is_patch(f) {
            true => in_equatorial_ball(&a, &b, &c, p),
            false => perturb::side_of_circle(&a, &b, &c, p) == Sign::Positive,
        }
    }

    /// The edges of the removed subfaces that border on nothing removed, but for the one that is
    /// split; `None` if `p` is not strictly on the inner side of each.
    pub(crate) fn rim(
        &self,
        f: u32,
        removed: &[[VertexId; 3]],
        p: &Point,
        seed: Seed,
    ) -> Option<Vec<[VertexId; 2]>> {
        let mut rim = Vec::new();
        let all = Sides::of(removed);
        for s in removed {
            for (side, opposite) in sides(*s) {
                let split = matches!(seed, Seed::Along(e) if e == side);
                let shared = all.at(side).nth(1).is_some();
                // Across a subsegment both subfaces may go, but the subsegment stays.
                if split || shared && !self.segments.contains_key(&side) {
                    continue;
                }
                let (a, b) = (self.at(side[0]), self.at(side[1]));
                let inner = self.turn_on(f, &a, &b, &self.at(opposite));
                if self.turn_on(f, &a, &b, p) != inner {
                    return None;
                }
                rim.push(side);
            }
        }
        Some(rim)
    }

    /// The turn of three points on facet `f`; of a patch, in the projection.
    pub(crate) fn turn_on(&self, f: u32, a: &Point, b: &Point, c: &Point) -> Sign {
        match &self.plc.facets[f as usize].patch {
            Some(patch) => Sign::from_ordering(patch.turn([a, b, c]).cmp(&0)),
            None => coplanar_orient(a, b, c),
        }
    }

    /// Is facet `f` a patch?
    pub(crate) fn is_patch(&self, f: u32) -> bool {
        self.plc.facets[f as usize].patch.is_some()
    }

    /// The facets that a point on `carrier` lies on.
    pub(crate) fn facets_of(&self, carrier: Carrier) -> Vec<u32> {
        match carrier {
            Carrier::Corner(c) => self.plc.facets_at[c as usize].clone(),
            Carrier::Segment(s, _) => self.plc.segments[s as usize].facets.clone(),
            Carrier::Facet(f) => vec![f],
            Carrier::Free => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_subface_of_a_large_fan_is_looked_at_a_few_times() {
        for count in [1 << 8, 1 << 14] {
            let corner = |k: u32| VertexId::new(k);
            let fan: Vec<[VertexId; 3]> =
                (1..=count).map(|k| [corner(0), corner(k), corner(k + 1)]).collect();
            let middle = count / 2;
            let all = Sides::of(&fan);
            let closed = [corner(0), corner(middle)];
            let reached = all.reached(&fan, vec![0], |side| side == closed);
            // From the first one to where a side is closed.
            assert_eq!(reached, (0..middle as usize - 1).collect::<Vec<_>>());
            let outline = fan.iter().flat_map(|s| sides(*s));
            assert_eq!(
                outline.filter(|(side, _)| all.at(*side).nth(1).is_none()).count(),
                2 + count as usize
            );
            assert!(all.steps.get() < 16 * u64::from(count), "{count}: {}", all.steps.get());
        }
    }
}
