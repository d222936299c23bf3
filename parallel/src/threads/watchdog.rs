//! A run that hangs is a failure, which shows the state of each worker: in debug builds, hence in
//! all tests.
//!
//! Every worker notes what it does, and looks now and then whether anybody has got on, asleep or
//! not. The first to find that nobody has for [`PATIENCE`] panics with the notes of all; the others
//! hear of that as of any failure. A step that does not end keeps its thread, as it does in
//! releases: the notes show which worker is in one.

use crate::protocol::{Action, Submesh, WorkerId};
use crate::sync::{Arc, Mutex, Tally};
use std::fmt::{self, Write};
use std::sync::PoisonError;
use std::time::{Duration, Instant};

/// The time without a point done, by any worker, after which a run hangs. Longer than a barrier, a
/// look at a whole mesh and the steps between two points take together, on a machine with many
/// other things to do.
const PATIENCE: Duration = Duration::from_secs(120);

/// Looks without a point done after which a run hangs, each a part of the patience after the one
/// before: a machine that stands still for as long as that is one look, and no run that hangs.
const LOOKS: u32 = 8;

/// The time between two descriptions of a worker that does not rest.
const NOTED: Duration = Duration::from_secs(1);

/// Actions that are remembered.
const ACTIONS: usize = 8;

/// The notes of one worker.
struct Notes {
    worker: WorkerId,
    /// The state that it was in between two steps, and when.
    state: String,
    at: Instant,
    is_idle: bool,
    steps: u64,
    is_in_step: bool,
    /// The last actions.
    last: Vec<String>,
}

/// The part that all workers of a run share.
pub(super) struct Watchdog {
    patience: Duration,
    done: Tally,
    notes: Mutex<Vec<Arc<Mutex<Notes>>>>,
}

/// One worker's part.
pub(super) struct Watched<'w> {
    common: &'w Watchdog,
    own: Arc<Mutex<Notes>>,
    /// Points done when they were last counted.
    done: u64,
    /// Since when they are not more, when that was last looked at, and how many times it was.
    since: Instant,
    looked: Instant,
    looks: u32,
}

impl fmt::Debug for Watchdog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a watchdog")
    }
}

impl fmt::Debug for Watched<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("watched")
    }
}

impl Watchdog {
    /// A watchdog, in debug builds.
    pub(super) fn new() -> Option<Self> {
        cfg!(debug_assertions).then(|| Self::with(PATIENCE))
    }

    /// One with another patience.
    pub(super) fn with(patience: Duration) -> Self {
        Self { patience, done: Tally::new(0), notes: Mutex::new(Vec::new()) }
    }

    /// A worker's part.
    pub(super) fn watch(&self, worker: WorkerId) -> Watched<'_> {
        let (state, at) = ("not begun".to_owned(), Instant::now());
        let (is_idle, is_in_step, steps, last) = (false, false, 0, Vec::new());
        let notes = Notes { worker, state, at, is_idle, steps, is_in_step, last };
        let own = Arc::new(Mutex::new(notes));
        self.notes.lock().unwrap_or_else(PoisonError::into_inner).push(Arc::clone(&own));
        Watched { common: self, own, done: 0, since: at, looked: at, looks: 0 }
    }

    /// The notes of all.
    fn tell(&self) -> String {
        let mut text = String::new();
        for notes in self.notes.lock().unwrap_or_else(PoisonError::into_inner).iter() {
            let own = notes.lock().unwrap_or_else(PoisonError::into_inner);
            let doing = match (own.is_in_step, own.is_idle) {
                (true, _) => "in a step",
                (false, true) => "asleep",
                (false, false) => "awake",
            };
            let Notes { worker, state, steps, last, .. } = &*own;
            let seconds = own.at.elapsed().as_secs();
            let _ =
                write!(text, "\nworker {worker}: {doing} after {steps} steps; {seconds} s ago:");
            let _ = write!(text, "\n{state}\n  last: {}", last.join(", "));
        }
        text
    }
}

impl Watched<'_> {
    /// The longest sleep: then it looks whether anybody has got on.
    pub(super) fn poll_interval(&self) -> Duration {
        self.common.patience / LOOKS
    }

    /// A turn of the loop begins, or a sleep.
    ///
    /// # Panics
    /// If nobody has got on for too long.
    pub(super) fn turns(&mut self, is_idle: bool, describe: impl FnOnce() -> String) {
        let now = Instant::now();
        let mut own = self.own.lock().unwrap_or_else(PoisonError::into_inner);
        own.is_in_step = false;
        if own.steps == 0 || own.is_idle != is_idle || now.duration_since(own.at) >= NOTED {
            (own.state, own.at, own.is_idle) = (describe(), now, is_idle);
        }
        drop(own);
        let done = self.common.done.done();
        if done != self.done {
            (self.done, self.since, self.looked, self.looks) = (done, now, now, 0);
        } else if now.duration_since(self.looked) >= self.poll_interval() {
            (self.looked, self.looks) = (now, self.looks + 1);
            if self.looks >= LOOKS {
                let seconds = now.duration_since(self.since).as_secs();
                panic!("the run hangs: no point done for {seconds} s{}", self.common.tell());
            }
        }
    }

    /// A step begins.
    pub(super) fn begins(&mut self) {
        let mut own = self.own.lock().unwrap_or_else(PoisonError::into_inner);
        (own.is_in_step, own.is_idle) = (true, false);
        own.steps += 1;
    }

    /// A step has ended, by which `done` more points are.
    pub(super) fn ended<S: Submesh>(&mut self, actions: &[Action<S>], done: u64) {
        self.common.done.add(done);
        let mut own = self.own.lock().unwrap_or_else(PoisonError::into_inner);
        own.is_in_step = false;
        let first = actions.len().saturating_sub(ACTIONS);
        own.last.extend(actions[first..].iter().map(|action| match action {
            Action::Send { to, message } => {
                format!("{} of {:?} to {to}", message.kind(), message.ticket())
            }
            Action::Backoff { ticket, .. } => format!("backoff of {ticket:?}"),
            Action::Note(note) => format!("{note:?}"),
        }));
        let surplus = own.last.len().saturating_sub(ACTIONS);
        own.last.drain(..surplus);
    }
}
