//! The tests that refinement decides with: closed balls of segments and triangles, and the bounds
//! of tetrahedra. Each is the proved filter of [`ltbw_exact::predicates::filter`], then exact
//! integers.
//!
//! Coordinates are in fine steps: whole numbers of at most 2^53 in magnitude.

use ltbw_domain::vector::{cross, dot, minus};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, filter};
use num_bigint::BigInt;

/// A vector of whole numbers.
pub(super) type Wide = [BigInt; 3];

/// The coordinates as integers; the callers' coordinates are whole and at most 2^53.
fn whole(p: &Point) -> [i128; 3] {
    p.map(|c| c as i64 as i128)
}

/// The difference of two points.
pub(super) fn wide(p: &Point, q: &Point) -> Wide {
    let (p, q) = (whole(p), whole(q));
    std::array::from_fn(|k| BigInt::from(p[k] - q[k]))
}

pub(super) fn dot_wide(a: &Wide, b: &Wide) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross_wide(a: &Wide, b: &Wide) -> Wide {
    let minor = |i: usize, j: usize| &a[i] * &b[j] - &a[j] * &b[i];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn sign_of(value: &BigInt) -> Sign {
    Sign::from_ordering(value.cmp(&BigInt::ZERO))
}

/// Is `p` in the closed ball with the diameter `ab`?
pub(crate) fn in_diametral_ball(a: &Point, b: &Point, p: &Point) -> bool {
    // The filter is positive inside, the exact expression outside.
    let outside = filter::in_diametral_ball_any(a, b, p).map(|inside| -inside);
    outside.unwrap_or_else(|| diametral_side(a, b, p)) != Sign::Positive
}

/// The exact sign of (a - p)·(b - p): positive outside. Products are below 2^108.
pub(crate) fn diametral_side(a: &Point, b: &Point, p: &Point) -> Sign {
    let [a, b, p] = [a, b, p].map(whole);
    let sum: i128 = (0..3).map(|k| (a[k] - p[k]) * (b[k] - p[k])).sum();
    Sign::from_ordering(sum.cmp(&0))
}

/// Is `p` in the closed ball that has the circle through `a`, `b`, `c` as its equator?
pub(crate) fn in_equatorial_ball(a: &Point, b: &Point, c: &Point, p: &Point) -> bool {
    let outside = filter::in_equatorial_ball_any(a, b, c, p).map(|inside| -inside);
    outside.unwrap_or_else(|| equatorial_side(a, b, c, p)) != Sign::Positive
}

/// The exact sign of G w² - X (w·u) - Y (w·v), with u = b - a, v = c - a, w = p - a,
/// G = u² v² - (u·v)², X = v² (u² - u·v), Y = u² (v² - u·v): positive outside the ball.
pub(crate) fn equatorial_side(a: &Point, b: &Point, c: &Point, p: &Point) -> Sign {
    if let Some(sign) = equatorial_few_bits(a, b, c, p) {
        return sign;
    }
    let (u, v, w) = (wide(b, a), wide(c, a), wide(p, a));
    let (uu, uv, vv) = (dot_wide(&u, &u), dot_wide(&u, &v), dot_wide(&v, &v));
    let g = &uu * &vv - &uv * &uv;
    let (x, y) = (&vv * (&uu - &uv), &uu * (&vv - &uv));
    sign_of(&(g * dot_wide(&w, &w) - x * dot_wide(&w, &u) - y * dot_wide(&w, &v)))
}

/// The sign for differences of at most 19 bits behind their common trailing zeros: 162 products
/// of six are below 2^122.
fn equatorial_few_bits(a: &Point, b: &Point, c: &Point, p: &Point) -> Option<Sign> {
    let [a, b, c, p] = [a, b, c, p].map(whole);
    let mut rows = [b, c, p].map(|q| [0, 1, 2].map(|k| q[k] - a[k]));
    let bits = rows.iter().flatten().fold(0, |bits, c| bits | c.unsigned_abs());
    let zeros = bits.trailing_zeros();
    if bits == 0 || 128 - bits.leading_zeros() - zeros > 18 {
        return None;
    }
    rows.iter_mut().flatten().for_each(|c| *c >>= zeros);
    let [u, v, w] = rows;
    let dot = |a: [i128; 3], b: [i128; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (uu, uv, vv) = (dot(u, u), dot(u, v), dot(v, v));
    let (g, x, y) = (uu * vv - uv * uv, vv * (uu - uv), uu * (vv - uv));
    let value = g * dot(w, w) - x * dot(w, u) - y * dot(w, v);
    Some(Sign::from_ordering(value.cmp(&0)))
}

/// A bound on circumradius to shortest edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RatioBound {
    bound: f64,
}

impl RatioBound {
    /// The bound B, which must be positive and finite.
    pub(crate) fn new(bound: f64) -> Self {
        Self { bound }
    }

    /// The bound B.
    pub(crate) fn value(&self) -> f64 {
        self.bound
    }

    /// Does circumradius to shortest edge exceed the bound? Never for equal.
    #[inline(always)]
    pub(crate) fn exceeded(&self, [p, q, r, s]: [&Point; 4]) -> bool {
        match filter::exceeds_radius_edge_any(p, q, r, s, self.bound) {
            Some(sign) => sign.is_positive(),
            None => self.exceeded_exactly([p, q, r, s]),
        }
    }

    /// The comparison in big integers: |N|² > 4B² l² D² with N = a²(b×c) + b²(c×a) + c²(a×b) and
    /// D = a·(b×c), a, b, c being the differences to the last corner.
    #[cold]
    pub(crate) fn exceeded_exactly(&self, [p, q, r, s]: [&Point; 4]) -> bool {
        let (a, b, c) = (wide(p, s), wide(q, s), wide(r, s));
        let (bc, ca, ab) = (cross_wide(&b, &c), cross_wide(&c, &a), cross_wide(&a, &b));
        let det = dot_wide(&a, &bc);
        let (aa, bb, cc) = (dot_wide(&a, &a), dot_wide(&b, &b), dot_wide(&c, &c));
        let n: Wide = std::array::from_fn(|k| &aa * &bc[k] + &bb * &ca[k] + &cc * &ab[k]);
        let side = |x: &Point, y: &Point| {
            let d = wide(x, y);
            dot_wide(&d, &d)
        };
        let others = [side(p, q), side(q, r), side(r, p)];
        let edge = others.into_iter().chain([aa, bb, cc]).min().unwrap_or(BigInt::ZERO);
        let (numerator, shift) = fraction(self.bound);
        dot_wide(&n, &n) << (2 * shift) > 4 * &numerator * &numerator * edge * &det * &det
    }
}

/// The edge of the regular tetrahedron whose volume bounds all of a mesh with usual edges of
/// length 1. Found by measurement: the tests `usual_edge` tell what comes of it.
pub(crate) const USUAL_EDGE: f64 = 1.18;

/// A bound on the volume.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VolumeBound {
    bound: f64,
}

