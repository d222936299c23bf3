//! Lock requests: the owner's side. Locks, tests and grants, one request for each operation that
//! has a part of its closure here.
//!
//! `docs/protocol.md`, *The owner*, is the table of states and events that this file follows, with
//! the pseudocode of `advance`, `grant`, `release` and `wake`.

use super::config::Rule;
use super::directory::{BlockId, WorkerId};
use super::invariant::invariant;
use super::rules::Rules;
use super::state::{Asker, Request, Waiter, Want, want};
use super::submesh::{Found, Source, Submesh};
use super::worker::{Action, Note, Worker};
use super::{Attempt, Message, Ticket};
use std::collections::BTreeMap;

impl<S: Submesh, Q: Source<S>, C: Rules> Worker<S, Q, C> {
    /// `Expand`: adds to the request of `ticket`, or makes one.
    pub(super) fn request(
        &mut self,
        ticket: Ticket,
        asker: Asker<S::Point>,
        wants: impl IntoIterator<Item = Want<S::Tet>>,
        around: Vec<u64>,
    ) {
        let (home, attempt) = (asker.home, asker.attempt);
        let spare = &mut self.spare.requests;
        let request = self.locks.requests.entry(ticket).or_insert_with(|| match spare.pop() {
            Some(ended) => ended.renew(asker),
            None => Request::new(asker),
        });
        invariant!(
            P8,
            request.home == home && request.attempt == attempt,
            "{home} asks for attempt {attempt} of {ticket:?}; here is {}",
            request.describe()
        );
        // R5: a stalled request waits for the last of its wants, and keeps its place in that queue.
        let first = request.wants.pop_if(|_| C::keeps_place() && request.stalled);
        request.wants.extend(wants);
        request.wants.extend(first);
        request.owed += 1;
        let is_stalled = request.stalled;
        if !around.is_empty() {
            self.widen(ticket, around);
        }
        if !is_stalled {
            self.advance(ticket);
        }
    }

    /// Locks and tests until nothing is wanted or something is in the way. Ends: every tetrahedron
    /// is locked once, and each adds at most four to what is wanted (with the vertex closure, the
    /// cavity and its ring once more).
    pub(super) fn advance(&mut self, ticket: Ticket) {
        let Some(mut request) = self.locks.requests.remove(&ticket) else {
            invariant!(P7, "a request of {ticket:?} is woken and gone")
        };
        request.stalled = false;
        // A search at once that meets a lock changes nothing. Then the rest is locked one by one,
        // and so it is when the request goes on: else every wake-up would search in vain.
        // (It locks the ring, R1.)
        let mut at_once = C::locks_ring() && request.held.is_empty();
        while let Some(want) = request.wants.pop() {
            let t = match want {
                Want::Tet(t) => t,
                Want::Seed(seed) if !self.directory.is_mine(seed.block) => {
                    // R10
                    if C::forwards() {
                        request.bounced.push(seed);
                    }
                    continue;
                }
                Want::Seed(seed) => match self.mesh.resolve(seed.name) {
                    Some(t) => t,
                    // R14
                    None if !C::awaits_installation() => continue,
                    None => {
                        let queue = self.locks.absent.entry(seed.name).or_default();
                        queue.push(Waiter::Request(ticket));
                        request.wants.push(want);
                        request.stalled = true;
                        break;
                    }
                },
            };
            match self.mesh.holder(t) {
                Some(holder) if holder == ticket => {}
                Some(holder) => {
                    request.wants.push(want);
                    request.stalled = true;
                    self.conflict(ticket, &request, t, holder);
                    break;
                }
                None => {
                    at_once = at_once && self.take_all(ticket, &mut request, t);
                    if !at_once {
                        self.take(ticket, &mut request, t);
                    }
                }
            }
        }
        if !request.stalled {
            self.grant(ticket, &mut request);
        }
        self.locks.requests.insert(ticket, request);
    }

    /// Locks and tests all that follows from a tetrahedron that is free, if all of it is free.
    fn take_all(&mut self, ticket: Ticket, request: &mut Request<S>, t: S::Tet) -> bool {
        let Request { point, held, pieces, foreign, around, .. } = request;
        around.is_empty()
            && self.mesh.lock_all(t, point, ticket, &mut Found { held, pieces, foreign })
    }

    /// Locks and tests a tetrahedron that is free.
    fn take(&mut self, ticket: Ticket, request: &mut Request<S>, t: S::Tet) {
        if !request.around.is_empty() {
            self.lock_around(ticket, request, t);
            return;
        }
        let in_conflict = self.mesh.in_conflict(t, &request.point);
        // R1
        if in_conflict || C::locks_ring() {
            self.mesh.lock(t, ticket, in_conflict);
            request.held.push(t);
        }
        if in_conflict {
            request.cavity.push(t);
            let Request { wants, foreign, .. } = request;
            self.mesh.neighbours(t, |n| want(n, wants, foreign));
        }
    }

