//! The parameters of the paper's Algorithm 1: the order in which bad tetrahedra are taken, and the
//! function that places a point for one. They are for runs without rounds, whose mesh depends on
//! the order in any case: to be studied.

use crate::complex::measure::Shape;
use ltbw_exact::Point;
use std::fmt;
use std::str::FromStr;

/// The order in which bad tetrahedra are taken; the boundary goes first in any case.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// The largest circumradius first.
    #[default]
    Largest,
    /// The smallest one first.
    Smallest,
    /// As they were found.
    Oldest,
    /// The other way round.
    Newest,
}

/// All parameters.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strategy {
    /// The order of tetrahedra.
    pub order: Order,
    /// The share of the way from the circumcentre to the middle of the shortest edge at which the
    /// point is placed, at most [`Strategy::MOST`].
    pub towards: f64,
}

impl Order {
    /// All orders.
    pub const ALL: [Self; 4] = [Self::Largest, Self::Smallest, Self::Oldest, Self::Newest];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Largest => "largest",
            Self::Smallest => "smallest",
            Self::Oldest => "oldest",
            Self::Newest => "newest",
        }
    }

    /// The urgency of a tetrahedron with this circumradius, found after `count` others.
    pub fn urgency(self, radius: f64, count: u64) -> u64 {
        // The bits of positive numbers order them.
        match self {
            Self::Largest => radius.to_bits(),
            Self::Smallest => !radius.to_bits(),
            Self::Oldest => !count,
            Self::Newest => count,
        }
    }
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Order {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|order| order.name() == text);
        found.ok_or_else(|| format!("no order `{text}`: largest, smallest, oldest or newest"))
    }
}

impl Strategy {
    /// The largest share: the point stays three quarters of a circumradius from all corners, which
    /// with a bound of 2 is one and a half times the shortest edge.
    pub const MOST: f64 = 0.25;

    /// The place for a tetrahedron's point.
    pub(crate) fn place(&self, shape: &Shape, corners: [&Point; 4]) -> Option<Point> {
        let centre = shape.circumcentre(corners[3])?;
        if self.towards == 0.0 {
            return Some(centre);
        }
        let pairs = (0..4).flat_map(|i| (0..i).map(move |j| [corners[i], corners[j]]));
        let square = |[a, b]: &[&Point; 2]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>();
        let [a, b] = pairs.min_by(|x, y| square(x).total_cmp(&square(y)))?;
        let middle = |k: usize| 0.5 * (a[k] + b[k]);
        Some([0, 1, 2].map(|k| centre[k] + self.towards * (middle(k) - centre[k])))
    }
}
