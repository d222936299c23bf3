//! Blocks that change their owner: the paper's mobile objects.
//!
//! A block moves only while none of its tetrahedra is locked, so that no closure ever changes its
//! whereabouts. Handles hold names and blocks, never places: nothing is renamed. A worker that gave
//! a block away knows where it went: a seed for it is bounced to its home with the news, a walk
//! and late tetrahedra are sent after it.

use super::directory::{BlockId, WorkerId};
use super::invariant::invariant;
use super::rules::Rules;
use super::state::{Waiter, Want};
use super::submesh::{Source, Submesh};
use super::worker::{Action, Note, Worker};
use super::{Handle, Message, Name};
use std::collections::BTreeMap;

impl<S: Submesh, Q: Source<S>, C: Rules> Worker<S, Q, C> {
    /// May `block` be given away now?
    pub fn can_migrate(&self, block: BlockId) -> bool {
        self.directory.is_mine(block)
            // R9
            && (!C::only_busy_migrate() || !self.is_passive())
            && !self.is_stopped()
            && !self.mesh.is_block_locked(block)
    }

    /// Gives `block` to worker `to`, if that is allowed now.
    pub(super) fn migrate(&mut self, block: BlockId, to: WorkerId) {
        if to == self.id() || to.number() >= self.config.workers || !self.can_migrate(block) {
            return;
        }
        let cargo = self.take_out(block);
        let epoch = self.directory.epoch(block) + 1;
        self.directory.learn(block, to, epoch);
        let points = self.source.remove_block(&self.mesh, block);
        self.out.push(Action::Note(Note::Migrated(block)));
        self.send(to, Message::Migrate { block, epoch, cargo, points });
        // R11
        if C::moves_waiters() {
            let woken = self.waiters_for(block);
            self.wake(woken);
        }
    }

    /// Extracts the tetrahedra of `block`; what requests still want of them is far now. Such a
    /// want is a near neighbour of what a request has locked: in a submesh where a locked neighbour
    /// keeps the block from moving ([`Submesh::is_block_locked`]) there is none.
    fn take_out(&mut self, block: BlockId) -> S::Cargo {
        let mut handles: BTreeMap<S::Tet, Handle> = BTreeMap::new();
        let cargo = self.mesh.extract::<C>(block, &mut |t, handle| {
            handles.insert(t, handle);
        });
        for request in self.locks.requests.values_mut() {
            let foreign = &mut request.foreign;
            request.wants.retain(|want| {
                let handle = match want {
                    Want::Tet(t) => handles.get(t),
                    Want::Seed(_) => None,
                };
                foreign.extend(handle);
                handle.is_none()
            });
        }
        cargo
    }

    /// Takes those out of the queues that wait for a tetrahedron of `block` to be installed, or
    /// for one whose block is not known here: they find out anew.
    fn waiters_for(&mut self, block: BlockId) -> Vec<Waiter> {
        let requests = &self.locks.requests;
        let concerned = |name: &Name, waiter: &Waiter| match waiter {
            Waiter::Walk(_) => true,
            Waiter::Request(ticket) => {
                let Some(request) = requests.get(ticket) else {
                    invariant!(P7, "{ticket:?} awaits {name:?} and has no request here")
                };
                request.wants.iter().any(
                    |want| matches!(want, Want::Seed(h) if h.name == *name && h.block == block),
                )
            }
        };
        let mut woken = Vec::new();
        self.locks.absent.retain(|name, queue| {
            woken.extend(queue.extract_if(.., |waiter| concerned(name, waiter)));
            !queue.is_empty()
        });
        woken
    }

    /// A block arrives.
    pub(super) fn moved_in(
        &mut self,
        block: BlockId,
        epoch: u32,
        cargo: S::Cargo,
        points: Vec<S::Point>,
    ) {
        let me = self.id();
        let known = self.directory.epoch(block);
        invariant!(P3, epoch > known, "block {block} arrives in epoch {epoch}; it has had {known}");
        self.directory.learn(block, me, epoch);
        // R15
        if self.cancelled && C::stays_cancelled() {
            self.dropped |= !points.is_empty();
        } else {
            self.source.add(block, points);
        }
        self.install(cargo);
    }

    /// Tetrahedra of a block that were made where it had been: they are at home here, or go on
    /// (R10).
    pub(super) fn stray(&mut self, block: BlockId, cargo: S::Cargo) {
        if self.directory.is_mine(block) {
            self.install(cargo);
        } else if C::forwards() {
            self.send(self.directory.owner(block), Message::Stray { block, cargo });
        }
    }

    /// Sends new tetrahedra of `block`, which has moved, after it.
    pub(super) fn send_stray(&mut self, block: BlockId) {
        let cargo = self.take_out(block);
        self.stray(block, cargo);
    }

    fn install(&mut self, cargo: S::Cargo) {
        let mut made = Vec::new();
        self.mesh.adopt(cargo, &mut made);
        if Q::WATCHES {
            self.source.created(&self.mesh, self.mesh.installed());
        }
        let woken: Vec<Waiter> =
            made.into_iter().filter_map(|name| self.locks.absent.remove(&name)).flatten().collect();
        self.wake(woken);
    }
}
