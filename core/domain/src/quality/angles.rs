//! Tetrahedra counted by their smallest dihedral angle, of meshes before and after slivers are
//! split.
//!
//! The counts are a function of the tetrahedra alone: corners are taken in the order of their
//! places, and an angle is told by the square of its cosine, which takes no root and no function of
//! a library.

use super::TetQuality;
use crate::vector::{cross, dot, minus, sorted};
use ltbw_exact::Point;

/// Bins of one degree: no smallest dihedral angle is above 70.53 degrees, that of a regular
/// tetrahedron. Groups, since longer arrays go through no `serde`.
const GROUPS: usize = 3;
const IN_GROUP: usize = 24;
const BINS: usize = GROUPS * IN_GROUP;

/// The cosine of two degrees.
const COS_2: f64 = 0.999_390_827_019_095_8;

/// Room for roundings at the ends of bins: an angle of exactly 45 degrees is not below 45.
const ROOM: f64 = 1e-12;

/// The squares of the cosines of whole degrees from 1 on, where bins begin.
const COS2: [f64; BINS - 1] = {
    let (mut all, mut k) = ([0.0; BINS - 1], 0);
    // cos 2(k+1)° = 2 cos 2° cos 2k° - cos 2(k-1)°
    let (mut before, mut now) = (1.0, COS_2);
    while k < BINS - 1 {
        all[k] = (1.0 + now) / 2.0 + ROOM;
        (before, now) = (now, 2.0 * COS_2 * now - before);
        k += 1;
    }
    all
};

/// The square of the cosine of a regular tetrahedron's angles, less roundings: below it there is
/// none but of a tetrahedron whose faces have no area.
const REGULAR: f64 = 1.0 / 9.0 - 1e-9;

/// The square of the cosine of a tetrahedron's smallest dihedral angle, rounded; 0 if none is
/// acute. Either orientation.
#[doc(hidden)]
#[must_use]
pub fn sharpest(corners: [&Point; 4]) -> f64 {
    Normals::of(corners).sharpest()
}

/// The normals of the faces of a tetrahedron, all outward or all inward, rounded.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    all: [Point; 4],
    squares: [f64; 4],
    /// The edges at the last corner.
    edges: [Point; 3],
}

impl Normals {
    /// The error of a squared cosine is smaller where normals are sure.
    pub const MARGIN: f64 = 1.0 / (1u64 << 24) as f64;

    /// The normals of a tetrahedron with these corners.
    #[inline(always)]
    #[must_use]
    pub fn of([p, q, r, s]: [&Point; 4]) -> Self {
        let edges = [minus(p, s), minus(q, s), minus(r, s)];
        let [a, b, c] = &edges;
        let [l, m, n] = [cross(b, c), cross(c, a), cross(a, b)];
        let last = [-(l[0] + m[0] + n[0]), -(l[1] + m[1] + n[1]), -(l[2] + m[2] + n[2])];
        let squares = [dot(&l, &l), dot(&m, &m), dot(&n, &n), dot(&last, &last)];
        Self { all: [l, m, n, last], squares, edges }
    }

    /// The square of the cosine of the smallest angle between two of the faces; 0 if none is acute.
    #[inline(always)]
    #[must_use]
    pub fn sharpest(&self) -> f64 {
        let Self { all, squares, .. } = self;
        let mut most = 0.0;
        // Loops, as closures on arrays cost twice as much.
        for i in 1..4 {
            for j in 0..i {
                let product = dot(&all[i], &all[j]);
                let cos2 = product * product / (squares[i] * squares[j]);
                if product < 0.0 && cos2 > most {
                    most = cos2;
                }
            }
        }
        most
    }

    /// Has each squared cosine an error below [`Normals::MARGIN`]?
    ///
    /// With u = 2^-53 and the longest edge L, a normal has an error below 32u L². Where all are
    /// longer than 2^-18 L² that is at most 2^-30 of each, so that a squared cosine has an error
    /// below 2^-26, if nothing is too large or too small.
    #[must_use]
    pub fn are_sure(&self) -> bool {
        // No edge is longer than two of those at one corner.
        const LEAST: f64 = 16.0 / (1u64 << 36) as f64;
        let longest = self.edges.iter().map(|e| dot(e, e)).fold(0.0, f64::max);
        let least = self.squares.iter().copied().fold(f64::INFINITY, f64::min);
        least > LEAST * (longest * longest) && least > 1e-120 && longest < 1e60
    }
}

/// Tetrahedra by their smallest dihedral angle, in bins of one degree.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LeastAngles {
    counts: [[u64; IN_GROUP]; GROUPS],
    least: f64,
}

