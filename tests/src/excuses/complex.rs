//! A domain as features: facets that are one plane, and the edges between them.
//!
//! Facets of one marker are one across an edge of exactly two polygons that is not drawn, as long
//! as all their corners are within the tolerance of one plane: that of the largest, fitted anew
//! while the set grows. The counter finds them by itself, in rounded numbers, from what
//! `docs/refinement.md` says of patches; it asks neither refinement nor the checker.

use super::unit;
use ltbw::Point;
use ltbw::domain::vector::{cross, dot, minus};
use ltbw::domain::{Domain, Facet};
use std::collections::{BTreeMap, BTreeSet};

/// A plane is fitted as many times at most.
const FITS: usize = 8;
/// The part of the diagonal within which a plane is exact.
const EXACT: f64 = 1.0 / (1u64 << 40) as f64;

/// An edge, its ends ascending.
fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Facets as groups of one plane each, segments, triangles.
pub(super) struct Complex<'a> {
    domain: &'a Domain,
    /// Corners, and the group that the triangle is part of.
    pub(super) triangles: Vec<([u32; 3], u32)>,
    /// Per group the unit normal.
    pub(super) normals: Vec<Point>,
    /// The edges that are no inside of a group.
    pub(super) segments: BTreeSet<[u32; 2]>,
    /// Per edge of triangles: the group and the third corner of each.
    around: BTreeMap<[u32; 2], Vec<(u32, u32)>>,
}

/// The uses of an edge of the domain.
#[derive(Default)]
struct Uses {
    /// The facets of the polygons along it, and the directions in which these run.
    facets: Vec<(u32, bool)>,
    drawn: bool,
}

impl<'a> Complex<'a> {
    pub(super) fn of(domain: &'a Domain, tolerance: f64) -> Self {
        let mut uses: BTreeMap<[u32; 2], Uses> = BTreeMap::new();
        for (f, facet) in (0..).zip(&domain.facets) {
            for polygon in &facet.polygons {
                for (k, &a) in polygon.iter().enumerate() {
                    let b = polygon[(k + 1) % polygon.len()];
                    let entry = uses.entry(edge(a, b)).or_default();
                    match polygon.len() {
                        2 => entry.drawn = true,
                        _ => entry.facets.push((f, a < b)),
                    }
                }
            }
        }
        for &([a, b], _) in &domain.segments {
            uses.entry(edge(a, b)).or_default().drawn = true;
        }
        let cut = |f: u32| domain.triangulate(f).map(|found| found.triangles).unwrap_or_default();
        let triangles: Vec<Vec<[u32; 3]>> = (0..domain.facets.len() as u32).map(cut).collect();
        let growth = Growth::of(domain, tolerance, &uses, &triangles);
        let (of, normals) = growth.groups();
        let is_inner = |uses: &Uses| match uses.facets[..] {
            [(f, _), (g, _)] => !uses.drawn && of[f as usize] == of[g as usize],
            _ => false,
        };
        let segments = uses.iter().filter(|(_, uses)| !is_inner(uses)).map(|(e, _)| *e).collect();
        let groups = of.iter().zip(triangles);
        let triangles: Vec<([u32; 3], u32)> =
            groups.flat_map(|(&g, all)| all.into_iter().map(move |t| (t, g))).collect();
        let mut around: BTreeMap<[u32; 2], Vec<(u32, u32)>> = BTreeMap::new();
        for &([a, b, c], group) in &triangles {
            for ([p, q], third) in [([a, b], c), ([b, c], a), ([c, a], b)] {
                around.entry(edge(p, q)).or_default().push((group, third));
            }
        }
        Self { domain, triangles, normals, segments, around }
    }

    pub(super) fn at(&self, v: u32) -> &Point {
        &self.domain.vertices[v as usize]
    }

    /// The group and the third corner of every triangle at an edge.
    pub(super) fn beside(&self, ends: [u32; 2]) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.around.get(&ends).into_iter().flatten().copied()
    }
}

/// The growth of groups over edges.
struct Growth<'a> {
    domain: &'a Domain,
    uses: &'a BTreeMap<[u32; 2], Uses>,
    /// Per facet its normal, as long as twice its area.
    normals: Vec<Point>,
    /// Per facet the distance from a plane that it may have.
    tolerances: Vec<f64>,
    /// The least of these, within which there is no telling.
    exact: f64,
}

impl<'a> Growth<'a> {
    fn of(
        domain: &'a Domain,
        tolerance: f64,
        uses: &'a BTreeMap<[u32; 2], Uses>,
        triangles: &[Vec<[u32; 3]>],
    ) -> Self {
        let at = |v: u32| &domain.vertices[v as usize];
        let normal = |all: &Vec<[u32; 3]>| {
            all.iter().fold([0.0; 3], |sum, &[a, b, c]| {
                let own = cross(&minus(at(b), at(a)), &minus(at(c), at(a)));
                [0, 1, 2].map(|k| sum[k] + own[k])
            })
        };
        let (low, high) = domain.bounds().unwrap_or_default();
        let diagonal = minus(&high, &low);
        let exact = EXACT * dot(&diagonal, &diagonal).sqrt();
        let open = open_facets(domain, uses);
        let own = |(facet, open): (&Facet, bool)| {
            let is_plain = facet.polygons.len() == 1 && facet.holes.is_empty();
            if is_plain && !open { tolerance.max(exact) } else { exact }
        };
        let tolerances = domain.facets.iter().zip(open).map(own).collect();
        let normals = triangles.iter().map(normal).collect();
        Self { domain, uses, normals, tolerances, exact }
    }

