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

/// Does a point come before another by x, y, z?
fn is_before(p: &Point, q: &Point) -> bool {
    // No branch depends on it.
    (p[0] < q[0]) | (p[0] == q[0]) & ((p[1] < q[1]) | (p[1] == q[1]) & (p[2] < q[2]))
}

/// Points by x, y, z. There are few: each counts those before it, without a branch.
#[inline(always)]
pub fn sorted<const N: usize>(points: [Point; N]) -> [Point; N] {
    let mut places = [0; N];
    for j in 0..N {
        for i in 0..j {
            let first = is_before(&points[j], &points[i]);
            places[i] += usize::from(first);
            places[j] += usize::from(!first);
        }
    }
    let mut sorted = points;
    for (place, point) in places.into_iter().zip(points) {
        sorted[place] = point;
    }
    sorted
}
