//! Exact geometric predicates: a proved filter first, exact arithmetic after it.
//!
//! Sign conventions (CGAL's and VTK's): `orient3d(a, b, c, d)` is the sign of
//! det(b-a, c-a, d-a), positive for the unit tetrahedron (0, x, y, z). `insphere(a, b, c, d, e)`
//! is positive when `e` lies inside the sphere through a positively oriented tetrahedron
//! `a, b, c, d`, and changes its sign with the orientation of `a, b, c, d`.
//!
//! The predicates of this module are right for **any finite coordinates**: subnormal, huge, or of
//! exponents as far apart as `f64` allows. NaN and infinities give an unspecified sign.
//!
//! | module | what it holds | cost (insphere) |
//! |---|---|---|
//! | [`filter`] | floating-point filters with proved error bounds | some 10 ns |
//! | [`exact`] | staged exact evaluation: few bits, fixed width, any width | tens of ns and up |
//! | `long` | exact sums of products of any finite `f64`, without allocation | |
//! | [`distance`] | which of two points is nearer | some ns; exact 0.1 µs |
//! | [`dihedral`] | has a tetrahedron a dihedral angle below a bound | some ns an edge; exact µs |
//! | [`twin`] | the same predicates, from big integers alone: the reference of the tests | 10 µs |
//! | [`perturb`] | the symbolic perturbation: an in-sphere test that is never zero | |

pub mod dihedral;
pub mod distance;
pub mod exact;
pub mod filter;
pub mod long;
pub mod perturb;
pub mod twin;

#[cfg(test)]
mod tests;

use std::cmp::Ordering;
use std::ops::{Mul, Neg};

use crate::Point;

/// Sign of an exactly evaluated expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(i8)]
pub enum Sign {
    /// Below zero.
    Negative = -1,
    /// Exactly zero.
    Zero = 0,
    /// Above zero.
    Positive = 1,
}

impl Sign {
    /// The sign of `value`; that of NaN is [`Sign::Zero`].
    #[inline(always)]
    #[must_use]
    pub fn from_f64(value: f64) -> Self {
        if value > 0.0 {
            Self::Positive
        } else if value < 0.0 {
            Self::Negative
        } else {
            Self::Zero
        }
    }

    /// `Less` is negative, `Greater` positive: the sign of `a - b` for `a.cmp(&b)`.
    #[inline(always)]
    #[must_use]
    pub fn from_ordering(ordering: Ordering) -> Self {
        match ordering {
            Ordering::Less => Self::Negative,
            Ordering::Equal => Self::Zero,
            Ordering::Greater => Self::Positive,
        }
    }

    /// Above zero?
    #[inline(always)]
    #[must_use]
    pub fn is_positive(self) -> bool {
        self == Self::Positive
    }

    /// Below zero?
    #[inline(always)]
    #[must_use]
    pub fn is_negative(self) -> bool {
        self == Self::Negative
    }

    /// Exactly zero?
    #[inline(always)]
    #[must_use]
    pub fn is_zero(self) -> bool {
        self == Self::Zero
    }
}

impl Neg for Sign {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        match self {
            Self::Negative => Self::Positive,
            Self::Zero => Self::Zero,
            Self::Positive => Self::Negative,
        }
    }
}

impl Mul for Sign {
    type Output = Self;

    /// The sign of a product.
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        match self {
            Self::Negative => -other,
            Self::Zero => Self::Zero,
            Self::Positive => other,
        }
    }
}

/// The projections in which [`coplanar_orient`] looks for three points that are not collinear,
/// in CGAL's order: xy, yz, xz.
pub const PLANES: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// Sign of det(b-a, c-a, d-a): positive for the unit tetrahedron (0, x, y, z), zero exactly when
/// the four points are coplanar.
#[inline]
#[must_use]
pub fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    filter::orient3d_any(a, b, c, d).unwrap_or_else(|| exact::orient3d(a, b, c, d))
}

/// The side of the sphere through `a, b, c, d` on which `e` lies: positive inside if
/// `orient3d(a, b, c, d)` is positive, negative inside if it is negative, zero on the sphere.
#[inline]
#[must_use]
pub fn insphere(a: &Point, b: &Point, c: &Point, d: &Point, e: &Point) -> Sign {
    filter::insphere_any(a, b, c, d, e).unwrap_or_else(|| exact::insphere(a, b, c, d, e))
}

/// The first non-zero sign over the projections [`PLANES`]; zero if there is none.
fn first_projection(sign: impl Fn([usize; 2]) -> Sign) -> Sign {
    PLANES.into_iter().map(sign).find(|sign| !sign.is_zero()).unwrap_or(Sign::Zero)
}

/// Orientation of three points of one plane: the first non-zero of the orientations of their
/// projections to xy, yz and xz; zero exactly when they are collinear.
///
/// Triples of one plane that are not collinear agree in the projection that decides, so their
/// orientations can be compared (CGAL's `coplanar_orientation` with three arguments).
#[must_use]
pub fn coplanar_orient(a: &Point, b: &Point, c: &Point) -> Sign {
    first_projection(|plane| orient2d(a, b, c, plane))
}

/// Are the three points on one line (or equal)?
#[must_use]
pub fn collinear(a: &Point, b: &Point, c: &Point) -> bool {
    coplanar_orient(a, b, c).is_zero()
}

/// The side of the circle through `a, b, c` on which `d` lies, for four points of one plane:
/// positive strictly inside, zero on the circle, negative outside, whatever the orientation of
/// `a, b, c`. Zero if `a, b, c` are collinear.
///
/// If `d` is not in their plane, the answer is that of some plane quadric and has no meaning.
#[must_use]
pub fn side_of_bounded_circle(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    for plane in PLANES {
        let local = orient2d(a, b, c, plane);
        if !local.is_zero() {
            return incircle(a, b, c, d, plane) * local;
        }
    }
    Sign::Zero
}

/// Orientation of the projections of `a, b, c` to the two axes of `plane`.
pub fn orient2d(a: &Point, b: &Point, c: &Point, plane: [usize; 2]) -> Sign {
    filter::orient2d_any(a, b, c, plane).unwrap_or_else(|| exact::orient2d(a, b, c, plane))
}

/// The side of the circle through the projections of `a, b, c` on which that of `d` lies; `a, b, c`
/// are oriented positively. Positive inside.
pub fn incircle(a: &Point, b: &Point, c: &Point, d: &Point, plane: [usize; 2]) -> Sign {
    filter::incircle_any(a, b, c, d, plane).unwrap_or_else(|| exact::incircle(a, b, c, d, plane))
}

/// The order of the symbolic perturbation: by x, then y, then z. `-0.0` equals `0.0`.
///
/// It is total on finite coordinates; NaN compares as equal.
#[inline]
#[must_use]
pub fn cmp_xyz(a: &Point, b: &Point) -> Ordering {
    for axis in 0..3 {
        if a[axis] < b[axis] {
            return Ordering::Less;
        }
        if a[axis] > b[axis] {
            return Ordering::Greater;
        }
    }
    Ordering::Equal
}
