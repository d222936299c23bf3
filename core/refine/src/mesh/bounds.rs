//! The bounds that a mesh has to meet, and the decision whether a tetrahedron does.

use super::key::sorted;
use super::limit::Limit;
use super::state::State;
use crate::RefineError;
use crate::complex::angles::Angles;
use crate::complex::dihedral::DihedralBound;
use crate::complex::edges::EdgeBound;
use crate::complex::measure::{RatioBound, Shape, USUAL_EDGE, VolumeBound};
use crate::thin::Thin;
use ltbw_core::topology::{INFINITE, TetId};
use ltbw_core::{FourCorners, test_bounds};
use ltbw_domain::{Domain, Lattice, largest_tolerance};
use ltbw_exact::Point;

/// A tolerance within which facets may be taken for coplanar.
pub(crate) fn check_tolerance(value: f64, domain: &Domain) -> Result<(), RefineError> {
    let largest = largest_tolerance(domain);
    if (0.0..=largest).contains(&value) {
        return Ok(());
    }
    let limit = format!("it has to be between 0 and {largest:e}, 2^-10 of the diagonal");
    Err(RefineError::Bound { name: "flat-tolerance", value, limit })
}

/// The most sweeps of smoothing.
pub const MOST_SWEEPS: u32 = 16;

/// A number of sweeps that smoothing may have.
pub(crate) fn check_sweeps(sweeps: u32) -> Result<(), RefineError> {
    if sweeps <= MOST_SWEEPS {
        return Ok(());
    }
    let limit = format!("it has to be {MOST_SWEEPS} at most");
    Err(RefineError::Bound { name: "smooth", value: f64::from(sweeps), limit })
}

/// The largest bound on dihedral angles, in degrees.
const MOST_DIHEDRAL: f64 = 12.0;

/// The largest volume and edge.
#[derive(Clone, Copy)]
pub(crate) struct Largest {
    pub(crate) volume: Option<f64>,
    pub(crate) edge: Option<f64>,
}

/// Bounds that no mesh can meet are errors.
pub(crate) fn check_limits(
    radius_edge: Option<f64>,
    min_dihedral: f64,
    sizes: Largest,
    lattice: &Lattice,
) -> Result<(), RefineError> {
    if !(0.0..=MOST_DIHEDRAL).contains(&min_dihedral) {
        let limit = format!("it has to be between 0 (none) and {MOST_DIHEDRAL} degrees");
        return Err(RefineError::Bound { name: "min-dihedral", value: min_dihedral, limit });
    }
    if let Some(value) = radius_edge
        && !(1.0..=1e100).contains(&value)
    {
        let limit = "it has to be at least 1 (refinement is sure to end from 2 on)".into();
        return Err(RefineError::Bound { name: "radius-edge", value, limit });
    }
    let shortest = lattice.fine_step() * 1024.0;
    if let Some(value) = sizes.edge
        && !(shortest..f64::INFINITY).contains(&value)
    {
        let limit = format!("the lattice allows {shortest:e} at least");
        return Err(RefineError::Bound { name: "max-edge", value, limit });
    }
    let least = shortest * shortest * shortest;
    if let Some(value) = sizes.volume
        && !(least..f64::INFINITY).contains(&value)
    {
        let limit = format!("the lattice allows {least:e} at least");
        return Err(RefineError::Bound { name: "max-volume", value, limit });
    }
    Ok(())
}

/// The volume of a regular tetrahedron with edges of length h: h³ √2/12.
pub(crate) fn regular_volume(h: f64) -> f64 {
    std::f64::consts::SQRT_2 / 12.0 * (h * h * h)
}

/// The cube root of a positive number to a few units in the last place, the same on every machine:
/// Newton's method from a start that is off by at most a factor of two.
fn cube_root(x: f64) -> f64 {
    let exponent = (x.to_bits() >> 52) as i32 - 1023;
    let mut root = f64::from_bits(((exponent.div_euclid(3) + 1023) as u64) << 52);
    for _ in 0..8 {
        root -= (root - x / (root * root)) / 3.0;
    }
    root
}

/// A wanted edge length, as a function of the place in the coordinates of the mesh: those of the
/// input less [`Lattice::offset`](ltbw_domain::Lattice::offset).
pub type SizeField<'a> = dyn Fn(Point) -> f64 + Sync + 'a;

