//! Dihedral angles of a tetrahedron against a bound: exact for any finite coordinates.
//!
//! The filter [`filter::below_dihedral_any`] decides nearly always, and big integers the rest.

use num_bigint::{BigInt, Sign};

use super::filter;
use crate::Point;

/// The edges of a tetrahedron: their ends, then the two other corners.
const EDGES: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];

/// Is one of the six dihedral angles of a tetrahedron strictly below a bound? The bound is an angle
/// below 90 degrees, given by the square of its cosine, which is positive and below 1. The corners
/// may have either orientation.
///
/// A flat tetrahedron has such an angle, zero; at the edges of a face without area there is none.
///
/// ```
/// use ltbw_exact::predicates::dihedral::has_dihedral_below;
/// // The corner of a cube: the angles at its other side are arccos(1/√3), 54.7 degrees.
/// let corners = [&[0.0; 3], &[1.0, 0.0, 0.0], &[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0]];
/// assert!(has_dihedral_below(corners, 0.333));
/// assert!(!has_dihedral_below(corners, 0.334));
/// ```
#[inline]
#[must_use]
pub fn has_dihedral_below(corners: [&Point; 4], cos2: f64) -> bool {
    EDGES.iter().any(|edge| is_below(edge.map(|k| corners[k]), cos2))
}

/// Is the dihedral angle at the edge between the first two corners below the bound?
///
/// A positive filter may mean the supplement of the angle: then the product p·q of the normals is
/// negative. Its rounded sign is the right one here. The bound that the filter's value exceeds is
/// at least 3360u m⁸, m being the largest difference, and what is subtracted from the square of p·q
/// is not negative: |p·q| as the filter computes it exceeds √(3360u) m⁴, more than 2^-21 m⁴. A
/// component of p or q is at most 2m² with an error of 8u m², a product of two 4m⁴ with 36u m⁴, and
/// their sum has an error below 129u m⁴, higher powers of u included: less than 2^-45 m⁴.
#[inline(always)]
fn is_below([a, b, c, d]: [&Point; 4], cos2: f64) -> bool {
    match filter::below_dihedral_any(a, b, c, d, cos2) {
        Some(sign) => sign.is_positive() && normals_product(a, b, c, d).is_sign_positive(),
        None => is_below_exactly([a, b, c, d], cos2),
    }
}

