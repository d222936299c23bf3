//! Points that are to be vertices of the mesh, [`Domain::points`]: those at the boundary are put on
//! it, exactly, and those outside are left out.
//!
//! A point within [`REACH`] steps of the lattice of a vertex is that vertex; else, of an edge of a
//! polygon or of a segment, on that; else, of a facet, on that. So whatever was on the boundary of
//! the input is on that of the domain on its lattice. A point that is exactly on a facet stays
//! where it is. Where a point comes to lie depends on the domain and on the point alone.
//!
//! Cost: a tree of edges and triangles, and one look at it for each point; one more check of the
//! domain for those inside.

use crate::exterior::LEFT_OUT;
use crate::repair::{Repairs, Surface};
use crate::straight::{Grid, Line, Plane, UNIT};
use crate::triangulate::{self, edges, sorted};
use crate::vector::{cross, distance2, dot, minus};
use crate::{CheckOptions, Domain, DomainError, Lattice};
use ltbw_exact::Point;
use ltbw_exact::points::ascending;
use ltbw_exact::predicates::cmp_xyz;
use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// Steps of the lattice within which a point is on the boundary: two for what rounding makes of a
/// point, and one for the move of what it is on.
pub const REACH: f64 = 3.0;

/// The part by which rounding may put a point out of a triangle.
const ROUNDING: f64 = 1e-9;

/// The points that are to be vertices, after the preparation of a domain.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Placed {
    /// For each point of the input its number in the mesh: that of a vertex of the domain, or from
    /// their number on that of one of [`Domain::points`]; [`LEFT_OUT`] if it is outside.
    pub map: Vec<u32>,
    /// Points on edges of polygons and on segments.
    pub on_edges: usize,
    /// Points on facets.
    pub on_facets: usize,
    /// Points at the place of a vertex, or of another point.
    pub doubled: usize,
    /// The farthest that a point at the boundary was moved.
    pub farthest: f64,
}

/// The place of a point at the boundary.
enum Spot {
    Vertex(u32),
    Edge(Point),
    Facet(Point),
}

/// An edge, or a triangle of a facet.
#[derive(Clone, Copy)]
enum Piece {
    Edge([u32; 2]),
    Triangle([u32; 3], u32),
}

/// The boundary of a domain, by place.
struct Pieces<'d> {
    domain: &'d Domain,
    tree: RTree<GeomWithData<Rectangle<Point>, Piece>>,
}

impl<'d> Pieces<'d> {
    fn of(domain: &'d Domain) -> Self {
        let at = |v: u32| domain.vertices[v as usize];
        let polygons = domain.facets.iter().flat_map(|f| &f.polygons);
        let sides = polygons.flat_map(|polygon| edges(polygon));
        let mut all: Vec<[u32; 2]> =
            sides.chain(domain.segments.iter().map(|(ends, _)| *ends)).map(sorted).collect();
        all.sort_unstable();
        all.dedup();
        let edge = |ends: [u32; 2]| {
            let [a, b] = ends.map(at);
            GeomWithData::new(Rectangle::from_corners(a, b), Piece::Edge(ends))
        };
        let triangles = |(number, facet): (u32, &crate::Facet)| {
            let found = triangulate::facet(&domain.vertices, facet);
            found.triangles.into_iter().map(move |corners| {
                let [a, b, c] = corners.map(at);
                let low = [0, 1, 2].map(|k| a[k].min(b[k]).min(c[k]));
                let high = [0, 1, 2].map(|k| a[k].max(b[k]).max(c[k]));
                let shape = Piece::Triangle(corners, number);
                GeomWithData::new(Rectangle::from_corners(low, high), shape)
            })
        };
        let pieces = all.into_iter().map(edge);
        let pieces = pieces.chain((0..).zip(&domain.facets).flat_map(triangles)).collect();
        Self { domain, tree: RTree::bulk_load(pieces) }
    }

    fn at(&self, v: u32) -> Point {
        self.domain.vertices[v as usize]
    }

    /// The pieces whose boxes come within `reach` of a point.
    fn near(&self, p: &Point, reach: f64) -> impl Iterator<Item = Piece> {
        let around = AABB::from_corners(p.map(|c| c - reach), p.map(|c| c + reach));
        self.tree.locate_in_envelope_intersecting(around).map(|piece| piece.data)
    }

    /// Is a point within `reach` of the boundary?
    fn is_at(&self, p: &Point, reach: f64) -> bool {
        self.near(p, reach).any(|piece| match piece {
            Piece::Edge(ends) => to_edge(p, ends.map(|v| self.at(v))).1 <= reach * reach,
            Piece::Triangle(corners, _) => {
                height_over(p, corners.map(|v| self.at(v))).is_some_and(|h| h <= reach)
            }
        })
    }

