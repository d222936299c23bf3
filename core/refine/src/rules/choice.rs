//! The choice of a round by values: what is proposed, and what is decided.
//!
//! A *closure* is all that a worker has collected: the cavity of a point and the tetrahedra around
//! it. The carriers of its corners tell which of it is boundary ([`Complex`](crate::Complex)). All
//! rules are those of the rounds (`docs/rounds.md`), which look at a closure alone.

use crate::complex::carrier::Carrier;
#[doc(hidden)]
pub use crate::complex::carrier::Corner;
use crate::complex::measure::circumcircle;
use crate::mesh::key::{OrderKey, SIZE, key, key_of_tet, order_key, sorted};
use crate::outcome::Reason;
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;
use std::cmp::Reverse;

/// The vertex at infinity, among the corners of a closure.
#[doc(hidden)]
pub const NOWHERE: u32 = u32::MAX;

/// The cavity of a point, and the tetrahedra around it.
#[doc(hidden)]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Closure {
    /// The vertices.
    pub corners: Vec<Corner>,
    /// The tetrahedra by their corners, positively oriented, and whether each is in conflict with
    /// the point. One with fewer than two corners on the boundary (of a
    /// boundary item: with none) may have none here, unless there are patches.
    pub tets: Vec<([u32; 4], bool)>,
    /// The regions of these; none where there are no patches.
    pub regions: Vec<u32>,
}

impl Closure {
    /// Which corners of the tetrahedron at a place are on the boundary? [`NOWHERE`] is not.
    pub fn bound(&self, place: usize) -> [bool; 4] {
        let carrier = |v: u32| self.corners[v as usize].carrier;
        self.tets[place].0.map(|v| v != NOWHERE && carrier(v) != Carrier::Free)
    }
}

/// A boundary item by its corners, which are sorted: two of a subsegment, three of a subface.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoundaryItem {
    corners: [Corner; 3],
    count: usize,
    /// Its segment or facet.
    of: u32,
}

/// The place of an item in an order by coordinates: subsegments first.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ItemPlace(usize, [OrderKey; 3]);

impl ItemPlace {
    /// The place of the item with these corners, two or three.
    pub(crate) fn of(corners: &[Point]) -> Self {
        let mut place = [[0; 3]; 3];
        for (to, corner) in place.iter_mut().zip(corners) {
            *to = order_key(corner);
        }
        let count = corners.len().min(3);
        place[..count].sort_unstable();
        Self(count - 2, place)
    }
}

/// The place of a tetrahedron in an order by coordinates.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TetPlace([OrderKey; 4]);

impl TetPlace {
    /// The place of the tetrahedron with these corners.
    pub fn of(corners: [Point; 4]) -> Self {
        Self(sorted(corners).map(|p| order_key(&p)))
    }
}

/// The leading part of a candidate's place in the order of a round, which nearly always decides:
/// the smaller one comes first.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RankLead {
    class: u8,
    key: Reverse<u64>,
}

impl RankLead {
    /// That of a tetrahedron with this key.
    pub fn of_tet(key: u64) -> Self {
        Self { class: 2, key: Reverse(key) }
    }

    /// That of a sliver: their places decide.
    pub fn of_sliver() -> Self {
        Self { class: 3, key: Reverse(1) }
    }

    /// Is it that of a sliver?
    pub fn is_sliver(&self) -> bool {
        self.class == 3
    }

    /// The number by which candidates of one kind are compared before their places: the larger one
    /// comes first. It is not 0.
    pub fn key(&self) -> u64 {
        self.key.0
    }

    /// Is it that of a boundary item?
    pub fn is_boundary(&self) -> bool {
        self.class < 2
    }
}

/// The place of a candidate in the order of a round: the smaller one comes first.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rank {
    lead: RankLead,
    place: [OrderKey; 4],
}

impl Rank {
    /// The rank of a tetrahedron.
    pub fn of_tet(corners: [Point; 4]) -> Self {
        let place = sorted(corners).map(|p| order_key(&p));
        Self { lead: RankLead::of_tet(key_of_tet(corners)), place }
    }

    /// The rank of a sliver.
    pub fn of_sliver(corners: [Point; 4]) -> Self {
        let place = sorted(corners).map(|p| order_key(&p));
        Self { lead: RankLead::of_sliver(), place }
    }

