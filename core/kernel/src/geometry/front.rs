//! The search for the corner in front of a face of a hole: its tetrahedron is Delaunay.
//!
//! The spheres through a face are ordered by how far they reach in front of it, so the corner is
//! the last one that is inside the sphere of the one before: one pass over all corners finds it,
//! from whichever it starts. It starts from the one that computing with roundings takes for the
//! right one; then nearly every test is decided by the sphere that the mesh caches anyway.

use super::Geometry;
use crate::cavity::hole::Front;
use crate::sphere::{Query, Sphere, simd};
use crate::topology::VertexId;
use ltbw_exact::Point;
use ltbw_exact::predicates::Sign;

/// Corners that are looked at together.
const LANES: usize = 4;
/// A corner that is nearer to the plane of a face, by the size of the hole, is no good guess.
const NEAR: f64 = 1e-10;

/// Some corners of a hole: differences to a point near by and their squared lengths, and the
/// corners as query points. Lanes without a corner have no numbers.
#[derive(Clone, Copy, Debug)]
struct Corners {
    x: [f64; LANES],
    y: [f64; LANES],
    z: [f64; LANES],
    square: [f64; LANES],
    query: [[f32; LANES]; 3],
}

impl Corners {
    const NONE: Self = Self {
        x: [f64::NAN; LANES],
        y: [f64::NAN; LANES],
        z: [f64::NAN; LANES],
        square: [f64::NAN; LANES],
        query: [[f32::NAN; LANES]; 3],
    };

    #[inline(always)]
    fn place(&self, lane: usize) -> [f64; 3] {
        [self.x[lane], self.y[lane], self.z[lane]]
    }

    /// Is each certainly outside the sphere? 1 or 0.
    #[inline(always)]
    fn outside(&self, sphere: &Sphere) -> [u32; LANES] {
        let [x, y, z] = &self.query;
        std::array::from_fn(|k| u32::from(sphere.is_outside(&Query([x[k], y[k], z[k], 0.0]))))
    }
}

/// The corners of a hole, and the spheres of its filling: memory that is used again.
#[derive(Debug, Default)]
pub(crate) struct Rim {
    corners: Vec<Corners>,
    /// The square of the distance of the farthest corner.
    size: f64,
    /// Spheres of the tetrahedra that were asked for, in their order.
    pub(crate) spheres: Vec<Sphere>,
}

/// The search in one hole.
#[derive(Debug)]
pub(crate) struct InFront<'a> {
    geometry: &'a mut Geometry,
    rim: &'a mut Rim,
}

impl<'a> InFront<'a> {
    /// The search among `corners`, for the hole around `p`.
    pub(crate) fn new(
        geometry: &'a mut Geometry,
        rim: &'a mut Rim,
        corners: &[VertexId],
        p: &Point,
    ) -> Self {
        geometry.step_in_work = geometry.step;
        rim.corners.clear();
        rim.spheres.clear();
        rim.size = 0.0;
        for some in corners.chunks(LANES) {
            let mut all = Corners::NONE;
            for (lane, &v) in some.iter().enumerate() {
                let q = geometry.points.at(v);
                let [x, y, z] = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
                let square = x * x + y * y + z * z;
                rim.size = rim.size.max(square);
                (all.x[lane], all.y[lane], all.z[lane], all.square[lane]) = (x, y, z, square);
                let query = geometry.frame.as_ref().map_or(Query::NOWHERE, |f| f.query(q)).0;
                (0..3).for_each(|k| all.query[k][lane] = query[k]);
            }
            rim.corners.push(all);
        }
        Self { geometry, rim }
    }

    /// The corner that is the right one as far as rounded numbers tell: a hint.
    #[inline(always)]
    fn guess(&self, face: [u32; 3]) -> Option<u32> {
        let all = &self.rim.corners;
        let at = |k: u32| all[k as usize / LANES].place(k as usize % LANES);
        let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let [a, b, c] = face.map(at);
        let (b, c) = (minus(b, a), minus(c, a));
        // Across the face, into the hole.
        let n = cross(c, b);
        // The smallest sphere through the face is |x - a|² + l (x - a) = 0; any other one is that
        // less a multiple of n (x - a), which is least for the corner that is asked for.
        let (square_b, square_c, square_n) = (dot(b, b), dot(c, c), dot(n, n));
        let (from_b, from_c, inverse) = (cross(c, n), cross(n, b), 1.0 / square_n);
        let l = [0, 1, 2].map(|k| (square_b * from_b[k] + square_c * from_c[k]) * inverse);
        let m = [0, 1, 2].map(|k| l[k] - 2.0 * a[k]);
        let (constant, level) = (dot(a, a) - dot(l, a), dot(n, a));
        let least = NEAR * (square_n * self.rim.size).sqrt();
        let (mut best, mut groups) = ([f64::INFINITY; LANES], [f64::NAN; LANES]);
        for (group, some) in all.iter().enumerate() {
            for lane in 0..LANES {
                let p = some.place(lane);
                let height = dot(n, p) - level;
                let value = (some.square[lane] + dot(m, p) + constant) / height;
                let is_better = (height > least) & (value < best[lane]);
                best[lane] = if is_better { value } else { best[lane] };
                groups[lane] = if is_better { group as f64 } else { groups[lane] };
            }
        }
        let lane =
            (1..LANES).fold(0, |one, other| if best[other] < best[one] { other } else { one });
        let group = groups[lane];
        (group >= 0.0).then_some((group as usize * LANES + lane) as u32)
    }

