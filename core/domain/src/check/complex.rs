//! A domain as triangles and free-standing edges, with an index over their boxes; vertices that
//! nothing names, which may lie anywhere.

use super::Findings;
use super::contact::sides_of;
use crate::triangulate::{self, Problem, Triangulated, edges, sorted};
use crate::{DefectKind, Domain, Element, Facet};
use ltbw_exact::Point;
use ltbw_exact::points::ascending;
use rayon::prelude::*;
use rstar::{AABB, RTreeObject};
use std::borrow::Cow;
use std::collections::HashMap;

/// A piece of a complex: its number, and the box around it.
///
/// Pieces are numbered triangles first, then edges.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) number: u32,
    pub(super) low: Point,
    pub(super) high: Point,
}

impl RTreeObject for Piece {
    type Envelope = AABB<Point>;

    fn envelope(&self) -> AABB<Point> {
        AABB::from_corners(self.low, self.high)
    }
}

impl Piece {
    fn of(number: u32, corners: &[&Point]) -> Self {
        let (mut low, mut high) = (*corners[0], *corners[0]);
        for p in corners {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        Self { number, low, high }
    }
}

/// The shape of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    Triangle([u32; 3]),
    Edge([u32; 2]),
}

/// A domain in pieces. Vertices of equal coordinates have one number here: the least.
pub(super) struct Complex<'a> {
    pub(super) points: &'a [Point],
    pub(super) triangles: Vec<[u32; 3]>,
    /// The facet of each triangle.
    pub(super) facet_of: Vec<u32>,
    /// Which sides of each triangle its facet draws, as sides of polygons; the others lie inside
    /// the facet, and that its triangles have them is chance.
    drawn: Vec<[bool; 3]>,
    /// The facets that are not planar, ascending.
    bent: Vec<u32>,
    /// Free-standing edges, and what they are part of.
    pub(super) loose: Vec<([u32; 2], Element)>,
    /// Vertices that nothing names.
    pub(super) unused: Vec<u32>,
    /// Edges of facets that have no triangles because something is wrong with them.
    pub(super) broken: Vec<[u32; 2]>,
}

impl<'a> Complex<'a> {
    /// Takes a domain apart, and tells what is wrong with single vertices, facets and segments.
    pub(super) fn new(domain: &'a Domain, findings: &mut Findings) -> Self {
        let points = domain.vertices.as_slice();
        let same = same_place(points);
        for (v, &kept) in (0..).zip(same.iter().flatten()).filter(|&(v, &kept)| v != kept) {
            let elements = vec![Element::Vertex(kept), Element::Vertex(v)];
            findings.add(DefectKind::DuplicateVertex, elements, vec![points[v as usize]]);
        }
        let map = |v: u32| same.as_ref().map_or(v, |s| s[v as usize]);
        let mut complex = Self {
            points,
            triangles: Vec::with_capacity(domain.facets.len()),
            facet_of: Vec::with_capacity(domain.facets.len()),
            drawn: Vec::with_capacity(domain.facets.len()),
            bent: Vec::new(),
            loose: Vec::new(),
            unused: unused(domain),
            broken: Vec::new(),
        };
        for &v in &complex.unused {
            let at = vec![points[v as usize]];
            findings.add(DefectKind::UnusedVertex, vec![Element::Vertex(v)], at);
        }
        // Equal vertices are reported once, as such.
        complex.unused.retain(|&v| map(v) == v);
        complex.add_facets(domain, &map, same.is_some(), findings);
        for (s, &(ends, _)) in (0..).zip(&domain.segments) {
            let ends = ends.map(map);
            if ends[0] == ends[1] {
                let at = vec![points[ends[0] as usize]];
                findings.add(DefectKind::Degenerate, vec![Element::Segment(s)], at);
            } else {
                complex.loose.push((ends, Element::Segment(s)));
            }
        }
        complex
    }

    fn add_facets(
        &mut self,
        domain: &Domain,
        map: &(impl Fn(u32) -> u32 + Sync),
        renamed: bool,
        findings: &mut Findings,
    ) {
        /// Facets that are held in triangles at once.
        const WAVE: usize = 1 << 16;
        for (wave, facets) in domain.facets.chunks(WAVE).enumerate() {
            let triangulated: Vec<(Triangulated, Vec<[bool; 3]>)> = facets
                .par_iter()
                .map(|facet| {
                    let mut facet = Cow::Borrowed(facet);
                    if renamed {
                        let corners = facet.to_mut().polygons.iter_mut().flatten();
                        corners.for_each(|v| *v = map(*v));
                    }
                    let found = triangulate::facet(self.points, &facet);
                    let drawn = drawn(&facet, &found.triangles);
                    (found, drawn)
                })
                .collect();
            for (i, (found, drawn)) in triangulated.into_iter().enumerate() {
                let number = (wave * WAVE + i) as u32;
                if !found.planar {
                    self.bent.push(number);
                    let at = domain.facets[number as usize].polygons.iter().flatten();
                    let at = at.take(4).map(|&v| self.points[v as usize]).collect();
                    findings.add(DefectKind::NonPlanar, vec![Element::Facet(number)], at);
                }
                for problem in &found.problems {
                    self.report(domain, number, *problem, findings);
                }
                if !found.is_sound() {
                    let polygons = &domain.facets[number as usize].polygons;
                    let broken = polygons.iter().flat_map(|p| edges(p));
                    self.broken.extend(broken.map(|e| e.map(map)));
                    continue;
                }
                self.facet_of.extend(found.triangles.iter().map(|_| number));
                self.triangles.extend(found.triangles);
                self.drawn.extend(drawn);
                let loose = found.loose.into_iter();
                self.loose.extend(loose.map(|e| (e, Element::Facet(number))));
            }
        }
    }

