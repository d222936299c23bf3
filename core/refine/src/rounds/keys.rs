//! Keys: which tetrahedra are over their bounds, and which of these come before all around them;
//! one list for an engine with a whole mesh and for each worker with a part of one.
//!
//! The key of a tetrahedron is the leading part of its rank. Whoever makes tetrahedra looks at them
//! as long as they are in the cache: a *look* enters their keys and stamps their slots, so that an
//! entry of before tells by its stamp that it is old.

use super::ranked::{Bad, Ranked, witness};
use crate::rules::choice::Rank;
use crate::sync::{Longs, Words};
use ltbw_core::topology::TetId;
use rayon::prelude::*;
use std::ops::Range;

/// Looks after which they are counted anew; few where nobody waits for it, so that it is tried.
const LAST_LOOK: u32 = match (cfg!(test), cfg!(debug_assertions)) {
    (true, _) => 8,
    (_, true) => 256,
    // Rounds of boundary items alone, after which nobody counts anew, have few.
    (false, false) => u32::MAX >> 1,
};

/// Entries that are sifted ahead in one step.
const SIFTED: usize = 256;

/// Tetrahedra over their bounds whose entries are looked at together, before what they point at.
const BLOCK: usize = 32;

/// The tetrahedra over their bounds.
#[doc(hidden)]
#[derive(Debug, Default)]
pub struct Keys {
    /// By slot: the key of its tetrahedron; 0 if that is within its bounds, or was refused.
    keys: Longs,
    /// By slot: the look at which its tetrahedron was new, or had gone.
    stamps: Words,
    /// Looks since they were counted anew, of which a round may have several.
    look: u32,
    /// The tetrahedra whose key is not 0, and others that are gone since.
    bad: Vec<Bad>,
    /// Entries to be forgotten: those before were sifted ahead, though some may be old by now.
    hole: Range<usize>,
}

impl Keys {
    /// Takes memory for this many tetrahedra. A hint.
    pub fn expect_tets(&mut self, tets: usize) {
        self.keys.expect(tets);
        self.stamps.expect(tets);
    }

    /// Makes room for this many slots.
    pub fn grow(&mut self, slots: usize) {
        self.keys.grow(slots);
        self.stamps.grow(slots);
    }

    /// The key of the tetrahedron in slot `t`.
    #[inline(always)]
    pub fn at(&self, t: TetId) -> u64 {
        self.keys.at(t)
    }

    /// The look at which slot `t` was written last.
    #[inline(always)]
    pub(crate) fn stamp(&self, t: TetId) -> u32 {
        self.stamps.at(t)
    }

    /// The looks so far.
    pub fn look(&self) -> u32 {
        self.look
    }

    /// Asks the processor to fetch the key of slot `t`. A hint.
    #[inline(always)]
    pub(crate) fn prefetch(&self, t: TetId) {
        self.keys.prefetch(t);
    }

    /// Asks the processor to fetch what a look writes of slot `t`. A hint.
    #[inline(always)]
    pub(crate) fn prefetch_all(&self, t: TetId) {
        self.keys.prefetch(t);
        self.stamps.prefetch(t);
    }

    /// Begins a look.
    pub fn begin_look(&mut self) {
        self.pass_looks(1);
    }

    /// Counts looks that several threads have made, each those of its own slots.
    pub(crate) fn pass_looks(&mut self, looks: u32) {
        self.look += looks;
    }

    /// Writes the entries of slot `t`, from this look on.
    #[inline(always)]
    pub fn write(&self, t: TetId, key: u64, look: u32) {
        self.keys.set(t, key);
        self.stamps.set(t, look);
    }

    /// Enters a tetrahedron that this look finds over its bounds.
    pub fn enter(&mut self, t: TetId, key: u64) {
        self.set(t, key);
        self.bad.push(self.entry(t));
    }

    /// Enters the key of the tetrahedron in slot `t`, whose stamp stays as it is.
    #[inline(always)]
    pub(crate) fn set(&self, t: TetId, key: u64) {
        self.keys.set(t, key);
    }

    /// Notes that the tetrahedron in slot `t` is new at this look.
    #[inline(always)]
    pub(crate) fn touch(&self, t: TetId) {
        self.stamps.set(t, self.look);
    }

    /// Nothing is in slot `t` any more that is over its bounds.
    #[inline(always)]
    pub fn forget(&self, t: TetId) {
        self.write(t, 0, self.look);
    }

    /// The entry of a tetrahedron that this look finds over its bounds.
    pub(crate) fn entry(&self, t: TetId) -> Bad {
        Bad::new(t, self.look)
    }

    /// Takes the list of entries, to which others are added before it is [put back](Self::put).
    pub(crate) fn take(&mut self) -> Vec<Bad> {
        std::mem::take(&mut self.bad)
    }

    /// Puts the list of entries back.
    pub(crate) fn put(&mut self, bad: Vec<Bad>) {
        self.bad = bad;
    }

    /// The number of entries, those of tetrahedra that are gone included.
    pub fn count(&self) -> usize {
        self.bad.len()
    }

