//! The view of model checkers, and how they fold runs that differ in a counter only.

use crate::protocol::{Attempt, Message, Rules, Source, Submesh, Ticket, Waiter, Worker, WorkerId};

/// An operation at its home as checkers see it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OperationView {
    /// Its state, by its name on the page.
    pub state: String,
    /// Its attempt.
    pub attempt: Attempt,
    /// The workers asked in it.
    pub asked: Vec<WorkerId>,
}

/// A request as checkers see it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RequestView<T> {
    /// Its attempt.
    pub attempt: Attempt,
    /// `Expand` not answered yet.
    pub owed: u32,
    /// Does it wait?
    pub stalled: bool,
    /// The number of tetrahedra that it wants.
    pub wants: usize,
    /// The tetrahedra that it has locked.
    pub held: Vec<T>,
}

impl<S: Submesh, Q: Source<S>, C: Rules> Worker<S, Q, C> {
    /// The worker's state, for people who look at a run that makes no progress.
    pub fn describe(&self) -> String {
        let ops = self.operations.all.iter().map(|(ticket, op)| {
            format!("\n  operation {ticket:?}: attempt {}, {:?}", op.attempt, op.phase)
        });
        let requests = self.locks.requests.iter();
        let requests =
            requests.map(|(ticket, r)| format!("\n  request {ticket:?}: {}", r.describe()));
        let absent = self.locks.absent.keys().map(|name| format!("\n  awaits {name:?}"));
        format!(
            "worker {}: {}{}",
            self.id(),
            self.source().describe(),
            ops.chain(requests).chain(absent).collect::<String>()
        )
    }

    /// Is an operation of this ticket at home here, and not committed yet?
    pub fn is_home_of(&self, ticket: Ticket) -> bool {
        self.operations.all.contains_key(&ticket)
    }

    /// Does a request wait for a tetrahedron that is not installed yet?
    pub fn awaits_installation(&self) -> bool {
        self.locks.absent.values().flatten().any(|waiter| matches!(waiter, Waiter::Request(_)))
    }

    /// Calls `f` with every locked tetrahedron that a request waits for, and its ticket.
    pub fn visit_waiting(&self, f: &mut dyn FnMut(S::Tet, Ticket)) {
        for (&t, queue) in &self.locks.waiting {
            for waiter in queue {
                if let Waiter::Request(ticket) = *waiter {
                    f(t, ticket);
                }
            }
        }
    }

    /// The operations at home here.
    pub fn operations(&self) -> impl Iterator<Item = Ticket> + '_ {
        self.operations.all.keys().copied()
    }

    /// The operations that have a request here.
    pub fn requests(&self) -> impl Iterator<Item = Ticket> + '_ {
        self.locks.requests.keys().copied()
    }

    /// An operation at home here.
    pub fn operation_of(&self, ticket: Ticket) -> Option<OperationView> {
        let op = self.operations.all.get(&ticket)?;
        let (state, asked) = (format!("{:?}", op.phase), op.asked.keys().collect());
        Some(OperationView { state, attempt: op.attempt, asked })
    }

    /// The request of an operation here.
    pub fn request_of(&self, ticket: Ticket) -> Option<RequestView<S::Tet>> {
        let request = self.locks.requests.get(&ticket)?;
        Some(RequestView {
            attempt: request.attempt,
            owed: request.owed,
            stalled: request.stalled,
            wants: request.wants.len(),
            held: request.held.clone(),
        })
    }

    /// Has an operation of this ticket a request here?
    pub fn has_request(&self, ticket: Ticket) -> bool {
        self.locks.requests.contains_key(&ticket)
    }

    /// Calls `f` with every attempt number in the worker's state. Attempts are only ever compared
    /// for equality with others of the same ticket: shifting all those of a ticket by the same
    /// amount, here and in all messages, changes no behaviour.
    pub fn visit_attempts(&mut self, f: &mut dyn FnMut(Ticket, &mut Attempt)) {
        for (&ticket, op) in &mut self.operations.all {
            f(ticket, &mut op.attempt);
        }
        for (&ticket, request) in &mut self.locks.requests {
            f(ticket, &mut request.attempt);
        }
    }

    /// Forgets the message counts and colours of termination detection, for models that do not
    /// run it.
    pub fn forget_counts(&mut self) {
        self.termination.forget();
    }
}

impl<S: Submesh> Message<S> {
    /// The attempt number that it carries, with its ticket.
    pub fn attempt_mut(&mut self) -> Option<(Ticket, &mut Attempt)> {
        match self {
            Self::Walk { ticket, attempt, .. }
            | Self::Expand { ticket, attempt, .. }
            | Self::Grant { ticket, attempt, .. }
            | Self::Deny { ticket, attempt }
            | Self::Wound { ticket, attempt }
            | Self::Abort { ticket, attempt }
            | Self::Aborted { ticket, attempt } => Some((*ticket, attempt)),
            Self::Commit { .. }
            | Self::Migrate { .. }
            | Self::Stray { .. }
            | Self::News(_)
            | Self::Token(_)
            | Self::Stop => None,
        }
    }
}
