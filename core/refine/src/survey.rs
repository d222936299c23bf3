//! Verdicts on proposed points, and the rules that keep points of one round apart, from a closure
//! alone: for engines whose mesh is on many processors.

use super::carrier::Carrier;
use super::choice::{BoundaryItem, Corner, NOWHERE, Rival, Ruling};
use super::complex::Complex;
use super::measure::{in_diametral_ball, in_equatorial_ball};
use super::state::FACE;
use super::surveyed::{Surveyed, sorted_face};
use super::table::{edge, sides};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, coplanar_orient};
use smallvec::SmallVec;

/// A marked face of a cavity.
#[derive(Debug)]
struct Face<T> {
    key: [u32; 3],
    facet: u32,
    /// A tetrahedron of the cavity that has it, and the one beyond, if that is in the closure.
    sides: [Option<T>; 2],
    is_inner: bool,
}

/// A marked edge of a cavity.
#[derive(Debug)]
struct Edge {
    key: [u32; 2],
    segment: u32,
    is_inner: bool,
}

/// A closure with what is boundary in it.
#[doc(hidden)]
#[derive(Debug)]
pub struct Survey<'c, R: Surveyed> {
    complex: &'c Complex<'c>,
    closure: &'c R,
    faces: SmallVec<[Face<R::Tet>; 8]>,
    edges: Vec<Edge>,
}

/// The slots at the ends of each edge of a tetrahedron, and the other two.
const EDGES: [([usize; 2], [usize; 2]); 6] = [
    ([0, 1], [2, 3]),
    ([0, 2], [1, 3]),
    ([0, 3], [1, 2]),
    ([1, 2], [0, 3]),
    ([1, 3], [0, 2]),
    ([2, 3], [0, 1]),
];

impl<'c, R: Surveyed> Survey<'c, R> {
    /// Finds what is boundary in a closure.
    pub fn of(complex: &'c Complex<'c>, closure: &'c R) -> Self {
        let mut own = Self { complex, closure, faces: SmallVec::new(), edges: Vec::new() };
        for t in closure.cavity() {
            let is_on = closure.bound(t);
            let count: u8 = is_on.iter().map(|&on| u8::from(on)).sum();
            // Three corners of a subface are on the boundary, and two of a subsegment.
            if count > 1 {
                let v = closure.vertices(t);
                if count > 2 {
                    own.note_faces(t, v, is_on);
                }
                own.note_edges(t, v, is_on);
            }
        }
        own
    }

    fn carrier(&self, v: u32) -> Carrier {
        self.closure.corner(v).carrier
    }

    fn point(&self, v: u32) -> Point {
        self.closure.corner(v).point
    }

    fn is_in(&self, t: Option<R::Tet>) -> bool {
        t.is_some_and(|t| self.closure.is_in(t))
    }

    fn note_faces(&mut self, t: R::Tet, v: [u32; 4], is_on: [bool; 4]) {
        for (slot, face) in FACE.into_iter().enumerate() {
            if face.iter().any(|&slot| !is_on[slot]) {
                continue;
            }
            let corners = face.map(|slot| v[slot]);
            let known = corners.map(|v| self.closure.corner(v)).map(|own| (own.carrier, own.point));
            let Some(facet) = self.complex.facet(known) else { continue };
            let beyond = self.closure.beyond(t, slot);
            let is_inner = self.is_in(beyond);
            // An inner face is met from both sides.
            if !is_inner || beyond > Some(t) {
                let sides = [Some(t), beyond];
                self.faces.push(Face { key: sorted_face(corners), facet, sides, is_inner });
            }
        }
    }

    fn note_edges(&mut self, t: R::Tet, v: [u32; 4], is_on: [bool; 4]) {
        for ([i, j], beside) in EDGES {
            if !(is_on[i] && is_on[j]) {
                continue;
            }
            let ends = [v[i], v[j]];
            let Some(segment) = self.complex.segment(ends.map(|v| self.carrier(v))) else {
                continue;
            };
            let is_inner = beside.into_iter().all(|slot| self.is_in(self.closure.beyond(t, slot)));
            let key = edge(ends[0], ends[1]);
            match self.edges.iter_mut().find(|edge| edge.key == key) {
                Some(edge) => edge.is_inner &= is_inner,
                None => self.edges.push(Edge { key, segment, is_inner }),
            }
        }
    }

    fn subface(&self, key: [u32; 3], of: u32) -> BoundaryItem {
        BoundaryItem::new(&key.map(|v| self.closure.corner(v)), of)
    }

