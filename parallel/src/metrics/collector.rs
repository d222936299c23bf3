//! One worker's figures while it runs.

use super::figures::WorkerFigures;
use super::flow::{About, Port};
use super::span::{Span, SpanKind};
use super::{Nanos, SubmeshSize};
use crate::protocol::{Action, Attempt, Event, Message, Note, Submesh, Ticket, WorkerId};
use std::collections::{BTreeMap, HashMap};

/// The event that a step answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// [`Event::Work`].
    Work,
    /// A message of this kind.
    Message {
        /// Its sender.
        from: WorkerId,
        /// [`Message::kind`].
        kind: &'static str,
        /// The operation that it is about; a commit is about the last attempt.
        about: Option<About>,
    },
    /// [`Event::Retry`].
    Retry(Ticket),
    /// [`Event::Migrate`].
    Migrate,
    /// [`Event::Cancel`].
    Cancel,
}

/// Stands for the attempt that succeeded, where a message does not tell its number.
const LAST: Attempt = Attempt::new(u32::MAX);

impl Cause {
    /// The cause that `event` is.
    pub fn of<S: Submesh>(event: &Event<S>) -> Self {
        match event {
            Event::Message { from, message } => {
                Self::Message { from: *from, kind: message.kind(), about: about(message) }
            }
            Event::Work => Self::Work,
            Event::Retry(ticket) => Self::Retry(*ticket),
            Event::Migrate { .. } => Self::Migrate,
            Event::Cancel => Self::Cancel,
        }
    }
}

fn about<S: Submesh>(message: &Message<S>) -> Option<About> {
    match message {
        Message::Walk { ticket, attempt, .. }
        | Message::Expand { ticket, attempt, .. }
        | Message::Grant { ticket, attempt, .. }
        | Message::Deny { ticket, attempt }
        | Message::Wound { ticket, attempt }
        | Message::Abort { ticket, attempt }
        | Message::Aborted { ticket, attempt } => {
            Some(About { ticket: *ticket, attempt: *attempt })
        }
        Message::Commit { ticket, .. } => Some(About { ticket: *ticket, attempt: LAST }),
        Message::Migrate { .. }
        | Message::Stray { .. }
        | Message::News(_)
        | Message::Token(_)
        | Message::Stop => None,
    }
}

/// A step's times, and those of its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Its begin.
    pub begin: Nanos,
    /// Its end.
    pub end: Nanos,
    /// Time spent receiving at the begin and sending; 0 if that was not measured.
    pub communication: Nanos,
    /// Time spent on point location; 0 if that was not measured.
    pub walk: Nanos,
}

/// Time that one attempt of an operation took on one worker.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spent {
    pub(super) all: Nanos,
    /// The part of that time while a cavity of the worker was active.
    pub(super) active: Nanos,
}

/// The end of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    Local,
    Interface,
}

/// Collects one worker's figures. Times must not go back.
#[derive(Clone, Debug)]
pub struct Collector {
    pub(super) figures: WorkerFigures,
    /// Active cavities of this worker.
    active: u32,
    /// Time up to which all is accounted for.
    clock: Nanos,
    /// Idle since the last insertion here.
    idle_since_work: Nanos,
    /// Setbacks so far of operations that were set back here and may start again here.
    attempts: HashMap<Ticket, Attempt>,
    pub(super) spent: HashMap<About, Spent>,
    pub(super) endings: HashMap<Ticket, (Attempt, Ending)>,
    pub(super) messages: BTreeMap<&'static str, (u64, u64)>,
    spans: Option<Vec<Span>>,
    spans_left: usize,
    /// Messages sent and taken, if stretches of time are kept; no more than of these.
    ports: [Vec<Port>; 2],
    ports_left: usize,
}

impl Collector {
    /// A collector for `worker`; it keeps at most `spans` stretches of time for a trace.
    pub fn new(worker: WorkerId, spans: usize) -> Self {
        Self {
            figures: WorkerFigures { worker, ..WorkerFigures::default() },
            active: 0,
            clock: 0,
            idle_since_work: 0,
            attempts: HashMap::new(),
            spent: HashMap::new(),
            endings: HashMap::new(),
            messages: BTreeMap::new(),
            spans: (spans > 0).then(Vec::new),
            spans_left: spans,
            ports: Default::default(),
            ports_left: spans,
        }
    }

    /// Time up to which all is accounted for.
    pub fn clock(&self) -> Nanos {
        self.clock
    }

    /// The worker looked for a message from `begin` to `end`, and found one if `useful`.
    pub fn poll(&mut self, begin: Nanos, end: Nanos, useful: bool) {
        self.idle_until(begin);
        let time = self.advance(end);
        self.figures.times.polling += time;
        let polls = &mut self.figures.polls;
        polls.total += 1;
        polls.total_time += time;
        if useful {
            polls.useful += 1;
            polls.useful_time += time;
        }
        self.count_active(time, self.active > 0);
        self.span(begin, end, SpanKind::Poll, None);
    }

