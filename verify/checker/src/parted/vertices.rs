//! The vertices of all parts meet by their coordinates: those at one place are one, which is one of
//! the points that were given, under its number; then they have numbers by their coordinates, the
//! same in all parts.

use super::exchange::{
    Exchange, Record, before, bytes_of, cuts, deal, member_of, stretch, sums, values_of,
};
use super::found::{Corner, Found};
use crate::defect::Kind;
use crate::mesh::Point;
use crate::places::ascending;
use rayon::prelude::*;

/// A vertex or a given point: its place, as numbers that ascend as coordinates do, and its number
/// among all points.
type Place = ([u64; 3], u32);

impl Record for Place {
    const BYTES: usize = 28;

    fn put(&self, to: &mut Vec<u8>) {
        self.0.put(to);
        self.1.put(to);
    }

    fn get(bytes: &[u8]) -> Self {
        (Record::get(bytes), Record::get(&bytes[24..]))
    }
}

/// A finite point as such a place; `-0.0` is `0.0`.
fn key(p: &Point) -> [u64; 3] {
    p.map(ascending)
}

/// The coordinates of a place.
pub(crate) fn point(key: &[u64; 3]) -> Point {
    key.map(|c| f64::from_bits(if c >> 63 == 1 { c & !(1 << 63) } else { !c }))
}

/// The vertices of all parts, as far as this member has to do with them.
pub(crate) struct Vertices {
    /// By vertex of the part: its number by coordinates.
    pub(crate) numbers: Vec<u32>,
    /// The places of this member's stretch of all vertices, ascending.
    pub(crate) stretch: Vec<[u64; 3]>,
    /// Vertices of the whole mesh.
    pub(crate) count: u64,
    /// Points given to all members.
    pub(crate) given: u64,
    /// Places of points at which no vertex lies.
    pub(crate) left_out: u64,
}

/// The vertices of a part and the points that it was given.
#[derive(Clone, Copy)]
pub(crate) struct Own<'a> {
    pub(crate) points: &'a [Point],
    /// Their numbers among all points.
    pub(crate) numbers: &'a [u32],
    /// The vertices that sound tetrahedra use, all finite.
    pub(crate) used: &'a [u32],
    /// This member's stretch of all points, if the vertices are to be some of these.
    pub(crate) given: Option<&'a [Point]>,
}

/// Finds the vertices of all parts, and compares them with the points that were given.
pub(crate) fn meet<E: Exchange>(
    team: &mut E,
    own: Own<'_>,
    all_points: bool,
    found: &mut Found,
) -> Result<Vertices, E::Error> {
    let list = own.given.unwrap_or_default();
    let [first, given_points] = before(team, list.len() as u64)?;
    let place = |v: &u32| (key(&own.points[*v as usize]), own.numbers[*v as usize]);
    let mut sorted: Vec<(Place, u32)> = own.used.par_iter().map(|v| (place(v), *v)).collect();
    sorted.par_sort_unstable();
    let places: Vec<Place> = sorted.iter().map(|&(place, _)| place).collect();
    let mut given: Vec<Place> = (list.iter().zip(first..))
        .filter(|(p, _)| p.iter().all(|c| c.is_finite()))
        .map(|(p, number)| (key(p), number as u32))
        .collect();
    given.par_sort_unstable();

    // By place alone: what lies at one comes to one member.
    let keyed = if own.given.is_some() { &given } else { &places };
    let keys: Vec<[u64; 3]> = keyed.iter().map(|&(key, _)| key).collect();
    let cuts = cuts(team, &keys)?;
    drop(keys);
    let used = send(team, &places, &cuts)?;
    drop(places);
    let given = send(team, &given, &cuts)?;

    let mut all: Vec<Place> = used.concat();
    all.par_sort_unstable();
    all.dedup();
    let mut points: Vec<Place> = given.into_iter().flatten().collect();
    points.par_sort_unstable();
    let left_out = match own.given {
        Some(_) => compare(&all, &points, all_points, found),
        None => agree(&all, found),
    };
    drop(points);
    let mut places: Vec<[u64; 3]> = all.into_iter().map(|(key, _)| key).collect();
    places.dedup();
    let [before, count] = before(team, places.len() as u64)?;
    let [left_out] = sums(team, [left_out])?;

    let number = |(key, _): &Place| {
        before.saturating_add(places.partition_point(|other| other < key) as u64) as u32
    };
    let answers: Vec<Vec<u8>> = (used.par_iter())
        .map(|places| bytes_of(&places.iter().map(number).collect::<Vec<u32>>()))
        .collect();
    drop(used);
    let mut numbers = vec![u32::MAX; own.points.len()];
    let mut told = sorted.iter();
    for (from, bytes) in team.exchange(answers)?.iter().enumerate() {
        for number in values_of::<E, u32>(team, from, bytes)? {
            match told.next() {
                Some(&(_, v)) if u64::from(number) < count => numbers[v as usize] = number,
                _ => return Err(team.nonsense(from, "a number of no vertex")),
            }
        }
    }
    match told.next() {
        None => Ok(Vertices { numbers, stretch: places, count, given: given_points, left_out }),
        Some(_) => Err(team.nonsense(team.members() - 1, "fewer numbers than vertices")),
    }
}

