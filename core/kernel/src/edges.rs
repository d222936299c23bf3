//! The joiner of faces: where two faces of a closed surface have an edge in common.

use crate::topology::FaceId;

/// The faces of a closed surface by their edges: every edge is passed by two faces, in opposite
/// directions.
///
/// A hash table with linear probing, at most half full, so that probing ends.
///
/// ```
/// use ltbw_core::edges::{EdgeTable, Met};
/// use ltbw_core::topology::{FaceId, TetId};
/// let [a, b] = [FaceId::new(TetId::new(7), 3), FaceId::new(TetId::new(8), 1)];
/// let mut edges = EdgeTable::default();
/// edges.start(2);
/// assert_eq!(edges.meet(5, 6, a), Met::Nothing);
/// assert_eq!(edges.meet(6, 5, b), Met::Face(a));
/// assert_eq!(edges.meet(5, 6, a), Met::Defect, "a third face");
/// ```
#[derive(Clone, Debug, Default)]
pub struct EdgeTable {
    entries: Vec<Entry>,
    shift: u32,
}

/// The face that another one meets at one of its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    /// It is the first face there.
    Nothing,
    /// The first face, which passes the edge in the opposite direction.
    Face(FaceId),
    /// The surface is none: a third face, or one in the same direction.
    Defect,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Both vertices, the smaller one first; [`EMPTY`] where no edge is.
    key: u64,
    face: FaceId,
    /// Where the first face comes from; [`CLOSED`] once the second is there.
    from: u32,
}

const EMPTY: u64 = u64::MAX;
const CLOSED: u32 = u32::MAX;

impl EdgeTable {
    /// Forgets all, and makes room for a surface of this number of triangles.
    pub fn start(&mut self, triangles: usize) {
        // Each triangle has three edges, each edge two triangles; two places, so that `shift` is
        // below 64.
        let size = (3 * triangles).next_power_of_two().max(2);
        self.shift = 64 - size.trailing_zeros();
        self.entries.clear();
        self.entries.resize(size, Entry { key: EMPTY, face: FaceId::default(), from: CLOSED });
    }

    /// Takes up `face`, which passes an edge from one vertex to the other, neither of them
    /// `u32::MAX`.
    #[inline]
    pub fn meet(&mut self, from: u32, to: u32, face: FaceId) -> Met {
        let key = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
        let last = self.entries.len() - 1;
        let first = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> self.shift) as usize;
        // A surface with a hole has more edges than there is room for: the search has an end, too.
        for place in first..=first + last {
            let entry = &mut self.entries[place & last];
            if entry.key == EMPTY {
                *entry = Entry { key, face, from };
                return Met::Nothing;
            }
            if entry.key == key {
                let is_second = entry.from == to;
                entry.from = CLOSED;
                return if is_second { Met::Face(entry.face) } else { Met::Defect };
            }
        }
        Met::Defect
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::TetId;

    #[test]
    fn a_table_that_is_too_small_is_a_defect() {
        let mut edges = EdgeTable::default();
        edges.start(4);
        let met = (0..17).map(|k| edges.meet(k, k + 1, FaceId::default())).collect::<Vec<_>>();
        assert_eq!(met[..16], [Met::Nothing; 16]);
        assert_eq!(met[16], Met::Defect);
        edges.start(0);
        assert_eq!(edges.meet(1, 2, FaceId::new(TetId::new(3), 1)), Met::Nothing);
        assert_eq!(
            edges.meet(1, 2, FaceId::new(TetId::new(4), 1)),
            Met::Defect,
            "the same direction"
        );
    }
}
