//! Teams of threads whose letters are bytes: what processes do, in one process.

use ltbw::Point;
use ltbw::distributed::{Slice, SliceError};
use ltbw::protocol::WorkerId;
use ltbw::team::{Kind, Post, Team, Threads, threads};
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

/// Runs every member of a team on a thread of its own; what comes of it, by member.
///
/// # Panics
/// If a member does.
pub fn on_team<R: Send>(members: u32, member: impl Fn(&mut Team) -> R + Sync) -> Vec<R> {
    std::thread::scope(|scope| {
        let member = &member;
        let run = |post| scope.spawn(move || member(&mut Team::new(post)));
        let all: Vec<_> = threads(members).into_iter().map(run).collect();
        all.into_iter().map(|thread| thread.join().expect("no member panics")).collect()
    })
}

/// A member's slice of points that a test has all of: of about the size of any other one.
///
/// # Errors
/// As [`Slice::new`].
pub fn try_slice(team: &mut Team, points: &[Point]) -> Result<Slice, SliceError> {
    let end = |k: usize| k * points.len() / team.size() as usize;
    let me = team.me().index();
    let own = points[end(me)..end(me + 1)].to_vec();
    Slice::new(team, own)
}

/// As [`try_slice`], of sound points.
///
/// # Panics
/// If they are not.
pub fn slice_of(team: &mut Team, points: &[Point]) -> Slice {
    try_slice(team, points).expect("finite points")
}

/// A post that gives away a copy of each letter of a kind that it sends.
struct Recorded {
    inner: Threads,
    kind: Kind,
    letters: Sender<Vec<u8>>,
}

impl Post for Recorded {
    fn me(&self) -> WorkerId {
        self.inner.me()
    }

    fn members(&self) -> u32 {
        self.inner.members()
    }

    fn send(&mut self, to: WorkerId, kind: Kind, letter: Vec<u8>) {
        if kind == self.kind {
            // The receiver is gone if a member has panicked.
            _ = self.letters.send(letter.clone());
        }
        self.inner.send(to, kind, letter);
    }

    fn flush(&mut self) {
        self.inner.flush();
    }

    fn take(&mut self) -> Option<(WorkerId, Kind, Vec<u8>)> {
        self.inner.take()
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        self.inner.wait(timeout);
    }

    fn failed(&self) -> Option<WorkerId> {
        self.inner.failed()
    }

    fn fail(&mut self) {
        self.inner.fail();
    }
}

/// Runs every member of a team; all letters of a kind that each has sent.
///
/// # Panics
/// If a member does.
pub fn recorded(members: u32, kind: Kind, member: impl Fn(&mut Team) + Sync) -> Vec<Vec<Vec<u8>>> {
    std::thread::scope(|scope| {
        let member = &member;
        let run = |inner| {
            scope.spawn(move || {
                let (letters, sent) = channel();
                member(&mut Team::new(Recorded { inner, kind, letters }));
                sent.into_iter().collect()
            })
        };
        let all: Vec<_> = threads(members).into_iter().map(run).collect();
        all.into_iter().map(|thread| thread.join().expect("no member panics")).collect()
    })
}
