//! Mailboxes between the worker threads of one process.
//!
//! Every worker has one inbox, a vector behind a lock. A sender collects messages for each
//! receiver and hands all of them over at once ([`Endpoint::flush`]); a receiver takes its whole
//! inbox at once ([`Endpoint::try_take`]). So one lock is taken per batch, and never two at a
//! time. Messages of one sender to one receiver keep their order.
//!
//! * **Nothing is lost.** A message is in `unsent`, in the inbox, or taken.
//! * **No wake-up is lost.** A receiver tests its inbox and goes to sleep inside *one* critical
//!   section: a sender comes either before it, and the test sees the message, or after it, and
//!   sees `parked`.
//! * **A failure is heard.** An endpoint dropped by a panic, or one that calls
//!   [`Endpoint::fail`], marks every inbox and wakes its owner. Locks are never held across
//!   anything that can panic but allocation, and poison is ignored: the vectors are whole.
//!
//! `verify/models` runs this file under loom and shuttle.

use crate::protocol::{Correct, Rules, WorkerId};
use crate::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::marker::PhantomData;
use std::sync::PoisonError;
use std::time::Duration;

/// The messages that wait for one worker. Alone on its cache lines: inboxes of different workers
/// are touched by different threads.
#[repr(align(128))]
struct Inbox<M> {
    state: Mutex<State<M>>,
    arrived: Condvar,
}

/// A message that has arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Received<M> {
    /// Its sender.
    pub from: WorkerId,
    /// The message.
    pub message: M,
}

struct State<M> {
    messages: Vec<Received<M>>,
    /// The owner sleeps, or is about to within this critical section.
    parked: bool,
    /// A worker that has failed.
    failed: Option<WorkerId>,
}

impl<M> Inbox<M> {
    fn new() -> Self {
        let state = State { messages: Vec::new(), parked: false, failed: None };
        Self { state: Mutex::new(state), arrived: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, State<M>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sleeps until somebody wakes the owner, or for no reason.
    fn sleep<'a>(&self, mut state: MutexGuard<'a, State<M>>) -> MutexGuard<'a, State<M>> {
        state.parked = true;
        self.arrived.wait(state).unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the state and wakes the owner if it sleeps.
    fn deliver(&self, change: impl FnOnce(&mut State<M>)) {
        let mut state = self.lock();
        change(&mut state);
        let parked = std::mem::take(&mut state.parked);
        drop(state);
        if parked {
            self.arrived.notify_one();
        }
    }
}

impl<M> State<M> {
    fn is_silent(&self) -> bool {
        self.messages.is_empty() && self.failed.is_none()
    }
}

/// One worker's access to its inbox and to those of the others.
pub struct Endpoint<M, C: Rules = Correct> {
    me: WorkerId,
    inboxes: Arc<Vec<Inbox<M>>>,
    /// By receiver: messages not handed over yet.
    unsent: Vec<Vec<Received<M>>>,
    /// Receivers with unsent messages.
    dirty: Vec<WorkerId>,
    failed: Option<WorkerId>,
    rules: PhantomData<C>,
}

/// Endpoints of `workers` workers, by number.
pub fn connect<M>(workers: u32) -> Vec<Endpoint<M>> {
    connect_as(workers)
}

/// Endpoints of workers under any [`Rules`], by number: the models' door.
pub fn connect_as<M, C: Rules>(workers: u32) -> Vec<Endpoint<M, C>> {
    let inboxes = Arc::new((0..workers).map(|_| Inbox::new()).collect::<Vec<_>>());
    let endpoint = |me| Endpoint {
        me,
        inboxes: Arc::clone(&inboxes),
        unsent: (0..workers).map(|_| Vec::new()).collect(),
        dirty: Vec::new(),
        failed: None,
        rules: PhantomData,
    };
    WorkerId::below(workers).map(endpoint).collect()
}

impl<M, C: Rules> Endpoint<M, C> {
    /// The number of its worker.
    pub fn id(&self) -> WorkerId {
        self.me
    }

    /// Number of workers.
    pub fn workers(&self) -> u32 {
        self.inboxes.len() as u32
    }

    /// A worker that has failed, as far as [`Endpoint::try_take`] and [`Endpoint::wait`] have
    /// seen. It will answer no message any more.
    pub fn failed(&self) -> Option<WorkerId> {
        self.failed
    }

    /// Adds a message for worker `to`. It is handed over by the next [`Endpoint::flush`].
    pub fn send(&mut self, to: WorkerId, message: M) {
        let batch = &mut self.unsent[to.index()];
        if batch.is_empty() {
            self.dirty.push(to);
        }
        batch.push(Received { from: self.me, message });
    }

    /// Hands over all messages sent since the last time.
    pub fn flush(&mut self) {
        for to in self.dirty.drain(..) {
            let batch = &mut self.unsent[to.index()];
            self.inboxes[to.index()].deliver(|state| {
                if state.messages.is_empty() {
                    std::mem::swap(&mut state.messages, batch);
                } else {
                    state.messages.append(batch);
                }
            });
        }
    }

