//! The news about circles of boundary items that wait for each other.

use super::{Bits, OWNED, Owned, PLACE, WireCorner, WireItem, WireItemRefusal, WireLimit, bits};
use super::{corners_bytes, item_bytes, point};
use ltbw_core::topology::TetId;
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;
use ltbw_refine::{Asked, Carrier, ItemPlace, TetPlace};

/// A boundary item that waits, in a message.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WireAsked {
    item: WireItem,
    first: Option<ItemPlace>,
    limit: Option<WireLimit>,
}

impl WireAsked {
    pub(crate) fn new(own: &Asked) -> Self {
        let (first, limit) = (own.first, own.limit.map(WireLimit::new));
        Self { item: WireItem::new(&own.item), first, limit }
    }

    pub(crate) fn asked(&self) -> Asked {
        let limit = self.limit.map(WireLimit::limit);
        Asked { item: self.item.item(), first: self.first, limit }
    }
}

/// A closed ball, all tetrahedra at whose vertices are lent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Ball {
    #[cfg_attr(feature = "wire", serde(with = "crate::wire::bits"))]
    centre: Bits,
    /// The square of its radius, as bits.
    square: u64,
}

impl Ball {
    pub(crate) fn new(centre: &Point, square: f64) -> Self {
        Self { centre: bits(centre), square: square.to_bits() }
    }

    /// Is a point in it?
    pub(crate) fn has(&self, p: &Point) -> bool {
        distance2(&point(&self.centre), p) <= f64::from_bits(self.square)
    }

    /// The place that it is, if it is no more than that.
    pub(crate) fn spot(&self) -> Option<Bits> {
        (self.square == 0).then_some(self.centre)
    }
}

/// A tetrahedron that is lent, by its vertices, its region and its slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WireLent {
    pub(crate) v: [u32; 4],
    pub(crate) region: u32,
    pub(crate) slot: TetId,
}

/// The tetrahedra that a worker lends.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WirePart {
    pub(crate) corners: Vec<WireCorner>,
    pub(crate) tets: Vec<WireLent>,
}

impl WirePart {
    pub(super) fn bytes(&self) -> u64 {
        8 + corners_bytes(&self.corners) + 16 * self.tets.len() as u64
    }
}

/// A point of a circle, and the tetrahedron that has it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WirePoint {
    #[cfg_attr(feature = "wire", serde(with = "crate::wire::bits"))]
    pub(crate) at: Bits,
    pub(crate) carrier: Carrier,
    pub(crate) within: Option<Owned>,
}

/// The outcome of all circles.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WireParted {
    pub(crate) points: Vec<WirePoint>,
    /// Items that are not to be split any more.
    pub(crate) ended: Vec<ItemPlace>,
    /// Items that are refused, or are not any more.
    pub(crate) refused: Vec<WireItemRefusal>,
    /// The transactions of joint steps in rounds so far.
    pub(crate) spent: u64,
    /// The regions of tetrahedra that are new or have another one than before.
    pub(crate) labels: Vec<(TetPlace, u32)>,
    /// The tetrahedra among these that are not new.
    pub(crate) relabelled: Vec<Owned>,
}

impl WireParted {
    pub(super) fn bytes(&self) -> u64 {
        let labels = self.labels.len() as u64;
        16 + (24 + 9 + OWNED) * self.points.len() as u64
            + PLACE * self.ended.len() as u64
            + (PLACE + 36) * self.refused.len() as u64
            + (4 * 24 + 4) * labels
            + OWNED * self.relabelled.len() as u64
    }
}

/// Bytes of items that wait.
pub(super) fn asked_bytes(all: &[WireAsked]) -> u64 {
    4 + all.iter().map(|own| item_bytes(&own.item) + PLACE + 18).sum::<u64>()
}

/// Bytes of balls.
pub(super) fn balls_bytes(all: &[Ball]) -> u64 {
    4 + 32 * all.len() as u64
}
