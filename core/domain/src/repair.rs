//! Repair of surfaces: what is done to every domain, and what `PrepareOptions::repair` asks for.
//!
//! Without a word from the user only such changes are made as leave the surface where it is, up to
//! one step of the lattice: vertices nearer to each other than a step become one, if no polygon has
//! both; facets without area are dropped, and their vertices put into the edges on which they lie;
//! facets that are there twice are kept once, and between two bodies become an inner facet. With a
//! tolerance, vertices within it become one, and vertices of open edges are put into the open edges
//! that they are near (the seam of a T-junction closes). Holes are filled where that is asked for,
//! up to a number of edges (`repair/fill.rs`). No body is united.
//!
//! Cost: about n log n; at most `NEIGHBOURS` near vertices of a vertex are looked at, and seams
//! are closed in at most `ROUNDS` rounds.

mod fill;
mod notes;

pub use fill::LONGEST_LOOP;

use crate::check::same_place;
use crate::triangulate::sorted;
use crate::vector::{distance2, dot, minus};
use crate::{CheckOptions, Domain, DomainError, DomainReport, Facet};
use ltbw_exact::Point;
use ltbw_exact::predicates::collinear;
use rayon::prelude::*;
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Near vertices that are looked at for each vertex.
const NEIGHBOURS: usize = 64;

/// Rounds in which seams are closed: an edge that got a vertex is two edges in the next one.
const ROUNDS: usize = 8;

/// A vertex and its place.
type Place = GeomWithData<Point, u32>;

/// The changes before the check. Numbers of facets and vertices are those of the input.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Repairs {
    /// Vertices at places of their own that became one with another.
    pub welded: usize,
    /// Welded vertices farther away than a step of the lattice: only a tolerance welds them.
    pub welded_by_tolerance: usize,
    /// The farthest that a vertex was from the one that it became.
    pub farthest_weld: f64,
    /// Facets without area that were dropped.
    pub degenerate: Vec<u32>,
    /// Vertices that were put into edges on which they lie exactly.
    pub spliced: usize,
    /// Facets that were dropped because an equal one, of the same orientation, is there.
    pub doubled: Vec<u32>,
    /// Facets that were dropped because an equal one, of the opposite orientation, is there. The
    /// one that was kept is an inner facet.
    pub inner: Vec<u32>,
    /// Vertices that were put into open edges near them, within the tolerance.
    pub seams: usize,
    /// The edges of each hole that was closed.
    pub filled: Vec<usize>,
    /// The triangles that closed them.
    pub filling: usize,
    /// Facets that were left out, both of each pair, because they were given from either side with
    /// nothing between.
    pub flaps: Vec<u32>,
    /// Facets that were left out because they end in the exterior.
    pub ends: Vec<u32>,
    /// Other facets that were left out because there is nothing but exterior around them.
    pub exterior: Vec<u32>,
    /// Segments that were left out for the same reason.
    pub exterior_segments: usize,
    /// Vertices outside that were left out because nothing names them, or nothing that was kept.
    pub exterior_vertices: usize,
    /// Points that were to be vertices and are outside.
    pub exterior_points: usize,
    /// Hole points that are outside without these facets.
    pub exterior_holes: usize,
}

/// A facet among equal ones.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Turned {
    facet: usize,
    /// As [`canonical`] says.
    turned: bool,
}

impl Repairs {
    /// Did anything change that the file's own coordinates do not say?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Did the tolerance change anything?
    #[must_use]
    pub fn used_tolerance(&self) -> bool {
        self.welded_by_tolerance > 0 || self.seams > 0
    }

    /// Counts a vertex that became one at this distance, which a tolerance did from `step` on.
    pub(crate) fn count_weld(&mut self, distance: f64, step: f64) {
        if distance > 0.0 {
            self.welded += 1;
            self.welded_by_tolerance += usize::from(distance >= step);
            self.farthest_weld = self.farthest_weld.max(distance);
        }
    }
}

/// The corners of a facet that is one polygon of three corners or more without holes.
fn simple(facet: &Facet) -> Option<&Vec<u32>> {
    match (facet.polygons.as_slice(), facet.holes.as_slice()) {
        ([polygon], []) if polygon.len() > 2 => Some(polygon),
        _ => None,
    }
}

fn edges(polygon: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..polygon.len()).map(|i| [polygon[i], polygon[(i + 1) % polygon.len()]])
}

