//! The slivers of one worker, and the points that are tried for them, one after the other.

use super::ranked::Own;
use crate::refining::domain::DomainMesh;
use crate::refining::news::Bits;
use ltbw_core::topology::TetId;
use ltbw_domain::quality::LeastAngles;
use ltbw_refine::{BoundaryItem, Carrier, Filled, OnBoundary, Tries};

/// The thing that is tried for a sliver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Now {
    /// A point inside.
    Inside,
    /// The way to its centre: what bars it?
    Looking,
    /// A point on one of the items.
    Beside { item: usize, gives_way: bool },
    /// The best point, which is taken.
    Taken,
}

/// A sliver, and the tries for it.
#[derive(Debug)]
pub(super) struct Sliver {
    pub(super) own: Own,
    pub(super) tries: Tries,
    pub(super) now: Now,
    /// The boundary items that points are tried on; before, those that keep points inside away.
    pub(super) items: Vec<BoundaryItem>,
    /// The item on the way to its centre, until others have told of its sides.
    pub(super) blocked: Option<BoundaryItem>,
    pub(super) best: Option<Best>,
}

/// The best point so far.
#[derive(Debug)]
pub(super) struct Best {
    pub(super) to: Bits,
    pub(super) carrier: Carrier,
    pub(super) filled: Filled,
}

/// The slivers of one worker.
#[derive(Debug, Default)]
pub(super) struct Slivers {
    /// The slivers to be looked at, if all bounds are met.
    pub(super) list: Option<Vec<Own>>,
    /// Its tetrahedra by their smallest dihedral angle when slivers were looked for, if asked.
    pub(super) before: Option<LeastAngles>,
    /// The slivers of this round.
    pub(super) all: Vec<Sliver>,
    /// The slivers among them that a point serves: if others are in its way they are looked at
    /// once more.
    pub(super) served: Vec<Own>,
}

impl Slivers {
    /// Have rounds of slivers begun?
    pub(super) fn has_begun(&self) -> bool {
        self.list.is_some()
    }

    /// Rounds of slivers go on with these.
    pub(super) fn resume(&mut self, list: Vec<Own>) {
        self.list = Some(list);
    }

    /// The points of this round are inserted.
    pub(super) fn carry_out(&mut self) {
        if let Some(list) = &mut self.list {
            *list = std::mem::take(&mut self.served);
        }
    }

    /// No point serves any.
    pub(super) fn end(&mut self) {
        self.list = Some(Vec::new());
    }

    /// The slivers that are left to be looked at, if rounds of slivers have begun.
    pub(super) fn into_left(self, mesh: &DomainMesh<'_>) -> Option<Vec<TetId>> {
        let is_left = |&(t, v): &Own| mesh.has(t, v);
        self.list.map(|list| list.into_iter().filter(is_left).map(|own| own.0).collect())
    }
}

impl Sliver {
    /// The boundary item that a point is tried on, if it is on one.
    pub(super) fn on(&self) -> Option<OnBoundary<'_>> {
        match self.now {
            Now::Beside { item, gives_way } => {
                Some(OnBoundary { item: &self.items[item], gives_way })
            }
            Now::Inside | Now::Looking | Now::Taken => None,
        }
    }
}
