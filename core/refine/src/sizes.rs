//! [`Sizes`]: wanted edge lengths as a function of the place alone. One for all places, shorter
//! ones near places and at facets, and growing from there.
//!
//! Distances are rounded, without any function of a library but the root, which is exact to the
//! last bit everywhere: one place has one length on all machines.

use ltbw_domain::vector::{cross, distance2, dot, minus};
use ltbw_domain::{Domain, Parts, Prepared};
use ltbw_exact::Point;
use rstar::{AABB, PointDistance, RTree, RTreeObject};
use std::collections::{BTreeMap, HashMap};

/// Bits of a length behind its first that tell it from others: steps of 6 %.
const BITS: u32 = 4;

/// The factor by which edges grow from one to the next, if nothing else was asked for.
const GROWTH: f64 = 1.3;

/// Why lengths are no lengths.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SizesError {
    /// A length is not positive and finite.
    #[error("{0:?} is no edge length: positive and finite")]
    Length(f64),
    /// A radius is negative, or no number; or a place has no coordinates.
    #[error("{0:?} is no radius or coordinate")]
    Place(f64),
    /// Edges do not grow by such a factor.
    #[error("{0:?} is no factor of growth: from 1 on")]
    Growth(f64),
    /// A turn has more edges.
    #[error("{0:?} edges are no turn: from 3 on")]
    Turn(f64),
    /// No facet is meant.
    #[error("there are no such facets")]
    NoFacet,
}

/// Wanted edge lengths in a domain.
///
/// ```
/// use ltbw_domain::{Domain, PrepareOptions};
/// use ltbw_refine::{Refiner, Sizes};
/// let ready = Domain::cuboid([0.0; 3], [1.0; 3]).prepare(&PrepareOptions::default())?;
/// let sizes = Sizes::new(&ready).everywhere(0.3)?.near([0.0; 3], 0.05, 0.1)?;
/// assert_eq!([sizes.at([0.05, 0.0, 0.0]), sizes.at([1.0; 3])], [0.05, 0.3]);
/// let field = |p| sizes.at(p);
/// let refined = Refiner::new().sizing(&field).refine(&ready.domain, &ready.lattice)?;
/// println!("{} tetrahedra", refined.num_tets());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sizes {
    offset: Point,
    everywhere: f64,
    growth: f64,
    near: Vec<Near>,
    walls: Vec<Wall>,
}

/// A ball of short edges.
#[derive(Clone, Debug)]
struct Near {
    at: Point,
    length: f64,
    radius: f64,
}

/// Facets of short edges.
#[derive(Clone, Debug)]
struct Wall {
    triangles: RTree<Triangle>,
    length: f64,
}

fn length(value: f64) -> Result<f64, SizesError> {
    let good = value > 0.0 && value.is_finite();
    good.then_some(value).ok_or(SizesError::Length(value))
}

impl Sizes {
    /// Lengths in a domain that ask for nothing yet. The growth is 1.3.
    #[must_use]
    pub fn new(ready: &Prepared) -> Self {
        let (offset, everywhere) = (ready.lattice.offset(), f64::INFINITY);
        Self { offset, everywhere, growth: GROWTH, near: Vec::new(), walls: Vec::new() }
    }

    /// Asks for edges of this length, and no longer ones, in all places.
    ///
    /// # Errors
    /// [`SizesError`]: it is no length.
    pub fn everywhere(mut self, length: f64) -> Result<Self, SizesError> {
        self.everywhere = self::length(length)?.min(self.everywhere);
        Ok(self)
    }

    /// Sets the factor by which edges grow from one to the next, away from where shorter ones are
    /// asked for: at a distance d from edges of length h they are h + (growth - 1) d.
    ///
    /// # Errors
    /// [`SizesError`]: it is below 1, or infinite.
    pub fn growth(mut self, factor: f64) -> Result<Self, SizesError> {
        let good = factor >= 1.0 && factor.is_finite();
        self.growth = good.then_some(factor).ok_or(SizesError::Growth(factor))?;
        Ok(self)
    }

    /// Asks for edges of a length within a radius of a place, in the coordinates of the input.
    ///
    /// # Errors
    /// [`SizesError`]: what is no length, radius or place.
    pub fn near(mut self, at: Point, length: f64, radius: f64) -> Result<Self, SizesError> {
        if !(radius >= 0.0 && radius.is_finite()) {
            return Err(SizesError::Place(radius));
        }
        if let Some(&wrong) = at.iter().find(|c| !c.is_finite()) {
            return Err(SizesError::Place(wrong));
        }
        let at = minus(&at, &self.offset);
        self.near.push(Near { at, length: self::length(length)?, radius });
        Ok(self)
    }