/// All bounds, in fine steps.
#[derive(Clone)]
pub(crate) struct Bounds<'a> {
    pub(crate) ratio: Option<RatioBound>,
    /// The angle below which a tetrahedron is a sliver; none without a bound of shape.
    pub(crate) dihedral: Option<DihedralBound>,
    /// Are angles to be counted before slivers are split?
    pub(crate) count_angles: bool,
    /// The bound of every region; that of the exterior is not used.
    pub(crate) volumes: Vec<Option<VolumeBound>>,
    pub(crate) field: Option<&'a SizeField<'a>>,
    /// The bound of every edge.
    pub(crate) edge: Option<EdgeBound>,
    /// The length of a fine step in the input's coordinates.
    pub(crate) fine_step: f64,
}

impl Bounds<'_> {
    /// Is tetrahedron `t` of the domain over its bounds?
    pub(crate) fn is_over(&self, state: &State, t: TetId) -> bool {
        let region = state.marks.region(t);
        if region == 0 {
            return false;
        }
        let [a, b, c, d] = state.vertices(t).map(|v| state.at(v));
        self.are_over([&a, &b, &c, &d], region) && !state.is_flat(state.vertices(t))
    }

    /// Would a tetrahedron with these corners in this region be over its bounds?
    pub(crate) fn are_over(&self, corners: [&Point; 4], region: u32) -> bool {
        let exceeds = |bound: Option<VolumeBound>| bound.is_some_and(|b| b.exceeded(corners));
        exceeds(self.volumes.get(region as usize).copied().flatten())
            || exceeds(self.field_bound(corners))
            || self.edge.is_some_and(|bound| bound.exceeded(corners))
            || self.ratio.is_some_and(|bound| bound.exceeded(corners))
    }

    /// Is tetrahedron `t` of the domain over a bound on its size?
    pub(crate) fn is_large(&self, state: &State, t: TetId) -> bool {
        let corners = state.vertices(t).map(|v| state.at(v));
        self.is_large_in(corners.each_ref(), state.marks.region(t))
    }

    /// Is a tetrahedron with these corners in a region over a bound on its size?
    pub(crate) fn is_large_in(&self, corners: [&Point; 4], region: u32) -> bool {
        let own = self.volumes.get(region as usize).copied().flatten();
        let bounds = own.into_iter().chain(self.field_bound(corners));
        bounds.into_iter().any(|bound| bound.exceeded(corners))
            || self.edge.is_some_and(|bound| bound.exceeded(corners))
    }

    /// Which of at most four tetrahedra would be over their bounds, and which may have tiny
    /// dihedral angles: bit masks. The same as [`Self::are_over`] of each, and faster.
    #[inline(always)]
    pub(crate) fn look_at_four(&self, tets: &Four) -> (u32, u32) {
        let volumes = match self.field {
            None => tets.regions.map(|region| self.volume_of(region)),
            Some(_) => std::array::from_fn(|k| match k < tets.count {
                true => self.volume_at(tets.corners(k).each_ref(), tets.regions[k]),
                false => f64::INFINITY,
            }),
        };
        let ratio = self.ratio.map(|bound| bound.value());
        let limit = self.dihedral.map_or(0.0, |bound| bound.thick());
        let [mut over, within, thick] = test_bounds(&tets.corners, &volumes, ratio, limit);
        let mut thin = 0;
        for k in 0..tets.count {
            if (over | within) >> k & 1 == 0 {
                over |= u32::from(self.are_over(tets.corners(k).each_ref(), tets.regions[k])) << k;
            }
            if let Some(bound) = self.edge.filter(|_| over >> k & 1 == 0) {
                over |= u32::from(bound.exceeded(tets.corners(k).each_ref())) << k;
            }
            if let Some(bound) = self.dihedral.filter(|_| thick >> k & 1 == 0) {
                thin |= u32::from(!bound.is_surely_met(tets.corners(k).each_ref())) << k;
            }
        }
        (over & !(u32::MAX << tets.count), thin)
    }

    /// The bound on the volume in a region; infinite if there is none.
    #[inline(always)]
    fn volume_of(&self, region: u32) -> f64 {
        let own = self.volumes.get(region as usize).copied().flatten();
        own.map_or(f64::INFINITY, |bound| bound.volume())
    }

    pub(crate) fn volume_at(&self, corners: [&Point; 4], region: u32) -> f64 {
        let field = self.field_bound(corners);
        field.map_or(f64::INFINITY, |bound| bound.volume()).min(self.volume_of(region))
    }

    /// Which of some tetrahedra of the domain are over their bounds, in their order. If there is a
    /// bound of shape, those that may have tiny dihedral angles are added to `thin`.
    pub(crate) fn over_of<'b>(
        &'b self,
        state: &'b State,
        tets: impl Iterator<Item = TetId> + 'b,
        thin: &'b mut Vec<Thin>,
    ) -> impl Iterator<Item = Thin> + 'b {
        let inside = tets.filter_map(|t| {
            let (v, region) = (state.vertices(t), state.marks.region(t));
            let is_inside = region != 0 && v[3] != INFINITE;
            let corners = || v.map(|v| state.at(v));
            is_inside.then(|| Solid { tet: (t, v), corners: corners(), region })
        });
        let all = self.over_among(inside, |own| thin.push(own));
        all.filter(|&(_, v)| !state.is_flat(v))
    }

    /// Which of some tetrahedra of the domain, given with their corners and regions, are over their
    /// bounds, in their order. If there is a bound of shape, `thin` is told of those that may have
    /// tiny dihedral angles.
    #[inline(always)]
    pub(crate) fn over_among<'b, T: Copy + Default + 'b>(
        &'b self,
        mut tets: impl Iterator<Item = Solid<T>> + 'b,
        mut thin: impl FnMut(T) + 'b,
    ) -> impl Iterator<Item = T> + 'b {
        let (mut four, mut own) = (Four::default(), [T::default(); 4]);
        let (mut over, mut is_done) = (0u32, false);
        std::iter::from_fn(move || {
            while over == 0 && !is_done {
                four.clear();
                for (to, Solid { tet, corners, region }) in own.iter_mut().zip(tets.by_ref()) {
                    *to = tet;
                    four.push(corners, region);
                }
                is_done = four.count < 4;
                let looked = self.look_at_four(&four);
                over = looked.0;
                bits(looked.1).for_each(|k| thin(own[k]));
            }
            let k = over.trailing_zeros() as usize;
            over &= over.wrapping_sub(1);
            own.get(k).copied()
        })
    }

    /// The factor by which tetrahedron `t`, which is over its bounds, is so: at least 1.
    #[inline(always)]
    pub(crate) fn excess_of(&self, state: &State, t: TetId) -> f64 {
        let [a, b, c, d] = state.vertices(t).map(|v| state.at(v));
        let corners = [&a, &b, &c, &d];
        let shape = Shape::of(corners);
        let volume = self.volumes.get(state.marks.region(t) as usize).copied().flatten();
        let sizes = volume.into_iter().chain(self.field_bound(corners));
        let sizes = sizes.map(|bound| bound.excess(&shape));
        let ratios = self.ratio.map(|bound| shape.ratio_over(&bound));
        let edges = self.edge.map(|bound| bound.excess(corners));
        // The excess over a bound that is met is at most 1, but for rounding.
        sizes.chain(ratios).chain(edges).fold(1.0, f64::max)
    }

    /// The edges that splitting `t` may go down to near small angles: its own shortest edge, or, if
    /// it is too large, that of a cube of the volume wanted, or half of the longest allowed; this
    /// one alone counts along facets.
    pub(crate) fn limit(&self, state: &State, t: TetId, shape: &Shape) -> Limit {
        let corners = state.vertices(t).map(|v| state.at(v));
        self.limit_in(corners.each_ref(), state.marks.region(t), shape, &state.angles)
    }

    /// The edges that splitting a tetrahedron with these corners in a region may go down to.
    pub(crate) fn limit_in(
        &self,
        corners: [&Point; 4],
        region: u32,
        shape: &Shape,
        angles: &Angles,
    ) -> Limit {
        let own = self.volumes.get(region as usize).copied().flatten();
        let bounds = [own, self.field_bound(corners)];
        let exceeded = bounds.into_iter().flatten().filter(|bound| bound.excess(shape) >= 1.0);
        let long = self.edge.filter(|bound| bound.exceeded(corners));
        let halves = long.map(|bound| bound.length() / 2.0);
        let along = exceeded.map(|bound| cube_root(bound.volume())).chain(halves);
        let along = along.reduce(f64::min);
        let edge = shape.edge2.sqrt();
        let least = along.map_or(edge, |size| edge.min(size));
        Limit { least, along: along.filter(|_| angles.has_small()) }
    }

    /// The bound of the sizing field at the centroid: a volume with which edges usually have the
    /// wanted length. One that is not positive and finite bounds nothing; whether all
    /// are positive is checked in the end.
    fn field_bound(&self, corners: [&Point; 4]) -> Option<VolumeBound> {
        let volume = self.wanted_volume(self.field?(self.centroid(corners)));
        (volume > 0.0 && volume.is_finite()).then(|| VolumeBound::new(volume))
    }

    /// The largest volume where edges have usually a length, in the input's coordinates.
    fn wanted_volume(&self, length: f64) -> f64 {
        regular_volume(USUAL_EDGE * (length / self.fine_step))
    }

    /// The place at which the sizing field is asked for a tetrahedron.
    pub(crate) fn centroid(&self, corners: [&Point; 4]) -> Point {
        let [a, b, c, d] = sorted(corners.map(|c| *c));
        [0, 1, 2].map(|k| (a[k] + b[k] + c[k] + d[k]) * 0.25 * self.fine_step)
    }

    /// Has the sizing field, if there is one, a length for a tetrahedron?
    pub(crate) fn has_size_at(&self, corners: [&Point; 4]) -> bool {
        self.field.is_none_or(|field| self.wanted_volume(field(self.centroid(corners))) > 0.0)
    }

    /// Has the sizing field a length for each of some tetrahedra of the domain? Others may be asked
    /// for before, and come and go with the order of insertion.
    ///
    /// # Errors
    /// The first for which it has none.
    pub(crate) fn check_sizes(&self, state: &State, tets: &[TetId]) -> Result<(), RefineError> {
        let Some(field) = self.field else { return Ok(()) };
        for &t in tets {
            let v = state.vertices(t);
            if state.marks.region(t) == 0 || state.is_flat(v) {
                continue;
            }
            let at = self.centroid(v.map(|v| state.at(v)).each_ref());
            let value = field(at);
            let is_length = self.wanted_volume(value) > 0.0;
            if !is_length {
                return Err(RefineError::Size { at, value });
            }
        }
        Ok(())
    }
}

