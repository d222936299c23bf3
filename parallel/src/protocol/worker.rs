//! One worker: its state, and the step that answers an event with actions. Here events are only
//! routed: to operations (the home's side), lock requests (the owner's side), blocks that move and
//! the token.

use super::config::Config;
use super::directory::{BlockId, Directory, WorkerId};
use super::invariant::invariant;
use super::news::Standing;
use super::rules::{Correct, Rules};
use super::state::{Asker, Granted, Locks, Operations, Spare, Start, Want};
use super::submesh::{Source, Submesh, SubmeshError};
use super::termination::{Pass, TerminationWave, Token};
use super::{Attempt, Message, Ticket};
use std::collections::VecDeque;
use std::marker::PhantomData;

/// An event for a worker.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Event<S: Submesh> {
    /// A message arrives. Messages of one sender arrive in the order in which they were sent.
    Message {
        /// The sender.
        from: WorkerId,
        /// The message.
        message: Message<S>,
    },
    /// There is time for one unit of local work. Does nothing unless [`Worker::has_work`].
    Work,
    /// The backoff of an operation is over.
    Retry(Ticket),
    /// Give a block away, if that is allowed now.
    Migrate {
        /// The block.
        block: BlockId,
        /// The receiver.
        to: WorkerId,
    },
    /// Start no more points. The mesh of the points inserted so far is the result.
    Cancel,
}

/// An action that a worker wants done.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Action<S: Submesh> {
    /// Send a message.
    Send {
        /// The receiver, never the worker itself.
        to: WorkerId,
        /// The message.
        message: Message<S>,
    },
    /// Answer with [`Event::Retry`] after a random time that grows with `attempt`.
    Backoff {
        /// The operation.
        ticket: Ticket,
        /// Its setbacks so far.
        attempt: Attempt,
    },
    /// For counters and traces; needs no answer.
    Note(Note),
}

/// A note about a step, for counters and traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Note {
    /// A point was inserted at once, without a lock.
    Local,
    /// A point was a vertex already.
    Duplicate,
    /// A point was let go: its item is gone.
    Gone,
    /// An operation asks for its closure.
    Began(Ticket),
    /// A request waits for a locked tetrahedron.
    Waits(Ticket),
    /// An operation was set back for the `attempt`-th time.
    SetBack {
        /// The operation.
        ticket: Ticket,
        /// Its setbacks so far, this one included.
        attempt: Attempt,
    },
    /// An operation's cavity is filled.
    Committed {
        /// The operation.
        ticket: Ticket,
        /// Its setbacks.
        setbacks: Attempt,
        /// Workers that had a part of the closure.
        parts: u32,
    },
    /// A block was given away.
    Migrated(BlockId),
    /// All work is done everywhere.
    Stopped,
}

/// A worker of the protocol.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Worker<S: Submesh, Q, C = Correct> {
    pub(crate) config: Config,
    pub(crate) mesh: S,
    pub(super) source: Q,
    pub(crate) directory: Directory,
    /// The largest Lamport clock seen.
    clock: u32,
    /// Tickets issued.
    sequence: u32,
    pub(crate) operations: Operations<S>,
    pub(crate) locks: Locks<S>,
    pub(super) spare: Spare<S>,
    pub(crate) termination: TerminationWave,
    stopped: bool,
    /// Points that arrive are dropped: it was told to start no more.
    pub(super) cancelled: bool,
    /// Some point was dropped.
    pub(super) dropped: bool,
    /// Messages to itself, taken in the same step.
    own: VecDeque<Message<S>>,
    /// Messages about operations so far.
    pub(super) traffic: Standing,
    /// The actions of the step under way.
    pub(super) out: Vec<Action<S>>,
    rules: PhantomData<C>,
}

impl<S: Submesh, Q: Source<S>, C: Rules> Worker<S, Q, C> {
    /// A worker with its submesh, its points, and a directory that is right at the start.
    pub fn new(config: Config, directory: Directory, mesh: S, source: Q) -> Self {
        Self {
            config,
            mesh,
            source,
            termination: TerminationWave::new(directory.me(), config.workers),
            directory,
            clock: 0,
            sequence: 0,
            operations: Operations::new(),
            locks: Locks::new(),
            spare: Spare::new(),
            stopped: false,
            cancelled: false,
            dropped: false,
            own: VecDeque::new(),
            traffic: Standing::default(),
            out: Vec::new(),
            rules: PhantomData,
        }
    }