impl Default for LeastAngles {
    /// Of no tetrahedra.
    fn default() -> Self {
        Self { counts: [[0; IN_GROUP]; GROUPS], least: f64::INFINITY }
    }
}

impl LeastAngles {
    /// The upper end of the last bin, in degrees; the first one begins with 0.
    pub const HIGH: f64 = BINS as f64;

    /// Counts a tetrahedron, whatever the order of its corners.
    pub fn add(&mut self, [p, q, r, s]: [&Point; 4]) {
        let corners = sorted([*p, *q, *r, *s]);
        let corners = corners.each_ref();
        let cos2 = sharpest(corners);
        let bin = match cos2 >= REGULAR {
            true => COS2.partition_point(|begin| cos2 <= *begin),
            false => 0,
        };
        self.counts[bin / IN_GROUP][bin % IN_GROUP] += 1;
        if bin as f64 <= self.least {
            self.least = self.least.min(TetQuality::of(corners).least_dihedral());
        }
    }

    /// The counts of these and of other tetrahedra.
    #[must_use]
    pub fn merged(mut self, others: Self) -> Self {
        let own = self.counts.as_flattened_mut().iter_mut();
        own.zip(others.counts()).for_each(|(own, more)| *own += more);
        self.least = self.least.min(others.least);
        self
    }

    /// The tetrahedra in each bin, from 0 degrees on.
    #[must_use]
    pub fn counts(&self) -> &[u64] {
        self.counts.as_flattened()
    }

    /// The smallest angle of all, in degrees, rounded; infinite of no tetrahedra.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.least
    }

    /// The tetrahedra with a smaller angle than some whole degrees; of others, than the whole
    /// degrees below.
    #[must_use]
    pub fn below(&self, degrees: f64) -> u64 {
        // The conversion saturates.
        self.counts().iter().take(degrees as usize).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Two equal sides at an edge of length 1, and the angle between them.
    fn folded(degrees: f64) -> [Point; 4] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, cos, sin]]
    }

    fn bin_of(corners: &[Point; 4]) -> usize {
        let mut own = LeastAngles::default();
        own.add(corners.each_ref());
        own.counts().iter().position(|&count| count > 0).expect("one is counted")
    }

    #[test]
    fn ends_of_bins_belong_to_the_upper_one() {
        for k in 1..50u32 {
            let degrees = f64::from(k);
            assert_eq!(bin_of(&folded(degrees + 1e-6)), k as usize);
            assert_eq!(bin_of(&folded(degrees - 1e-6)), k as usize - 1);
        }
        let regular = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 2.0], [0.0, 2.0, 2.0]];
        assert!((sharpest(regular.each_ref()) - 1.0 / 9.0).abs() < 1e-15);
        assert_eq!(bin_of(&regular), 70);
        // A sixth of a cube: 45 degrees exactly.
        let sixth = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
        assert_eq!(bin_of(&sixth), 45);
        // Without area, and flat.
        assert_eq!(bin_of(&[[1.0; 3]; 4]), 0);
        assert_eq!(bin_of(&folded(0.0)), 0);
    }

    #[test]
    fn counts_are_sums() {
        let mut all = LeastAngles::default();
        assert_eq!((all.below(90.0), all.least()), (0, f64::INFINITY));
        let mut parts = [all; 3];
        for k in 0..30 {
            let corners = folded(0.5 + f64::from(k));
            all.add(corners.each_ref());
            parts[k as usize % 3].add(corners.each_ref());
        }
        let [first, second, third] = parts;
        assert_ne!(first.merged(second), all);
        assert_eq!(third.merged(first.merged(second)), all);
        assert_eq!([0.0, 1.0, 8.0, 8.9, 90.0].map(|d| all.below(d)), [0, 1, 8, 8, 30]);
        assert!((all.least() - 0.5).abs() < 1e-9, "{}", all.least());
    }

    proptest! {
        #[test]
        fn bins_are_those_of_measured_angles(
            points in proptest::array::uniform4(proptest::array::uniform3(-1.0f64..1.0)),
            turn in 0..24usize,
        ) {
            let angle = TetQuality::of(points.each_ref()).least_dihedral();
            prop_assume!((angle - angle.round()).abs() > 1e-6);
            let mut own = LeastAngles::default();
            own.add(points.each_ref());
            prop_assert_eq!(bin_of(&points), angle as usize);
            prop_assert!((own.least() - angle).abs() < 1e-6);
            let mut turned = points;
            turned.swap(turn % 4, turn / 8);
            turned.rotate_left(turn % 3);
            let mut other = LeastAngles::default();
            other.add(turned.each_ref());
            prop_assert_eq!(own, other);
        }
    }
}
