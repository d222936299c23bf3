//! The points of all members, sorted along a Hilbert curve: each member gets a stretch of it, with
//! its exact share of the different points.
//!
//! Sorted are records of key, coordinates and number: a cluster may be smaller than a cell of the
//! curve, which is one key, and points at one place come together wherever their slices were. Of
//! these the least number is the vertex. Inside its stretch a member orders its points as it likes,
//! along a curve through the stretch alone: places are names, and the mesh does not depend on them.

use super::Slice;
use super::records::{bytes_of, refused, values_of};
use super::sort::stretch_of;
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};
use ltbw_core::build::is_independent;
use ltbw_core::order::{Curve, hilbert};
use ltbw_core::submesh::{Extent, MeshParams};
use ltbw_core::{Duplicate, Vertex};
use ltbw_exact::Point;
use ltbw_exact::points::{ascending, of_ascending};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Key along the curve, coordinates as numbers that ascend as they do, number in the input.
type Keyed = [u64; 5];

/// One member's stretch of the curve.
#[derive(Clone, Debug)]
pub struct Ordered {
    /// Kernel coordinates of the different points of the stretch.
    pub points: Vec<Point>,
    /// Their numbers in the input, the least ones of equal points.
    pub numbers: Vec<Vertex>,
    /// By member: vertices before its stretch; and all vertices.
    pub firsts: Vec<u64>,
    /// The extent of the points of all members.
    pub extent: Extent,
    /// Points of all slices that equal another one, a part of them.
    pub duplicates: Vec<Duplicate>,
}

/// A vertex of the whole mesh: its number along the curve, from 0, and its kernel coordinates.
pub type Placed = (u32, Point);

/// The last place of a sorted stretch, and the least number there.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Ends {
    last: [u64; 3],
    least: u64,
}

/// Sorts the points of all members.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub fn order(team: &mut Team, slice: &Slice) -> Result<Ordered, TeamError> {
    let mode = slice.mode();
    let kernel: Vec<Point> = slice.points().par_iter().map(|&p| mode.to_kernel(p)).collect();
    let all: Vec<Extent> = team.gather_all(&Extent::of(&kernel, mode))?;
    let extent = all.into_iter().fold(Extent::of(&[], mode), Extent::join);
    let (low, high) = MeshParams::within(extent, mode).bounds();
    let curve = Curve::of_box(low, high);
    let keyed = |(p, number): (&Point, u32)| {
        let [x, y, z] = ascending(p);
        [curve.key(p), x, y, z, u64::from(slice.first() + number)]
    };
    let mut own: Vec<Keyed> = kernel.par_iter().zip(0..kernel.len() as u32).map(keyed).collect();
    drop(kernel);
    own.par_sort_unstable();
    let stretches = stretch_of(team, &own)?;
    drop(own);
    let is_foreign = |own: &Keyed| own[4] >= u64::from(slice.total());
    for (from, stretch) in WorkerId::below(team.size()).zip(&stretches) {
        if let Some(k) = stretch.iter().position(|own| is_foreign(own) || !is_finite(own)) {
            return Err(refused(from, [40 * k, 40 * stretch.len()], "no point of the input").into());
        }
    }
    let mut sorted = stretches.concat();
    drop(stretches);
    sorted.sort();
    let Distinct { records, duplicates } = distinct(team, &sorted)?;
    drop(sorted);
    let (firsts, records) = share(team, records)?;
    let points: Vec<Point> =
        records.par_iter().map(|&[x, y, z, _]| of_ascending([x, y, z])).collect();
    let along = hilbert(&points);
    Ok(Ordered {
        points: along.par_iter().map(|&k| points[k as usize]).collect(),
        numbers: along.iter().map(|&k| records[k as usize][3] as Vertex).collect(),
        firsts,
        extent,
        duplicates,
    })
}

/// Coordinates and number of a point.
type Record = [u64; 4];

fn place_of([_, x, y, z, _]: &Keyed) -> [u64; 3] {
    [*x, *y, *z]
}

fn is_finite(own: &Keyed) -> bool {
    of_ascending(place_of(own)).iter().all(|c| c.is_finite())
}

/// The different points of a stretch.
struct Distinct {
    records: Vec<Record>,
    duplicates: Vec<Duplicate>,
}

