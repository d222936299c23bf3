//! Symbolic perturbation: an in-sphere test that is never zero.
//!
//! CGAL's rule (Devillers and Teillaud, *Perturbations for Delaunay and weighted Delaunay 3D
//! triangulations*, 2011): of the points of a test, sorted by (x, y, z), the lifted coordinate
//! x² + y² + z² of the largest is raised by ε, that of the next by ε², and so on, ε tending to
//! zero. The in-sphere determinant becomes a polynomial in ε whose coefficients, after the
//! constant one, are orientations; its sign for small ε is that of the first coefficient that is
//! not zero. Orientations are never perturbed, so that no flat tetrahedra arise.
//!
//! The rule depends on the coordinates alone: the Delaunay triangulation is one function of the
//! point set. All functions need pairwise distinct points; with equal points, they return some
//! sign.

use super::{Sign, coplanar_orient, insphere, orient3d, side_of_bounded_circle};
use crate::Point;

/// Is `p` after `q` in the order by (x, y, z)? No branch: on a grid the outcome is a coin toss.
#[inline(always)]
fn exceeds(p: &Point, q: &Point) -> bool {
    let z = p[2] > q[2];
    let y = (p[1] > q[1]) | ((p[1] == q[1]) & z);
    (p[0] > q[0]) | ((p[0] == q[0]) & y)
}

/// Hands out the indices of `points` from the largest point to the smallest, one at a time: the
/// perturbation looks at more than two only if its input was not as it should be.
struct Descending<'a, const N: usize> {
    points: [&'a Point; N],
    used: [bool; N],
}

impl<'a, const N: usize> Descending<'a, N> {
    fn new(points: [&'a Point; N]) -> Self {
        Self { points, used: [false; N] }
    }
}

impl<const N: usize> Iterator for Descending<'_, N> {
    type Item = usize;

    /// The largest point not yet handed out; ends after N.
    fn next(&mut self) -> Option<usize> {
        let mut largest: Option<usize> = None;
        for i in 0..N {
            let after = |j: usize| exceeds(self.points[i], self.points[j]);
            if !self.used[i] && largest.is_none_or(after) {
                largest = Some(i);
            }
        }
        if let Some(i) = largest {
            self.used[i] = true;
        }
        largest
    }
}

/// The side of the perturbed sphere through `p0, p1, p2, p3` on which `p` lies: positive inside,
/// negative outside, never zero. Needs `orient3d(p0, p1, p2, p3)` positive and distinct points.
#[must_use]
pub fn side_of_sphere(p0: &Point, p1: &Point, p2: &Point, p3: &Point, p: &Point) -> Sign {
    let exact = insphere(p0, p1, p2, p3, p);
    if exact.is_zero() { perturbed_side(p0, p1, p2, p3, p) } else { exact }
}

/// [`side_of_sphere`] for points of which the caller knows that `insphere` is zero.
///
/// The loop has at most five rounds, and two decide: were `p` coplanar with the two facets
/// opposite the largest two vertices, it would lie on the line through the other two vertices;
/// a line meets the sphere in two points at most, so `p` would equal one of them.
#[must_use]
pub fn perturbed_side(p0: &Point, p1: &Point, p2: &Point, p3: &Point, p: &Point) -> Sign {
    let points = [p0, p1, p2, p3, p];
    let round = |q: usize| {
        if q == 4 {
            return Sign::Negative;
        }
        let mut corners = [p0, p1, p2, p3];
        corners[q] = p;
        orient3d(corners[0], corners[1], corners[2], corners[3])
    };
    // The first round nearly always decides.
    let mut largest = 0;
    for i in 1..5 {
        largest = if exceeds(points[i], points[largest]) { i } else { largest };
    }
    let side = round(largest);
    if !side.is_zero() {
        return side;
    }
    // Every round that does not decide is one of p0 to p3, and there are five.
    let mut sides = Descending::new(points).skip(1).map(round);
    sides.find(|side| !side.is_zero()).unwrap_or(Sign::Negative)
}

/// The side of the perturbed circle through `p0, p1, p2`, in their plane, on which `p` lies:
/// positive inside, negative outside, never zero. Needs four distinct coplanar points, of which
/// `p0, p1, p2` are not collinear (their orientation is free).
#[must_use]
pub fn side_of_circle(p0: &Point, p1: &Point, p2: &Point, p: &Point) -> Sign {
    let exact = side_of_bounded_circle(p0, p1, p2, p);
    if !exact.is_zero() {
        return exact;
    }
    // On the circle. As on the sphere, two rounds decide: a point collinear with two edges of
    // the triangle is their common vertex.
    let local = coplanar_orient(p0, p1, p2);
    for q in Descending::new([p0, p1, p2, p]).take(3) {
        let side = match q {
            0 => coplanar_orient(p, p1, p2),
            1 => coplanar_orient(p0, p, p2),
            2 => coplanar_orient(p0, p1, p),
            _ => return Sign::Negative,
        };
        if !side.is_zero() {
            return side * local;
        }
    }
    -local
}

/// Does `p` see the hull facet `a, b, c`, i.e. is it inside the sphere of the infinite
/// tetrahedron beyond that facet? The orientation is such that `orient3d(a, b, c, p)` is positive
/// for points beyond. In the facet's plane, the facet's perturbed circle decides.
///
/// Never zero for distinct points and `a, b, c` not collinear.
#[must_use]
pub fn side_of_hull_facet(a: &Point, b: &Point, c: &Point, p: &Point) -> Sign {
    let beyond = orient3d(a, b, c, p);
    if beyond.is_zero() { side_of_circle(a, b, c, p) } else { beyond }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicates::cmp_xyz;

    /// All points of {-1, 0, 1}^3, the zeros with either sign.
    fn lattice() -> impl Iterator<Item = Point> + Clone {
        (0..64).map(|i| [i & 3, i >> 2 & 3, i >> 4].map(|k| [-1.0, -0.0, 0.0, 1.0][k as usize]))
    }

    #[test]
    fn the_branch_free_order_is_that_by_coordinates() {
        for p in lattice() {
            for q in lattice() {
                assert_eq!(exceeds(&p, &q), cmp_xyz(&p, &q).is_gt(), "{p:?} {q:?}");
            }
        }
    }

    #[test]
    fn points_are_handed_out_from_the_largest_each_once() {
        let points: Vec<Point> = lattice().collect();
        for i in 0..64 {
            let five = [0, 7, 21, 38, 49].map(|k| &points[(i * (k + 1) + k) % 64]);
            let order: Vec<usize> = Descending::new(five).collect();
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, [0, 1, 2, 3, 4]);
            assert!(order.is_sorted_by(|&j, &k| cmp_xyz(five[j], five[k]).is_ge()), "{five:?}");
        }
    }

    /// Equal points are outside the contract; the answer is some sign all the same.
    #[test]
    fn equal_points_get_some_sign() {
        let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for p in [&o, &x, &y, &z] {
            assert!(!perturbed_side(&o, &x, &y, &z, p).is_zero());
        }
        for p in [&o, &x, &y] {
            assert!(!side_of_circle(&o, &x, &y, p).is_zero());
        }
    }
}
