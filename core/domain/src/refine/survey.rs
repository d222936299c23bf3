//! Verdicts on proposed points, and the rules that keep points of one round apart, from a closure
//! alone: for engines whose mesh is on many processors.

use super::carrier::Carrier;
use super::choice::{BoundaryItem, Closure, Corner, NOWHERE, Rival, Ruling};
use super::complex::Complex;
use super::measure::{in_diametral_ball, in_equatorial_ball};
use super::state::FACE;
use super::table::{Map, edge, sides, triangle};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, coplanar_orient};

/// A marked face of a cavity.
#[derive(Debug)]
struct Face {
    key: [u32; 3],
    facet: u32,
    /// A tetrahedron of the cavity that has it, and the one beyond, if that is in the closure.
    sides: [Option<usize>; 2],
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
pub struct Survey<'c> {
    complex: &'c Complex<'c>,
    closure: &'c Closure,
    faces: Vec<Face>,
    edges: Vec<Edge>,
    /// The tetrahedra at each face that matters, if the closure does not tell.
    at_face: Map<[u32; 3], [Option<usize>; 2]>,
}

fn triple([a, b, c]: [u32; 3]) -> [u32; 3] {
    triangle(a, b, c)
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

impl<'c> Survey<'c> {
    /// Finds what is boundary in a closure.
    pub fn of(complex: &'c Complex<'c>, closure: &'c Closure) -> Self {
        let (faces, edges, at_face) = (Vec::new(), Vec::new(), Map::default());
        let mut own = Self { complex, closure, faces, edges, at_face };
        let all = || closure.tets.iter().enumerate();
        let is_bound = |v: u32| closure.corners[v as usize].carrier != Carrier::Free;
        let may = |v: &u32| *v != NOWHERE && is_bound(*v);
        let is_near = |tet: &[u32; 4]| tet.iter().filter(|v| may(v)).count() > 1;
        let near = || all().filter(|(_, (tet, is_in))| *is_in && is_near(tet)).map(|(k, _)| k);
        if near().next().is_none() {
            return own;
        }
        if closure.beyond.is_empty() {
            own.at_face.reserve(3 * closure.tets.len());
        }
        let unknown = all().filter(|_| closure.beyond.is_empty());
        for (k, (tet, _)) in unknown.filter(|(_, (tet, _))| is_near(tet)) {
            // A face that is marked, or has a marked edge, has two such corners.
            let is_on =
                |face: &[usize; 3]| face.iter().filter(|&&slot| may(&tet[slot])).count() > 1;
            for face in FACE.into_iter().filter(is_on) {
                let entry = own.at_face.entry(triple(face.map(|slot| tet[slot]))).or_default();
                entry[usize::from(entry[0].is_some())] = Some(k);
            }
        }
        for k in near() {
            own.note_faces(k);
            own.note_edges(k);
        }
        own
    }

    fn carrier(&self, v: u32) -> Carrier {
        self.closure.corners[v as usize].carrier
    }

    fn point(&self, v: u32) -> &Point {
        &self.closure.corners[v as usize].point
    }

    fn is_in(&self, tet: Option<usize>) -> bool {
        tet.is_some_and(|k| self.closure.tets[k].1)
    }

    /// The tetrahedron beyond face `slot` of one of the closure, if that is there, too.
    fn beyond(&self, k: usize, slot: usize) -> Option<usize> {
        if let Some(beyond) = self.closure.beyond.get(k) {
            return (beyond[slot] != NOWHERE).then_some(beyond[slot] as usize);
        }
        let tet = &self.closure.tets[k].0;
        let at = self.at_face.get(&triple(FACE[slot].map(|slot| tet[slot])))?;
        at.iter().flatten().copied().find(|other| *other != k)
    }

    fn note_faces(&mut self, k: usize) {
        let tet = self.closure.tets[k].0;
        for (slot, face) in FACE.into_iter().enumerate() {
            let corners = face.map(|slot| tet[slot]);
            if corners.iter().any(|&v| v == NOWHERE || self.carrier(v) == Carrier::Free) {
                continue;
            }
            let beyond = self.beyond(k, slot);
            let is_inner = self.is_in(beyond);
            // An inner face is met from both sides.
            if is_inner && beyond < Some(k) {
                continue;
            }
            let known = corners.map(|v| (self.carrier(v), *self.point(v)));
            if let Some(facet) = self.complex.facet(known) {
                let sides = [Some(k), beyond];
                self.faces.push(Face { key: triple(corners), facet, sides, is_inner });
            }
        }
    }

    fn note_edges(&mut self, k: usize) {
        let tet = self.closure.tets[k].0;
        for ([i, j], beside) in EDGES {
            let ends = [tet[i], tet[j]];
            if ends.contains(&NOWHERE) {
                continue;
            }
            let Some(segment) = self.complex.segment(ends.map(|v| self.carrier(v))) else {
                continue;
            };
            let is_inner = beside.into_iter().all(|slot| self.is_in(self.beyond(k, slot)));
            let key = edge(ends[0], ends[1]);
            match self.edges.iter_mut().find(|edge| edge.key == key) {
                Some(edge) => edge.is_inner &= is_inner,
                None => self.edges.push(Edge { key, segment, is_inner }),
            }
        }
    }

    /// Is anything of the cavity marked?
    pub fn is_marked(&self) -> bool {
        !(self.faces.is_empty() && self.edges.is_empty())
    }

    fn subface(&self, key: [u32; 3], of: u32) -> BoundaryItem {
        BoundaryItem::new(key.iter().map(|&v| self.closure.corners[v as usize]).collect(), of)
    }

    fn subsegment(&self, edge: &Edge) -> BoundaryItem {
        let corners = edge.key.iter().map(|&v| self.closure.corners[v as usize]);
        BoundaryItem::new(corners.collect(), edge.segment)
    }

    /// The subsegments whose closed balls hold `p`.
    fn hit_segments(&self, p: &Point) -> Vec<BoundaryItem> {
        let is_hit = |edge: &&Edge| {
            let [a, b] = edge.key.map(|v| *self.point(v));
            in_diametral_ball(&a, &b, p)
        };
        sorted_items(self.edges.iter().filter(is_hit).map(|edge| self.subsegment(edge)).collect())
    }

    /// The subfaces whose closed balls hold `p`, which is in none of their planes.
    fn hit_subfaces(&self, p: &Point) -> Vec<BoundaryItem> {
        let is_hit = |face: &&Face| {
            let [a, b, c] = face.key.map(|v| *self.point(v));
            in_equatorial_ball(&a, &b, &c, p)
        };
        let hits = self.faces.iter().filter(is_hit);
        sorted_items(hits.map(|face| self.subface(face.key, face.facet)).collect())
    }

    /// The items that go with the cavity, but for some.
    fn losses(&self, removed: &[[u32; 3]], split: Option<[u32; 2]>) -> Vec<BoundaryItem> {
        let is_lost = |face: &&Face| face.is_inner && !removed.contains(&face.key);
        let faces = self.faces.iter().filter(is_lost);
        let edges = self.edges.iter().filter(|edge| edge.is_inner && Some(edge.key) != split);
        let faces = faces.map(|face| self.subface(face.key, face.facet));
        sorted_items(faces.chain(edges.map(|edge| self.subsegment(edge))).collect())
    }

    /// The verdict on a point inside: nothing goes, or one of these items comes first.
    pub fn rule_on_tet(&self, p: &Point) -> Vec<BoundaryItem> {
        let hits = self.hit_segments(p);
        let hits = if hits.is_empty() { self.hit_subfaces(p) } else { hits };
        if hits.is_empty() { self.losses(&[], None) } else { hits }
    }

    /// The corners of the closure that are those of an item.
    fn own(&self, item: &BoundaryItem) -> Option<Vec<u32>> {
        let place = |corner: &Corner| {
            let found = self.closure.corners.iter().position(|c| c.point == corner.point);
            found.map(|k| k as u32)
        };
        item.corners().iter().map(place).collect()
    }

    /// The verdict on a point of the boundary that is to split an item.
    pub fn rule_on_item(&self, item: &BoundaryItem, p: &Point) -> Ruling {
        let Some(own) = self.own(item) else { return Ruling::Useless };
        match own[..] {
            [a, b] => self.rule_on_segment(edge(a, b), item, p),
            [a, b, c] => self.rule_on_subface(triple([a, b, c]), item.of(), p),
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
        let lost = self.losses(&removed, Some(ends));
        if !lost.is_empty() {
            return Ruling::Defer(lost);
        }
        let gone = self.faces.iter().filter(|face| removed.contains(&face.key));
        let gone = gone.map(|face| self.subface(face.key, face.facet));
        Ruling::Fill(gone.chain([*item]).collect())
    }

    fn rule_on_subface(&self, own: [u32; 3], f: u32, p: &Point) -> Ruling {
        let hits = self.hit_segments(p);
        if !hits.is_empty() {
            return Ruling::Defer(hits);
        }
        let removed = self.planar_cavity(f, p, |key| *key == own, None);
        if let Some(removed) = removed.filter(|removed| removed.contains(&own)) {
            let lost = self.losses(&removed, None);
            return match lost.is_empty() {
                true => Ruling::Fill(removed.iter().map(|&key| self.subface(key, f)).collect()),
                false => Ruling::Defer(lost),
            };
        }
        match self.segment_between(own, f, p) {
            Some(segment) => Ruling::Defer(vec![segment]),
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
                if self.turn([a, b], p) != self.turn([a, b], self.point(opposite)) {
                    return None;
                }
            }
        }
        Some(removed)
    }

    fn turn(&self, [a, b]: [u32; 2], p: &Point) -> Sign {
        coplanar_orient(self.point(a), self.point(b), p)
    }

    /// The subsegment of facet `f` between its subface and a point `p` of its plane that the
    /// subface does not see.
    fn segment_between(&self, own: [u32; 3], f: u32, p: &Point) -> Option<BoundaryItem> {
        let nearest = |found: Vec<BoundaryItem>| found.into_iter().min_by_key(BoundaryItem::place);
        let is_beyond = |&([a, b], opposite): &([u32; 2], u32)| {
            self.is_segment([a, b])
                && self.turn([a, b], p) != self.turn([a, b], self.point(opposite))
        };
        let item = |([a, b], _): ([u32; 2], u32)| {
            let ends = [a, b].map(|v| self.closure.corners[v as usize]);
            let of = self.complex.segment(ends.map(|end| end.carrier))?;
            Some(BoundaryItem::new(ends.to_vec(), of))
        };
        let sides = sides(own).into_iter().filter(is_beyond).filter_map(item).collect();
        if let Some(side) = nearest(sides) {
            return Some(side);
        }
        let separates = |edge: &&Edge| {
            let [x, y] = edge.key;
            let mine = self.turn([x, y], p);
            let theirs = own.map(|v| self.turn([x, y], self.point(v)));
            let is_between = !mine.is_zero() && theirs.contains(&-mine) && !theirs.contains(&mine);
            let crosses = own.iter().any(|&v| {
                let [left, right] =
                    [x, y].map(|end| coplanar_orient(self.point(v), p, self.point(end)));
                !left.is_zero() && left == -right
            });
            self.complex.facets_of(edge.segment).contains(&f) && is_between && crosses
        };
        nearest(self.edges.iter().filter(separates).map(|edge| self.subsegment(edge)).collect())
    }

    /// Does a point inside wait for candidates before it? `rivals`: of the closure's tetrahedra.
    pub fn yields_in_tet(&self, rivals: &[Rival]) -> bool {
        if !self.is_marked() {
            return false;
        }
        let is_beside = rivals.iter().any(|rival| rival.is_there && rival.is_boundary);
        is_beside || self.loses_face(rivals, Carrier::Free) || self.loses_edge(rivals, None)
    }

    /// The same of a point of the boundary on `carrier` that splits an item.
    pub fn yields_at_item(&self, item: &BoundaryItem, carrier: Carrier, rivals: &[Rival]) -> bool {
        if rivals.iter().any(|rival| rival.is_there && rival.is_apart) {
            return true;
        }
        let own = self.own(item).unwrap_or_default();
        if let [a, b, c] = own[..] {
            let has = |tet: &[u32; 4]| [a, b, c].iter().all(|v| tet.contains(v));
            let at = self.closure.tets.iter().zip(rivals);
            let mut at = at.filter(|((tet, is_in), _)| *is_in && has(tet));
            if at.all(|(_, rival)| rival.is_there) {
                return true;
            }
        }
        let split = match carrier {
            Carrier::Segment(s, _) => Some(s),
            _ => None,
        };
        self.loses_face(rivals, carrier) || self.loses_edge(rivals, split)
    }

    /// Rule (b).
    fn loses_face(&self, rivals: &[Rival], carrier: Carrier) -> bool {
        let has_rival = |side: Option<usize>| side.is_some_and(|k| rivals[k].is_there);
        self.faces.iter().any(|face| {
            let [one, other] = face.sides;
            // From either side that is in the cavity.
            if !(has_rival(other) || face.is_inner && has_rival(one)) {
                return false;
            }
            if carrier != Carrier::Free {
                return !self.complex.lies_on(carrier, face.facet);
            }
            let [a, b, c] = face.key.map(|v| *self.point(v));
            let apexes = face.sides.into_iter().flatten().filter_map(|k| {
                let tet = self.closure.tets[k].0;
                tet.into_iter().find(|v| !face.key.contains(v))
            });
            apexes
                .filter(|v| *v != NOWHERE)
                .any(|apex| in_equatorial_ball(&a, &b, &c, self.point(apex)))
        })
    }

    /// Rule (c), but for edges of segment `split`.
    fn loses_edge(&self, rivals: &[Rival], split: Option<u32>) -> bool {
        let others = self.edges.iter().filter(|edge| Some(edge.segment) != split);
        let keys: Vec<[u32; 2]> = others.map(|edge| edge.key).collect();
        if keys.is_empty() {
            return false;
        }
        let cavity = self.closure.tets.iter().enumerate().filter(|(_, (_, is_in))| *is_in);
        let mut all = cavity.flat_map(|(k, (tet, _))| EDGES.map(move |own| (k, tet, own)));
        all.any(|(k, tet, ([i, j], beside))| {
            keys.contains(&edge(tet[i], tet[j]))
                && (rivals[k].is_there
                    || beside.into_iter().any(|slot| {
                        self.beyond(k, slot).is_some_and(|other| rivals[other].is_there)
                    }))
        })
    }
}

/// Sorts items: that which is to be split first comes first.
fn sorted_items(mut items: Vec<BoundaryItem>) -> Vec<BoundaryItem> {
    if items.len() > 1 {
        items.sort_by_cached_key(BoundaryItem::urgency);
    }
    items
}
