//! The way of a worker thread's messages: one trait, so that a worker cannot tell what is behind.

use crate::mailbox::{Endpoint, Received};
use crate::protocol::{Message, Rules, Submesh, WorkerId};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// The letter that workers send each other: a message of the protocol, with a word about the
/// sender's load.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "Message<S>: serde::Serialize",
        deserialize = "Message<S>: serde::Deserialize<'de>"
    ))
)]
pub struct Mail<S: Submesh> {
    /// The sender's points left; 0 if nobody wants to know.
    pub load: u64,
    /// None: the sender has few points left and asks for blocks.
    pub message: Option<Message<S>>,
}

/// A worker's way to the others. Messages of one sender to one receiver keep their order.
pub trait Transport<M> {
    /// Adds a message for worker `to`.
    fn send(&mut self, to: WorkerId, message: M);

    /// Lets go of all messages sent.
    fn flush(&mut self);

    /// Moves all messages that have arrived to the end of `into`. Never waits.
    fn take(&mut self, into: &mut Vec<Received<M>>);

    /// Flushes, then waits until a message may be there, a worker has failed, or the time is over.
    fn wait(&mut self, timeout: Option<Duration>);

    /// A worker that has failed.
    fn failed(&self) -> Option<WorkerId>;

    /// Tells all workers that this one has failed. What was sent and not flushed may be lost.
    fn fail(&mut self);
}

impl<M, C: Rules> Transport<M> for Endpoint<M, C> {
    fn send(&mut self, to: WorkerId, message: M) {
        Endpoint::send(self, to, message);
    }

    fn flush(&mut self) {
        Endpoint::flush(self);
    }

    fn take(&mut self, into: &mut Vec<Received<M>>) {
        self.try_take(into);
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        match timeout {
            Some(timeout) => self.wait_timeout(timeout),
            None => Endpoint::wait(self),
        }
    }

    fn failed(&self) -> Option<WorkerId> {
        Endpoint::failed(self)
    }

    fn fail(&mut self) {
        Endpoint::fail(self);
    }
}

/// Threads with an injected latency: every message arrives that much after it was sent.
pub struct Delayed<M> {
    inner: Endpoint<Stamped<M>>,
    latency: Duration,
    /// Messages under way here, in the order of their arrival, and when they are due.
    under_way: VecDeque<(Instant, Received<M>)>,
    taken: Vec<Received<Stamped<M>>>,
}

/// A message that tells when it was sent.
#[derive(Debug)]
pub struct Stamped<M> {
    sent: Instant,
    message: M,
}

impl<M> Delayed<M> {
    /// Delays what arrives at `inner` by `latency`.
    pub fn new(inner: Endpoint<Stamped<M>>, latency: Duration) -> Self {
        Self { inner, latency, under_way: VecDeque::new(), taken: Vec::new() }
    }

    fn receive(&mut self) {
        self.inner.try_take(&mut self.taken);
        for Received { from, message: Stamped { sent, message } } in self.taken.drain(..) {
            self.under_way.push_back((sent + self.latency, Received { from, message }));
        }
    }
}

impl<M> Transport<M> for Delayed<M> {
    fn send(&mut self, to: WorkerId, message: M) {
        self.inner.send(to, Stamped { sent: Instant::now(), message });
    }

    fn flush(&mut self) {
        self.inner.flush();
    }

    fn take(&mut self, into: &mut Vec<Received<M>>) {
        self.receive();
        let now = Instant::now();
        // A message that is due later holds up those behind it: the order is kept.
        while self.under_way.front().is_some_and(|(due, ..)| *due <= now) {
            into.extend(self.under_way.pop_front().map(|(_, received)| received));
        }
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        self.receive();
        let due = self.under_way.front().map(|(due, ..)| *due - Instant::now().min(*due));
        match (due, timeout) {
            (None, None) => self.inner.wait(),
            (due, timeout) => {
                let least = due.into_iter().chain(timeout).min().unwrap_or_default();
                self.inner.wait_timeout(least);
            }
        }
    }

    fn failed(&self) -> Option<WorkerId> {
        self.inner.failed()
    }

    fn fail(&mut self) {
        self.inner.fail();
    }
}
