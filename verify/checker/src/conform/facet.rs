//! A facet of the domain and the faces of the mesh that tile it, in the plane.

use super::outline::{Flat, Weighted, signed_area};
use super::slab::{big_dot, cross, minus};
use super::tree::{Shape, Tree, bounds};
use super::whole::{Whole, twice_area};
use num_bigint::BigInt;
use std::collections::HashSet;

/// A facet projected along the largest axis of its normal.
#[derive(Debug)]
pub(crate) struct FlatFacet {
    pub(crate) axes: [usize; 2],
    /// Three corners that are not collinear.
    pub(crate) frame: [u32; 3],
    polygons: Vec<Vec<Flat>>,
    holes: Vec<Flat>,
}

impl FlatFacet {
    /// `None` if the corners are collinear. `at` gives the corners.
    pub(crate) fn new(
        polygons: &[Vec<u32>],
        holes: &[Whole],
        at: impl Fn(u32) -> Whole,
    ) -> Option<Self> {
        let mut corners = polygons.iter().flatten().copied();
        let first = corners.next()?;
        let second = corners.find(|&v| at(v) != at(first))?;
        let normal = |v: u32| {
            let [o, a, b] = [first, second, v].map(&at);
            cross(&minus(&a, &o), &minus(&b, &o))
        };
        let third = corners.find(|&v| normal(v) != [0; 3])?;
        let n = normal(third).map(i128::unsigned_abs);
        let axis = (0..3).max_by_key(|&k| n[k])?;
        let axes = [(axis + 1) % 3, (axis + 2) % 3];
        let flat = |p: Whole| axes.map(|k| 3 * p[k]);
        let polygons =
            polygons.iter().map(|polygon| polygon.iter().map(|&v| flat(at(v))).collect());
        Some(Self {
            axes,
            frame: [first, second, third],
            polygons: polygons.collect(),
            holes: holes.iter().map(|&p| flat(p)).collect(),
        })
    }

    /// The plane: its normal without common divisors, the first entry that is not zero positive,
    /// and its scalar product with the plane's points.
    pub(crate) fn plane(&self, corners: &[Whole]) -> ([i128; 3], BigInt) {
        let [o, a, b] = self.frame.map(|v| corners[v as usize]);
        // Differences are below 2^62, so entries of the normal are below 2^125.
        let n = cross(&minus(&a, &o), &minus(&b, &o));
        let mut divisor = 0u128;
        for c in &n {
            let (mut x, mut y) = (divisor, c.unsigned_abs());
            // Euclid: ends because the remainders shrink.
            while y != 0 {
                (x, y) = (y, x % y);
            }
            divisor = x;
        }
        // The corners are not collinear, so the divisor is not zero.
        let sign = n.iter().find(|c| **c != 0).map_or(1, |c| c.signum());
        let n = n.map(|c| c / (divisor as i128 * sign));
        (n, big_dot(&n, &o))
    }

