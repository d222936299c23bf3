//! Cavities found for the next choice, as values.

use super::ranked::{Own, RankedHere};
use crate::protocol::Rules;
use crate::refining::domain::DomainMesh;
use crate::refining::news::Bits;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_refine::{Carrier, Keys};
use rustc_hash::FxHashMap;
use std::ops::Range;

/// The cavities found ahead.
#[derive(Debug, Default)]
pub(super) struct Ahead {
    /// The tetrahedra whose cavities are to be found.
    pub(super) next: Vec<Own>,
    found: FxHashMap<TetId, Found>,
    cavities: Vec<TetId>,
}

/// The point of a tetrahedron, and its cavity as of a look.
#[derive(Debug)]
struct Found {
    v: [VertexId; 4],
    to: Bits,
    carrier: Carrier,
    look: u32,
    cavity: Range<usize>,
}

impl Ahead {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.next.clear();
        self.found.clear();
        self.cavities.clear();
    }

    /// Enters the point of a tetrahedron, and its cavity, as of a look.
    pub(super) fn enter(
        &mut self,
        (t, v): Own,
        to: Bits,
        carrier: Carrier,
        look: u32,
        cavity: &[TetId],
    ) {
        let first = self.cavities.len();
        self.cavities.extend_from_slice(cavity);
        let cavity = first..self.cavities.len();
        self.found.insert(t, Found { v, to, carrier, look, cavity });
    }

    /// The point of a tetrahedron, and its cavity, if both are as a search would find them now.
    pub(super) fn of<C: Rules>(
        &self,
        mesh: &DomainMesh<'_>,
        keys: &Keys,
        (t, v): Own,
    ) -> Option<(Bits, Carrier, &[TetId])> {
        let found = self.found.get(&t).filter(|found| found.v == v)?;
        let cavity = &self.cavities[found.cavity.clone()];
        // R27.
        let stands = !C::checks_ahead()
            || keys.are_unchanged(&RankedHere::<C>::of(mesh), cavity, found.look);
        stands.then_some((found.to, found.carrier, cavity))
    }
}
