//! Reservations: the slots that the cavities of a round's candidates have, and those that the
//! round has written.
//!
//! A slot has one word, and no round clears any: what earlier rounds have left is smaller than what
//! this one writes.

use crate::sync::Words;
use ltbw_core::topology::TetId;
use std::ops::Range;

/// The largest word of a candidate. A round adds less than that.
const LAST: u32 = if cfg!(test) { 1 << 10 } else { u32::MAX >> 1 };

/// The reservations of a round, by the ranks of its candidates; 0 is the foremost.
#[derive(Debug, Default)]
pub(super) struct Reserved {
    /// By slot, if it is more than `free`: `count` more, less the rank of the foremost candidate
    /// with the slot in its cavity; or more than that, if this round has written it.
    words: Words,
    /// The largest word of the rounds before.
    free: u32,
    /// The number of ranks, and of the first ones among them, which boundary items have.
    count: u32,
    boundary: u32,
    /// Looks at new tetrahedra in this round so far.
    looks: u32,
    /// By rank: is the candidate of this rank to be alone? Empty if none is.
    alone: Vec<bool>,
}

impl Reserved {
    /// Takes memory for this many slots. A hint.
    pub(super) fn expect(&mut self, slots: usize) {
        self.words.expect(slots);
    }

    /// Makes room for this many slots.
    pub(super) fn grow(&mut self, slots: usize) {
        self.words.grow(slots);
    }

    /// Starts a round of this many ranks, of which boundary items have the first ones, in which no
    /// slot is reserved or written.
    pub(super) fn start(&mut self, count: usize, boundary: usize) {
        let count = count as u32;
        self.free = match self.written().checked_add(count).filter(|&most| most < LAST) {
            Some(_) => self.written(),
            None => {
                self.words.clear();
                0
            }
        };
        (self.count, self.boundary, self.looks) = (count, boundary as u32, 0);
        self.alone.clear();
    }

    /// Starts the same round once more; ranks that have to be alone are known by now.
    pub(super) fn start_again(&mut self) {
        let alone = std::mem::take(&mut self.alone);
        self.start(self.count as usize, self.boundary as usize);
        self.alone = alone;
    }

    /// The ranks of boundary items.
    pub(super) fn of_boundary(&self) -> Range<u32> {
        0..self.boundary
    }

    /// The ranks of tetrahedra.
    pub(super) fn of_tets(&self) -> Range<u32> {
        self.boundary..self.count
    }

    /// Reserves slots for the candidate of a rank, where none before it has them. Several threads
    /// may do so at once, unless the caller is alone: the foremost stays, whoever writes first.
    #[inline(always)]
    pub(super) fn reserve(&self, rank: u32, slots: &[TetId], is_alone: bool) {
        let own = self.free + self.count - rank;
        slots.iter().for_each(|&t| self.words.raise(t, own, is_alone));
    }

    /// Does a candidate before the one of this rank have slot `t` in its cavity?
    #[inline(always)]
    pub(super) fn has_rival(&self, t: TetId, rank: u32) -> bool {
        self.words.at(t) > self.free + self.count - rank
    }

    /// The rank of the foremost candidate with slot `t` in its cavity, before any is written.
    #[inline(always)]
    pub(super) fn holder(&self, t: TetId) -> Option<usize> {
        let own = self.words.at(t);
        (own > self.free).then(|| (self.free + self.count - own) as usize)
    }

    /// Notes by its rank whether a candidate has to be alone.
    pub(super) fn note_alone(&mut self, rank: u32, alone: bool) {
        if alone || !self.alone.is_empty() {
            self.alone.resize(self.count as usize, false);
            self.alone[rank as usize] = alone;
        }
    }

    /// Has any candidate to be alone?
    pub(super) fn has_alone(&self) -> bool {
        !self.alone.is_empty()
    }

    /// Has the candidate of a rank to be alone?
    pub(super) fn is_alone(&self, rank: usize) -> bool {
        self.alone[rank]
    }

    /// Asks the processor to fetch the word of slot `t`. A hint.
    #[inline(always)]
    pub(super) fn prefetch(&self, t: TetId) {
        self.words.prefetch(t);
    }

    /// Has this round written slot `t`?
    #[inline(always)]
    pub(super) fn is_written(&self, t: TetId) -> bool {
        self.words.at(t) > self.free + self.count
    }

    /// The word of slots that the insertions since the last look have written: it is larger than
    /// those of candidates, and than those written before.
    fn written(&self) -> u32 {
        self.free + self.count + 1 + self.looks
    }

    /// Notes that an insertion has written slot `t`, `looks` looks after the last that was passed;
    /// `false` if that is noted since the look before. Several threads may do so at once, each for
    /// slots of its own.
    #[inline(always)]
    pub(super) fn note_written(&self, t: TetId, looks: u32) -> bool {
        let written = self.written() + looks;
        let is_new = self.words.at(t) != written;
        if is_new {
            self.words.set(t, written);
        }
        is_new
    }

    /// Counts looks at what was written.
    pub(super) fn pass_looks(&mut self, looks: u32) {
        self.looks += looks;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_round_sees_what_another_has_left() {
        let mut all = Reserved::default();
        all.grow(3);
        let [a, b, c] = [0, 1, 2].map(TetId::new);
        // More rounds than words have room for, of other widths.
        for round in 0..u64::from(LAST) {
            let count = 1 + round as usize % 7;
            all.start(count, 0);
            assert!([a, b, c].iter().all(|&t| all.holder(t).is_none() && !all.is_written(t)));
            let last = count as u32 - 1;
            all.reserve(last, &[a, b], true);
            all.reserve(0, &[b], false);
            assert_eq!([a, b, c].map(|t| all.holder(t)), [Some(count - 1), Some(0), None]);
            assert_eq!([a, b, c].map(|t| all.has_rival(t, last)), [false, last > 0, false]);
            assert!(all.note_written(a, 0) && !all.note_written(a, 0) && all.is_written(a));
            all.pass_looks(1);
            assert!(all.note_written(a, 0) && all.note_written(b, 1) && !all.is_written(c));
            all.pass_looks(1);
        }
    }
}
