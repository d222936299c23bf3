//! The geometry of a mesh: kernel points, cached spheres, and the conflict test. It changes no
//! topology. A slot may be *tagged* in place of its sphere: it never sees by whom, or why.
//!
//! A conflict test goes through up to four stages, each certain when it answers: the cached
//! sphere, the semi-static filter, exact arithmetic, symbolic perturbation.

mod front;
mod shared;

pub(crate) use front::{InFront, Rim};
pub(crate) use shared::SharedConflict;

use crate::arena::Arena;
use crate::cavity::{Conflict, Star};
use crate::sphere::{Frame, Query, Sphere, SphereBuilder, Verdict, simd};
use crate::topology::{INFINITE, TetId, Topology, VertexId};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, exact, filter, perturb};

/// The numbers of predicate calls, and of those that needed more than a filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PredicateStats {
    /// Orientation tests.
    pub orient3d_calls: u64,
    /// Orientation tests that the filter left open.
    pub orient3d_exact: u64,
    /// Conflict tests of the cavity searches that succeeded, those of ghosts included: one for
    /// each tetrahedron of the cavity but the first, and one for each face of its boundary.
    pub insphere_calls: u64,
    /// Conflict tests that neither the cached sphere nor the filter decided.
    pub insphere_exact: u64,
    /// Conflict tests whose exact answer was zero: symbolic perturbation decided.
    pub insphere_perturbed: u64,
    /// Conflict tests that the cached sphere left to the filter.
    pub sphere_undecided: u64,
}

impl std::ops::AddAssign for PredicateStats {
    fn add_assign(&mut self, other: Self) {
        self.orient3d_calls += other.orient3d_calls;
        self.orient3d_exact += other.orient3d_exact;
        self.insphere_calls += other.insphere_calls;
        self.insphere_exact += other.insphere_exact;
        self.insphere_perturbed += other.insphere_perturbed;
        self.sphere_undecided += other.sphere_undecided;
    }
}

/// Points, spheres and counters of one mesh.
#[derive(Clone, Debug)]
pub(crate) struct Geometry {
    /// Kernel coordinates by vertex; entry 0 stands for the vertex at infinity.
    points: Arena<Point>,
    /// Cached spheres by tetrahedron slot.
    spheres: Arena<Sphere>,
    /// `None`: no sphere is cached.
    frame: Option<Frame>,
    /// Some point lies outside the exactness window: filters are guarded.
    wide: bool,
    /// A power of two of which all coordinates are multiples; zero if it is not known.
    step: f64,
    /// A step of all coordinates and those of the point in work.
    step_in_work: f64,
    builder: SphereBuilder,
    pub(crate) stats: PredicateStats,
}

impl Geometry {
    /// Geometry for points in the box `low`..`high`; `wide`: any finite coordinates.
    pub(crate) fn new(low: Point, high: Point, wide: bool, vertices: usize, tets: usize) -> Self {
        let mut points = Arena::with_capacity(vertices + 1);
        points.push([f64::NAN; 3]);
        let frame = if wide { None } else { Frame::of_box(low, high) };
        Self {
            points,
            // In wide mode they only mark that nothing is known.
            spheres: Arena::with_capacity(if wide { 0 } else { tets }),
            frame,
            wide,
            step: if wide { 0.0 } else { f64::INFINITY },
            step_in_work: 0.0,
            builder: SphereBuilder::default(),
            stats: PredicateStats::default(),
        }
    }

    /// Geometry of a submesh that begins with vertices 1 to `vertices`. `step` is a power of two of
    /// which all coordinates are multiples, or zero.
    pub(crate) fn submesh(low: Point, high: Point, wide: bool, step: f64, vertices: usize) -> Self {
        let mut geometry = Self::new(low, high, wide, 0, 0);
        geometry.points = Arena::filled([0.0; 3], vertices + 1);
        *geometry.points.at_mut(INFINITE) = [f64::NAN; 3];
        geometry.step = if wide { 0.0 } else { step };
        geometry
    }

    /// These points and spheres under another name, for one of several threads; predicate calls
    /// are counted from zero.
    ///
    /// # Safety
    /// As of [`Arena::alias`].
    #[allow(unsafe_code)]
    pub(crate) unsafe fn alias(&mut self) -> Self {
        // SAFETY: as promised.
        let (points, spheres) = unsafe { (self.points.alias(), self.spheres.alias()) };
        let (builder, stats) = (SphereBuilder::default(), PredicateStats::default());
        Self { points, spheres, builder, stats, ..*self }
    }

    /// Gives vertex `v` of a submesh its coordinates.
    #[inline(always)]
    pub(crate) fn set_point(&mut self, v: VertexId, p: Point) {
        *self.points.at_mut(v) = p;
    }

