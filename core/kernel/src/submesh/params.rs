//! The parameters of a whole mesh, which submeshes have to know before there is one.

use crate::topology::MAX_TETS;
use ltbw_exact::Point;
use ltbw_exact::points::Mode;
use rayon::prelude::*;

/// The box and the arithmetic of the whole mesh, and the size of a part.
#[derive(Clone, Copy, Debug)]
pub struct MeshParams {
    pub(super) low: Point,
    pub(super) high: Point,
    pub(super) wide: bool,
    pub(super) step: f64,
    pub(super) vertices: usize,
    pub(super) max_tets: usize,
}

/// The extent of points: what the parameters of a mesh are made of. That of all points is the join
/// of those of parts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Extent {
    low: Point,
    high: Point,
    /// The largest power of two of which all coordinates are multiples; 0 if it is not asked for.
    step: f64,
}

impl Extent {
    /// That of points in kernel coordinates under `mode`.
    pub fn of(points: &[Point], mode: Mode) -> Self {
        let wide = mode == Mode::Wide;
        let of_chunk = |chunk: &[Point]| {
            let (low, high) = crate::order::bounding_box(chunk);
            let step = if wide { 0.0 } else { crate::geometry::common_step(chunk) };
            Self { low, high, step }
        };
        points.par_chunks(1 << 14).map(of_chunk).reduce(|| of_chunk(&[]), Self::join)
    }

    /// That of both.
    #[must_use]
    pub fn join(self, other: Self) -> Self {
        Self {
            low: [0, 1, 2].map(|k| self.low[k].min(other.low[k])),
            high: [0, 1, 2].map(|k| self.high[k].max(other.high[k])),
            step: self.step.min(other.step),
        }
    }
}

impl MeshParams {
    /// The parameters of a mesh with these points, in kernel coordinates under `mode`.
    pub fn of(points: &[Point], mode: Mode) -> Self {
        Self::within(Extent::of(points, mode), mode).vertices(points.len())
    }

    /// The parameters of a mesh whose points, in kernel coordinates under `mode`, have this extent.
    pub fn within(Extent { low, high, step }: Extent, mode: Mode) -> Self {
        Self { low, high, wide: mode == Mode::Wide, step, vertices: 0, max_tets: MAX_TETS }
    }

    /// Sets how many vertices a submesh has at the start: those that it is to insert. At first it
    /// is the number of all points.
    pub fn vertices(self, vertices: usize) -> Self {
        Self { vertices, ..self }
    }

    /// The corners of the box.
    pub fn bounds(&self) -> (Point, Point) {
        (self.low, self.high)
    }

    /// Sets how many tetrahedra, hull ghosts and far faces included, a submesh may have at most: no
    /// more than [`MAX_TETS`], which is the default.
    pub fn at_most(self, max_tets: usize) -> Self {
        Self { max_tets, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extent_of_parts_joined_is_that_of_all() {
        let points = [[0.0, 8.0, -4.0], [2.5, 1.0, 6.0], [-3.0, 0.5, 12.0], [1.0, 1.0, 1.0]];
        for mode in [Mode::Normal, Mode::Wide] {
            let of = |points: &[Point]| Extent::of(points, mode);
            for cut in 0..=points.len() {
                assert_eq!(of(&points[..cut]).join(of(&points[cut..])), of(&points));
            }
        }
        let all = Extent::of(&points, Mode::Normal);
        assert_eq!((all.low, all.high, all.step), ([-3.0, 0.5, -4.0], [2.5, 8.0, 12.0], 0.5));
    }
}
