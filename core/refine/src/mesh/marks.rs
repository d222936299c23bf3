//! Per tetrahedron: which of its faces are subfaces, which of its edges subsegments, and the
//! region that it lies in.
//!
//! One word: bit i for the face opposite vertex i; bits 4 to 9 for the edges 01, 02, 03, 12, 13,
//! 23; the region above. A new tetrahedron (p, wall) inherits from the tetrahedron of the cavity
//! behind its wall: the wall's own face and three edges, and the region, because the two lie on the
//! same side of the wall.

use crate::sync::Words;
use ltbw_core::cavity::OTHERS;
use ltbw_core::mesh::Mesh;
use ltbw_core::topology::{FaceId, TetId, slot_of, tet_of};

/// A word of marks.
pub(crate) type Word = u32;

/// The bits of faces, and those of edges.
pub(crate) const FACES: Word = 0xf;
/// See [`FACES`].
pub(crate) const EDGES: Word = 0x3f << 4;
const REGION_SHIFT: u32 = 10;

/// The largest number of a region.
pub(crate) const MAX_REGION: u32 = u32::MAX >> REGION_SHIFT;

/// Dust of a patch, which belongs to the outer side when that is known.
pub(crate) const DUST: u32 = MAX_REGION - 1;

/// The slots of edge k.
pub(crate) const ENDS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The bit of the face opposite `slot`.
pub(crate) fn face_bit(slot: usize) -> Word {
    1 << slot
}

/// The bit of the edge between two slots.
pub(crate) const fn edge_bit(i: usize, j: usize) -> Word {
    let (i, j) = if i < j { (i, j) } else { (j, i) };
    // 01, 02, 03 are 0 to 2; 12, 13 are 3 and 4; 23 is 5.
    let k = [0, 2, 3][i] + j - 1;
    1 << (4 + k)
}

/// The region of a word.
pub(crate) fn region_of(word: Word) -> u32 {
    word >> REGION_SHIFT
}

/// The word that the tetrahedron behind face `slot` leaves to the new one on that face.
#[inline(always)]
fn inherit(word: Word, slot: usize) -> Word {
    let region = word & !(FACES | EDGES);
    if word & (FACES | EDGES) == 0 {
        return region;
    }
    let [a, b, c] = OTHERS[slot];
    let take = |from: Word, to: Word| if word & from != 0 { to } else { 0 };
    region
        | take(face_bit(slot), face_bit(0))
        | take(edge_bit(a, b), edge_bit(1, 2))
        | take(edge_bit(a, c), edge_bit(1, 3))
        | take(edge_bit(b, c), edge_bit(2, 3))
}

/// The words of all slots.
#[derive(Debug, Default)]
pub(crate) struct Marks {
    words: Words,
    /// Words of the walls of the open cavity.
    inherited: Vec<Word>,
}

impl Marks {
    /// No marks, for `slots` slots.
    pub(crate) fn new(slots: usize) -> Self {
        let mut own = Self::default();
        own.grow(slots);
        own
    }

    pub(crate) fn of(&self, t: TetId) -> Word {
        self.words.at(t)
    }

    /// Asks the processor to fetch the word of a slot. A hint.
    #[inline(always)]
    pub(crate) fn prefetch(&self, t: TetId) {
        self.words.prefetch(t);
    }

    /// Adds bits to those of a slot, which is the caller's.
    pub(crate) fn set(&self, t: TetId, bits: Word) {
        self.words.set(t, self.of(t) | bits);
    }

    pub(crate) fn clear(&mut self, t: TetId, bits: Word) {
        self.words.set(t, self.of(t) & !bits);
    }

    pub(crate) fn region(&self, t: TetId) -> u32 {
        region_of(self.of(t))
    }

    pub(crate) fn set_region(&mut self, t: TetId, region: u32) {
        self.words.set(t, self.of(t) & (FACES | EDGES) | region << REGION_SHIFT);
    }

    /// Writes the marks and the region of a slot, which is the caller's.
    pub(crate) fn enter(&self, t: TetId, region: u32, bits: Word) {
        self.words.set(t, bits | region << REGION_SHIFT);
    }

    /// Gives a slot the word that it had before.
    pub(crate) fn restore(&mut self, t: TetId, word: Word) {
        self.words.set(t, word);
    }

    /// Reads what the walls of the mesh's open cavity pass on.
    pub(crate) fn gather(&mut self, mesh: &Mesh) {
        let inner = |outer: FaceId| mesh.topology().at(tet_of(outer)).neighbours()[slot_of(outer)];
        let mut inherited = std::mem::take(&mut self.inherited);
        self.inherit(&mut inherited, mesh.cavity().boundary().map(|(_, outer)| inner(outer)));
        self.inherited = inherited;
    }

    /// Reads what walls, as seen from inside the cavity, pass on.
    #[inline(always)]
    pub(crate) fn inherit(&self, into: &mut Vec<Word>, walls: impl Iterator<Item = FaceId>) {
        into.clear();
        into.extend(walls.map(|wall| inherit(self.of(tet_of(wall)), slot_of(wall))));
    }

    /// Writes it to the star that filled the cavity.
    pub(crate) fn pass_on(&mut self, mesh: &Mesh) {
        self.grow(mesh.topology().slots());
        self.pass(&self.inherited, mesh.cavity().star().tets);
    }

    /// Writes words to the tetrahedra of a star, which are those of the caller.
    #[inline(always)]
    pub(crate) fn pass(&self, words: &[Word], star: &[TetId]) {
        star.iter().zip(words).for_each(|(&t, &word)| self.words.set(t, word));
    }

    /// Takes memory for this many slots. A hint.
    pub(crate) fn expect(&mut self, slots: usize) {
        self.words.expect(slots);
    }

    /// Makes room for `slots` slots.
    pub(crate) fn grow(&mut self, slots: usize) {
        self.words.grow(slots);
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.words.memory_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_and_their_bits_agree() {
        for (k, [i, j]) in ENDS.into_iter().enumerate() {
            assert_eq!(edge_bit(i, j), 1 << (4 + k));
            assert_eq!(edge_bit(j, i), 1 << (4 + k));
        }
    }

    #[test]
    fn a_wall_passes_on_its_own_marks_only() {
        for (slot, others) in OTHERS.into_iter().enumerate() {
            let own = [edge_bit(others[0], others[1]), edge_bit(others[0], others[2])];
            let word = face_bit(slot) | own[0] | own[1] | 5 << REGION_SHIFT;
            let passed = inherit(word, slot);
            assert_eq!(passed, face_bit(0) | edge_bit(1, 2) | edge_bit(1, 3) | 5 << REGION_SHIFT);
            // Everything at the vertex opposite the wall is lost.
            let lost = (0..4).filter(|&k| k != slot).fold(0, |w, k| w | edge_bit(slot, k));
            let faces = FACES & !face_bit(slot);
            assert_eq!(inherit(lost | faces, slot), 0);
        }
    }
}