    /// Makes room for the coordinates of vertices up to `last`.
    pub(crate) fn grow_points(&mut self, last: VertexId) {
        self.points.grow(last.index() + 1, [0.0; 3]);
    }

    /// Says that the mesh has a vertex at `p` that is none of the points that the step was made of.
    pub(crate) fn refine_step(&mut self, p: &Point) {
        if !self.wide {
            self.step = self.step.min(lattice_step(p));
        }
    }

    /// Says that `count` vertices from `first` on get coordinates. A hint.
    pub(crate) fn prepare_points(&self, first: VertexId, count: usize) {
        let first = first.index();
        self.points.prepare(first..first.saturating_add(count));
    }

    /// The cached sphere of `t`.
    #[inline(always)]
    pub(crate) fn sphere(&self, t: TetId) -> Sphere {
        *self.spheres.at(t)
    }

    /// Asks the processor to fetch the cached sphere of `t`.
    #[inline(always)]
    pub(crate) fn prefetch_sphere(&self, t: TetId) {
        self.spheres.prefetch(t);
    }

    /// A hint to fetch a vertex.
    #[inline(always)]
    pub(crate) fn prefetch_point(&self, v: VertexId) {
        self.points.prefetch(v);
    }

    /// Replaces the cached sphere of `t`.
    #[inline(always)]
    pub(crate) fn set_sphere(&mut self, t: TetId, sphere: Sphere) {
        *self.spheres.at_mut(t) = sphere;
    }

    /// Appends the spheres of another submesh's `other_slots` slots to those of `slots` slots.
    pub(crate) fn append_spheres(&mut self, slots: usize, other: Self, other_slots: usize) {
        self.reserve_spheres(slots);
        // Either may have vertices that the other has not.
        self.step = self.step.min(other.step);
        self.spheres.append(other.spheres, other_slots, |sphere| sphere);
    }

    /// Replaces the coordinates of all vertices, the one at infinity included.
    pub(crate) fn set_points(&mut self, points: Arena<Point>) {
        self.points = points;
    }

    /// Reserves room for the spheres of `tets` slots. A hint.
    pub(crate) fn reserve_sphere_capacity(&mut self, tets: usize) {
        self.spheres = Arena::with_capacity(if self.wide { 0 } else { tets });
    }

    /// Takes memory for this many points and spheres. A hint.
    pub(crate) fn expect(&mut self, points: usize, spheres: usize) {
        self.points.expect(points);
        if !self.wide {
            self.spheres.expect(spheres);
        }
    }

    /// Makes room for the spheres of `slots` slots.
    pub(crate) fn reserve_spheres(&mut self, slots: usize) {
        self.spheres.grow(slots, Sphere::UNKNOWN);
    }

    /// The sphere of a tetrahedron with these vertices.
    pub(crate) fn compute_sphere(&mut self, v: [VertexId; 4]) -> Sphere {
        let Some(frame) = &self.frame else { return Sphere::UNKNOWN };
        let p = *self.points.at(v[0]);
        if v[3] == INFINITE || !self.builder.at_apex(frame, &self.points, &v[1..], &p) {
            return Sphere::UNKNOWN;
        }
        self.builder.sphere([0, 1, 2, 0])
    }

    pub(crate) fn points(&self) -> &[Point] {
        self.points.all()
    }

    #[inline(always)]
    pub(crate) fn point(&self, v: VertexId) -> &Point {
        self.points.at(v)
    }

    /// Coordinates of a vertex, if there is one.
    pub(crate) fn get_point(&self, v: VertexId) -> Option<&Point> {
        self.points.get(v)
    }

    pub(crate) fn push(&mut self, p: Point) {
        self.step = self.step.min(lattice_step(&p));
        self.points.push(p);
    }

    /// The coordinates of the next vertex, `v`. Where an insertion was taken back there is a place.
    #[inline(always)]
    pub(crate) fn put_point(&mut self, v: VertexId, p: Point) {
        if v.index() < self.points.all().len() {
            self.step = self.step.min(lattice_step(&p));
            *self.points.at_mut(v) = p;
        } else {
            self.push(p);
        }
    }

