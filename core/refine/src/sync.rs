//! The only file of this crate that touches atomics: numbers by slot, which several
//! threads may write, each those of its own slots.

use ltbw_core::topology::TetId;
use ltbw_core::{expect, prefetch};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// An array with a number for each slot of a mesh. Numbers carry no other data, so relaxed ordering
/// is enough.
macro_rules! by_slot {
    ($(#[$doc:meta])* $name:ident, $number:ident, $atomic:ident) => {
        $(#[$doc])*
        #[derive(Debug, Default)]
        pub(crate) struct $name(Vec<$atomic>);

        impl $name {
            /// Takes memory for this many slots, on huge pages where there are any. A hint.
            pub(crate) fn expect(&mut self, slots: usize) {
                expect(&mut self.0, slots);
            }

            /// Makes room for `slots` slots, zeros at first.
            pub(crate) fn grow(&mut self, slots: usize) {
                if self.0.len() < slots {
                    self.0.resize_with(slots, $atomic::default);
                }
            }

            /// The number of slot `t`.
            #[inline(always)]
            pub(crate) fn at(&self, t: TetId) -> $number {
                self.0[t.index()].load(Ordering::Relaxed)
            }

            /// Asks the processor to fetch the number of slot `t`. A hint.
            #[inline(always)]
            pub(crate) fn prefetch(&self, t: TetId) {
                prefetch(self.0.as_ptr().wrapping_add(t.index()));
            }

            /// Replaces the number of slot `t`.
            #[inline(always)]
            pub(crate) fn set(&self, t: TetId, number: $number) {
                self.0[t.index()].store(number, Ordering::Relaxed);
            }
        }
    };
}

by_slot! {
    /// A word for each slot.
    Words, u32, AtomicU32
}
by_slot! {
    /// A long word for each slot.
    Longs, u64, AtomicU64
}

impl Words {
    /// Raises the word of slot `t` to `word` if it is less. Several threads may do so at once,
    /// unless the caller is alone.
    #[inline(always)]
    pub(crate) fn raise(&self, t: TetId, word: u32, is_alone: bool) {
        let own = &self.0[t.index()];
        if own.load(Ordering::Relaxed) >= word {
            return;
        }
        match is_alone {
            true => own.store(word, Ordering::Relaxed),
            false => _ = own.fetch_max(word, Ordering::Relaxed),
        }
    }

    /// Makes all words zero.
    pub(crate) fn clear(&mut self) {
        self.0.iter_mut().for_each(|word| *word.get_mut() = 0);
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.0.capacity() * size_of::<AtomicU32>()
    }
}
