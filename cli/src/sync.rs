//! The only module of this crate with atomics.

#[cfg(unix)]
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// A flag that is set at most once and never taken back. It publishes nothing else.
#[derive(Debug, Default)]
pub(crate) struct Flag(AtomicBool);

impl Flag {
    /// A flag that is not set.
    pub(crate) const fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    /// Sets it; true if it was set before.
    pub(crate) fn set(&self) -> bool {
        self.0.swap(true, Ordering::Relaxed)
    }

    /// Is it set?
    pub(crate) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A flag that is set at first and taken back once, for signal handlers. It publishes nothing else.
#[cfg(unix)]
#[derive(Debug, Clone)]
pub(crate) struct Still(Arc<AtomicBool>);

#[cfg(unix)]
impl Still {
    /// A flag that is set.
    pub(crate) fn new() -> Self {
        Self(Arc::new(AtomicBool::new(true)))
    }

    /// Takes it back.
    pub(crate) fn end(&self) {
        self.0.store(false, Ordering::Relaxed);
    }

    /// The flag, as a signal handler looks at it.
    pub(crate) fn shared(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }
}

/// The time when something was done last: a limit on how often it is done. It orders nothing.
#[derive(Debug, Default)]
pub(crate) struct Due(AtomicU64);

impl Due {
    /// Is it `pause` or longer since this was true last, or never true? `now` counts from any
    /// moment that stays the same.
    pub(crate) fn is_due(&self, now: Duration, pause: Duration) -> bool {
        let (now, pause) = (now.as_millis() as u64, pause.as_millis() as u64);
        let next = self.0.load(Ordering::Relaxed);
        now >= next && {
            self.0.store(now + pause, Ordering::Relaxed);
            true
        }
    }
}

/// The numbers of things done and of all. It orders nothing: a reader may see one of them late.
#[derive(Debug)]
pub(crate) struct Counts {
    done: AtomicU64,
    total: AtomicU64,
}

/// Points that were counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Counted {
    pub(crate) done: u64,
    /// The number of all, if it is known.
    pub(crate) total: Option<u64>,
}

/// Stands for a number that there is not.
const NONE: u64 = u64::MAX;

impl Default for Counts {
    /// Nothing is counted yet.
    fn default() -> Self {
        Self { done: AtomicU64::new(NONE), total: AtomicU64::new(NONE) }
    }
}

impl Counts {
    /// Sets both numbers.
    pub(crate) fn set(&self, done: u64, total: Option<u64>) {
        self.total.store(total.unwrap_or(NONE), Ordering::Relaxed);
        self.done.store(done, Ordering::Relaxed);
    }

    /// The numbers set last, if any were.
    pub(crate) fn get(&self) -> Option<Counted> {
        let known =
            |number: &AtomicU64| Some(number.load(Ordering::Relaxed)).filter(|n| *n != NONE);
        Some(Counted { done: known(&self.done)?, total: known(&self.total) })
    }
}

#[cfg(test)]
mod tests {
    use super::Due;
    use std::time::Duration;

    #[test]
    fn what_was_done_is_due_after_a_pause() {
        let (due, pause) = (Due::default(), Duration::from_millis(200));
        let times = [0, 100, 199, 200, 399, 401].map(Duration::from_millis);
        assert_eq!(times.map(|t| due.is_due(t, pause)), [true, false, false, true, false, true]);
    }
}