/// For each vertex the one that it becomes: vertices at the same place; and vertices nearer to each
/// other than `step`, or within `tolerance`, which no facet and no segment both names.
pub(crate) fn weld(domain: &Domain, step: f64, tolerance: f64) -> Vec<u32> {
    let points = &domain.vertices;
    let count = points.len() as u32;
    let root = same_place(points).unwrap_or_else(|| (0..count).collect());
    let is_near = |d: f64| d < step * step || (tolerance > 0.0 && d <= tolerance * tolerance);
    let reach = step.max(tolerance);
    let distinct = (0..count).filter(|&v| root[v as usize] == v && reach > 0.0);
    let places: Vec<Place> = distinct.map(|v| GeomWithData::new(points[v as usize], v)).collect();
    let tree = RTree::bulk_load(places.clone());
    let near = |place: &Place| {
        let (own, v) = (*place.geom(), place.data);
        let near = tree.locate_within_distance(own, reach * reach).take(NEIGHBOURS);
        let near = near.map(|other| (distance2(&own, other.geom()), v, other.data));
        near.filter(|&(d, v, w)| v < w && is_near(d)).collect::<Vec<_>>()
    };
    let mut pairs: Vec<(f64, u32, u32)> = places.par_iter().flat_map_iter(near).collect();
    if pairs.is_empty() {
        return root;
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut clusters = Clusters::new(domain, root);
    for (_, a, b) in pairs {
        clusters.unite(a, b, is_near);
    }
    (0..count).map(|v| clusters.find(v)).collect()
}

/// Vertices that become one, with the polygons and segments that name any of them.
struct Clusters<'a> {
    points: &'a [Point],
    /// A vertex of the same cluster with a smaller number, or itself.
    root: Vec<u32>,
    /// Of each root: the polygons and segments, ascending.
    stars: Vec<Vec<u32>>,
}

impl<'a> Clusters<'a> {
    /// Vertices with the same root are one from the beginning.
    fn new(domain: &'a Domain, root: Vec<u32>) -> Self {
        let mut stars = vec![Vec::new(); root.len()];
        let polygons = domain.facets.iter().flat_map(|f| f.polygons.iter().map(Vec::as_slice));
        let segments = domain.segments.iter().map(|(ends, _)| ends.as_slice());
        for (number, corners) in (0..).zip(polygons.chain(segments)) {
            corners.iter().for_each(|&v| stars[root[v as usize] as usize].push(number));
        }
        stars.iter_mut().for_each(Vec::dedup);
        Self { points: &domain.vertices, root, stars }
    }

    fn find(&mut self, mut v: u32) -> u32 {
        // Halves the path: every turn goes to a smaller number.
        while self.root[v as usize] != v {
            self.root[v as usize] = self.root[self.root[v as usize] as usize];
            v = self.root[v as usize];
        }
        v
    }

    /// Makes the clusters of two vertices one, unless a polygon has corners in both or their first
    /// vertices are not near.
    fn unite(&mut self, a: u32, b: u32, is_near: impl Fn(f64) -> bool) {
        let (a, b) = (self.find(a), self.find(b));
        let (low, high) = (a.min(b), a.max(b));
        let distance = distance2(&self.points[low as usize], &self.points[high as usize]);
        if low == high || !is_near(distance) {
            return;
        }
        let (own, other) = (&self.stars[low as usize], &self.stars[high as usize]);
        if own.iter().any(|f| other.binary_search(f).is_ok()) {
            return;
        }
        let other = std::mem::take(&mut self.stars[high as usize]);
        let own = &mut self.stars[low as usize];
        own.extend(other);
        own.sort_unstable();
        self.root[high as usize] = low;
    }
}

/// A surface while it is repaired: for each facet the one of the input, and if it is an inner one
/// that which was given from the other side.
pub(crate) struct Surface {
    pub(crate) domain: Domain,
    pub(crate) origin: Vec<u32>,
    pub(crate) inner: Vec<Option<u32>>,
}

impl Surface {
    pub(crate) fn new(domain: Domain) -> Self {
        let count = domain.facets.len() as u32;
        Self { origin: (0..count).collect(), inner: vec![None; count as usize], domain }
    }

    /// The check of the surface.
    ///
    /// # Errors
    /// Those of [`Domain::check`].
    pub(crate) fn check(&self, options: &CheckOptions) -> Result<DomainReport, DomainError> {
        self.domain.check_with(options, &self.inner_facets())
    }

    /// Drops facets without area and doubled ones.
    pub(crate) fn clean(&mut self, repairs: &mut Repairs) {
        let dropped = self.drop_degenerate(repairs);
        self.splice(&dropped, repairs);
        self.drop_doubled(repairs);
    }