    /// The polygons, each with its change inside: 1 if the facet begins at its outline, -1 if it
    /// ends there, 0 if neither. Polygons may be nested but must not cross.
    pub(crate) fn weighted(&self) -> impl Iterator<Item = Weighted<'_>> {
        let weights = match (self.polygons.len(), self.holes.len()) {
            (1, 0) => vec![1],
            _ => self.weights(),
        };
        let weighted = |(polygon, weight)| Weighted { polygon, weight };
        self.polygons.iter().map(Vec::as_slice).zip(weights).map(weighted)
    }

    /// The weights of many polygons. Cost: n log n, and what pairs of polygons cost of which one is
    /// in the box of the other.
    fn weights(&self) -> Vec<i8> {
        let flat = |p: &Flat| [p[0], p[1], 0];
        let firsts = self.polygons.iter().map(|polygon| polygon.first().map_or([0; 3], flat));
        let points: Vec<Whole> = firsts.chain(self.holes.iter().map(flat)).collect();
        let tree = Tree::new(&points, (0..points.len() as u32).collect());
        // Per polygon, and then per hole: the polygons that it is in.
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
        for (l, outer) in (0u32..).zip(&self.polygons) {
            tree.search(&Shape::within(bounds(outer.iter().map(flat))), |i| {
                let is_inside = match self.polygons.get(i as usize) {
                    _ if i == l => false,
                    // A corner on the other's outline says nothing: ask one that is off it.
                    Some(own) => {
                        let off = own.iter().find(|q| !is_on_outline(outer, **q));
                        off.is_some_and(|q| encloses(outer, *q))
                    }
                    None => encloses(outer, self.holes[i as usize - self.polygons.len()]),
                };
                around[i as usize].extend(is_inside.then_some(l));
            });
        }
        let (around, holes) = around.split_at(self.polygons.len());
        let holes: HashSet<&Vec<u32>> = holes.iter().collect();
        // A piece of the plane, by the polygons around it: not the outside, nor one of a hole.
        let is_facet = |piece: &Vec<u32>| i8::from(!piece.is_empty() && !holes.contains(piece));
        (0u32..)
            .zip(around)
            .map(|(k, outside)| {
                let place = outside.partition_point(|&l| l < k);
                let inside = [&outside[..place], &[k], &outside[place..]].concat();
                is_facet(&inside) - is_facet(outside)
            })
            .collect()
    }

    /// Twice the area of the projection, in the units of [`FlatFacet::area_of`].
    pub(crate) fn area(&self) -> BigInt {
        let area = |Weighted { polygon, weight }: Weighted<'_>| {
            let area = signed_area(polygon);
            (if area < BigInt::ZERO { -area } else { area }) * weight
        };
        self.weighted().map(area).sum()
    }

    /// Twice the area of a triangle's projection, in the same units.
    pub(crate) fn area_of(&self, corners: [Whole; 3]) -> BigInt {
        let [a, b, c] = corners.map(|p| self.axes.map(|k| 3 * p[k]));
        // Three times a coordinate is below 2^62, so products fit.
        BigInt::from(twice_area(a, b, c).abs())
    }

    /// Three times the centroid of a triangle, in the projection.
    pub(crate) fn centroid(&self, corners: [Whole; 3]) -> Flat {
        self.axes.map(|k| corners.iter().map(|p| p[k]).sum())
    }
}

/// Does a ray from `p` cross the outline an odd number of times?
pub(super) fn encloses(polygon: &[Flat], p: Flat) -> bool {
    let mut inside = false;
    for (k, &a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        if (a[1] > p[1]) != (b[1] > p[1]) {
            let side = twice_area(a, b, p);
            inside ^= if b[1] > a[1] { side > 0 } else { side < 0 };
        }
    }
    inside
}

pub(super) fn is_on_outline(polygon: &[Flat], p: Flat) -> bool {
    (0..polygon.len()).any(|k| {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        twice_area(a, b, p) == 0 && (0..2).all(|i| a[i].min(b[i]) <= p[i] && p[i] <= a[i].max(b[i]))
    })
}

#[cfg(test)]
mod tests {
    use super::super::outline::Outline;
    use super::*;

    #[test]
    fn a_facet_with_an_island_in_a_hole_has_the_area_between() {
        let square = |low: i128, high: i128| {
            [[low, low, 5], [high, low, 5], [high, high, 5], [low, high, 5]]
        };
        let corners: Vec<Whole> = [square(0, 12), square(2, 10), square(4, 8)].concat();
        let polygons: Vec<Vec<u32>> = (0..3).map(|k| (4 * k..4 * k + 4).collect()).collect();
        let at = |v: u32| corners[v as usize];
        let area = |holes: &[Whole]| {
            let facet = FlatFacet::new(&polygons, holes, at).expect("a plane");
            facet.area() / 18
        };
        assert_eq!(area(&[]), BigInt::from(144));
        assert_eq!(area(&[[3, 3, 5]]), BigInt::from(144 - 64 + 16));
        assert_eq!(area(&[[6, 6, 5]]), BigInt::from(144 - 16));
        assert_eq!(area(&[[3, 3, 5], [6, 6, 5]]), BigInt::from(144 - 64));
        let facet = FlatFacet::new(&polygons, &[[3, 3, 5]], at).expect("a plane");
        let outline = Outline::new(facet.weighted());
        let holds = |t: [Whole; 3]| outline.weight_at(facet.centroid(t), &mut 0) > 0;
        assert!(holds([[0, 0, 5], [2, 0, 5], [0, 2, 5]]));
        assert!(!holds([[2, 2, 5], [4, 2, 5], [2, 4, 5]]));
        assert!(holds([[4, 4, 5], [8, 4, 5], [4, 8, 5]]));
        assert_eq!(facet.area_of([[0, 0, 5], [2, 0, 5], [0, 2, 5]]), BigInt::from(9 * 4));
        assert!(FlatFacet::new(&[vec![0, 1]], &[], at).is_none());
    }
}
