//! The only file of this crate that touches atomics: cancelling long work from another thread.

#[cfg(loom)]
use loom::sync::{Arc, atomic::AtomicBool, atomic::Ordering};
#[cfg(not(loom))]
use std::sync::{Arc, atomic::AtomicBool, atomic::Ordering};

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
