//! The additions of a worker thread to the loop: a clock, a cancel token, counters, and figures if
//! they are wanted.

use super::WorkerStats;
use super::watchdog::Watched;
use super::worker_loop::RuntimeHooks;
use crate::metrics::{Cause, Collector, Nanos, Step, SubmeshSize};
use crate::payload::{LOAD_BYTES, Payload, bytes};
use crate::protocol::{Action, Attempt, BlockId, Event, Note, WorkerId};
use crate::sync::Tally;
use ltbw_core::{CancelToken, Random};
use std::time::{Duration, Instant};

/// A cancel token wakes nobody: a sleeping worker looks at it now and then.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// The number of times that a backoff doubles.
const DOUBLINGS: u32 = 10;

/// Looks for messages of a worker with nothing to do, some ten microseconds in all, before it
/// sleeps.
const POLLS: u32 = 100;

/// Points that a thread or a process inserts between two looks for messages.
pub const BURST: u32 = 8;

/// Points that a worker has done before it says so.
const BATCH: u64 = 64;

/// The watch of a worker thread.
#[derive(Debug)]
pub(super) struct ThreadHooks<'a> {
    start: Instant,
    cancel: Option<&'a CancelToken>,
    /// The worker was told of the cancel.
    has_cancelled: bool,
    /// A backoff's longest time, before it is doubled.
    backoff: Duration,
    random: Random,
    polls: u32,
    pub(super) stats: WorkerStats,
    meter: Option<Meter>,
    /// The figures of all workers, if somebody wants to know.
    tally: Option<&'a Tally>,
    /// Points done that the tally does not have yet.
    uncounted: u64,
    /// Its part of the watchdog, if there is one.
    watched: Option<Watched<'a>>,
}

/// The settings that all workers of a run have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Running<'a> {
    /// Its begin.
    pub(super) start: Instant,
    pub(super) cancel: Option<&'a CancelToken>,
    /// A backoff's longest time, before it is doubled.
    pub(super) backoff: Duration,
    /// If there is a number, all is measured, and that number of stretches of time is kept.
    pub(super) spans: Option<usize>,
    /// There are more workers than processors.
    pub(super) crowded: bool,
}

/// Takes the time of everything.
#[derive(Debug)]
struct Meter {
    collector: Collector,
    /// The end of the last thing measured.
    last: Nanos,
    cause: Cause,
}

impl<'a> ThreadHooks<'a> {
    /// The watch of `worker` in a run.
    pub(super) fn new(worker: WorkerId, run: Running<'a>) -> Self {
        let Running { start, cancel, backoff, spans, crowded } = run;
        let meter = spans.map(|spans| Meter {
            collector: Collector::new(worker, spans),
            last: 0,
            cause: Cause::Work,
        });
        let random = Random::new(worker.number().into());
        let stats = WorkerStats::default();
        let polls = if crowded { 0 } else { POLLS };
        let (tally, uncounted, watched) = (None, 0, None);
        Self {
            start,
            cancel,
            has_cancelled: false,
            backoff,
            random,
            polls,
            stats,
            meter,
            tally,
            uncounted,
            watched,
        }
    }

    /// Adds the points done to `tally`.
    pub(super) fn counted(mut self, tally: Option<&'a Tally>) -> Self {
        self.tally = tally;
        self
    }

    /// Tells a watchdog what it does.
    pub(super) fn watched(mut self, watched: Option<Watched<'a>>) -> Self {
        self.watched = watched;
        self
    }

    fn count(&mut self, most: u64) {
        if self.uncounted > most {
            if let Some(tally) = self.tally {
                tally.add(self.uncounted);
            }
            self.uncounted = 0;
        }
    }

    /// Ends the measuring.
    pub(super) fn finish(self, mesh: &impl SubmeshSize) -> (WorkerStats, Option<Collector>) {
        let seconds = self.start.elapsed().as_secs_f64();
        let collector = self.meter.map(|mut meter| {
            meter.collector.finish(meter.last, mesh);
            meter.collector
        });
        (WorkerStats { seconds, ..self.stats }, collector)
    }
}

