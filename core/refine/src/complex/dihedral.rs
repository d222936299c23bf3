//! Bounds on the dihedral angles of tetrahedra.
//!
//! An angle is told by the square of its cosine, so that no root is taken: with the normals m and n
//! of two faces, cos² = (m·n)² / m² n², and the angle is acute if the normals that look outside
//! have a negative product. Bounds are decided exactly; which of several points is the best one, by
//! rounded angles.

use ltbw_domain::quality::Normals;
use ltbw_domain::vector::{cross, dot, minus};
use ltbw_exact::Point;
use ltbw_exact::predicates::dihedral::has_dihedral_below;

/// A lower bound on dihedral angles, below a right angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DihedralBound {
    /// The square of its cosine. The bound is this number.
    cos2: f64,
    /// The square of its sine, times 9/16 and a little more.
    thick: f64,
}

/// One degree: an angle below is tiny.
pub(crate) const TINY: DihedralBound =
    DihedralBound { cos2: 0.999_695_413_509_547_9, thick: 0.000_172 };

impl DihedralBound {
    /// The bound of some degrees, of which there are at most 45.
    pub(crate) fn new(degrees: f64) -> Self {
        // The series of the sine and not that of a library, whose last bits are its own.
        let x = degrees.to_radians();
        let mut terms = (x, x);
        for k in 1..12 {
            let k = f64::from(2 * k);
            terms.1 *= -x * x / (k * (k + 1.0));
            terms.0 += terms.1;
        }
        let sin2 = terms.0 * terms.0;
        Self { cos2: 1.0 - sin2, thick: 0.564_75 * sin2 }
    }

    /// The bound of an angle that is told by the square of its cosine.
    pub(crate) fn of_cos2(cos2: f64) -> Self {
        Self { cos2, thick: 0.564_75 * (1.0 - cos2) }
    }

    /// The weaker of this bound and [`TINY`].
    pub(crate) fn or_tiny(self) -> Self {
        if self.cos2 < TINY.cos2 { TINY } else { self }
    }

    /// The square of the sine, times 9/16 and a little more: what `ltbw_core::test_bounds` asks.
    pub(crate) fn thick(&self) -> f64 {
        self.thick
    }

    /// Has a tetrahedron a dihedral angle below the bound? Never for equal. Either orientation.
    pub(crate) fn is_missed(&self, corners: [&Point; 4]) -> bool {
        !self.is_surely_met(corners) && self.sharpest_if_met(corners).is_none()
    }

    /// The value of [`Normals::sharpest`], if no angle of a tetrahedron is below the bound.
    pub(crate) fn sharpest_if_met(&self, corners: [&Point; 4]) -> Option<f64> {
        let normals = Normals::of(corners);
        let sharpest = normals.sharpest();
        let is_surely_met = sharpest < self.cos2 - Normals::MARGIN && normals.are_sure();
        (is_surely_met || !has_dihedral_below(corners, self.cos2)).then_some(sharpest)
    }

    /// Are all dihedral angles of a tetrahedron above the bound, as a short test tells? Either
    /// orientation, and the corners in any order.
    ///
    /// The sine of an angle between faces with areas A and B at an edge l is 3 V l / (2 A B); no
    /// area is more than √3/4 of the square of the longest edge L, so that it is at least
    /// 4/3 |D| l / L⁴, D being the determinant. Where that is enough, D is so large that its
    /// rounding does not matter.
    #[inline(always)]
    pub(crate) fn is_surely_met(&self, [p, q, r, s]: [&Point; 4]) -> bool {
        let (a, b, c) = (minus(p, s), minus(q, s), minus(r, s));
        let edges = [a, b, c, minus(p, q), minus(q, r), minus(r, p)].map(|e| dot(&e, &e));
        let (least, most) =
            edges[1..].iter().fold((edges[0], edges[0]), |(x, y), &e| (x.min(e), y.max(e)));
        let det = dot(&a, &cross(&b, &c));
        det * det * least > self.thick * (most * most) * (most * most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complex::measure::tests::point;
    use proptest::prelude::*;

    /// Does the test of four at once say that all dihedral angles are large? Never on a machine
    /// without AVX2.
    fn are_large_in_lanes(bound: &DihedralBound, corners: [&Point; 4]) -> bool {
        let four = corners.map(|corner| corner.map(|c| [c; 4]));
        let volumes = [f64::INFINITY; 4];
        let thick = ltbw_core::test_bounds(&four, &volumes, Some(2.0), bound.thick())[2];
        assert!([0, 15].contains(&thick), "the same in all lanes: {thick:b}");
        thick == 15
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn large_angles_are_not_small(
            a in point(), b in point(), c in point(), d in point(), degrees in 0.1f64..45.0,
        ) {
            let (corners, bound) = ([&a, &b, &c, &d], DihedralBound::new(degrees));
            let is_below = has_dihedral_below(corners, bound.cos2);
            prop_assert!(!is_below || !bound.is_surely_met(corners));
            prop_assert!(!is_below || !are_large_in_lanes(&bound, corners));
            prop_assert_eq!(bound.is_missed(corners), is_below);
        }

        /// Four points near a square, folded by up to twice the bound.
        #[test]
        fn folds_about_the_bound_are_looked_at(
            degrees in 0.5f64..12.0,
            width in 0.2f64..1.0,
            height in 0.2f64..1.0,
            fold in 0.0f64..2.0,
            shift in -0.3f64..0.3,
        ) {
            let size = (1u64 << 50) as f64;
            let at = |p: Point| p.map(|c| (c * size).round());
            let (sin, cos) = (fold * degrees).to_radians().sin_cos();
            let corners = [
                at([0.0, 0.0, 0.0]),
                at([1.0, 0.0, 0.0]),
                at([0.5 + shift, width, 0.0]),
                at([0.5, -height * cos, height * sin]),
            ];
            let (corners, bound) = (corners.each_ref(), DihedralBound::new(degrees));
            let is_below = has_dihedral_below(corners, bound.cos2);
            prop_assert!(fold > 0.49 || is_below);
            prop_assert!(!(is_below && bound.is_surely_met(corners)));
            prop_assert!(!(is_below && are_large_in_lanes(&bound, corners)));
        }
    }

    #[test]
    fn regular_tetrahedra_have_large_angles() {
        let regular = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 2.0], [0.0, 2.0, 2.0]];
        let bound = DihedralBound::new(8.0);
        assert!(bound.is_surely_met(regular.each_ref()));
        // The corner of a cube: 54.7 degrees.
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(bound.is_surely_met(corner.each_ref()));
        #[cfg(target_arch = "x86_64")]
        match is_x86_feature_detected!("avx2") {
            true => assert!(are_large_in_lanes(&bound, corner.each_ref())),
            false => println!("SKIPPED: no AVX2 on this machine"),
        }
    }

    #[test]
    fn bounds_are_the_squares_of_cosines() {
        for k in 1..90 {
            let degrees = 0.5 * f64::from(k);
            let cos = degrees.to_radians().cos();
            assert!((DihedralBound::new(degrees).cos2 - cos * cos).abs() < 1e-15, "{degrees}");
        }
        assert!((DihedralBound::new(1.0).cos2 - TINY.cos2).abs() < 1e-15);
        let [own, tiny] = [DihedralBound::new(1.0), TINY].map(|bound| bound.thick);
        assert!((own / tiny - 1.0).abs() < 1e-3, "{own} {tiny}");
    }
}
