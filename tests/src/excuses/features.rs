//! The angles at which the features of a domain meet.
//!
//! In a sound domain two features meet in what both name: segments at a vertex, a segment and a
//! facet at a vertex, two facets at a segment. (Facets that meet at a vertex alone are nearest to
//! each other along a segment of one of them.) All angles are rounded: they are compared with
//! limits of whole degrees, and decide nothing in a mesh.

use super::complex::Complex;
use super::unit;
use ltbw::Point;
use ltbw::domain::Domain;
use ltbw::domain::vector::{cross, dot, minus};
use std::collections::{BTreeMap, BTreeSet};

/// The plane angle, in degrees, below which a facet is a needle: at a tip with a smaller one every
/// triangle has a circumradius of more than twice its shortest edge.
pub const NEEDLE: f64 = 14.5;

/// The part of a length below which a place is on the border of a cone.
const BORDER: f64 = 1e-12;

/// The least angles between the features of a domain, in degrees; 180 where no two meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Features {
    /// Between segments at a vertex, but for the plane angles of facets.
    pub segments: f64,
    /// Between a segment and a facet that it is no side of.
    pub segment_facet: f64,
    /// Between facets at a segment.
    pub facets: f64,
    /// Between two sides of a facet, measured inside it.
    pub plane: f64,
    /// Facets with a plane angle below [`NEEDLE`].
    pub needles: usize,
}

impl Features {
    /// The features of a domain in which facets within `tolerance` of a plane are one. Cost: all
    /// pairs of what meets at a vertex.
    #[must_use]
    pub fn of(domain: &Domain, tolerance: f64) -> Self {
        let complex = Complex::of(domain, tolerance);
        let mut found =
            Self { segments: 180.0, segment_facet: 180.0, facets: 180.0, plane: 180.0, needles: 0 };
        found.look_at_segments(&complex);
        let mut at: BTreeMap<u32, Corner> = BTreeMap::new();
        for &ends in &complex.segments {
            for [v, far] in [ends, [ends[1], ends[0]]] {
                let groups = complex.beside(ends).map(|(group, _)| group).collect();
                let direction = minus(complex.at(far), complex.at(v));
                at.entry(v).or_default().segments.push((direction, groups));
            }
        }
        for (corners, group) in &complex.triangles {
            for k in 0..3 {
                let Some(corner) = at.get_mut(&corners[k]) else { continue };
                let side = |j: usize| minus(complex.at(corners[j]), complex.at(corners[k]));
                corner.cones.push(([side((k + 1) % 3), side((k + 2) % 3)], *group));
            }
        }
        let mut needles = BTreeSet::new();
        at.values().for_each(|corner| found.look_at_corner(corner, &complex.normals, &mut needles));
        Self { needles: needles.len(), ..found }
    }

    /// The least angle of all.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.segments.min(self.segment_facet).min(self.facets).min(self.plane)
    }

    /// Facets at a segment: their directions away from it, each in the plane of its own.
    fn look_at_segments(&mut self, complex: &Complex<'_>) {
        for &ends in &complex.segments {
            let [a, b] = ends.map(|v| complex.at(v));
            let along = minus(b, a);
            let away = |(group, third): (u32, u32)| {
                let side = cross(&complex.normals[group as usize], &along);
                let is_inner = dot(&side, &minus(complex.at(third), a)) >= 0.0;
                if is_inner { side } else { side.map(|c| -c) }
            };
            let sides: Vec<Point> = complex.beside(ends).map(away).collect();
            for (k, side) in sides.iter().enumerate() {
                for other in &sides[..k] {
                    self.facets = self.facets.min(angle(side, other));
                }
            }
        }
    }

    /// Features that meet at a corner alone.
    fn look_at_corner(&mut self, corner: &Corner, normals: &[Point], needles: &mut BTreeSet<u32>) {
        let within = |group: u32, direction: &Point| {
            let cones = corner.cones.iter().filter(|(_, of)| *of == group);
            let normal = &normals[group as usize];
            cones.clone().any(|(sides, _)| is_in_cone(direction, sides, normal))
        };
        for (k, (direction, own)) in corner.segments.iter().enumerate() {
            for (other, theirs) in &corner.segments[..k] {
                let angle = angle(direction, other);
                let middle = [unit(direction), unit(other)];
                let middle = [0, 1, 2].map(|i| middle[0][i] + middle[1][i]);
                let mut shared = own.iter().filter(|g| theirs.contains(g));
                match shared.find(|&&group| within(group, &middle)) {
                    Some(&group) => {
                        self.plane = self.plane.min(angle);
                        if angle < NEEDLE {
                            needles.insert(group);
                        }
                    }
                    None => self.segments = self.segments.min(angle),
                }
            }
            for (sides, group) in corner.cones.iter().filter(|(_, group)| !own.contains(group)) {
                let normal = &normals[*group as usize];
                if is_in_cone(direction, sides, normal) {
                    let over = dot(&unit(direction), normal).abs().min(1.0);
                    self.segment_facet = self.segment_facet.min(over.asin().to_degrees());
                }
            }
        }
    }
}

/// Segments and facets at a vertex.
#[derive(Default)]
struct Corner {
    /// Directions of the segments, with the facets that have them as sides.
    segments: Vec<(Point, Vec<u32>)>,
    /// The two sides of each triangle there, and its facet.
    cones: Vec<([Point; 2], u32)>,
}

/// The angle between two directions, in degrees.
fn angle(a: &Point, b: &Point) -> f64 {
    let normal = cross(a, b);
    dot(&normal, &normal).sqrt().atan2(dot(a, b)).to_degrees()
}

/// Is a direction, projected to the plane with a normal, between two others, or on one of them?
fn is_in_cone(direction: &Point, [a, b]: &[Point; 2], normal: &Point) -> bool {
    let length = |p: &Point| dot(p, p).sqrt();
    let turn = |p: &Point, q: &Point| dot(normal, &cross(p, q)) / (length(p) * length(q));
    let sign = turn(a, b).signum();
    sign * turn(a, direction) >= -BORDER && sign * turn(direction, b) >= -BORDER
}