    /// Asks for edges of a length at facets of the prepared domain: those that `is_meant` says, by
    /// their places among [`Domain::facets`](ltbw_domain::Domain::facets).
    ///
    /// # Errors
    /// [`SizesError`]: it is no length, or no facet is meant.
    pub fn at_facets(
        mut self,
        domain: &Domain,
        is_meant: impl Fn(usize) -> bool,
        length: f64,
    ) -> Result<Self, SizesError> {
        let meant = (0..domain.facets.len()).filter(|&f| is_meant(f));
        let triangles = meant.filter_map(|f| Some(domain.triangulate(f as u32)?.triangles));
        let corners = |t: [u32; 3]| Triangle(t.map(|v| domain.vertices[v as usize]));
        let triangles: Vec<Triangle> = triangles.flatten().map(corners).collect();
        if triangles.is_empty() {
            return Err(SizesError::NoFacet);
        }
        let triangles = RTree::bulk_load(triangles);
        self.walls.push(Wall { triangles, length: self::length(length)? });
        Ok(self)
    }

    /// Asks for `per_turn` edges in a full turn of a curved surface: at a radius r for edges
    /// of 2πr over their number. `parts` are the smooth ones of the domain, over whose borders
    /// nothing is curved.
    ///
    /// The curvature of a triangle is that of its most curved side: the difference of the surface's
    /// normals at the ends, which are the means of those of the part's triangles there, over the
    /// length. Lengths are rounded down, by 6 % at most.
    ///
    /// # Errors
    /// [`SizesError`]: it is no number of edges.
    pub fn curved(
        mut self,
        domain: &Domain,
        parts: &Parts,
        per_turn: f64,
    ) -> Result<Self, SizesError> {
        if !(per_turn >= 3.0 && per_turn.is_finite()) {
            return Err(SizesError::Turn(per_turn));
        }
        let mut triangles: Vec<([u32; 3], i32)> = Vec::new();
        for (f, &part) in (0..).zip(&parts.markers) {
            let own = domain.triangulate(f).into_iter().flat_map(|found| found.triangles);
            triangles.extend(own.map(|corners| (corners, part)));
        }
        let at = |v: u32| domain.vertices[v as usize];
        let mut normals: HashMap<(u32, i32), Point> = HashMap::new();
        for &(corners, part) in &triangles {
            let [a, b, c] = corners.map(at);
            let n = cross(&minus(&b, &a), &minus(&c, &a));
            for v in corners {
                let sum = normals.entry((v, part)).or_default();
                *sum = [0, 1, 2].map(|k| sum[k] + n[k]);
            }
        }
        for n in normals.values_mut() {
            let length = dot(n, n).sqrt();
            *n = n.map(|c| if length > 0.0 { c / length } else { 0.0 });
        }
        let mut walls: BTreeMap<u64, Vec<Triangle>> = BTreeMap::new();
        for (corners, part) in triangles {
            let [a, b, c] = corners;
            let curvature = |[v, w]: [u32; 2]| {
                let [m, n] = [v, w].map(|v| normals.get(&(v, part)).copied().unwrap_or_default());
                (distance2(&m, &n) / distance2(&at(v), &at(w))).sqrt()
            };
            let most = [[a, b], [b, c], [c, a]].map(curvature).into_iter().fold(0.0, f64::max);
            let length = std::f64::consts::TAU / (per_turn * most);
            if length.is_normal() {
                let class = length.to_bits() >> (52 - BITS);
                walls.entry(class).or_default().push(Triangle(corners.map(at)));
            }
        }
        let wall = |(class, triangles): (u64, Vec<Triangle>)| {
            let length = f64::from_bits(class << (52 - BITS));
            Wall { triangles: RTree::bulk_load(triangles), length }
        };
        self.walls.extend(walls.into_iter().map(wall));
        Ok(self)
    }

    /// The length at a place in the coordinates of the mesh; infinite where nothing is asked for.
    #[must_use]
    pub fn at(&self, p: Point) -> f64 {
        let slope = self.growth - 1.0;
        let near = |size: f64, near: &Near| {
            let outside = (distance2(&p, &near.at).sqrt() - near.radius).max(0.0);
            size.min(near.length + slope * outside)
        };
        let size = self.near.iter().fold(self.everywhere, near);
        self.walls.iter().fold(size, |size, wall| {
            if wall.length >= size {
                return size;
            }
            let nearest = wall.triangles.nearest_neighbor(p);
            let distance = nearest.map_or(f64::INFINITY, |own| own.distance_2(&p).sqrt());
            // No growth and no distance: zero times infinity is no number.
            size.min(wall.length + slope * distance.min(f64::MAX))
        })
    }
}

/// A triangle of a facet.
#[derive(Clone, Debug)]
struct Triangle([Point; 3]);

impl RTreeObject for Triangle {
    type Envelope = AABB<Point>;

    fn envelope(&self) -> AABB<Point> {
        AABB::from_points(&self.0)
    }
}

impl PointDistance for Triangle {
    fn distance_2(&self, p: &Point) -> f64 {
        let [a, b, c] = &self.0;
        let n = cross(&minus(b, a), &minus(c, a));
        let sides = [[a, b], [b, c], [c, a]];
        // Is it over the inside? Then the foot of its height is the nearest point.
        let is_inside = |[a, b]: &[&Point; 2]| dot(&cross(&n, &minus(b, a)), &minus(p, a)) >= 0.0;
        let height = dot(&n, &minus(p, a));
        let square = dot(&n, &n);
        if square > 0.0 && sides.iter().all(is_inside) {
            return height * height / square;
        }
        sides.into_iter().map(|side| from_side(p, side)).fold(f64::INFINITY, f64::min)
    }
}

