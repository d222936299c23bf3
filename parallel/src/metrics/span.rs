//! Stretches of a worker's time, by what it was busy with.

use super::Nanos;
use crate::protocol::{Ticket, WorkerId};

/// A worker's occupation in a stretch of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SpanKind {
    /// Point location.
    Walk,
    /// A closure is asked for, locked or collected.
    Expand,
    /// No message and no local work, while a cavity of the worker is active.
    Wait,
    /// A cavity is filled: a local one, or a part of one on an interface.
    Fill,
    /// A cavity is set back.
    Setback,
    /// The worker looks for messages, or takes one that is about termination.
    Poll,
    /// Blocks change their owner.
    Balance,
    /// No message, no local work, no cavity active.
    Idle,
}

impl SpanKind {
    /// Its name in a trace.
    pub fn name(self) -> &'static str {
        match self {
            Self::Walk => "walk",
            Self::Expand => "expand",
            Self::Wait => "wait",
            Self::Fill => "fill",
            Self::Setback => "setback",
            Self::Poll => "poll",
            Self::Balance => "balance",
            Self::Idle => "idle",
        }
    }
}

/// A stretch of a worker's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The worker.
    pub worker: WorkerId,
    /// Its begin.
    pub begin: Nanos,
    /// Its end.
    pub end: Nanos,
    /// Its occupation.
    pub kind: SpanKind,
    /// The operation that it was about.
    pub ticket: Option<Ticket>,
}
