//! The only file of this crate that touches atomics: cancelling long work from another thread, and
//! the claims of several threads on the slots of one mesh.

use crate::arena::prefetch;
use crate::topology::TetId;
#[cfg(loom)]
use loom::sync::{Arc, atomic::AtomicBool};
use std::sync::atomic::{AtomicU8, Ordering};
#[cfg(not(loom))]
use std::sync::{Arc, atomic::AtomicBool};

/// A shared flag that asks long work to stop. Clones share the flag.
#[derive(Clone, Debug)]
pub struct CancelToken(Arc<AtomicBool>);

impl Default for CancelToken {
    fn default() -> Self {
        Self(Arc::new(AtomicBool::new(false)))
    }
}

impl CancelToken {
    /// A token that is not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the work to stop. It stops at its next check; the mesh so far stays valid.
    ///
    /// The flag carries no data, so relaxed ordering is enough.
    pub fn cancel(&self) {
        self.0.swap(true, Ordering::Relaxed);
    }

    /// Was [`CancelToken::cancel`] called on this token or a clone?
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The claims of several lanes on the slots of a mesh: a slot is the own one of the lane that was
/// the first to ask for it. A lane alone reads and writes what is in its slots, so relaxed ordering
/// is enough.
#[derive(Debug, Default)]
pub(crate) struct Claims(Vec<AtomicU8>);

impl Claims {
    /// The most lanes; they have numbers from 1 on.
    pub(crate) const MOST: usize = u8::MAX as usize;

    /// Makes `slots` slots nobody's.
    pub(crate) fn clear(&mut self, slots: usize) {
        self.0.iter_mut().for_each(|slot| *slot.get_mut() = 0);
        self.0.resize_with(slots.max(self.0.len()), Default::default);
    }

    /// The number of slots that there are claims on.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Gives slot `t` to a lane; `false` if there is no such slot, or it is somebody's.
    #[inline(always)]
    pub(crate) fn give(&self, t: TetId, lane: u8) -> bool {
        let take = |slot: &AtomicU8| {
            slot.compare_exchange(0, lane, Ordering::Relaxed, Ordering::Relaxed).is_ok()
        };
        self.0.get(t.index()).is_some_and(take)
    }

    /// Asks the processor to fetch the entry of slot `t`. A hint.
    #[inline(always)]
    pub(crate) fn prefetch(&self, t: TetId) {
        prefetch(self.0.as_ptr().wrapping_add(t.index()));
    }

    /// Asks for slot `t`; says whether it is this lane's.
    #[inline(always)]
    pub(crate) fn ask(&self, t: TetId, lane: u8) -> bool {
        self.has(t, lane) || self.give(t, lane)
    }

    /// Is slot `t` this lane's?
    #[inline(always)]
    pub(crate) fn has(&self, t: TetId, lane: u8) -> bool {
        self.0.get(t.index()).is_some_and(|slot| slot.load(Ordering::Relaxed) == lane)
    }
}
