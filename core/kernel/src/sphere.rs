//! A cached, low-precision circumsphere per tetrahedron: 16 bytes that decide nearly every
//! in-sphere test without touching a vertex.
//!
//! Everything is in the *frame* of the mesh: coordinates shifted by the centre of the bounding
//! box and scaled by a power of two, so that the box lies in [-1, 1]^3. A sphere stores centre
//! and radius in single precision; [`TOLERANCE`] covers every rounding, so an answer is certain:
//! `docs/numerics.md` (section "Cached spheres") says what of this is proved.
//!
//! A sphere that cannot be bounded (flat, huge, or a ghost's) has NaN as its radius, and a query
//! outside the frame has NaN coordinates; every comparison then fails and the exact test is made.

mod constants;
pub(crate) mod simd;

pub(crate) use constants::{FLATNESS, LEAST_SQUARE, MAX_RADIUS, TOLERANCE};

use crate::arena::{Arena, zeroable};
use crate::cavity::SMALL;
use crate::topology::{TetId, VertexId};
use ltbw_exact::Point;

/// The radius of what stands in place of a sphere, a NaN that no computation makes: the first of
/// two, one for each [`TagKind`].
const TAGGED: u32 = 0x7fc5_e714;

/// Centre and radius, in the frame. A radius that is NaN decides nothing.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(crate) struct Sphere(pub(crate) [f32; 4]);

zeroable!(Sphere { 0: numbers });

/// The frame of a mesh: where and how large its box is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    origin: Point,
    scale: f64,
}

impl Frame {
    /// The frame of a box with corners `low` and `high`; `None` if the box is so large or small
    /// that the scale or a difference leaves the range of f64 (no sphere is cached then).
    pub(crate) fn of_box(low: Point, high: Point) -> Option<Self> {
        let origin = [0, 1, 2].map(|k| low[k] * 0.5 + high[k] * 0.5);
        let half =
            (0..3).map(|k| (high[k] - origin[k]).max(origin[k] - low[k])).fold(0.0, f64::max);
        if !(half > 1e-150 && half < 1e150) {
            return None;
        }
        // The power of two at or above `half`, then one over it: exact.
        let mut power = f64::from_bits(half.to_bits() & 0x7ff0_0000_0000_0000);
        if power < half {
            power *= 2.0;
        }
        Some(Self { origin, scale: 1.0 / power })
    }

    /// `p` in the frame, in double precision.
    #[inline(always)]
    fn place(&self, p: &Point) -> Point {
        [0, 1, 2].map(|k| (p[k] - self.origin[k]) * self.scale)
    }

    /// `p` as a query point: NaN outside the frame.
    #[inline(always)]
    pub(crate) fn query(&self, p: &Point) -> Query {
        let q = self.place(p);
        let inside = q.iter().all(|c| c.abs() <= 1.0);
        let q = [q[0], q[1], q[2], 0.0].map(|c| c as f32);
        Query(if inside { q } else { [f32::NAN; 4] })
    }
}

/// A point in the frame, rounded to single precision; the fourth number means nothing. Of 16 bytes,
/// so that it can be written and read as one: a processor waits where it reads at once what was
/// written in pieces.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(crate) struct Query(pub(crate) [f32; 4]);

/// Why a slot is tagged, as far as geometry knows: it means something to whoever tagged it, who has
/// a table of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum TagKind {
    First = 0,
    Second = 1,
}

/// The answer of a cached sphere for a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Inside,
    Outside,
    Unknown,
}

impl Query {
    /// A point that no sphere decides.
    pub(crate) const NOWHERE: Self = Self([f32::NAN; 4]);
}

impl Sphere {
    /// The sphere that decides nothing.
    pub(crate) const UNKNOWN: Self = Self([0.0, 0.0, 0.0, f32::NAN]);

    /// In place of a sphere: the slot is tagged with a number below 2^30. It decides nothing.
    #[inline]
    pub(crate) fn tagged(kind: TagKind, number: u32) -> Self {
        // Numbers from 1 up: none is subnormal, which would be slow to compute with.
        let radius = f32::from_bits(TAGGED + kind as u32);
        Self([f32::from_bits(1f32.to_bits() + number), 0.0, 0.0, radius])
    }

    /// The number that [`Sphere::tagged`] was given with this tag, if this is one of those.
    #[inline(always)]
    pub(crate) fn number(self, kind: TagKind) -> Option<u32> {
        let is_tagged = self.0[3].to_bits() == TAGGED + kind as u32;
        is_tagged.then(|| self.0[0].to_bits() - 1f32.to_bits())
    }

