//! Groups of circumspheres that are nearly equal, of each of which one tetrahedron is probed.

use ltbw_exact::Point;

/// The circumspheres that are nearly equal to one: the power of two below its radius, and the cell
/// of its centre in a grid of half of that.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Group(i32, [i64; 3]);

/// Where 0 is in its cell of the grid.
const SHIFT: f64 = 0.382;

impl Group {
    /// The group of a sphere. Two spheres of one group hold each other's centres: their radii are
    /// from s to 2s, and their centres at most s √3/2 apart.
    pub(crate) fn of(centre: &Point, radius: f64) -> Self {
        let exponent = (radius.to_bits() >> 52) as i32;
        let half = f64::from_bits(((exponent - 1).max(1) as u64) << 52);
        // Domains with a middle have it at 0, which is in one cell.
        Self(exponent, centre.map(|c| (c / half + SHIFT).floor() as i64))
    }
}
