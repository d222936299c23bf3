//! Points that are to be vertices of the mesh: where each lives, exactly.
//!
//! Cost: a tree of segments and polygons, and one look at it for each point.

use super::carrier::{Carrier, corner_point};
use super::parts::Parts;
use super::plc::Plc;
use crate::RefineError;
use ltbw_domain::{Domain, Lattice};
use ltbw_exact::Point;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::cell::OnceCell;

/// A segment, or a facet of which a polygon is near.
#[derive(Clone, Copy)]
enum Near {
    Segment(u32),
    Facet(u32),
}

impl Plc {
    /// Finds out where the points of a domain live that are to be vertices.
    ///
    /// # Errors
    /// [`RefineError::OffLattice`] names a point that is not on the grid of all points of a mesh.
    pub(crate) fn join_points(
        &mut self,
        domain: &Domain,
        lattice: &Lattice,
    ) -> Result<(), RefineError> {
        if domain.points.is_empty() {
            return Ok(());
        }
        let tree = self.near_tree();
        let parts: Vec<OnceCell<Parts<'_>>> = self.facets.iter().map(|_| OnceCell::new()).collect();
        let mut points = Vec::with_capacity(domain.points.len());
        for (vertex, &at) in (self.corners.len() as u32..).zip(&domain.points) {
            let steps = lattice.fine_steps(&at).ok_or(RefineError::OffLattice { vertex, at })?;
            let p = steps.map(|c| c as f64);
            let mut carrier = Carrier::Free;
            for near in tree.locate_in_envelope_intersecting(AABB::from_point(p)) {
                match near.data {
                    Near::Segment(s) => {
                        if let Some(t) = self.segments[s as usize].line.parameter(&p) {
                            carrier = Carrier::Segment(s, t);
                            break;
                        }
                    }
                    Near::Facet(f) if self.holds(f, &p, &parts[f as usize]) => {
                        carrier = Carrier::Facet(f);
                    }
                    Near::Facet(_) => {}
                }
            }
            points.push((p, carrier));
        }
        drop(parts);
        self.points = points;
        Ok(())
    }

    /// Is a point, which is on no segment, on a facet?
    fn holds<'p>(&'p self, f: u32, p: &Point, parts: &OnceCell<Parts<'p>>) -> bool {
        let facet = &self.facets[f as usize];
        match &facet.patch {
            Some(patch) => patch.holds(p),
            None => {
                let parts = || parts.get_or_init(|| Parts::new(facet, &self.corners));
                facet.plane.holds(p) && parts().at_centroid([*p; 3]).is_some()
            }
        }
    }

    /// Segments and polygons by their boxes, in fine steps.
    fn near_tree(&self) -> RTree<GeomWithData<Rectangle<Point>, Near>> {
        let at = |&v: &u32| corner_point(&self.corners[v as usize]);
        let boxed = |corners: &[u32], near: Near| {
            let by = |fold: fn(f64, f64) -> f64| {
                let first = corners.first().map(at).unwrap_or_default();
                corners.iter().map(at).fold(first, |one, p| [0, 1, 2].map(|k| fold(one[k], p[k])))
            };
            GeomWithData::new(Rectangle::from_corners(by(f64::min), by(f64::max)), near)
        };
        let segments = (0..).zip(&self.segments);
        let mut all: Vec<_> = segments.map(|(s, own)| boxed(&own.ends, Near::Segment(s))).collect();
        for (f, facet) in (0..).zip(&self.facets) {
            let polygons = facet.parts.iter().flat_map(|part| &part.polygons);
            all.extend(polygons.map(|polygon| boxed(polygon, Near::Facet(f))));
        }
        RTree::bulk_load(all)
    }
}
