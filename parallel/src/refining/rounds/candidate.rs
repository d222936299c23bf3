//! Probes and candidates as values.

use super::reserved::{LazyRank, Whose};
use crate::protocol::table::Table;
use crate::protocol::{Name, WorkerId};
use crate::refining::domain::{DomainMesh, DomainPoint};
use crate::refining::news::{Bits, Owned, ProbeId, Proposal, WireClosure};
use ltbw_core::topology::{TetId, VertexId};
use ltbw_refine::{
    BoundaryItem, Carrier, Closure, Filled, Limit, NOWHERE, Past, Rank, RankLead, Reason, Rival,
    Watch,
};
use rustc_hash::FxHashMap;
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
    /// It asks for the first of some items that may be split, or is refused if none may. Bounds are
    /// read now: when all is decided, others insert already.
    pub(super) fn asks(
        &self,
        mesh: &DomainMesh<'_>,
        first: &[BoundaryItem],
        past: &Past<'_>,
    ) -> Outcome {
        let (past, limit, reason) = match *self {
            Self::Tet(_, v) => {
                let past = self.under_limit(mesh, past);
                let reason = || mesh.complex.reason_near(v.map(|v| mesh.corner(v)));
                let is_told = past.refused.is_empty() && !first.is_empty();
                let reason = if is_told { Reason::Rounding } else { reason() };
                (past, past.limit, reason)
            }
            Self::Item(_) => (*past, None, Reason::Rounding),
        };
        match past.first_of(first, reason) {
            Ok(item) => Outcome::Asks(Box::new(item), limit),
            Err(reason) => Outcome::Refused(reason),
        }
    }

    /// Its past, with the limit of a tetrahedron.
    pub(super) fn under_limit<'p>(&self, mesh: &DomainMesh<'_>, past: &Past<'p>) -> Past<'p> {
        match *self {
            Self::Tet(t, v) => {
                let points = v.map(|v| mesh.point(v));
                let limit = Some(mesh.complex.limit_of_tet(points, mesh.region(t)));
                Past { limit, ..*past }
            }
            Self::Item(_) => *past,
        }
    }
}

/// The outcome of a probe.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    /// It is under way.
    Open,
    /// Another one has taken its place.
    Dropped,
    /// The point may be inserted, unless others are in its way.
    Fits(Filled),
    /// An item comes first; the edges that this may lead to.
    Asks(Box<BoundaryItem>, Option<Limit>),
    /// It cannot be split.
    Refused(Reason),
}

/// A probe, and the point that it is about.
#[derive(Clone, Debug)]
pub(super) struct Seeker {
    pub(super) probe: ProbeId,
    pub(super) to: Bits,
    pub(super) carrier: Carrier,
    pub(super) rank: LazyRank,
}

impl Seeker {
    /// The candidate as one that reserves.
    pub(super) fn whose(&self) -> Whose {
        Whose { rank: self.rank.clone(), carrier: self.carrier }
    }

    /// The candidate as another worker is told of it; `of_tet` tells a rank.
    pub(super) fn proposal(&self, of_tet: impl Fn([VertexId; 4]) -> Rank) -> Proposal {
        let Self { probe, to, carrier, .. } = *self;
        Proposal { probe, to, carrier, rank: self.rank.whole(of_tet) }
    }
}

impl From<Proposal> for Seeker {
    fn from(own: Proposal) -> Self {
        let Proposal { probe, to, carrier, rank } = own;
        Self { probe, to, carrier, rank: LazyRank::told(rank) }
    }
}

/// The news of others about a probe's closure.
#[derive(Debug, Default)]
pub(super) struct Told {
    /// Far tetrahedra that were asked for.
    pub(super) known: Table<Name, ()>,
    /// The other workers that have a part.
    pub(super) owners: Vec<WorkerId>,
    /// The closure, as far as it is known. This worker's own part is added where it matters.
    pub(super) closure: Closure,
    /// Its tetrahedra, where there are patches.
    pub(super) tets: Vec<Owned>,
    index: FxHashMap<Bits, u32>,
    /// Per owner, the places in the closure of what it has told of, in that order.
    pub(super) places: Table<WorkerId, Vec<u32>>,
    /// Owners that are to tell of rivals.
    pub(super) due: u32,
    pub(super) rivals: Vec<Rival>,
}