impl VolumeBound {
    /// A bound in cubes of fine steps, positive and finite.
    pub(crate) fn new(bound: f64) -> Self {
        Self { bound }
    }

    /// Does the volume of a positively oriented tetrahedron exceed the bound?
    #[inline(always)]
    pub(crate) fn exceeded(&self, [p, q, r, s]: [&Point; 4]) -> bool {
        match filter::exceeds_volume_any(p, q, r, s, self.bound) {
            Some(sign) => sign.is_positive(),
            None => self.exceeded_exactly([p, q, r, s]),
        }
    }

    /// The comparison in big integers.
    #[cold]
    pub(crate) fn exceeded_exactly(&self, [p, q, r, s]: [&Point; 4]) -> bool {
        let (a, b, c) = (wide(p, s), wide(q, s), wide(r, s));
        let det = dot_wide(&a, &cross_wide(&b, &c));
        // (p-s)·((q-s)×(r-s)) is negative for a positively oriented p, q, r, s.
        let (numerator, shift) = fraction(self.bound);
        (-det << shift) > 6 * numerator
    }

    /// The bound.
    pub(crate) fn volume(&self) -> f64 {
        self.bound
    }

    /// The volume over the bound, rounded.
    pub(crate) fn excess(&self, shape: &Shape) -> f64 {
        shape.det.abs() / (6.0 * self.bound)
    }
}

