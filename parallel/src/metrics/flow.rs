//! Messages between workers, from the step that sends one to the step that takes it.

use super::Nanos;
use crate::protocol::{Attempt, Ticket, WorkerId};

/// A message about an operation, sent and taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flow {
    /// The name of its kind.
    pub kind: &'static str,
    /// The operation.
    pub ticket: Ticket,
    /// The sender.
    pub from: WorkerId,
    /// The receiver.
    pub to: WorkerId,
    /// A time in the step that sent it.
    pub sent: Nanos,
    /// The begin of the step that took it, not before it was sent.
    pub taken: Nanos,
}

/// The attempt of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct About {
    /// The operation.
    pub ticket: Ticket,
    /// The number of the attempt.
    pub attempt: Attempt,
}

/// One end of a message. Messages of one sender arrive in the order in which they were sent, so the
/// n-th of a key that is sent is the n-th that is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Port {
    pub(super) from: WorkerId,
    pub(super) to: WorkerId,
    pub(super) kind: &'static str,
    pub(super) about: About,
    /// The step's begin and end.
    pub(super) step: (Nanos, Nanos),
}

impl Port {
    fn key(&self) -> (WorkerId, WorkerId, &'static str, About) {
        (self.from, self.to, self.kind, self.about)
    }
}

/// Messages of which both ends are known, by the time at which they were sent.
pub(super) fn join(mut sent: Vec<Port>, mut taken: Vec<Port>) -> Vec<Flow> {
    // Each list has the ports of a worker in the order of time, which the sorts keep.
    sent.sort_by_key(Port::key);
    taken.sort_by_key(Port::key);
    let mut flows = Vec::with_capacity(sent.len().min(taken.len()));
    let mut ends = taken.iter().peekable();
    for start in &sent {
        while ends.next_if(|end| end.key() < start.key()).is_some() {}
        let Some(end) = ends.next_if(|end| end.key() == start.key()) else { continue };
        // A message may be taken before the step that sent it and others is over.
        let last = start.step.1.saturating_sub(1).min(end.step.0);
        flows.push(Flow {
            kind: start.kind,
            ticket: start.about.ticket,
            from: start.from,
            to: start.to,
            sent: last.max(start.step.0),
            taken: end.step.0,
        });
    }
    flows.sort_by_key(|flow| (flow.sent, flow.from, flow.taken, flow.to));
    flows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nth_message_sent_is_the_nth_taken_and_one_without_an_end_is_left_out() {
        let ticket = |sequence| Ticket { clock: 1, worker: WorkerId::default(), sequence };
        let port = |kind, sequence, begin| Port {
            from: WorkerId::default(),
            to: WorkerId::new(1),
            kind,
            about: About { ticket: ticket(sequence), attempt: Attempt::default() },
            step: (begin, begin + 10),
        };
        let sent = vec![port("expand", 1, 0), port("expand", 2, 20), port("expand", 1, 40)];
        let taken = vec![port("commit", 1, 5), port("expand", 1, 4), port("expand", 1, 70)];
        let flows = join(sent, taken);
        let times: Vec<_> = flows.iter().map(|f| (f.ticket.sequence, f.sent, f.taken)).collect();
        // The first is taken before its step is over; nobody takes the second.
        assert_eq!(times, [(1, 4, 4), (1, 49, 70)]);
    }
}
