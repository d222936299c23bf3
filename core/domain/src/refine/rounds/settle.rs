//! After the insertions: which tetrahedra are over their bounds, with which keys.

use super::Rounds;
use crate::refine::RefineError;
use crate::refine::item::Item;
use crate::refine::key::{key, sorted};
use crate::refine::marks::{ENDS, FACES};
use crate::refine::measure::Shape;
use crate::refine::table::{Set, edge};
use ltbw_core::topology::TetId;

/// The key of a slot that was written in the round: no key is this one.
const WRITTEN: u64 = u64::MAX;

impl Rounds<'_, '_> {
    /// Looks at the tetrahedra that the insertions of the round have made.
    pub(super) fn settle(&mut self) {
        let topology = self.own.state.mesh.topology();
        self.keys.resize(topology.slots(), 0);
        self.reserved.resize(topology.slots(), 0);
        // Each slot is looked at once, however often it was written.
        let keys = &mut self.keys;
        self.created.retain(|&t| std::mem::replace(&mut keys[t as usize], WRITTEN) != WRITTEN);
        self.bad.retain(|&t| {
            let own = &mut keys[t as usize];
            if *own != WRITTEN && topology.at(t).is_free() {
                *own = 0;
            }
            *own != 0 && *own != WRITTEN
        });
        let mut created = std::mem::take(&mut self.created);
        for t in created.drain(..) {
            self.keys[t as usize] = 0;
            self.look_at_tet(t);
        }
        self.created = created;
        // Items that are gone are asked for no more.
        let state = &self.own.state;
        self.pending.retain(|item, _| match item {
            Item::Segment(s) => state.segments.contains_key(s),
            Item::Subface(s) => state.subfaces.contains_key(s),
            Item::Tet(..) => false,
        });
    }

    /// Looks at all tetrahedra.
    pub(super) fn look_at_all(&mut self) {
        let slots = self.own.state.mesh.topology().slots();
        self.keys = vec![0; slots];
        self.reserved.resize(slots, 0);
        self.bad.clear();
        let all: Vec<TetId> = self.own.state.mesh.tet_ids().collect();
        all.into_iter().for_each(|t| self.look_at_tet(t));
    }

    /// Gives a tetrahedron over its bounds its key, unless it was refused.
    fn look_at_tet(&mut self, t: TetId) {
        let state = &self.own.state;
        let tet = state.mesh.topology().at(t);
        let over = |b: &crate::refine::bounds::Bounds<'_>| b.is_over(state, t);
        if tet.is_free() || tet.is_ghost() || !self.own.bounds.as_ref().is_some_and(over) {
            return;
        }
        let v = tet.vertices();
        if self.own.record.refused.contains_key(&Item::Tet(t, v)) {
            return;
        }
        let corners = sorted(v.map(|v| state.at(v)));
        let [a, b, c, d] = &corners;
        self.keys[t as usize] = key(Shape::of([a, b, c, d]).radius2(), &corners);
        self.bad.push(t);
    }

    /// Checks that the mesh has every subsegment and subface.
    ///
    /// # Errors
    /// One is missing: a round has lost it.
    pub(super) fn check_complete(&self) -> Result<(), RefineError> {
        let state = &self.own.state;
        let (mut faces, mut edges) = (0, Set::default());
        for (t, tet) in state.mesh.topology().iter() {
            let (word, v) = (state.marks.of(t), tet.vertices());
            faces += (word & FACES).count_ones() as usize;
            for (k, [i, j]) in ENDS.into_iter().enumerate() {
                if word >> (4 + k) & 1 == 1 {
                    edges.insert(edge(v[i], v[j]));
                }
            }
        }
        let whole = faces == 2 * state.subfaces.len() && edges.len() == state.segments.len();
        match whole {
            true => Ok(()),
            false => Err(RefineError::Invariant { what: "the mesh has all of the boundary" }),
        }
    }
}