    /// Bytes of memory that the arrays hold.
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(self.points.all()) + size_of_val(self.spheres.all())
    }

    /// Goes to wide mode, with all coordinates replaced by `rescale` of them, which must be exact.
    pub(crate) fn widen(&mut self, rescale: impl Fn(&Point) -> Point) {
        for p in &mut self.points.all_mut()[1..] {
            *p = rescale(p);
        }
        self.spheres.all_mut().fill(Sphere::UNKNOWN);
        self.frame = None;
        self.wide = true;
        (self.step, self.step_in_work) = (0.0, 0.0);
    }

    /// The predicates of the point in work.
    #[inline(always)]
    fn predicates(&mut self) -> Predicates<'_> {
        let Self { points, wide, step_in_work, stats, .. } = self;
        Predicates { points, wide: *wide, step: *step_in_work, stats }
    }

    /// Sign of orient3d of vertices `a`, `b`, `c` and the point `p`, filtered and counted.
    #[inline(always)]
    pub(crate) fn orient(&mut self, v: [VertexId; 3], p: &Point) -> Sign {
        self.predicates().orient(v, p)
    }

    /// Is `p` inside the perturbed circumsphere of `t`? The cached sphere has not decided.
    #[inline(never)]
    fn conflict_by_points(&mut self, topology: &Topology, t: TetId, p: &Point) -> bool {
        self.predicates().in_conflict(topology.tet(t).vertices(), p)
    }

    /// Caches the spheres of the star around `p`; there are `slots` slots now.
    #[inline(always)]
    pub(crate) fn created(&mut self, slots: usize, star: &Star<'_>, p: &Point) {
        self.spheres.grow(slots, Sphere::UNKNOWN);
        let Some(frame) = &self.frame else { return };
        if !star.rim.is_empty() && self.builder.at_apex(frame, &self.points, star.rim, p) {
            self.builder.make(&mut self.spheres, star.tets, star.faces);
        } else {
            for &t in star.tets {
                *self.spheres.at_mut(t) = Sphere::UNKNOWN;
            }
        }
    }

    /// The side of `t`'s cached sphere on which `p` lies; `None` if the sphere does not tell.
    pub(crate) fn cached_side(&self, t: TetId, p: &Point) -> Option<Sign> {
        self.side(*self.spheres.at(t), p)
    }

    /// The side of a sphere of this frame on which `p` lies; `None` if the sphere does not tell.
    pub(crate) fn side(&self, sphere: Sphere, p: &Point) -> Option<Sign> {
        match sphere.test(&self.frame?.query(p)) {
            Verdict::Inside => Some(Sign::Positive),
            Verdict::Outside => Some(Sign::Negative),
            Verdict::Unknown => None,
        }
    }

    /// The cached spheres and the lattice step, to the bit.
    pub(crate) fn spheres_fingerprint(&self) -> Vec<[u32; 4]> {
        let step = self.step.to_bits();
        let step = [step as u32, (step >> 32) as u32, 0, 0];
        self.spheres.all().iter().map(Sphere::bits).chain([step]).collect()
    }

    /// The conflict test for `p`.
    pub(crate) fn conflict_of(&mut self, p: &Point) -> PointConflict<'_> {
        self.step_in_work = self.step.min(lattice_step(p));
        let query = self.frame.as_ref().map_or(Query::NOWHERE, |f| f.query(p));
        PointConflict { geometry: self, p: *p, query }
    }
}

/// The largest power of two of which the coordinates of all `points` are multiples; infinite if
/// there are none but zeros. The points are in the exactness window.
pub(crate) fn common_step(points: &[Point]) -> f64 {
    points.iter().map(lattice_step).fold(f64::INFINITY, f64::min)
}

/// The largest power of two of which all three coordinates are multiples; infinite for zero.
/// Coordinates are in the exactness window, so that it is a normal number.
#[inline(always)]
fn lattice_step(p: &Point) -> f64 {
    let step = |c: f64| {
        let bits = c.to_bits();
        let exponent = (bits >> 52) & 0x7ff;
        // The lowest set bit of the significand, the hidden one included, counts from 2^-52.
        let lowest = (bits & ((1 << 52) - 1) | 1 << 52).trailing_zeros();
        let power = (exponent + u64::from(lowest)).wrapping_sub(52);
        if c == 0.0 { f64::INFINITY } else { f64::from_bits((power & 0x7ff) << 52) }
    };
    step(p[0]).min(step(p[1])).min(step(p[2]))
}

/// Predicates of vertices and one point, filtered and counted.
#[derive(Debug)]
struct Predicates<'a> {
    points: &'a Arena<Point>,
    /// See [`Geometry::wide`].
    wide: bool,
    /// See [`Geometry::step_in_work`].
    step: f64,
    stats: &'a mut PredicateStats,
}

