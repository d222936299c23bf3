//! Subfaces that bar many tetrahedra of a round.
//!
//! Where thousands of tetrahedra have their centres in one place, as in a ball, a few subfaces that
//! may not be split bar the points of all of them. To open a cavity of thousands of tetrahedra for
//! each only to find the same subfaces takes the time of its square. So a refusal leaves these
//! subfaces behind, and from then on a tetrahedron whose point would take one of them out of the
//! mesh is refused by two tests.

use super::bounded::Bounded;
use super::choice::ItemPlace;
use super::verdict::Judge;
use crate::outcome::Reason;
use ltbw_core::topology::{INFINITE, VertexId};
use ltbw_exact::Point;
use ltbw_exact::predicates::perturb::{side_of_hull_facet, side_of_sphere};

/// The most subfaces that one refusal leaves behind, and the most that are kept.
const MOST: [usize; 2] = [4, 64];

/// The corners of a tetrahedron by the bits of their coordinates, positively oriented; the last one
/// of one beyond the hull is at infinity.
type Side = [Option<[u64; 3]>; 4];

/// A subface that may not be split, and the tetrahedra on both sides of it: others may have the
/// subface, too.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Block {
    place: ItemPlace,
    sides: [Side; 2],
}

impl Block {
    /// The subface with these corners, between tetrahedra with these vertices.
    pub(crate) fn new(
        corners: [VertexId; 3],
        sides: [[VertexId; 4]; 2],
        at: impl Fn(VertexId) -> Point,
    ) -> Self {
        let side = |v: [VertexId; 4]| v.map(|v| (v != INFINITE).then(|| at(v).map(f64::to_bits)));
        let mut sides = sides.map(side);
        sides.sort_unstable_by_key(sorted);
        Self { place: ItemPlace::of(&corners.map(&at)), sides }
    }

    /// The place of its subface.
    pub fn place(&self) -> ItemPlace {
        self.place
    }

    /// Has another block its subface, between the tetrahedra that it is between here?
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.place == other.place
            && self.sides.map(|own| sorted(&own)) == other.sides.map(|own| sorted(&own))
    }

    /// Would a point take its subface out of the mesh?
    pub fn is_lost_to(&self, p: &Point) -> bool {
        self.sides.iter().all(|side| is_in_conflict(side, p))
    }

    /// Would a point take a tetrahedron beside it out of the mesh?
    pub fn is_touched_by(&self, p: &Point) -> bool {
        self.sides.iter().any(|side| is_in_conflict(side, p))
    }
}

fn sorted(side: &Side) -> Side {
    let mut side = *side;
    side.sort_unstable();
    side
}

/// Is a point inside the (perturbed) circumsphere of a tetrahedron?
fn is_in_conflict(side: &Side, p: &Point) -> bool {
    let [a, b, c, d] = side.map(|own| own.map(|bits| bits.map(f64::from_bits)));
    let (Some(a), Some(b), Some(c)) = (a, b, c) else { return false };
    let side = match d {
        Some(d) => side_of_sphere(&a, &b, &c, &d, p),
        None => side_of_hull_facet(&a, &b, &c, p),
    };
    side.is_positive()
}

/// A subface that tetrahedra were refused for, with what its keeper knows of it.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct KeptBlock<H> {
    /// The subface.
    pub block: Block,
    /// The knowledge of its keeper.
    pub here: H,
}

/// The subfaces that tetrahedra were refused for.
#[doc(hidden)]
#[derive(Debug)]
pub struct Blocks<H> {
    /// In earlier rounds.
    kept: Vec<KeptBlock<H>>,
    /// In this one.
    found: Vec<KeptBlock<H>>,
}

impl<H> Default for Blocks<H> {
    fn default() -> Self {
        Self { kept: Vec::new(), found: Vec::new() }
    }
}

impl<H> Blocks<H> {
    /// The blocks of others, from earlier rounds.
    pub fn of(kept: Vec<KeptBlock<H>>) -> Self {
        Self { kept, found: Vec::new() }
    }

    /// The blocks of earlier rounds.
    pub fn kept(&self) -> &[KeptBlock<H>] {
        &self.kept
    }

    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.kept.clear();
        self.found.clear();
    }

    /// Forgets those of earlier rounds that do not stay.
    pub fn retain(&mut self, stays: impl Fn(&KeptBlock<H>) -> bool) {
        self.kept.retain(stays);
    }

    /// A refusal has left some behind.
    pub fn note(&mut self, found: impl IntoIterator<Item = KeptBlock<H>>) {
        self.found.extend(found);
    }

    /// Adds those that were found in this round to those that are kept; are there any now?
    pub fn keep(&mut self) -> bool {
        let mut found = std::mem::take(&mut self.found);
        found.retain(|own| self.kept.iter().all(|other| other.block.place != own.block.place));
        found.sort_by_key(|own| own.block.place);
        found.dedup_by_key(|own| own.block.place);
        found.truncate(MOST[1].saturating_sub(self.kept.len()));
        self.kept.append(&mut found);
        !self.kept.is_empty()
    }

    /// The reason why a tetrahedron is refused whose point would take one out of the mesh, which
    /// `is_lost` says; `bars` tells why one may not be split for it, and `near` of the small angle
    /// that it is at.
    pub fn refuse(
        &self,
        is_lost: impl Fn(&KeptBlock<H>) -> bool,
        bars: impl Fn(&KeptBlock<H>) -> Option<Reason>,
        near: impl FnOnce() -> Reason,
    ) -> Option<Reason> {
        // It may be split for a shorter edge than those before allowed.
        let root = self.kept.iter().filter(|own| is_lost(own)).find_map(bars)?;
        match near() {
            Reason::Rounding => Some(root),
            named => Some(named),
        }
    }
}

/// The corners of a subface, and the tetrahedra on both sides of it.
pub(crate) type Between<T> = ([VertexId; 3], [T; 2]);

impl<B: Bounded> Judge<'_, B> {
    /// The subfaces that a refused point would take out of the mesh, if they may not be split, by
    /// what `bars` says; each with its corners and the tetrahedra on both sides.
    pub(crate) fn blocks(
        &self,
        bars: impl Fn([VertexId; 3]) -> bool,
    ) -> Vec<(Block, Between<B::Tet>)> {
        let closure = &self.closure;
        // Beside dust of a patch others may become subfaces in its place.
        let is_flat = |t: B::Tet| {
            let v = closure.vertices(t);
            v[3] != INFINITE && closure.plc().is_flat(|k| closure.carrier(v[k]))
        };
        let mut found = Vec::new();
        for face in self.survey.inner() {
            let [Some(one), Some(other)] = face.sides else { continue };
            let sides = [one, other];
            if !sides.into_iter().any(is_flat) && bars(face.key) {
                let all = sides.map(|t| closure.vertices(t));
                found.push((Block::new(face.key, all, |v| closure.at(v)), (face.key, sides)));
            }
        }
        found.sort_by_key(|own| own.0.place);
        found.truncate(MOST[0]);
        found
    }
}
