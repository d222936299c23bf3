//! The contact of two pieces of a complex, exactly.
//!
//! Pieces are triangles, edges and vertices, by the numbers of their vertices; equal coordinates
//! have one number. Two pieces may meet in the vertices and edges that both name, and nowhere
//! else: everything more is a [`Contact`]. Signs come from the exact predicates alone.

use ltbw_exact::Point;
use ltbw_exact::predicates::{PLANES, Sign, collinear, orient2d, orient3d};

/// The kind of contact of two pieces that must not touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Contact {
    /// They cross.
    Crossing,
    /// They have an area in common.
    Overlap,
    /// A vertex of one lies on the other.
    Touch(u32),
}

/// The points by which contacts are decided.
#[derive(Clone, Copy)]
pub(super) struct Contacts<'a> {
    pub(super) points: &'a [Point],
}

type Triangle = [u32; 3];
type Edge = [u32; 2];

impl<'a> Contacts<'a> {
    fn at(self, v: u32) -> &'a Point {
        &self.points[v as usize]
    }

    /// On which side of a triangle a vertex lies; its own corners are in its plane.
    fn side(self, t: Triangle, v: u32) -> Sign {
        if t.contains(&v) {
            return Sign::Zero;
        }
        orient3d(self.at(t[0]), self.at(t[1]), self.at(t[2]), self.at(v))
    }

    fn turn(self, [a, b]: Edge, c: u32, axes: [usize; 2]) -> Sign {
        orient2d(self.at(a), self.at(b), self.at(c), axes)
    }

    /// Axes to which the triangle projects to a triangle, and how that turns. Triangles of a
    /// complex have an area, so there are such axes.
    fn axes(self, [a, b, c]: Triangle) -> ([usize; 2], Sign) {
        let turns = PLANES.into_iter().map(|axes| (axes, self.turn([a, b], c, axes)));
        turns.into_iter().find(|(_, turn)| !turn.is_zero()).unwrap_or((PLANES[0], Sign::Zero))
    }

    /// Is a vertex of the triangle's plane in the triangle or on its border?
    fn inside(self, t: Triangle, v: u32) -> bool {
        self.inside_in_plane(t, self.at(v))
    }

    fn inside_in_plane(self, t: Triangle, p: &Point) -> bool {
        let (axes, turn) = self.axes(t);
        sides_of(t)
            .iter()
            .all(|&[a, b]| orient2d(self.at(a), self.at(b), p, axes) * turn != Sign::Negative)
    }

    /// Is a vertex on the line segment, ends included?
    fn on_edge(self, [a, b]: Edge, v: u32) -> bool {
        let (a, b, v) = (self.at(a), self.at(b), self.at(v));
        let within = (0..3).all(|k| a[k].min(b[k]) <= v[k] && v[k] <= a[k].max(b[k]));
        within && collinear(a, b, v)
    }

    /// Two triangles.
    pub(super) fn triangles(self, p: Triangle, q: Triangle) -> Option<Contact> {
        let shared = p.iter().filter(|v| q.contains(v)).count();
        match shared {
            3 => Some(Contact::Overlap),
            2 => self.wings(p, q),
            _ => {
                let below = p.map(|v| self.side(q, v));
                if apart(p, q, below) {
                    return None;
                }
                let above = q.map(|v| self.side(p, v));
                if apart(q, p, above) {
                    return None;
                }
                if below.iter().all(|s| s.is_zero()) {
                    return self.coplanar(p, q);
                }
                // The common part is a segment (or a point); each of its ends is on an edge of one
                // of the two that does not start at a shared vertex, which is an end already.
                let over = |t: Triangle, sides: [Sign; 3], other: Triangle| {
                    (0..3).find_map(|k| {
                        let (e, s) = ([t[k], t[(k + 1) % 3]], [sides[k], sides[(k + 1) % 3]]);
                        if e.iter().any(|v| other.contains(v)) {
                            return None;
                        }
                        self.edge_and_triangle(e, s, other)
                    })
                };
                over(p, below, q).or_else(|| over(q, above, p))
            }
        }
    }

    /// Two triangles of a common edge: they overlap if one lies folded on the other.
    fn wings(self, p: Triangle, q: Triangle) -> Option<Contact> {
        let c = p.into_iter().find(|v| !q.contains(v))?;
        let d = q.into_iter().find(|v| !p.contains(v))?;
        if !self.side(p, d).is_zero() {
            return None;
        }
        let edge = sides_of(p).into_iter().find(|e| !e.contains(&c))?;
        let (axes, _) = self.axes(p);
        (self.turn(edge, c, axes) == self.turn(edge, d, axes)).then_some(Contact::Overlap)
    }

    /// Two triangles of one plane with at most one common vertex.
    fn coplanar(self, p: Triangle, q: Triangle) -> Option<Contact> {
        // Convex sets have disjoint interiors if and only if a line along an edge separates them.
        let separates = |t: Triangle, other: Triangle| {
            let (axes, turn) = self.axes(t);
            let beyond = |e: Edge, v: u32| self.turn(e, v, axes) * turn != Sign::Positive;
            sides_of(t).into_iter().any(|e| other.iter().all(|&v| beyond(e, v)))
        };
        if !separates(p, q) && !separates(q, p) {
            return Some(Contact::Overlap);
        }
        let on = |t: Triangle, other: Triangle| {
            other.into_iter().find(|v| !t.contains(v) && self.inside(t, *v)).map(Contact::Touch)
        };
        on(p, q).or_else(|| on(q, p))
    }

    /// An edge and a triangle without common vertices; `sides` are those of the edge's ends.
    fn edge_and_triangle(self, e: Edge, sides: [Sign; 2], t: Triangle) -> Option<Contact> {
        match sides {
            [Sign::Zero, Sign::Zero] => self.edge_in_plane(e, t),
            [Sign::Zero, _] => self.inside(t, e[0]).then_some(Contact::Touch(e[0])),
            [_, Sign::Zero] => self.inside(t, e[1]).then_some(Contact::Touch(e[1])),
            [a, b] if a == b => None,
            _ => {
                let past =
                    |[b, c]: Edge| orient3d(self.at(e[0]), self.at(e[1]), self.at(b), self.at(c));
                let past = sides_of(t).map(past);
                let has = |sign| past.contains(&sign);
                if has(Sign::Positive) && has(Sign::Negative) {
                    return None;
                }
                // Through two sides at once: through the corner between them.
                let corner = (0..3).find(|&k| past[k].is_zero() && past[(k + 2) % 3].is_zero());
                Some(corner.map_or(Contact::Crossing, |k| Contact::Touch(t[k])))
            }
        }
    }

    /// An edge in the plane of a triangle; they may have vertices in common.
    fn edge_in_plane(self, e: Edge, t: Triangle) -> Option<Contact> {
        if let Some(v) = e.into_iter().find(|v| !t.contains(v) && self.inside(t, *v)) {
            return Some(Contact::Touch(v));
        }
        if let Some(v) = t.into_iter().find(|v| !e.contains(v) && self.on_edge(e, *v)) {
            return Some(Contact::Touch(v));
        }
        let (axes, _) = self.axes(t);
        sides_of(t).into_iter().find_map(|side| self.cross_in_plane(e, side, axes))
    }

    /// Do two edges of one plane cross inside both?
    fn cross_in_plane(self, e: Edge, f: Edge, axes: [usize; 2]) -> Option<Contact> {
        let splits = |e: Edge, f: Edge| {
            self.turn(e, f[0], axes) * self.turn(e, f[1], axes) == Sign::Negative
        };
        (splits(e, f) && splits(f, e)).then_some(Contact::Crossing)
    }

    /// A free-standing edge and a triangle.
    pub(super) fn edge_on_triangle(self, e: Edge, t: Triangle) -> Option<Contact> {
        let sides = e.map(|v| self.side(t, v));
        match e.iter().filter(|v| t.contains(v)).count() {
            0 => self.edge_and_triangle(e, sides, t),
            1 if sides.iter().all(|s| s.is_zero()) => self.edge_in_plane(e, t),
            _ => None,
        }
    }

    /// Two free-standing edges.
    pub(super) fn edges(self, e: Edge, f: Edge) -> Option<Contact> {
        if e.iter().all(|v| f.contains(v)) {
            return Some(Contact::Overlap);
        }
        for (one, other) in [(e, f), (f, e)] {
            let on = |v: &u32| !one.contains(v) && self.on_edge(one, *v);
            if let Some(v) = other.into_iter().find(on) {
                return Some(Contact::Touch(v));
            }
        }
        if e.iter().any(|v| f.contains(v)) || !self.side([e[0], e[1], f[0]], f[1]).is_zero() {
            return None;
        }
        let axes = PLANES.into_iter().find(|&axes| !self.turn(e, f[0], axes).is_zero())?;
        self.cross_in_plane(e, f, axes)
    }

    /// Is a point that is no vertex on a triangle?
    pub(super) fn point_on_triangle(self, p: &Point, t: Triangle) -> bool {
        let [a, b, c] = t.map(|v| self.at(v));
        orient3d(a, b, c, p).is_zero() && self.inside_in_plane(t, p)
    }
}

/// The edges of a triangle, each followed by the one at its end.
pub(super) fn sides_of([a, b, c]: Triangle) -> [Edge; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The side that two triangles have in common.
pub(super) fn shared_side(t: Triangle, u: Triangle) -> Option<Edge> {
    sides_of(t).into_iter().find(|side| side.iter().all(|v| u.contains(v)))
}

/// Are the corners of `t` that `other` does not have all strictly on one side of it?
fn apart(t: Triangle, other: Triangle, sides: [Sign; 3]) -> bool {
    [Sign::Positive, Sign::Negative]
        .into_iter()
        .any(|side| (0..3).all(|k| other.contains(&t[k]) || sides[k] == side))
}