    /// The slots of all entries, those of tetrahedra that are gone included.
    pub(crate) fn entries(&self) -> impl Iterator<Item = TetId> + '_ {
        self.bad.iter().map(|own| own.t)
    }

    /// Forgets all entries.
    pub(crate) fn clear(&mut self) {
        self.bad.clear();
        self.hole = 0..0;
    }

    /// Is an entry's tetrahedron before another one, which has this key?
    #[inline(always)]
    fn is_before(&self, mesh: &impl Ranked, one: TetId, other: TetId, key: u64) -> bool {
        let own = self.at(one);
        (own > key && (mesh.breaks_ties() || !Rank::is_tie(own, key)))
            || own == key && one != other && mesh.is_first_by_place(one, other)
    }

    /// The neighbour on the way, or `t`, and a tetrahedron around `t` that comes before it.
    ///
    /// A slot without a tetrahedron has no key, or while points are inserted one of before: a
    /// witness that its stamp forgets.
    #[inline(always)]
    pub(crate) fn one_before(&self, mesh: &impl Ranked, t: TetId) -> Option<[TetId; 2]> {
        let key = self.at(t);
        let is_before = |&one: &TetId| self.is_before(mesh, one, t, key);
        witness(t, mesh.neighbours(t), |way| mesh.around(way), is_before)
    }

    /// Looks around the tetrahedra of the entries from number `first` on, which are new and in the
    /// cache: what is before one of them now may be so when the round has ended.
    pub fn find_witnesses(&mut self, mesh: &impl Ranked, first: usize) {
        for k in first..self.bad.len() {
            if let Some(next) = self.bad.get(k + 2) {
                mesh.neighbours(next.t).into_iter().for_each(|t| self.keys.prefetch(t));
            }
            if let Some(witness) = self.one_before(mesh, self.bad[k].t) {
                self.bad[k].witness = witness;
            }
        }
    }

    /// Forgets the entries of those that are gone, and tells the tetrahedra that come before all
    /// around them, each with its key.
    pub fn sift(&mut self, mesh: &impl Ranked, mut foremost: impl FnMut(TetId, u64)) {
        let mut bad = std::mem::take(&mut self.bad);
        bad.drain(std::mem::take(&mut self.hole));
        let this = &*self;
        let kept = sift(&mut bad, this, mesh, |t| foremost(t, this.at(t)));
        bad.truncate(kept);
        self.bad = bad;
    }

    /// The findings of [`Keys::sift`] on several threads, each with `share` entries at a time, in
    /// the order of the entries.
    pub(crate) fn sift_in_shares<F: Send>(
        &mut self,
        mesh: &(impl Ranked + Sync),
        share: usize,
        foremost: impl Fn(TetId, u64) -> F + Sync,
    ) -> Vec<F> {
        let mut bad = std::mem::take(&mut self.bad);
        bad.drain(std::mem::take(&mut self.hole));
        let this = &*self;
        let look = |own: &mut [Bad]| {
            let mut found = Vec::new();
            let kept = sift(own, this, mesh, |t| found.push(foremost(t, this.at(t))));
            (kept, found)
        };
        let sifted: Vec<(usize, Vec<F>)> = bad.par_chunks_mut(share).map(look).collect();
        let (mut kept, mut all) = (0, Vec::new());
        for (k, (stay, found)) in sifted.into_iter().enumerate() {
            bad.copy_within(k * share..k * share + stay, kept);
            kept += stay;
            all.extend(found);
        }
        bad.truncate(kept);
        self.bad = bad;
        all
    }

    /// Were all entries sifted since the foremost were found?
    pub fn is_sifted_ahead(&self) -> bool {
        self.hole.end == self.bad.len()
    }

    /// Sifts some more entries, so that they have their witnesses when the foremost are found.
    /// Tells of tetrahedra that may be foremost then; returns the number of entries.
    pub fn sift_ahead(&mut self, mesh: &impl Ranked, told: impl FnMut(TetId)) -> usize {
        let mut bad = std::mem::take(&mut self.bad);
        let some = self.hole.end..bad.len().min(self.hole.end + SIFTED);
        let kept = sift(&mut bad[some.clone()], self, mesh, told);
        bad.copy_within(some.start..some.start + kept, self.hole.start);
        self.hole = self.hole.start + kept..some.end;
        self.bad = bad;
        some.len()
    }

    /// Was nothing written to some tetrahedra, and those around them, since a look?
    pub fn are_unchanged(&self, mesh: &impl Ranked, own: &[TetId], look: u32) -> bool {
        let stands = |t: TetId| self.stamp(t) <= look;
        own.iter().all(|&t| stands(t) && mesh.neighbours(t).into_iter().all(stands))
    }

    /// Forgets all looks, and what they have found, if there were that many: `true` then. Those
    /// that are gone are dropped before, as nothing tells them any more.
    pub fn count_looks_anew(&mut self) -> bool {
        if self.look <= LAST_LOOK {
            return false;
        }
        self.bad.drain(std::mem::take(&mut self.hole));
        self.bad.retain(|own| own.is_there(self.stamps.at(own.t)));
        self.bad.iter_mut().for_each(|own| *own = Bad::new(own.t, 0));
        self.stamps.clear();
        self.look = 0;
        true
    }
}

/// Moves those of some tetrahedra that are still there to the front, and tells those for which
/// there is no witness. Returns the number of those that are there.
#[inline]
fn sift(
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
