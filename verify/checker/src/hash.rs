//! The canonical mesh hash `ltbw.mesh/1`, computed from its definition.
//!
//! The vertices used by at least one tetrahedron, with `-0.0` as `0.0`, sorted by (x, y, z) and
//! numbered from 0; each tetrahedron as its four numbers ascending; tetrahedra sorted
//! lexicographically. SHA-256 over the bytes `ltbw.mesh/1\n`, the number of vertices as u64, the
//! coordinates as f64, the number of tetrahedra as u64, the numbers as u32; all little-endian.

use crate::mesh::Point;
use crate::perturb::order;
use crate::places;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// Why a mesh has no canonical hash.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HashError {
    /// A tetrahedron names a point that does not exist.
    #[error("tetrahedron {tet} names the point {vertex}, but there are {points} points")]
    IndexOutOfRange {
        /// The tetrahedron.
        tet: usize,
        /// The index that it names.
        vertex: u32,
        /// Number of points.
        points: usize,
    },
    /// A used point is not finite.
    #[error("the used point {vertex} is not finite")]
    NotFinite {
        /// The point.
        vertex: u32,
    },
    /// Two used points lie at the same place, so that the order of vertices is not defined.
    #[error("the used points {first} and {second} lie at the same place")]
    EqualVertices {
        /// The smaller index.
        first: u32,
        /// The larger index.
        second: u32,
    },
}

/// The canonical hash of a mesh as 64 lower-case hexadecimal digits.
///
/// Cost: O(V log V + T) time for usual meshes on the current rayon pool, 16 bytes of memory per
/// tetrahedron and some 30 per point.
pub fn canonical_hash(points: &[Point], tets: &[[u32; 4]]) -> Result<String, HashError> {
    let mut used = vec![false; points.len()];
    for (tet, vertices) in tets.iter().enumerate() {
        for &vertex in vertices {
            let slot = used.get_mut(vertex as usize);
            *slot.ok_or(HashError::IndexOutOfRange { tet, vertex, points: points.len() })? = true;
        }
    }
    let finite = |p: &Point| p.iter().all(|c| c.is_finite());
    for (vertex, point) in (0u32..).zip(points) {
        if used[vertex as usize] && !finite(point) {
            return Err(HashError::NotFinite { vertex });
        }
    }
    let mut vertices = places::sorted(points);
    vertices.retain(|&v| used[v as usize]);
    let at = |v: u32| &points[v as usize];
    for pair in vertices.windows(2) {
        if order(at(pair[0]), at(pair[1])).is_eq() {
            return Err(HashError::EqualVertices { first: pair[0], second: pair[1] });
        }
    }
    Ok(of_sorted(points, tets, &vertices))
}

/// The hash of a mesh whose used points, all finite and at different places, are `vertices` in
/// the order by (x, y, z).
pub(crate) fn of_sorted(points: &[Point], tets: &[[u32; 4]], vertices: &[u32]) -> String {
    let mut number = vec![0u32; points.len()];
    for (n, &v) in (0u32..).zip(vertices) {
        number[v as usize] = n;
    }
    let coordinates = || {
        let mut sha = Sha256::new();
        let mut bytes = Vec::with_capacity(1 << 16);
        sha.update(b"ltbw.mesh/1\n");
        sha.update((vertices.len() as u64).to_le_bytes());
        for block in vertices.chunks(1 << 11) {
            bytes.clear();
            for &c in block.iter().flat_map(|&v| &points[v as usize]) {
                let c = if c == 0.0 { 0.0 } else { c };
                bytes.extend_from_slice(&c.to_le_bytes());
            }
            sha.update(&bytes);
        }
        sha.update((tets.len() as u64).to_le_bytes());
        sha
    };
    let (mut sha, rows) = rayon::join(coordinates, || Rows::new(tets, &number, vertices.len()));
    // While one wave of buckets goes through the hash, which is sequential, the next is sorted.
    let mut wave = rows.sorted(0);
    while !wave.is_empty() {
        let first = wave[0].0 + wave.len();
        let feed = || wave.iter().for_each(|(_, bytes)| sha.update(bytes));
        let ((), next) = rayon::join(feed, || rows.sorted(first));
        wave = next;
    }
    let mut text = String::with_capacity(64);
    for byte in sha.finalize() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
    }
    text
}

