//! Simplification: vertices of a surface are put onto neighbours, within a tolerance.
//!
//! Edges are collapsed onto one of their ends, the shortest first, so every vertex that is left is
//! one of the input. An edge is collapsed only if all of this holds:
//!
//! * **Topology.** The vertex that goes has one closed fan of triangles, or it is on a line of
//!   edges that are features (open, of more than two triangles, between markers, sharp) and goes
//!   along it. The two ends have no common neighbours but by triangles of their edge. Vertices of
//!   segments, and of facets that are no triangles, stay.
//! * **Nothing is crossed** (`space.rs`), exactly: the new triangles touch nothing, and the
//!   tetrahedra that are swept hold nothing.
//! * **Distance** (`fan.rs`): every point of the first surface is within the tolerance of this one,
//!   and every point of this one of the first. Each triangle keeps a bound for either way; those of
//!   a new triangle are the largest of the old ones that it has strips of, and how far these are.
//! * **Shape.** No new triangle leans away from the fan, or is worse than what was there, unless it
//!   is good.
//!
//! Vertices are numbered by coordinates and sums are taken in the order of fans, so that the result
//! is a function of the surface, whatever the order of its facets. Cost: n log n.

mod fan;
mod space;
mod surface;

use crate::triangulate;
use crate::vector::{distance2, dot};
use crate::{Domain, Facet};
use fan::{Fan, SLACK, normal};
use ltbw_exact::Point;
use ltbw_exact::predicates::{cmp_xyz, collinear};
use space::Space;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use surface::{Sector, Star, Surface};

/// The largest tolerance within which the surface of a domain may be simplified: 5 % of the
/// diagonal.
#[must_use]
pub fn largest_simplification(domain: &Domain) -> f64 {
    0.05 * domain.diagonal()
}

/// Height to longest side of a triangle that is good.
const GOOD: f64 = 0.25;

/// The cosine of the angle by which a new triangle may lean away from its fan.
const LEAN: f64 = 0.5;

/// The figures of a surface that was simplified.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Simplified {
    /// The tolerance that was asked for.
    pub tolerance: f64,
    /// Vertices that went.
    pub removed: usize,
    /// Triangles before and after; facets that are no triangles are not counted.
    pub triangles: [usize; 2],
    /// No point of the surface before is farther from that after.
    pub from_before: f64,
    /// No point of the surface after is farther from that before.
    pub from_after: f64,
}

impl Simplified {
    /// The bound on the distance of the two surfaces, the larger of both ways.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.from_before.max(self.from_after)
    }

    /// A line for people.
    #[must_use]
    pub fn note(&self) -> String {
        let [before, after] = self.triangles;
        format!(
            "{before} triangles became {after}, {} vertices less; the surfaces are at most {:.3e} \
             apart ({:.3e} from the first one, {:.3e} from the last)",
            self.removed,
            self.distance(),
            self.from_before,
            self.from_after
        )
    }
}

/// A domain whose surface was simplified.
#[derive(Clone, Debug)]
pub struct SimplifiedDomain {
    /// The domain.
    pub domain: Domain,
    /// The changes of its surface.
    pub told: Simplified,
}

/// A prepared domain with its surface simplified within a tolerance: what
/// [`crate::PrepareOptions::simplify`] would lead to, but for the check.
#[must_use]
pub fn simplified(domain: &Domain, tolerance: f64) -> SimplifiedDomain {
    let Simpler { domain, told, .. } = simplify(domain, tolerance, false);
    SimplifiedDomain { domain, told }
}

/// A domain of which the surface is simplified.
pub(crate) struct Simpler {
    pub(crate) domain: Domain,
    pub(crate) told: Simplified,
    /// For each vertex its new number, or that it is gone.
    pub(crate) vertices: Vec<Option<u32>>,
    /// For each facet the one that it was, or was part of.
    pub(crate) facets: Vec<u32>,
}

