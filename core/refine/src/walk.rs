//! Ways through the mesh and through a facet: from what has to be split to the point proposed for
//! it.
//!
//! The circumcentre of a tetrahedron may lie far beyond the boundary. All tetrahedra on a way to it
//! that crosses only faces with the centre strictly beyond them are in its cavity, for the power of
//! the point with respect to the circumspheres falls from one to the next. So the first subface on
//! the way is found at the cost of the way, and the cavity, which may be far larger, is not opened.

use super::item::Item;
use super::key::{order_key, sorted};
use super::marks::face_bit;
use super::state::{State, Touched};
use super::table::{sides, triangle};
use ltbw_core::topology::{TetId, VertexId, slot_of, tet_of};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, coplanar_orient, orient3d};

/// The face opposite each slot, its vertices in such an order that a point beyond it makes a
/// negatively oriented tetrahedron with them.
const FACES: [[usize; 3]; 4] = [[2, 1, 3], [3, 0, 2], [1, 0, 3], [0, 1, 2]];

/// Where the way to a point ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// In the tetrahedron that holds the point.
    Arrived(TetId),
    /// At this subface, the first that it crosses.
    Blocked([VertexId; 3]),
    /// Outside the hull.
    Outside,
}

impl State {
    /// Walks from the middle of tetrahedron `start` straight to `p`, up to the first subface.
    pub(crate) fn way(&self, start: TetId, p: &Point) -> Way {
        let topology = self.mesh.topology();
        let from = middle(self.vertices(start).map(|v| self.at(v)));
        let (mut t, mut entry) = (start, 4);
        // In a Delaunay mesh such a walk visits no tetrahedron twice; the bound only guards it.
        for _ in 0..=topology.slots() {
            let tet = topology.at(t);
            if tet.is_ghost() {
                return Way::Outside;
            }
            let v = tet.vertices();
            let corners = v.map(|v| self.at(v));
            let Some(slot) = exit(&corners, entry, &from, p) else { return Way::Arrived(t) };
            if self.marks.of(t) & face_bit(slot) != 0 {
                let [a, b, c] = FACES[slot].map(|k| v[k]);
                return Way::Blocked(triangle(a, b, c));
            }
            let next = tet.neighbours()[slot];
            (t, entry) = (tet_of(next), slot_of(next));
        }
        Way::Outside
    }

    /// A tetrahedron, or ghost, that holds `p`: where a walk from `start` ends that nothing bars.
    pub(crate) fn holder(&self, start: TetId, p: &Point) -> Option<TetId> {
        let topology = self.mesh.topology();
        let (mut t, mut entry) = (start, 4);
        if topology.at(t).is_ghost() {
            t = tet_of(topology.at(t).neighbours()[3]);
        }
        // In a Delaunay mesh such a walk visits no tetrahedron twice; the bound only guards it.
        for _ in 0..=topology.slots() {
            let tet = topology.at(t);
            let v = tet.vertices();
            let is_beyond = |slot: &usize| {
                let [a, b, c] = FACES[*slot].map(|k| self.at(v[k]));
                *slot != entry && orient3d(&a, &b, &c, p) == Sign::Negative
            };
            let Some(slot) = (0..4).filter(|_| !tet.is_ghost()).find(is_beyond) else {
                return Some(t);
            };
            let next = tet.neighbours()[slot];
            (t, entry) = (tet_of(next), slot_of(next));
        }
        None
    }

