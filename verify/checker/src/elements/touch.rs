//! Vertices inside faces and edges, and edges that cross, exactly.

use crate::mesh::Point;
use crate::predicates::{Tally, orient3d};

/// The axes that are left when one is dropped.
const AXES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// The sense in which three points turn when they are projected along an axis: 1, -1, or 0 on one
/// line. It is their orientation in the plane with a point straight above the first one.
fn turn([i, j]: [usize; 2], [a, b, c]: [&Point; 3], tally: &mut Tally) -> i8 {
    let [d, e, f] = [a, b, c].map(|p| [p[i], p[j], 0.0]);
    orient3d([&d, &e, &f, &[a[i], a[j], 1.0]], tally)
}

/// The place of a point inside a triangle or one of its edges; `None` if it is elsewhere, or at a
/// corner.
///
/// Inside: `Some(None)`. Inside an edge: its number; edge `k` starts at corner `k`.
pub(super) fn inside(p: &Point, corners: [&Point; 3], tally: &mut Tally) -> Option<Option<usize>> {
    let [a, b, c] = corners;
    if corners.contains(&p) || orient3d([a, b, c, p], tally) != 0 {
        return None;
    }
    for axes in AXES {
        let whole = turn(axes, corners, tally);
        if whole == 0 {
            continue;
        }
        let sides = [[a, b, p], [b, c, p], [c, a, p]].map(|three| whole * turn(axes, three, tally));
        if sides.contains(&-1) {
            return None;
        }
        return Some(sides.iter().position(|&side| side == 0));
    }
    None
}

/// Whether two edges meet in one point that is inside both.
pub(super) fn cross([a, b]: [&Point; 2], [c, d]: [&Point; 2], tally: &mut Tally) -> bool {
    if [a, b].iter().any(|p| *p == c || *p == d) || orient3d([a, b, c, d], tally) != 0 {
        return false;
    }
    // All four are in one plane, which some projection keeps a plane.
    AXES.iter().any(|&axes| {
        let mut turn = |p, q, r| turn(axes, [p, q, r], tally);
        turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every way to hand over the corners.
    fn place(p: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> Option<bool> {
        let orders = [[a, b, c], [b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]];
        let places = orders.map(|corners| {
            let found = inside(&p, corners.each_ref(), &mut Tally::default());
            if let Some(Some(k)) = found {
                let ends = [corners[k], corners[(k + 1) % 3]];
                let on =
                    orient3d([&ends[0], &ends[1], &p, &[0.3, 9.0, -4.0]], &mut Tally::default());
                assert_eq!(on, 0, "{p:?} {corners:?}");
            }
            found.map(|edge| edge.is_some())
        });
        assert!(places.iter().all(|x| *x == places[0]), "{p:?}");
        places[0]
    }

    #[test]
    fn points_in_triangles_and_edges() {
        for k in 0..3 {
            for scale in [1.0, 5e-324, 1e-160, 1e300] {
                let at = |x: f64, y: f64, z: f64| {
                    let p = [x * scale, y * scale, z * scale];
                    [p[k], p[(k + 1) % 3], p[(k + 2) % 3]]
                };
                // In a plane that is slanted, and in one of an axis.
                for z in [0.0, 1.0] {
                    let t = [at(0.0, 0.0, 0.0), at(4.0, 0.0, 4.0 * z), at(0.0, 4.0, 8.0 * z)];
                    let on = |x: f64, y: f64| at(x, y, (x + 2.0 * y) * z);
                    assert_eq!(place(on(1.0, 1.0), t), Some(false));
                    assert_eq!(place(on(2.0, 2.0), t), Some(true));
                    assert_eq!(place(on(1.0, 0.0), t), Some(true));
                    assert_eq!(place(on(5.0, 0.0), t), None, "beyond, on the line of an edge");
                    assert_eq!(place(on(3.0, 2.0), t), None);
                    assert_eq!(place(on(4.0, 0.0), t), None, "a corner");
                    assert_eq!(place(at(1.0, 1.0, 3.0 * z + 1.0), t), None, "off the plane");
                }
            }
        }
        assert_eq!(place([1.0, 0.0, 0.0], [[0.0; 3], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]]), None);
    }

    #[test]
    fn edges_that_cross() {
        let crossing = |a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3]| {
            let both = [([&a, &b], [&c, &d]), ([&d, &c], [&a, &b]), ([&b, &a], [&d, &c])];
            let found = both.map(|(e, f)| cross(e, f, &mut Tally::default()));
            assert!(found.iter().all(|x| *x == found[0]));
            found[0]
        };
        let (o, far) = ([0.0; 3], [2.0, 2.0, 2.0]);
        assert!(crossing(o, far, [0.0, 2.0, 1.0], [2.0, 0.0, 1.0]));
        assert!(!crossing(o, far, [0.0, 2.0, 1.0], [2.0, 0.0, 1.5]), "apart");
        assert!(!crossing(o, far, [1.0, 1.0, 1.0], [2.0, 0.0, 1.0]), "an end inside: it hangs");
        assert!(!crossing(o, far, o, [2.0, 0.0, 1.0]), "a common end");
        assert!(!crossing(o, far, [1.0, 1.0, 1.0], [3.0, 3.0, 3.0]), "on one line");
        assert!(!crossing(o, far, [0.0, 2.0, 4.0], [2.0, 0.0, 4.0]), "in one plane, apart");
    }
}
