//! The tetrahedra of all parts at the first member, for what is made of a whole mesh: a file that
//! holds all of it, a page.

use super::Part;
use super::records::{Record, bytes_of, refused, values_of};
use crate::protocol::WorkerId;
use crate::team::{Post, Team, TeamError};
use ltbw_core::Vertex;

/// The tetrahedra of all parts, without a mesh: 16 bytes each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Gathered {
    /// By part, by the numbers of the input.
    pub tets: Vec<Vec<[Vertex; 4]>>,
    /// Facets of the hull.
    pub hull: Vec<[Vertex; 3]>,
}

/// Brings the tetrahedra of all members, whose input has this many points, to the first one; the
/// others get nothing.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub fn gather<P: Post>(
    team: &mut Team<P>,
    part: &Part,
    points: usize,
) -> Result<Option<Gathered>, TeamError> {
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
