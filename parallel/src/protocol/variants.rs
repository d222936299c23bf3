//! The steps of the paper's variants, kept to be compared with: its conflict rule and its closure
//! (`config`). (Its third one, that the creator owns a tetrahedron, is `mesh::Ownership::Creator`.)
//!
//! Nothing here runs by default. `docs/protocol-variants.md` describes them and says what they
//! cost. The main code calls this module at five places: where an operation meets a lock at its
//! home, where its cavity is complete, where a request is asked for more, where it locks, and where
//! it meets a lock.

use super::config::Closure;
use super::invariant::invariant;
use super::rules::Rules;
use super::state::{Phase, Request, want};
use super::submesh::{Insert, Source, Submesh};
use super::worker::Worker;
use super::{Attempt, Message, Ticket, WorkerId};

impl<S: Submesh, Q: Source<S>, C: Rules> Worker<S, Q, C> {
    /// The paper's rule knows no waiting: a request that meets a lock is denied.
    pub(super) fn deny(&mut self, ticket: Ticket, request: &Request<S>) {
        let attempt = request.attempt;
        self.send(request.home, Message::Deny { ticket, attempt });
    }

    /// A request was denied: the operation is set back, unless another one's denial did it.
    pub(super) fn denied(&mut self, ticket: Ticket, attempt: Attempt) {
        if self.operation(ticket, attempt).phase == Phase::Expanding {
            self.set_back(ticket);
        }
    }

    /// The backoff of a denied operation is over. A runtime that is late is forgiven.
    pub(super) fn retry(&mut self, ticket: Ticket) {
        let op = self.operations.all.get(&ticket);
        if op.is_some_and(|op| op.phase == Phase::Backoff) {
            self.make_ready(ticket);
        }
    }

    /// The obstacle in the vertex closure of a local insertion.
    pub(super) fn in_the_way(&mut self, point: &S::Point, seed: S::Tet) -> Option<Insert<S::Tet>> {
        match self.config.closure {
            Closure::Face => None,
            Closure::Vertex => self.mesh.in_the_way(point, seed),
        }
    }

    /// The cavity is complete: all that touches it is asked for, too, unless that was done.
    /// `false`: nothing more is to be locked.
    pub(super) fn surround(&mut self, ticket: Ticket) -> bool {
        let Some(op) = self.operations.all.get_mut(&ticket) else {
            invariant!(P8, "{ticket:?} is complete and gone")
        };
        if self.config.closure == Closure::Face || !op.around.is_empty() {
            return false;
        }
        op.around = S::corners(op.parts.entries());
        if op.around.is_empty() {
            return false;
        }
        let asked: Vec<WorkerId> = op.asked.keys().collect();
        for &worker in &asked {
            *op.asked.entry(worker, || 0) += 1;
        }
        let (attempt, point, around) = (op.attempt, op.point.clone(), op.around.clone());
        for worker in asked {
            let (point, around) = (point.clone(), around.clone());
            let seeds = Vec::new();
            self.send(worker, Message::Expand { ticket, attempt, point, seeds, around });
        }
        true
    }

    /// Tells a request the cavity's vertices: what touches them across a face is wanted.
    pub(super) fn widen(&mut self, ticket: Ticket, vertices: Vec<u64>) {
        let Some(request) = self.locks.requests.get_mut(&ticket) else {
            invariant!(P8, "a request of {ticket:?} is to widen and gone")
        };
        if !request.around.is_empty() || vertices.is_empty() {
            return;
        }
        request.around = vertices;
        let Request { held, wants, foreign, around, .. } = &mut **request;
        for &t in &*held {
            self.mesh.neighbours_around(t, around, |n| want(n, wants, foreign));
        }
    }

    /// Locks without a test a tetrahedron that touches the cavity.
    pub(super) fn lock_around(&mut self, ticket: Ticket, request: &mut Request<S>, t: S::Tet) {
        self.mesh.lock(t, ticket, false);
        request.held.push(t);
        let Request { wants, foreign, around, .. } = request;
        self.mesh.neighbours_around(t, around, |n| want(n, wants, foreign));
    }
}
