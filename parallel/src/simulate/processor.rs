//! One simulated processor: a worker, its inbox, and what is known of its time.

use super::cost::CostModel;
use crate::balance::{Balancer, Workload};
use crate::metrics::{Collector, Nanos};
use crate::protocol::{Event, Message, Rules, Source, Submesh, Ticket, Worker, WorkerId};
use std::collections::VecDeque;

/// A message on the network, with what travels along.
pub(super) struct Envelope<S: Submesh> {
    pub(super) from: WorkerId,
    /// The sender's points left.
    pub(super) load: u64,
    pub(super) bytes: u64,
    /// It is in a letter that another one has begun.
    pub(super) goes_along: bool,
    /// None: the sender has few points left and asks for a block.
    pub(super) message: Option<Message<S>>,
}

/// The next task of a processor.
pub(super) enum Next<S: Submesh> {
    /// It takes a message.
    Take(Envelope<S>),
    /// It looks in vain for a message, then does this.
    Do(Event<S>),
    /// It goes on with its own work without a look.
    GoOn,
    /// It asks others for blocks.
    Ask,
    /// Nothing.
    Rest,
}

/// Whether a worker asks others for blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asking {
    /// It has no intention to.
    No,
    /// It will at a later time.
    Later,
    /// It wants to.
    Now,
}

/// A simulated processor.
pub(super) struct Processor<S: Submesh, Q, C> {
    pub(super) worker: Worker<S, Q, C>,
    pub(super) inbox: VecDeque<Envelope<S>>,
    /// Operations whose backoff is over.
    pub(super) retries: VecDeque<Ticket>,
    /// Moves and the cancel.
    pub(super) orders: VecDeque<Event<S>>,
    pub(super) is_busy: bool,
    /// The time since when it has had nothing to do, if it looks for messages meanwhile.
    pub(super) looks_since: Option<Nanos>,
    /// Steps of own work since it last looked for messages.
    pub(super) unpolled: u32,
    /// Its last look has found messages, which it answers, one after the other.
    pub(super) answers: bool,
    /// Messages that leave when its turn is over, with their receivers.
    pub(super) letters: Vec<(WorkerId, Envelope<S>)>,
    /// The factor by which it takes longer than others.
    pub(super) slowness: f64,
    pub(super) balancer: Option<Balancer>,
    pub(super) asking: Asking,
    pub(super) collector: Collector,
}

/// The time of work done in a submesh.
pub(super) struct WorkTime {
    /// Of all of it.
    pub(super) all: Nanos,
    /// Of point location alone.
    pub(super) walk: Nanos,
}

impl<S: Submesh, Q: Source<S> + Workload, C: Rules> Processor<S, Q, C> {
    /// A turn is over, and the next one begins with a look for messages.
    pub(super) fn is_between_turns(&self, poll_every: u32) -> bool {
        let is_waited_for = self.worker.source().is_waited_for();
        let goes_on = !is_waited_for && self.unpolled + 1 < poll_every && self.worker.has_work();
        !self.answers && !goes_on
    }

    /// Messages come before local work, and set-back operations before new points; they are looked
    /// for before each `poll_every`-th step of local work, and all that are there are answered.
    pub(super) fn next(&mut self, poll_every: u32) -> Next<S> {
        if self.worker.is_stopped() {
            self.orders.clear();
            self.asking = Asking::No;
        }
        if !self.is_between_turns(poll_every) && !self.answers {
            self.unpolled += 1;
            return Next::GoOn;
        }
        self.unpolled = 0;
        self.answers = !self.inbox.is_empty();
        if let Some(envelope) = self.inbox.pop_front() {
            Next::Take(envelope)
        } else if let Some(ticket) = self.retries.pop_front() {
            Next::Do(Event::Retry(ticket))
        } else if let Some(order) = self.orders.pop_front() {
            Next::Do(order)
        } else if self.asking == Asking::Now {
            self.asking = Asking::No;
            Next::Ask
        } else if self.worker.has_work() {
            Next::Do(Event::Work)
        } else {
            Next::Rest
        }
    }

    /// It has nothing to do from `now` on, but to look for messages, unless it sleeps or has
    /// stopped.
    pub(super) fn rest(&mut self, now: Nanos, model: &CostModel) {
        if model.idle_poll > 0.0 && !self.worker.is_stopped() {
            self.looks_since = Some(now);
        }
    }

    /// It has something to do: the end of the looks that it has begun meanwhile, each in vain.
    pub(super) fn end_of_looks(&mut self, now: Nanos, model: &CostModel) -> Nanos {
        let Some(since) = self.looks_since.take() else { return now };
        let each = self.time(model.idle_poll).max(1);
        let looks = now.saturating_sub(since).div_ceil(each);
        let end = since + looks * each;
        self.collector.look_on(since, end, looks);
        end
    }

    /// A time on this processor.
    pub(super) fn time(&self, nanos: f64) -> Nanos {
        (nanos * self.slowness) as Nanos
    }

    /// The time of the work done in the submesh since the last call.
    pub(super) fn work_time(&mut self, model: &CostModel) -> WorkTime {
        let costs = self.worker.mesh_mut().take_costs();
        // No step takes no time: else time might stand still.
        let (all, walk) = (self.time(model.work(costs)).max(1), self.time(model.walk(costs)));
        WorkTime { all, walk }
    }
}