    /// Per facet its group, and per group the unit normal of its plane.
    fn groups(&self) -> (Vec<u32>, Vec<Point>) {
        let mut of = vec![u32::MAX; self.normals.len()];
        let mut normals: Vec<Point> = Vec::new();
        let mut order: Vec<usize> = (0..of.len()).collect();
        let area = |&f: &usize| dot(&self.normals[f], &self.normals[f]);
        order.sort_by(|f, g| area(g).total_cmp(&area(f)));
        for first in order {
            if of[first] != u32::MAX {
                continue;
            }
            let mut normal = unit(&self.normals[first]);
            let mut list = self.spread(first, &normal, &of);
            for _ in 0..FITS {
                let sum = list.iter().fold([0.0; 3], |sum, &(f, sign)| {
                    [0, 1, 2].map(|k| sum[k] + sign * self.normals[f][k])
                });
                let fitted = unit(&sum);
                let larger = self.spread(first, &fitted, &of);
                if larger.len() <= list.len() {
                    break;
                }
                (normal, list) = (fitted, larger);
            }
            list.iter().for_each(|&(f, _)| of[f] = normals.len() as u32);
            of[first] = normals.len() as u32;
            normals.push(normal);
        }
        (of, normals)
    }

    /// The facets that belong to the plane of the first one with this normal, each with 1 or, if
    /// its normal points to the other side, -1.
    fn spread(&self, first: usize, normal: &Point, of: &[u32]) -> Vec<(usize, f64)> {
        let corners = |f: usize| self.domain.facets[f].polygons.iter().flatten();
        let origin = corners(first).next().map(|&v| self.domain.vertices[v as usize]);
        let origin = origin.unwrap_or_default();
        let mut list = vec![(first, 1.0)];
        let mut seen: BTreeSet<usize> = [first].into();
        let mut next = 0;
        // Breadth first; each facet enters once.
        while let Some(&(f, sign)) = list.get(next) {
            next += 1;
            for (g, is_turned) in self.beside(f) {
                let tolerance = self.tolerances[g].min(self.tolerances[first]);
                let height =
                    |v: &u32| dot(normal, &minus(&self.domain.vertices[*v as usize], &origin));
                let sign = if is_turned { -sign } else { sign };
                let fits = corners(g).all(|v| height(v).abs() <= tolerance)
                    && self.faces(g, &self.normals[g].map(|c| sign * c), normal, tolerance);
                if of[g] == u32::MAX && fits && seen.insert(g) {
                    list.push((g, sign));
                }
            }
        }
        list
    }

    /// Does a facet within `tolerance` of a plane face the same way: within 60 degrees, or if it is
    /// a needle lower than that, not turned over? In the plane itself either way will do.
    fn faces(&self, f: usize, own: &Point, normal: &Point, tolerance: f64) -> bool {
        if tolerance <= self.exact {
            return true;
        }
        let larger = |a: usize, b: usize| if normal[b].abs() > normal[a].abs() { b } else { a };
        let axis = larger(larger(0, 1), 2);
        let length = dot(own, own).sqrt();
        let sides = self.domain.facets[f].polygons.iter().flat_map(|ring| {
            let next = ring.iter().cycle().skip(1);
            ring.iter().zip(next).map(|(&a, &b)| {
                let side =
                    minus(&self.domain.vertices[b as usize], &self.domain.vertices[a as usize]);
                dot(&side, &side).sqrt()
            })
        });
        let is_needle = length <= tolerance * sides.fold(0.0, f64::max);
        own[axis] * normal[axis] > 0.0 && (is_needle || dot(own, normal) >= length / 2.0)
    }

    /// The facets across the edges of a facet where a surface may continue, and whether they run
    /// along the edge as the facet itself does.
    fn beside(&self, f: usize) -> impl Iterator<Item = (usize, bool)> + '_ {
        let rings = self.domain.facets[f].polygons.iter().filter(|ring| ring.len() > 2);
        let sides = rings.flat_map(|ring| {
            ring.iter().zip(ring.iter().cycle().skip(1)).map(|(&a, &b)| edge(a, b))
        });
        sides.filter_map(move |side| {
            let uses = self.uses.get(&side).filter(|uses| !uses.drawn)?;
            let [(a, way), (b, other)] = uses.facets[..] else { return None };
            let marker = |f: u32| self.domain.facets[f as usize].marker;
            let across = if a as usize == f { b } else { a };
            (a != b && marker(a) == marker(b)).then_some((across as usize, way == other))
        })
    }
}

/// Per facet: do edges connect it to one of an odd number of polygons?
fn open_facets(domain: &Domain, uses: &BTreeMap<[u32; 2], Uses>) -> Vec<bool> {
    let mut open = vec![false; domain.facets.len()];
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); open.len()];
    let mut stack = Vec::new();
    for uses in uses.values().map(|uses| &uses.facets) {
        for pair in uses.windows(2) {
            beside[pair[0].0 as usize].push(pair[1].0);
            beside[pair[1].0 as usize].push(pair[0].0);
        }
        if uses.len() % 2 == 1 {
            stack.extend(uses.iter().map(|(f, _)| *f));
        }
    }
    // Every facet is spread from once.
    while let Some(f) = stack.pop() {
        if !std::mem::replace(&mut open[f as usize], true) {
            stack.extend(&beside[f as usize]);
        }
    }
    open
}