/// The rows of the hash, put into buckets by their first numbers.
///
/// Every piece of the list of tetrahedra is put in order of buckets by itself, so that threads
/// share nothing; a bucket is put together from the pieces when it is sorted.
struct Rows {
    pieces: Vec<Piece>,
    buckets: usize,
}

/// A part of the rows in order of their buckets; bucket `b` is `rows[starts[b]..starts[b + 1]]`.
struct Piece {
    rows: Vec<Row>,
    starts: Vec<u32>,
}

/// The four numbers of a tetrahedron, ascending.
type Row = [u32; 4];

/// Rows in a piece: some megabytes, so that putting them in order stays in the cache.
const PIECE: usize = 1 << 18;
/// The most buckets: a piece has some hundred rows in each.
const BUCKETS: usize = 1 << 11;
/// Buckets that are sorted while as many others are hashed.
const WAVE: usize = 32;

impl Rows {
    /// The rows of `tets`, whose vertices have numbers below `count`.
    fn new(tets: &[[u32; 4]], number: &[u32], count: usize) -> Self {
        let shift = (0..32).find(|s| count >> s < BUCKETS).unwrap_or(31);
        let buckets = (count >> shift) + 1;
        let pieces = tets
            .par_chunks(PIECE)
            .map(|tets| {
                let rows: Vec<Row> = tets.iter().map(|tet| row(tet, number)).collect();
                Piece::new(&rows, shift, buckets)
            })
            .collect();
        Self { pieces, buckets }
    }

    /// The bytes of the buckets of the wave that starts with `first`, with their numbers.
    fn sorted(&self, first: usize) -> Vec<(usize, Vec<u8>)> {
        let wave = first..self.buckets.min(first + WAVE);
        wave.into_par_iter().map(|bucket| (bucket, self.bytes(bucket))).collect()
    }

    fn bytes(&self, bucket: usize) -> Vec<u8> {
        let mut rows: Vec<u128> =
            self.pieces.iter().flat_map(|piece| piece.bucket(bucket)).map(packed).collect();
        rows.sort_unstable();
        let mut bytes = Vec::with_capacity(16 * rows.len());
        for row in rows {
            let mut four = [0; 16];
            for (place, shift) in four.chunks_exact_mut(4).zip([96, 64, 32, 0]) {
                place.copy_from_slice(&((row >> shift) as u32).to_le_bytes());
            }
            bytes.extend_from_slice(&four);
        }
        bytes
    }
}

