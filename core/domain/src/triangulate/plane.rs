//! A triangulation of points in the plane, with edges forced into it.
//!
//! Points are inserted from left to right: each sees a part of the hull, gets triangles with it,
//! and edges are flipped until they are locally Delaunay (Lawson). An edge is forced by flipping
//! those that cross it (Sloan). Predicates are exact, so that every step means what it says.
//!
//! ```text
//!        c                triangle t has corners [a, b, c], counterclockwise;
//!       / \               its neighbour at place i is the one across from corner i,
//!      /   \              NONE where there is none
//!     a-----b
//! ```

#[cfg(test)]
mod tests;

use super::{Problem, sorted};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, incircle, orient2d};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::cell::Cell;
use std::collections::{HashSet, VecDeque};

/// No triangle.
const NONE: u32 = u32::MAX;

/// The place of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// In the piece of this triangle.
    Inside(u32),
    /// Beyond what the edges enclose.
    Outside,
    /// On a forced edge.
    OnEdge,
}

/// A triangulation of projected points.
pub(super) struct Plane {
    points: Vec<Point>,
    axes: [usize; 2],
    corners: Vec<[u32; 3]>,
    neighbours: Vec<[u32; 3]>,
    /// A triangle at each vertex.
    at_vertex: Vec<u32>,
    /// Forced edges, the smaller vertex first.
    forced: HashSet<[u32; 2]>,
    removed: Vec<bool>,
    /// Triangles that were looked at so far.
    steps: Cell<u64>,
}

/// Triangles by their boxes.
pub(super) type Index = RTree<GeomWithData<Rectangle<[f64; 2]>, u32>>;

/// The triangles at a vertex: counterclockwise until the start or the hull, then clockwise from the
/// start until the hull.
struct Star<'a> {
    plane: &'a Plane,
    v: u32,
    first: u32,
    /// [`NONE`] at the end.
    next: u32,
    step: usize,
}

impl Star<'_> {
    /// The triangle beside `t`.
    fn beside(&self, t: u32) -> u32 {
        self.plane.neighbours[t as usize][(self.plane.place(t, self.v) + self.step) % 3]
    }
}

impl Iterator for Star<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let t = self.next;
        if t == NONE {
            return None;
        }
        self.plane.step();
        self.next = self.beside(t);
        if self.next == NONE && self.step == 1 {
            self.step = 2;
            self.next = self.beside(self.first);
        } else if self.next == self.first {
            self.next = NONE;
        }
        Some(t)
    }
}

impl Plane {
    /// The Delaunay triangulation of `points` of one plane, projected to two axes, of which three
    /// have to be not collinear. The projections have to be distinct.
    pub(super) fn new(points: Vec<Point>, axes: [usize; 2]) -> Result<Self, Problem> {
        let n = points.len();
        let mut order: Vec<u32> = (0..n as u32).collect();
        let key = |v: u32| (points[v as usize][axes[0]], points[v as usize][axes[1]]);
        order.sort_by(|&v, &w| key(v).partial_cmp(&key(w)).unwrap_or(std::cmp::Ordering::Equal));
        if let Some(w) = order.windows(2).find(|w| key(w[0]) == key(w[1])) {
            return Err(Problem::SamePlace(sorted([w[0], w[1]])));
        }
        let mut plane = Self {
            points,
            axes,
            corners: Vec::with_capacity(2 * n),
            neighbours: Vec::with_capacity(2 * n),
            at_vertex: vec![NONE; n],
            forced: HashSet::new(),
            removed: Vec::new(),
            steps: Cell::new(0),
        };
        plane.sweep(&order)?;
        plane.removed = vec![false; plane.corners.len()];
        Ok(plane)
    }

    /// Counts a triangle that is looked at.
    fn step(&self) {
        self.steps.set(self.steps.get() + 1);
    }

    fn turn(&self, a: u32, b: u32, c: u32) -> Sign {
        let [a, b, c] = [a, b, c].map(|v| &self.points[v as usize]);
        orient2d(a, b, c, self.axes)
    }

