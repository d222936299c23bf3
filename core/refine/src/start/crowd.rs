//! Crowded segments, which are cut before there is a mesh.
//!
//! The back of a comb is a segment whose diametral ball holds nearly all corners. In the mesh of
//! these it is an edge of tetrahedra with spheres far larger than the domain: nearly the whole mesh
//! is the cavity of a point on it, and of each point that it bars. Cut until the ball of each part
//! holds few corners, it is as long as what is around it is wide, and all cavities are small from
//! the start. Refinement would have to cut it as far, one round after the other.
//!
//! Cost: a search in a tree for each segment, and for each part of a crowded one.

use crate::RefineError;
use crate::complex::carrier::{Carrier, Corner, Cut, corner_point};
use crate::complex::plc::Plc;
use crate::heed::Heed;
use crate::rules::aim::{Aim, Aims};
use crate::table::Map;
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;
use rstar::RTree;
use std::collections::VecDeque;

/// Corners in the ball of a segment from which on it is cut.
const CROWD: usize = 1024;

/// The most corners in the ball of a part of it.
const FEW: usize = 4;

/// A part of a segment, by its ends.
struct Part {
    segment: u32,
    ends: [Corner; 2],
}

impl Part {
    fn whole(plc: &Plc, segment: u32) -> Self {
        let point = |c: u32| corner_point(&plc.corners[c as usize]);
        let end = |c: u32| Corner { point: point(c), carrier: Carrier::Corner(c) };
        Self { segment, ends: plc.segments[segment as usize].ends.map(end) }
    }

    /// The parts between points on it that are to be vertices, in their order along it.
    fn between(&self, inner: &[Corner]) -> Vec<Self> {
        let [first, last] = self.ends;
        let all: Vec<_> = [first].into_iter().chain(inner.iter().copied()).chain([last]).collect();
        let part = |pair: &[Corner]| Self { segment: self.segment, ends: [pair[0], pair[1]] };
        all.windows(2).map(part).collect()
    }

    /// Does its ball hold more than this number of corners, its own ends left out? Rounding may
    /// count one on the sphere: it is a number of about that size.
    fn has_more(&self, tree: &RTree<Point>, count: usize) -> bool {
        let [a, b] = self.ends.map(|end| end.point);
        let middle = [0, 1, 2].map(|k| a[k] / 2.0 + b[k] / 2.0);
        let inside = tree.locate_within_distance(middle, distance2(&a, &b) / 4.0);
        inside.filter(|&p| *p != a && *p != b).nth(count).is_some()
    }
}

/// The parameter of a place on a segment.
fn parameter(carrier: Carrier) -> i64 {
    match carrier {
        Carrier::Segment(_, parameter) => parameter,
        _ => 0,
    }
}

impl Plc {
    /// The points on segments that are to be vertices, in their order along each.
    fn inner_points(&self) -> Map<u32, Vec<Corner>> {
        let mut all: Map<u32, Vec<Corner>> = Map::default();
        for &(point, carrier) in &self.points {
            if let Carrier::Segment(s, _) = carrier {
                all.entry(s).or_default().push(Corner { point, carrier });
            }
        }
        all.values_mut().for_each(|own| own.sort_by_key(|own| parameter(own.carrier)));
        all
    }

    /// The cuts of crowded segments, ascending; none if there are patches, and at most `most`. A
    /// function of the domain alone.
    ///
    /// # Errors
    /// [`RefineError::Cancelled`].
    pub(crate) fn cuts(
        &self,
        floor: f64,
        most: u64,
        heed: Heed<'_>,
    ) -> Result<Vec<Cut>, RefineError> {
        let mut cuts = Vec::new();
        if most == 0 || self.corners.len() <= CROWD || self.has_patches() {
            return Ok(cuts);
        }
        let tree = RTree::bulk_load(self.corners.iter().map(corner_point).collect());
        let aims = Aims { plc: self, floor };
        // The longest parts come first: where the budget ends the rest is cut evenly.
        let mut parts = VecDeque::new();
        let inner = self.inner_points();
        for segment in 0..self.segments.len() as u32 {
            heed.ask_at(segment as usize)?;
            let whole = Part::whole(self, segment);
            if whole.has_more(&tree, CROWD) {
                let between = whole.between(inner.get(&segment).map_or(&[], Vec::as_slice));
                parts.extend(between.into_iter().filter(|part| part.has_more(&tree, FEW)));
            }
        }
        // Ends: parts have whole parameters at their ends, and each is cut between them.
        while let Some(Part { segment, ends }) = parts.pop_front() {
            heed.ask_at(cuts.len())?;
            let Aim::At { point, carrier, .. } = aims.subsegment(segment, ends, 0) else {
                continue;
            };
            let Carrier::Segment(_, parameter) = carrier else { continue };
            if cuts.len() as u64 >= most {
                break;
            }
            cuts.push(Cut { segment, parameter });
            let cut = Corner { point, carrier };
            let halves = [[ends[0], cut], [cut, ends[1]]].map(|ends| Part { segment, ends });
            parts.extend(halves.into_iter().filter(|half| half.has_more(&tree, FEW)));
        }
        cuts.sort_unstable();
        Ok(cuts)
    }
}