/// The product of the normals of the two faces at `ab`, rounded: both on the left, seen along the
/// edge, or both on the right.
#[inline(always)]
fn normals_product(a: &Point, b: &Point, c: &Point, d: &Point) -> f64 {
    let [e, v, w] = [b, c, d].map(|p| [a[0] - p[0], a[1] - p[1], a[2] - p[2]]);
    let [p, q] = [v, w]
        .map(|v| [e[1] * v[2] - e[2] * v[1], e[2] * v[0] - e[0] * v[2], e[0] * v[1] - e[1] * v[0]]);
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

/// The comparison in big integers: p·q > 0 and (p·q)² > cos2 |p|² |q|², by Lagrange's identity from
/// the products of the edges.
#[cold]
fn is_below_exactly(corners: [&Point; 4], cos2: f64) -> bool {
    let [a, b, c, d] = integers(corners);
    let minus = |p: &[BigInt; 3]| -> [BigInt; 3] { std::array::from_fn(|k| &p[k] - &a[k]) };
    let (e, v, w) = (minus(&b), minus(&c), minus(&d));
    let dot = |x: &[BigInt; 3], y: &[BigInt; 3]| &x[0] * &y[0] + &x[1] * &y[1] + &x[2] * &y[2];
    let (ee, ev, ew) = (dot(&e, &e), dot(&e, &v), dot(&e, &w));
    let product = &ee * dot(&v, &w) - &ev * &ew;
    let squares = (&ee * dot(&v, &v) - &ev * &ev) * (&ee * dot(&w, &w) - &ew * &ew);
    // The exponent of a number below 1 is negative.
    let (mantissa, exponent) = dyadic(cos2);
    let left = (&product * &product) << exponent.unsigned_abs();
    product.sign() == Sign::Plus && left > mantissa * squares
}

/// The points in one power of two, of which all coordinates are multiples.
fn integers(points: [&Point; 4]) -> [[BigInt; 3]; 4] {
    let parts = points.map(|p| p.map(dyadic));
    let used = parts.iter().flatten().filter(|(mantissa, _)| *mantissa != 0);
    let low = used.map(|&(_, exponent)| exponent).min().unwrap_or(0);
    parts.map(|p| p.map(|(mantissa, e)| BigInt::from(mantissa) << e.max(low).abs_diff(low)))
}

/// A finite number as mantissa · 2^exponent.
fn dyadic(value: f64) -> (i64, i32) {
    let bits = value.to_bits();
    let field = ((bits >> 52) & 0x7ff) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let magnitude = if field == 0 { fraction } else { fraction + (1 << 52) };
    (if value.is_sign_negative() { -magnitude } else { magnitude }, field.max(1) - 1075)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicates::filter::power_of_two;
    use num_traits::Zero;
    use proptest::prelude::*;

    type Wide = [BigInt; 3];

    fn dot(a: &Wide, b: &Wide) -> BigInt {
        &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
    }

    /// A point in units of the least subnormal.
    fn wide(p: &Point) -> Wide {
        p.map(|c| {
            let bits = c.to_bits() & !(1 << 63);
            let (field, fraction) = (bits >> 52, bits % (1 << 52));
            let magnitude = match field {
                0 => BigInt::from(fraction),
                _ => BigInt::from(fraction + (1 << 52)) << (field - 1),
            };
            if c < 0.0 { -magnitude } else { magnitude }
        })
    }

    /// The definition, from the normals of the faces, all outward or all inward: at the edge that
    /// two faces have in common the cosine is the negative one of their normals. For each edge.
    fn by_definition(corners: [&Point; 4], cos2: f64) -> [bool; 6] {
        let [p, q, r, s] = corners.map(wide);
        let minus = |x: &Wide, y: &Wide| -> Wide { std::array::from_fn(|k| &x[k] - &y[k]) };
        let cross = |x: &Wide, y: &Wide| -> Wide {
            std::array::from_fn(|k| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                &x[i] * &y[j] - &x[j] * &y[i]
            })
        };
        let (a, b, c) = (minus(&p, &s), minus(&q, &s), minus(&r, &s));
        let last = cross(&minus(&r, &p), &minus(&q, &p));
        let normals = [cross(&b, &c), cross(&c, &a), cross(&a, &b), last];
        let [cosine, _, one] = wide(&[cos2, 0.0, 1.0]);
        EDGES.map(|[_, _, i, j]| {
            let product: BigInt = -dot(&normals[i], &normals[j]);
            let squares = dot(&normals[i], &normals[i]) * dot(&normals[j], &normals[j]);
            product > BigInt::zero() && &one * &product * &product > &cosine * squares
        })
    }

    /// Squared cosines of the six angles, rounded.
    fn cosines(corners: [&Point; 4]) -> [f64; 6] {
        EDGES.map(|edge| {
            let [a, b, c, d] = edge.map(|k| corners[k]);
            let [pq, pp, qq] = [[c, d], [c, c], [d, d]].map(|[x, y]| normals_product(a, b, x, y));
            pq * pq / (pp * qq)
        })
    }

    /// Whole numbers of few bits, of 41 and of 53, and some of any size.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            4 => (-3i64..4).prop_map(|c| c as f64),
            2 => (-40i64..40).prop_map(|c| (c << 40) as f64),
            2 => (-(1i64 << 53)..=1 << 53).prop_map(|c| c as f64),
            1 => ((1i64 << 53) - 9..=1 << 53).prop_map(|c| c as f64),
        ]
    }

    fn point() -> impl Strategy<Value = Point> {
        [coordinate(), coordinate(), coordinate()]
    }

    /// Checks the bounds around each angle, and others.
    fn agrees(corners: [&Point; 4], other: f64) {
        let angles = cosines(corners).into_iter().filter(|c| *c > 0.0 && *c < 1.0);
        for cos2 in angles.chain([other, 0.25, 0.5, 0.75]) {
            for bound in [cos2.next_down(), cos2, cos2.next_up()] {
                let expected = by_definition(corners, bound);
                let case = || format!("{corners:?} {bound}");
                let found = EDGES.map(|edge| is_below(edge.map(|k| corners[k]), bound));
                assert_eq!(found, expected, "{}", case());
                let exact = EDGES.map(|edge| is_below_exactly(edge.map(|k| corners[k]), bound));
                assert_eq!(exact, expected, "{}", case());
                let any = expected.contains(&true);
                assert_eq!(has_dihedral_below(corners, bound), any, "{}", case());
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1500))]

        #[test]
        fn angles_are_what_they_are_defined_to_be(
            p in point(), q in point(), r in point(), s in point(), other in 0.001f64..0.999,
        ) {
            agrees([&p, &q, &r, &s], other);
            // A flat one, if the sums are exact.
            let fourth = std::array::from_fn(|k| q[k] + (r[k] - p[k]));
            agrees([&p, &q, &r, &fourth], other);
        }

        /// Slivers: four points near a square.
        #[test]
        fn slivers_have_small_angles(
            height in -40i64..40, shift in 0u32..44, noise in any::<[[u8; 3]; 4]>(),
        ) {
            let size = 1i64 << shift;
            let at = |k: usize, p: [i64; 3]| -> Point {
                std::array::from_fn(|i| (p[i] * size + i64::from(noise[k][i] % 7) - 3) as f64)
            };
            let corners = [
                at(0, [100, 0, height]),
                at(1, [0, 100, 0]),
                at(2, [-100, 0, height]),
                at(3, [0, -100, 0]),
            ];
            agrees(corners.each_ref(), 0.97);
        }
    }

    #[test]
    fn coordinates_may_have_any_size() {
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for exponent in [-1022, -300, -101, 0, 101, 300, 1000] {
            let scaled = corner.map(|p| p.map(|c| c * power_of_two(exponent)));
            agrees(scaled.each_ref(), 0.3);
        }
        // One corner at a height that no other coordinate knows.
        let thin = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.25, 0.25, 5e-324]];
        assert!(has_dihedral_below(thin.each_ref(), 1.0f64.next_down()));
        let large = thin.map(|p| p.map(|c| c * power_of_two(1000)));
        assert!(has_dihedral_below(large.each_ref(), 1.0f64.next_down()));
    }

    #[test]
    fn equality_is_not_below() {
        // Half of a prism over a right triangle: all angles are 45, 60 or 90 degrees.
        let prism = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
        assert!(!has_dihedral_below(prism.each_ref(), 0.5));
        assert!(has_dihedral_below(prism.each_ref(), 0.5f64.next_down()));
        assert!(!has_dihedral_below(prism.each_ref(), 0.5f64.next_up()));
    }

    #[test]
    fn obtuse_angles_are_not_small() {
        // A flat cap over a triangle: at the edges of its apex the angles are near 180 degrees.
        let [a, b, c] = [[0.0, 4.0, 0.0], [-3.0, -2.0, 0.0], [3.0, -2.0, 0.0]];
        let apex = [0.0, 0.0, 0.125];
        let found = filter::below_dihedral_any(&a, &apex, &b, &c, 0.97);
        assert_eq!(found, Some(crate::Sign::Positive), "the supplement");
        assert!(!is_below([&a, &apex, &b, &c], 0.97));
        assert!(!is_below_exactly([&a, &apex, &b, &c], 0.97));
        assert!(has_dihedral_below([&a, &b, &c, &apex], 0.97), "at its base");
    }

    #[test]
    fn faces_without_area_have_no_angles() {
        let line = [[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]];
        assert!(!has_dihedral_below(line.each_ref(), 0.5));
        assert!(!has_dihedral_below([&[1.0; 3]; 4], 0.5));
    }
}