impl Predicates<'_> {
    #[inline(always)]
    fn orient(&mut self, [a, b, c]: [VertexId; 3], p: &Point) -> Sign {
        self.stats.orient3d_calls += 1;
        let [a, b, c] = [a, b, c].map(|v| self.points.at(v));
        let fast = if self.wide {
            filter::orient3d_any(a, b, c, p)
        } else {
            filter::orient3d_lattice(a, b, c, p, self.step)
        };
        match fast {
            Some(sign) => sign,
            None => {
                self.stats.orient3d_exact += 1;
                exact::orient3d(a, b, c, p)
            }
        }
    }

    /// Is `p` in the perturbed circumsphere of a tetrahedron? The cached sphere has not decided.
    #[inline(always)]
    fn in_conflict(&mut self, [a, b, c, d]: [VertexId; 4], p: &Point) -> bool {
        if d == INFINITE {
            let sign = match self.orient([a, b, c], p) {
                Sign::Zero => {
                    let [a, b, c] = [a, b, c].map(|v| self.points.at(v));
                    perturb::side_of_circle(a, b, c, p)
                }
                sign => sign,
            };
            return sign == Sign::Positive;
        }
        let [a, b, c, d] = [a, b, c, d].map(|v| self.points.at(v));
        self.stats.sphere_undecided += 1;
        let fast = if self.wide {
            filter::insphere_any(a, b, c, d, p)
        } else {
            filter::insphere_lattice([a, b, c, d], p, self.step)
        };
        let sign = fast.unwrap_or_else(|| {
            self.stats.insphere_exact += 1;
            exact::insphere(a, b, c, d, p)
        });
        let sign = if sign == Sign::Zero {
            self.stats.insphere_perturbed += 1;
            perturb::perturbed_side(a, b, c, d, p)
        } else {
            sign
        };
        sign == Sign::Positive
    }

    /// Which of four are in conflict for certain, of those that the mask `unknown` asks for, and
    /// which of these are still unknown.
    #[inline(always)]
    fn filter(
        &mut self,
        topology: &Topology,
        tets: [TetId; 4],
        unknown: u32,
        p: &Point,
    ) -> (u32, u32) {
        // Two or more: the vector filter pays.
        if unknown & (unknown - 1) == 0 || self.wide {
            return (0, unknown);
        }
        let corners = tets.map(|t| topology.tet(t).vertices());
        let (inside, outside) = simd::filter_insphere(self.points, corners, p);
        let open = unknown & !(inside | outside);
        self.stats.sphere_undecided += u64::from((unknown & !open).count_ones());
        (inside & unknown, open)
    }
}

/// Decides what is still open, one after the other; adds it to the known `conflicts`.
#[inline(always)]
fn decide_rest(
    conflict: &mut impl Conflict,
    topology: &Topology,
    tets: [TetId; 4],
    mut conflicts: u32,
    mut open: u32,
) -> u32 {
    while open != 0 {
        if conflict.in_conflict(topology, tets[open.trailing_zeros() as usize & 3]) {
            conflicts |= open & open.wrapping_neg();
        }
        open &= open - 1;
    }
    conflicts
}

/// [`Conflict`] with one point.
#[derive(Debug)]
pub(crate) struct PointConflict<'a> {
    geometry: &'a mut Geometry,
    p: Point,
    query: Query,
}

impl PointConflict<'_> {
    /// Is `t` in conflict for certain, by its cached sphere alone?
    #[inline(always)]
    pub(crate) fn sphere_says_inside(&self, t: TetId) -> bool {
        self.geometry.spheres.at(t).test(&self.query) == Verdict::Inside
    }

    #[inline(always)]
    pub(crate) fn geometry(&mut self) -> &mut Geometry {
        self.geometry
    }

    #[inline(always)]
    pub(crate) fn target(&self) -> Point {
        self.p
    }
}

impl Conflict for PointConflict<'_> {
    #[inline(always)]
    fn prefetch(&self, t: TetId) {
        self.geometry.prefetch_sphere(t);
    }

    #[inline(always)]
    fn by_sphere(&self, tets: [TetId; 4]) -> (u32, u32) {
        simd::test_spheres(tets.map(|t| self.geometry.spheres.at(t)), &self.query)
    }

    #[inline(never)]
    fn by_points(&mut self, topology: &Topology, tets: [TetId; 4], unknown: u32) -> u32 {
        let (conflicts, open) = self.geometry.predicates().filter(topology, tets, unknown, &self.p);
        decide_rest(self, topology, tets, conflicts, open)
    }

    #[cold]
    fn in_conflict(&mut self, topology: &Topology, t: TetId) -> bool {
        let p = self.p;
        self.geometry.conflict_by_points(topology, t, &p)
    }
}

#[cfg(test)]
mod tests {
    use super::lattice_step;

    #[test]
    fn the_step_divides_the_coordinates_and_twice_the_step_does_not() {
        assert_eq!(lattice_step(&[0.0; 3]), f64::INFINITY);
        assert_eq!(lattice_step(&[0.0, -12.0, 64.0]), 4.0);
        assert_eq!(lattice_step(&[0.1, 1.0, 1.0]), 2f64.powi(-55));
        for exponent in -142..200 {
            let unit = 2f64.powi(exponent);
            for k in [1.0, 3.0, 5.0, 4503599627370497.0] {
                assert_eq!(lattice_step(&[-k * unit, 0.0, 8.0 * unit]), unit, "{k} 2^{exponent}");
                assert_eq!(lattice_step(&[0.0, 6.0 * unit, 16.0 * unit]), 2.0 * unit);
            }
        }
    }
}