    fn grant(&mut self, ticket: Ticket, request: &mut Request<S>) {
        let mut pieces = std::mem::take(&mut request.pieces);
        pieces.extend(self.mesh.pieces(&request.cavity));
        request.cavity.clear();
        let bounced = std::mem::take(&mut request.bounced);
        let mut blocks: Vec<BlockId> = bounced.iter().map(|h| h.block).collect();
        blocks.sort_unstable();
        blocks.dedup();
        let news = |b| (b, self.directory.owner(b), self.directory.epoch(b));
        let message = Message::Grant {
            ticket,
            attempt: request.attempt,
            answers: std::mem::take(&mut request.owed),
            pieces,
            foreign: request.foreign.drain(..).collect(),
            bounced,
            moved: blocks.into_iter().map(news).collect(),
        };
        self.send(request.home, message);
    }

    /// `request` has met tetrahedron `t`, locked by `holder`: it waits, and if it is older the
    /// holder's home is told, once for each of the holder's attempts.
    fn conflict(&mut self, ticket: Ticket, request: &Request<S>, t: S::Tet, holder: Ticket) {
        if self.config.rule == Rule::Paper {
            self.deny(ticket, request);
            return;
        }
        self.out.push(Action::Note(Note::Waits(ticket)));
        self.locks.waiting.entry(t).or_default().push(Waiter::Request(ticket));
        let Some(other) = self.locks.requests.get_mut(&holder) else {
            invariant!(P5, "{t:?} is locked by {holder:?}, which has no request here")
        };
        if ticket < holder && !std::mem::replace(&mut other.wounded, true) {
            let (home, attempt) = (other.home, other.attempt);
            self.send(home, Message::Wound { ticket: holder, attempt });
        }
    }

    /// `Abort`: the operation is set back.
    pub(super) fn abort(&mut self, from: WorkerId, ticket: Ticket, attempt: Attempt) {
        let mut request = match self.locks.requests.remove(&ticket) {
            Some(request) if request.attempt == attempt => request,
            Some(request) => invariant!(
                P8,
                "attempt {attempt} of {ticket:?} is aborted; here is {}",
                request.describe()
            ),
            None => invariant!(P8, "{ticket:?} is aborted, which has no request here"),
        };
        let me = Waiter::Request(ticket);
        forget(&mut self.locks.waiting, me);
        forget(&mut self.locks.absent, me);
        // R2
        if !C::releases_all() {
            request.held.pop();
        }
        let woken = self.unlock(&request.held);
        // R3
        if C::wakes_on_abort() {
            self.wake(woken);
        }
        self.spare.put(request);
        self.send(from, Message::Aborted { ticket, attempt });
    }

    /// `Commit`: the cavity is replaced and its closure unlocked.
    pub(super) fn commit(&mut self, ticket: Ticket, patch: Option<S::Patch>) {
        let request = self.locks.requests.remove(&ticket);
        let mut woken = match &request {
            Some(request) => self.unlock(&request.held),
            None => Vec::new(),
        };
        if let Some(request) = &request {
            let whole = request.wants.is_empty() && request.owed == 0;
            invariant!(P8, whole, "{ticket:?} commits; here is {}", request.describe());
        } else {
            invariant!(P8, patch.is_some(), "{ticket:?} commits, and has nothing here");
        }
        if let Some(patch) = patch {
            let (made, mut strays) = (&mut self.spare.made, Vec::new());
            made.clear();
            self.mesh.apply::<C>(patch, &self.directory, made, &mut strays);
            if Q::WATCHES {
                self.source.created(&self.mesh, self.mesh.installed());
            }
            if !self.locks.absent.is_empty() {
                let awaited = made.iter().filter_map(|name| self.locks.absent.remove(name));
                woken.extend(awaited.flatten());
            }
            strays.sort_unstable();
            strays.dedup();
            for block in strays {
                self.send_stray(block);
            }
        }
        if let Some(request) = request {
            if request.home == self.id() {
                self.source.inserted(&self.mesh, &request.point);
            }
            self.spare.put(request);
        }
        self.wake(woken);
    }

    /// Unlocks tetrahedra; returns who waits for them (R4: everybody).
    fn unlock(&mut self, held: &[S::Tet]) -> Vec<Waiter> {
        let mut woken = Vec::new();
        for &t in held {
            self.mesh.set_holder(t, None);
            if self.locks.waiting.is_empty() {
                continue;
            }
            let Some(queue) = self.locks.waiting.get_mut(&t) else { continue };
            if C::regrant_asks_all() {
                woken.append(queue);
            } else if let Some(first) = (0..queue.len()).min_by_key(|&k| queue[k]) {
                woken.push(queue.swap_remove(first));
            }
            if queue.is_empty() {
                self.locks.waiting.remove(&t);
            }
        }
        woken
    }

    /// Waiting walks and requests go on, the oldest first.
    pub(super) fn wake(&mut self, mut woken: Vec<Waiter>) {
        woken.sort_unstable_by_key(|waiter| match waiter {
            Waiter::Walk(ticket) | Waiter::Request(ticket) => *ticket,
        });
        for waiter in woken {
            match waiter {
                Waiter::Walk(ticket) => self.make_ready(ticket),
                Waiter::Request(ticket) => self.advance(ticket),
            }
        }
    }
}

/// Removes `waiter` from all queues.
fn forget<K: Ord + Copy>(queues: &mut BTreeMap<K, Vec<Waiter>>, waiter: Waiter) {
    queues.retain(|_, queue| {
        queue.retain(|&w| w != waiter);
        !queue.is_empty()
    });
}