/// Simplifies the surface of a domain in which nothing crosses; polygons of more than three corners
/// are cut into triangles if `cut`.
pub(crate) fn simplify(domain: &Domain, tolerance: f64, cut: bool) -> Simpler {
    let (mut simplifier, rank, facets) = Simplifier::new(domain, tolerance, cut);
    let before = simplifier.surface.triangles.len();
    while simplifier.pass() {}
    let surface = &simplifier.surface;
    let alive = || (0..surface.triangles.len()).filter(|&t| !surface.is_gone(t as u32));
    let far = |way: usize| alive().map(|t| surface.bounds[t][way]).fold(0.0, f64::max);
    let mut told = Simplified {
        tolerance,
        removed: 0,
        triangles: [before, alive().count()],
        from_before: far(0),
        from_after: far(1),
    };
    let mut vertices = Vec::with_capacity(rank.len());
    let mut left = Domain { vertices: Vec::new(), facets: Vec::new(), ..domain.clone() };
    for (p, &v) in domain.vertices.iter().zip(&rank) {
        let is_gone = simplifier.gone[v as usize];
        told.removed += usize::from(is_gone);
        vertices.push((!is_gone).then_some(left.vertices.len() as u32));
        if !is_gone {
            left.vertices.push(*p);
        }
    }
    let mut of_rank = vec![u32::MAX; rank.len()];
    for (number, &v) in vertices.iter().zip(&rank) {
        of_rank[v as usize] = number.unwrap_or(u32::MAX);
    }
    let number = |v: &mut u32| *v = of_rank[rank[*v as usize] as usize];
    let mut origin = Vec::new();
    for (f, own) in (0..).zip(facets) {
        match own {
            None => {
                let mut facet = domain.facets[f as usize].clone();
                facet.polygons.iter_mut().flatten().for_each(number);
                left.facets.push(facet);
                origin.push(f);
            }
            Some(triangles) => {
                for t in triangles.filter(|&t| !surface.is_gone(t)) {
                    let corners = surface.triangles[t as usize].map(|v| of_rank[v as usize]);
                    left.facets.push(Facet::polygon(&corners, surface.markers[t as usize]));
                    origin.push(f);
                }
            }
        }
    }
    left.segments.iter_mut().flat_map(|(ends, _)| ends).for_each(number);
    Simpler { domain: left, told, vertices, facets: origin }
}

/// The triangles that a facet is cut into.
type Own = Option<std::ops::Range<u32>>;

/// A surface on the way.
struct Simplifier {
    surface: Surface,
    space: Space,
    gone: Vec<bool>,
    slack: f64,
}

/// A collapse that keeps topology, shape and distance.
struct Plan {
    star: Star,
    from: u32,
    onto: u32,
    /// The bounds of each triangle that is changed.
    bounds: Vec<(u32, [f64; 2])>,
    /// The largest of them.
    worst: f64,
}

