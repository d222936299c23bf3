//! The limits of a refinement that nobody has set: the floor of edge lengths, the most points.

use super::Refiner;
use crate::complex::measure::USUAL_EDGE;
use crate::mesh::bounds::regular_volume;
use ltbw_domain::{Domain, Lattice};
use ltbw_exact::Point;

/// Default floor of edge lengths: this part of the box.
const FLOOR: f64 = 1.0 / (1 << 20) as f64;

/// Default limit on inserted points: this number, [`STEINER_PER_CORNER`] for each corner, and
/// [`STEINER_PER_VOLUME`] for each tetrahedron of the largest allowed volume that the box could
/// hold.
const STEINER_BASE: u64 = 1_000_000;
/// See [`STEINER_BASE`].
const STEINER_PER_CORNER: u64 = 64;
/// See [`STEINER_BASE`].
const STEINER_PER_VOLUME: f64 = 4.0;

/// The most tetrahedra for which memory is taken before they are there.
const MOST_EXPECTED: usize = 1 << 23;

impl Refiner<'_> {
    pub(super) fn floor_in_steps(&self, domain: &Domain, lattice: &Lattice) -> f64 {
        let length = self.floor.unwrap_or_else(|| {
            let (low, high) = domain.bounds().unwrap_or(([0.0; 3], [1.0; 3]));
            (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max) * FLOOR
        });
        length / lattice.fine_step()
    }

    /// The tetrahedra for which memory is taken beforehand: about as many as a domain has that
    /// fills its box; none where no bound on all volumes is given.
    pub(super) fn expected_tets(&self, domain: &Domain) -> usize {
        let (low, high) = domain.bounds().unwrap_or(([0.0; 3], [1.0; 3]));
        let volume: f64 = (0..3).map(|k| high[k] - low[k]).product();
        // A conversion of floats saturates.
        self.max_volume.map_or(0, |most| (2.0 * volume / most) as usize).min(MOST_EXPECTED)
    }

    pub(super) fn default_budget(&self, domain: &Domain) -> u64 {
        let (low, high) = domain.bounds().unwrap_or(([0.0; 3], [1.0; 3]));
        let volume: f64 = (0..3).map(|k| high[k] - low[k]).product();
        let regions = domain.regions.iter().filter_map(|r| r.max_volume);
        // A sizing field is looked at where the domain has vertices: nothing else is known about
        // it.
        let field = |p: &Point| self.field.map(|field| regular_volume(USUAL_EDGE * field(*p)));
        let fields = domain.vertices.iter().filter_map(field).filter(|&v| v > 0.0);
        let edges = self.max_edge.map(|longest| regular_volume(longest / 2.0));
        let all = regions.chain(self.max_volume).chain(edges).chain(fields);
        let least = all.fold(f64::INFINITY, f64::min);
        // A conversion of floats saturates.
        let by_volume = (STEINER_PER_VOLUME * volume / least) as u64;
        let by_corners = STEINER_PER_CORNER * (domain.vertices.len() + domain.points.len()) as u64;
        by_volume.saturating_add(by_corners).saturating_add(STEINER_BASE)
    }
}
