//! The verdict on a point, by what the owners of its cavity say of the boundary there.

use super::values::{DomainPiece, DomainPoint, ItemKey, Marked, segment_key, subface_key};
use crate::mesh::{Link, Side, VertexName};
use crate::protocol::WorkerId;
use ltbw_domain::vector::{dot, minus};
use ltbw_exact::Point;
use ltbw_refine::{Carrier, Complex};
use rustc_hash::{FxHashMap, FxHashSet};
use std::cmp::Ordering;

/// The verdict on a point whose closure is locked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// It may be inserted.
    Fill,
    /// This item goes first, at that worker's tetrahedron.
    Defer(WorkerId, Marked),
    /// An item is in the way that cannot be split.
    Bar,
    /// It does not do what it was made for.
    Useless,
}

/// A boundary item of the cavity.
#[derive(Debug)]
struct Item {
    marked: Marked,
    at: WorkerId,
    corners: Vec<Point>,
    /// All tetrahedra at it are in conflict.
    is_inner: bool,
    is_refused: bool,
}

impl Item {
    fn is_subface(&self) -> bool {
        self.corners.len() == 3
    }

    fn middle(&self) -> Point {
        let sum = |k: usize| self.corners.iter().map(|p| p[k]).sum::<f64>();
        [0, 1, 2].map(|k| sum(k) / self.corners.len() as f64)
    }
}

/// The boundary in a cavity.
#[derive(Debug)]
pub(super) struct Cavity<'a> {
    complex: &'a Complex<'a>,
    items: Vec<Item>,
    segments: FxHashSet<ItemKey>,
}

/// The sides of a cavity that are its boundary, by the names of their vertices, with their pieces
/// and their places there.
pub(super) fn sides(
    parts: &[(WorkerId, Vec<DomainPiece>)],
) -> impl Iterator<Item = ([VertexName; 3], &DomainPiece, usize)> {
    let pieces = || parts.iter().flat_map(|(_, pieces)| pieces);
    let named: FxHashSet<_> = pieces().flat_map(|own| own.piece.names.iter().copied()).collect();
    let is_outer =
        move |side: &Side| !matches!(side.link, Link::Far(far) if named.contains(&far.name));
    let all = pieces().flat_map(|own| own.piece.sides.iter().enumerate().map(move |s| (own, s)));
    all.filter_map(move |(own, (k, side))| {
        let name = |v: u32| own.piece.vertices[v as usize].name;
        is_outer(side).then(|| (side.v.map(name), own, k))
    })
}

impl<'a> Cavity<'a> {
    pub(super) fn of(complex: &'a Complex<'a>, parts: &[(WorkerId, Vec<DomainPiece>)]) -> Self {
        let mut own = Self { complex, items: Vec::new(), segments: FxHashSet::default() };
        let mut places: FxHashMap<ItemKey, usize> = FxHashMap::default();
        for (worker, pieces) in parts {
            for piece in pieces.iter().filter(|piece| !piece.marked.is_empty()) {
                let vertices = &piece.piece.vertices;
                let at = |name: &VertexName| {
                    vertices.iter().find(|v| v.name == *name).map(|vertex| vertex.point())
                };
                for &marked in &piece.marked {
                    let next = own.items.len();
                    let place = *places.entry(marked.key).or_insert(next);
                    if place == next {
                        let is_refused = false;
                        let corners: Vec<Point> =
                            marked.key.iter().filter(|name| **name != 0).filter_map(at).collect();
                        let is_inner = corners.len() == 2;
                        let item = Item { marked, at: *worker, corners, is_inner, is_refused };
                        own.items.push(item);
                    } else if own.items[place].is_subface() {
                        own.items[place].is_inner = true;
                    }
                    own.items[place].is_refused |= marked.is_refused;
                }
            }
        }
        if own.items.iter().any(|item| !item.is_subface()) {
            for ([a, b, c], ..) in sides(parts) {
                for ends in [[a, b], [b, c], [c, a]] {
                    if let Some(&place) = places.get(&segment_key(ends)) {
                        own.items[place].is_inner = false;
                    }
                }
            }
        }
        let segments = own.items.iter().filter(|item| !item.is_subface());
        own.segments = segments.map(|item| item.marked.key).collect();
        own
    }

    /// Is there nothing of the boundary?
    pub(super) fn is_bare(&self) -> bool {
        self.items.is_empty()
    }

    pub(super) fn verdict(&self, point: &DomainPoint) -> Verdict {
        let p = point.vertex.point();
        match point.carrier {
            Carrier::Free => {
                let hits = |item: &&Item| item.is_inner || self.encroaches(item, &p);
                self.defer_to(self.items.iter().filter(hits), point)
            }
            Carrier::Segment(s, _) => self.on_segment(point, s),
            Carrier::Facet(f) => self.on_subface(point, &p, f),
            Carrier::Corner(_) => Verdict::Useless,
        }
    }

    fn encroaches(&self, item: &Item, p: &Point) -> bool {
        match &item.corners[..] {
            [a, b] => self.complex.encroaches_segment([a, b], p),
            [a, b, c] => self.complex.encroaches_subface([a, b, c], p),
            _ => false,
        }
    }

