//! The loop of one worker: the same on threads and in the models that run threads.
//!
//! ```text
//! take and answer all messages (QR) -> handle an order -> some local work (QL, then LB)
//!   -> ask for blocks, if points run out -> hand over what was sent -> sleep, if there was nothing
//! ```
//!
//! The differences between the runtimes are behind [`Transport`] (how messages travel) and
//! [`RuntimeHooks`] (the time, orders from outside, observers). Both are known when the code is
//! compiled.

use crate::balance::{Balance, Balancer, Workload};
use crate::mailbox::Received;
use crate::metrics::Nanos;
use crate::protocol::{
    Action, Attempt, BlockId, Event, Rules, Source, Submesh, SubmeshError, Ticket, Worker, WorkerId,
};
use crate::transport::{Mail, Transport};
use std::time::Duration;

/// A runtime's additions to the loop: time, orders, and a look at what happens.
pub trait RuntimeHooks<S: Submesh> {
    /// Units of local work between two looks for messages.
    const BURST: usize;

    /// Nanoseconds since some moment; always 0 if there is no clock.
    fn now(&mut self) -> Nanos;

    /// The time until `due`; `None` if there is no clock to wait for.
    fn until(&mut self, due: Nanos) -> Option<Duration>;

    /// The time at which an operation may start its attempt number `attempt` (the paper's rule).
    fn backoff(&mut self, attempt: Attempt) -> Nanos;

    /// An order from outside: to stop, or to give a block away. `may_move` tells whether a block
    /// may be given away now.
    fn order(&mut self, may_move: impl Fn(BlockId) -> bool) -> Option<Event<S>>;

    /// The time after which a sleeping worker must look for orders; `None` if it need not.
    fn poll_interval(&self) -> Option<Duration>;

    /// The number of looks for messages of a worker with nothing to do before it sleeps: to be
    /// woken takes longer than most answers do.
    fn polls_before_sleep(&self) -> u32 {
        0
    }

    /// A turn of the loop begins, or an `idle` worker is about to sleep; `describe` tells its
    /// state.
    fn turns(&mut self, idle: bool, describe: impl FnOnce() -> String) {
        let _ = (idle, describe);
    }

    /// A look for messages begins.
    fn polls(&mut self) {}

    /// The look has ended, and found `found` messages.
    fn polled(&mut self, found: usize);

    /// A step begins.
    fn begins(&mut self, event: &Event<S>) {
        let _ = event;
    }

    /// The step has ended in these actions.
    fn ended(&mut self, actions: &[Action<S>]);

    /// All sent messages are handed over, requests for blocks to `asked` others among them.
    fn sent(&mut self, asked: usize) {
        let _ = asked;
    }

    /// The worker has found nothing to do and sleeps.
    fn sleeps(&mut self) {}
}

/// A worker with its way to the others.
pub struct Loop<S: Submesh, Q, C, T, W> {
    node: Worker<S, Q, C>,
    way: T,
    hooks: W,
    balancer: Option<Balancer>,
    /// When it asks for blocks, if it is going to.
    asks: Option<Nanos>,
    actions: Vec<Action<S>>,
    inbox: Vec<Received<Mail<S>>>,
    /// Operations that back off, with the end of their time.
    resting: Vec<(Nanos, Ticket)>,
}

/// The remains of a loop that has come to its end.
pub struct Ended<S: Submesh, Q, C, T, W> {
    /// The worker. Nothing is locked or awaited, here or anywhere.
    pub node: Worker<S, Q, C>,
    /// Its way to the others.
    pub way: T,
    /// The watch.
    pub hooks: W,
}

/// Why a loop has not come to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Broken {
    /// Its own submesh has failed; the other workers have been told.
    Here(SubmeshError),
    /// Another worker has failed.
    Elsewhere(WorkerId),
}

