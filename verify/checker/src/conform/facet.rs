//! A facet of the domain and the faces of the mesh that tile it, in the plane.

use super::whole::{Whole, twice_area};
use num_bigint::BigInt;

/// A point of the facet's plane: two of its coordinates, times three.
type Flat = [i128; 2];

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
            let (p, q) = ([0, 1, 2].map(|k| a[k] - o[k]), [0, 1, 2].map(|k| b[k] - o[k]));
            [(1, 2), (2, 0), (0, 1)].map(|(i, j)| p[i] * q[j] - p[j] * q[i])
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
    pub(crate) fn plane(&self, corners: &[Whole]) -> ([BigInt; 3], BigInt) {
        let [o, a, b] = self.frame.map(|v| corners[v as usize].map(BigInt::from));
        let (p, q) = ([0, 1, 2].map(|k| &a[k] - &o[k]), [0, 1, 2].map(|k| &b[k] - &o[k]));
        let n = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &p[i] * &q[j] - &p[j] * &q[i]);
        let mut divisor = BigInt::ZERO;
        for c in &n {
            let (mut x, mut y) = (divisor, c.clone());
            // Euclid: ends because the remainders shrink.
            while y != BigInt::ZERO {
                (x, y) = (y.clone(), x % y);
            }
            divisor = x;
        }
        let negative = n.iter().find(|c| **c != BigInt::ZERO).is_some_and(|c| *c < BigInt::ZERO);
        if negative != (divisor < BigInt::ZERO) {
            divisor = -divisor;
        }
        // The corners are not collinear, so the divisor is not zero.
        let n = n.map(|c| c / &divisor);
        let level = n.iter().zip(&o).map(|(x, y)| x * y).sum();
        (n, level)
    }

    /// Is the centroid of a triangle in the facet?
    pub(crate) fn holds_centroid(&self, corners: [Whole; 3]) -> bool {
        let centre = self.axes.map(|k| corners.iter().map(|p| p[k]).sum());
        self.is_inside(&self.enclosing(centre))
    }

    /// Which polygons enclose a point strictly (of a point on an outline: one of two neighbours).
    fn enclosing(&self, p: Flat) -> Vec<bool> {
        self.polygons.iter().map(|polygon| encloses(polygon, p)).collect()
    }

    /// Does a piece of the plane that these polygons enclose belong to the facet? Not the outside,
    /// nor the piece of a hole point.
    fn is_inside(&self, enclosing: &[bool]) -> bool {
        enclosing.contains(&true)
            && !self.holes.iter().any(|&hole| self.enclosing(hole) == enclosing)
    }

    /// Twice the area of the projection, in the units of [`FlatFacet::area_of`]. Polygons may be
    /// nested but must not cross: then each counts with what changes at its outline.
    pub(crate) fn area(&self) -> BigInt {
        let mut sum = BigInt::ZERO;
        for (k, polygon) in self.polygons.iter().enumerate() {
            let mut outside = vec![false; self.polygons.len()];
            for (l, other) in self.polygons.iter().enumerate() {
                // A corner on the other's outline says nothing: ask one that is off it.
                let off = polygon.iter().find(|q| !is_on_outline(other, **q));
                outside[l] = l != k && off.is_some_and(|q| encloses(other, *q));
            }
            let mut inside = outside.clone();
            inside[k] = true;
            let change = i8::from(self.is_inside(&inside)) - i8::from(self.is_inside(&outside));
            let area: BigInt =
                (2..polygon.len()).map(|i| big_area(polygon[0], polygon[i - 1], polygon[i])).sum();
            let area = if area < BigInt::ZERO { -area } else { area };
            sum += area * change;
        }
        sum
    }

    /// Twice the area of a triangle's projection, in the same units.
    pub(crate) fn area_of(&self, corners: [Whole; 3]) -> BigInt {
        let [a, b, c] = corners.map(|p| self.axes.map(|k| 3 * p[k]));
        let area = big_area(a, b, c);
        if area < BigInt::ZERO { -area } else { area }
    }
}

/// Twice the signed area; three times a coordinate is below 2^63, so products fit.
fn big_area(a: Flat, b: Flat, c: Flat) -> BigInt {
    BigInt::from(twice_area(a, b, c))
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
        assert!(facet.holds_centroid([[0, 0, 5], [2, 0, 5], [0, 2, 5]]));
        assert!(!facet.holds_centroid([[2, 2, 5], [4, 2, 5], [2, 4, 5]]));
        assert!(facet.holds_centroid([[4, 4, 5], [8, 4, 5], [4, 8, 5]]));
        assert_eq!(facet.area_of([[0, 0, 5], [2, 0, 5], [0, 2, 5]]), BigInt::from(9 * 4));
        assert!(FlatFacet::new(&[vec![0, 1]], &[], at).is_none());
    }
}
