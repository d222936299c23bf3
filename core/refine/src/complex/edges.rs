//! The bound on the edges of tetrahedra: exact, as all bounds are.

use super::measure::{dot_wide, fraction, wide};
use ltbw_domain::vector::{dot, minus};
use ltbw_exact::Point;

/// The relative error of a squared length and of a squared bound, generously: a difference of whole
/// numbers of at most 2^53, a square, two sums.
const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// The largest length of an edge, in fine steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeBound {
    length: f64,
    square: f64,
}

impl EdgeBound {
    /// A bound, positive and finite.
    pub(crate) fn new(length: f64) -> Self {
        Self { length, square: length * length }
    }

    /// Is an edge of a tetrahedron longer? Never for equal.
    #[inline(always)]
    pub(crate) fn exceeded(&self, corners: [&Point; 4]) -> bool {
        edges(corners).into_iter().any(|[p, q]| self.is_below(p, q))
    }

    /// The longest edge over the bound, rounded.
    pub(crate) fn excess(&self, corners: [&Point; 4]) -> f64 {
        let square = |[p, q]: [&Point; 2]| {
            let d = minus(p, q);
            dot(&d, &d)
        };
        edges(corners).into_iter().map(square).fold(0.0, f64::max).sqrt() / self.length
    }

    /// The bound.
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// Is it below the distance of two points?
    fn is_below(&self, p: &Point, q: &Point) -> bool {
        let d = minus(p, q);
        let square = dot(&d, &d);
        if (square - self.square).abs() > ROUNDING * self.square {
            return square > self.square;
        }
        self.is_below_exactly(p, q)
    }

    #[cold]
    fn is_below_exactly(&self, p: &Point, q: &Point) -> bool {
        let d = wide(p, q);
        let (numerator, shift) = fraction(self.length);
        dot_wide(&d, &d) << (2 * shift) > &numerator * &numerator
    }
}

/// The ends of the edges.
fn edges([p, q, r, s]: [&Point; 4]) -> [[&Point; 2]; 6] {
    [[p, q], [p, r], [p, s], [q, r], [q, s], [r, s]]
}

#[cfg(test)]
mod tests {
    use super::EdgeBound;
    use crate::complex::measure::tests::point;
    use proptest::prelude::*;

    #[test]
    fn equality_does_not_exceed() {
        let corners = [[0.0; 3], [3.0, 4.0, 0.0], [0.0, 1.0, 0.0], [1.0; 3]];
        let exceeded = |bound: f64| EdgeBound::new(bound).exceeded(corners.each_ref());
        assert!(!exceeded(5.0) && exceeded(5.0f64.next_down()));
        assert_eq!(EdgeBound::new(2.5).excess(corners.each_ref()), 2.0);
        // 2^53 in each coordinate, and a unit more.
        let most = (1u64 << 53) as f64;
        let corners = [[0.0; 3], [most, 0.0, 0.0], [most, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(EdgeBound::new(most).exceeded(corners.each_ref()));
    }

    proptest! {
        #[test]
        fn the_bound_is_exact(a in point(), b in point(), c in point(), d in point()) {
            let corners = [&a, &b, &c, &d];
            let longest = EdgeBound::new(1.0).excess(corners);
            prop_assume!(longest > 0.0);
            for bound in [longest.next_down(), longest, longest.next_up()].map(EdgeBound::new) {
                let exact = super::edges(corners);
                let exact = exact.into_iter().any(|[p, q]| bound.is_below_exactly(p, q));
                prop_assert_eq!(bound.exceeded(corners), exact);
            }
        }
    }
}
