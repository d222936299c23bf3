//! Keys: which tetrahedra are over their bounds, and which of these come before all around them;
//! one list for an engine with a whole mesh and for each worker with a part of one.
//!
//! The key of a tetrahedron is the leading part of its rank. Whoever makes tetrahedra looks at them
//! as long as they are in the cache: a *look* enters their keys and stamps their slots, so that an
//! entry of before tells by its stamp that it is old.

use super::sift::{Bad, Ranked, sift, witness};
use crate::rules::choice::Rank;
use crate::sync::{Longs, Words};
use ltbw_core::topology::TetId;
use rayon::prelude::*;
use std::ops::Range;

/// Looks after which they are counted anew; few where nobody waits for it, so that it is tried.
const LAST_LOOK: u32 = match (cfg!(test), cfg!(debug_assertions)) {
    (true, _) => 8,
    (_, true) => 256,
    // A round has fewer.
    (false, false) => u32::MAX >> 1,
};

/// Entries that are sifted ahead in one step.
const SIFTED: usize = 256;

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
    pub fn stamp(&self, t: TetId) -> u32 {
        self.stamps.at(t)
    }

    /// The looks so far.
    pub fn look(&self) -> u32 {
        self.look
    }

    /// Asks the processor to fetch the key of slot `t`. A hint.
    #[inline(always)]
    pub fn prefetch(&self, t: TetId) {
        self.keys.prefetch(t);
    }

    /// Asks the processor to fetch what a look writes of slot `t`. A hint.
    #[inline(always)]
    pub fn prefetch_all(&self, t: TetId) {
        self.keys.prefetch(t);
        self.stamps.prefetch(t);
    }

    /// Begins a look.
    pub fn begin_look(&mut self) {
        self.pass_looks(1);
    }

    /// Counts looks that several threads have made, each those of its own slots.
    pub fn pass_looks(&mut self, looks: u32) {
        self.look += looks;
    }

    /// Writes the entries of slot `t`, from this look on.
    #[inline(always)]
    pub fn write(&self, t: TetId, key: u64, look: u32) {
        self.keys.set(t, key);
        self.stamps.set(t, look);
    }

    /// Enters the key of the tetrahedron in slot `t`, whose stamp stays as it is.
    #[inline(always)]
    pub fn set(&self, t: TetId, key: u64) {
        self.keys.set(t, key);
    }

    /// Notes that the tetrahedron in slot `t` is new at this look.
    #[inline(always)]
    pub fn touch(&self, t: TetId) {
        self.stamps.set(t, self.look);
    }

    /// Nothing is in slot `t` any more that is over its bounds.
    #[inline(always)]
    pub fn forget(&self, t: TetId) {
        self.write(t, 0, self.look);
    }

    /// The entry of a tetrahedron that this look finds over its bounds.
    pub fn entry(&self, t: TetId) -> Bad {
        Bad::new(t, self.look)
    }

    /// Takes the list of entries, to which others are added before it is [put back](Self::put).
    pub fn take(&mut self) -> Vec<Bad> {
        std::mem::take(&mut self.bad)
    }

    /// Puts the list of entries back.
    pub fn put(&mut self, bad: Vec<Bad>) {
        self.bad = bad;
    }

    /// The number of entries, those of tetrahedra that are gone included.
    pub fn count(&self) -> usize {
        self.bad.len()
    }

    /// The slots of all entries, those of tetrahedra that are gone included.
    pub fn entries(&self) -> impl Iterator<Item = TetId> + '_ {
        self.bad.iter().map(|own| own.t)
    }

    /// Forgets all entries.
    pub fn clear(&mut self) {
        self.bad.clear();
        self.hole = 0..0;
    }

    /// Is an entry's tetrahedron before another one, which has this key?
    #[inline(always)]
    fn is_before(&self, mesh: &impl Ranked, one: TetId, (other, key): (TetId, u64)) -> bool {
        let own = self.at(one);
        // R26.
        (own > key && (mesh.breaks_ties() || !Rank::is_tie(own, key)))
            || own == key && one != other && mesh.is_first_by_place(one, other)
    }

    /// The neighbour on the way, or `t`, and a tetrahedron around `t` that comes before it.
    ///
    /// A slot without a tetrahedron has no key, or while points are inserted one of before: a
    /// witness that its stamp forgets.
    #[inline(always)]
    pub fn one_before(&self, mesh: &impl Ranked, t: TetId) -> Option<[TetId; 2]> {
        let own = (t, self.at(t));
        let is_before = |&one: &TetId| self.is_before(mesh, one, own);
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
