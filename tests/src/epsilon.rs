//! The symbolic perturbation by its definition, for points of small integer coordinates.
//!
//! The lift of a point, x² + y² + z², is raised by ε^r, r being the point's rank: 1 for the largest
//! by (x, y, z). A determinant with such lifts is a polynomial in ε. It is expanded here as it
//! stands, over all permutations, with polynomials as entries; its sign for all small enough
//! ε > 0 is that of its first coefficient that is not zero. No orientation of a replaced vertex, no
//! order of trial, no rounding: nothing of the kernel's rule, nor of [`crate::oracle`]'s.
//!
//! For rows (1, x, y, z, lift) of the points a, b, c, d, p, subtracting from the last column the
//! affine function that has the lifts of a, b, c, d there leaves it zero but for p, so that the
//! determinant is orient(a, b, c, d) times the height of p's lift over that function; p is inside
//! the sphere when the height is negative. The same for circles, with one coordinate fewer.

use ltbw::Sign;
use std::ops::{AddAssign, Mul, Neg};

/// A point of small integers: below 2^9, so that no coefficient overflows.
pub type Small = [i64; 3];

/// Powers of ε that occur: 0, and the ranks of five points.
const POWERS: usize = 6;

/// A polynomial in ε, by its coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Poly([i64; POWERS]);

impl Poly {
    fn constant(value: i64) -> Self {
        let mut poly = Self::default();
        poly.0[0] = value;
        poly
    }

    /// `value` + ε^`rank`.
    fn raised(value: i64, rank: usize) -> Self {
        let mut poly = Self::constant(value);
        poly.0[rank] += 1;
        poly
    }

    /// Sign for all small enough ε > 0.
    fn sign(&self) -> Sign {
        let first = self.0.iter().find(|&&c| c != 0).copied().unwrap_or(0);
        Sign::from_ordering(first.cmp(&0))
    }
}

impl AddAssign for Poly {
    fn add_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(mine, theirs)| *mine += theirs);
    }
}

impl Neg for Poly {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.map(|c| -c))
    }
}

impl Mul for Poly {
    type Output = Self;

    /// The degree of a product never exceeds that of a factor here: one column alone holds ε.
    fn mul(self, other: Self) -> Self {
        let mut product = Self::default();
        for (i, &a) in self.0.iter().enumerate().filter(|&(_, &a)| a != 0) {
            for (j, &b) in other.0.iter().enumerate().filter(|&(_, &b)| b != 0) {
                product.0[i + j] += a * b;
            }
        }
        product
    }
}

/// Sum over all permutations; `N` is at most 5.
fn determinant<const N: usize>(rows: &[[Poly; N]; N]) -> Poly {
    fn expand<const N: usize>(
        rows: &[[Poly; N]; N],
        row: usize,
        used: usize,
        term: Poly,
        sum: &mut Poly,
    ) {
        if row == N {
            *sum += term;
            return;
        }
        for column in (0..N).filter(|c| used >> c & 1 == 0) {
            // Columns used before that lie to the right: one inversion each.
            let odd = (used >> column).count_ones() % 2 == 1;
            let next = term * rows[row][column];
            if next != Poly::default() {
                expand(rows, row + 1, used | 1 << column, if odd { -next } else { next }, sum);
            }
        }
    }
    let mut sum = Poly::default();
    expand(rows, 0, 0, Poly::constant(1), &mut sum);
    sum
}

/// Lifts of the points of a test: raised by ε^rank if `perturbed`.
fn lifts<const N: usize>(points: &[Small; N], perturbed: bool) -> [Poly; N] {
    std::array::from_fn(|i| {
        let square = points[i].iter().map(|c| c * c).sum();
        if !perturbed {
            return Poly::constant(square);
        }
        // Arrays compare by x, then y, then z.
        Poly::raised(square, 1 + points.iter().filter(|q| **q > points[i]).count())
    })
}

/// Sign of det(b - a, c - a, d - a), from the rows (1, x, y, z).
#[must_use]
pub fn orient3d(points: &[Small; 4]) -> Sign {
    determinant(&points.map(|[x, y, z]| [1, x, y, z].map(Poly::constant))).sign()
}

/// Orientation of five points in the lifted space. It alternates, as determinants do.
fn lifted(points: &[Small; 5], perturbed: bool) -> Sign {
    let lifts = lifts(points, perturbed);
    let rows: [[Poly; 5]; 5] = std::array::from_fn(|i| {
        let [x, y, z] = points[i].map(Poly::constant);
        [Poly::constant(1), x, y, z, lifts[i]]
    });
    determinant(&rows).sign()
}

