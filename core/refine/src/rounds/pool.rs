//! Rounds on a thread of the pool, which asks the others without going to sleep: a thread outside
//! is woken after every piece of work that several share.

use super::{Finished, Rounds};
use crate::RefineError;
use ltbw_core::CancelToken;
use std::sync::mpsc::channel;
use std::sync::{Mutex, TryLockError};

/// The run that is in the pool from outside.
static ALONE: Mutex<()> = Mutex::new(());

impl Rounds<'_, '_> {
    /// Carries out rounds until nothing is left to do, or the token is cancelled. `tell` is told
    /// the number of vertices now and then, on this thread.
    ///
    /// # Errors
    /// A broken invariant.
    pub(crate) fn run_in_pool(
        self,
        cancel: Option<&CancelToken>,
        tell: impl Fn(usize),
    ) -> Result<Finished, RefineError> {
        let is_cancelled = || cancel.is_some_and(CancelToken::is_cancelled);
        // A thread of the pool must not wait for another one to take the work.
        let is_inside = rayon::current_thread_index().is_some();
        // A thread of the pool that waits for a piece of work may take up the whole of another run,
        // and go on with its own when that has ended: so there is one at a time.
        let alone = ALONE.try_lock();
        let is_taken = matches!(alone, Err(TryLockError::WouldBlock));
        if self.threads == 1 || is_inside || is_taken {
            return self.run(&|vertices| {
                tell(vertices);
                is_cancelled()
            });
        }
        let mut finished = Err(RefineError::Invariant { what: "rounds end" });
        let (sender, counts) = channel();
        rayon::in_place_scope(|scope| {
            let finished = &mut finished;
            scope.spawn(move |_| {
                *finished = self.run(&|vertices| {
                    // The other end is gone if `tell` has panicked.
                    sender.send(vertices).is_err() || is_cancelled()
                });
            });
            // Ends when the work does: then the sender is gone.
            counts.into_iter().for_each(&tell);
        });
        finished
    }
}
