//! The past of proposals by values: the grounds of verdicts beside the closure, for engines whose
//! mesh is on many processors.

use super::choice::{BoundaryItem, ItemPlace};
use super::record::{Refusal, first_of};
use crate::mesh::limit::Limit;
use crate::outcome::Reason;
use std::collections::BTreeMap;

/// Boundary items that were refused.
#[doc(hidden)]
pub type Refusals = BTreeMap<ItemPlace, Refusal>;

/// The past of a proposal.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Past<'p> {
    /// The vertices of the whole mesh.
    pub num_vertices: usize,
    /// The transactions of joint steps in rounds so far.
    pub spent: usize,
    /// The edges that splitting the item may make.
    pub limit: Option<Limit>,
    /// The boundary items that were refused.
    pub refused: &'p Refusals,
}

impl<'p> Past<'p> {
    /// That of domains without small angles.
    pub fn without(refused: &'p Refusals) -> Self {
        Self { num_vertices: 0, spent: 0, limit: None, refused }
    }

    /// The first of some items that may be split under its limit; else the reason why none may,
    /// after one that is known.
    ///
    /// # Errors
    /// That reason.
    pub fn first_of(&self, items: &[BoundaryItem], reason: Reason) -> Result<BoundaryItem, Reason> {
        first_of(items, |item| self.bars(item.place()), reason)
    }

    /// The reason why the item at a place was refused, unless its limit allows it.
    pub fn bars(&self, place: ItemPlace) -> Option<Reason> {
        let refusal = self.refused.get(&place)?;
        (!refusal.allows(self.limit)).then_some(refusal.reason)
    }
}