/// A positive finite number as `numerator` · 2^-`shift`.
pub(super) fn fraction(value: f64) -> (BigInt, u32) {
    let bits = value.to_bits();
    let field = (bits >> 52) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let (significand, exponent) =
        if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
    let numerator = BigInt::from(significand);
    if exponent >= 0 {
        (numerator << exponent.unsigned_abs(), 0)
    } else {
        (numerator, exponent.unsigned_abs())
    }
}

/// Measures of a tetrahedron for its circumcentre and the order of work, rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// N of the circumcentre s + N / 2D, and |N|².
    normal: Point,
    normal2: f64,
    /// Six times the volume, positive for a positive orientation.
    pub(crate) det: f64,
    /// The shortest edge, squared.
    pub(crate) edge2: f64,
}

impl Shape {
    /// The shape of a positively oriented tetrahedron.
    pub(crate) fn of([p, q, r, s]: [&Point; 4]) -> Self {
        let (a, b, c) = (minus(p, s), minus(q, s), minus(r, s));
        let (bc, ca, ab) = (cross(&b, &c), cross(&c, &a), cross(&a, &b));
        let (aa, bb, cc) = (dot(&a, &a), dot(&b, &b), dot(&c, &c));
        let normal = [0, 1, 2].map(|k| aa * bc[k] + bb * ca[k] + cc * ab[k]);
        let side = |x: &Point, y: &Point| {
            let d = minus(x, y);
            dot(&d, &d)
        };
        let edge2 = aa.min(bb).min(cc).min(side(&a, &b)).min(side(&b, &c)).min(side(&c, &a));
        Self { normal, normal2: dot(&normal, &normal), det: -dot(&a, &bc), edge2 }
    }

    /// The circumcentre, rounded, given the last corner; `None` if it is not finite.
    pub(crate) fn circumcentre(&self, last: &Point) -> Option<Point> {
        let inverse = -0.5 / self.det;
        let c = [0, 1, 2].map(|k| last[k] + self.normal[k] * inverse);
        c.iter().all(|x| x.is_finite()).then_some(c)
    }

    /// The square of the circumradius, rounded.
    pub(crate) fn radius2(&self) -> f64 {
        self.normal2 / (4.0 * (self.det * self.det))
    }

    /// Circumradius, rounded.
    pub(crate) fn radius(&self) -> f64 {
        self.normal2.sqrt() / (2.0 * self.det.abs())
    }

    /// Circumradius to shortest edge over a bound on it, rounded.
    pub(crate) fn ratio_over(&self, bound: &RatioBound) -> f64 {
        self.ratio() / bound.bound
    }

    /// Circumradius to shortest edge, rounded.
    pub(crate) fn ratio(&self) -> f64 {
        self.radius() / self.edge2.sqrt()
    }
}