    fn retain(&mut self, keep: &[bool]) {
        fn kept<T>(list: &mut Vec<T>, keep: &[bool]) {
            let mut keep = keep.iter();
            list.retain(|_| keep.next().copied().unwrap_or(true));
        }
        kept(&mut self.domain.facets, keep);
        kept(&mut self.origin, keep);
        kept(&mut self.inner, keep);
    }

    /// Drops facets that are on a line; returns their vertices.
    fn drop_degenerate(&mut self, repairs: &mut Repairs) -> HashSet<u32> {
        let mut vertices = HashSet::new();
        let points = &self.domain.vertices;
        let mut keep = vec![true; self.domain.facets.len()];
        for (f, facet) in self.domain.facets.iter_mut().enumerate() {
            if simple(facet).is_none() {
                continue;
            }
            let polygon = &mut facet.polygons[0];
            polygon.dedup();
            // The last corner is before the first one.
            while polygon.len() > 1 && polygon.first() == polygon.last() {
                polygon.pop();
            }
            if is_on_a_line(points, polygon) {
                vertices.extend(polygon.iter().copied());
                keep[f] = false;
                repairs.degenerate.push(self.origin[f]);
            }
        }
        if !vertices.is_empty() {
            self.retain(&keep);
        }
        vertices
    }

    /// Puts vertices into the edges on which they lie exactly.
    fn splice(&mut self, vertices: &HashSet<u32>, repairs: &mut Repairs) {
        if vertices.is_empty() {
            return;
        }
        let points = &self.domain.vertices;
        let place = |&v: &u32| GeomWithData::new(points[v as usize], v);
        let tree: RTree<Place> = RTree::bulk_load(vertices.iter().map(place).collect());
        let within = |[a, b]: [u32; 2]| {
            let (p, q) = (&points[a as usize], &points[b as usize]);
            let on = tree.locate_in_envelope(AABB::from_corners(*p, *q)).filter(|place| {
                place.data != a && place.data != b && collinear(p, q, place.geom())
            });
            on.map(|place| place.data).collect::<Vec<u32>>()
        };
        for facet in &mut self.domain.facets {
            if simple(facet).is_some() {
                repairs.spliced += put_into_edges(points, &mut facet.polygons[0], &within);
            }
        }
    }

    /// Keeps one of equal facets. If as many are turned either way it is an inner one; otherwise it
    /// is turned as most are, and nothing lies between the pairs of others.
    fn drop_doubled(&mut self, repairs: &mut Repairs) {
        let mut first: HashMap<Vec<u32>, Turned> = HashMap::new();
        let mut more: BTreeMap<usize, Vec<Turned>> = BTreeMap::new();
        for (f, facet) in self.domain.facets.iter().enumerate() {
            let Some(polygon) = simple(facet) else { continue };
            let (key, turned) = canonical(polygon);
            let own = Turned { facet: f, turned };
            let &mut one = first.entry(key).or_insert(own);
            if one != own {
                more.entry(one.facet).or_insert_with(|| vec![one]).push(own);
            }
        }
        let mut keep = vec![true; self.domain.facets.len()];
        for equal in more.into_values() {
            self.keep_one(&equal, &mut keep, repairs);
        }
        for list in [&mut repairs.doubled, &mut repairs.inner, &mut repairs.flaps] {
            list.sort_unstable();
        }
        if keep.contains(&false) {
            self.retain(&keep);
        }
    }

    /// Keeps one of these equal facets, ascending.
    fn keep_one(&mut self, equal: &[Turned], keep: &mut [bool], repairs: &mut Repairs) {
        let turned = equal.iter().filter(|facet| facet.turned).count();
        let is_inner = 2 * turned == equal.len();
        let way = if is_inner { equal[0].turned } else { 2 * turned > equal.len() };
        let (same, other): (Vec<_>, Vec<_>) = equal.iter().partition(|facet| facet.turned == way);
        let origin = |list: &[Turned]| -> Vec<u32> {
            list.iter().map(|facet| self.origin[facet.facet]).collect()
        };
        let pairs = if is_inner { 0 } else { other.len() };
        repairs.flaps.extend(origin(&same[1..=pairs]));
        repairs.doubled.extend(origin(&same[1 + pairs..]));
        if is_inner { &mut repairs.inner } else { &mut repairs.flaps }.extend(origin(&other));
        let partner = is_inner.then(|| self.origin[other[0].facet]);
        let kept = same[0].facet;
        equal.iter().for_each(|equal| keep[equal.facet] = equal.facet == kept);
        self.inner[kept] = partner.or(self.inner[kept]);
    }

