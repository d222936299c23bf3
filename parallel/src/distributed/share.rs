//! Triangles between two parts: one of the two has each.

use super::records::{bytes_of, refused, values_of};
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};

/// One side of a triangle at which another part may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Side {
    /// The corners of the triangle by number, ascending.
    pub(crate) corners: [u32; 3],
    /// The region and the vertices of the tetrahedron on this side: the lesser has the triangle.
    pub(crate) rank: [u32; 5],
}

/// Whether this member has each of some triangles: it is told to whom the corners send both sides.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub(crate) fn first_of_two(team: &mut Team, own: &[Side]) -> Result<Vec<bool>, TeamError> {
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
        answers.push(vec![0_u32; sides.len()]);
        all.extend(sides.enumerate().map(|(k, side)| (side, from, k)));
    }
    all.sort_unstable();
    for group in all.chunk_by(|a, b| a.0[..3] == b.0[..3]) {
        let (_, from, k) = group[0];
        answers[from.index()][k] = 1;
    }
    let answers = answers.into_iter().map(|own| bytes_of(own.into_iter())).collect();
    let answers = team.exchange(answers)?;
    let mut told = Vec::with_capacity(answers.len());
    for (from, bytes) in WorkerId::below(size).zip(&answers) {
        told.push(values_of::<u32>(from, bytes)?.collect::<Vec<u32>>().into_iter());
    }
    let answer = |side: &Side| {
        let from = member(side);
        told[from].next().ok_or_else(|| {
            let from = WorkerId::new(from as u32);
            refused(from, [0, answers[from.index()].len()], "fewer answers than sides").into()
        })
    };
    own.iter().map(answer).map(|own| own.map(|word| word == 1)).collect()
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::*;
    use crate::team::threads;

    #[test]
    fn one_of_two_parts_has_a_triangle_and_one_alone_has_its_own() {
        let side = |k: u32, region: u32| Side { corners: [k, k + 1, k + 5], rank: [region; 5] };
        let posts = threads(3);
        std::thread::scope(|scope| {
            for (me, post) in (0..3u32).zip(posts) {
                scope.spawn(move || {
                    let mut team = Team::new(post);
                    // Triangles of this one and the next; the lower region is that of the greater.
                    let shared = |k: u32| side(100 * k + me % 2, 7 - me);
                    let own = [side(9 + 10 * me, 1), shared(1), shared(2)];
                    let has = first_of_two(&mut team, &own).expect("answers");
                    let expected = [true, me > 0, me > 0];
                    assert_eq!(has, expected, "{me}");
                });
            }
        });
    }
}
