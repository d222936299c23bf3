//! Triangles between two parts: one of the two has each, and each is told of the other's side.

use super::records::{bytes_of, refused, values_of};
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};

/// One side of a triangle at which another part may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Side {
    /// The corners of the triangle by number, ascending.
    pub(crate) corners: [u32; 3],
    /// The rank of its tetrahedron's region, and that one's vertices: the lesser has the triangle.
    pub(crate) rank: [u32; 5],
}

/// The answer about a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shared {
    /// Has this member the triangle?
    pub(crate) is_own: bool,
    /// The rank of the region on the other side, if somebody has told of it.
    pub(crate) beyond: Option<u32>,
}

/// Whether this member has each of some triangles, and what is beyond: both sides go to the member
/// whom the corners name.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub(crate) fn first_of_two(team: &mut Team, own: &[Side]) -> Result<Vec<Shared>, TeamError> {
    let size = team.size();
    let member = |side: &Side| {
        let [a, b, c] = side.corners.map(u64::from);
        let mixed = (a << 32 | b).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ c;
        (((mixed >> 32) * u64::from(size)) >> 32) as usize
    };
    let mut parts: Vec<Vec<[u32; 8]>> = vec![Vec::new(); size as usize];
    for side in own {
        let ([a, b, c], [r, v, w, x, y]) = (side.corners, side.rank);
        parts[member(side)].push([a, b, c, r, v, w, x, y]);
    }
    let parts = parts.into_iter().map(|own| bytes_of(own.into_iter())).collect();
    let met = team.exchange(parts)?;
    let mut all: Vec<([u32; 8], WorkerId, usize)> = Vec::new();
    let mut answers = Vec::with_capacity(met.len());
    for (from, bytes) in WorkerId::below(size).zip(&met) {
        let sides = values_of::<[u32; 8]>(from, bytes)?;
        answers.push(vec![[0_u32; 3]; sides.len()]);
        all.extend(sides.enumerate().map(|(k, side)| (side, from, k)));
    }
    all.sort_unstable();
    for group in all.chunk_by(|a, b| a.0[..3] == b.0[..3]) {
        // One of the two has it; the region on the other side is told, if there are two.
        let mut answer = |to: &([u32; 8], WorkerId, usize), own: [u32; 3]| {
            answers[to.1.index()][to.2] = own;
        };
        match group {
            [one] => answer(one, [1, 0, 0]),
            [one, other, ..] => {
                answer(one, [1, 1, other.0[3]]);
                answer(other, [0, 1, one.0[3]]);
            }
            [] => {}
        }
    }
    let answers = answers.into_iter().map(|own| bytes_of(own.into_iter())).collect();
    let answers = team.exchange(answers)?;
    let mut told = Vec::with_capacity(answers.len());
    for (from, bytes) in WorkerId::below(size).zip(&answers) {
        told.push(values_of::<[u32; 3]>(from, bytes)?.collect::<Vec<_>>().into_iter());
    }
    let answer = |side: &Side| {
        let from = member(side);
        told[from].next().ok_or_else(|| {
            let from = WorkerId::new(from as u32);
            refused(from, [0, answers[from.index()].len()], "fewer answers than sides").into()
        })
    };
    let shared = |[is_own, is_told, region]: [u32; 3]| Shared {
        is_own: is_own == 1,
        beyond: (is_told == 1).then_some(region),
    };
    own.iter().map(answer).map(|own| own.map(shared)).collect()
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::*;
    use crate::team::threads;

    #[test]
    fn one_of_two_parts_has_a_triangle_and_knows_what_is_beyond() {
        let side = |k: u32, region: u32| Side { corners: [k, k + 1, k + 5], rank: [region; 5] };
        let posts = threads(3);
        std::thread::scope(|scope| {
            for (me, post) in (0..3u32).zip(posts) {
                scope.spawn(move || {
                    let mut team = Team::new(post);
                    // Triangles of this one and the next; the lower region is that of the greater.
                    let shared = |k: u32| side(100 * k + me % 2, 7 - me);
                    let own = [side(9 + 10 * me, 1), shared(1), shared(2)];
                    let found = first_of_two(&mut team, &own).expect("answers");
                    let told = |is_own, beyond| Shared { is_own, beyond };
                    let between =
                        [told(false, Some(5)), told(true, None), told(true, Some(7))][me as usize];
                    assert_eq!(found, [told(true, None), between, between], "{me}");
                });
            }
        });
    }
}