    /// Its number.
    pub fn id(&self) -> WorkerId {
        self.directory.me()
    }

    /// Its submesh.
    pub fn mesh(&self) -> &S {
        &self.mesh
    }

    /// Its submesh, to take figures from.
    pub fn mesh_mut(&mut self) -> &mut S {
        &mut self.mesh
    }

    /// Its points.
    pub fn source(&self) -> &Q {
        &self.source
    }

    /// Its view of who owns which block.
    pub fn directory(&self) -> &Directory {
        &self.directory
    }

    /// The largest clock of a ticket that it has issued or heard of.
    pub fn clock(&self) -> u32 {
        self.clock
    }

    /// Number of operations at home here.
    pub fn active(&self) -> usize {
        self.operations.all.len()
    }

    /// Is all work done everywhere, as far as this worker knows?
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Why the worker's submesh has failed, if it has. The worker answers no event any more: the
    /// whole run has failed, and whoever runs the workers has to end it.
    pub fn error(&self) -> Option<SubmeshError> {
        self.mesh.error()
    }

    /// Was a point dropped, because of a cancel?
    pub fn has_dropped_points(&self) -> bool {
        self.dropped
    }

    /// Is there no operation at home here, and no point left?
    pub fn is_passive(&self) -> bool {
        self.operations.all.is_empty() && self.source.is_empty()
    }

    /// Would [`Event::Work`] do anything?
    pub fn has_work(&self) -> bool {
        !self.stopped
            && self.error().is_none()
            && (self.has_thoughts()
                || !self.operations.ready.is_empty()
                || self.has_room() && self.source.is_ready()
                || self.is_passive() && self.termination.may_speak())
    }

    fn has_room(&self) -> bool {
        self.operations.all.len() < self.config.window
    }

    /// Is nothing locked, awaited or under way here? So it must be at the end of a run.
    pub fn is_quiescent(&self) -> bool {
        self.is_passive() && self.locks.is_empty()
    }

    /// Takes the worker apart when the run is over.
    pub fn into_parts(self) -> (S, Q, Directory) {
        (self.mesh, self.source, self.directory)
    }

    /// Answers an event. Actions are to be carried out in their order.
    ///
    /// A worker that fails in the step ([`Worker::error`]), or has failed before, wants nothing
    /// done.
    ///
    /// # Panics
    /// If an invariant of the protocol is broken, by a defect of this crate or by a runtime that
    /// does not keep the order of messages: [`Broken`](super::Broken) reads the panic's message.
    /// The worker is of no use afterwards.
    pub fn step(&mut self, event: Event<S>, out: &mut Vec<Action<S>>) {
        if self.error().is_some() {
            return;
        }
        std::mem::swap(&mut self.out, out);
        let before = self.out.len();
        self.answer(event);
        if self.error().is_some() {
            self.out.truncate(before);
        }
        std::mem::swap(&mut self.out, out);
    }

    fn answer(&mut self, event: Event<S>) {
        match event {
            Event::Message { from, message } => {
                if message.is_basic() {
                    self.termination.received::<C>();
                }
                self.count_taken(&message);
                self.receive(from, message);
            }
            Event::Work => self.work(),
            Event::Retry(ticket) => self.retry(ticket),
            Event::Migrate { block, to } => self.migrate(block, to),
            Event::Cancel => self.cancel(),
        }
        // Ends: a message to itself follows from one seed, grant, cavity, commit or release of the
        // step.
        let me = self.id();
        while self.error().is_none() {
            match self.own.pop_front() {
                Some(message) => self.receive(me, message),
                None if self.tell() => {}
                None => break,
            }
        }
    }