impl Simplifier {
    /// Takes a domain apart; also the number of each vertex, and the triangles of each facet that
    /// is cut into such.
    fn new(domain: &Domain, tolerance: f64, cut: bool) -> (Self, Vec<u32>, Vec<Own>) {
        let mut order: Vec<u32> = (0..domain.vertices.len() as u32).collect();
        order.sort_by(|&v, &w| {
            let at = |v: u32| &domain.vertices[v as usize];
            cmp_xyz(at(v), at(w)).then(v.cmp(&w))
        });
        let mut rank = vec![0; order.len()];
        (0..).zip(&order).for_each(|(number, &v)| rank[v as usize] = number);
        let points: Vec<Point> = order.iter().map(|&v| domain.vertices[v as usize]).collect();
        let numbered = |[a, b]: [u32; 2]| [rank[a as usize], rank[b as usize]];
        let (mut triangles, mut markers, mut facets) = (Vec::new(), Vec::new(), Vec::new());
        let (mut kept, mut edges): (Vec<[u32; 3]>, Vec<[u32; 2]>) = Default::default();
        for facet in &domain.facets {
            let found = triangulate::facet(&domain.vertices, facet);
            let is_polygon = facet.polygons.len() == 1 && facet.holes.is_empty();
            let own = found.triangles.iter().map(|t| t.map(|v| rank[v as usize]));
            if is_polygon && found.is_sound() && (cut || facet.polygons[0].len() == 3) {
                let first = triangles.len() as u32;
                triangles.extend(own);
                markers.resize(triangles.len(), facet.marker);
                facets.push(Some(first..triangles.len() as u32));
            } else {
                kept.extend(own);
                let sides = facet.polygons.iter().flat_map(|p| triangulate::edges(p));
                edges.extend(sides.map(numbered));
                facets.push(None);
            }
        }
        let sides = edges.len();
        edges.extend(domain.segments.iter().map(|(ends, _)| numbered(*ends)));
        let mut stars = vec![Vec::new(); points.len()];
        for (t, corners) in (0..).zip(&triangles) {
            corners.iter().for_each(|&v: &u32| stars[v as usize].push(t));
        }
        let mut beside = vec![Vec::new(); points.len()];
        for &[a, b] in &edges {
            beside[a as usize].push(b);
            beside[b as usize].push(a);
        }
        let largest = points.iter().flatten().fold(0.0, |most: f64, c| most.max(c.abs()));
        let seeds = domain.holes.iter().copied().chain(domain.regions.iter().map(|r| r.seed));
        let bounds = vec![[0.0; 2]; triangles.len()];
        let surface =
            Surface { points, triangles, markers, bounds, stars, beside, most: tolerance };
        let space = Space::new(&surface, &kept, &edges[sides..], seeds.collect());
        let gone = vec![false; rank.len()];
        (Self { surface, space, gone, slack: SLACK * largest }, rank, facets)
    }

    /// Goes once through all edges, the shortest first; did any collapse?
    fn pass(&mut self) -> bool {
        let mut queue = BinaryHeap::new();
        for &corners in &self.surface.triangles {
            if corners[0] != u32::MAX {
                let [a, b, c] = corners;
                for [v, w] in [[a, b], [b, c], [c, a]] {
                    queue.push(self.queued(v, w));
                }
            }
        }
        let (mut any, mut last) = (false, None);
        while let Some(edge) = queue.pop() {
            // Each edge is there once for each of its triangles.
            if last == Some(edge) {
                continue;
            }
            last = Some(edge);
            let Reverse((_, v, w)) = edge;
            if self.gone[v as usize] || self.gone[w as usize] || !self.surface.are_neighbours(v, w)
            {
                continue;
            }
            let mut plans: Vec<Plan> =
                [self.plan(v, w), self.plan(w, v)].into_iter().flatten().collect();
            plans.sort_by(|a, b| a.worst.total_cmp(&b.worst));
            let free = plans
                .into_iter()
                .find(|plan| self.space.is_free(&self.surface, &plan.star, plan.from, plan.onto));
            let Some(plan) = free else { continue };
            any = true;
            self.carry_out(&plan);
            let onto = plan.onto;
            let star = self.surface.stars[onto as usize].iter();
            let around: Vec<u32> = star.flat_map(|&t| self.surface.opposite(t, onto)).collect();
            queue.extend(around.iter().map(|&u| self.queued(onto, u)));
        }
        any
    }

    fn queued(&self, v: u32, w: u32) -> Reverse<(u64, u32, u32)> {
        // Of numbers that are not negative the bits have their order.
        let length = distance2(self.surface.at(v), self.surface.at(w));
        Reverse((length.to_bits(), v.min(w), v.max(w)))
    }

    fn carry_out(&mut self, plan: &Plan) {
        let triangles = plan.star.sectors.iter().flat_map(|s| s.triangles.iter().copied());
        self.space.take(&self.surface, triangles.clone());
        self.surface.collapse(plan.from, plan.onto);
        self.gone[plan.from as usize] = true;
        for &(t, bounds) in &plan.bounds {
            self.surface.bounds[t as usize] = bounds;
        }
        self.space.put(&self.surface, triangles.filter(|&t| !self.surface.is_gone(t)));
    }