    /// Fill, if there are no such items; else the nearest goes first.
    fn defer_to<'i>(&self, items: impl Iterator<Item = &'i Item>, point: &DomainPoint) -> Verdict {
        let from = point.from.map(f64::from_bits);
        let mut nearest: Option<(f64, &Item)> = None;
        for item in items {
            if item.is_refused {
                return Verdict::Bar;
            }
            let way = minus(&item.middle(), &from);
            let distance = dot(&way, &way);
            let is_nearer = |&(least, other): &(f64, &Item)| {
                (distance, item.marked.key) < (least, other.marked.key)
            };
            if nearest.as_ref().is_none_or(is_nearer) {
                nearest = Some((distance, item));
            }
        }
        nearest.map_or(Verdict::Fill, |(_, item)| Verdict::Defer(item.at, item.marked))
    }

    /// On a point that splits a subsegment of segment `s`: whatever else it would take out of the
    /// mesh goes first.
    fn on_segment(&self, point: &DomainPoint, s: u32) -> Verdict {
        let is_own = |item: &&Item| item.marked.key == point.item;
        if !self.items.iter().filter(is_own).any(|item| item.is_inner) {
            return Verdict::Useless;
        }
        let [_, a, b] = point.item;
        let mut taken = FxHashSet::from_iter([point.item]);
        for &f in self.complex.facets_of(s) {
            let at_item = |item: &&Item| {
                self.is_inner_of(item, f) && [a, b].iter().all(|v| item.marked.key.contains(v))
            };
            let start = self.items.iter().filter(at_item).collect();
            taken.extend(self.connected(start, f).iter().map(|item| item.marked.key));
        }
        self.spare(&taken, point)
    }

    /// On a point of facet `f` that splits a subface: subsegments that it encroaches go first, and
    /// whatever it would take out of the mesh of other facets.
    fn on_subface(&self, point: &DomainPoint, p: &Point, f: u32) -> Verdict {
        let hits = |item: &&Item| !item.is_subface() && self.encroaches(item, p);
        let first = self.defer_to(self.items.iter().filter(hits), point);
        if first != Verdict::Fill {
            return first;
        }
        let is_own = |item: &&Item| item.marked.key == point.item && self.is_inner_of(item, f);
        let faces = self.connected(self.items.iter().filter(is_own).collect(), f);
        if !faces.iter().any(|item| self.holds(item, p, f)) {
            let bars = |item: &&Item| {
                !item.is_subface() && faces.iter().any(|face| self.parts(item, face, p, f))
            };
            let verdict = self.defer_to(self.items.iter().filter(bars), point);
            return if verdict == Verdict::Fill { Verdict::Useless } else { verdict };
        }
        self.spare(&faces.iter().map(|item| item.marked.key).collect(), point)
    }

    /// Defers to what the point would take out of the mesh without putting something in its place.
    fn spare(&self, taken: &FxHashSet<ItemKey>, point: &DomainPoint) -> Verdict {
        let lost = |item: &&Item| item.is_inner && !taken.contains(&item.marked.key);
        self.defer_to(self.items.iter().filter(lost), point)
    }

    /// Is it a subface of facet `f` inside the cavity?
    fn is_inner_of(&self, item: &Item, f: u32) -> bool {
        item.is_subface() && item.is_inner && item.marked.of == f
    }

    /// The subfaces of facet `f` inside the cavity that are connected with some, but not across a
    /// subsegment.
    fn connected<'i>(&'i self, start: Vec<&'i Item>, f: u32) -> Vec<&'i Item> {
        let mut found = start;
        let mut keys: FxHashSet<ItemKey> = found.iter().map(|item| item.marked.key).collect();
        let mut next = 0;
        // Ends: each is found once.
        while let Some(&face) = found.get(next) {
            next += 1;
            for item in self.items.iter().filter(|item| self.is_inner_of(item, f)) {
                let common: Vec<VertexName> =
                    item.marked.key.into_iter().filter(|v| face.marked.key.contains(v)).collect();
                if let [a, b] = common[..]
                    && !self.segments.contains(&segment_key([a, b]))
                    && keys.insert(item.marked.key)
                {
                    found.push(item);
                }
            }
        }
        found
    }

    /// Does a subface of facet `f` hold `p` of its plane?
    fn holds(&self, item: &Item, p: &Point, f: u32) -> bool {
        let [a, b, c] = &item.corners[..] else { return false };
        let turns = [[a, b], [b, c], [c, a]].map(|[x, y]| self.complex.turn(f, [x, y, p]));
        !(turns.contains(&Ordering::Less) && turns.contains(&Ordering::Greater))
    }

    /// Is a subsegment a side of a subface of facet `f`, and `p` beyond it?
    fn parts(&self, segment: &Item, face: &Item, p: &Point, f: u32) -> bool {
        let key = &face.marked.key;
        if !segment.marked.key[1..].iter().all(|v| key.contains(v)) {
            return false;
        }
        let apex = key.iter().position(|v| !segment.marked.key.contains(v));
        let (Some(apex), [a, b]) = (apex, &segment.corners[..]) else { return false };
        let inside = self.complex.turn(f, [a, b, &face.corners[apex]]);
        self.complex.turn(f, [a, b, p]) == inside.reverse()
    }
}

/// The regions of the tetrahedra on the sides of a cavity; `None` if all are equal.
pub(super) fn regions(
    parts: &[(WorkerId, Vec<DomainPiece>)],
) -> Result<u32, FxHashMap<ItemKey, u32>> {
    let mut all = parts.iter().flat_map(|(_, pieces)| pieces).flat_map(|own| &own.regions);
    let first = all.next().copied().unwrap_or_default();
    if all.all(|&region| region == first) {
        return Ok(first);
    }
    let region = |own: &DomainPiece, k: usize| match own.regions[..] {
        [one] => one,
        _ => own.regions[k],
    };
    Err(sides(parts).map(|(v, own, k)| (subface_key(v), region(own, k))).collect())
}
