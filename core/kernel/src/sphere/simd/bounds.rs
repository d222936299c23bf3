//! The filters for bounds of tetrahedra, four at a time: operation by operation those of
//! [`ltbw_exact::predicates::filter`], so that what is proved of them holds here.

use super::FourCorners;
use ltbw_exact::predicates::filter::{
    EDGE_ERROR, RADIUS_ERROR, VOLUME_ERROR, VOLUME_LIMIT_ERROR, power_of_two,
};
use std::arch::x86_64::*;

/// Numbers of four tetrahedra.
type Lanes = __m256d;

#[target_feature(enable = "avx2")]
#[inline]
fn all(value: f64) -> Lanes {
    _mm256_set1_pd(value)
}

/// p - q
#[target_feature(enable = "avx2")]
#[inline]
fn minus(p: [Lanes; 3], q: [Lanes; 3]) -> [Lanes; 3] {
    let [x, y, z] = p;
    [_mm256_sub_pd(x, q[0]), _mm256_sub_pd(y, q[1]), _mm256_sub_pd(z, q[2])]
}

/// a b - c d
#[target_feature(enable = "avx2")]
#[inline]
fn minor(a: Lanes, b: Lanes, c: Lanes, d: Lanes) -> Lanes {
    _mm256_sub_pd(_mm256_mul_pd(a, b), _mm256_mul_pd(c, d))
}

/// a . b, from left to right
#[target_feature(enable = "avx2")]
#[inline]
fn dot(a: [Lanes; 3], b: [Lanes; 3]) -> Lanes {
    let first = _mm256_add_pd(_mm256_mul_pd(a[0], b[0]), _mm256_mul_pd(a[1], b[1]));
    _mm256_add_pd(first, _mm256_mul_pd(a[2], b[2]))
}

/// The larger |entry| of three vectors, axis by axis.
#[target_feature(enable = "avx2")]
#[inline]
fn extents(a: [Lanes; 3], b: [Lanes; 3], c: [Lanes; 3]) -> [Lanes; 3] {
    let of = |a: Lanes, b: Lanes, c: Lanes| {
        let [a, b, c] = [magnitude(a), magnitude(b), magnitude(c)];
        _mm256_max_pd(_mm256_max_pd(a, b), c)
    };
    [of(a[0], b[0], c[0]), of(a[1], b[1], c[1]), of(a[2], b[2], c[2])]
}

#[target_feature(enable = "avx2")]
#[inline]
fn magnitude(a: Lanes) -> Lanes {
    _mm256_andnot_pd(all(-0.0), a)
}

#[target_feature(enable = "avx2")]
#[inline]
fn largest([a, b, c]: [Lanes; 3]) -> Lanes {
    _mm256_max_pd(_mm256_max_pd(a, b), c)
}

#[target_feature(enable = "avx2")]
#[inline]
fn within(value: Lanes, low: i32, high: i32) -> Lanes {
    let [low, high] = [low, high].map(power_of_two);
    let above = _mm256_cmp_pd::<_CMP_GT_OQ>(value, all(low));
    _mm256_and_pd(above, _mm256_cmp_pd::<_CMP_LT_OQ>(value, all(high)))
}

/// Bit masks (more, less) of values and the bounds of their errors, where a guard holds.
#[target_feature(enable = "avx2")]
#[inline]
fn decide(value: Lanes, bound: Lanes, guard: Lanes) -> (u32, u32) {
    let more = _mm256_cmp_pd::<_CMP_GT_OQ>(value, bound);
    let less = _mm256_cmp_pd::<_CMP_GT_OQ>(_mm256_xor_pd(all(-0.0), value), bound);
    let mask = |side: Lanes| _mm256_movemask_pd(_mm256_and_pd(side, guard)) as u32;
    (mask(more), mask(less))
}