/// The squared distance of a point from a line between two others.
fn from_side(p: &Point, [a, b]: [&Point; 2]) -> f64 {
    let (u, w) = (minus(b, a), minus(p, a));
    let square = dot(&u, &u);
    let part = if square > 0.0 { (dot(&u, &w) / square).clamp(0.0, 1.0) } else { 0.0 };
    distance2(&w, &u.map(|c| part * c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_domain::PrepareOptions;

    fn cube() -> Prepared {
        Domain::cuboid([0.0; 3], [1.0; 3]).prepare(&PrepareOptions::default()).expect("a domain")
    }

    #[test]
    fn edges_grow_from_places_and_facets() {
        let ready = cube();
        let sizes = Sizes::new(&ready).growth(1.5).expect("a factor");
        assert_eq!(sizes.at([0.5; 3]), f64::INFINITY);
        let near = sizes.clone().near([0.0; 3], 0.1, 0.25).expect("a place");
        assert_eq!([near.at([0.25, 0.0, 0.0]), near.at([0.75, 0.0, 0.0])], [0.1, 0.35]);
        let both = near.everywhere(0.2).expect("a length");
        assert_eq!([both.at([0.25, 0.0, 0.0]), both.at([0.75, 0.0, 0.0])], [0.1, 0.2]);
        // The facet of marker 6 is z = 1.
        let is_top = |f: usize| ready.domain.facets[f].marker == 6;
        let top = sizes.clone().at_facets(&ready.domain, is_top, 0.125).expect("a facet");
        assert_eq!([top.at([0.3, 0.6, 1.0]), top.at([0.3, 0.6, 0.5])], [0.125, 0.375]);
        assert_eq!(top.at([2.0, 0.5, 1.0]), 0.625);
        assert_eq!(
            sizes.at_facets(&ready.domain, |_| false, 0.1).expect_err("none"),
            SizesError::NoFacet
        );
    }

    #[test]
    fn curved_surfaces_have_so_many_edges_in_a_turn() {
        let ready = ltbw_generate::surfaces::prism(24, 0.0, 1)
            .prepare(&PrepareOptions { oriented: true, ..PrepareOptions::default() })
            .expect("a domain");
        let parts = Parts::smooth(&ready, 40.0, 0.0);
        let sizes = Sizes::new(&ready).curved(&ready.domain, &parts, 20.0).expect("edges");
        // The radius is 1/2; the caps are flat.
        let wanted = std::f64::consts::PI / 20.0;
        let round = sizes.at([0.5, 0.0, 0.2]);
        assert!(round <= wanted * 1.01 && round > wanted * 0.93, "{round} {wanted}");
        let flat = sizes.at([0.0, 0.0, 0.5]);
        assert!(flat > round + 0.14 && flat < round + 0.16, "{flat}");
        let plain =
            Sizes::new(&cube()).curved(&cube().domain, &Parts::smooth(&cube(), 40.0, 0.0), 9.0);
        assert_eq!(plain.expect("edges").at([0.5; 3]), f64::INFINITY);
    }

    #[test]
    fn what_is_no_length_is_refused() {
        let ready = cube();
        let sizes = || Sizes::new(&ready);
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let is_length = |found: Result<Sizes, SizesError>| {
                matches!(found.expect_err("no length"), SizesError::Length(_))
            };
            assert!(is_length(sizes().everywhere(wrong)));
            assert!(is_length(sizes().near([0.0; 3], wrong, 0.0)));
            assert!(is_length(sizes().at_facets(&ready.domain, |_| true, wrong)));
        }
        for wrong in [0.9, f64::NAN, f64::INFINITY] {
            assert!(matches!(sizes().growth(wrong), Err(SizesError::Growth(_))));
        }
        for wrong in [2.0, f64::NAN, f64::INFINITY] {
            let found = sizes().curved(&ready.domain, &Parts::default(), wrong);
            assert!(matches!(found, Err(SizesError::Turn(_))));
        }
        for [x, radius] in [[0.0, -1.0], [0.0, f64::NAN], [f64::NAN, 1.0]] {
            let found = sizes().near([x, 0.0, 0.0], 0.1, radius);
            assert!(matches!(found, Err(SizesError::Place(_))));
        }
    }

    #[test]
    fn distances_from_triangles_are_those_of_the_nearest_point() {
        let triangle = Triangle([[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        for (p, square) in [
            ([1.0, 1.0, 3.0], 9.0),
            ([1.0, 1.0, -3.0], 9.0),
            ([2.0, -3.0, 0.0], 9.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([4.0, 4.0, 1.0], 9.0),
            ([7.0, 0.0, 4.0], 25.0),
        ] {
            assert!((triangle.distance_2(&p) - square).abs() < 1e-12, "{p:?}");
        }
        let needle = Triangle([[0.0; 3], [4.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        assert_eq!(needle.distance_2(&[5.0, 2.0, 2.0]), 9.0);
    }
}