    fn subsegment(&self, edge: &Edge) -> BoundaryItem {
        BoundaryItem::new(&edge.key.map(|v| self.closure.corner(v)), edge.segment)
    }

    /// Of the subsegments whose closed balls hold `p`, the one that comes first.
    fn hit_segment(&self, p: &Point) -> Option<BoundaryItem> {
        let is_hit = |edge: &&Edge| {
            let [a, b] = edge.key.map(|v| self.point(v));
            in_diametral_ball(&a, &b, p)
        };
        most_urgent(self.edges.iter().filter(is_hit).map(|edge| self.subsegment(edge)))
    }

    /// Of the subfaces whose balls hold `p`, the one that comes first. `p` is in none of their
    /// planes.
    fn hit_subface(&self, p: &Point) -> Option<BoundaryItem> {
        let is_hit = |face: &&Face<_>| {
            let [a, b, c] = face.key.map(|v| self.point(v));
            in_equatorial_ball(&a, &b, &c, p)
        };
        let hits = self.faces.iter().filter(is_hit);
        most_urgent(hits.map(|face| self.subface(face.key, face.facet)))
    }

    /// Of the items that go with the cavity, but for some, the one that comes first.
    fn loss(&self, removed: &[[u32; 3]], split: Option<[u32; 2]>) -> Option<BoundaryItem> {
        let is_lost = |face: &&Face<_>| face.is_inner && !removed.contains(&face.key);
        let faces = self.faces.iter().filter(is_lost);
        let edges = self.edges.iter().filter(|edge| edge.is_inner && Some(edge.key) != split);
        let faces = faces.map(|face| self.subface(face.key, face.facet));
        most_urgent(faces.chain(edges.map(|edge| self.subsegment(edge))))
    }

    /// The verdict on a point inside: nothing goes, or this item comes first.
    pub fn rule_on_tet(&self, p: &Point) -> Option<BoundaryItem> {
        self.hit_segment(p).or_else(|| self.hit_subface(p)).or_else(|| self.loss(&[], None))
    }

    /// The vertices of the cavity that are the corners of an item.
    fn own(&self, item: &BoundaryItem) -> Option<Vec<u32>> {
        let all = || {
            let of_tet = |t| self.closure.vertices(t).into_iter().zip(self.closure.bound(t));
            self.closure.cavity().flat_map(of_tet).filter(|own| own.1).map(|own| own.0)
        };
        let place = |corner: &Corner| all().find(|&v| self.point(v) == corner.point);
        item.corners().iter().map(place).collect()
    }

    /// The verdict on a point of the boundary that is to split an item.
    pub fn rule_on_item(&self, item: &BoundaryItem, p: &Point) -> Ruling {
        let Some(own) = self.own(item) else { return Ruling::Useless };
        match own[..] {
            [a, b] => self.rule_on_segment(edge(a, b), item, p),
            [a, b, c] => self.rule_on_subface(sorted_face([a, b, c]), item.of(), p),
            _ => Ruling::Useless,
        }
    }

    fn rule_on_segment(&self, ends: [u32; 2], item: &BoundaryItem, p: &Point) -> Ruling {
        let mut removed = Vec::new();
        for &f in self.complex.facets_of(item.of()) {
            let is_first = |key: &[u32; 3]| ends.iter().all(|v| key.contains(v));
            match self.planar_cavity(f, p, is_first, Some(ends)) {
                Some(own) => removed.extend(own),
                None => return Ruling::Refuse,
            }
        }
        if let Some(lost) = self.loss(&removed, Some(ends)) {
            return Ruling::Defer(lost);
        }
        let gone = self.faces.iter().filter(|face| removed.contains(&face.key));
        let gone = gone.map(|face| self.subface(face.key, face.facet));
        Ruling::Fill(gone.chain([*item]).collect())
    }

    fn rule_on_subface(&self, own: [u32; 3], f: u32, p: &Point) -> Ruling {
        if let Some(hit) = self.hit_segment(p) {
            return Ruling::Defer(hit);
        }
        let removed = self.planar_cavity(f, p, |key| *key == own, None);
        if let Some(removed) = removed.filter(|removed| removed.contains(&own)) {
            return match self.loss(&removed, None) {
                None => Ruling::Fill(removed.iter().map(|&key| self.subface(key, f)).collect()),
                Some(lost) => Ruling::Defer(lost),
            };
        }
        match self.segment_between(own, f, p) {
            Some(segment) => Ruling::Defer(segment),
            None => Ruling::Useless,
        }
    }

    fn is_segment(&self, ends: [u32; 2]) -> bool {
        self.complex.segment(ends.map(|v| self.carrier(v))).is_some()
    }

