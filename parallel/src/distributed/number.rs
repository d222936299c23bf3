//! Numbers of vertices that nobody has given one: along the curve by which one engine numbers them,
//! which has all of them.

use super::records::{bytes_of, refused, values_of};
use super::sort::{place_in, stretch_cut};
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};
use ltbw_core::order::{Curve, bounding_box};
use ltbw_exact::Point;
use ltbw_exact::points::{ascending, of_ascending};
use rayon::prelude::*;

/// Key along the curve, coordinates as numbers that ascend as they do, kind.
type Keyed = [u64; 5];

/// A vertex of a part without a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unnumbered {
    pub(crate) at: Point,
    /// The kind under which it is counted, below [`KINDS`]: the same in all parts.
    pub(crate) kind: u8,
}

/// Kinds of vertices.
pub(crate) const KINDS: usize = 3;

/// The numbers of a part's vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Numbered {
    /// In the order in which they were given.
    pub(crate) numbers: Vec<u32>,
    /// The vertices of all parts, by kind: each place counts once.
    pub(crate) counts: [u64; KINDS],
}

/// Numbers the vertices of all parts, from `first` on; those at one place are one.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub(crate) fn number(
    team: &mut Team,
    own: &[Unnumbered],
    first: u32,
) -> Result<Numbered, TeamError> {
    let boxes: Vec<(Point, Point)> =
        team.gather_all(&bounding_box(own.iter().map(|own| &own.at)))?;
    let (low, high) = bounding_box(boxes.iter().flat_map(|(low, high)| [low, high]));
    let curve = Curve::of_box(low, high);
    let keyed = |own: &Unnumbered| {
        let [x, y, z] = ascending(&own.at);
        [curve.key(&own.at), x, y, z, u64::from(own.kind)]
    };
    let mut sorted: Vec<(Keyed, u32)> =
        own.par_iter().map(keyed).zip(0..own.len() as u32).collect();
    sorted.par_sort_unstable();
    let keys: Vec<Keyed> = sorted.iter().map(|own| own.0).collect();
    // One member has all of a cell: clusters are sorted again.
    let asked = stretch_cut(team, &keys, |[key, ..]| [key, 0, 0, 0, 0])?;
    drop(keys);
    let mut stretch = asked.concat();
    stretch.sort();
    stretch.dedup();
    let points: Vec<Point> =
        stretch.par_iter().map(|&[_, x, y, z, _]| of_ascending([x, y, z])).collect();
    let mut counts = [0; KINDS];
    for (k, own) in stretch.iter().enumerate() {
        match counts.get_mut(own[4] as usize) {
            Some(count) if points[k].iter().all(|c| c.is_finite()) => *count += 1,
            _ => return Err(refused(team.me(), [k, stretch.len()], "no vertex of a part").into()),
        }
    }
    let all: Vec<[u64; KINDS]> = team.gather_all(&counts)?;
    let add =
        |sum: [u64; KINDS], own: &[u64; KINDS]| [0, 1, 2].map(|k| sum[k].saturating_add(own[k]));
    let before = all[..team.me().index()].iter().fold([0; KINDS], add);
    let counts = all.iter().fold([0; KINDS], add);
    let start = before.iter().fold(u64::from(first), |sum, own| sum.saturating_add(*own));
    let mut places = vec![0_u32; stretch.len()];
    for (place, k) in (start..).zip(curve.hilbert(&points)) {
        places[k as usize] = place as u32;
    }
    drop(points);
    // Whatever was asked for is in the stretch.
    let answer = |keys: &Vec<Keyed>| {
        let mut place = 0;
        let number = |own: &Keyed| {
            place = place_in(own, &stretch, place);
            places[place]
        };
        bytes_of(keys.iter().map(number))
    };
    let answers: Vec<Vec<u8>> = asked.par_iter().map(answer).collect();
    drop(asked);
    let answers = team.exchange(answers)?;
    let mut numbers = vec![0; own.len()];
    let mut told = sorted.iter();
    for (from, bytes) in WorkerId::below(team.size()).zip(&answers) {
        for (k, number) in values_of::<u32>(from, bytes)?.enumerate() {
            match told.next() {
                Some(&(_, v)) => numbers[v as usize] = number,
                None => {
                    let place = [4 * k, bytes.len()];
                    return Err(refused(from, place, "more numbers than vertices").into());
                }
            }
        }
    }
    match told.next() {
        None => Ok(Numbered { numbers, counts }),
        Some(_) => Err(refused(team.me(), [0, 0], "fewer numbers than vertices").into()),
    }
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::*;
    use crate::team::threads;
    use ltbw_core::order::hilbert;
    use ltbw_generate::{PointKind, generate};

    /// The numbers are those along the curve of all, clusters in one cell included, however the
    /// points are divided, and whatever several parts have.
    #[test]
    fn parts_number_their_vertices_as_one_does() {
        let uniform = generate(PointKind::Uniform, 300, 7);
        let far = [[-1e9; 3], [1e9; 3]];
        let cluster: Vec<Point> = far.iter().copied().chain(uniform.iter().copied()).collect();
        for mut points in [uniform, cluster, vec![[1.0, 2.0, 3.0]], Vec::new()] {
            points.sort_unstable_by_key(ascending);
            let kind = |k: usize| (k % 7 % 3) as u8;
            let mut expected = vec![0; points.len()];
            (5..).zip(hilbert(&points)).for_each(|(n, k)| expected[k as usize] = n);
            let count = |own: u8| (0..points.len()).filter(|&k| kind(k) == own).count() as u64;
            let counts = [0, 1, 2].map(count);
            for members in [1, 2, 3, 5] {
                let posts = threads(members);
                std::thread::scope(|scope| {
                    for (me, post) in posts.into_iter().enumerate() {
                        let (points, expected) = (&points, &expected);
                        scope.spawn(move || {
                            let mut team = Team::new(post);
                            let is_own = |k: &usize| {
                                k % members as usize == me
                                    || k.is_multiple_of(if me == 2 { 2 } else { 4 })
                            };
                            let all: Vec<usize> = (0..points.len()).rev().filter(is_own).collect();
                            let own: Vec<Unnumbered> = all
                                .iter()
                                .map(|&k| Unnumbered { at: points[k], kind: kind(k) })
                                .collect();
                            let found = number(&mut team, &own, 5).expect("numbers");
                            let wanted: Vec<u32> = all.iter().map(|&k| expected[k]).collect();
                            assert_eq!(found.numbers, wanted, "{me} of {members}");
                            assert_eq!(found.counts, counts, "{me} of {members}");
                        });
                    }
                });
            }
        }
    }
}
