//! Teams of threads whose letters are bytes: what processes do, in one process.

use ltbw::Point;
use ltbw::distributed::{Slice, SliceError};
use ltbw::protocol::WorkerId;
use ltbw::team::{Kind, Post, Team, Threads, threads};
use std::time::Duration;

/// Runs every member of a team on a thread of its own; what comes of it, by member.
///
/// # Panics
/// If a member does.
pub fn on_team<R: Send>(members: u32, member: impl Fn(&mut Team<Threads>) -> R + Sync) -> Vec<R> {
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
pub fn try_slice<P: Post>(team: &mut Team<P>, points: &[Point]) -> Result<Slice, SliceError> {
    let end = |k: usize| k * points.len() / team.size() as usize;
    let me = team.me().index();
    let own = points[end(me)..end(me + 1)].to_vec();
    Slice::new(team, own)
}

/// As [`try_slice`], of sound points.
///
/// # Panics
/// If they are not.
pub fn slice_of<P: Post>(team: &mut Team<P>, points: &[Point]) -> Slice {
    try_slice(team, points).expect("finite points")
}

/// A post that keeps a copy of each letter of a kind that it sends.
#[derive(Debug)]
pub struct Recorded<P> {
    inner: P,
    kind: Kind,
    /// The letters, in their order.
    pub letters: Vec<Vec<u8>>,
}

impl<P: Post> Post for Recorded<P> {
    fn me(&self) -> WorkerId {
        self.inner.me()
    }

    fn members(&self) -> u32 {
        self.inner.members()
    }

    fn send(&mut self, to: WorkerId, kind: Kind, letter: Vec<u8>) {
        if kind == self.kind {
            self.letters.push(letter.clone());
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
pub fn recorded(
    members: u32,
    kind: Kind,
    member: impl Fn(&mut Team<Recorded<Threads>>) + Sync,
) -> Vec<Vec<Vec<u8>>> {
    std::thread::scope(|scope| {
        let member = &member;
        let run = |inner| {
            scope.spawn(move || {
                let mut team = Team::new(Recorded { inner, kind, letters: Vec::new() });
                member(&mut team);
                std::mem::take(&mut team.post().letters)
            })
        };
        let all: Vec<_> = threads(members).into_iter().map(run).collect();
        all.into_iter().map(|thread| thread.join().expect("no member panics")).collect()
    })
}