/// The circumcentre of a triangle, rounded, with its squared radius.
pub(crate) fn circumcircle(a: &Point, b: &Point, c: &Point) -> (Point, f64) {
    let (u, v) = (minus(b, a), minus(c, a));
    let (uu, uv, vv) = (dot(&u, &u), dot(&u, &v), dot(&v, &v));
    let n = cross(&u, &v);
    let g = 2.0 * dot(&n, &n);
    let (x, y) = (vv * (uu - uv) / g, uu * (vv - uv) / g);
    let w = [0, 1, 2].map(|k| x * u[k] + y * v[k]);
    ([0, 1, 2].map(|k| a[k] + w[k]), dot(&w, &w))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use ltbw_exact::predicates::orient3d;
    use proptest::prelude::*;

    /// Few-bit and full-size whole coordinates.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            (-3i64..4).prop_map(|c| c as f64),
            (-40i64..40).prop_map(|c| (c << 40) as f64),
            (-(1i64 << 53)..=1 << 53).prop_map(|c| c as f64),
            ((1i64 << 53) - 9..=1 << 53).prop_map(|c| c as f64),
        ]
    }

    pub(in crate::complex) fn point() -> impl Strategy<Value = Point> {
        [coordinate(), coordinate(), coordinate()]
    }

    /// The ball by its definition, in integers: |2Gw - 2G(centre - a)|² against (2G R)².
    fn ball_by_definition(a: &Point, b: &Point, c: &Point, p: &Point) -> bool {
        let (u, v, w) = (wide(b, a), wide(c, a), wide(p, a));
        let (uu, uv, vv) = (dot_wide(&u, &u), dot_wide(&u, &v), dot_wide(&v, &v));
        let g = &uu * &vv - &uv * &uv;
        let (x, y) = (&vv * (&uu - &uv), &uu * (&vv - &uv));
        let centre: Wide = std::array::from_fn(|k| &x * &u[k] + &y * &v[k]);
        let from: Wide = std::array::from_fn(|k| 2 * &g * &w[k] - &centre[k]);
        dot_wide(&from, &from) <= dot_wide(&centre, &centre)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn balls_are_what_they_are_defined_to_be(
            a in point(), b in point(), c in point(), p in point(), corner in 0u8..8,
        ) {
            // A corner of the box over a and b lies on the sphere with the diameter ab.
            let side = |k| if corner >> k & 1 == 0 { a[k] } else { b[k] };
            let box_corner = std::array::from_fn(side);
            for p in [p, box_corner] {
                let slow = diametral_side(&a, &b, &p) != Sign::Positive;
                prop_assert_eq!(in_diametral_ball(&a, &b, &p), slow);
                prop_assert!(slow || p != box_corner);
                let (u, v) = (wide(&b, &a), wide(&c, &a));
                if cross_wide(&u, &v).iter().any(|c| *c != BigInt::ZERO) {
                    let slow = ball_by_definition(&a, &b, &c, &p);
                    prop_assert_eq!(in_equatorial_ball(&a, &b, &c, &p), slow);
                    prop_assert_eq!(equatorial_side(&a, &b, &c, &p) != Sign::Positive, slow);
                }
            }
        }

        #[test]
        fn bounds_are_exact(
            a in point(), b in point(), c in point(), d in point(), bound in 0.7f64..3.0,
        ) {
            let positive = orient3d(&a, &b, &c, &d) == Sign::Positive;
            let corners = if positive { [&a, &b, &c, &d] } else { [&b, &a, &c, &d] };
            let [p, q, r, s] = corners;
            prop_assume!(!orient3d(p, q, r, s).is_zero());
            let shape = Shape::of(corners);
            let ratio = RatioBound::new(bound);
            prop_assert_eq!(ratio.exceeded(corners), ratio.exceeded_exactly(corners));
            for bound in [bound * shape.det.abs(), shape.det.abs() / 6.0] {
                let volume = VolumeBound::new(bound);
                let exact = volume.exceeded_exactly(corners);
                prop_assert_eq!(volume.exceeded(corners), exact);
            }
        }
    }

    #[test]
    fn equality_does_not_exceed() {
        // The corner of a cube: circumradius √3/2, shortest edge 1, volume 1/6.
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
        let corners = [&unit[1], &unit[0], &unit[2], &unit[3]];
        let [a, b, c, d] = corners;
        assert_eq!(orient3d(a, b, c, d), Sign::Positive);
        let shape = Shape::of(corners);
        assert!((shape.ratio() - 0.75f64.sqrt()).abs() < 1e-15);
        assert!(!RatioBound::new(0.8660254037844387).exceeded(corners));
        assert!(RatioBound::new(0.8660254037844386).exceeded(corners));
        // The regular tetrahedron in a cube of side 2: volume 8/3, R/l = √3/√8 as 3/8 of squares.
        let corners = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 2.0], [0.0, 2.0, 2.0]];
        let [a, b, c, d] = &corners;
        let corners = [a, b, d, c];
        assert_eq!(orient3d(a, b, d, c), Sign::Positive);
        // det = 16, volume 16/6: a bound of 4 with the determinant 24 is met with equality.
        let scaled: Vec<Point> =
            [[0.0; 3], [6.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].to_vec();
        let tall = [&scaled[0], &scaled[1], &scaled[2], &scaled[3]];
        assert!(!VolumeBound::new(4.0).exceeded(tall));
        assert!(VolumeBound::new(4.0f64.next_down()).exceeded(tall));
        assert!(VolumeBound::new(1.0).exceeded(corners));
    }
}