impl Piece {
    /// A counting sort of `rows` by `row[0] >> shift`.
    fn new(rows: &[Row], shift: u32, buckets: usize) -> Self {
        let mut starts = vec![0u32; buckets + 2];
        rows.iter().for_each(|row| starts[(row[0] >> shift) as usize + 2] += 1);
        (2..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        let mut ordered = vec![[0; 4]; rows.len()];
        for &row in rows {
            let slot = &mut starts[(row[0] >> shift) as usize + 1];
            ordered[*slot as usize] = row;
            *slot += 1;
        }
        Self { rows: ordered, starts }
    }

    fn bucket(&self, bucket: usize) -> &[Row] {
        &self.rows[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
    }
}

/// The four numbers of a tetrahedron, ascending.
fn row(tet: &[u32; 4], number: &[u32]) -> Row {
    // A sorting network: no branch.
    let sort = |a: u32, b: u32| (a.min(b), a.max(b));
    let [a, b, c, d] = tet.map(|v| number[v as usize]);
    let ((a, b), (c, d)) = (sort(a, b), sort(c, d));
    let ((a, c), (b, d)) = (sort(a, c), sort(b, d));
    let (b, c) = sort(b, c);
    [a, b, c, d]
}

/// A row in one number that sorts as rows do.
fn packed(row: &Row) -> u128 {
    row.iter().fold(0, |packed, &n| packed << 32 | u128::from(n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TET: [Point; 4] = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];

    /// SHA-256 from FIPS 180-4, for messages of any length: a second implementation.
    fn sha256(message: &[u8]) -> String {
        let primes: Vec<u64> = (2..312).filter(|n| (2..*n).all(|d| n % d != 0)).collect();
        // The first 32 bits of the fractional parts of roots, by integer root finding.
        let root = |p: u64, power: u32| -> u32 {
            let target = u128::from(p) << (32 * power);
            let (mut low, mut high) = (0u128, 1u128 << 40);
            while high - low > 1 {
                let middle = (low + high) / 2;
                let above = middle.pow(power) > target;
                if above { high = middle } else { low = middle }
            }
            low as u32
        };
        let k: Vec<u32> = primes.iter().take(64).map(|&p| root(p, 3)).collect();
        let mut h: Vec<u32> = primes.iter().take(8).map(|&p| root(p, 2)).collect();
        let mut bytes = message.to_vec();
        bytes.push(0x80);
        while bytes.len() % 64 != 56 {
            bytes.push(0);
        }
        bytes.extend((8 * message.len() as u64).to_be_bytes());
        for block in bytes.chunks(64) {
            let mut w: Vec<u32> =
                block.chunks(4).map(|c| u32::from_be_bytes(c.try_into().unwrap())).collect();
            for t in 16..64 {
                let (x, y) = (w[t - 15], w[t - 2]);
                let s0 = x.rotate_right(7) ^ x.rotate_right(18) ^ (x >> 3);
                let s1 = y.rotate_right(17) ^ y.rotate_right(19) ^ (y >> 10);
                w.push(w[t - 16].wrapping_add(s0).wrapping_add(w[t - 7]).wrapping_add(s1));
            }
            let mut s = h.clone();
            for t in 0..64 {
                let e = s[4].rotate_right(6) ^ s[4].rotate_right(11) ^ s[4].rotate_right(25);
                let choice = (s[4] & s[5]) ^ (!s[4] & s[6]);
                let t1 = [e, choice, k[t], w[t]].iter().fold(s[7], |a, &b| a.wrapping_add(b));
                let a = s[0].rotate_right(2) ^ s[0].rotate_right(13) ^ s[0].rotate_right(22);
                let t2 = a.wrapping_add((s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]));
                s.rotate_right(1);
                s[4] = s[4].wrapping_add(t1);
                s[0] = t1.wrapping_add(t2);
            }
            h.iter_mut().zip(s).for_each(|(h, s)| *h = h.wrapping_add(s));
        }
        h.iter().map(|h| format!("{h:08x}")).collect()
    }

    #[test]
    fn the_second_sha256_is_right() {
        // FIPS 180-4, example of one block.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), abc);
    }

    #[test]
    fn the_empty_mesh_has_the_hash_of_its_bytes() {
        let mut bytes = b"ltbw.mesh/1\n".to_vec();
        bytes.extend([0; 16]);
        assert_eq!(canonical_hash(&[], &[]).unwrap(), sha256(&bytes));
    }

    #[test]
    fn one_tetrahedron_has_the_hash_of_its_bytes() {
        let mut bytes = b"ltbw.mesh/1\n".to_vec();
        bytes.extend(4u64.to_le_bytes());
        TET.iter().flatten().for_each(|c| bytes.extend(c.to_le_bytes()));
        bytes.extend(1u64.to_le_bytes());
        (0u32..4).for_each(|n| bytes.extend(n.to_le_bytes()));
        let expected = sha256(&bytes);
        assert_eq!(canonical_hash(&TET, &[[0, 1, 2, 3]]).unwrap(), expected);
        // Numbering, order of vertices, unused points and the sign of zero do not matter.
        let other = [TET[3], [9.0; 3], TET[1], [-0.0, 0.0, -0.0], TET[2]];
        assert_eq!(canonical_hash(&other, &[[4, 0, 2, 3]]).unwrap(), expected);
    }

    #[test]
    fn meshes_without_a_hash_say_why() {
        let out = HashError::IndexOutOfRange { tet: 0, vertex: 7, points: 4 };
        assert_eq!(canonical_hash(&TET, &[[0, 1, 2, 7]]), Err(out));
        let mut points = TET;
        points[2] = [0.0, f64::NAN, 0.0];
        assert_eq!(
            canonical_hash(&points, &[[0, 1, 2, 3]]),
            Err(HashError::NotFinite { vertex: 2 })
        );
        points[2] = [-0.0, 0.0, 1.0];
        let equal = HashError::EqualVertices { first: 1, second: 2 };
        assert_eq!(canonical_hash(&points, &[[0, 1, 2, 3]]), Err(equal));
    }

    proptest! {
        #[test]
        fn the_second_sha256_agrees(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let ours: String = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
            prop_assert_eq!(ours, sha256(&bytes));
        }
    }
}
