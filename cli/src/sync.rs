//! The only module of this crate with atomics.

use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that is set at most once and never taken back. It publishes nothing else.
#[derive(Debug, Default)]
pub(crate) struct Flag(AtomicBool);

impl Flag {
    /// Sets it; true if it was set before.
    pub(crate) fn set(&self) -> bool {
        self.0.swap(true, Ordering::Relaxed)
    }

    /// Is it set?
    pub(crate) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
