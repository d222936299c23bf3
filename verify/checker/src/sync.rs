//! The only module of this crate with atomics: arrays that the threads of a sweep write and that
//! are read after it. The end of the sweep orders the two, so that relaxed accesses are enough.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Marks, each of which may be set by several threads. None is ever taken away.
pub(crate) struct Marks(Vec<AtomicBool>);

impl Marks {
    /// `len` marks, not set.
    pub(crate) fn new(len: usize) -> Self {
        Self((0..len).map(|_| AtomicBool::new(false)).collect())
    }

    /// Sets mark `k`, if there is one. It is read first, so that a mark that is set costs no
    /// traffic between the cores; setting it is one step, whatever other threads do in between.
    pub(crate) fn set(&self, k: usize) {
        if let Some(mark) = self.0.get(k)
            && !mark.load(Ordering::Relaxed)
        {
            mark.fetch_or(true, Ordering::Relaxed);
        }
    }

    /// The marks, when the sweep is over.
    pub(crate) fn into_plain(self) -> Vec<bool> {
        self.0.into_iter().map(AtomicBool::into_inner).collect()
    }
}

/// Numbers, each of which is written by one thread at most.
pub(crate) struct Numbers(Vec<AtomicU32>);

impl Numbers {
    /// `len` times `number`.
    pub(crate) fn new(len: usize, number: u32) -> Self {
        Self((0..len).map(|_| AtomicU32::new(number)).collect())
    }

    /// Writes number `k`, which must exist.
    pub(crate) fn set(&self, k: u32, number: u32) {
        self.0[k as usize].store(number, Ordering::Relaxed);
    }

    /// The numbers, when the sweep is over.
    pub(crate) fn into_plain(self) -> Vec<u32> {
        self.0.into_iter().map(AtomicU32::into_inner).collect()
    }
}