    /// Can it decide nothing, of whatever point?
    #[inline(always)]
    pub(crate) fn is_blank(self) -> bool {
        self.0[3].is_nan()
    }

    /// Its four numbers, to the bit.
    pub(crate) fn bits(&self) -> [u32; 4] {
        self.0.map(f32::to_bits)
    }

    /// Is `q` certainly outside?
    #[inline(always)]
    pub(crate) fn is_outside(&self, q: &Query) -> bool {
        let ([x, y, z, r], [qx, qy, qz, _]) = (self.0, q.0);
        let (dx, dy, dz) = (qx - x, qy - y, qz - z);
        dx * dx + dy * dy + dz * dz > (r + TOLERANCE) * (r + TOLERANCE)
    }

    /// Is `q` certainly inside or outside?
    #[inline(always)]
    pub(crate) fn test(&self, q: &Query) -> Verdict {
        let [x, y, z, r] = self.0;
        let (dx, dy, dz) = (q.0[0] - x, q.0[1] - y, q.0[2] - z);
        let s = dx * dx + dy * dy + dz * dz;
        let (far, near) = (r + TOLERANCE, r - TOLERANCE);
        if s > far * far {
            Verdict::Outside
        } else if s < near * near && near > 0.0 {
            Verdict::Inside
        } else {
            Verdict::Unknown
        }
    }
}

/// Computes spheres of tetrahedra around one vertex.
///
/// Vertices other than it are given by number into a *rim*: the differences to the vertex with
/// their squared length.
#[derive(Clone, Debug)]
pub(crate) struct SphereBuilder {
    /// The vertex, in the frame.
    pub(crate) centre: Point,
    /// From input units to the frame.
    pub(crate) scale: f64,
    /// Differences x, y, z and squared length.
    pub(crate) rim: [[f64; 4]; SMALL],
}

impl Default for SphereBuilder {
    fn default() -> Self {
        Self { centre: [0.0; 3], scale: 0.0, rim: [[0.0; 4]; SMALL] }
    }
}

impl SphereBuilder {
    /// Aims at the star of the vertex at `p`; the vertex at infinity must have NaN coordinates.
    /// `false` if `p` lies outside the frame: then no sphere of the star can be bounded.
    #[inline(always)]
    pub(crate) fn at_apex(
        &mut self,
        frame: &Frame,
        points: &Arena<Point>,
        rim: &[VertexId],
        p: &Point,
    ) -> bool {
        self.centre = frame.place(p);
        if !self.centre.iter().all(|c| c.abs() <= 1.0) {
            return false;
        }
        self.scale = frame.scale;
        for (d, &v) in self.rim.iter_mut().zip(rim) {
            let q = points.at(v);
            let (x, y, z) = (q[0] - p[0], q[1] - p[1], q[2] - p[2]);
            *d = [x, y, z, x * x + y * y + z * z];
        }
        true
    }

    /// The sphere through the vertex and three others: the plain twin of [`simd`]'s
    /// vector code.
    ///
    /// With A, B, C the differences to the vertex p, the centre is p + N / D for
    /// N = |A|^2 (B x C) + |B|^2 (C x A) + |C|^2 (A x B) and D = 2 A . (B x C).
    pub(crate) fn sphere(&self, face: [u8; 4]) -> Sphere {
        let [a, b, c] = [0, 1, 2].map(|k| &self.rim[face[k] as usize % SMALL]);
        let cross = |p: &[f64; 4], q: &[f64; 4]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
        let det = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2];
        let det = det + det;
        let inverse = 1.0 / det;
        let offset = [0, 1, 2].map(|k| (a[3] * bc[k] + b[3] * ca[k] + c[3] * ab[k]) * inverse);
        let square = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
        let radius = square.sqrt();
        let longest = a[3].max(b[3]).max(c[3]);
        let scaled = radius * self.scale;
        let sound = det.abs() > FLATNESS * (longest * radius)
            && square >= LEAST_SQUARE * longest
            && scaled <= MAX_RADIUS;
        let [x, y, z] = [0, 1, 2].map(|k| (self.centre[k] + offset[k] * self.scale) as f32);
        Sphere([x, y, z, if sound { scaled as f32 } else { f32::NAN }])
    }

    /// Caches the spheres of `tets`, on the faces `faces` of the rim.
    #[inline(always)]
    pub(crate) fn make(&self, spheres: &mut Arena<Sphere>, tets: &[TetId], faces: &[[u8; 4]]) {
        if !simd::make_spheres(self, spheres, tets, faces) {
            for (&t, &face) in tets.iter().zip(faces) {
                *spheres.at_mut(t) = self.sphere(face);
            }
        }
    }
}

#[cfg(test)]
mod tests;
