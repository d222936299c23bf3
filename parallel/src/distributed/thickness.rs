//! Whether the points of all members are nearly in one plane.

use super::Slice;
use crate::team::{Team, TeamError};
use ltbw_domain::Thickness;
use ltbw_exact::Point;

/// The thickness of the points of all slices, if they are nearly in one plane: the same at all
/// members.
///
/// # Errors
/// [`TeamError`] if a member has failed.
pub fn thickness(team: &mut Team, slice: &Slice) -> Result<Option<Thickness>, TeamError> {
    let points = slice.points();
    let firsts: Vec<Option<Point>> = team.gather_all(&points.first().copied())?;
    let Some(first) = firsts.into_iter().flatten().next() else { return Ok(None) };
    Thickness::by(first, |measure| {
        let own = points.iter().max_by(|p, q| measure(p).total_cmp(&measure(q)));
        let all: Vec<Option<Point>> = team.gather_all(&own.copied())?;
        let farthest = all.into_iter().flatten().max_by(|p, q| measure(p).total_cmp(&measure(q)));
        Ok(farthest.unwrap_or(first))
    })
}