impl<S, Q, C, T, W> Loop<S, Q, C, T, W>
where
    S: Submesh,
    Q: Source<S> + Workload,
    C: Rules,
    T: Transport<Mail<S>>,
    W: RuntimeHooks<S>,
{
    /// The loop of worker `node`, one of `workers`; it asks for blocks if there is a `balance`.
    pub fn new(
        node: Worker<S, Q, C>,
        workers: u32,
        way: T,
        hooks: W,
        balance: Option<Balance>,
    ) -> Self {
        let balancer = balance.map(|b| Balancer::new(b, node.id(), workers as usize));
        let (actions, inbox, resting) = (Vec::new(), Vec::new(), Vec::new());
        Self { node, way, hooks, balancer, asks: None, actions, inbox, resting }
    }

    /// Tells all others that this one is not going to run.
    pub(super) fn refuse(&mut self) {
        self.way.fail();
    }

    /// Runs until all work is done everywhere.
    ///
    /// Ends: the protocol does (`docs/protocol.md`), and a failure wakes every worker.
    ///
    /// # Errors
    /// [`Broken`] if a worker has failed: this one or another.
    pub fn run(mut self) -> Result<Ended<S, Q, C, T, W>, Broken> {
        let mut idle = 0;
        while !self.node.is_stopped() {
            if let Some(error) = self.node.error() {
                self.way.fail();
                return Err(Broken::Here(error));
            }
            if let Some(worker) = self.way.failed() {
                return Err(Broken::Elsewhere(worker));
            }
            self.hooks.turns(false, || self.node.describe());
            let heard = self.receive();
            self.handle_order();
            let worked = self.work();
            let asked = self.ask();
            self.way.flush();
            self.hooks.sent(asked);
            if heard || worked || self.node.is_stopped() {
                idle = 0;
            } else if idle < self.hooks.polls_before_sleep() {
                idle += 1;
                std::hint::spin_loop();
            } else if self.node.error().is_none() {
                self.sleep();
                idle = 0;
            }
        }
        self.way.flush();
        let Self { node, way, hooks, .. } = self;
        Ok(Ended { node, way, hooks })
    }

    /// Answers all messages that are there.
    fn receive(&mut self) -> bool {
        let mut inbox = std::mem::take(&mut self.inbox);
        self.hooks.polls();
        self.way.take(&mut inbox);
        self.hooks.polled(inbox.len());
        let heard = !inbox.is_empty();
        for Received { from, message: Mail { load, message } } in inbox.drain(..) {
            if let Some(balancer) = &mut self.balancer {
                balancer.heard(from, load);
            }
            match message {
                Some(message) => self.step(Event::Message { from, message }),
                None => self.give(from),
            }
        }
        self.inbox = inbox;
        heard
    }

    /// Handles an order from outside.
    fn handle_order(&mut self) {
        let node = &self.node;
        if let Some(event) = self.hooks.order(|block| node.can_migrate(block)) {
            self.step(event);
        }
    }

    /// Some local work.
    fn work(&mut self) -> bool {
        let mut worked = false;
        if !self.resting.is_empty() {
            let now = self.hooks.now();
            while let Some(k) = self.resting.iter().position(|&(due, _)| due <= now) {
                let (_, ticket) = self.resting.swap_remove(k);
                self.step(Event::Retry(ticket));
                worked = true;
            }
        }
        let burst = if self.node.source().is_waited_for() { 1 } else { W::BURST };
        for _ in 0..burst {
            if !self.node.has_work() {
                break;
            }
            let thinks = self.node.has_thoughts();
            if thinks {
                // They may take long: nobody is to wait for what was sent.
                self.way.flush();
            }
            self.step(Event::Work);
            worked = true;
            // A message may have come meanwhile.
            if thinks {
                break;
            }
        }
        worked
    }

    /// A worker with few points left asks others for blocks, at first at once, then less and less
    /// often. Returns how many it asks now.
    fn ask(&mut self) -> usize {
        let Some(balancer) = &mut self.balancer else { return 0 };
        let load = self.node.source().left();
        if self.node.is_stopped() || !balancer.is_low(load) {
            self.asks = None;
            return 0;
        }
        let now = self.hooks.now();
        let due = *self.asks.get_or_insert_with(|| now.saturating_add(balancer.pause()));
        if due > now {
            return 0;
        }
        self.asks = None;
        let others = balancer.ask(load);
        for &to in &others {
            self.way.send(to, Mail { load, message: None });
        }
        others.len()
    }

    /// Worker `to` has asked for blocks.
    fn give(&mut self, to: WorkerId) {
        let Some(balancer) = &mut self.balancer else { return };
        for block in balancer.give(&self.node, to) {
            self.step(Event::Migrate { block, to });
        }
    }

    fn sleep(&mut self) {
        self.hooks.sleeps();
        self.hooks.turns(true, || self.node.describe());
        let due = self.resting.iter().map(|&(due, _)| due).chain(self.asks).min();
        let rest = due.and_then(|due| self.hooks.until(due));
        self.way.wait(rest.into_iter().chain(self.hooks.poll_interval()).min());
    }

    fn step(&mut self, event: Event<S>) {
        self.hooks.begins(&event);
        self.node.step(event, &mut self.actions);
        self.hooks.ended(&self.actions);
        let load = self.balancer.as_ref().map_or(0, |_| self.node.source().left());
        for action in self.actions.drain(..) {
            match action {
                Action::Send { to, message } => {
                    self.way.send(to, Mail { load, message: Some(message) });
                }
                Action::Note(_) => {}
                Action::Backoff { ticket, attempt } => {
                    let due = self.hooks.backoff(attempt);
                    self.resting.push((due, ticket));
                }
            }
        }
    }
}
