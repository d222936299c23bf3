//! Figures of a run under way, from all workers to the thread that tells them.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// The points done so far, and the workers that have ended. It orders nothing else: what workers
/// leave behind is taken from their threads, which are joined.
#[derive(Debug)]
pub(crate) struct Tally {
    done: AtomicU64,
    ended: AtomicU32,
}

impl Tally {
    /// A tally of `done` points.
    pub(crate) fn new(done: u64) -> Self {
        Self { done: AtomicU64::new(done), ended: AtomicU32::new(0) }
    }

    /// More points are done.
    pub(crate) fn add(&self, points: u64) {
        self.done.fetch_add(points, Ordering::Relaxed);
    }

    /// The points done.
    pub(crate) fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// One more worker has ended.
    pub(crate) fn end(&self) {
        self.ended.fetch_add(1, Ordering::Relaxed);
    }

    /// The workers that have ended.
    pub(crate) fn ended(&self) -> u32 {
        self.ended.load(Ordering::Relaxed)
    }
}