    /// The subfaces of facet `f` in the cavity of `p`, from the first ones on, as far as no
    /// subsegment is between; `None` if `p` does not see all of their rim.
    fn planar_cavity(
        &self,
        f: u32,
        p: &Point,
        is_first: impl Fn(&[u32; 3]) -> bool,
        split: Option<[u32; 2]>,
    ) -> Option<Vec<[u32; 3]>> {
        let all = self.faces.iter().filter(|face| face.is_inner && face.facet == f);
        let all: Vec<[u32; 3]> = all.map(|face| face.key).collect();
        let mut removed: Vec<[u32; 3]> = all.iter().copied().filter(is_first).collect();
        let mut next = 0;
        // Breadth first; each one enters once.
        while let Some(&face) = removed.get(next) {
            next += 1;
            for ([a, b], _) in sides(face) {
                if self.is_segment([a, b]) {
                    continue;
                }
                let has = |other: &&[u32; 3]| other.contains(&a) && other.contains(&b);
                for &other in all.iter().filter(has) {
                    if !removed.contains(&other) {
                        removed.push(other);
                    }
                }
            }
        }
        for (k, &face) in removed.iter().enumerate() {
            for ([a, b], opposite) in sides(face) {
                let has = |(l, other): (usize, &[u32; 3])| {
                    l != k && other.contains(&a) && other.contains(&b)
                };
                let is_shared = removed.iter().enumerate().any(has);
                if split == Some(edge(a, b)) || is_shared && !self.is_segment([a, b]) {
                    continue;
                }
                if self.turn([a, b], p) != self.turn([a, b], &self.point(opposite)) {
                    return None;
                }
            }
        }
        Some(removed)
    }

    fn turn(&self, [a, b]: [u32; 2], p: &Point) -> Sign {
        coplanar_orient(&self.point(a), &self.point(b), p)
    }

    /// The subsegment of facet `f` between its subface and a point `p` of its plane that the
    /// subface does not see.
    fn segment_between(&self, own: [u32; 3], f: u32, p: &Point) -> Option<BoundaryItem> {
        let nearest = |found: Vec<BoundaryItem>| found.into_iter().min_by_key(BoundaryItem::place);
        let is_beyond = |&([a, b], opposite): &([u32; 2], u32)| {
            self.is_segment([a, b])
                && self.turn([a, b], p) != self.turn([a, b], &self.point(opposite))
        };
        let item = |([a, b], _): ([u32; 2], u32)| {
            let ends = [a, b].map(|v| self.closure.corner(v));
            let of = self.complex.segment(ends.map(|end| end.carrier))?;
            Some(BoundaryItem::new(&ends, of))
        };
        let sides = sides(own).into_iter().filter(is_beyond).filter_map(item).collect();
        if let Some(side) = nearest(sides) {
            return Some(side);
        }
        let separates = |edge: &&Edge| {
            let [x, y] = edge.key;
            let mine = self.turn([x, y], p);
            let theirs = own.map(|v| self.turn([x, y], &self.point(v)));
            let is_between = !mine.is_zero() && theirs.contains(&-mine) && !theirs.contains(&mine);
            let crosses = own.iter().any(|&v| {
                let [left, right] =
                    [x, y].map(|end| coplanar_orient(&self.point(v), p, &self.point(end)));
                !left.is_zero() && left == -right
            });
            self.complex.facets_of(edge.segment).contains(&f) && is_between && crosses
        };
        nearest(self.edges.iter().filter(separates).map(|edge| self.subsegment(edge)).collect())
    }

    /// The watch of a point inside; none if no part of its cavity is marked.
    pub fn watch_in_tet(&self) -> Option<Watch<R::Tet>> {
        if self.faces.is_empty() && self.edges.is_empty() {
            return None;
        }
        let mut watch = Watch { any: Vec::new(), own: Vec::new(), anywhere: Anywhere::Boundary };
        self.watch_faces(Carrier::Free, &mut watch.any);
        self.watch_edges(None, &mut watch.any);
        Some(watch)
    }

    /// The watch of a point of the boundary on `carrier` that splits an item.
    pub fn watch_at_item(&self, item: &BoundaryItem, carrier: Carrier) -> Watch<R::Tet> {
        let own = match self.own(item).unwrap_or_default()[..] {
            [a, b, c] => {
                let has = |v: [u32; 4]| [a, b, c].iter().all(|own| v.contains(own));
                self.closure.cavity().filter(|&t| has(self.closure.vertices(t))).collect()
            }
            _ => Vec::new(),
        };
        let split = match carrier {
            Carrier::Segment(s, _) => Some(s),
            _ => None,
        };
        let mut watch = Watch { any: Vec::new(), own, anywhere: Anywhere::Apart };
        self.watch_faces(carrier, &mut watch.any);
        self.watch_edges(split, &mut watch.any);
        watch
    }

