//! The thickness of point sets: are they points of a plane, but for rounding?

use crate::vector::{cross, distance2, dot, minus};
use ltbw_exact::Point;
use std::fmt;

/// The largest part of their extent that nearly flat points are thick.
const FLAT: f64 = 1.0 / (1 << 20) as f64;

/// The reach of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thickness {
    /// Across the plane through three of them that are far from each other.
    pub thickness: f64,
    /// The distance of two that are far from each other.
    pub extent: f64,
}

impl Thickness {
    /// That of points, if they are nearly in one plane: not thicker than 2^-20 of their extent.
    /// Rounded, for people. O(n).
    #[must_use]
    pub fn of_flat(points: &[Point]) -> Option<Self> {
        let first = *points.first()?;
        let farthest = |measure: &dyn Fn(&Point) -> f64| {
            let found = points.iter().max_by(|p, q| measure(p).total_cmp(&measure(q)));
            Ok::<_, std::convert::Infallible>(found.copied().unwrap_or(first))
        };
        let Ok(found) = Self::by(first, farthest);
        found
    }

    /// As [`Thickness::of_flat`], of points wherever they are: `first` is one of them, and
    /// `farthest` finds the one with the greatest measure.
    ///
    /// # Errors
    /// Those of `farthest`.
    pub fn by<E>(
        first: Point,
        mut farthest: impl FnMut(&dyn Fn(&Point) -> f64) -> Result<Point, E>,
    ) -> Result<Option<Self>, E> {
        let a = farthest(&|p| distance2(p, &first))?;
        let b = farthest(&|p| distance2(p, &a))?;
        let across = |p: &Point| cross(&minus(&b, &a), &minus(p, &a));
        let c = farthest(&|p| dot(&across(p), &across(p)))?;
        let (normal, extent) = (across(&c), distance2(&a, &b).sqrt());
        let length = dot(&normal, &normal).sqrt();
        if length == 0.0 {
            return Ok(None);
        }
        let height = |p: &Point| dot(&minus(p, &a), &normal) / length;
        let (highest, lowest) = (farthest(&height)?, farthest(&|p| -height(p))?);
        let thickness = height(&highest) - height(&lowest);
        Ok((thickness <= FLAT * extent).then_some(Self { thickness, extent }))
    }
}

/// A note for people on what that means for a mesh.
impl fmt::Display for Thickness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { thickness, extent } = self;
        write!(
            f,
            "the points are nearly in one plane: thickness {thickness:.3e}, {:.1e} of their \
             extent; the tetrahedra are as flat",
            thickness / extent
        )
    }
}

#[cfg(test)]
mod tests {
    use super::Thickness;
    use ltbw_core::Random;

    #[test]
    fn nearly_flat_points_have_the_thickness_of_their_noise() {
        let mut random = Random::new(7);
        for size in [1e-6, 1.0, 1e6] {
            for part in [0.0, 1e-12, 1e-8, 1e-3] {
                let (u, v, w) = ([0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]);
                let mut point = || {
                    let [s, t, n] = [0; 3].map(|_| random.unit() - 0.5);
                    [0, 1, 2].map(|k: usize| size * (s * u[k] + t * v[k] + part * n * w[k]))
                };
                let points: Vec<_> = (0..1000).map(|_| point()).collect();
                let found = Thickness::of_flat(&points);
                assert_eq!(found.is_some(), part < 1e-6, "{size} {part}");
                if let Some(found) = found {
                    assert!(found.extent > size && found.extent < 1.5 * size);
                    let (low, high) =
                        (0.25 * part * size - 1e-14 * size, (8.0 * part + 1e-14) * size);
                    let thickness = found.thickness;
                    assert!(low <= thickness && thickness <= high, "{thickness} {part}");
                }
            }
        }
        assert_eq!(Thickness::of_flat(&[]), None);
        assert_eq!(Thickness::of_flat(&[[1.0; 3]; 4]), None);
    }
}