/// Leaves out points that are at the place of another one, here or in a stretch before.
fn distinct(team: &mut Team, sorted: &[Keyed]) -> Result<Distinct, TeamError> {
    let ends = sorted.last().map(|own| {
        let last = place_of(own);
        let first = sorted.partition_point(|other| other[..4] < own[..4]);
        Ends { last, least: sorted[first][4] }
    });
    let all: Vec<Option<Ends>> = team.gather_all(&ends)?;
    let mut before: Option<Ends> = None;
    for ends in all[..team.me().index()].iter().flatten() {
        // A stretch that ends where the one before it does has that place alone.
        if before.is_none_or(|before| before.last != ends.last) {
            before = Some(*ends);
        }
    }
    let (mut records, mut duplicates) = (Vec::with_capacity(sorted.len()), Vec::new());
    for own in sorted {
        let (at, number) = (place_of(own), own[4]);
        match before {
            Some(Ends { last, least }) if last == at => {
                let [number, kept] = [number, least].map(|number| number as Vertex);
                duplicates.push(Duplicate { number, kept });
            }
            _ => {
                before = Some(Ends { last: at, least: number });
                let [x, y, z] = at;
                records.push([x, y, z, number]);
            }
        }
    }
    Ok(Distinct { records, duplicates })
}

/// Moves sorted records so that each member has its exact share of all; what each has before its
/// own, and all.
fn share(team: &mut Team, own: Vec<Record>) -> Result<(Vec<u64>, Vec<Record>), TeamError> {
    let counts: Vec<u64> = team.gather_all(&(own.len() as u64))?;
    let sum = |counts: &[u64]| counts.iter().fold(0, |sum: u64, own| sum.saturating_add(*own));
    let (before, all) = (sum(&counts[..team.me().index()]), sum(&counts));
    let members = u64::from(team.size());
    // As blocks are cut.
    let share_of = |k: u64| (u128::from(k) * u128::from(all) / u128::from(members)) as u64;
    let firsts: Vec<u64> = (0..=members).map(share_of).collect();
    let place = |first: u64| first.saturating_sub(before).min(own.len() as u64) as usize;
    let parts = firsts.windows(2).map(|pair| &own[place(pair[0])..place(pair[1])]);
    let parts = parts.map(|part| bytes_of(part.iter().copied())).collect();
    drop(own);
    let parts = team.exchange(parts)?;
    let mut records: Vec<Record> =
        Vec::with_capacity(parts.iter().map(Vec::len).sum::<usize>() / 32);
    for (from, bytes) in WorkerId::below(team.size()).zip(&parts) {
        records.extend(values_of::<Record>(from, bytes)?);
    }
    let me = team.me().index();
    if records.len() as u64 != firsts[me + 1] - firsts[me] {
        return Err(refused(team.me(), [0, 0], "not as many points as are its share").into());
    }
    Ok((firsts, records))
}

impl Ordered {
    /// Vertices of the whole mesh.
    pub fn vertices(&self) -> u32 {
        self.firsts[self.firsts.len() - 1] as u32
    }

    /// Vertices before the own stretch.
    pub fn before(&self, me: WorkerId) -> u32 {
        self.firsts[me.index()] as u32
    }

    /// Four affinely independent points of all stretches, or as many as there are: the same at all
    /// members.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed.
    pub fn independent(&self, team: &mut Team) -> Result<Vec<Placed>, TeamError> {
        let mut found: Vec<Placed> = Vec::new();
        while found.len() < 4 {
            let points: Vec<Point> = found.iter().map(|&(_, p)| p).collect();
            let own = self.points.iter().position(|p| is_independent(&points, p));
            let own: Option<Placed> =
                own.map(|k| (self.before(team.me()) + k as u32, self.points[k]));
            let all: Vec<Option<Placed>> = team.gather_all(&own)?;
            let first = WorkerId::below(team.size()).zip(all);
            match first.into_iter().find_map(|(from, own)| Some((from, own?))) {
                Some((from, (k, p))) => {
                    if k >= self.vertices() || p.iter().any(|c| !c.is_finite()) {
                        return Err(refused(from, [0, 0], "no vertex").into());
                    }
                    found.push((k, p));
                }
                None => break,
            }
        }
        Ok(found)
    }

    /// The vertices with these numbers along the curve: all members get all of them.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed, or has sent what makes no sense.
    pub fn of_all(
        &self,
        team: &mut Team,
        numbers: impl Iterator<Item = u32>,
    ) -> Result<Vec<Placed>, TeamError> {
        let before = self.before(team.me());
        let own: Vec<Record> = numbers
            .filter_map(|number| {
                let p = self.points.get(number.checked_sub(before)? as usize)?;
                let [x, y, z] = p.map(f64::to_bits);
                Some([x, y, z, u64::from(number)])
            })
            .collect();
        let all = team.gather(bytes_of(own.into_iter()))?.unwrap_or_default().concat();
        let all = team.tell(all)?;
        let first = WorkerId::default();
        let mut placed = Vec::with_capacity(all.len() / 32);
        for (k, [x, y, z, number]) in values_of::<Record>(first, &all)?.enumerate() {
            let p = [x, y, z].map(f64::from_bits);
            if number >= u64::from(self.vertices()) || p.iter().any(|c| !c.is_finite()) {
                return Err(refused(first, [32 * k, all.len()], "no vertex").into());
            }
            placed.push((number as u32, p));
        }
        Ok(placed)
    }
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::*;
    use crate::team::threads;
    use ltbw_exact::PointSet;
    use ltbw_generate::{PointKind, generate};
    use std::collections::BTreeMap;