    /// The place at the boundary of a point within `reach` of it.
    fn spot(&self, lattice: &Lattice, p: &Point, reach: f64) -> Option<Spot> {
        let square = reach * reach;
        let (mut ends, mut edge, mut facet) = (None, None, None);
        for piece in self.near(p, reach) {
            match piece {
                Piece::Edge(own) => {
                    for v in own {
                        let at = self.at(v);
                        Nearby { square: distance2(p, &at), at, of: v }.keep(&mut ends);
                    }
                    let mut own = own.map(|v| self.at(v));
                    own.sort_by(cmp_xyz);
                    let (part, square) = to_edge(p, own);
                    Nearby { square, at: own[0], of: (own[1], part) }.keep(&mut edge);
                }
                Piece::Triangle(corners, f) => {
                    let height = height_over(p, corners.map(|v| self.at(v)));
                    let least_corner = self.corners(f).map(|v| self.at(v)).min_by(cmp_xyz);
                    if let (Some(height), Some(at)) = (height, least_corner) {
                        Nearby { square: height * height, at, of: f }.keep(&mut facet);
                    }
                }
            }
        }
        if let Some(end) = ends.filter(|own| own.square <= square) {
            return Some(Spot::Vertex(end.of));
        }
        let back = |p: Point| p.map(|c| c * lattice.fine_step());
        if let Some(Nearby { at: from, of: (to, part), .. }) =
            edge.filter(|own| own.square <= square)
        {
            let line = Line { from: lattice.steps(&from)?, to: lattice.steps(&to)? };
            let t = (part * UNIT as f64).round() as i64;
            return Some(Spot::Edge(back(line.point(t.clamp(1, UNIT - 1)))));
        }
        let f = facet.filter(|own| own.square <= square)?.of;
        let [origin, far, wide] = self.basis(lattice, f)?;
        let target = p.map(|c| c / lattice.fine_step());
        let plane = Plane::through(origin, far, wide);
        let at = if plane.holds(&target) { target } else { plane.near(&target, 0.0)? };
        Some(Spot::Facet(back(at)))
    }

    fn corners(&self, f: u32) -> impl Iterator<Item = u32> {
        self.domain.facets[f as usize].polygons.iter().flatten().copied()
    }

    /// Three corners of a facet far from each other, by their places alone.
    fn basis(&self, lattice: &Lattice, f: u32) -> Option<[Grid; 3]> {
        let all: Option<Vec<Grid>> = self.corners(f).map(|v| lattice.steps(&self.at(v))).collect();
        let all = all?;
        let &origin = all.iter().min()?;
        let from = |p: &Grid| [0, 1, 2].map(|k| (p[k] - origin[k]) as f64);
        let far = *all.iter().max_by(|a, b| {
            let [x, y] = [a, b].map(|p| dot(&from(p), &from(p)));
            x.total_cmp(&y).then(a.cmp(b))
        })?;
        let area = |p: &Grid| {
            let n = cross(&from(&far), &from(p));
            dot(&n, &n)
        };
        let wide = *all.iter().max_by(|a, b| area(a).total_cmp(&area(b)).then(a.cmp(b)))?;
        (area(&wide) > 0.0).then_some([origin, far, wide])
    }
}

/// Something near a point: its squared distance, and a place that tells it from others.
struct Nearby<T> {
    square: f64,
    at: Point,
    of: T,
}

impl<T> Nearby<T> {
    /// Keeps the nearer of two, of equally near ones that whose place comes first.
    fn keep(self, best: &mut Option<Self>) {
        let is_first = |other: &Self| {
            let by_distance = self.square.total_cmp(&other.square);
            by_distance.then_with(|| cmp_xyz(&self.at, &other.at)).is_lt()
        };
        if best.as_ref().is_none_or(is_first) {
            *best = Some(self);
        }
    }
}

/// The part of an edge at which it is nearest to a point, and the squared distance.
fn to_edge(p: &Point, [a, b]: [Point; 2]) -> (f64, f64) {
    let (along, to) = (minus(&b, &a), minus(p, &a));
    let square = dot(&along, &along);
    let part = if square > 0.0 { (dot(&along, &to) / square).clamp(0.0, 1.0) } else { 0.0 };
    let off = [0, 1, 2].map(|k| to[k] - part * along[k]);
    (part, dot(&off, &off))
}

