//! The hash `ltbw.mesh/1` of a mesh in parts, byte for byte.
//!
//! Vertices are sorted by their coordinates: whoever has a stretch of them numbers it and tells the
//! numbers to whoever asked. Tetrahedra are sorted by these numbers. The bytes of each stretch go
//! through the hash where they are, one member after the other; only its state travels.

use super::Part;
use super::records::{bytes_of, refused, values_of};
use super::sort::{place_in, stretch_of};
use super::stream::HashStream;
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};
use ltbw_core::MeshHash;
use ltbw_exact::Point;
use ltbw_exact::points::{ascending, of_ascending};
use rayon::prelude::*;

/// The hash of a whole mesh, and its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hashed {
    /// The hash `ltbw.mesh/1`.
    pub hash: MeshHash,
    /// Vertices.
    pub vertices: u64,
    /// Tetrahedra.
    pub tets: u64,
}

/// A place, as numbers that ascend as its coordinates do.
type Key = [u64; 3];

/// Computes `ltbw.mesh/1` of the mesh that the parts of all members are; all get it.
///
/// Cost: that of sorting the own share twice, and the time of the hash, which is sequential.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub fn hash(team: &mut Team, part: &Part) -> Result<Hashed, TeamError> {
    let hashed = hash_whole(team, part);
    if hashed.is_err() {
        // Others may wait for this one.
        team.fail();
    }
    hashed
}

fn hash_whole(team: &mut Team, part: &Part) -> Result<Hashed, TeamError> {
    let Numbered { stretch, numbers, vertices } = numbered(team, &part.points)?;
    // As one number each, which are compared faster than lists.
    let row = |tet: &[u32; 4]| {
        let mut row = tet.map(|v| numbers[v as usize]);
        row.sort_unstable();
        row.iter().fold(0, |all: u128, &v| all << 32 | u128::from(v))
    };
    let mut own: Vec<u128> = part.tets.par_iter().map(row).collect();
    own.par_sort_unstable();
    let stretches = stretch_of(team, &own)?;
    drop(own);
    let mut rows = stretches.concat();
    drop(stretches);
    rows.sort();
    let counts: Vec<u64> = team.gather_all(&(rows.len() as u64))?;
    let tets = sum(&counts);

    let state = feed(team, HashStream::new(vertices).state(), |stream| {
        stream.coordinates(stretch.iter().map(|&key| of_ascending(key)));
    })?;
    let is_first = team.is_first();
    let state = feed(team, state, |stream| {
        if is_first {
            stream.tets(tets);
        }
        stream.rows(&rows);
    })?;
    let stream = stream_of(WorkerId::default(), &state)?;
    Ok(Hashed { hash: stream.finish(), vertices, tets })
}

/// The numbers of all vertices, by coordinates.
struct Numbered {
    /// This member's stretch of all vertices.
    stretch: Vec<Key>,
    /// The numbers of the own part's vertices.
    numbers: Vec<u32>,
    /// Vertices of the whole mesh.
    vertices: u64,
}

/// Numbers the vertices of all parts by their coordinates; those at one place are one.
fn numbered(team: &mut Team, points: &[Point]) -> Result<Numbered, TeamError> {
    let mut sorted: Vec<(Key, u32)> =
        points.par_iter().map(ascending).zip(0..points.len() as u32).collect();
    sorted.par_sort_unstable();
    let keys: Vec<Key> = sorted.iter().map(|&(key, _)| key).collect();
    let asked = stretch_of(team, &keys)?;
    drop(keys);
    let mut stretch = asked.concat();
    stretch.sort();
    stretch.dedup();
    let counts: Vec<u64> = team.gather_all(&(stretch.len() as u64))?;
    let [first, vertices] = [sum(&counts[..team.me().index()]), sum(&counts)];
    let answer = |keys: &Vec<Key>| {
        let mut place = 0;
        let number = |key: &Key| {
            place = place_in(key, &stretch, place);
            first.saturating_add(place as u64) as u32
        };
        bytes_of(keys.iter().map(number))
    };
    let answers: Vec<Vec<u8>> = asked.par_iter().map(answer).collect();
    drop(asked);
    let answers = team.exchange(answers)?;
    let mut numbers = vec![0; points.len()];
    let mut told = sorted.iter();
    for (from, bytes) in WorkerId::below(team.size()).zip(&answers) {
        for (k, number) in values_of::<u32>(from, bytes)?.enumerate() {
            let place = [4 * k, bytes.len()];
            match told.next() {
                Some(_) if u64::from(number) >= vertices => {
                    return Err(refused(from, place, "a number of no vertex").into());
                }
                Some(&(_, v)) => numbers[v as usize] = number,
                None => return Err(refused(from, place, "more numbers than vertices").into()),
            }
        }
    }
    match told.next() {
        None => Ok(Numbered { stretch, numbers, vertices }),
        Some(_) => {
            let last = WorkerId::new(team.size() - 1);
            Err(refused(last, [0, 0], "fewer numbers than vertices").into())
        }
    }
}

/// The sum of what members have told, which may be anything.
fn sum(counts: &[u64]) -> u64 {
    counts.iter().fold(0, |sum, &own| sum.saturating_add(own))
}

/// Feeds a hash at every member in turn; its state at the end.
fn feed(
    team: &mut Team,
    state: Vec<u8>,
    own: impl FnOnce(&mut HashStream),
) -> Result<Vec<u8>, TeamError> {
    let before = WorkerId::new(team.me().number().saturating_sub(1));
    team.in_turn(state, |state| {
        let mut stream = stream_of(before, &state)?;
        own(&mut stream);
        Ok(stream.state())
    })
}

/// The hash in a state that `from` has sent.
fn stream_of(from: WorkerId, state: &[u8]) -> Result<HashStream, TeamError> {
    let stream = HashStream::of_state(state);
    Ok(stream.ok_or_else(|| refused(from, [0, state.len()], "no state of a hash"))?)
}
