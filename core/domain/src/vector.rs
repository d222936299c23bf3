//! Vectors of doubles, rounded: they steer, and never decide where exactness is asked for.

use ltbw_exact::Point;

/// The difference `a - b`.
#[inline(always)]
pub fn minus<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    // An array made by a closure costs twice as much.
    let mut difference = *a;
    difference.iter_mut().zip(b).for_each(|(a, b)| *a -= b);
    difference
}

/// The axis of the largest entry.
pub fn dominant(n: &Point) -> usize {
    let larger = |a: usize, b: usize| if n[b].abs() > n[a].abs() { b } else { a };
    larger(larger(0, 1), 2)
}

/// The scalar product.
#[inline]
pub fn dot(a: &Point, b: &Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
#[inline]
pub fn cross(a: &Point, b: &Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The squared distance.
#[inline]
pub fn distance2(a: &Point, b: &Point) -> f64 {
    let d = minus(a, b);
    dot(&d, &d)
}
