//! Differences of points and their determinants, written once for floats and integers: the filters
//! of [`crate::predicates`] and the exact stages of [`crate::exact`] evaluate the same text.

use crate::mesh::Point;
use std::ops::{Add, Mul, Sub};

/// 2^-190 and 2^200: the range of differences in which the filter holds.
const SMALLEST: f64 = f64::from_bits((1023 - 190) << 52);
const LARGEST: f64 = f64::from_bits((1023 + 200) << 52);

/// Arithmetic by reference, so that one text serves f64, i64, i128 and big integers.
pub(crate) trait Number: Sized {
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
}

impl<T> Number for T
where
    for<'a> &'a T: Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn minus(&self, other: &Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        self * other
    }
}

/// The determinant of three rows, expanded along z.
#[inline(always)]
pub(crate) fn det3<T: Number>([a, b, c]: &[[T; 3]; 3]) -> T {
    let minor = |p: &[T; 3], q: &[T; 3]| p[0].times(&q[1]).minus(&p[1].times(&q[0]));
    let (bc, ac, ab) = (minor(b, c), minor(a, c), minor(a, b));
    a[2].times(&bc).minus(&b[2].times(&ac)).plus(&c[2].times(&ab))
}

/// The in-sphere determinant of four rows (the points of the sphere, seen from the fifth):
/// det(x, y, z, x² + y² + z²), positive inside a positive tetrahedron.
#[inline(always)]
pub(crate) fn det_lifted<T: Number>([a, b, c, d]: &[[T; 3]; 4]) -> T {
    let minor = |p: &[T; 3], q: &[T; 3]| p[0].times(&q[1]).minus(&q[0].times(&p[1]));
    let lift = |p: &[T; 3]| p[0].times(&p[0]).plus(&p[1].times(&p[1])).plus(&p[2].times(&p[2]));
    let (ab, bc, cd, da) = (minor(a, b), minor(b, c), minor(c, d), minor(d, a));
    let (ac, bd) = (minor(a, c), minor(b, d));
    let abc = a[2].times(&bc).minus(&b[2].times(&ac)).plus(&c[2].times(&ab));
    let bcd = b[2].times(&cd).minus(&c[2].times(&bd)).plus(&d[2].times(&bc));
    let cda = c[2].times(&da).plus(&d[2].times(&ac)).plus(&a[2].times(&cd));
    let dab = d[2].times(&ab).plus(&a[2].times(&bd)).plus(&b[2].times(&da));
    let first = lift(c).times(&dab).minus(&lift(d).times(&abc));
    first.plus(&lift(a).times(&bcd).minus(&lift(b).times(&cda)))
}

/// The difference of two points, first less second, as computed.
#[inline(always)]
pub(crate) fn difference([p, q]: [&Point; 2]) -> [f64; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

/// Differences of `N` points to `origin`, as computed.
#[inline(always)]
pub(crate) fn differences<const N: usize>(points: [&Point; N], origin: &Point) -> [[f64; 3]; N] {
    points.map(|p| difference([p, origin]))
}

/// The largest absolute difference on each axis.
#[inline(always)]
pub(crate) fn extents<const N: usize>(rows: &[[f64; 3]; N]) -> [f64; 3] {
    let mut m = [0.0f64; 3];
    for row in rows {
        for (m, d) in m.iter_mut().zip(row) {
            *m = m.max(d.abs());
        }
    }
    m
}

/// Whether the filter's error bound holds for differences of this size. NaN cannot occur: the
/// coordinates are finite, so a difference is at worst infinite, and then this is false.
#[inline(always)]
pub(crate) fn in_range(m: [f64; 3]) -> bool {
    m.iter().all(|&m| SMALLEST < m && m < LARGEST)
}