    /// The number of the rank of a tetrahedron with these corners.
    #[inline]
    pub fn key_of_tet(corners: [Point; 4]) -> u64 {
        key_of_tet(corners)
    }

    /// Its leading part.
    pub fn lead(&self) -> RankLead {
        self.lead
    }

    /// The key of the leading part.
    pub fn key(&self) -> u64 {
        self.lead.key()
    }

    /// Are two keys of tetrahedra of about one size, so that a hash of their corners decides?
    pub fn is_tie(one: u64, other: u64) -> bool {
        one >> SIZE == other >> SIZE
    }
}

impl BoundaryItem {
    /// The item with these corners, two or three, of a segment or facet.
    pub fn new(corners: &[Corner], of: u32) -> Self {
        let count = corners.len().min(3);
        let mut own = [0, 1, 2].map(|k| corners[k % count]);
        own[..count].sort_unstable_by_key(|corner| order_key(&corner.point));
        if count == 2 {
            own[2] = own[0];
        }
        Self { corners: own, count, of }
    }

    /// Its corners, two or three.
    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    /// Its segment or facet.
    pub fn of(&self) -> u32 {
        self.of
    }

    /// Is it a subsegment?
    pub fn is_segment(&self) -> bool {
        self.count == 2
    }

    pub(crate) fn points(&self) -> [Point; 3] {
        self.corners.map(|corner| corner.point)
    }

    /// The mean of its corners, rounded.
    pub fn middle(&self) -> Point {
        let sum = |k: usize| self.corners().iter().map(|corner| corner.point[k]).sum::<f64>();
        [0, 1, 2].map(|k| sum(k) / self.count as f64)
    }

    /// Its place in an order by coordinates.
    pub fn place(&self) -> ItemPlace {
        ItemPlace::of(&self.points()[..self.count])
    }

    /// Its place among the candidates of a round.
    pub fn rank(&self) -> Rank {
        let [a, b, c] = &self.points();
        let ItemPlace(class, [x, y, z]) = self.place();
        let key = match self.is_segment() {
            true => key(distance2(a, b), &[*a, *b]),
            false => key(circumcircle(a, b, c).1, &[*a, *b, *c]),
        };
        let lead = RankLead { class: class as u8, key: Reverse(key) };
        Rank { lead, place: [x, y, z, [0; 3]] }
    }
}

/// A wall of a cavity whose new tetrahedron does not inherit its region.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relabelled {
    /// Its corners.
    pub corners: [Point; 3],
    /// The region that the tetrahedron gets.
    pub region: u32,
}

/// The changes that come with a point.
#[doc(hidden)]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filled {
    /// Items that go.
    pub gone: Vec<BoundaryItem>,
    /// Walls of the cavity whose tetrahedra do not inherit their region.
    pub relabelled: Vec<Relabelled>,
    /// Is a patch changed? Then the point is alone in its closure.
    pub is_alone: bool,
}

/// The verdict on a point.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub enum Ruling {
    /// It may be inserted.
    Fill(Filled),
    /// One of these items comes first: in rounds the first of them.
    Defer(Vec<BoundaryItem>),
    /// It cannot be, for this reason.
    Refuse(Reason),
    /// It does not do what it was made for; another one may.
    Useless,
}

/// Something of a closure's tetrahedron that a candidate before one's own has.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Rival {
    /// There is such a candidate.
    pub is_there: bool,
    /// The foremost of them is of the boundary.
    pub is_boundary: bool,
    /// The foremost of them lies on another segment or facet.
    pub is_apart: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Carrier;

    #[test]
    fn items_do_not_depend_on_the_order_of_corners() {
        let corner = |x: f64, carrier| Corner { point: [x, x * x, 0.0], carrier };
        let [a, b, c] = [
            corner(0.0, Carrier::Corner(7)),
            corner(1.0, Carrier::Facet(2)),
            corner(2.0, Carrier::Segment(3, 0)),
        ];
        assert_eq!(BoundaryItem::new(&[b, a], 5), BoundaryItem::new(&[a, b], 5));
        let all = [[a, b, c], [a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]];
        let items = all.map(|corners| BoundaryItem::new(&corners, 5));
        assert!(items.iter().all(|item| *item == items[0] && item.corners() == [a, b, c]));
        assert!(!items[0].is_segment() && BoundaryItem::new(&[c, a], 1).corners() == [a, c]);
    }
}
