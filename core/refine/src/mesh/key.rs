//! Keys and orders that are functions of coordinates alone, whatever the numbers of vertices and
//! slots: what is chosen first, and what comes first of several.

use super::item::Item;
use super::state::State;
use crate::complex::measure::{Shape, circumcircle};
use crate::outcome::Spot;
use ltbw_core::topology::VertexId;
use ltbw_domain::vector::distance2;
pub(crate) use ltbw_domain::vector::sorted;
use ltbw_exact::Point;
use std::cmp::Reverse;

/// A place in the order of points: coordinates are whole.
pub(crate) type OrderKey = [i64; 3];

/// The place of a point in the order by x, y, z.
pub(crate) fn order_key(p: &Point) -> OrderKey {
    p.map(|c| c as i64)
}

/// The lowest bit of the size in a key.
pub(crate) const SIZE: u32 = 48;

/// The key of an item: 16 leading bits of the square of its size, then 47 bits of a hash of its
/// corners, which are sorted, and a 1. The larger comes first; no key is 0.
///
/// The hash: from 0, for each coordinate of each corner, `h = (h ^ bits) * 0x9e3779b97f4a7c15`
/// modulo 2^64, then `h ^= h >> 32`, where `bits` are those of the coordinate as `f64`.
pub(crate) fn key(size2: f64, corners: &[Point]) -> u64 {
    let hash = corners.iter().flatten().fold(0u64, |h, c| {
        let h = (h ^ c.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        h ^ h >> 32
    });
    let size = if size2.is_nan() { f64::INFINITY } else { size2 };
    size.to_bits() >> SIZE << SIZE | hash >> 16 | 1
}

/// The key of a tetrahedron with these corners.
#[inline(always)]
pub(crate) fn key_of_tet(corners: [Point; 4]) -> u64 {
    let corners = sorted(corners);
    let [a, b, c, d] = &corners;
    key(Shape::of([a, b, c, d]).radius2(), &corners)
}

/// The middle of a boundary item, in the coordinates of the mesh.
pub(crate) fn spot(item: Item, at: impl Fn(VertexId) -> Point, fine_step: f64) -> Spot {
    let corners: &[VertexId] = match &item {
        Item::Segment(s) => s,
        Item::Subface(s) => s,
        Item::Tet(_, v) => v,
    };
    let mut points: Vec<Point> = corners.iter().map(|&v| at(v)).collect();
    points.sort_unstable_by_key(order_key);
    let step = fine_step / points.len() as f64;
    Spot::new([0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() * step))
}

/// The place of an item in an order by coordinates, which `at` tells: segments first.
pub(crate) fn place_of(item: Item, at: impl Fn(VertexId) -> Point) -> (usize, [OrderKey; 4]) {
    let mut place = [[0; 3]; 4];
    let mut put = |corners: &[VertexId]| {
        for (to, &v) in place.iter_mut().zip(corners) {
            *to = order_key(&at(v));
        }
        place[..corners.len()].sort_unstable();
    };
    match item {
        Item::Segment(s) => put(&s),
        Item::Subface(s) => put(&s),
        Item::Tet(_, v) => put(&v),
    }
    let class = match item {
        Item::Segment(_) => 0,
        Item::Subface(_) => 1,
        Item::Tet(..) => 2,
    };
    (class, place)
}

/// The key of an item, of whose vertices `at` tells the coordinates.
fn key_of(item: Item, at: impl Fn(VertexId) -> Point) -> u64 {
    match item {
        Item::Segment(s) => {
            let [a, b] = sorted(s.map(at));
            key(distance2(&a, &b), &[a, b])
        }
        Item::Subface(s) => {
            let corners = sorted(s.map(at));
            let [a, b, c] = &corners;
            key(circumcircle(a, b, c).1, &corners)
        }
        Item::Tet(_, v) => key_of_tet(v.map(at)),
    }
}

/// Sorts boundary items, of whose vertices `at` tells the coordinates: segments first, and of each
/// kind the largest key.
///
/// The one that is split should be large: what is encroached with it may be gone afterwards.
pub(crate) fn sort_largest_first(items: &mut [Item], at: impl Fn(VertexId) -> Point) {
    if items.len() > 1 {
        items.sort_by_cached_key(|&item| {
            let (class, place) = place_of(item, &at);
            (class, Reverse(key_of(item, &at)), place)
        });
    }
}

impl State {
    /// The place of an item in an order by coordinates: segments first.
    pub(crate) fn place_of(&self, item: Item) -> (usize, [OrderKey; 4]) {
        place_of(item, |v| self.at(v))
    }

    /// The key of an item.
    pub(crate) fn key_of(&self, item: Item) -> u64 {
        key_of(item, |v| self.at(v))
    }

    /// Sorts boundary items by coordinates.
    pub(crate) fn sort(&self, items: &mut [Item]) {
        if items.len() > 1 {
            items.sort_by_cached_key(|&item| self.place_of(item));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoundaryItem, Carrier, Corner};

    /// Engines without a whole mesh go by the ranks of items.
    #[test]
    fn items_are_sorted_as_their_ranks_tell() {
        let at = |v: VertexId| {
            let k = i32::try_from(v.number()).expect("a small number");
            [k % 5, k / 5 % 2, k * k % 7].map(f64::from)
        };
        let vertex = VertexId::new;
        let segments = (1..12).map(|k| Item::Segment([k, k + 1 + k % 3].map(vertex)));
        let faces = (1..12).map(|k| Item::Subface([k, k + 1, k + 3].map(vertex)));
        let mut items: Vec<Item> = faces.chain(segments).collect();
        let rank = |item: &Item| {
            let corner = |v| Corner { point: at(v), carrier: Carrier::Facet(0) };
            let own = match item {
                Item::Segment(s) => BoundaryItem::new(&s.map(corner), 1),
                Item::Subface(s) => BoundaryItem::new(&s.map(corner), 2),
                Item::Tet(..) => panic!("no tetrahedra"),
            };
            (own.rank().lead(), own.place())
        };
        let mut by_rank = items.clone();
        by_rank.sort_by_cached_key(rank);
        assert_ne!(items, by_rank);
        sort_largest_first(&mut items, at);
        assert_eq!(items, by_rank);
    }

    #[test]
    fn points_are_sorted_by_all_coordinates() {
        let mut points = Vec::new();
        for k in 0..27 {
            points.push([k / 9, k / 3 % 3, k % 3].map(|c| f64::from(c) - 1.0));
        }
        for k in 0..27 * 27 * 27 {
            let own = [points[k % 27], points[k / 27 % 27], points[k / 729], points[(k * 7) % 27]];
            let mut slow = own;
            slow.sort_by_key(order_key);
            assert_eq!(sorted(own), slow);
        }
    }

    #[test]
    fn larger_sizes_have_larger_keys() {
        let corners = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let keys = [0.0, 1e-300, 1.0, 1.25, 2.0, 1e300, f64::INFINITY].map(|s| key(s, &corners));
        assert!(keys.is_sorted_by(|a, b| a < b) && keys[0] > 0);
        assert_eq!(key(f64::NAN, &corners), key(f64::INFINITY, &corners));
        assert_ne!(key(1.0, &corners), key(1.0, &sorted([corners[1], [1.0, 2.0, 4.0]])));
    }
}