/// A tetrahedron of the domain by values.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Solid<T> {
    /// The tetrahedron.
    pub tet: T,
    /// Its corners, positively oriented.
    pub corners: [Point; 4],
    /// Its region.
    pub region: u32,
}

/// The numbers of the bits of a mask of four.
pub(crate) fn bits(mask: u32) -> impl Iterator<Item = usize> {
    (0..4).filter(move |k| mask >> k & 1 == 1)
}

/// At most four tetrahedra whose bounds are tested together.
#[derive(Default)]
pub(crate) struct Four {
    corners: FourCorners,
    regions: [u32; 4],
    count: usize,
}

impl Four {
    /// Adds a tetrahedron, of which there are fewer than four.
    #[inline(always)]
    pub(crate) fn push(&mut self, corners: [Point; 4], region: u32) {
        let lane = self.count % 4;
        for (to, corner) in self.corners.iter_mut().zip(corners) {
            for (to, coordinate) in to.iter_mut().zip(corner) {
                to[lane] = coordinate;
            }
        }
        self.regions[lane] = region;
        self.count = lane + 1;
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The corners of tetrahedron `lane`.
    #[inline(always)]
    pub(crate) fn corners(&self, lane: usize) -> [Point; 4] {
        self.corners.map(|corner| corner.map(|coordinate| coordinate[lane % 4]))
    }
}

#[cfg(test)]
mod tests {
    use super::cube_root;

    #[test]
    fn cube_roots_are_near() {
        for k in 0..2000 {
            let x = 1.7f64.powi(k - 1000) * (1.0 + f64::from(k) * 1e-3);
            let root = cube_root(x);
            assert!((root * root * root / x - 1.0).abs() < 1e-14, "{x}");
        }
    }
}
