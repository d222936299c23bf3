//! The slivers of a mesh: tetrahedra with small dihedral angles, which bounds on their shape allow.

use crate::mesh::bounds::Bounds;
use crate::mesh::item::Item;
use crate::mesh::key::sorted;
use crate::mesh::number::in_order;
use crate::mesh::state::State;
use crate::outcome::{Reason, Sliver};
use crate::queue::split::Refinement;
use crate::rules::sliver::is_open_sliver;
use crate::thin::Thin;
use ltbw_core::topology::{INFINITE, Tet, TetId, VertexId};
use ltbw_domain::quality::{LeastAngles, TetQuality};
use rayon::prelude::*;

impl Refinement<'_> {
    /// The slivers that a point may serve, in the order of their coordinates: none in a collar,
    /// where the domain asks for small angles.
    pub(crate) fn slivers(&mut self) -> Vec<Thin> {
        let (state, thin) = (&self.state, &mut self.inserted.thin.tets);
        let Some(bounds) = &self.bounds else { return Vec::new() };
        if bounds.dihedral.is_none() {
            return Vec::new();
        }
        thin.retain(|&(t, v)| state.is_live(t, v));
        let is_open = |t: TetId, v| {
            let (corners, region) = (state.cornered(v), state.marks.region(t));
            is_open_sliver(&state.plc, &state.angles, bounds, &corners, region)
        };
        let mut slivers: Vec<Thin> = thin.iter().copied().filter(|&(t, v)| is_open(t, v)).collect();
        slivers.sort_by_cached_key(|&(t, v)| state.place_of(Item::Tet(t, v)));
        slivers.dedup();
        debug_assert!(
            state.mesh.tet_ids().filter(|&t| is_open(t, state.vertices(t))).count()
                == slivers.len(),
            "all slivers are in the list"
        );
        slivers
    }
}

impl State {
    /// The slivers of a list that may have others, and has all, in the order of their numbers.
    pub(crate) fn slivers_among(&self, thin: Vec<Thin>, bounds: &Bounds<'_>) -> Vec<Sliver> {
        let is_left = |&(t, v): &Thin| self.is_live(t, v) && self.is_sliver(t, bounds);
        let mut left: Vec<Thin> = thin.into_iter().filter(is_left).collect();
        left.sort_by_cached_key(|&(t, _)| self.mesh.tet(t).map(in_order));
        left.dedup();
        let named = |v| Some(self.reason_near(v)).filter(|reason| *reason != Reason::Rounding);
        let near = |v| self.asks_for_shape(v, bounds).or_else(|| named(v));
        let sliver = |(tet, v)| Sliver { tet, angle: self.least_angle(v), near: near(v) };
        left.into_iter().map(sliver).collect()
    }

    /// The smallest dihedral angle of a tetrahedron in degrees, rounded in an order that is always
    /// the same.
    pub(crate) fn least_angle(&self, v: [VertexId; 4]) -> f64 {
        TetQuality::of(sorted(v.map(|v| self.at(v))).each_ref()).least_dihedral()
    }

    /// The tetrahedra of the domain by their smallest dihedral angle, counted by some threads.
    pub(crate) fn least_angles(&self, threads: usize) -> LeastAngles {
        let add = |mut sum: LeastAngles, (t, tet): (TetId, &Tet)| {
            let v = tet.vertices();
            if v[3] != INFINITE && self.marks.region(t) != 0 {
                sum.add(v.map(|v| self.at(v)).each_ref());
            }
            sum
        };
        let all = self.mesh.topology();
        let none = LeastAngles::default;
        match threads > 1 {
            true => all.par_iter().fold(none, add).reduce(none, LeastAngles::merged),
            false => all.iter().fold(none(), add),
        }
    }

    /// Is a tetrahedron in a region, and has it a dihedral angle below the bound?
    pub(crate) fn is_sliver(&self, t: TetId, bounds: &Bounds<'_>) -> bool {
        let Some(dihedral) = bounds.dihedral.filter(|_| self.marks.region(t) != 0) else {
            return false;
        };
        let v = self.vertices(t);
        dihedral.is_missed(v.map(|v| self.at(v)).each_ref())
    }
}
