//! The knowledge that a worker has of circles, and what the conductor is lent.

use crate::protocol::WorkerId;
use crate::refining::flags::Flags;
use crate::refining::news::{
    Ball, Bits, Owned, WireCorner, WireItemRefusal, WireLent, WirePart, WireParted, WirePoint, bits,
};
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;
use ltbw_refine::{Asked, BoundaryItem, Lent, LentTet, NOWHERE, Parted, PartedPoint};
use rustc_hash::FxHashMap;

/// The radius around an item in which vertices are lent first, over that of its corners.
const REACH: f64 = 3.0;

/// No vertex lent has this number: what is lent with it is refused.
const UNKNOWN: u32 = NOWHERE - 1;

/// The knowledge that a worker has of circles.
#[derive(Debug, Default)]
pub(super) struct Circles {
    /// The tetrahedra lent in this stage, by slot.
    pub(super) given: Flags,
    /// The outcome of the circles, while their points are inserted.
    pub(super) parted: Option<Box<WireParted>>,
    /// The conductor's: workers that have still to tell or to lend.
    pub(super) awaited: u32,
    /// The times that it has asked for what lies somewhere.
    pub(super) loans: u32,
    /// Items that wait.
    pub(super) asked: Vec<Asked>,
    /// The balls asked for.
    pub(super) balls: Vec<Ball>,
    pub(super) lent: Lent,
    /// The tetrahedra lent, at their owners.
    pub(super) owners: Vec<Owned>,
    /// The numbers of the vertices lent.
    pub(super) numbers: FxHashMap<Bits, u32>,
}

impl Circles {
    /// Are the points of circles inserted, and the regions of new tetrahedra not known yet?
    pub(super) fn are_inserted(&self) -> bool {
        self.parted.is_some()
    }

    /// Enters what a worker lends.
    pub(super) fn enter(&mut self, from: WorkerId, part: WirePart) {
        let mut number = |corner: &WireCorner| {
            let Self { lent, numbers, .. } = &mut *self;
            *numbers.entry(corner.at).or_insert_with(|| {
                lent.corners.push(corner.corner());
                lent.corners.len() as u32 - 1
            })
        };
        let numbers: Vec<u32> = part.corners.iter().map(&mut number).collect();
        let number = |k: u32| match k {
            NOWHERE => NOWHERE,
            k => numbers.get(k as usize).copied().unwrap_or(UNKNOWN),
        };
        for WireLent { v, region, slot } in part.tets {
            let v = v.map(number);
            self.lent.tets.push(LentTet { v, region });
            self.owners.push(Owned { owner: from, tet: slot });
        }
    }

    /// The balls to ask for, of those around vertices: none that was asked for before.
    pub(super) fn new_balls(&self, missed: &[Point]) -> Vec<Ball> {
        let is_new = |p: &&Point| !self.balls.iter().any(|ball| ball.has(p));
        missed.iter().filter(is_new).map(|p| Ball::new(p, 0.0)).collect()
    }

    /// The outcome, to be told.
    pub(super) fn wire(&self, parted: Parted) -> WireParted {
        let owned = |place: usize| self.owners[place];
        let told = |own: &PartedPoint| WirePoint {
            at: bits(&own.point),
            carrier: own.carrier,
            within: own.within.map(owned),
        };
        let refused = parted.refused.into_iter();
        WireParted {
            points: parted.points.iter().map(told).collect(),
            ended: parted.ended,
            refused: refused.map(|(place, why)| WireItemRefusal::new(place, why)).collect(),
            spent: parted.spent as u64,
            labels: parted.labels.iter().map(|own| (own.place, own.region)).collect(),
            relabelled: parted.relabelled.into_iter().map(owned).collect(),
        }
    }
}

/// The ball around an item in which vertices are lent first.
pub(super) fn ball_around(item: &BoundaryItem) -> Ball {
    let corners = item.corners();
    let share = 1.0 / corners.len() as f64;
    let centre = [0, 1, 2].map(|k| corners.iter().map(|own| own.point[k] * share).sum());
    let squares = corners.iter().map(|own| distance2(&own.point, &centre));
    Ball::new(&centre, REACH * REACH * squares.fold(0.0, f64::max))
}