/// Sends sorted places to those in whose stretches they lie; what has come, by sender.
fn send<E: Exchange>(
    team: &mut E,
    places: &[Place],
    cuts: &[[u64; 3]],
) -> Result<Vec<Vec<Place>>, E::Error> {
    let mut parts = vec![Vec::new(); team.members()];
    for run in places.chunk_by(|a, b| stretch(cuts, &a.0) == stretch(cuts, &b.0)) {
        parts[stretch(cuts, &run[0].0)] = bytes_of(run);
    }
    let all = team.exchange(parts)?;
    all.iter().enumerate().map(|(from, bytes)| values_of(team, from, bytes)).collect()
}

/// Looks for vertices at one place under several numbers; no place is left out.
fn agree(vertices: &[Place], found: &mut Found) -> u64 {
    let corner = |&(key, number): &Place| Corner { number, at: point(&key) };
    for group in vertices.chunk_by(|a, b| a.0 == b.0) {
        for other in &group[1..] {
            found.add(Kind::EqualVertices, &[], &[corner(&group[0]), corner(other)]);
        }
    }
    0
}

/// Lets the numbers of vertices meet, of which each has to be that of one place.
pub(crate) fn meet_by_number<E: Exchange>(
    team: &mut E,
    own: &Own<'_>,
    by_place: &[u32],
    found: &mut Found,
) -> Result<(), E::Error> {
    let members = team.members();
    let numbered = own.used.iter().map(|&v| {
        let place = by_place[v as usize];
        Numbered { number: own.numbers[v as usize], place, at: own.points[v as usize] }
    });
    let all = deal(team, numbered, |own| member_of(&[own.number], members))?;
    let mut all: Vec<Numbered> = all.into_iter().flatten().collect();
    all.sort_unstable_by_key(|own| (own.number, own.place));
    all.dedup_by_key(|own| (own.number, own.place));
    for pair in all.windows(2).filter(|pair| pair[0].number == pair[1].number) {
        let [one, other] = [pair[0], pair[1]].map(|own| Corner { number: own.number, at: own.at });
        found.add(Kind::IndexOutOfRange, &[], &[one, other]);
    }
    Ok(())
}

/// A vertex with its number, and its number by coordinates.
#[derive(Clone, Copy)]
struct Numbered {
    number: u32,
    place: u32,
    at: Point,
}

impl Record for Numbered {
    const BYTES: usize = 32;

    fn put(&self, to: &mut Vec<u8>) {
        [self.number, self.place].put(to);
        self.at.put(to);
    }

    fn get(bytes: &[u8]) -> Self {
        let [number, place] = Record::get(bytes);
        Self { number, place, at: Record::get(&bytes[8..]) }
    }

    fn is_sound(&self) -> bool {
        self.at.iter().all(|c| c.is_finite())
    }
}

/// Compares the vertices of a stretch with the points there, both ascending: the number of places
/// that no vertex has.
fn compare(vertices: &[Place], points: &[Place], all_points: bool, found: &mut Found) -> u64 {
    let corner = |&(key, number): &Place| Corner { number, at: point(&key) };
    let mut vertices = vertices.chunk_by(|a, b| a.0 == b.0).peekable();
    let mut left_out = 0;
    let foreign = |vertex: &Place, found: &mut Found| {
        found.add(Kind::IndexOutOfRange, &[], &[corner(vertex)]);
    };
    for given in points.chunk_by(|a, b| a.0 == b.0) {
        while let Some(group) = vertices.next_if(|group| group[0].0 < given[0].0) {
            group.iter().for_each(|vertex| foreign(vertex, found));
        }
        let Some(group) = vertices.next_if(|group| group[0].0 == given[0].0) else {
            left_out += 1;
            if all_points {
                found.add(Kind::PointLeftOut, &[], &[corner(&given[0])]);
            }
            continue;
        };
        let is_given = |vertex: &&Place| given.binary_search(vertex).is_err();
        group.iter().filter(is_given).for_each(|vertex| foreign(vertex, found));
        for other in &group[1..] {
            found.add(Kind::EqualVertices, &[], &[corner(&group[0]), corner(other)]);
        }
    }
    vertices.flatten().for_each(|vertex| foreign(vertex, found));
    left_out
}
