//! Teams of threads whose letters are bytes: what processes do, in one process.

use ltbw::team::{Team, Threads, threads};

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