    /// The worker had nothing to do from `begin` to `end` but to look for messages, `looks` times,
    /// in vain.
    pub fn look_on(&mut self, begin: Nanos, end: Nanos, looks: u64) {
        self.idle_until(begin);
        let time = self.advance(end);
        let waits = self.active > 0;
        let times = &mut self.figures.times;
        times.polling += time;
        times.idle_active += if waits { time } else { 0 };
        let polls = &mut self.figures.polls;
        polls.total += looks;
        polls.total_time += time;
        self.idle_since_work += time;
        self.count_active(time, waits);
        self.span(begin, end, SpanKind::Poll, None);
    }

    /// A message of `kind` with `bytes` bytes was sent.
    pub fn sent(&mut self, kind: &'static str, bytes: u64) {
        let (count, sum) = self.messages.entry(kind).or_default();
        *count += 1;
        *sum += bytes;
        self.figures.sent.count += 1;
        self.figures.sent.bytes += bytes;
    }

    /// The worker handed over messages, where a runtime does not do that in the step that sends.
    pub fn communicate(&mut self, begin: Nanos, end: Nanos) {
        self.idle_until(begin);
        let time = self.advance(end);
        self.figures.times.communication += time;
        self.count_active(time, self.active > 0);
        self.span(begin, end, SpanKind::Poll, None);
    }

    /// The worker dealt with messages that are not the protocol's until `end`.
    pub fn control(&mut self, begin: Nanos, end: Nanos) {
        self.idle_until(begin);
        let time = self.advance(end);
        self.figures.times.balancing += time;
        self.count_active(time, self.active > 0);
        self.span(begin, end, SpanKind::Balance, None);
    }

    /// The worker took a step, which ended in `actions`.
    pub fn step<S: Submesh>(&mut self, cause: Cause, step: Step, actions: &[Action<S>]) {
        self.idle_until(step.begin);
        let was_active = self.active > 0;
        if let Cause::Message { kind: "walk", about: Some(about), .. } = cause
            && about.attempt > Attempt::default()
        {
            self.attempts.insert(about.ticket, about.attempt);
        }
        let about = self.about(cause, actions);
        let mut kind = kind_of(cause);
        for action in actions {
            if let Action::Note(note) = action {
                kind = self.note(*note, about, kind);
            }
        }
        let time = self.advance(step.end);
        let active = was_active || self.active > 0;
        self.count_active(time, active);
        let communication = step.communication.min(time);
        let times = &mut self.figures.times;
        match kind {
            SpanKind::Balance => times.balancing += time,
            SpanKind::Poll => times.communication += time,
            _ => {
                times.communication += communication;
                times.meshing += time - communication;
            }
        }
        if let Cause::Message { from, kind, .. } = cause
            && from != self.figures.worker
        {
            self.figures.received += 1;
            if kind == "expand" {
                self.figures.services += 1;
                self.figures.service_time += time;
            }
        }
        let local = matches!(cause, Cause::Work) && about.is_none();
        match about {
            Some(key) => self.spend(key, time, active),
            None if local && actions.iter().any(|a| matches!(a, Action::Note(Note::Local))) => {
                self.figures.times.local += time;
                self.figures.times.local_active += if active { time } else { 0 };
            }
            None => {}
        }
        self.messages(cause, step, actions);
        let walked = step.end.min(step.begin + step.walk);
        self.span(step.begin, walked, SpanKind::Walk, about);
        self.span(walked, step.end, kind, about);
    }

    /// The run is over at `end`; `mesh` is the worker's submesh.
    pub fn finish(&mut self, end: Nanos, mesh: &impl SubmeshSize) {
        self.rest_until(end);
        self.figures.tets = mesh.tets();
        self.figures.interface_faces = mesh.interface_faces();
    }

    /// The worker has ended, and the run lasts until `end`.
    pub fn rest_until(&mut self, end: Nanos) {
        self.idle_until(end);
        self.figures.times.idle_at_end = self.idle_since_work;
    }

    /// The worker's figures so far.
    pub fn figures(&self) -> &WorkerFigures {
        &self.figures
    }

    /// Messages sent and taken in steps that were kept.
    pub(super) fn take_ports(&mut self) -> [Vec<Port>; 2] {
        std::mem::take(&mut self.ports)
    }

    /// Takes the stretches of time that were kept.
    pub fn take_spans(&mut self) -> Vec<Span> {
        self.spans.take().unwrap_or_default()
    }

    /// Was every stretch of time kept, and every message?
    pub fn has_kept_all(&self) -> bool {
        self.spans_left > 0 && self.ports_left > 0
    }

    /// The operation that a step is about.
    fn about<S: Submesh>(&self, cause: Cause, actions: &[Action<S>]) -> Option<About> {
        match cause {
            Cause::Message { about, .. } => about,
            Cause::Retry(ticket) => Some(self.last(ticket)),
            Cause::Migrate | Cause::Cancel => None,
            Cause::Work => actions.iter().find_map(|action| match action {
                Action::Note(Note::Began(ticket)) => Some(self.last(*ticket)),
                Action::Send { message: Message::Walk { ticket, attempt, .. }, .. } => {
                    Some(About { ticket: *ticket, attempt: *attempt })
                }
                _ => None,
            }),
        }
    }

