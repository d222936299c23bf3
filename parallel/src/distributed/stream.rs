//! The bytes of `ltbw.mesh/1` on their way through the hash, piece by piece, in one process after
//! the other. The kernel's `canonical_hash` says which bytes these are.

use super::records::Record;
use ltbw_core::MeshHash;
use ltbw_exact::Point;
use sha2::digest::common::hazmat::{SerializableState, SerializedState};
use sha2::{Digest, Sha256};

/// Bytes that go through the hash together.
const BLOCK: usize = 1 << 16;

/// A hash that is not at its end, in the order of its methods.
#[derive(Clone, Debug)]
pub(super) struct HashStream(Sha256);

impl HashStream {
    /// Begins with the number of vertices.
    pub(super) fn new(vertices: u64) -> Self {
        Self(Sha256::new_with_prefix(b"ltbw.mesh/1\n").chain_update(vertices.to_le_bytes()))
    }

    /// The coordinates of the next vertices, which ascend.
    pub(super) fn coordinates(&mut self, points: impl Iterator<Item = Point>) {
        let mut block = Vec::with_capacity(BLOCK);
        for p in points {
            block.extend(p.into_iter().flat_map(f64::to_le_bytes));
            if block.len() + 24 > BLOCK {
                self.0.update(&block);
                block.clear();
            }
        }
        self.0.update(&block);
    }

    /// After all vertices: the number of tetrahedra.
    pub(super) fn tets(&mut self, count: u64) {
        self.0.update(count.to_le_bytes());
    }

    /// The next tetrahedra, which ascend, by the numbers of their vertices, ascending: the first
    /// one in the highest bits.
    pub(super) fn rows(&mut self, rows: &[u128]) {
        let mut block = Vec::with_capacity(BLOCK);
        for chunk in rows.chunks(BLOCK / 16) {
            block.clear();
            for row in chunk {
                [96, 64, 32, 0].map(|low| (row >> low) as u32).put(&mut block);
            }
            self.0.update(&block);
        }
    }

    /// All that went in so far, in some hundred bytes.
    pub(super) fn state(&self) -> Vec<u8> {
        self.0.serialize().to_vec()
    }

    /// The stream with this state; `None` if it is none.
    pub(super) fn of_state(state: &[u8]) -> Option<Self> {
        let state = SerializedState::<Sha256>::try_from(state).ok()?;
        Sha256::deserialize(&state).ok().map(Self)
    }

    /// The hash, after all tetrahedra.
    pub(super) fn finish(self) -> MeshHash {
        MeshHash(self.0.finalize().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_core::canonical_hash;

    #[test]
    fn a_stream_that_moves_has_the_hash() {
        let points: Vec<Point> = (0..70).map(|k| [f64::from(k), 0.5, 1.0]).collect();
        let tets: Vec<[u32; 4]> = (0..67).map(|k| [k, k + 1, k + 2, k + 3]).collect();
        let row = |tet: &[u32; 4]| tet.iter().fold(0, |all, &v| all << 32 | u128::from(v));
        let rows: Vec<u128> = tets.iter().map(row).collect();
        let expected = canonical_hash(&points, &tets).unwrap();
        let moved = |stream: &HashStream| HashStream::of_state(&stream.state()).unwrap();
        // Where a block of the hash ends, before, and after.
        for cut in [0, 1, 3, 5, 8, 33, 67] {
            let mut stream = HashStream::new(70);
            stream.coordinates(points[..cut].iter().copied());
            stream = moved(&stream);
            stream.coordinates(points[cut..].iter().copied());
            stream.tets(67);
            stream.rows(&rows[..cut]);
            stream = moved(&stream);
            stream.rows(&rows[cut..]);
            assert_eq!(stream.finish(), expected, "cut at {cut}");
        }
        let state = HashStream::new(1).state();
        assert!(HashStream::of_state(&state[1..]).is_none());
        assert!(HashStream::of_state(&vec![0xff; state.len()]).is_none());
    }
}
