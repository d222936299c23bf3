//! Do two tetrahedra overlap? Exactly, by the planes that may come between them.
//!
//! Two convex polytopes P and Q whose interiors do not meet are separated by a plane, and one
//! such plane is parallel to a face of P or of Q, or to an edge of each: 0 is not inside P - Q,
//! hence beyond the plane of one of its faces, and the faces of P - Q are made of a face of one
//! and a vertex of the other, or of an edge of each.

use crate::mesh::{OUTWARD, Point};
use crate::predicates::{Tally, orient3d, triple};

/// The edges of a tetrahedron, each with the two other corners behind it.
const EDGES: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];

/// Whether the interiors of two positive tetrahedra meet.
pub(super) fn overlap(p: [&Point; 4], q: [&Point; 4], tally: &mut Tally) -> bool {
    let by_edges = |tally: &mut Tally| {
        EDGES.iter().any(|&e| EDGES.iter().any(|&f| edges_part(p, e, q, f, tally)))
    };
    !(a_face_parts(p, q, tally) || a_face_parts(q, p, tally) || by_edges(tally))
}

/// Whether all of `q` is beyond a face of `p`, or on its plane.
fn a_face_parts(p: [&Point; 4], q: [&Point; 4], tally: &mut Tally) -> bool {
    OUTWARD.iter().any(|face| {
        let [a, b, c] = face.map(|k| p[k]);
        q.iter().all(|v| orient3d([a, b, c, v], tally) >= 0)
    })
}

/// Whether a plane parallel to an edge of each separates `p` from `q`.
fn edges_part(
    p: [&Point; 4],
    [a, b, other, another]: [usize; 4],
    q: [&Point; 4],
    [c, d, third, fourth]: [usize; 4],
    tally: &mut Tally,
) -> bool {
    // The component along the normal of both edges.
    let mut along = |x: &Point, y: &Point| triple([[p[b], p[a]], [q[d], q[c]], [x, y]], tally);
    let (s, t) = (along(p[other], p[a]), along(p[another], p[a]));
    // The side that p is on. If both signs are zero, the edges are parallel: p is not flat.
    let own = if s == 0 { t } else { s };
    own != 0
        && s * t >= 0
        && own * along(q[c], p[a]) <= 0
        && own * along(q[third], q[c]) <= 0
        && own * along(q[fourth], q[c]) <= 0
}