    /// The collapse of an edge onto `onto`, if it keeps topology, shape and distance.
    fn plan(&self, from: u32, onto: u32) -> Option<Plan> {
        let mut star = self.surface.star(from)?;
        if star.along.is_some_and(|ends| !ends.contains(&onto)) {
            return None;
        }
        star.sectors.iter_mut().for_each(|sector| sector.start_at(onto));
        if !self.links(&star, from, onto) {
            return None;
        }
        let (mut bounds, mut worst) = (Vec::new(), 0.0_f64);
        for sector in &star.sectors {
            let ring: Vec<Point> = sector.ring.iter().map(|&u| *self.surface.at(u)).collect();
            let old: Vec<[f64; 2]> =
                sector.triangles.iter().map(|&t| self.surface.bounds[t as usize]).collect();
            let fan = Fan {
                old: *self.surface.at(from),
                ring: &ring,
                closed: sector.closed,
                bounds: &old,
                slack: self.slack,
            };
            if ring.len() < 3 || !is_well_shaped(&fan) {
                return None;
            }
            let moved = fan.moved(self.surface.most)?;
            worst = moved.iter().flatten().fold(worst, |worst, &far| worst.max(far));
            bounds.extend(sector.triangles[1..].iter().copied().zip(moved));
        }
        Some(Plan { star, from, onto, bounds, worst })
    }

    /// Does the collapse keep the topology: are the neighbours that both ends have those of their
    /// triangles, is no new triangle there already, and no new edge inside a facet?
    fn links(&self, star: &Star, from: u32, onto: u32) -> bool {
        let surface = &self.surface;
        let stays = |u: u32| !surface.beside[u as usize].is_empty();
        let may_meet = |sector: &Sector, k: usize| {
            let (u, last) = (sector.ring[k], sector.closed && k + 1 == sector.ring.len());
            let meet = surface.are_neighbours(onto, u) || (stays(onto) && stays(u));
            // The first and the last of a ring are corners of triangles that go.
            k == 1 || last || !meet
        };
        star.sectors.iter().all(|sector| (1..sector.ring.len()).all(|k| may_meet(sector, k)))
            && !surface.stars[onto as usize].iter().any(|&t| {
                let sides = surface.opposite(t, onto);
                let both = |s: &Sector| sides.iter().all(|u| s.ring[1..].contains(u));
                !surface.triangles[t as usize].contains(&from) && star.sectors.iter().any(both)
            })
    }
}

impl Sector {
    /// Turns the ring so that it starts at a corner, towards the lesser of its neighbours there.
    fn start_at(&mut self, first: u32) {
        let count = self.ring.len();
        if self.closed {
            let place = self.ring.iter().position(|&u| u == first).unwrap_or(0);
            self.ring.rotate_left(place);
            self.triangles.rotate_left(place);
            if self.ring[1] > self.ring[count - 1] {
                self.ring[1..].reverse();
                self.triangles.reverse();
            }
        } else if self.ring[0] != first {
            self.ring.reverse();
            self.triangles.reverse();
        }
    }
}

/// Are the new triangles of a fan good, or no worse than the old ones, and do they lean little?
fn is_well_shaped(fan: &Fan<'_>) -> bool {
    let worst = |triangles: &mut dyn Iterator<Item = [&Point; 3]>| {
        triangles.map(shape).fold(f64::INFINITY, f64::min)
    };
    let up = fan.normal();
    let leans = |triangle: [&Point; 3]| {
        let n = normal(triangle);
        let along = dot(&n, &up);
        !(along > 0.0 && along * along >= LEAN * LEAN * dot(&n, &n) * dot(&up, &up))
    };
    if fan.new_triangles().any(|t| leans(t) || collinear(t[0], t[1], t[2])) {
        return false;
    }
    let new = worst(&mut fan.new_triangles());
    new >= GOOD * GOOD || new >= worst(&mut fan.old_triangles())
}

/// The square of the height over the longest side, as a part of that side.
fn shape(triangle: [&Point; 3]) -> f64 {
    let [a, b, c] = triangle;
    let longest = distance2(a, b).max(distance2(b, c)).max(distance2(c, a));
    let n = normal(triangle);
    dot(&n, &n) / (longest * longest)
}
