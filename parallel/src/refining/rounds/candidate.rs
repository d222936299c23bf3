//! Probes and candidates as values.

use crate::protocol::{Name, WorkerId};
use crate::refining::domain::{DomainMesh, DomainPoint};
use crate::refining::news::{Bits, WireClosure};
use ltbw_core::topology::{TetId, VertexId};
use ltbw_domain::refine::{BoundaryItem, Carrier, Closure, NOWHERE, Rank, Rival};
use rustc_hash::{FxHashMap, FxHashSet};
use std::ops::Range;

/// The purpose of a probe.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum What {
    /// A tetrahedron of this worker.
    Tet(TetId, [VertexId; 4]),
    /// A boundary item that this worker keeps.
    Item(Box<BoundaryItem>),
}

impl What {
    /// It asks for an item. Bounds are read now: when all is decided, others insert already.
    pub(super) fn asks(&self, mesh: &DomainMesh<'_>, item: BoundaryItem) -> Outcome {
        let limit = match *self {
            Self::Tet(t, v) => {
                let points = v.map(|v| mesh.point(v));
                Some(mesh.complex.limit_of_tet(points, mesh.region(t)))
            }
            Self::Item(_) => None,
        };
        Outcome::Asks(Box::new(item), limit)
    }
}

/// The outcome of a probe.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    /// It is under way.
    Open,
    /// Another one has taken its place.
    Dropped,
    /// The point may be inserted, unless others are in its way; items that go then.
    Fits(Vec<BoundaryItem>),
    /// An item comes first; the shortest edge that this may lead to.
    Asks(Box<BoundaryItem>, Option<f64>),
}

/// The news of others about a probe's closure.
#[derive(Debug, Default)]
pub(super) struct Told {
    /// Far tetrahedra that were asked for.
    pub(super) known: FxHashSet<Name>,
    /// The other workers that have a part.
    pub(super) owners: Vec<WorkerId>,
    index: FxHashMap<Bits, u32>,
    /// Per owner, the places in the closure of what it has told of, in that order.
    pub(super) places: FxHashMap<WorkerId, Vec<u32>>,
}

/// The memory of closures of rounds before.
pub(super) type Spare = Vec<Box<Closure>>;

/// A probe of this worker.
#[derive(Debug)]
pub(super) struct Probe {
    pub(super) what: What,
    pub(super) rank: Rank,
    pub(super) attempt: usize,
    pub(super) to: Bits,
    pub(super) carrier: Carrier,
    pub(super) may: bool,
    /// Answers that are still to come.
    pub(super) open: u32,
    /// Its closure was searched.
    pub(super) was_searched: bool,
    /// Its cavity was found ahead.
    pub(super) is_ahead: bool,
    /// The news of others about its closure.
    pub(super) told: Option<Box<Told>>,
    /// Its closure, as far as it is known. This worker's own part is added where it matters.
    closure: Option<Box<Closure>>,
    pub(super) outcome: Outcome,
    /// Does a rival matter that has not its tetrahedron?
    pub(super) has_boundary: bool,
    /// The tetrahedron to begin at, and its vertices, as they were.
    pub(super) start: Option<(TetId, [VertexId; 4])>,
    /// Owners that are to tell of rivals.
    pub(super) due: u32,
    pub(super) rivals: Vec<Rival>,
}

impl Probe {
    pub(super) fn new(what: What, rank: Rank, attempt: usize) -> Self {
        Self {
            what,
            rank,
            attempt,
            to: [0; 3],
            carrier: Carrier::Free,
            may: false,
            open: 0,
            was_searched: false,
            is_ahead: false,
            told: None,
            closure: None,
            outcome: Outcome::Open,
            has_boundary: false,
            start: None,
            due: 0,
            rivals: Vec::new(),
        }
    }

    /// Its closure, as far as it is known.
    pub(super) fn closure(&self) -> &Closure {
        static NOTHING: Closure =
            Closure { corners: Vec::new(), tets: Vec::new(), beyond: Vec::new() };
        self.closure.as_deref().unwrap_or(&NOTHING)
    }

    /// The closure to write to; its memory is one of `spare` if it has none.
    pub(super) fn closure_in(&mut self, spare: &mut Spare) -> &mut Closure {
        self.closure.get_or_insert_with(|| spare.pop().unwrap_or_default())
    }

    /// The memory of its closure, forgotten.
    pub(super) fn into_spare(self) -> Option<Box<Closure>> {
        let mut closure = self.closure?;
        closure.clear();
        Some(closure)
    }

    /// Adds what an owner has found, in memory of `spare` if it has no closure.
    pub(super) fn add(&mut self, owner: WorkerId, found: &WireClosure, spare: &mut Spare) {
        let Self { closure, told, .. } = self;
        let closure = closure.get_or_insert_with(|| spare.pop().unwrap_or_default());
        let Told { index, places, .. } = &mut **told.get_or_insert_default();
        let numbers: Vec<u32> = found
            .corners
            .iter()
            .map(|corner| {
                *index.entry(corner.at).or_insert_with(|| {
                    closure.corners.push(corner.corner());
                    closure.corners.len() as u32 - 1
                })
            })
            .collect();
        let places = places.entry(owner).or_default();
        for (v, is_in) in &found.tets {
            places.push(closure.tets.len() as u32);
            let v = v.map(|k| if k == NOWHERE { k } else { numbers[k as usize] });
            closure.tets.push((v, *is_in));
        }
    }
}

/// A point of this worker that is to be inserted in this round.
#[derive(Clone, Debug)]
pub(super) struct ChosenPoint {
    pub(super) point: DomainPoint,
    /// The tetrahedron that it begins at, and its vertices.
    pub(super) start: Option<(TetId, [VertexId; 4])>,
    /// Its cavity, if its closure was all here.
    pub(super) cavity: Range<usize>,
}
