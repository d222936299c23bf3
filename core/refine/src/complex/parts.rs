//! Which part of a facet a point of its plane is in, and the marker of the part.

use super::carrier::{Grid, UNIT};
use super::plc::{Facet, Part, Plc};
use super::ring::{Flat, Ring};
use crate::table::Set;
use ltbw_domain::vector::dominant;
use ltbw_exact::Point;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::cell::OnceCell;

/// The polygons of a facet in the projection along the largest entry of its normal, in thirds of
/// fine steps.
pub(crate) struct Parts<'f> {
    facet: &'f Facet,
    axes: [usize; 2],
    /// The polygons of all parts, one part after the other, each with its part.
    rings: Vec<(usize, Ring)>,
    tree: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
    /// Per part the polygons around each point of a hole.
    holes: Vec<Set<Vec<usize>>>,
}

/// Rounded; larger is never rounded to less.
fn rounded(p: Flat) -> [f64; 2] {
    p.map(|c| c as f64)
}

impl<'f> Parts<'f> {
    /// The parts of a facet of a complex with these corners.
    pub(crate) fn new(facet: &'f Facet, corners: &[Grid]) -> Self {
        let axis = dominant(&facet.plane.normal());
        let axes = [(axis + 1) % 3, (axis + 2) % 3];
        let flat = |v: &u32| axes.map(|k| 3 * corners[*v as usize][k] * UNIT);
        let mut rings = Vec::new();
        for (k, part) in facet.parts.iter().enumerate() {
            let own = part.polygons.iter().map(|polygon| polygon.iter().map(flat).collect());
            rings.extend(own.map(|corners| (k, Ring::new(corners))));
        }
        let boxed = |(k, (_, ring)): (usize, &(usize, Ring))| {
            let [low, high] = ring.bounds().map(rounded);
            GeomWithData::new(Rectangle::from_corners(low, high), k)
        };
        let tree = RTree::bulk_load(rings.iter().enumerate().map(boxed).collect());
        let mut parts = Self { facet, axes, rings, tree, holes: Vec::new() };
        let around = |(k, part): (usize, &Part)| {
            let hole = |p: &Point| parts.around(axes.map(|i| (3.0 * p[i]).round() as i64));
            let own = |all: Vec<usize>| all.into_iter().filter(|&r| parts.rings[r].0 == k);
            part.holes.iter().map(|p| own(hole(p)).collect()).collect()
        };
        parts.holes = facet.parts.iter().enumerate().map(around).collect();
        parts
    }

    /// The polygons around a point, ascending.
    fn around(&self, p: Flat) -> Vec<usize> {
        let near = self.tree.locate_in_envelope_intersecting(AABB::from_point(rounded(p)));
        let mut around: Vec<usize> =
            near.map(|ring| ring.data).filter(|&k| self.rings[k].1.encloses(p)).collect();
        around.sort_unstable();
        around
    }

    /// The part that the centroid of a triangle in the plane is in, and not in a hole of it.
    pub(crate) fn at_centroid(&self, corners: [Point; 3]) -> Option<&'f Part> {
        // Three times the centroid, whole.
        let centre = self.axes.map(|k| corners.iter().map(|p| p[k] as i64).sum());
        let around = self.around(centre);
        let mut groups = around.chunk_by(|&a, &b| self.rings[a].0 == self.rings[b].0);
        let part = groups.find_map(|own| {
            let part = self.rings[own[0]].0;
            (!self.holes[part].contains(own)).then_some(part)
        });
        part.map(|part| &self.facet.parts[part])
    }
}

/// The marker of a facet, or its parts if they have several.
enum Marker<'p> {
    One(i32),
    Several(Parts<'p>),
}

/// The markers of subfaces; what a facet has is found when it is asked for.
pub(crate) struct Markers<'p> {
    plc: &'p Plc,
    /// Markers of the domain's facets in place of their own.
    given: Option<&'p [i32]>,
    facets: Vec<OnceCell<Marker<'p>>>,
}

impl<'p> Markers<'p> {
    pub(crate) fn new(plc: &'p Plc, given: Option<&'p [i32]>) -> Self {
        Self { plc, given, facets: (0..plc.facets.len()).map(|_| OnceCell::new()).collect() }
    }

    /// The marker of a subface of facet `f`: that of the polygons which it is part of.
    pub(crate) fn of(&self, f: u32, corners: [Point; 3]) -> i32 {
        let facet = &self.plc.facets[f as usize];
        let marker = |part: &Part| match self.given {
            Some(given) => given.get(part.facet as usize).copied().unwrap_or(0),
            None => part.marker,
        };
        let first = facet.parts.first().map_or(0, marker);
        let found = || match facet.parts.iter().all(|part| marker(part) == first) {
            true => Marker::One(first),
            false => Marker::Several(Parts::new(facet, &self.plc.corners)),
        };
        match self.facets[f as usize].get_or_init(found) {
            Marker::One(marker) => *marker,
            Marker::Several(parts) => parts.at_centroid(corners).map_or(first, marker),
        }
    }
}
