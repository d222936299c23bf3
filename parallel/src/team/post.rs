//! Letters from one member of a team to another.

use crate::mailbox::{Endpoint, Received, connect};
use crate::protocol::WorkerId;
use std::collections::VecDeque;
use std::time::Duration;

/// The kinds of letters. Those of one kind from one sender keep their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Messages of workers.
    Mail,
    /// Messages that are to be late: the time of their sending is at the end.
    Late,
    /// A part of what all members do together.
    Team,
}

/// Whatever carries letters.
pub trait Post {
    /// The number of this member.
    fn me(&self) -> WorkerId;

    /// Number of members.
    fn members(&self) -> u32;

    /// Sends a letter to another member, at the latest with the next [`Post::flush`].
    fn send(&mut self, to: WorkerId, kind: Kind, letter: Vec<u8>);

    /// Lets go of all letters sent.
    fn flush(&mut self);

    /// Takes a letter that has arrived. Never waits.
    fn take(&mut self) -> Option<(WorkerId, Kind, Vec<u8>)>;

    /// Waits until a letter may be there, a member has failed, or the time is over.
    fn wait(&mut self, timeout: Option<Duration>);

    /// An empty letter, with the memory of an old one if there is any.
    fn spare(&mut self) -> Vec<u8> {
        Vec::new()
    }

    /// Takes back the memory of a letter that was read.
    fn keep(&mut self, letter: Vec<u8>) {
        drop(letter);
    }

    /// A member that has failed.
    fn failed(&self) -> Option<WorkerId>;

    /// Tells all others that this one has failed.
    fn fail(&mut self);
}

/// The post of a team of one, to whom nobody writes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Post for Alone {
    fn me(&self) -> WorkerId {
        WorkerId::default()
    }

    fn members(&self) -> u32 {
        1
    }

    fn send(&mut self, _: WorkerId, _: Kind, _: Vec<u8>) {}

    fn flush(&mut self) {}

    fn take(&mut self) -> Option<(WorkerId, Kind, Vec<u8>)> {
        None
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        std::thread::sleep(timeout.unwrap_or_default());
    }

    fn failed(&self) -> Option<WorkerId> {
        None
    }

    fn fail(&mut self) {}
}

/// The post of threads of one process, which share nothing but mailboxes of bytes.
pub struct Threads {
    end: Endpoint<(Kind, Vec<u8>)>,
    arrived: Vec<Received<(Kind, Vec<u8>)>>,
    waiting: VecDeque<(WorkerId, Kind, Vec<u8>)>,
}

impl std::fmt::Debug for Threads {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Threads").field("me", &self.end.id()).finish_non_exhaustive()
    }
}

/// The posts of a team of threads, by member.
pub fn threads(members: u32) -> Vec<Threads> {
    let post = |end| Threads { end, arrived: Vec::new(), waiting: VecDeque::new() };
    connect(members).into_iter().map(post).collect()
}

impl Post for Threads {
    fn me(&self) -> WorkerId {
        self.end.id()
    }

    fn members(&self) -> u32 {
        self.end.workers()
    }

    fn send(&mut self, to: WorkerId, kind: Kind, letter: Vec<u8>) {
        self.end.send(to, (kind, letter));
    }

    fn flush(&mut self) {
        self.end.flush();
    }

    fn take(&mut self) -> Option<(WorkerId, Kind, Vec<u8>)> {
        if self.waiting.is_empty() {
            self.end.try_take(&mut self.arrived);
            let all = self.arrived.drain(..);
            self.waiting
                .extend(all.map(|Received { from, message: (kind, letter) }| (from, kind, letter)));
        }
        self.waiting.pop_front()
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        match timeout {
            _ if !self.waiting.is_empty() => {}
            Some(timeout) => self.end.wait_timeout(timeout),
            None => self.end.wait(),
        }
    }

    fn failed(&self) -> Option<WorkerId> {
        self.end.failed()
    }

    fn fail(&mut self) {
        self.end.fail();
    }
}
