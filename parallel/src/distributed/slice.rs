//! The points that are given, in slices: each member has one, and no member has them all.

use crate::team::{Team, TeamError};
use ltbw_exact::points::{Magnitudes, check_count};
use ltbw_exact::{Mode, Point, PointError};
use serde::{Deserialize, Serialize};

/// One member's slice of the points: those of all members, one after the other, are the input, and
/// their places there are their numbers.
#[derive(Clone, Debug)]
pub struct Slice {
    points: Vec<Point>,
    me: usize,
    firsts: Vec<u64>,
    mode: Mode,
}

/// Why points in slices are no input.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SliceError {
    /// As with one list of them: the same error at all members.
    #[error(transparent)]
    Points(#[from] PointError),
    /// A member has failed.
    #[error(transparent)]
    Team(#[from] TeamError),
}

/// The word of a member on its slice.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Told {
    count: u64,
    found: Result<Magnitudes, NotFinite>,
}

/// The first coordinate of a slice that is not finite.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct NotFinite {
    index: u64,
    axis: char,
    value: f64,
}

impl Slice {
    /// Validates the points of all members as [`ltbw_exact::PointSet::new`] does those of one.
    ///
    /// # Errors
    /// [`SliceError`], the same at all members: the first point of all that is wrong, by its
    /// number among all.
    pub fn new(team: &mut Team, mut points: Vec<Point>) -> Result<Self, SliceError> {
        let count = points.len() as u64;
        let found = Magnitudes::of(&mut points).map_err(|error| match error {
            PointError::NotFinite { index, axis, value } => {
                NotFinite { index: index as u64, axis, value }
            }
            _ => NotFinite { index: 0, axis: 'x', value: f64::NAN },
        });
        let all: Vec<Told> = team.gather_all(&Told { count, found })?;
        let mut firsts = vec![0_u64];
        for told in &all {
            firsts.push(firsts[firsts.len() - 1].saturating_add(told.count));
        }
        check_count(firsts[all.len()] as usize)?;
        let mut range = Magnitudes::NONE;
        for (told, first) in all.iter().zip(&firsts) {
            match told.found {
                Ok(own) => range = range.join(own),
                Err(NotFinite { index, axis, value }) => {
                    let index = first.saturating_add(index) as usize;
                    return Err(PointError::NotFinite { index, axis, value }.into());
                }
            }
        }
        Ok(Self { points, me: team.me().index(), firsts, mode: range.mode() })
    }

    /// The points of this slice, in the coordinates of the input.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The number of its first one.
    pub fn first(&self) -> u32 {
        self.firsts[self.me] as u32
    }

    /// Number of points of all slices.
    pub fn total(&self) -> u32 {
        self.firsts[self.firsts.len() - 1] as u32
    }

    /// The numbers of the first points of all members, and the number of points.
    pub(super) fn firsts(&self) -> &[u64] {
        &self.firsts
    }

    /// The mode of computing with the points of all slices.
    pub fn mode(&self) -> Mode {
        self.mode
    }
}
