//! Progress, shared by the thread that works and the one that holds the interpreter.

use ltbw::Observer;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Points done, of a total that may be unknown (0), and the bell that rings at the end.
#[derive(Debug, Default)]
pub struct Progress {
    done: AtomicU64,
    total: AtomicU64,
    ended: Mutex<bool>,
    bell: Condvar,
}

/// The points of a piece of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Figures {
    /// The number of points done.
    pub done: u64,
    /// The number of all, if it is known.
    pub total: Option<u64>,
}

impl Observer for Progress {
    fn progress(&self, progress: ltbw::Progress) {
        // Figures for people: neither orders anything else.
        self.done.store(progress.done, Ordering::Relaxed);
        self.total.store(progress.total.unwrap_or(0), Ordering::Relaxed);
    }
}

impl Progress {
    /// The points so far.
    pub fn figures(&self) -> Figures {
        let total = self.total.load(Ordering::Relaxed);
        Figures { done: self.done.load(Ordering::Relaxed), total: (total > 0).then_some(total) }
    }

    /// Says that the work has ended.
    pub fn end(&self) {
        *self.ended.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.bell.notify_all();
    }

    /// Waits for the end of the work, at most `patience`: has it come?
    pub fn wait(&self, patience: Duration) -> bool {
        let ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.bell.wait_timeout_while(ended, patience, |ended| !*ended);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}
