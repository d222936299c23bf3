//! The teller of progress: workers count, and the calling thread tells the observer.
//!
//! So the observer is called from one thread, by time, and no worker waits for it.

use super::watchdog::{Watchdog, Watched};
use crate::protocol::WorkerId;
use crate::sync::Tally;
use ltbw_core::{Observer, Phase, Progress};
use std::fmt;
use std::thread::Thread;
use std::time::{Duration, Instant};

/// The time between two reports of one phase.
pub(crate) const PAUSE: Duration = Duration::from_millis(100);

/// An observer, if there is one.
#[derive(Clone, Copy, Default)]
pub(super) struct Listener<'a>(pub(super) Option<&'a dyn Observer>);

impl fmt::Debug for Listener<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "observed" } else { "not observed" })
    }
}

impl Listener<'_> {
    /// Tells of `done` points.
    pub(super) fn tell(&self, phase: Phase, done: u64, total: u64) {
        if let Some(observer) = self.0 {
            observer.progress(Progress { phase, done, total: Some(total) });
        }
    }
}

/// The teller of one run.
#[derive(Debug)]
pub(super) struct Teller<'a> {
    listener: Listener<'a>,
    total: u64,
    tally: Tally,
    watchdog: Option<Watchdog>,
}

/// A worker's word that it has ended, be it in a panic.
pub(super) struct Leave<'t> {
    tally: &'t Tally,
    caller: Thread,
}

impl Drop for Leave<'_> {
    fn drop(&mut self) {
        self.tally.end();
        self.caller.unpark();
    }
}

impl<'a> Teller<'a> {
    /// The teller of a run that has `done` points of `total`.
    pub(super) fn new(listener: Listener<'a>, done: u64, total: u64) -> Self {
        Self { listener, total, tally: Tally::new(done), watchdog: Watchdog::new() }
    }

    /// A worker's part of the watchdog, if there is one.
    pub(super) fn watch(&self, worker: WorkerId) -> Option<Watched<'_>> {
        self.watchdog.as_ref().map(|watchdog| watchdog.watch(worker))
    }

    /// The tally for the workers, if anybody wants to know.
    pub(super) fn tally(&self) -> Option<&Tally> {
        self.listener.0.map(|_| &self.tally)
    }

    /// The word of one worker, for its thread; the caller's thread is this one.
    pub(super) fn leave(&self) -> Leave<'_> {
        Leave { tally: &self.tally, caller: std::thread::current() }
    }

    /// Tells the observer of the points done until all `workers` have ended.
    ///
    /// Ends: each worker leaves its word when its thread ends.
    pub(super) fn tell_until(&self, workers: u32) {
        let mut next = Instant::now();
        while self.listener.0.is_some() && self.tally.ended() < workers {
            if Instant::now() >= next {
                self.listener.tell(Phase::Insert, self.tally.done().min(self.total), self.total);
                next = Instant::now() + PAUSE;
            }
            std::thread::park_timeout(next.saturating_duration_since(Instant::now()));
        }
    }
}