#[target_feature(enable = "avx2")]
pub(super) fn test_bounds(
    corners: &FourCorners,
    volumes: &[f64; 4],
    ratio: Option<f64>,
    thick: f64,
) -> [u32; 3] {
    let lanes = |of: &[f64; 4]| _mm256_setr_pd(of[0], of[1], of[2], of[3]);
    let point = |k: usize| [lanes(&corners[k][0]), lanes(&corners[k][1]), lanes(&corners[k][2])];
    let (a, b, c, d) = (point(0), point(1), point(2), point(3));
    let (ad, bd, cd) = (minus(a, d), minus(b, d), minus(c, d));
    let volume = lanes(volumes);
    // The volume, as `exceeds_volume_any`.
    let x = minor(cd[0], bd[1], bd[0], cd[1]);
    let y = minor(ad[0], cd[1], cd[0], ad[1]);
    let z = minor(bd[0], ad[1], ad[0], bd[1]);
    let det = dot([ad[2], bd[2], cd[2]], [x, y, z]);
    let value = _mm256_sub_pd(det, _mm256_mul_pd(all(6.0), volume));
    let extent = extents(ad, bd, cd);
    let [mx, my, mz] = extent;
    let solid = _mm256_mul_pd(_mm256_mul_pd(_mm256_mul_pd(all(VOLUME_ERROR), mx), my), mz);
    let bound = _mm256_add_pd(solid, _mm256_mul_pd(all(VOLUME_LIMIT_ERROR), volume));
    let guard = _mm256_and_pd(within(mx, -190, 200), within(my, -190, 200));
    let guard = _mm256_and_pd(guard, within(mz, -190, 200));
    let guard = _mm256_and_pd(guard, within(volume, -600, 600));
    let (large, small) = decide(value, bound, guard);
    // No tetrahedron exceeds an infinite bound.
    let any = _mm256_cmp_pd::<_CMP_EQ_OQ>(volume, all(f64::INFINITY));
    let small = small | _mm256_movemask_pd(any) as u32;
    let Some(ratio) = ratio else { return [large, small, 0] };
    // The ratio, as `exceeds_radius_edge_any`.
    let (ab, bc, ca) = (minus(a, b), minus(b, c), minus(c, a));
    let lifts = [dot(ad, ad), dot(bd, bd), dot(cd, cd)];
    let cross = |u: [Lanes; 3], v: [Lanes; 3]| {
        let (x, y) = (minor(u[1], v[2], u[2], v[1]), minor(u[2], v[0], u[0], v[2]));
        [x, y, minor(u[0], v[1], u[1], v[0])]
    };
    let (p, q, r) = (cross(bd, cd), cross(cd, ad), cross(ad, bd));
    let n = |k: usize| dot(lifts, [p[k], q[k], r[k]]);
    let n = [n(0), n(1), n(2)];
    let det = dot(ad, p);
    let least = |a: Lanes, b: Lanes, c: Lanes| _mm256_min_pd(_mm256_min_pd(a, b), c);
    let [alift, blift, clift] = lifts;
    let sides = [dot(ab, ab), dot(bc, bc), dot(ca, ca)];
    let shortest = least(sides[0], sides[1], sides[2]);
    let shortest = _mm256_min_pd(least(alift, blift, clift), shortest);
    let limit = _mm256_mul_pd(all(2.0 * ratio), det);
    let limit = _mm256_mul_pd(_mm256_mul_pd(limit, limit), shortest);
    let value = _mm256_sub_pd(dot(n, n), limit);
    let m = _mm256_max_pd(largest(extent), largest(extents(ab, bc, ca)));
    let m2 = _mm256_mul_pd(m, m);
    let m4 = _mm256_mul_pd(m2, m2);
    let factor = all(RADIUS_ERROR + EDGE_ERROR * (ratio * ratio));
    let bound = _mm256_mul_pd(factor, _mm256_mul_pd(m4, m4));
    let guard = _mm256_and_pd(within(m, -100, 100), within(all(ratio), -20, 20));
    let (long, short) = decide(value, bound, guard);
    // The dihedral angles, as the caller says.
    let most = |a: Lanes, b: Lanes, c: Lanes| _mm256_max_pd(_mm256_max_pd(a, b), c);
    let longest = _mm256_max_pd(most(alift, blift, clift), most(sides[0], sides[1], sides[2]));
    let square = _mm256_mul_pd(longest, longest);
    let limit = _mm256_mul_pd(all(thick), _mm256_mul_pd(square, square));
    let sine = _mm256_mul_pd(_mm256_mul_pd(det, det), shortest);
    let thick = _mm256_cmp_pd::<_CMP_GT_OQ>(sine, limit);
    [large | long, small & short, _mm256_movemask_pd(thick) as u32]
}

#[cfg(test)]
mod tests {
    use super::super::{FourCorners, test_bounds};
    use ltbw_exact::Sign;
    use ltbw_exact::predicates::filter::{exceeds_radius_edge_any, exceeds_volume_any};

    /// The masks of the plain filters.
    fn plain(corners: &FourCorners, volumes: &[f64; 4], ratio: Option<f64>) -> [u32; 2] {
        let (mut over, mut within) = (0, 0);
        for (lane, &volume) in volumes.iter().enumerate() {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| [0, 1, 2].map(|x| corners[k][x][lane]));
            let size = match volume.is_finite() {
                true => exceeds_volume_any(&a, &b, &c, &d, volume),
                false => Some(Sign::Negative),
            };
            let shape = ratio.map(|ratio| exceeds_radius_edge_any(&a, &b, &c, &d, ratio));
            let shape = shape.unwrap_or(Some(Sign::Negative));
            let is =
                |sign: Sign| [size, shape].into_iter().filter(|&own| own == Some(sign)).count();
            over |= u32::from(is(Sign::Positive) > 0) << lane;
            within |= u32::from(is(Sign::Negative) == 2) << lane;
        }
        [over, within]
    }

    #[test]
    fn four_at_once_agree_with_the_plain_filters() {
        if !std::arch::is_x86_feature_detected!("avx2") {
            println!("SKIPPED: no AVX2 on this machine");
            return;
        }
        let mut next = super::super::tests::numbers();
        let mut seen = [0; 3];
        for round in 0..6000 {
            let scale = [1.0, 4503599627370496.0, 2f64.powi(-180), 2f64.powi(120)][round % 4];
            let corners: FourCorners =
                [0; 4].map(|_| [0; 3].map(|_| [0; 4].map(|_| next() * scale)));
            let cube = scale * scale * scale;
            let volumes = [0; 4].map(|_| match round % 5 {
                0 => f64::INFINITY,
                _ => (next() * next()).abs() * cube,
            });
            let ratio = (round % 7 > 0).then(|| next().abs() * 3.0);
            let [over, within, thick] = test_bounds(&corners, &volumes, ratio, 0.01);
            assert_eq!([over, within], plain(&corners, &volumes, ratio));
            assert!(thick == 0 || ratio.is_some());
            for lane in 0..4 {
                seen[(over >> lane & 1 | (within >> lane & 1) << 1) as usize] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
    }
}
