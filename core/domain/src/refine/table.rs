//! Hash tables with one fixed hash function, so that runs repeat exactly on every machine.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};

/// A map from small integer keys.
pub(crate) type Map<K, V> = HashMap<K, V, BuildHasherDefault<Mixer>>;
/// A set of small integer keys.
pub(crate) type Set<K> = HashSet<K, BuildHasherDefault<Mixer>>;

/// Multiplies and rotates: keys are tuples of vertex numbers, chosen by us and not by an attacker.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mixer(u64);

impl Mixer {
    fn mix(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

impl Hasher for Mixer {
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.mix(u64::from_le_bytes(word));
        }
    }

    fn write_u32(&mut self, word: u32) {
        self.mix(word.into());
    }

    fn write_u64(&mut self, word: u64) {
        self.mix(word);
    }

    fn write_i64(&mut self, word: i64) {
        self.mix(word as u64);
    }

    fn write_usize(&mut self, word: usize) {
        self.mix(word as u64);
    }

    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 29
    }
}

/// An edge as a key: its ends, ascending.
pub(crate) fn edge<V: Ord>(a: V, b: V) -> [V; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// A triangle as a key: its corners, ascending.
pub(crate) fn triangle<V: Ord>(a: V, b: V, c: V) -> [V; 3] {
    let [a, b] = edge(a, b);
    let [b, c] = edge(b, c);
    let [a, b] = edge(a, b);
    [a, b, c]
}

/// The edges of a triangle, each with the corner opposite.
pub(crate) fn sides<V: Copy + Ord>([a, b, c]: [V; 3]) -> [([V; 2], V); 3] {
    [(edge(a, b), c), (edge(b, c), a), (edge(a, c), b)]
}
