//! The bounds that were asked for, in fine steps.

use super::Refiner;
use crate::complex::dihedral::DihedralBound;
use crate::complex::edges::EdgeBound;
use crate::complex::measure::{RatioBound, VolumeBound};
use crate::mesh::bounds::Bounds;
use crate::mesh::region::RegionInfo;
use ltbw_domain::Lattice;

impl<'a> Refiner<'a> {
    /// The bound on dihedral angles: none without a bound of shape.
    pub(super) fn dihedral(&self) -> Option<DihedralBound> {
        let is_asked = self.radius_edge.is_some() && self.min_dihedral > 0.0;
        is_asked.then(|| DihedralBound::new(self.min_dihedral))
    }

    pub(super) fn bounds(&self, regions: &[RegionInfo], lattice: &Lattice) -> Bounds<'a> {
        let step = lattice.fine_step();
        let volume = |region: &RegionInfo| {
            let own = region.max_volume.filter(|&v| v > 0.0);
            let both = match (own, self.max_volume) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            };
            // Exact: the step is a power of two.
            both.map(|v| VolumeBound::new(v / step / step / step))
        };
        Bounds {
            ratio: self.radius_edge.map(RatioBound::new),
            dihedral: self.dihedral(),
            count_angles: self.count_angles,
            volumes: regions.iter().map(volume).collect(),
            field: self.field,
            edge: self.max_edge.map(|length| EdgeBound::new(length / step)),
            fine_step: step,
        }
    }
}
