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

impl State {
    /// The change that `p`, in whose cavity the boundary is `touched`, makes to the triangulation
    /// of facet `f`; `None` if `p` does not see its whole rim, which means that it lies elsewhere.
    pub(crate) fn plan(&self, touched: &Touched, f: u32, p: &Point, seed: Seed) -> Option<Change> {
        let mut candidates: Vec<[VertexId; 3]> =
            touched.inner.iter().filter(|(_, g)| *g == f).map(|(s, _)| *s).collect();
        let missing = self.missing_near(f, p);
        candidates.extend(missing.into_iter().filter(|s| self.conflicts(f, *s, p, seed)));
        let mut taken = vec![false; candidates.len()];
        let mut list: Vec<usize> = Vec::new();
        for (k, s) in candidates.iter().enumerate() {
            let starts = match seed {
                Seed::Along([a, b]) => s.contains(&a) && s.contains(&b),
                Seed::At(target) => *s == target,
            };
            if starts {
                taken[k] = true;
                list.push(k);
            }
        }
        // Breadth first; each candidate enters once.
        let mut next = 0;
        while let Some(&k) = list.get(next) {
            next += 1;
            for (side, _) in sides(candidates[k]) {
                if self.segments.contains_key(&side) {
                    continue;
                }
                for (other, s) in candidates.iter().enumerate() {
                    if !taken[other] && s.contains(&side[0]) && s.contains(&side[1]) {
                        taken[other] = true;
                        list.push(other);
                    }
                }
            }
        }
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
        for (k, s) in removed.iter().enumerate() {
            for (side, opposite) in sides(*s) {
                let split = matches!(seed, Seed::Along(e) if e == side);
                let shared = removed
                    .iter()
                    .enumerate()
                    .any(|(l, r)| l != k && r.contains(&side[0]) && r.contains(&side[1]));
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