    /// Rule (b).
    fn watch_faces(&self, carrier: Carrier, any: &mut Vec<R::Tet>) {
        for face in &self.faces {
            let is_lost = || {
                if carrier != Carrier::Free {
                    return !self.complex.lies_on(carrier, face.facet);
                }
                let [a, b, c] = face.key.map(|v| self.point(v));
                let apexes = face.sides.into_iter().flatten().filter_map(|t| {
                    self.closure.vertices(t).into_iter().find(|v| !face.key.contains(v))
                });
                apexes
                    .filter(|v| *v != NOWHERE)
                    .any(|apex| in_equatorial_ball(&a, &b, &c, &self.point(apex)))
            };
            // From either side that is in the cavity.
            let [one, other] = face.sides;
            if is_lost() {
                any.extend(other.into_iter().chain(one.filter(|_| face.is_inner)));
            }
        }
    }

    /// Rule (c), but for edges of segment `split`.
    fn watch_edges(&self, split: Option<u32>, any: &mut Vec<R::Tet>) {
        let others = self.edges.iter().filter(|edge| Some(edge.segment) != split);
        let keys: Vec<[u32; 2]> = others.map(|edge| edge.key).collect();
        if keys.is_empty() {
            return;
        }
        for t in self.closure.cavity() {
            let v = self.closure.vertices(t);
            for ([i, j], beside) in EDGES {
                if keys.contains(&edge(v[i], v[j])) {
                    any.push(t);
                    any.extend(beside.into_iter().filter_map(|s| self.closure.beyond(t, s)));
                }
            }
        }
    }
}

/// The tetrahedra at which candidates that come before a point make it wait.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Watch<T> {
    /// It waits if one of these has a rival.
    any: Vec<T>,
    /// It waits if all of these have, unless there are none: the tetrahedra at its own subface.
    own: Vec<T>,
    anywhere: Anywhere,
}

/// The rivals for which a point waits wherever they are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Anywhere {
    Boundary,
    Apart,
}

impl<T: Copy> Watch<T> {
    /// This watch over tetrahedra with other names, in the order of these.
    pub fn named<U: Ord>(&self, name: impl Fn(T) -> U) -> Watch<U> {
        let named = |all: &[T]| {
            let mut all: Vec<U> = all.iter().copied().map(&name).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        Watch { any: named(&self.any), own: named(&self.own), anywhere: self.anywhere }
    }

    /// Does the point wait, if the tetrahedra of its closure, which are these, have these rivals?
    pub fn yields(&self, all: impl IntoIterator<Item = T>, rival: impl Fn(T) -> Rival) -> bool {
        let matters = |own: Rival| match self.anywhere {
            Anywhere::Boundary => own.is_boundary,
            Anywhere::Apart => own.is_apart,
        };
        let has = |&t: &T| rival(t).is_there;
        self.any.iter().any(has)
            || !self.own.is_empty() && self.own.iter().all(has)
            || all.into_iter().map(&rival).any(|own| own.is_there && matters(own))
    }
}

/// The item that is to be split before the others.
fn most_urgent(mut items: impl Iterator<Item = BoundaryItem>) -> Option<BoundaryItem> {
    let first = items.next()?;
    // Of nearly all there is one.
    let Some(second) = items.next() else { return Some(first) };
    [first, second].into_iter().chain(items).min_by_key(BoundaryItem::urgency)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_urgent_item_is_the_first_of_them_in_order() {
        let corner = |x: i32, y: i32| Corner {
            point: [f64::from(x), f64::from(y), 0.5],
            carrier: Carrier::Facet(0),
        };
        // Subsegments and subfaces of some sizes, and equal ones at other places.
        let segment = |x| BoundaryItem::new(&[corner(x, 0), corner(x + 1 + x % 3, 0)], 1);
        let face =
            |x| BoundaryItem::new(&[corner(x, 0), corner(x + 1, 0), corner(x, 1 + x % 2)], 2);
        let items: Vec<BoundaryItem> = (0..6).flat_map(|x| [face(x), segment(x)]).collect();
        for count in 0..items.len() {
            for first in 0..items.len() - count {
                let some = &items[first..first + count];
                let mut sorted = some.to_vec();
                sorted.sort_by_cached_key(BoundaryItem::urgency);
                assert_eq!(most_urgent(some.iter().copied()), sorted.first().copied());
            }
        }
    }
}
