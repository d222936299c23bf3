//! The change of a facet's triangulation, and what it is found by.

use super::state::State;
use crate::complex::carrier::Carrier;
use crate::complex::plc::Plc;
use crate::table::sides;
use ltbw_core::topology::VertexId;
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, coplanar_orient};
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
    pub(crate) relabelled: Vec<([VertexId; 3], u32)>,
    /// Of a patch: walls that become subfaces.
    pub(crate) raised: Vec<[VertexId; 3]>,
}

impl Change {
    /// No change.
    pub(crate) fn of(facet: u32) -> Self {
        let (removed, rim, relabelled, raised) = Default::default();
        Self { facet, removed, rim, relabelled, raised }
    }
}

/// Subfaces of a facet by their sides.
pub(crate) struct Sides {
    /// Each side with the place of a subface that has it, sorted.
    all: Vec<([VertexId; 2], u32)>,
    /// Sides that were looked at so far.
    steps: Cell<u64>,
}

impl Sides {
    pub(crate) fn of(subfaces: &[[VertexId; 3]]) -> Self {
        let own = |(k, s): (u32, &[VertexId; 3])| sides(*s).map(|(side, _)| (side, k));
        let mut all: Vec<_> = (0..).zip(subfaces).flat_map(own).collect();
        all.sort_unstable();
        Self { all, steps: Cell::new(0) }
    }

    /// The places of the subfaces at a side, ascending.
    pub(crate) fn at(&self, side: [VertexId; 2]) -> impl Iterator<Item = usize> + '_ {
        let first = self.all.partition_point(|(other, _)| *other < side);
        let own = self.all[first..].iter().take_while(move |(other, _)| *other == side);
        own.map(|&(_, k)| {
            self.steps.set(self.steps.get() + 1);
            k as usize
        })
    }

    /// The places of what is reached from some subfaces without crossing what is `closed`, breadth
    /// first.
    pub(crate) fn reached(
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
    /// Is facet `f` a patch?
    pub(crate) fn is_patch(&self, f: u32) -> bool {
        self.plc.is_patch(f)
    }
}

impl Plc {
    /// Is facet `f` a patch?
    pub(crate) fn is_patch(&self, f: u32) -> bool {
        self.facets[f as usize].patch.is_some()
    }

    /// The turn of three points on facet `f`; of a patch, in the projection.
    pub(crate) fn turn_on(&self, f: u32, [a, b, c]: [&Point; 3]) -> Sign {
        match &self.facets[f as usize].patch {
            Some(patch) => Sign::from_ordering(patch.turn([a, b, c]).cmp(&0)),
            None => coplanar_orient(a, b, c),
        }
    }

    /// The facets that a point on `carrier` lies on.
    pub(crate) fn facets_of<'f>(&'f self, carrier: &'f Carrier) -> &'f [u32] {
        match carrier {
            Carrier::Corner(c) => &self.facets_at[*c as usize],
            Carrier::Segment(s, _) => &self.segments[*s as usize].facets,
            Carrier::Facet(f) => std::slice::from_ref(f),
            Carrier::Free => &[],
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