    fn last(&self, ticket: Ticket) -> About {
        About { ticket, attempt: self.attempt(ticket) }
    }

    fn attempt(&self, ticket: Ticket) -> Attempt {
        self.attempts.get(&ticket).copied().unwrap_or_default()
    }

    /// Takes in a note of a step; returns what the step is called in a trace.
    fn note(&mut self, note: Note, about: Option<About>, kind: SpanKind) -> SpanKind {
        let others = self.active;
        match note {
            Note::Local => {
                self.idle_since_work = 0;
                self.figures.cavities.count(false, others > 0);
                if let Some(About { ticket, attempt }) = about {
                    self.attempts.remove(&ticket);
                    self.endings.insert(ticket, (attempt, Ending::Local));
                }
                SpanKind::Fill
            }
            Note::Duplicate | Note::Gone => {
                self.figures.known += 1;
                kind
            }
            Note::Began(_) => {
                self.active += 1;
                SpanKind::Expand
            }
            Note::SetBack { ticket, attempt } => {
                self.active = self.active.saturating_sub(1);
                self.attempts.insert(ticket, attempt);
                self.figures.setbacks += 1;
                self.figures.worst_setbacks = self.figures.worst_setbacks.max(attempt.number());
                SpanKind::Setback
            }
            Note::Committed { ticket, setbacks, parts } => {
                self.active = self.active.saturating_sub(1);
                self.idle_since_work = 0;
                self.attempts.remove(&ticket);
                self.figures.cavities.count(true, others > 1);
                self.figures.closure_parts += u64::from(parts);
                self.endings.insert(ticket, (setbacks, Ending::Interface));
                SpanKind::Fill
            }
            Note::Migrated(_) => {
                self.figures.migrations += 1;
                SpanKind::Balance
            }
            Note::Waits(_) => {
                self.figures.waits += 1;
                kind
            }
            Note::Stopped => kind,
        }
    }

    /// Keeps the ends of a step's messages about operations, as long as there is room for its time.
    fn messages<S: Submesh>(&mut self, cause: Cause, step: Step, actions: &[Action<S>]) {
        // A step without length has no stretch that an arrow could begin or end in.
        if self.spans.is_none() || self.spans_left < 2 || step.begin >= step.end {
            return;
        }
        let me = self.figures.worker;
        let step = (step.begin, step.end);
        if let Cause::Message { from, kind, about: Some(about) } = cause {
            self.port(1, Port { from, to: me, kind, about, step });
        }
        for action in actions {
            if let Action::Send { to, message } = action
                && let Some(about) = about(message)
            {
                self.port(0, Port { from: me, to: *to, kind: message.kind(), about, step });
            }
        }
    }

    fn port(&mut self, end: usize, port: Port) {
        if self.ports_left > 0 {
            self.ports_left -= 1;
            self.ports[end].push(port);
        }
    }

    fn spend(&mut self, key: About, time: Nanos, active: bool) {
        let spent = self.spent.entry(key).or_default();
        spent.all += time;
        spent.active += if active { time } else { 0 };
    }

    /// Accounts for the time up to `end`; returns how much that is.
    fn advance(&mut self, end: Nanos) -> Nanos {
        let time = end.saturating_sub(self.clock);
        self.clock += time;
        time
    }

    fn idle_until(&mut self, begin: Nanos) {
        let from = self.clock;
        let time = self.advance(begin);
        if time == 0 {
            return;
        }
        let waits = self.active > 0;
        self.figures.times.idle += time;
        self.figures.times.idle_active += if waits { time } else { 0 };
        self.idle_since_work += time;
        self.count_active(time, waits);
        self.span(from, begin, if waits { SpanKind::Wait } else { SpanKind::Idle }, None);
    }

    fn count_active(&mut self, time: Nanos, active: bool) {
        self.figures.times.active += if active { time } else { 0 };
    }

    fn span(&mut self, begin: Nanos, end: Nanos, kind: SpanKind, about: Option<About>) {
        let Some(spans) = &mut self.spans else { return };
        if begin < end && self.spans_left > 0 {
            self.spans_left -= 1;
            let ticket = about.map(|about| about.ticket);
            spans.push(Span { worker: self.figures.worker, begin, end, kind, ticket });
        }
    }
}

/// The name of a step in a trace if no note says better.
fn kind_of(cause: Cause) -> SpanKind {
    match cause {
        Cause::Message { kind, .. } => match kind {
            "walk" => SpanKind::Walk,
            "expand" | "grant" => SpanKind::Expand,
            "commit" => SpanKind::Fill,
            "deny" | "wound" | "abort" | "aborted" => SpanKind::Setback,
            "migrate" | "stray" => SpanKind::Balance,
            _ => SpanKind::Poll,
        },
        Cause::Work => SpanKind::Walk,
        Cause::Retry(_) => SpanKind::Setback,
        Cause::Migrate => SpanKind::Balance,
        Cause::Cancel => SpanKind::Poll,
    }
}