impl Told {
    /// Adds what an owner has found.
    pub(super) fn add(&mut self, owner: WorkerId, found: &WireClosure) {
        let Self { closure, tets, index, places, .. } = self;
        index.reserve(found.corners.len());
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
        closure.regions.extend(&found.regions);
        tets.extend(found.slots.iter().map(|&tet| Owned { owner, tet }));
        let places = places.entry(owner, Vec::new);
        places.reserve(found.tets.len());
        closure.tets.reserve(found.tets.len());
        for (v, is_in) in &found.tets {
            places.push(closure.tets.len() as u32);
            let v = v.map(|k| if k == NOWHERE { k } else { numbers[k as usize] });
            closure.tets.push((v, *is_in));
        }
    }

    /// Adds the rivals that an owner has found, in the order in which it has told of its part.
    pub(super) fn add_rivals(&mut self, owner: WorkerId, rivals: impl IntoIterator<Item = Rival>) {
        self.rivals.resize(self.closure.tets.len(), Rival::default());
        let places = self.places.get(owner).into_iter().flatten();
        for (&place, rival) in places.zip(rivals) {
            self.rivals[place as usize] = rival;
        }
    }
}

/// The tetrahedra at which others before a candidate make it wait.
#[derive(Debug)]
pub(super) enum Waits {
    /// All of its closure is here, and listed there if rivals anywhere in it matter.
    Here(Watch<TetId>, Range<usize>),
    /// Others have told of it.
    Told(Watch<usize>),
}

/// A probe of this worker.
#[derive(Debug)]
pub(super) struct Probe {
    pub(super) what: What,
    pub(super) lead: RankLead,
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
    /// If a block bars its tetrahedron: the reason why that is refused.
    pub(super) barred: Option<Reason>,
    /// Is its tetrahedron not to be split, since another one of its group is?
    pub(super) follows: bool,
    /// Do others tell of the tetrahedra beyond the sides of its own, not of its closure?
    pub(super) asks_beyond: bool,
    /// The news of others about its closure.
    pub(super) told: Option<Box<Told>>,
    pub(super) outcome: Outcome,
    pub(super) waits: Option<Box<Waits>>,
    /// The tetrahedron that a boundary item's point begins at, and its vertices, as they were.
    pub(super) start: Option<(TetId, [VertexId; 4])>,
    /// Its turn, if candidates have turns.
    pub(super) turn: Option<Box<Turn>>,
    /// If its tetrahedron is a sliver: the number among those of the round, and its rank.
    pub(super) sliver: Option<Box<(usize, Rank)>>,
}

/// The turn of a candidate.
#[derive(Debug)]
pub(super) struct Turn {
    /// Its number among its home's.
    pub(super) number: u32,
    /// Of a boundary item: the closures of points that did not do.
    pub(super) passed: Vec<Owned>,
}

impl Probe {
    pub(super) fn new(what: What, lead: RankLead, attempt: usize) -> Self {
        Self {
            what,
            lead,
            attempt,
            to: [0; 3],
            carrier: Carrier::Free,
            may: false,
            open: 0,
            was_searched: false,
            is_ahead: false,
            barred: None,
            follows: false,
            asks_beyond: false,
            told: None,
            outcome: Outcome::Open,
            waits: None,
            start: None,
            turn: None,
            sliver: None,
        }
    }

    /// Its rank.
    pub(super) fn rank(&self) -> LazyRank {
        match &self.what {
            _ if let Some(own) = &self.sliver => LazyRank::told(own.1),
            What::Tet(_, v) => LazyRank::of_tet(self.lead, *v),
            What::Item(item) => LazyRank::told(item.rank()),
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
