//! Which of the tetrahedra over their bounds come before all around them: the same for an engine
//! with one mesh and for workers with parts of one.
//!
//! Most are beaten round after round by the same one. It is remembered as a *witness*, and as long
//! as nothing on the way there has changed nothing is looked at.

use super::keys::Keys;
use ltbw_core::topology::TetId;

/// A tetrahedron over its bounds, or one that was.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Bad {
    /// Its slot.
    pub t: TetId,
    /// A tetrahedron that came before it at that look, after the neighbour on the way there, or `t`
    /// itself; `t` twice if none was found.
    pub witness: [TetId; 2],
    /// The look at new tetrahedra up to which all this is so.
    look: u32,
}

impl Bad {
    /// One that is new.
    pub fn new(t: TetId, look: u32) -> Self {
        Self { t, witness: [t; 2], look }
    }

    /// Is its tetrahedron there, if its slot was written last at the look `stamp`?
    pub fn is_there(&self, stamp: u32) -> bool {
        stamp <= self.look
    }
}

/// A mesh, or a part of one, whose tetrahedra over their bounds are sifted.
#[doc(hidden)]
pub trait Ranked {
    /// The slots around one.
    fn neighbours(&self, t: TetId) -> [TetId; 4];
    /// The slots around one beside a tetrahedron, which may be none here.
    fn around(&self, way: TetId) -> Option<[TetId; 4]>;
    /// Asks the processor to fetch a tetrahedron. A hint.
    fn prefetch(&self, t: TetId);
    /// Comes one of two tetrahedra with equal keys first?
    fn is_first_by_place(&self, one: TetId, other: TetId) -> bool;
    /// Do ties of the parts that keys hold count? Only a known-bad variant says no.
    #[inline(always)]
    fn breaks_ties(&self) -> bool {
        true
    }
}

/// Tetrahedra over their bounds whose entries are looked at together, before what they point at.
const BLOCK: usize = 32;

/// Moves those of some tetrahedra that are still there to the front, and tells those for which
/// there is no witness. Returns the number of those that are there.
#[inline]
pub(super) fn sift(
    bad: &mut [Bad],
    keys: &Keys,
    mesh: &impl Ranked,
    mut foremost: impl FnMut(TetId),
) -> usize {
    let mut kept = 0;
    let changed = |own: &Bad, t: TetId| u32::from(keys.stamp(t) > own.look);
    for first in (0..bad.len()).step_by(BLOCK) {
        let block = first..bad.len().min(first + BLOCK);
        // No branch waits for an entry: they are fetched side by side. 0: what came before it is
        // where it was; 1: it has to be looked for; 2 or 3: the tetrahedron is gone.
        let mut news = [0u32; BLOCK];
        for (own, new) in bad[block.clone()].iter().zip(&mut news) {
            let [way, other] = own.witness;
            let is_alone = u32::from(other == own.t);
            *new = changed(own, own.t) << 1 | changed(own, way) | changed(own, other) | is_alone;
        }
        let of = |new: u32| block.clone().zip(news).filter(move |own| own.1 == new);
        let fetch = |t: TetId| {
            mesh.prefetch(t);
            keys.prefetch(t);
        };
        of(1).for_each(|(k, _)| fetch(bad[k].t));
        of(1).for_each(|(k, _)| mesh.neighbours(bad[k].t).into_iter().for_each(fetch));
        for (k, new) in block.zip(news).filter(|own| own.1 <= 1) {
            let mut own = bad[k];
            if new == 1 {
                match keys.one_before(mesh, own.t) {
                    Some(witness) => own = Bad { witness, look: keys.look(), ..own },
                    None => foremost(own.t),
                }
            }
            bad[kept] = own;
            kept += 1;
        }
    }
    kept
}

