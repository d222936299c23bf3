//! A patch: facets that are coplanar within the tolerance of the domain (`flat`).

use super::outline::{Flat, Outline, Weighted, signed_area};
use super::slab::{Slab, big_dot, minus};
use super::whole::Whole;
use num_bigint::BigInt;

/// A plane, and the axis along which it is projected.
#[derive(Clone, Copy)]
pub(crate) struct Cast {
    pub(crate) axis: usize,
    pub(crate) normal: Whole,
    pub(crate) origin: Whole,
}

/// A patch.
#[derive(Debug)]
pub(crate) struct Patch {
    /// Its facets, the largest first.
    pub(crate) facets: Vec<u32>,
    axis: usize,
    /// The normal of its plane, in units of the domain.
    normal: [i128; 3],
    /// The corner in its plane, in units of the mesh.
    origin: Whole,
    /// The polygons in the projection, in thirds of units of the mesh.
    outline: Outline,
    /// Twice their area there, in ninths of square units.
    pub(crate) area: BigInt,
}

impl Patch {
    pub(crate) fn new(
        facets: Vec<u32>,
        plane: Cast,
        rings: &[&Vec<u32>],
        corners: &[Whole],
    ) -> Self {
        let Cast { axis, normal, origin } = plane;
        let axes = [(axis + 1) % 3, (axis + 2) % 3];
        let flat = |ring: &&Vec<u32>| -> Vec<Flat> {
            ring.iter().map(|&v| axes.map(|k| 3 * corners[v as usize][k])).collect()
        };
        let rings: Vec<Vec<Flat>> = rings.iter().map(flat).collect();
        let outline = Outline::new(rings.iter().map(|ring| Weighted::once(ring)));
        let area = |ring: &Vec<Flat>| {
            let area = signed_area(ring);
            if area < BigInt::ZERO { -area } else { area }
        };
        let area = rings.iter().map(area).sum();
        Self { facets, axis, normal, origin, outline, area }
    }

    pub(crate) fn flat(&self, p: &Whole) -> Flat {
        [3 * p[(self.axis + 1) % 3], 3 * p[(self.axis + 2) % 3]]
    }

    /// Is the centroid of a triangle in a polygon, in the projection?
    pub(crate) fn holds_centroid(&self, corners: &[Whole; 3], steps: &mut u64) -> bool {
        let flats = corners.map(|p| self.flat(&p));
        let centre = [0, 1].map(|k| flats.iter().map(|p| p[k] / 3).sum::<i128>());
        self.outline.weight_at(centre, steps) > 0
    }

    /// Is a point within the tolerance of the plane?
    pub(crate) fn is_in_slab(&self, p: &Whole, slab: &Slab) -> bool {
        slab.holds(
            &big_dot(&self.normal, &minus(p, &self.origin)),
            &big_dot(&self.normal, &self.normal),
        )
    }

    /// An upper bound of the area in the plane, in square units.
    pub(crate) fn plane_area(&self) -> f64 {
        let projected = big_to_f64(&self.area) / 18.0;
        let n = self.normal.map(|c| c as f64);
        let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
        projected * length / n[self.axis].abs() * (1.0 + 1e-9)
    }
}

/// A big integer, rounded.
fn big_to_f64(n: &BigInt) -> f64 {
    n.to_string().parse().unwrap_or(f64::INFINITY)
}
