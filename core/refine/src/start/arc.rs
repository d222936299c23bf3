//! Points on arcs around a corner, for facets at it that cutting segments does not recover.
//!
//! Where all segments at a corner are cut at one distance r, the ends lie on a sphere around it,
//! and the triangle of a facet between two of them is in the mesh exactly if a circle on the sphere
//! through the two has no other end inside: if the facet's arc is an edge of the Delaunay mesh on
//! the sphere. Where facets are folded narrowly around the corner some arc is not, and to cut the
//! segments nearer to the corner changes nothing but the scale, down to the floor. The arc has to
//! be divided: by points of the facet at the distance r, where they encroach no segment.

use crate::complex::carrier::{Carrier, UNIT};
use crate::mesh::item::Item;
use crate::mesh::state::{Place, State};
use ltbw_core::topology::VertexId;
use ltbw_domain::vector::distance2;

/// The part of their segment that subsegments at a corner have at most, squared, where an arc is
/// divided: what else is near the corner needs some cuts, and no point on an arc.
const SHARE: f64 = 1.0 / 256.0;
/// The part, squared, by which the distances from the corner may differ.
const ALIKE: f64 = 1.0 / 1024.0;

impl State {
    /// The place in the middle of the arc of a missing triangle of facet `f`, if it has one corner
    /// of the domain, its others are equally far from that, and its point encroaches `first`,
    /// subsegments there that have been cut again and again.
    pub(crate) fn arc(&self, corners: [VertexId; 3], f: u32, first: &[Item]) -> Option<Place> {
        let is_corner =
            |k: &usize| matches!(self.carriers[corners[*k].index()], Carrier::Corner(_));
        let mut of_domain = (0..3).filter(is_corner);
        let (Some(k), None) = (of_domain.next(), of_domain.next()) else { return None };
        let [o, a, b] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| self.at(corners[k]));
        let [near, far] = [distance2(&o, &a), distance2(&o, &b)];
        let square = near.max(far);
        let was_cut = |item: &Item| match item {
            Item::Segment(ends) if ends.contains(&corners[k]) => {
                self.segments.get(ends).is_some_and(|&s| square < SHARE * self.square_of(s))
            }
            _ => false,
        };
        if square - near.min(far) > ALIKE * square || !first.iter().all(was_cut) {
            return None;
        }
        let middle = [0, 1, 2].map(|k| (a[k] - o[k]) / 2.0 + (b[k] - o[k]) / 2.0);
        let stretch = (square / distance2(&middle, &[0.0; 3])).sqrt();
        let target = [0, 1, 2].map(|k| o[k] + stretch * middle[k]);
        // The triangle's circle reaches beyond the arc by an eighth of its side, squared, over r.
        let tolerance = distance2(&a, &b) / (128.0 * square.sqrt());
        self.place_at(f, &target, tolerance)
    }

    /// The squared length of segment `s`, rounded.
    fn square_of(&self, s: u32) -> f64 {
        let corner = |c: u32| self.plc.corners[c as usize].map(|x| (x * UNIT) as f64);
        let [start, end] = self.plc.segments[s as usize].ends.map(corner);
        distance2(&start, &end)
    }
}
