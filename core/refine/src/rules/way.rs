//! The straight way through a mesh from what is to be split to the point proposed for it.
//!
//! The circumcentre of a tetrahedron may lie far beyond the boundary. All tetrahedra on a way to it
//! that crosses only faces with the centre strictly beyond them are in its cavity, for the power of
//! the point with respect to the circumspheres falls from one to the next. So the first subface on
//! the way is found at the cost of the way, and the cavity, which may be far larger, is not opened.

use crate::mesh::key::{order_key, sorted};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, orient3d};

/// The face opposite each slot, its vertices in such an order that a point beyond it makes a
/// negatively oriented tetrahedron with them.
pub(crate) const FACES: [[usize; 3]; 4] = [[2, 1, 3], [3, 0, 2], [1, 0, 3], [0, 1, 2]];

/// The mesh, or the part of it, that ways lead through.
#[doc(hidden)]
pub trait View {
    /// A boundary item that bars a way.
    type Item;
    /// A tetrahedron of somebody else's; a whole mesh has none.
    type Far;

    /// Steps that no way is longer than.
    fn most_steps(&self) -> usize;

    /// The vertices of a tetrahedron; the one at infinity is the last one of a ghost's.
    fn vertices(&self, t: TetId) -> [VertexId; 4];

    /// The coordinates of a vertex.
    fn point(&self, v: VertexId) -> Point;

    /// The subface opposite a slot of a tetrahedron with these vertices, if there is one.
    fn barrier(&self, t: TetId, v: [VertexId; 4], slot: usize) -> Option<Self::Item>;

    /// The tetrahedron beyond the face opposite a slot.
    fn across(&self, t: TetId, slot: usize) -> Across<Self::Far>;
}

/// The tetrahedron beyond a face.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Across<F> {
    /// It is here.
    Here(Stop),
    /// It is somebody else's.
    Far(F),
}

/// A tetrahedron on a way.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// It.
    pub t: TetId,
    /// The slot of the face that the way came in by; none where the way begins.
    pub entry: Option<usize>,
}

/// Where a way leads.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading {
    /// Its beginning.
    pub from: Point,
    /// The point proposed.
    pub to: Point,
    /// May that be inserted? If not, what is on the way there is all that counts.
    pub may: bool,
}

/// Where a way ends.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way<I, F> {
    /// In the tetrahedron that holds the point.
    Arrived(TetId),
    /// At this item, the first that it crosses.
    Blocked(I),
    /// Outside the hull, or where no point may be inserted.
    Outside,
    /// It goes on elsewhere.
    Far(F),
}

/// The end of a walk, and its steps.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walked<I, F> {
    /// Its end.
    pub end: Way<I, F>,
    /// The number of steps made.
    pub steps: usize,
}

/// Walks straight on from a tetrahedron, up to the first subface.
#[doc(hidden)]
pub fn walk<V: View>(view: &V, start: Stop, way: &Heading) -> Walked<V::Item, V::Far> {
    let Stop { mut t, mut entry } = start;
    // In a Delaunay mesh such a walk visits no tetrahedron twice; the bound only guards it.
    for steps in 0..=view.most_steps() {
        let v = view.vertices(t);
        if v[3] == INFINITE {
            return Walked { end: Way::Outside, steps };
        }
        let corners = v.map(|v| view.point(v));
        let Some(slot) = exit(&corners, entry, &way.from, &way.to) else {
            let end = if way.may { Way::Arrived(t) } else { Way::Outside };
            return Walked { end, steps };
        };
        if let Some(item) = view.barrier(t, v, slot) {
            return Walked { end: Way::Blocked(item), steps };
        }
        match view.across(t, slot) {
            Across::Here(next) => Stop { t, entry } = next,
            Across::Far(far) => return Walked { end: Way::Far(far), steps },
        }
    }
    Walked { end: Way::Outside, steps: view.most_steps() }
}

/// The middle of a tetrahedron, where a way begins: a whole number of fine steps, so that the
/// predicates stay in their window.
#[doc(hidden)]
pub fn middle(corners: [Point; 4]) -> Point {
    let corners = sorted(corners);
    [0, 1, 2].map(|k| corners.iter().map(|c| c[k] * 0.25).sum::<f64>().round())
}

/// The face through which the straight way from `from` to `p` leaves a tetrahedron that it has
/// entered through face `entry`, by the slot opposite; `None` if the tetrahedron holds `p`.
fn exit(corners: &[Point; 4], entry: Option<usize>, from: &Point, p: &Point) -> Option<usize> {
    let at = |slot: usize| FACES[slot].map(|k| corners[k]);
    let is_beyond = |slot: usize| {
        let [a, b, c] = at(slot);
        orient3d(&a, &b, &c, p) == Sign::Negative
    };
    let (mut exit, mut several) = (None, false);
    for slot in (0..4).filter(|&slot| Some(slot) != entry) {
        if is_beyond(slot) {
            several |= exit.is_some();
            exit = exit.or(Some(slot));
        }
    }
    if several {
        let beyond = |slot: &usize| Some(*slot) != entry && is_beyond(*slot);
        let straight = (0..4).filter(beyond).filter(|&k| crosses(from, p, &at(k)));
        // Through an edge or a vertex, and where the rounded start is outside a flat tetrahedron,
        // the way goes as the coordinates say, not the slots.
        let place = |k: &usize| order_key(&corners[*k]);
        exit = straight.min_by_key(place).or_else(|| (0..4).filter(beyond).min_by_key(place));
    }
    exit
}

/// Does the line from `a` to `b`, which lie on different sides of a triangle's plane, meet it?
fn crosses(a: &Point, b: &Point, [x, y, z]: &[Point; 3]) -> bool {
    let signs = [(x, y), (y, z), (z, x)].map(|(x, y)| orient3d(a, b, x, y));
    !(signs.contains(&Sign::Positive) && signs.contains(&Sign::Negative))
}