    /// Puts ends of open edges into open edges within the tolerance.
    pub(crate) fn close_seams(&mut self, tolerance: f64, repairs: &mut Repairs) {
        for _ in 0..ROUNDS {
            let before = repairs.seams;
            self.close_once(tolerance, repairs);
            if repairs.seams == before {
                return;
            }
            self.clean(repairs);
        }
    }

    fn close_once(&mut self, tolerance: f64, repairs: &mut Repairs) {
        let mut uses: HashMap<[u32; 2], u32> = HashMap::new();
        let polygons = || self.domain.facets.iter().flat_map(|f| &f.polygons);
        polygons().flat_map(|p| edges(p)).for_each(|e| *uses.entry(sorted(e)).or_default() += 1);
        uses.retain(|_, count| *count == 1);
        let ends: HashSet<u32> = uses.keys().flatten().copied().collect();
        let points = &self.domain.vertices;
        let place = |&v: &u32| GeomWithData::new(points[v as usize], v);
        let tree: RTree<Place> = RTree::bulk_load(ends.iter().map(place).collect());
        let within = |e: [u32; 2]| {
            if !uses.contains_key(&sorted(e)) {
                return Vec::new();
            }
            let [a, b] = e.map(|v| points[v as usize]);
            let low = [0, 1, 2].map(|k| a[k].min(b[k]) - tolerance);
            let high = [0, 1, 2].map(|k| a[k].max(b[k]) + tolerance);
            tree.locate_in_envelope(AABB::from_corners(low, high))
                .filter(|place| !e.contains(&place.data) && beside(place.geom(), &a, &b, tolerance))
                .map(|place| place.data)
                .collect()
        };
        for facet in &mut self.domain.facets {
            if simple(facet).is_some() {
                repairs.seams += put_into_edges(points, &mut facet.polygons[0], &within);
            }
        }
    }

    /// Cuts facets that are not planar, keeping track of where facets come from.
    pub(crate) fn flatten(&mut self) {
        let cut = self.domain.flatten();
        self.inner = cut.iter().map(|&f| self.inner[f as usize]).collect();
        self.origin = cut.iter().map(|&f| self.origin[f as usize]).collect();
    }

    /// The facets that are inner.
    fn inner_facets(&self) -> Vec<u32> {
        (0..).zip(&self.inner).filter(|(_, inner)| inner.is_some()).map(|(f, _)| f).collect()
    }
}

/// Is a point within the tolerance of the line segment, between its ends?
fn beside(p: &Point, a: &Point, b: &Point, tolerance: f64) -> bool {
    let (along, offset) = (minus(b, a), minus(p, a));
    let (length, place) = (dot(&along, &along), dot(&along, &offset));
    let foot = place / length;
    let gap = distance2(p, &[0, 1, 2].map(|k| a[k] + foot * along[k]));
    place > 0.0 && place < length && gap <= tolerance * tolerance
}

/// Puts into each edge of a polygon the vertices that `within` names for it, in their order along
/// the edge, but for corners that the polygon has; returns how many.
fn put_into_edges(
    points: &[Point],
    polygon: &mut Vec<u32>,
    within: &dyn Fn([u32; 2]) -> Vec<u32>,
) -> usize {
    let mut corners = Vec::with_capacity(polygon.len());
    for edge in edges(polygon) {
        let mut more = within(edge);
        more.retain(|v| !polygon.contains(v) && !corners.contains(v));
        let start = &points[edge[0] as usize];
        let along = |v: &u32| distance2(&points[*v as usize], start);
        more.sort_by(|v, w| along(v).total_cmp(&along(w)).then(v.cmp(w)));
        corners.push(edge[0]);
        corners.extend(more);
    }
    let added = corners.len() - polygon.len();
    *polygon = corners;
    added
}

/// Are all corners on a line?
fn is_on_a_line(points: &[Point], polygon: &[u32]) -> bool {
    let at = |v: u32| &points[v as usize];
    let Some((&a, rest)) = polygon.split_first() else { return true };
    let Some(&b) = rest.iter().find(|&&v| at(v) != at(a)) else { return true };
    rest.iter().all(|&c| collinear(at(a), at(b), at(c)))
}

/// The corners from the least one on, towards the smaller of its neighbours; and whether that is
/// against the polygon's direction.
fn canonical(polygon: &[u32]) -> (Vec<u32>, bool) {
    let n = polygon.len();
    let least = (0..n).min_by_key(|&i| polygon[i]).unwrap_or(0);
    let turned = polygon[(least + n - 1) % n] < polygon[(least + 1) % n];
    let at = |i: usize| polygon[if turned { least + n - i } else { least + i } % n];
    ((0..n).map(at).collect(), turned)
}
