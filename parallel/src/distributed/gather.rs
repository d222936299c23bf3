//! The tetrahedra of all parts, and the points, at the first member, for what is made of a whole
//! mesh: a file that holds all of it, a page.

use super::records::{Record, bytes_of, refused, values_of};
use super::{Part, Slice};
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};
use ltbw_core::Vertex;
use ltbw_exact::Point;

/// The tetrahedra of all parts, without a mesh: 16 bytes each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Gathered {
    /// By part, by the numbers of the input.
    pub tets: Vec<Vec<[Vertex; 4]>>,
    /// Facets of the hull.
    pub hull: Vec<[Vertex; 3]>,
}

/// Points, with tags if they have them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    /// In the coordinates of the input.
    pub at: Vec<Point>,
    /// One for each point.
    pub tags: Option<Vec<i64>>,
}

/// Brings the tetrahedra of all members, whose input has this many points, to the first one; the
/// others get nothing.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub fn gather(team: &mut Team, part: &Part, points: usize) -> Result<Option<Gathered>, TeamError> {
    let mut whole = Gathered::default();
    for from in WorkerId::below(team.size()) {
        // One after the other: the first one has the bytes of one part at a time.
        let is_sender = team.me() == from && !team.is_first();
        if is_sender {
            team.send(WorkerId::default(), &bytes_of(part.numbered()));
            team.send(WorkerId::default(), &bytes_of(part.hull.iter().copied()));
        } else if team.is_first() {
            let (tets, hull) = match from == team.me() {
                true => (part.numbered().collect(), part.hull.clone()),
                false => {
                    let tets = team.receive(from)?;
                    let tets = numbers_of(from, &tets, points)?;
                    (tets, numbers_of(from, &team.receive(from)?, points)?)
                }
            };
            whole.tets.push(tets);
            whole.hull.extend(hull);
        }
    }
    Ok(team.is_first().then_some(whole))
}

/// Brings the points of all slices to the first member, with their tags if all slices have them;
/// the others get nothing.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub fn gather_points(
    team: &mut Team,
    slice: &Slice,
    tags: Option<&[i64]>,
) -> Result<Option<Points>, TeamError> {
    let has_none = tags.is_none_or(|tags| tags.len() != slice.points().len());
    let tags = if team.is_any(has_none)? { None } else { tags };
    let own = slice.points().iter().map(|p| p.map(f64::to_bits));
    let points = to_first(team, own)?;
    let tags = match tags {
        Some(tags) => to_first(team, tags.iter().map(|&tag| tag as u64))?,
        None => None,
    };
    let points: Option<Vec<Point>> =
        points.map(|all| all.into_iter().map(|p| p.map(f64::from_bits)).collect());
    let tags = tags.map(|all| all.into_iter().map(|tag| tag as i64).collect());
    Ok(points.map(|at| Points { at, tags }))
}

/// Deals points that the first member has to all, each about its share; the others have nothing.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub fn deal(team: &mut Team, whole: Option<Points>) -> Result<Points, TeamError> {
    let first = WorkerId::default();
    let has_tags = whole.as_ref().map(|whole| whole.tags.is_some());
    let has_tags = team.tell_value(has_tags.or_else(|| team.is_first().then_some(false)))?;
    let Some(mut whole) = whole else {
        let at = team.receive(first)?;
        let at = values_of::<[u64; 3]>(first, &at)?.map(|p| p.map(f64::from_bits)).collect();
        let mut tags = None;
        if has_tags {
            let bytes = team.receive(first)?;
            tags = Some(values_of::<u64>(first, &bytes)?.map(|tag| tag as i64).collect());
        }
        return Ok(Points { at, tags });
    };
    let (count, members) = (whole.at.len(), team.size() as usize);
    for to in WorkerId::below(team.size()).skip(1) {
        let own = [to.index(), to.index() + 1].map(|k| k * count / members);
        let points = &whole.at[own[0]..own[1]];
        team.send(to, &bytes_of(points.iter().map(|p| p.map(f64::to_bits))));
        if let Some(tags) = &whole.tags {
            team.send(to, &bytes_of(tags[own[0]..own[1]].iter().map(|&tag| tag as u64)));
        }
    }
    whole.at.truncate(count / members);
    whole.at.shrink_to_fit();
    if let Some(tags) = &mut whole.tags {
        tags.truncate(count / members);
    }
    Ok(whole)
}

/// Values of all members at the first one, by member; one after the other.
fn to_first<R: Record>(
    team: &mut Team,
    own: impl ExactSizeIterator<Item = R>,
) -> Result<Option<Vec<R>>, TeamError> {
    if !team.is_first() {
        team.send(WorkerId::default(), &bytes_of(own));
        return Ok(None);
    }
    let mut all: Vec<R> = own.collect();
    for from in WorkerId::below(team.size()).skip(1) {
        let bytes = team.receive(from)?;
        all.extend(values_of::<R>(from, &bytes)?);
    }
    Ok(Some(all))
}

/// Numbers of points that `from` has sent, each of which there is.
fn numbers_of<const N: usize>(
    from: WorkerId,
    bytes: &[u8],
    points: usize,
) -> Result<Vec<[Vertex; N]>, TeamError> {
    let all: Vec<[Vertex; N]> = values_of(from, bytes)?.collect();
    let is_foreign = |own: &[Vertex; N]| own.iter().any(|&v| v as usize >= points);
    match all.iter().position(is_foreign) {
        Some(k) => {
            let at = k * <[Vertex; N]>::BYTES;
            Err(refused(from, [at, bytes.len()], "a number of no point").into())
        }
        None => Ok(all),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_no_point_are_refused_by_name() {
        let from = WorkerId::new(2);
        let bytes = bytes_of([[0_u32, 1, 2], [1, 4, 2]].into_iter());
        assert_eq!(numbers_of::<3>(from, &bytes, 5).map(|all| all.len()), Ok(2));
        match numbers_of::<3>(from, &bytes, 4) {
            Err(TeamError::Wire(error)) => assert_eq!((error.from, error.at), (from, 12)),
            other => panic!("{other:?}"),
        }
    }
}
