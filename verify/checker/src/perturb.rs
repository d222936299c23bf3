//! Ties: the symbolic perturbation that makes the Delaunay triangulation one function of the
//! point set (Devillers and Teillaud, *Perturbations for Delaunay and weighted Delaunay 3D
//! triangulations*, Comput. Geom. 44:160–168, 2011).
//!
//! The lifted coordinate of the point of rank r in the order by (x, y, z) is raised by ε^r, the
//! largest point most. The perturbed in-sphere determinant is then a polynomial in ε whose
//! coefficients are orientations, and its first coefficient that is not zero decides. Orientation
//! itself is never perturbed.

use crate::mesh::Point;
use crate::predicates::{Tally, orient3d};
use std::cmp::Ordering;

/// The order of the points by (x, y, z). Coordinates are finite; `-0.0` equals `0.0`.
pub(crate) fn order(p: &Point, q: &Point) -> Ordering {
    p.partial_cmp(q).unwrap_or(Ordering::Equal)
}

/// Whether `p` is inside (positive) or outside (negative) the perturbed sphere of the positive
/// tetrahedron `t`, when it lies exactly on the sphere.
pub(crate) fn side(t: [&Point; 4], p: &Point, tally: &mut Tally) -> i8 {
    let mut descending = [0, 1, 2, 3, 4];
    let at = |i: usize| if i == 4 { p } else { t[i] };
    descending.sort_by(|&i, &j| order(at(j), at(i)));
    for i in descending {
        if i == 4 {
            return -1;
        }
        let mut replaced = t;
        replaced[i] = p;
        let sign = orient3d(replaced, tally);
        if sign != 0 {
            return sign;
        }
    }
    -1 // not reached: p itself is one of the five
}

/// Whether `p` is inside (positive) or outside (negative) the perturbed circle of `a b c`, when
/// the four points lie on one circle and `a b c` is not collinear.
///
/// `off` is any point off their plane: the orientation of three points in the plane is, up to one
/// common sign that the rule cancels, their `orient3d` with `off`.
pub(crate) fn side_in_plane(t: [&Point; 3], p: &Point, off: &Point, tally: &mut Tally) -> i8 {
    let [a, b, c] = t;
    let local = orient3d([a, b, c, off], tally);
    let mut descending = [0, 1, 2, 3];
    let at = |i: usize| if i == 3 { p } else { t[i] };
    descending.sort_by(|&i, &j| order(at(j), at(i)));
    for i in descending {
        if i == 3 {
            return -1;
        }
        let mut replaced = t;
        replaced[i] = p;
        let [a, b, c] = replaced;
        let sign = orient3d([a, b, c, off], tally) * local;
        // Four distinct points on a circle: no three are collinear, so the first round decides.
        if sign != 0 {
            return sign;
        }
    }
    -1 // not reached: p itself is one of the four
}