    /// Inserts the points in this order, left to right.
    fn sweep(&mut self, order: &[u32]) -> Result<(), Problem> {
        // The first point that is not on the line of those before it.
        let apex = (2..order.len())
            .find(|&k| !self.turn(order[0], order[1], order[k]).is_zero())
            .ok_or(Problem::NoArea)?;
        let left = self.turn(order[0], order[1], order[apex]).is_positive();
        // The hull, counterclockwise: the successor of each of its vertices, and its predecessor.
        let mut next = vec![NONE; self.points.len()];
        let mut before = vec![NONE; self.points.len()];
        let mut link = |a: u32, b: u32| {
            next[a as usize] = b;
            before[b as usize] = a;
        };
        let top = order[apex];
        let mut last = NONE;
        for pair in order[..apex].windows(2) {
            let [a, b] = if left { [pair[0], pair[1]] } else { [pair[1], pair[0]] };
            // The previous triangle lies across the edge from the apex to the shared vertex.
            let t = self.add([a, b, top]);
            if last != NONE {
                let (place, other) = if left { (1, 0) } else { (0, 1) };
                self.join(t, place, last, other);
            }
            link(a, b);
            last = t;
        }
        let (start, end) = (order[0], order[apex - 1]);
        let (from, to) = if left { (end, start) } else { (start, end) };
        link(from, top);
        link(top, to);
        let mut stack: Vec<[u32; 2]> = Vec::new();
        let mut previous = top;
        for &p in &order[apex + 1..] {
            let mut fresh: Option<u32> = None;
            // Forwards from the rightmost vertex while edges are visible. Every turn takes an edge
            // off the hull.
            let mut a = previous;
            let mut newest = NONE;
            while self.turn(a, next[a as usize], p).is_negative() {
                let b = next[a as usize];
                let t = self.add_outside([a, b], p);
                if newest != NONE {
                    // The earlier triangle [a, earlier, p] shares the edge a-p.
                    let place = self.place(t, b);
                    let other = self.opposite_of(newest, [a, p]);
                    self.join(t, place, newest, other);
                }
                fresh.get_or_insert(t);
                newest = t;
                stack.push([a, b]);
                a = b;
            }
            let forwards = a;
            // Backwards from it likewise.
            let mut b = previous;
            let mut newest = fresh.unwrap_or(NONE);
            while self.turn(before[b as usize], b, p).is_negative() {
                let a = before[b as usize];
                let t = self.add_outside([a, b], p);
                if newest != NONE {
                    let place = self.place(t, a);
                    let other = self.opposite_of(newest, [b, p]);
                    self.join(t, place, newest, other);
                }
                newest = t;
                stack.push([a, b]);
                b = a;
            }
            let backwards = b;
            next[backwards as usize] = p;
            before[p as usize] = backwards;
            next[p as usize] = forwards;
            before[forwards as usize] = p;
            previous = p;
            self.flip_to_delaunay(&mut stack);
        }
        Ok(())
    }

    /// A new triangle without neighbours.
    fn add(&mut self, corners: [u32; 3]) -> u32 {
        let t = self.corners.len() as u32;
        self.corners.push(corners);
        self.neighbours.push([NONE; 3]);
        corners.iter().for_each(|&v| self.at_vertex[v as usize] = t);
        t
    }

    /// A new triangle of the hull edge a-b and the point p beyond it.
    fn add_outside(&mut self, [a, b]: [u32; 2], p: u32) -> u32 {
        let inner = self.find_edge([a, b]);
        let t = self.add([b, a, p]);
        if let Some((inner, place)) = inner {
            self.join(t, 2, inner, place);
        }
        t
    }

    fn join(&mut self, t: u32, place: usize, u: u32, other: usize) {
        self.neighbours[t as usize][place] = u;
        self.neighbours[u as usize][other] = t;
    }

    /// The place of vertex `v` in triangle `t`, which has it.
    fn place(&self, t: u32, v: u32) -> usize {
        self.corners[t as usize].iter().position(|&w| w == v).unwrap_or(0)
    }

    /// The place of the corner of `t` that is not in `edge`.
    fn opposite_of(&self, t: u32, edge: [u32; 2]) -> usize {
        self.corners[t as usize].iter().position(|v| !edge.contains(v)).unwrap_or(0)
    }