/// The neighbour of `t` on the way, or `t`, and a tetrahedron that comes before `t`: one of its
/// neighbours, else one around one of these.
#[inline(always)]
pub(super) fn witness(
    t: TetId,
    neighbours: [TetId; 4],
    around: impl Fn(TetId) -> Option<[TetId; 4]>,
    is_before: impl Fn(&TetId) -> bool,
) -> Option<[TetId; 2]> {
    let beside = neighbours.into_iter().find(&is_before).map(|other| [t, other]);
    let beyond = |way: TetId| around(way)?.into_iter().find(&is_before).map(|other| [way, other]);
    beside.or_else(|| neighbours.into_iter().find_map(beyond))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    /// Tetrahedra in a row: 1 is on the way from 0 to 2, which comes before 0 if its key does.
    #[derive(Default)]
    struct Row {
        asked: RefCell<Vec<TetId>>,
    }

    impl Ranked for Row {
        fn neighbours(&self, t: TetId) -> [TetId; 4] {
            self.asked.borrow_mut().push(t);
            [[1, 1, 1, 1], [0, 2, 2, 2], [1, 1, 1, 1], [3, 3, 3, 3]][t.index()].map(TetId::new)
        }

        fn around(&self, way: TetId) -> Option<[TetId; 4]> {
            Some(self.neighbours(way))
        }

        fn prefetch(&self, _: TetId) {}

        fn is_first_by_place(&self, _: TetId, _: TetId) -> bool {
            false
        }
    }

    /// Keys with these stamps at look 7, of which tetrahedron 2 has the largest if it is a witness.
    fn keys(stamps: [u32; 4], has_witness: bool) -> Keys {
        let mut keys = Keys::default();
        keys.grow(4);
        keys.pass_looks(7);
        for (t, stamp) in (0..).map(TetId::new).zip(stamps) {
            let key = if has_witness && t == TetId::new(2) { 9 } else { 5 };
            keys.write(t, key, stamp);
        }
        keys
    }

    /// Sifts the entry of tetrahedron 0, which had its witness at look 5, at look 7. Returns
    /// whether it is there, whether it was looked at, and whether it is foremost.
    fn sifted(stamps: [u32; 4], has_witness: bool) -> [bool; 3] {
        let (row, keys) = (Row::default(), keys(stamps, has_witness));
        let witness = [1, 2].map(TetId::new);
        let mut bad = [Bad { t: TetId::new(0), witness, look: 5 }];
        let mut foremost = Vec::new();
        let kept = sift(&mut bad, &keys, &row, |t| foremost.push(t));
        let is_asked = !row.asked.borrow().is_empty();
        assert!(!is_asked || !has_witness || bad[0].look == 7, "what was found holds from now on");
        assert!(!is_asked || !has_witness || bad[0].witness == witness);
        [kept == 1, is_asked, !foremost.is_empty()]
    }

    #[test]
    fn a_witness_holds_until_something_on_the_way_there_changes() {
        assert_eq!(sifted([5, 5, 5, 7], false), [true, false, false]);
        // The tetrahedron on the way, and the witness itself.
        for stamps in [[5, 6, 5, 5], [5, 5, 6, 5], [5, 7, 7, 5]] {
            assert_eq!(sifted(stamps, false), [true, true, true], "{stamps:?}");
            assert_eq!(sifted(stamps, true), [true, true, false], "{stamps:?}");
        }
        for stamps in [[6, 5, 5, 5], [6, 6, 6, 5]] {
            assert_eq!(sifted(stamps, false), [false; 3], "{stamps:?}");
        }
    }

    #[test]
    fn one_without_a_witness_is_looked_at_every_time() {
        let row = Row::default();
        let mut bad = [Bad::new(TetId::new(3), 1)];
        for look in 2..4 {
            let mut keys = keys([1; 4], false);
            keys.pass_looks(look);
            let mut foremost = Vec::new();
            assert_eq!(sift(&mut bad, &keys, &row, |t| foremost.push(t)), 1);
            assert_eq!(foremost, [TetId::new(3)]);
        }
    }
}