    /// Reports what is wrong with a facet by itself.
    fn report(&self, domain: &Domain, facet: u32, problem: Problem, findings: &mut Findings) {
        let points = self.points;
        let at = |vertices: &[u32]| vertices.iter().map(|&v| points[v as usize]).collect();
        let own = Element::Facet(facet);
        let polygons = &domain.facets[facet as usize].polygons;
        let hole = |h: u32| {
            let at = vec![domain.facets[facet as usize].holes[h as usize]];
            (vec![Element::FacetHole { facet, hole: h }], at)
        };
        let (kind, (elements, at)) = match problem {
            Problem::NoArea => {
                let corners: Vec<u32> = polygons.iter().flatten().copied().take(3).collect();
                (DefectKind::Degenerate, (vec![own], at(&corners)))
            }
            Problem::RepeatedVertex { polygon, vertex } => {
                let elements = vec![Element::Polygon { facet, polygon }, Element::Vertex(vertex)];
                (DefectKind::Degenerate, (elements, at(&[vertex])))
            }
            Problem::SamePlace(pair) => {
                let elements = [&[own][..], &pair.map(Element::Vertex)].concat();
                (DefectKind::Degenerate, (elements, at(&pair)))
            }
            Problem::VertexOnEdge { vertex, edge } => {
                let elements = vec![own, Element::Vertex(vertex), Element::Edge(edge)];
                (DefectKind::TJunction, (elements, at(&[vertex])))
            }
            Problem::Crossing(e, f) => {
                let elements = vec![own, Element::Edge(e), Element::Edge(f)];
                (DefectKind::Intersection, (elements, at(&[e[0], e[1], f[0], f[1]])))
            }
            Problem::HoleOutside(h) => (DefectKind::SeedOutside, hole(h)),
            Problem::HoleOnEdge(h) => (DefectKind::SeedOnFacet, hole(h)),
        };
        findings.add(kind, elements, at);
    }

    /// Reports the part of the surface that a triangle is in as one that could not be placed.
    pub(super) fn unresolved(&self, triangle: u32, findings: &mut Findings) {
        let n = triangle as usize;
        let at = self.triangles[n].map(|v| self.points[v as usize]).to_vec();
        findings.add(DefectKind::Unresolved, vec![Element::Facet(self.facet_of[n])], at);
    }

    /// Is a facet not planar?
    pub(super) fn is_bent(&self, facet: u32) -> bool {
        self.bent.binary_search(&facet).is_ok()
    }

    /// The number of pieces.
    pub(super) fn count(&self) -> usize {
        self.triangles.len() + self.loose.len()
    }

    /// A piece by its number.
    pub(super) fn shape(&self, number: u32) -> Shape {
        let number = number as usize;
        if let Some(&triangle) = self.triangles.get(number) {
            return Shape::Triangle(triangle);
        }
        Shape::Edge(self.loose[number - self.triangles.len()].0)
    }

    /// The element of the domain that a piece is part of.
    pub(super) fn element(&self, number: u32) -> Element {
        let n = number as usize;
        match self.shape(number) {
            Shape::Triangle(_) => Element::Facet(self.facet_of[n]),
            Shape::Edge(_) => self.loose[n - self.triangles.len()].1,
        }
    }

    /// Does the facet of a triangle draw this edge, if it is a side of the triangle?
    pub(super) fn draws(&self, triangle: u32, [a, b]: [u32; 2]) -> bool {
        let n = triangle as usize;
        let sides = sides_of(self.triangles[n]).into_iter().zip(self.drawn[n]);
        sides.into_iter().all(|(side, drawn)| drawn || (side != [a, b] && side != [b, a]))
    }

    /// The corners of a piece, and how many it has; the first one again where it has fewer.
    pub(super) fn corners(&self, number: u32) -> ([&Point; 3], usize) {
        let at = |v: u32| &self.points[v as usize];
        match self.shape(number) {
            Shape::Triangle(t) => (t.map(at), 3),
            Shape::Edge([a, b]) => ([a, b, a].map(at), 2),
        }
    }

    /// All pieces with their boxes.
    pub(super) fn pieces(&self) -> Vec<Piece> {
        let piece = |n: u32| Piece::of(n, &self.corners(n).0);
        (0..self.count() as u32).into_par_iter().map(piece).collect()
    }
}

/// Which sides of its triangles a facet draws.
fn drawn(facet: &Facet, triangles: &[[u32; 3]]) -> Vec<[bool; 3]> {
    if let [_] = triangles {
        return vec![[true; 3]];
    }
    let mut sides: Vec<[u32; 2]> =
        facet.polygons.iter().flat_map(|p| edges(p)).map(sorted).collect();
    sides.sort_unstable();
    let drawn = |side| sides.binary_search(&sorted(side)).is_ok();
    triangles.iter().map(|&t| sides_of(t).map(drawn)).collect()
}

/// For each vertex the least one with its coordinates; `None` if all are distinct.
pub(crate) fn same_place(points: &[Point]) -> Option<Vec<u32>> {
    let mut first: HashMap<[u64; 3], u32> = HashMap::with_capacity(points.len());
    let same: Vec<u32> =
        (0..).zip(points).map(|(v, p)| *first.entry(ascending(p)).or_insert(v)).collect();
    (first.len() < points.len()).then_some(same)
}

/// The vertices that nothing names.
fn unused(domain: &Domain) -> Vec<u32> {
    let mut used = vec![false; domain.vertices.len()];
    let corners = domain.facets.iter().flat_map(|f| f.polygons.iter().flatten());
    let ends = domain.segments.iter().flat_map(|(ends, _)| ends);
    corners.chain(ends).for_each(|&v| used[v as usize] = true);
    (0..).zip(used).filter(|&(_, used)| !used).map(|(v, _)| v).collect()
}
