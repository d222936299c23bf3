//! Vector code for the cached spheres and the in-sphere filter, with plain twins and tests that
//! they agree: one of the modules with unsafe code (see the crate).
#![allow(unsafe_code)]

use super::{Query, Sphere, SphereBuilder};
use crate::arena::Arena;
use crate::topology::{TetId, VertexId};
use ltbw_exact::Point;

/// Caches spheres with AVX2, four at a time, bit for bit as [`SphereBuilder::sphere`] does; `false`
/// if the machine has no AVX2.
#[inline(always)]
pub(crate) fn make_spheres(
    builder: &SphereBuilder,
    spheres: &mut Arena<Sphere>,
    tets: &[TetId],
    faces: &[[u8; 4]],
) -> bool {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the machine has AVX2.
        unsafe { x86::make_spheres(builder, spheres, tets, faces) };
        return true;
    }
    let _ = (builder, spheres, tets, faces);
    false
}

/// The answers of four spheres for a point, as bit masks `(inside, outside)`: [`Sphere::test`] of
/// each.
#[inline(always)]
pub(crate) fn test_spheres(spheres: [&Sphere; 4], q: &Query) -> (u32, u32) {
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: SSE2 is part of x86-64.
        unsafe { x86::test_spheres(spheres, q) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        use crate::sphere::Verdict;
        let mask = |v| (0..4).map(|k| u32::from(spheres[k].test(q) == v) << k).sum();
        (mask(Verdict::Inside), mask(Verdict::Outside))
    }
}

/// [`ltbw_exact::predicates::filter::insphere_window`] of a point and four tetrahedra at once, as
/// bit masks `(inside, outside)`; nothing is decided of a ghost (its point is NaN), nor on a
/// machine without AVX2.
#[inline(always)]
pub(crate) fn filter_insphere(
    points: &Arena<Point>,
    tets: [[VertexId; 4]; 4],
    p: &Point,
) -> (u32, u32) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the machine has AVX2.
        return unsafe { x86::filter_insphere(points, tets, p) };
    }
    let _ = (points, tets, p);
    (0, 0)
}

/// Corners of four tetrahedra: of each corner each coordinate, one number a tetrahedron.
pub type FourCorners = [[[f64; 4]; 3]; 4];

/// Which of four positively oriented tetrahedra exceed a volume of their own, or a bound on
/// circumradius to shortest edge, which exceed neither, and which, if there is such a bound, have
/// D² l² > `thick` L⁸, D being the determinant, l and L the shortest and the longest edge: three
/// bit masks. What exceeds a bound is told by [`exceeds_volume_any`] and
/// [`exceeds_radius_edge_any`], and an infinite volume is none. Nothing is said on a machine
/// without AVX2.
///
/// [`exceeds_volume_any`]: ltbw_exact::predicates::filter::exceeds_volume_any
/// [`exceeds_radius_edge_any`]: ltbw_exact::predicates::filter::exceeds_radius_edge_any
#[inline(always)]
pub fn test_bounds(
    corners: &FourCorners,
    volumes: &[f64; 4],
    ratio: Option<f64>,
    thick: f64,
) -> [u32; 3] {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the machine has AVX2.
        return unsafe { bounds::test_bounds(corners, volumes, ratio, thick) };
    }
    let _ = (corners, volumes, ratio, thick);
    [0; 3]
}

