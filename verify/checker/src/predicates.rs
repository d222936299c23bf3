//! Exact predicates: a forward-error filter, then exact arithmetic ([`crate::exact`]).
//!
//! Signs: `orient3d(a, b, c, d)` is the sign of det(b-a, c-a, d-a), positive for the unit
//! tetrahedron (origin, x, y, z). `insphere(a, b, c, d, e)` is positive when `e` lies inside the
//! sphere through the positive tetrahedron `a b c d`.
//!
//! **The filter.** Let mx, my, mz be the largest absolute computed differences on each axis,
//! m the largest of them, u = 2^-53, and γ(k) = ku/(1-ku) (Higham, *Accuracy and Stability of
//! Numerical Algorithms*, §3.1). Expanded, orient3d is a sum of 6 products of three
//! differences; each picks up 3 roundings from differences, 2 from products, 1 from the 2 × 2
//! minor and 2 from the last sums: |error| ≤ 6γ(8) mx my mz < 49u mx my mz. Insphere is a sum of
//! 24 products of three differences with a lift of at most 3m². In [`Sphere`]'s form those of
//! s · n pick up 5 roundings in the lift, 3 in the other differences, 1 + 1 in the 2 × 2 minor,
//! 1 + 2 in n, 1 + 2 in the dot product and 1 in the last difference, the others fewer:
//! |error| ≤ 72γ(17) mx my mz m² < 1226u mx my mz m². The bounds used, 64u and 2048u, leave
//! room for the roundings of the bound itself and for underflow: with mx, my, mz in
//! (2^-190, 2^200) an underflow costs at most 2^-1074 times the remaining factors, below
//! 2^-300 of the bound; and nothing overflows. Outside this range the exact stage decides.

use crate::determinant::{det3, difference, differences, extents, in_range};
use crate::exact;
use crate::mesh::Point;

/// The numbers of tests that a filter decided, and that exact arithmetic did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Tally {
    pub(crate) filter: u64,
    pub(crate) exact: u64,
}

impl Tally {
    pub(crate) fn merge(&mut self, other: Self) {
        self.filter += other.filter;
        self.exact += other.exact;
    }
}

const ORIENT_BOUND: f64 = 64.0 / (1u64 << 53) as f64;
const INSPHERE_BOUND: f64 = 2048.0 / (1u64 << 53) as f64;

/// The sign of `det` if it exceeds `bound` in absolute value.
#[inline(always)]
pub(crate) fn sign_beyond(det: f64, bound: f64) -> Option<i8> {
    if det > bound {
        Some(1)
    } else if det < -bound {
        Some(-1)
    } else {
        None
    }
}

/// The sign of a determinant of three differences, computed as `det`: by the filter, with their
/// largest absolute coordinates `m`, or `exact`.
#[inline(always)]
fn sign3(det: f64, m: [f64; 3], tally: &mut Tally, exact: impl FnOnce() -> i8) -> i8 {
    if in_range(m)
        && let Some(sign) = sign_beyond(det, ORIENT_BOUND * m[0] * m[1] * m[2])
    {
        tally.filter += 1;
        return sign;
    }
    tally.exact += 1;
    exact()
}

/// Exact sign of det(b-a, c-a, d-a). The coordinates must be finite.
#[inline]
pub(crate) fn orient3d([a, b, c, d]: [&Point; 4], tally: &mut Tally) -> i8 {
    let rows = differences([b, c, d], a);
    sign3(det3(&rows), extents(&rows), tally, || exact::orient3d([a, b, c, d]))
}

/// Exact sign of the determinant of three vectors, each the difference of two points, first less
/// second. The coordinates must be finite. [`orient3d`] is the case of one common second point, and
/// its bound holds: the same operations on differences of the same error.
#[inline]
pub(crate) fn triple(vectors: [[&Point; 2]; 3], tally: &mut Tally) -> i8 {
    let rows = vectors.map(difference);
    sign3(det3(&rows), extents(&rows), tally, || exact::triple(vectors))
}

/// The sphere through four points, made once for any number of tests.
///
/// With p, q, r, s the differences of b, c, d, e to a, and w of a row its squared length,
/// the in-sphere determinant is s · n - w(s) det(p, q, r), where
/// n = w(p) q × r + w(q) r × p + w(r) p × q.
pub(crate) struct Sphere<'a> {
    corners: [&'a Point; 4],
    normal: [f64; 3],
    det: f64,
    /// The largest absolute differences of the corners to the first, on each axis.
    extents: [f64; 3],
}

impl<'a> Sphere<'a> {
    /// The sphere through `corners`, whose coordinates must be finite.
    #[inline]
    pub(crate) fn new(corners: [&'a Point; 4]) -> Self {
        let [a, b, c, d] = corners;
        let rows = differences([b, c, d], a);
        let [p, q, r] = rows;
        let minor = |p: [f64; 3], q: [f64; 3], x: usize, y: usize| p[x] * q[y] - p[y] * q[x];
        let cross = |p, q| [minor(p, q, 1, 2), minor(p, q, 2, 0), minor(p, q, 0, 1)];
        let (qr, rp, pq) = (cross(q, r), cross(r, p), cross(p, q));
        let (wp, wq, wr) = (square(p), square(q), square(r));
        let normal = [0, 1, 2].map(|k| wp * qr[k] + wq * rp[k] + wr * pq[k]);
        let det = p[2] * qr[2] + q[2] * rp[2] + r[2] * pq[2];
        Self { corners, normal, det, extents: extents(&rows) }
    }

    /// Six times the absolute volume of the tetrahedron, rounded.
    #[inline]
    pub(crate) fn volume6(&self) -> f64 {
        self.det.abs()
    }

    /// The exact sign of the tetrahedron: [`orient3d`] of the corners.
    #[inline]
    pub(crate) fn orientation(&self, tally: &mut Tally) -> i8 {
        sign3(self.det, self.extents, tally, || exact::orient3d(self.corners))
    }

    /// The exact in-sphere sign: positive when `e`, whose coordinates must be finite, lies
    /// inside the sphere and the tetrahedron is positive.
    #[inline]
    pub(crate) fn side(&self, e: &Point, tally: &mut Tally) -> i8 {
        let [a, b, c, d] = self.corners;
        let [s] = differences([e], a);
        let m = [0, 1, 2].map(|k| self.extents[k].max(s[k].abs()));
        if in_range(m) {
            let largest = m[0].max(m[1]).max(m[2]);
            let bound = INSPHERE_BOUND * m[0] * m[1] * m[2] * (largest * largest);
            let n = self.normal;
            let det = (s[0] * n[0] + s[1] * n[1] + s[2] * n[2]) - square(s) * self.det;
            if let Some(sign) = sign_beyond(det, bound) {
                tally.filter += 1;
                return sign;
            }
        }
        tally.exact += 1;
        exact::insphere([a, b, c, d, e])
    }
}

#[inline(always)]
fn square(p: [f64; 3]) -> f64 {
    p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
}

/// Exact in-sphere sign; positive when `e` lies inside the sphere of the positive tetrahedron
/// `a b c d`. The coordinates must be finite.
#[inline]
pub(crate) fn insphere([a, b, c, d, e]: [&Point; 5], tally: &mut Tally) -> i8 {
    Sphere::new([a, b, c, d]).side(e, tally)
}