    fn receive(&mut self, from: WorkerId, message: Message<S>) {
        if let Some(ticket) = message.ticket() {
            self.clock = self.clock.max(ticket.clock);
        }
        match message {
            // To the home of an operation.
            Message::Walk { ticket, attempt, point, at } => {
                self.walk_in(Start { ticket: Some(ticket), attempt, point }, at);
            }
            Message::Grant { ticket, attempt, answers, pieces, foreign, bounced, moved } => {
                let granted = Granted { answers, pieces, foreign, bounced, moved };
                self.granted(from, ticket, attempt, granted);
            }
            Message::Wound { ticket, attempt } => self.wounded(ticket, attempt),
            Message::Aborted { ticket, attempt } => self.aborted(ticket, attempt),
            Message::Deny { ticket, attempt } => self.denied(ticket, attempt),
            // To the owner of a part of its closure.
            Message::Expand { ticket, attempt, point, seeds, around } => {
                let wants = seeds.into_iter().map(Want::Seed);
                self.request(ticket, Asker { home: from, attempt, point }, wants, around);
            }
            Message::Abort { ticket, attempt } => self.abort(from, ticket, attempt),
            Message::Commit { ticket, patch } => self.commit(ticket, patch),
            // To the owner of a block.
            Message::Migrate { block, epoch, cargo, points } => {
                self.moved_in(block, epoch, cargo, points);
            }
            Message::Stray { block, cargo } => self.stray(block, cargo),
            Message::News(news) => self.source.hear(&mut self.mesh, &self.directory, from, news),
            Message::Token(token) => {
                let pass = self.termination.arrived(from, token);
                self.pass(pass);
            }
            Message::Stop => self.stop(),
        }
    }

    /// One unit of local work: an operation that can start, else a new point, else a word in a
    /// wave of termination detection.
    fn work(&mut self) {
        if self.stopped {
            return;
        }
        if self.has_thoughts() {
            return self.think();
        }
        if self.start_ready() {
            return;
        }
        if self.has_room()
            && let Some(point) = self.source.next(&self.mesh)
        {
            self.start(Start { ticket: None, attempt: Attempt::default(), point }, None);
        } else if self.is_passive() {
            let pass = self.termination.pass();
            self.pass(pass);
        }
    }

    /// Goes on with termination detection.
    fn pass(&mut self, pass: Pass) {
        let (me, workers) = (self.id(), self.config.workers);
        match pass {
            Pass::Nothing => {}
            Pass::Up(to, token) => self.send(to, Message::Token(token)),
            Pass::Again => {
                me.children(workers).for_each(|to| self.send(to, Message::Token(Token::default())));
            }
            Pass::Terminated => {
                // It is worker 0's word.
                (1..workers).for_each(|w| self.send(WorkerId::new(w), Message::Stop));
                self.stop();
            }
        }
    }

    /// Starts no more points, be they here or on their way here.
    fn cancel(&mut self) {
        self.cancelled = true;
        self.dropped |= !self.source.is_empty();
        self.source.clear();
    }

    fn stop(&mut self) {
        invariant!(P10, self.is_quiescent(), "a stop comes too early: {}", self.describe());
        self.stopped = true;
        self.out.push(Action::Note(Note::Stopped));
    }

    /// A new ticket, younger than every ticket seen.
    pub(super) fn ticket(&mut self) -> Ticket {
        self.clock += 1;
        self.sequence += 1;
        Ticket { clock: self.clock, worker: self.id(), sequence: self.sequence }
    }

    /// Sends a message; one to itself is taken at the end of the step.
    pub(super) fn send(&mut self, to: WorkerId, message: Message<S>) {
        if to == self.id() {
            self.own.push_back(message);
            return;
        }
        if message.is_basic() {
            self.termination.sent();
        }
        self.count_sent(&message);
        self.out.push(Action::Send { to, message });
    }
}

impl<S: Submesh, Q: Source<S>, C: Rules> Worker<S, Q, C> {
    /// Where this worker stands.
    pub fn standing(&self) -> Standing {
        Standing { is_passive: self.operations.all.is_empty(), ..self.traffic }
    }

    /// Is the source to think?
    pub(crate) fn has_thoughts(&self) -> bool {
        self.source.has_thoughts(self.standing())
    }

    /// Lets the source think.
    fn think(&mut self) {
        let standing = self.standing();
        self.source.think(&mut self.mesh, &self.directory, standing);
    }

    /// Counts a message that is taken.
    fn count_taken(&mut self, message: &Message<S>) {
        self.traffic.received += u64::from(self.source.counts() && message.is_of_operation());
    }

    /// Counts a message that is sent.
    fn count_sent(&mut self, message: &Message<S>) {
        self.traffic.sent += u64::from(self.source.counts() && message.is_of_operation());
    }

    /// Sends the next thing that the source wants to tell. Returns `false` if there is none.
    fn tell(&mut self) -> bool {
        let next = self.source.tell();
        let is_some = next.is_some();
        if let Some((to, news)) = next {
            self.send(to, Message::News(news));
        }
        is_some
    }
}
