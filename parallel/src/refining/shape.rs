//! The measures of a tetrahedron, rounded: they decide what is refined, never where it fits.

use ltbw_domain::vector::{cross, dot, minus};
use ltbw_exact::Point;

/// Volume, circumsphere and shortest edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub(super) volume: f64,
    pub(super) centre: Point,
    pub(super) radius: f64,
    pub(super) shortest: f64,
}

impl Shape {
    /// The measures of a tetrahedron with these corners. A flat one has no finite centre.
    pub(super) fn of(corners: [Point; 4]) -> Self {
        let [p, rest @ ..] = corners;
        let [a, b, c] = [0, 1, 2].map(|k| minus(&rest[k], &p));
        let (bc, ca, ab) = (cross(&b, &c), cross(&c, &a), cross(&a, &b));
        let squares = [dot(&a, &a), dot(&b, &b), dot(&c, &c)];
        let det = dot(&a, &bc);
        let offset = [0, 1, 2]
            .map(|k| (squares[0] * bc[k] + squares[1] * ca[k] + squares[2] * ab[k]) / (2.0 * det));
        let others = [minus(&a, &b), minus(&b, &c), minus(&c, &a)].map(|e| dot(&e, &e));
        let shortest = squares.into_iter().chain(others).fold(f64::INFINITY, f64::min).sqrt();
        Self {
            volume: det.abs() / 6.0,
            centre: [0, 1, 2].map(|k| p[k] + offset[k]),
            radius: dot(&offset, &offset).sqrt(),
            shortest,
        }
    }
}