    /// The stretches of a team whose members have slices that end at these places.
    fn stretches(points: &[Point], ends: &[usize]) -> Vec<Ordered> {
        std::thread::scope(|scope| {
            let run = |(k, post)| {
                let start = if k == 0 { 0 } else { ends[k - 1] };
                let own = points[start..ends[k]].to_vec();
                scope.spawn(move || {
                    let mut team = Team::new(post);
                    let slice = Slice::new(&mut team, own).expect("finite points");
                    assert_eq!(slice.first() as usize, start);
                    order(&mut team, &slice).expect("an order")
                })
            };
            let members = threads(ends.len() as u32).into_iter().enumerate();
            let all: Vec<_> = members.map(run).collect();
            all.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        })
    }

    fn check(name: &str, points: &[Point], ends: &[usize]) {
        let all = stretches(points, ends);
        // By place: the least number there.
        let set = PointSet::new(points.to_vec()).expect("finite points");
        let mut kept: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        let mut expected = Vec::new();
        for (p, number) in set.points().iter().zip(0..) {
            let kept = *kept.entry(ascending(p)).or_insert(number);
            if kept != number {
                expected.push(Duplicate { number, kept });
            }
        }
        let mut duplicates: Vec<Duplicate> =
            all.iter().flat_map(|own| own.duplicates.clone()).collect();
        duplicates.sort_unstable();
        assert_eq!(duplicates, expected, "{name} {ends:?}");
        let vertices = kept.len();
        let mut numbers = Vec::new();
        for (k, own) in all.iter().enumerate() {
            let share = [k, k + 1].map(|k| (k * vertices / ends.len()) as u64);
            assert_eq!([own.firsts[k], own.firsts[k + 1]], share, "{name} {ends:?}");
            assert_eq!(own.vertices() as usize, vertices);
            assert_eq!(own.points.len() as u64, share[1] - share[0], "{name} {ends:?}");
            assert_eq!(own.extent, Extent::of(&set.kernel_points(), set.mode()), "{name}");
            for (p, &number) in own.points.iter().zip(&own.numbers) {
                assert_eq!(set.kernel_point(number as usize), Some(*p), "{name} {ends:?}");
            }
            numbers.extend(own.numbers.iter().copied());
        }
        numbers.sort_unstable();
        let mut expected: Vec<u32> = kept.into_values().collect();
        expected.sort_unstable();
        assert_eq!(numbers, expected, "{name} {ends:?}");
    }

    #[test]
    fn each_member_has_its_share_of_the_different_points() {
        let uniform = generate(PointKind::Uniform, 400, 7);
        let far = [[-1e9; 3], [1e9; 3]];
        let cases = [
            ("uniform", uniform.clone()),
            ("backwards", uniform.iter().rev().chain(&uniform).copied().collect()),
            ("one cell", far.iter().copied().chain(uniform.iter().copied()).collect()),
            ("one place", vec![[0.5, 1.0, -0.0]; 90]),
            ("two places", [[[1.0; 3]; 40], [[-0.0; 3]; 40], [[1.0; 3]; 40]].concat()),
            ("mostly one", [vec![[0.25; 3]; 300], uniform[..20].to_vec()].concat()),
            ("tiny", uniform.iter().map(|p| p.map(|c| c * 1e-280)).collect()),
            ("wide", uniform.iter().map(|p| [p[0] * 1e-290, p[1] * 1e290, p[2]]).collect()),
            ("few", uniform[..3].to_vec()),
            ("none", Vec::new()),
        ];
        for (name, points) in cases {
            let n = points.len();
            check(name, &points, &[n]);
            check(name, &points, &[n / 2, n]);
            check(name, &points, &[n / 3, n / 3, n]);
            check(name, &points, &[0, 0, n, n, n]);
            check(name, &points, &[n / 7, n / 7, n / 2, n / 2 + n / 5, n, n, n]);
            check(name, &points, &(1..=8).map(|k| k * n / 8).collect::<Vec<_>>());
        }
    }
}
