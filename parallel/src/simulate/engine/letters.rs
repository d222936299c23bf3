//! Messages on their way out: each leaves at once, or with those of its turn.

use super::super::event::What;
use super::super::processor::{Envelope, Processor};
use super::Engine;
use crate::balance::Workload;
use crate::check::Inspect;
use crate::metrics::{Nanos, SubmeshSize};
use crate::payload::Payload;
use crate::protocol::{Action, Rules, Source, Submesh, WorkerId};

impl<S, Q, C> Engine<'_, S, Q, C>
where
    S: Payload + SubmeshSize + Inspect,
    Q: Source<S> + Workload,
    C: Rules,
{
    /// A message leaves.
    pub(super) fn post(&mut self, to: WorkerId, envelope: Envelope<S>, time: Nanos) {
        let arrival = self.links.arrival(envelope.from, to, time, envelope.bytes);
        self.at(arrival, What::Arrive(to, envelope));
    }

    /// A turn is over: the messages of it leave.
    pub(super) fn flush(&mut self, id: WorkerId) {
        let mut letters = std::mem::take(&mut self.processors[id.index()].letters);
        for (to, envelope) in letters.drain(..) {
            self.post(to, envelope, self.now);
        }
        self.processors[id.index()].letters = letters;
    }
}

impl<S: Submesh, Q, C> Processor<S, Q, C> {
    /// Is there a letter to `to` already, by what was sent in this turn and `before` in this step?
    pub(super) fn has_letter(&self, to: WorkerId, before: &[Action<S>]) -> bool {
        let is_to_it =
            |own: &Action<S>| matches!(own, Action::Send { to: other, .. } if *other == to);
        self.letters.iter().any(|own| own.0 == to) || before.iter().any(is_to_it)
    }
}