    /// Are all corners but four certainly outside the sphere? Those on it never are.
    #[inline(always)]
    fn is_empty(&self, sphere: &Sphere, count: usize) -> bool {
        let mut outside = [0; LANES];
        for some in &self.rim.corners {
            let are_outside = some.outside(sphere);
            (0..LANES).for_each(|lane| outside[lane] += are_outside[lane]);
        }
        outside.iter().sum::<u32>() as usize + 4 == count
    }

    fn is_in_front(&mut self, face: [VertexId; 3], v: VertexId) -> bool {
        let p = *self.geometry.points.at(v);
        self.geometry.orient(face, &p) == Sign::Negative
    }
}

impl InFront<'_> {
    /// The corner that is asked for, from one that lies in front of the face; and its sphere.
    #[inline(never)]
    fn improve(&mut self, corners: &[VertexId], face: [u32; 3], first: u32) -> (u32, Sphere) {
        let at = |k: u32| corners[k as usize];
        let [a, b, c] = face.map(at);
        let mut apex = first;
        let mut sphere = self.geometry.compute_sphere([at(apex), a, b, c]);
        for group in 0..self.rim.corners.len() {
            let base = (LANES * group) as u32;
            let is_other = |k: u32| (k as usize) < corners.len() && !face.contains(&k);
            let mut open = (0..4).fold(0, |mask, k| mask | u32::from(is_other(base + k)) << k);
            loop {
                let outside = self.rim.corners[group].outside(&sphere);
                open &= (0..4).fold(u32::MAX, |mask, k| mask & !(outside[k] << k));
                open &= !(u32::from(apex & !3 == base) << (apex & 3));
                open &= self.undecided([at(apex), a, b, c], &corners[base as usize..], open);
                if open == 0 {
                    break;
                }
                let k = open.trailing_zeros();
                open &= open - 1;
                let p = *self.geometry.points.at(at(base + k));
                if self.geometry.predicates().in_conflict([at(apex), a, b, c], &p) {
                    apex = base + k;
                    sphere = self.geometry.compute_sphere([at(apex), a, b, c]);
                }
            }
        }
        (apex, sphere)
    }

    /// The mask `open` of the first corners without those that are certain to be outside the sphere
    /// of the tetrahedron `v`.
    #[inline(always)]
    fn undecided(&self, v: [VertexId; 4], corners: &[VertexId], open: u32) -> u32 {
        if open & open.wrapping_sub(1) == 0 || self.geometry.wide {
            return open;
        }
        let [apex, a, b, c] = v;
        let corner = |k: usize| corners.get(k).copied().unwrap_or(apex);
        let tets = [0, 1, 2, 3].map(|k| [corner(k), a, b, c]);
        // With corner and apex exchanged the determinant has the other sign.
        open & !simd::filter_insphere(&self.geometry.points, tets, self.geometry.point(apex)).0
    }
}

impl Front for InFront<'_> {
    fn apex(&mut self, corners: &[VertexId], face: [u32; 3]) -> Option<u32> {
        let at = |k: u32| corners[k as usize];
        let [a, b, c] = face.map(at);
        let guess = self.guess(face).filter(|&k| self.is_in_front([a, b, c], at(k)));
        let mut others = (0..corners.len() as u32).filter(|k| !face.contains(k));
        // Whether any is in front is exact.
        let first = guess.or_else(|| others.find(|&k| self.is_in_front([a, b, c], at(k))));
        let Some(mut apex) = first else {
            self.rim.spheres.push(Sphere::UNKNOWN);
            return None;
        };
        let mut sphere = self.geometry.compute_sphere([at(apex), a, b, c]);
        if !self.is_empty(&sphere, corners.len()) {
            (apex, sphere) = self.improve(corners, face, apex);
        }
        self.rim.spheres.push(sphere);
        Some(apex)
    }
}