/// The height of a point over a triangle, if it is over that.
fn height_over(p: &Point, [a, b, c]: [Point; 3]) -> Option<f64> {
    let (u, v, w) = (minus(&b, &a), minus(&c, &a), minus(p, &a));
    let n = cross(&u, &v);
    let square = dot(&n, &n);
    let parts = [dot(&cross(&w, &v), &n) / square, dot(&cross(&u, &w), &n) / square];
    let is_over =
        parts.iter().all(|part| *part >= -ROUNDING) && parts.iter().sum::<f64>() <= 1.0 + ROUNDING;
    is_over.then(|| dot(&w, &n).abs() / square.sqrt())
}

impl Domain {
    /// The domain with those vertices as points that nothing names and that are at its boundary,
    /// before its other points; and the numbers of these vertices, ascending. The structure has to
    /// be sound.
    pub(crate) fn part_spare(&self) -> (Cow<'_, Self>, Vec<u32>) {
        let mut is_named = vec![false; self.vertices.len()];
        self.named().for_each(|v| is_named[v as usize] = true);
        let lattice = Lattice::of(&self.near().0).ok().filter(|_| is_named.contains(&false));
        let Some(lattice) = lattice else { return (Cow::Borrowed(self), Vec::new()) };
        let (pieces, reach) = (Pieces::of(self), REACH * lattice.step());
        let spare = (0..self.vertices.len() as u32).into_par_iter();
        let spare = spare.filter(|&v| !is_named[v as usize] && pieces.is_at(&pieces.at(v), reach));
        let spare: Vec<u32> = spare.collect();
        if spare.is_empty() {
            return (Cow::Borrowed(self), spare);
        }
        let mut points: Vec<Point> = spare.iter().map(|&v| pieces.at(v)).collect();
        points.extend(&self.points);
        let without = self.clone().without_vertices(&spare).0;
        (Cow::Owned(Self { points, ..without }), spare)
    }
}

impl Surface {
    /// Puts the points of the domain, which is on its lattice, on its boundary where they are at
    /// it, and leaves those out that are outside.
    ///
    /// # Errors
    /// Those of [`Domain::check`].
    pub(crate) fn place_points(
        &mut self,
        lattice: &Lattice,
        checks: &CheckOptions,
        repairs: &mut Repairs,
    ) -> Result<Placed, DomainError> {
        let given = std::mem::take(&mut self.domain.points);
        let mut placed = Placed::default();
        if given.is_empty() {
            return Ok(placed);
        }
        let (pieces, reach) = (Pieces::of(&self.domain), REACH * lattice.step());
        let spots: Vec<Option<Spot>> =
            given.par_iter().map(|p| pieces.spot(lattice, p, reach)).collect();
        let free: Vec<Point> =
            spots.iter().zip(&given).filter(|s| s.0.is_none()).map(|s| *s.1).collect();
        let outside = self.outside(free, checks)?;
        let first = self.domain.vertices.len() as u32;
        let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
        for (spot, p) in spots.into_iter().zip(given) {
            let at = match spot {
                Some(Spot::Vertex(v)) => {
                    placed.doubled += 1;
                    placed.map.push(v);
                    continue;
                }
                Some(Spot::Edge(at) | Spot::Facet(at)) => at,
                None if outside.contains(&ascending(&p)) => {
                    repairs.exterior_points += 1;
                    placed.map.push(LEFT_OUT);
                    continue;
                }
                None => p,
            };
            let next = first + self.domain.points.len() as u32;
            let &mut number = numbers.entry(ascending(&at)).or_insert(next);
            placed.map.push(number);
            if number != next {
                placed.doubled += 1;
                continue;
            }
            match spot {
                Some(Spot::Edge(_)) => placed.on_edges += 1,
                Some(Spot::Facet(_)) => placed.on_facets += 1,
                _ => {}
            }
            placed.farthest = placed.farthest.max(distance2(&p, &at).sqrt());
            self.domain.points.push(at);
        }
        Ok(placed)
    }

    /// The points among some, which are not at the boundary, that are outside.
    fn outside(
        &mut self,
        mut free: Vec<Point>,
        checks: &CheckOptions,
    ) -> Result<HashSet<[u64; 3]>, DomainError> {
        let (low, high) = self.domain.bounds().unwrap_or_default();
        let is_in_box = |p: &Point| (0..3).all(|k| low[k] <= p[k] && p[k] <= high[k]);
        let mut outside: HashSet<[u64; 3]> =
            free.iter().filter(|p| !is_in_box(p)).map(ascending).collect();
        free.retain(is_in_box);
        if free.is_empty() {
            return Ok(outside);
        }
        let count = self.domain.vertices.len();
        self.domain.vertices.append(&mut free);
        let report = self.check(checks);
        let all = self.domain.vertices.split_off(count);
        let outer = report?.exterior.vertices.into_iter().map(|v| v as usize);
        outside.extend(outer.filter_map(|v| Some(ascending(all.get(v.checked_sub(count)?)?))));
        Ok(outside)
    }
}