/// The in-sphere determinant: positive when the last point is inside the sphere of the first
/// four and these are positively oriented.
#[must_use]
pub fn insphere(points: &[Small; 5]) -> Sign {
    -lifted(points, false)
}

/// [`insphere`] with perturbed lifts: it alternates, and is zero for no five distinct points that
/// are not all in one plane.
#[must_use]
pub fn perturbed_insphere(points: &[Small; 5]) -> Sign {
    -lifted(points, true)
}

/// Is the last point inside the perturbed sphere of the first four? Zero if these are coplanar.
#[must_use]
pub fn side_of_sphere(points: &[Small; 5]) -> Sign {
    let [a, b, c, d, _] = *points;
    perturbed_insphere(points) * orient3d(&[a, b, c, d])
}

/// Turn of a, b, c in the projection to the axes `i` and `j`.
fn turn([a, b, c]: [Small; 3], [i, j]: [usize; 2]) -> Sign {
    determinant(&[a, b, c].map(|p| [1, p[i], p[j]].map(Poly::constant))).sign()
}

/// The projections, in the order in which CGAL looks for one in which three points turn.
const PLANES: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// Turn of a, b, c in the first projection in which it is not zero; zero if they are collinear.
#[must_use]
pub fn coplanar_orient(points: [Small; 3]) -> Sign {
    let turns = PLANES.map(|plane| turn(points, plane));
    turns.into_iter().find(|&s| s != Sign::Zero).unwrap_or(Sign::Zero)
}

/// Is the last of four coplanar points inside the circle of the first three (perturbed or not)?
/// Zero if these are collinear.
///
/// # Panics
/// If two projections disagree: the question does not depend on the projection.
#[must_use]
pub fn side_of_circle(points: &[Small; 4], perturbed: bool) -> Sign {
    let [a, b, c, _] = *points;
    let lifts = lifts(points, perturbed);
    let mut side = None;
    for plane in PLANES {
        let local = turn([a, b, c], plane);
        if local == Sign::Zero {
            continue;
        }
        let rows: [[Poly; 4]; 4] = std::array::from_fn(|i| {
            let [x, y] = plane.map(|axis| Poly::constant(points[i][axis]));
            [Poly::constant(1), x, y, lifts[i]]
        });
        let here = -determinant(&rows).sign() * local;
        assert_eq!(*side.get_or_insert(here), here, "{points:?}: projections disagree");
    }
    side.unwrap_or(Sign::Zero)
}

/// Is p inside the perturbed sphere of the infinite tetrahedron over the hull facet a, b, c, for
/// `[a, b, c, p]` with orient3d(a, b, c, p) > 0 for p beyond?
#[must_use]
pub fn side_of_hull_facet(points: &[Small; 4]) -> Sign {
    match orient3d(points) {
        Sign::Zero => side_of_circle(points, true),
        beyond => beyond,
    }
}

#[cfg(test)]
mod tests {
    use super::{insphere, side_of_circle, side_of_sphere};
    use ltbw::Sign;

    const CORNER: [[i64; 3]; 4] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];

    fn with(p: [i64; 3]) -> [[i64; 3]; 5] {
        let [a, b, c, d] = CORNER.map(|q| q.map(|x| 2 * x));
        [a, b, c, d, p]
    }

    #[test]
    fn inside_is_positive_and_ties_go_to_the_largest_lift() {
        assert_eq!(insphere(&with([1, 1, 1])), Sign::Positive);
        assert_eq!(insphere(&with([2, 2, 2])), Sign::Zero);
        assert_eq!(insphere(&with([3, 2, 2])), Sign::Negative);
        // The largest point is raised most: it is outside.
        assert_eq!(side_of_sphere(&with([2, 2, 2])), Sign::Negative);
        let [a, b, c, d, p] = with([2, 2, 2]);
        // Without orientation: the tetrahedron turned inside out has the same sphere.
        assert_eq!(side_of_sphere(&[b, a, c, d, p]), Sign::Negative);
    }

    #[test]
    fn circles_of_slanted_planes() {
        let slanted = |p: [i64; 2]| [p[0], p[1], p[0] + p[1]];
        let square = [[0, 0], [2, 0], [0, 2]].map(slanted);
        let [a, b, c] = square;
        assert_eq!(side_of_circle(&[a, b, c, slanted([1, 1])], false), Sign::Positive);
        assert_eq!(side_of_circle(&[a, b, c, slanted([3, 3])], false), Sign::Negative);
    }
}