    /// Moves all messages that have arrived to the end of `into`; returns how many. Never
    /// waits.
    pub fn try_take(&mut self, into: &mut Vec<Received<M>>) -> usize {
        let before = into.len();
        let mut state = self.inboxes[self.me.index()].lock();
        if into.is_empty() {
            std::mem::swap(&mut state.messages, into);
        } else {
            into.append(&mut state.messages);
        }
        self.failed = self.failed.or(state.failed);
        into.len() - before
    }

    /// Flushes, then sleeps until a message is there or a worker has failed.
    pub fn wait(&mut self) {
        self.flush();
        let inbox = &self.inboxes[self.me.index()];
        let mut state = inbox.lock();
        // R17
        if !C::tests_before_sleep() && state.is_silent() {
            drop(state);
            state = inbox.sleep(inbox.lock());
        }
        // Ends when somebody delivers: every delivery wakes, and the test is repeated.
        while state.is_silent() {
            state = inbox.sleep(state);
        }
        state.parked = false;
        self.failed = self.failed.or(state.failed);
    }

    /// As [`Endpoint::wait`], for `timeout` at most. May return sooner for no reason.
    pub fn wait_timeout(&mut self, timeout: Duration) {
        self.flush();
        let inbox = &self.inboxes[self.me.index()];
        let mut state = inbox.lock();
        if state.is_silent() {
            state.parked = true;
            let woken = inbox.arrived.wait_timeout(state, timeout);
            state = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        state.parked = false;
        self.failed = self.failed.or(state.failed);
    }

    /// Tells all workers that this one has failed.
    pub fn fail(&mut self) {
        let me = self.me;
        self.failed = self.failed.or(Some(me));
        for inbox in self.inboxes.iter() {
            inbox.deliver(|state| state.failed = state.failed.or(Some(me)));
        }
    }
}

/// A panic of the worker is told to all others; else what was sent is handed over.
impl<M, C: Rules> Drop for Endpoint<M, C> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.fail();
        } else {
            self.flush();
        }
    }
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::{Endpoint, Received, connect};
    use crate::protocol::WorkerId;
    use std::thread;
    use std::time::Duration;

    #[test]
    fn batches_arrive_whole_and_in_order() {
        let mut ends = connect::<u32>(3);
        for k in 0..5 {
            ends[1].send(WorkerId::default(), k);
        }
        let mut taken = Vec::new();
        assert_eq!(ends[0].try_take(&mut taken), 0, "nothing was handed over yet");
        ends[1].flush();
        ends[2].send(WorkerId::default(), 9);
        ends[2].flush();
        assert_eq!(ends[0].try_take(&mut taken), 6);
        let received = |(from, message)| Received { from: WorkerId::new(from), message };
        let sent = [(1, 0), (1, 1), (1, 2), (1, 3), (1, 4), (2, 9)];
        assert_eq!(taken, sent.map(received));
        ends[1].send(WorkerId::default(), 7);
        ends[1].flush();
        ends[0].wait();
        assert_eq!(ends[0].try_take(&mut taken), 1, "taken is not empty: appended");
        assert_eq!(taken.last(), Some(&received((1, 7))));
    }

    /// Every thread sends `ROUNDS` numbers to every other, and sleeps whenever it has nothing.
    #[test]
    fn nobody_sleeps_for_ever_and_pairs_keep_their_order() {
        const WORKERS: u32 = 4;
        const ROUNDS: u32 = 2_000;
        let work = |mut end: Endpoint<u32>| {
            let me = end.id();
            let mut next = [0; WORKERS as usize];
            let mut taken = Vec::new();
            for round in 0..ROUNDS {
                for to in WorkerId::below(WORKERS).filter(|&to| to != me) {
                    end.send(to, round);
                }
                if round % 3 == 0 {
                    end.flush();
                }
                while next.iter().sum::<u32>() < (WORKERS - 1) * round {
                    end.wait();
                    assert!(end.try_take(&mut taken) > 0);
                    for Received { from, message } in taken.drain(..) {
                        assert_eq!(next[from.index()], message);
                        next[from.index()] += 1;
                    }
                }
            }
        };
        thread::scope(|scope| {
            for end in connect(WORKERS) {
                scope.spawn(move || work(end));
            }
        });
    }

    #[test]
    fn a_panic_is_heard_by_all_and_hangs_nobody() {
        let mut ends = connect::<u32>(3);
        let mut second = ends.remove(1);
        thread::scope(|scope| {
            let victim = scope.spawn(move || {
                second.send(WorkerId::default(), 1);
                panic!("planted");
            });
            for mut end in ends {
                scope.spawn(move || {
                    end.wait();
                    assert_eq!(end.failed(), Some(WorkerId::new(1)));
                    end.wait();
                    assert_eq!(end.try_take(&mut Vec::new()), 0, "a panic hands nothing over");
                });
            }
            assert!(victim.join().is_err());
        });
    }

    #[test]
    fn a_timeout_ends_a_wait_and_a_dropped_endpoint_hands_over() {
        let mut ends = connect::<u32>(2);
        ends[0].wait_timeout(Duration::from_millis(1));
        assert_eq!(ends[0].try_take(&mut Vec::new()), 0);
        let mut last = ends.remove(1);
        last.send(WorkerId::default(), 5);
        drop(last);
        let mut taken = Vec::new();
        assert_eq!(ends[0].try_take(&mut taken), 1);
        assert_eq!(ends[0].failed(), None);
    }
}