    /// The subsegment of facet `f` between its subface `s` and a point `p` of its plane, in whose
    /// cavity the boundary is `touched`, that `s` does not see.
    pub(crate) fn segment_between(
        &self,
        touched: &Touched,
        s: [VertexId; 3],
        f: u32,
        p: &Point,
    ) -> Option<[VertexId; 2]> {
        if self.at_edge.is_some() {
            return self.segment_on_way(s, f, p);
        }
        // A missing subface is in no cavity, but its own sides may be what is between.
        let beyond = |&(side, opposite): &([VertexId; 2], VertexId)| {
            let [a, b] = side.map(|v| self.at(v));
            let inner = self.turn_on(f, &a, &b, &self.at(opposite));
            self.segments.contains_key(&side) && self.turn_on(f, &a, &b, p) != inner
        };
        let own = sides(s).into_iter().filter(beyond).map(|(side, _)| side);
        if let Some(side) = own.min_by_key(|&side| self.place_of(Item::Segment(side))) {
            return Some(side);
        }
        // The cavity is star-shaped from `p` and has the subface: what is between them is in it.
        let side =
            |a: VertexId, b: &Point, c: VertexId| self.turn_on(f, &self.at(a), b, &self.at(c));
        let separates = |[x, y]: [VertexId; 2]| {
            let (b, mine) = (self.at(y), self.turn_on(f, &self.at(x), &self.at(y), p));
            let theirs = s.map(|v| side(x, &b, v));
            let between = !mine.is_zero() && theirs.contains(&-mine) && !theirs.contains(&mine);
            let crosses = s.iter().any(|&v| {
                let [left, right] = [x, y].map(|end| side(v, p, end));
                !left.is_zero() && left == -right
            });
            between && crosses
        };
        let on_facet = |e: &[VertexId; 2]| {
            let segment = self.segments.get(e).map(|&of| &self.plc.segments[of as usize]);
            segment.is_some_and(|segment| segment.facets.contains(&f))
        };
        let between = touched.edges().filter(|e| on_facet(e) && separates(*e));
        between.min_by_key(|&e| self.place_of(Item::Segment(e)))
    }

    /// The first subsegment on a way from subface `s` of facet `f` to `p` in its plane, through the
    /// facet's triangulation, whether the mesh has its triangles or not.
    fn segment_on_way(&self, s: [VertexId; 3], f: u32, p: &Point) -> Option<[VertexId; 2]> {
        let at_edge = self.at_edge.as_ref()?;
        let (mut t, mut entry) = (s, None);
        // Every triangle is passed once in a Delaunay triangulation; the bound only guards it.
        for _ in 0..=self.subfaces.len() {
            let beyond = |&(side, opposite): &([VertexId; 2], VertexId)| {
                let [a, b] = side.map(|v| self.at(v));
                let inner = coplanar_orient(&a, &b, &self.at(opposite));
                Some(side) != entry && coplanar_orient(&a, &b, p) == -inner
            };
            let (side, _) = sides(t).into_iter().find(beyond)?;
            if self.segments.contains_key(&side) {
                return Some(side);
            }
            let others = at_edge.get(&side)?;
            t = *others.iter().find(|o| **o != t && self.subfaces.get(*o) == Some(&f))?;
            entry = Some(side);
        }
        None
    }
}

/// The middle of a tetrahedron, where a way begins: a whole number of fine steps, so that the
/// predicates stay in their window.
pub(crate) fn middle(corners: [Point; 4]) -> Point {
    let corners = sorted(corners);
    [0, 1, 2].map(|k| corners.iter().map(|c| c[k] * 0.25).sum::<f64>().round())
}

/// The face through which the straight way from `from` to `p` leaves a tetrahedron that it has
/// entered through face `entry`, by the slot opposite; `None` if the tetrahedron holds `p`.
pub(crate) fn exit(corners: &[Point; 4], entry: usize, from: &Point, p: &Point) -> Option<usize> {
    let at = |slot: usize| FACES[slot].map(|k| corners[k]);
    let (mut exit, mut several) = (None, false);
    for slot in (0..4).filter(|&slot| slot != entry) {
        let [a, b, c] = at(slot);
        if orient3d(&a, &b, &c, p) == Sign::Negative {
            several |= exit.is_some();
            exit = exit.or(Some(slot));
        }
    }
    if several {
        let beyond = |slot: &usize| {
            let [a, b, c] = at(*slot);
            *slot != entry && orient3d(&a, &b, &c, p) == Sign::Negative
        };
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