/// Nanoseconds since `start`: 584 years fit.
fn nanos(start: Instant) -> Nanos {
    start.elapsed().as_nanos() as Nanos
}

impl<S: Payload> RuntimeHooks<S> for ThreadHooks<'_> {
    const BURST: usize = BURST as usize;

    fn now(&mut self) -> Nanos {
        nanos(self.start)
    }

    fn until(&mut self, due: Nanos) -> Option<Duration> {
        Some(Duration::from_nanos(due.saturating_sub(nanos(self.start))))
    }

    /// A random time that doubles with every attempt.
    fn backoff(&mut self, attempt: Attempt) -> Nanos {
        let most = self.backoff * (1 << attempt.number().min(DOUBLINGS));
        let time = most.mul_f64(self.random.unit());
        nanos(self.start) + time.as_nanos() as Nanos
    }

    fn order(&mut self, _: impl Fn(BlockId) -> bool) -> Option<Event<S>> {
        if self.has_cancelled || !self.cancel.is_some_and(CancelToken::is_cancelled) {
            return None;
        }
        self.has_cancelled = true;
        Some(Event::Cancel)
    }

    fn poll_interval(&self) -> Option<Duration> {
        let watched = self.watched.as_ref().map(Watched::poll_interval);
        self.cancel.filter(|_| !self.has_cancelled).map(|_| POLL_INTERVAL).or(watched)
    }

    fn turns(&mut self, idle: bool, describe: impl FnOnce() -> String) {
        if let Some(watched) = &mut self.watched {
            watched.turns(idle, describe);
        }
    }

    fn polls_before_sleep(&self) -> u32 {
        self.polls
    }

    fn polls(&mut self) {
        if let Some(meter) = &mut self.meter {
            meter.last = nanos(self.start);
        }
    }

    fn polled(&mut self, found: usize) {
        self.stats.polls[0] += 1;
        self.stats.polls[1] += u64::from(found > 0);
        if let Some(meter) = &mut self.meter {
            let end = nanos(self.start);
            meter.collector.poll(meter.last, end, found > 0);
            meter.last = end;
        }
    }

    fn begins(&mut self, event: &Event<S>) {
        self.watched.iter_mut().for_each(Watched::begins);
        if let Some(meter) = &mut self.meter {
            meter.cause = Cause::of(event);
        }
    }

    fn ended(&mut self, actions: &[Action<S>]) {
        let before = self.uncounted;
        for action in actions {
            match action {
                Action::Send { message, .. } => {
                    self.stats.messages += 1;
                    if let Some(meter) = &mut self.meter {
                        meter.collector.sent(message.kind(), bytes(message));
                    }
                }
                Action::Note(note) => {
                    let is_done = matches!(
                        note,
                        Note::Local | Note::Duplicate | Note::Gone | Note::Committed { .. }
                    );
                    self.uncounted += u64::from(is_done);
                    self.stats.note(*note);
                }
                Action::Backoff { .. } => {}
            }
        }
        if let Some(watched) = &mut self.watched {
            watched.ended(actions, self.uncounted - before);
        }
        self.count(BATCH);
        if let Some(meter) = &mut self.meter {
            let (begin, end) = (meter.last, nanos(self.start));
            let step = Step { begin, end, communication: 0, walk: 0 };
            meter.collector.step(meter.cause, step, actions);
            meter.last = end;
        }
    }

    fn sleeps(&mut self) {
        self.count(0);
    }

    fn sent(&mut self, asked: usize) {
        if let Some(meter) = &mut self.meter {
            let end = nanos(self.start);
            (0..asked).for_each(|_| meter.collector.sent("load", LOAD_BYTES));
            meter.collector.communicate(meter.last, end);
            meter.last = end;
        }
    }
}
