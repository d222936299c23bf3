//! The reins of work under way, panics as failures, and threads.

use crate::failure::{Class, Failure};
use crate::sync::Progress;
use ltbw::CancelToken;
use std::any::Any;
use std::num::NonZero;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

/// The time between two looks at what the calling side wants.
pub const PATIENCE: Duration = Duration::from_millis(50);

/// Work may be cancelled by this, and tells its progress to that.
#[derive(Debug, Default)]
pub struct Reins {
    /// Cancels the work.
    pub cancel: CancelToken,
    /// The figures so far.
    pub progress: Progress,
}

/// Turns a panic of `work` into a failure.
///
/// # Errors
/// Those of `work`; a panic is [`Class::Internal`].
pub fn unpanicked<T, E: From<Failure>>(work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(defect(&*panic).into()))
}

fn defect(panic: &(dyn Any + Send)) -> Failure {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic");
    Failure::new(Class::Internal, "internal.panic", format!("a defect of ltbw: {text}"))
}

/// Carries out `work` on threads of its own, as many as there are processors.
///
/// The pool that Rayon keeps for all is never used: its threads do not live on in a process that
/// was forked, where whoever waits for them waits for ever.
///
/// # Errors
/// Those of `work`; threads that do not start.
pub fn in_own_pool<T: Send, E: From<Failure> + Send>(
    work: impl FnOnce() -> Result<T, E> + Send,
) -> Result<T, E> {
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    in_pool(u32::try_from(threads).unwrap_or(1), work)
}

/// Carries out `work` with no more than `threads` threads for sorting and checking.
///
/// # Errors
/// Those of `work`; threads that do not start.
pub fn in_pool<T: Send, E: From<Failure> + Send>(
    threads: u32,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> Result<T, E> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1) as usize).build();
    pool.map_err(|e| Failure::new(Class::Machine, "threads.start", e))?.install(work)
}