    /// The triangles at a vertex, each once.
    fn star(&self, v: u32) -> Star<'_> {
        let first = self.at_vertex[v as usize];
        Star { plane: self, v, first, next: first, step: 1 }
    }

    /// A triangle with the edge, and the place of its corner across from the edge. Looks around
    /// both ends in turn: one of them may have very many triangles.
    fn find_edge(&self, [a, b]: [u32; 2]) -> Option<(u32, usize)> {
        let (mut at_a, mut at_b) = (self.star(a), self.star(b));
        // Ends with the shorter of the stars.
        loop {
            for (star, other) in [(&mut at_a, b), (&mut at_b, a)] {
                let t = star.next()?;
                if self.corners[t as usize].contains(&other) {
                    return Some((t, self.opposite_of(t, [a, b])));
                }
            }
        }
    }

    /// Flips the edge of triangle `t` across from its corner at `place`:
    ///
    /// ```text
    ///      c               c
    ///     / \             /|\
    ///    a---b     ->    a | b      t = [d, c, a], u = [c, d, b]
    ///     \ /             \|/
    ///      d               d
    /// ```
    fn flip(&mut self, t: u32, place: usize) {
        let u = self.neighbours[t as usize][place];
        let [c, a, b] = [0, 1, 2].map(|k| self.corners[t as usize][(place + k) % 3]);
        let other = self.opposite_of(u, [a, b]);
        let d = self.corners[u as usize][other];
        let [across_a, across_b] = [1, 2].map(|k| self.neighbours[t as usize][(place + k) % 3]);
        // Across from a and b as corners of u.
        let [below_a, below_b] = [a, b].map(|v| self.neighbours[u as usize][self.place(u, v)]);
        self.corners[t as usize] = [d, c, a];
        self.corners[u as usize] = [c, d, b];
        self.neighbours[t as usize] = [across_b, below_b, u];
        self.neighbours[u as usize] = [below_a, across_a, t];
        for (outer, edge, now) in [(below_b, [a, d], t), (across_a, [b, c], u)] {
            if outer != NONE {
                let place = self.opposite_of(outer, edge);
                self.neighbours[outer as usize][place] = now;
            }
        }
        [a, c, d].iter().for_each(|&v| self.at_vertex[v as usize] = t);
        self.at_vertex[b as usize] = u;
    }

    /// Flips edges until those of `stack`, and what their flips concern, are locally Delaunay.
    /// Terminates: every flip lowers the lifted surface, of which there are finitely many. (Of
    /// points that are not in one plane there is no such surface: see `incircle`.)
    fn flip_to_delaunay(&mut self, stack: &mut Vec<[u32; 2]>) {
        while let Some(edge) = stack.pop() {
            let Some((t, place)) = self.find_edge(edge) else { continue };
            let u = self.neighbours[t as usize][place];
            if u == NONE {
                continue;
            }
            let d = self.corners[u as usize][self.opposite_of(u, edge)];
            let [c, a, b] = [0, 1, 2].map(|k| self.corners[t as usize][(place + k) % 3]);
            let [pa, pb, pc, pd] = [a, b, c, d].map(|v| &self.points[v as usize]);
            if incircle(pa, pb, pc, pd, self.axes).is_positive() {
                self.flip(t, place);
                stack.extend([[a, c], [c, b], [b, d], [d, a]]);
            }
        }
    }

    /// Makes the segment between two vertices an edge, for good.
    pub(super) fn force(&mut self, edge: [u32; 2]) -> Result<(), Problem> {
        let mut crossing = self.crossed(edge)?;
        let [a, b] = edge;
        // Flipping in turn ends (Sloan 1993); the bound is far beyond what it takes.
        let mut left = 100 + 10 * crossing.len() * crossing.len();
        while let Some(other) = crossing.pop_front() {
            let stuck = Problem::Crossing(edge, other);
            left = left.checked_sub(1).ok_or(stuck)?;
            let (t, place) = self.find_edge(other).ok_or(stuck)?;
            let u = self.neighbours[t as usize][place];
            if u == NONE {
                // An edge of the rim cannot be flipped: only garbage forces a segment across it.
                return Err(stuck);
            }
            let c = self.corners[t as usize][place];
            let d = self.corners[u as usize][self.opposite_of(u, other)];
            let [p, q] = other;
            // The quadrilateral is convex if its other diagonal separates p and q.
            if self.turn(c, d, p) * self.turn(c, d, q) != Sign::Negative {
                crossing.push_back(other);
                continue;
            }
            self.flip(t, place);
            let apart = self.turn(a, b, c) * self.turn(a, b, d) == Sign::Negative;
            if apart && ![c, d].iter().any(|v| edge.contains(v)) {
                crossing.push_back([c, d]);
            }
        }
        self.forced.insert(sorted(edge));
        Ok(())
    }

    /// The edges that the segment crosses, from its first end to its second.
    fn crossed(&self, edge: [u32; 2]) -> Result<VecDeque<[u32; 2]>, Problem> {
        let [a, b] = edge;
        let mut crossed = VecDeque::new();
        let mut found = None;
        for t in self.star(a) {
            let place = self.place(t, a);
            let [p, q] = [1, 2].map(|k| self.corners[t as usize][(place + k) % 3]);
            if p == b || q == b {
                return Ok(crossed);
            }
            // Is p to the right of a-b, and q to its left?
            let (right, left) = (self.turn(a, b, p), self.turn(a, b, q));
            for (v, side) in [(p, right), (q, left)] {
                if side.is_zero() && self.between(a, v, b) {
                    return Err(Problem::VertexOnEdge { vertex: v, edge });
                }
            }
            // Counterclockwise from p to q is less than half a turn: it passes what is ahead.
            if right.is_negative() && left.is_positive() {
                found = Some((t, place));
            }
        }
        let Some((mut t, mut place)) = found else {
            return Err(Problem::Crossing(edge, edge));
        };
        // Every turn goes on to the next triangle along the segment.
        for _ in 0..self.corners.len() {
            self.step();
            let [p, q] = [1, 2].map(|k| self.corners[t as usize][(place + k) % 3]);
            if self.forced.contains(&sorted([p, q])) {
                return Err(Problem::Crossing(edge, [p, q]));
            }
            crossed.push_back([p, q]);
            let u = self.neighbours[t as usize][place];
            if u == NONE {
                break;
            }
            let far = self.corners[u as usize][self.opposite_of(u, [p, q])];
            if far == b {
                break;
            }
            let leave = match self.turn(a, b, far) {
                Sign::Zero => return Err(Problem::VertexOnEdge { vertex: far, edge }),
                // `far` takes the place of q, or of p: go on across the other one.
                Sign::Positive => q,
                Sign::Negative => p,
            };
            (t, place) = (u, self.place(u, leave));
        }
        Ok(crossed)
    }

    /// Does v, on the line through a and b, lie between them?
    fn between(&self, a: u32, v: u32, b: u32) -> bool {
        let key = |v: u32| self.axes.map(|k| self.points[v as usize][k]);
        let (a, v, b) = (key(a), key(v), key(b));
        (a < v && v < b) || (b < v && v < a)
    }

    fn is_forced(&self, t: u32, place: usize) -> bool {
        let [p, q] = [1, 2].map(|k| self.corners[t as usize][(place + k) % 3]);
        self.forced.contains(&sorted([p, q]))
    }

    /// Removes what is reached from outside the hull without crossing a forced edge.
    pub(super) fn remove_outside(&mut self) {
        let count = self.corners.len() as u32;
        for t in 0..count {
            let open = |&k: &usize| self.neighbours[t as usize][k] == NONE && !self.is_forced(t, k);
            if (0..3).any(|k| open(&k)) {
                self.remove_from(t);
            }
        }
    }

    /// Removes the piece of a triangle.
    pub(super) fn remove_from(&mut self, start: u32) {
        let mut stack = vec![start];
        // A triangle is removed once, and pushes three at most.
        while let Some(t) = stack.pop() {
            if std::mem::replace(&mut self.removed[t as usize], true) {
                continue;
            }
            for k in 0..3 {
                let u = self.neighbours[t as usize][k];
                if u != NONE && !self.is_forced(t, k) && !self.removed[u as usize] {
                    stack.push(u);
                }
            }
        }
    }

    /// All triangles by their boxes.
    pub(super) fn index(&self) -> Index {
        let boxed = |(t, c): (u32, &[u32; 3])| {
            let at = c.map(|v| self.axes.map(|k| self.points[v as usize][k]));
            GeomWithData::new(AABB::from_points(&at).into(), t)
        };
        RTree::bulk_load((0..).zip(&self.corners).map(boxed).collect())
    }

    /// The place of the projection of a point.
    pub(super) fn locate(&self, index: &Index, p: &Point) -> Place {
        let flat = self.axes.map(|k| p[k]);
        for found in index.locate_in_envelope_intersecting(AABB::from_point(flat)) {
            self.step();
            let t = found.data as usize;
            let c = self.corners[t];
            let side = |k: usize| {
                let [a, b] = [1, 2].map(|j| &self.points[c[(k + j) % 3] as usize]);
                orient2d(a, b, p, self.axes)
            };
            let sides = [0, 1, 2].map(side);
            if sides.iter().any(|s| s.is_negative()) {
                continue;
            }
            if (0..3).any(|k| sides[k].is_zero() && self.is_forced(t as u32, k)) {
                return Place::OnEdge;
            }
            // A corner of a triangle is on a forced edge: every vertex is the end of one.
            if sides.iter().filter(|s| s.is_zero()).count() > 1 {
                return Place::OnEdge;
            }
            return if self.removed[t] { Place::Outside } else { Place::Inside(t as u32) };
        }
        Place::Outside
    }

    /// The triangles that are left.
    pub(super) fn kept(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        (0..self.corners.len()).filter(|&t| !self.removed[t]).map(|t| self.corners[t])
    }

    /// Forced edges with no triangle left on either side, sorted.
    pub(super) fn loose(&self) -> impl Iterator<Item = [u32; 2]> {
        let mut loose = self.forced.clone();
        for [a, b, c] in self.kept() {
            for edge in [[a, b], [b, c], [c, a]] {
                loose.remove(&sorted(edge));
            }
        }
        let mut loose: Vec<[u32; 2]> = loose.into_iter().collect();
        loose.sort_unstable();
        loose.into_iter()
    }
}
