//! A thread for each worker of a run: begun, waited for, and what came of it.

use super::teller::Teller;
use super::worker_loop::{Broken, Ended, Loop, RuntimeHooks};
use super::{Node, RunError, Travels};
use crate::WorkerError;
use crate::balance::Workload;
use crate::protocol::{Correct, Source, WorkerId, message_of};
use crate::transport::{Mail, Transport};

/// A worker at its end, and its hooks.
pub(super) type End<S, Q, W> = (Node<S, Q>, W);

/// A loop that has no thread yet. If it gets none, all others are told: those that have begun would
/// wait for it.
struct Waiting<S, Q, T, W>(Option<Loop<S, Q, Correct, T, W>>)
where
    S: Travels,
    Q: Source<S> + Workload,
    T: Transport<Mail<S>>,
    W: RuntimeHooks<S>;

impl<S, Q, T, W> Drop for Waiting<S, Q, T, W>
where
    S: Travels,
    Q: Source<S> + Workload,
    T: Transport<Mail<S>>,
    W: RuntimeHooks<S>,
{
    fn drop(&mut self) {
        if let Some(worker) = &mut self.0 {
            worker.refuse();
        }
    }
}

/// A thread with nothing special about it.
pub(super) fn any_thread(_: usize) -> std::thread::Builder {
    std::thread::Builder::new()
}

/// Runs every loop on a thread of its own, made by `thread` from its number. A loop that panics
/// takes its way along, which tells the others.
pub(super) fn run_all<S, Q, T, W>(
    loops: Vec<Loop<S, Q, Correct, T, W>>,
    teller: &Teller<'_>,
    thread: impl Fn(usize) -> std::thread::Builder,
) -> Result<Vec<End<S, Q, W>>, RunError>
where
    S: Travels,
    Q: Source<S> + Workload + Send,
    T: Transport<Mail<S>> + Send,
    W: RuntimeHooks<S> + Send,
{
    let wanted = loops.len();
    let (results, refused): (Vec<_>, _) = std::thread::scope(|scope| {
        let spawn = |(k, worker): (usize, Loop<S, Q, _, T, W>)| {
            let leave = teller.leave();
            let mut waiting = Waiting(Some(worker));
            thread(k).spawn_scoped(scope, move || {
                let _leave = leave;
                waiting.0.take().map(Loop::run)
            })
        };
        // A loop that has no thread tells those that have one; the loops after it are not begun.
        let (mut threads, mut refused) = (Vec::with_capacity(wanted), None);
        for started in loops.into_iter().enumerate().map(spawn) {
            match started {
                Ok(thread) => threads.push(thread),
                Err(error) => {
                    refused = Some(error);
                    break;
                }
            }
        }
        teller.tell_until(threads.len() as u32);
        let ends = threads.into_iter().map(std::thread::ScopedJoinHandle::join);
        (ends.collect(), refused)
    });
    let mut ends = Vec::with_capacity(results.len());
    let (mut panics, mut errors) = (Vec::new(), Vec::new());
    for (worker, result) in results.into_iter().enumerate() {
        let worker = WorkerId::at(worker);
        match result {
            Ok(Some(Ok(Ended { node, hooks, .. }))) => ends.push((node, hooks)),
            Ok(Some(Err(Broken::Here(error)))) => {
                errors.push(WorkerError::Submesh { worker, error });
            }
            // It stopped because another one failed.
            Ok(None | Some(Err(Broken::Elsewhere(_)))) => {}
            Err(panic) => panics.push(WorkerError::of_panic(worker, message_of(&*panic))),
        }
    }
    match (panics.into_iter().next(), refused, errors.into_iter().next()) {
        (Some(error), ..) | (_, None, Some(error)) => Err(error.into()),
        (_, Some(error), _) => {
            Err(RunError::Threads { threads: wanted, reason: error.to_string() })
        }
        _ => Ok(ends),
    }
}