#[cfg(target_arch = "x86_64")]
mod bounds;

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Arena, Point, Query, Sphere, SphereBuilder, TetId, VertexId};
    use crate::cavity::SMALL;
    use crate::sphere::{FLATNESS, LEAST_SQUARE, MAX_RADIUS, TOLERANCE};
    use ltbw_exact::predicates::filter::INSPHERE_ERROR;
    use std::arch::x86_64::*;

    /// Turns four rows into four columns.
    #[target_feature(enable = "sse2")]
    #[inline]
    fn transpose(r: [__m128; 4]) -> [__m128; 4] {
        let (a, b) = (_mm_unpacklo_ps(r[0], r[1]), _mm_unpacklo_ps(r[2], r[3]));
        let (c, d) = (_mm_unpackhi_ps(r[0], r[1]), _mm_unpackhi_ps(r[2], r[3]));
        [_mm_movelh_ps(a, b), _mm_movehl_ps(b, a), _mm_movelh_ps(c, d), _mm_movehl_ps(d, c)]
    }

    #[target_feature(enable = "sse2")]
    #[inline]
    pub(super) fn test_spheres(spheres: [&Sphere; 4], q: &Query) -> (u32, u32) {
        let load = |s: &Sphere| {
            // SAFETY: a Sphere is four f32, 16-byte aligned.
            unsafe { _mm_load_ps(s.0.as_ptr()) }
        };
        let [s0, s1, s2, s3] = spheres;
        let [x, y, z, r] = transpose([load(s0), load(s1), load(s2), load(s3)]);
        let dx = _mm_sub_ps(_mm_set1_ps(q.0[0]), x);
        let dy = _mm_sub_ps(_mm_set1_ps(q.0[1]), y);
        let dz = _mm_sub_ps(_mm_set1_ps(q.0[2]), z);
        let squares = _mm_add_ps(_mm_mul_ps(dx, dx), _mm_mul_ps(dy, dy));
        let s = _mm_add_ps(squares, _mm_mul_ps(dz, dz));
        let tolerance = _mm_set1_ps(TOLERANCE);
        let (far, near) = (_mm_add_ps(r, tolerance), _mm_sub_ps(r, tolerance));
        let outside = _mm_cmpgt_ps(s, _mm_mul_ps(far, far));
        let closer = _mm_cmplt_ps(s, _mm_mul_ps(near, near));
        let inside = _mm_and_ps(closer, _mm_cmpgt_ps(near, _mm_setzero_ps()));
        (_mm_movemask_ps(inside) as u32, _mm_movemask_ps(outside) as u32)
    }

    /// Entries `f` of the rim as columns x, y, z, squared length.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn lanes(rim: &[[f64; 4]; SMALL], f: [u8; 4]) -> [__m256d; 4] {
        let row = |i: u8| {
            let r = &rim[i as usize % SMALL];
            _mm256_setr_pd(r[0], r[1], r[2], r[3])
        };
        let (a, b, c, d) = (row(f[0]), row(f[1]), row(f[2]), row(f[3]));
        let (ab, cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
        let (ab2, cd2) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
        [
            _mm256_permute2f128_pd::<0x20>(ab, cd),
            _mm256_permute2f128_pd::<0x20>(ab2, cd2),
            _mm256_permute2f128_pd::<0x31>(ab, cd),
            _mm256_permute2f128_pd::<0x31>(ab2, cd2),
        ]
    }

    /// a b - c d
    #[target_feature(enable = "avx2")]
    #[inline]
    fn minor(a: __m256d, b: __m256d, c: __m256d, d: __m256d) -> __m256d {
        _mm256_sub_pd(_mm256_mul_pd(a, b), _mm256_mul_pd(c, d))
    }

    /// a . b, from left to right
    #[target_feature(enable = "avx2")]
    #[inline]
    fn dot(a: [__m256d; 3], b: [__m256d; 3]) -> __m256d {
        let first = _mm256_add_pd(_mm256_mul_pd(a[0], b[0]), _mm256_mul_pd(a[1], b[1]));
        _mm256_add_pd(first, _mm256_mul_pd(a[2], b[2]))
    }

    /// The largest |entry| of four vectors, lane by lane.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn extent(v: [__m256d; 4]) -> __m256d {
        let sign = _mm256_set1_pd(-0.0);
        let [a, b, c, d] = v;
        let (a, b) = (_mm256_andnot_pd(sign, a), _mm256_andnot_pd(sign, b));
        let (c, d) = (_mm256_andnot_pd(sign, c), _mm256_andnot_pd(sign, d));
        _mm256_max_pd(_mm256_max_pd(a, b), _mm256_max_pd(c, d))
    }

    /// The operations of the plain filter in its order, one tetrahedron a lane.
    #[target_feature(enable = "avx2")]
    pub(super) fn filter_insphere(
        points: &Arena<Point>,
        tets: [[VertexId; 4]; 4],
        p: &Point,
    ) -> (u32, u32) {
        let target = _mm256_setr_pd(p[0], p[1], p[2], 0.0);
        let row = |v: VertexId| {
            let q = points.at(v);
            _mm256_sub_pd(_mm256_setr_pd(q[0], q[1], q[2], 0.0), target)
        };
        // Differences of one vertex of each tetrahedron, as columns x, y, z.
        let columns = |k: usize| {
            let (r0, r1, r2, r3) =
                (row(tets[0][k]), row(tets[1][k]), row(tets[2][k]), row(tets[3][k]));
            let (xz01, xz23) = (_mm256_unpacklo_pd(r0, r1), _mm256_unpacklo_pd(r2, r3));
            let (y01, y23) = (_mm256_unpackhi_pd(r0, r1), _mm256_unpackhi_pd(r2, r3));
            [
                _mm256_permute2f128_pd::<0x20>(xz01, xz23),
                _mm256_permute2f128_pd::<0x20>(y01, y23),
                _mm256_permute2f128_pd::<0x31>(xz01, xz23),
            ]
        };
        let (a, b, c, d) = (columns(0), columns(1), columns(2), columns(3));
        let xy = |u: &[__m256d; 3], v: &[__m256d; 3]| minor(u[0], v[1], v[0], u[1]);
        let (ab, bc, cd) = (xy(&a, &b), xy(&b, &c), xy(&c, &d));
        let (da, ac, bd) = (xy(&d, &a), xy(&a, &c), xy(&b, &d));
        // u z - v y + w x and u z + v y + w x, from left to right
        let alternating = |z: [__m256d; 3], m: [__m256d; 3]| {
            let first = _mm256_sub_pd(_mm256_mul_pd(z[0], m[0]), _mm256_mul_pd(z[1], m[1]));
            _mm256_add_pd(first, _mm256_mul_pd(z[2], m[2]))
        };
        let abc = alternating([a[2], b[2], c[2]], [bc, ac, ab]);
        let bcd = alternating([b[2], c[2], d[2]], [cd, bd, bc]);
        let cda = dot([c[2], d[2], a[2]], [da, ac, cd]);
        let dab = dot([d[2], a[2], b[2]], [ab, bd, da]);
        let left = minor(dot(d, d), abc, dot(c, c), dab);
        let right = minor(dot(b, b), cda, dot(a, a), bcd);
        let negative = _mm256_add_pd(left, right);
        let det = _mm256_xor_pd(_mm256_set1_pd(-0.0), negative);
        let [mx, my, mz] = [0, 1, 2].map(|k| extent([a[k], b[k], c[k], d[k]]));
        let m = _mm256_max_pd(_mm256_max_pd(mx, my), mz);
        let bound = _mm256_mul_pd(_mm256_mul_pd(_mm256_set1_pd(INSPHERE_ERROR), mx), my);
        let bound = _mm256_mul_pd(_mm256_mul_pd(bound, mz), _mm256_mul_pd(m, m));
        let inside = _mm256_cmp_pd::<_CMP_GT_OQ>(det, bound);
        let outside = _mm256_cmp_pd::<_CMP_GT_OQ>(negative, bound);
        (_mm256_movemask_pd(inside) as u32, _mm256_movemask_pd(outside) as u32)
    }

    #[target_feature(enable = "avx2")]
    pub(super) fn make_spheres(
        builder: &SphereBuilder,
        spheres: &mut Arena<Sphere>,
        tets: &[TetId],
        faces: &[[u8; 4]],
    ) {
        let scale = _mm256_set1_pd(builder.scale);
        let column = |f: &[[u8; 4]; 4], k: usize| [f[0][k], f[1][k], f[2][k], f[3][k]];
        for (tets, faces) in tets.chunks(4).zip(faces.chunks(4)) {
            // All but the last are whole: no call to copy.
            let f: [[u8; 4]; 4] = faces.try_into().unwrap_or_else(|_| {
                let mut f = [[0; 4]; 4];
                f.iter_mut().zip(faces).for_each(|(to, from)| *to = *from);
                f
            });
            let [ax, ay, az, la] = lanes(&builder.rim, column(&f, 0));
            let [bx, by, bz, lb] = lanes(&builder.rim, column(&f, 1));
            let [cx, cy, cz, lc] = lanes(&builder.rim, column(&f, 2));
            let bc = [minor(by, cz, bz, cy), minor(bz, cx, bx, cz), minor(bx, cy, by, cx)];
            let ca = [minor(cy, az, cz, ay), minor(cz, ax, cx, az), minor(cx, ay, cy, ax)];
            let ab = [minor(ay, bz, az, by), minor(az, bx, ax, bz), minor(ax, by, ay, bx)];
            let det = dot([ax, ay, az], bc);
            let det = _mm256_add_pd(det, det);
            let inverse = _mm256_div_pd(_mm256_set1_pd(1.0), det);
            let l = [la, lb, lc];
            let x = _mm256_mul_pd(dot(l, [bc[0], ca[0], ab[0]]), inverse);
            let y = _mm256_mul_pd(dot(l, [bc[1], ca[1], ab[1]]), inverse);
            let z = _mm256_mul_pd(dot(l, [bc[2], ca[2], ab[2]]), inverse);
            let square = dot([x, y, z], [x, y, z]);
            let radius = _mm256_sqrt_pd(square);
            let longest = _mm256_max_pd(_mm256_max_pd(la, lb), lc);
            let limit = _mm256_mul_pd(_mm256_set1_pd(FLATNESS), _mm256_mul_pd(longest, radius));
            let scaled = _mm256_mul_pd(radius, scale);
            let solid =
                _mm256_cmp_pd::<_CMP_GT_OQ>(_mm256_andnot_pd(_mm256_set1_pd(-0.0), det), limit);
            let small = _mm256_cmp_pd::<_CMP_LE_OQ>(scaled, _mm256_set1_pd(MAX_RADIUS));
            let least = _mm256_mul_pd(_mm256_set1_pd(LEAST_SQUARE), longest);
            let credible = _mm256_cmp_pd::<_CMP_GE_OQ>(square, least);
            let sound = _mm256_and_pd(_mm256_and_pd(solid, credible), small);
            let r = _mm256_blendv_pd(_mm256_set1_pd(f64::NAN), scaled, sound);
            let centre = builder.centre;
            let x = _mm256_add_pd(_mm256_set1_pd(centre[0]), _mm256_mul_pd(x, scale));
            let y = _mm256_add_pd(_mm256_set1_pd(centre[1]), _mm256_mul_pd(y, scale));
            let z = _mm256_add_pd(_mm256_set1_pd(centre[2]), _mm256_mul_pd(z, scale));
            let rows = transpose([
                _mm256_cvtpd_ps(x),
                _mm256_cvtpd_ps(y),
                _mm256_cvtpd_ps(z),
                _mm256_cvtpd_ps(r),
            ]);
            for (&t, row) in tets.iter().zip(rows) {
                let out = &mut spheres.at_mut(t).0;
                // SAFETY: a Sphere is four f32, 16-byte aligned.
                unsafe { _mm_store_ps(out.as_mut_ptr(), row) };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::{Frame, Verdict};

    /// Numbers in [-1, 1], of few bits so that degenerate cases occur.
    pub(super) fn numbers() -> impl FnMut() -> f64 {
        let mut s = 88_172_645_463_325_252u64;
        move || {
            s ^= s << 13;
            s ^= s >> 7;
            s ^= s << 17;
            ((s >> 40) % 65) as f64 / 32.0 - 1.0
        }
    }

    #[test]
    fn four_filters_at_once_agree_with_the_plain_filter() {
        use ltbw_exact::predicates::{Sign, filter::insphere_window};
        let mut next = numbers();
        let mut seen = [0; 3];
        for round in 0..4000 {
            let scale = [1.0, 2f64.powi(-140), 2f64.powi(190)][round % 3];
            let mut points = Arena::with_capacity(18);
            points.push([f64::NAN; 3]);
            for _ in 0..17 {
                points.push([0; 3].map(|_| next() * scale));
            }
            let p = *points.at(17u32);
            // Corners of one box with p: cospherical, which no filter decides.
            let q = *points.at(1u32);
            *points.at_mut(2u32) = [p[0], q[1], q[2]];
            *points.at_mut(3u32) = [q[0], p[1], q[2]];
            *points.at_mut(4u32) = [q[0], q[1], p[2]];
            let tets = [[1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12], [13, 14, 15, 0]];
            let tets = tets.map(|tet| tet.map(VertexId::new));
            if !std::arch::is_x86_feature_detected!("avx2") {
                println!("SKIPPED: no AVX2 on this machine");
                return;
            }
            let (inside, outside) = filter_insphere(&points, tets, &p);
            assert_eq!((inside | outside) >> 3, 0, "a ghost was decided");
            for (k, tet) in tets.iter().enumerate().take(3) {
                let [a, b, c, d] = tet.map(|v| points.at(v));
                let expected = insphere_window(a, b, c, d, &p);
                let found = match (inside >> k & 1, outside >> k & 1) {
                    (1, 0) => Some(Sign::Positive),
                    (0, 1) => Some(Sign::Negative),
                    (0, 0) => None,
                    both => panic!("inside and outside at once: {both:?}"),
                };
                assert_eq!(found, expected);
                seen[found.map_or(0, |sign| 1 + usize::from(sign == Sign::Positive))] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n > 50), "{seen:?}");
    }

    #[test]
    fn vector_code_agrees_with_its_plain_twin_bit_for_bit() {
        let mut next = numbers();
        let mut point = || [next(), next(), next()];
        let frame = Frame::of_box([-1.0; 3], [1.0; 3]).expect("an ordinary box");
        let (mut flat, mut noise, mut sound, mut seen) = (0, 0, 0, [0; 3]);
        for round in 0..3000 {
            let mut points = Arena::with_capacity(13);
            points.push([f64::NAN; 3]);
            (0..12).for_each(|_| points.push(point()));
            if round % 2 == 1 {
                // Vertices one ulp apart: the computed radius is rounding noise.
                for k in 1..6u32 {
                    *points.at_mut(2 * k) = points.at(2 * k - 1).map(f64::next_up);
                }
            }
            let rim: Vec<VertexId> = VertexId::below(12).collect();
            let mut builder = SphereBuilder::default();
            assert!(builder.at_apex(&frame, &points, &rim, points.at(12u32)));
            let faces: Vec<[u8; 4]> = (0..11).map(|k| [k, (k + 1) % 11, (k + 4) % 11, 0]).collect();
            let tets: Vec<TetId> = TetId::below(11).collect();
            let mut fast = Arena::default();
            fast.grow(11, Sphere::UNKNOWN);
            if !make_spheres(&builder, &mut fast, &tets, &faces) {
                println!("SKIPPED: no AVX2 on this machine");
                return;
            }
            let slow: Vec<Sphere> = faces.iter().map(|&f| builder.sphere(f)).collect();
            for (a, b) in fast.all().iter().zip(&slow) {
                assert_eq!(a.0[3].is_nan(), b.0[3].is_nan());
                if a.0[3].is_nan() {
                    *(if round % 2 == 1 { &mut noise } else { &mut flat }) += 1;
                } else {
                    sound += 1;
                    assert_eq!(a.0.map(f32::to_bits), b.0.map(f32::to_bits));
                }
            }
            let q = frame.query(&point());
            for four in slow.windows(4) {
                let (inside, outside) = test_spheres([&four[0], &four[1], &four[2], &four[3]], &q);
                for (k, sphere) in four.iter().enumerate() {
                    let expected = match (inside >> k & 1, outside >> k & 1) {
                        (1, 0) => Verdict::Inside,
                        (0, 1) => Verdict::Outside,
                        (0, 0) => Verdict::Unknown,
                        both => panic!("inside and outside at once: {both:?}"),
                    };
                    assert_eq!(sphere.test(&q), expected);
                    seen[expected as usize] += 1;
                }
            }
        }
        let enough = flat > 100 && noise > 100 && sound > 1000 && seen.iter().all(|&n| n > 100);
        assert!(enough, "{flat} {noise} {sound} {seen:?}");
    }
}
