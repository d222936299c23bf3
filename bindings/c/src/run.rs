//! Threads, progress and cancelling.

use crate::sized::Growing;
use ltbw_bindings::{Class, Failure, Figures, PATIENCE, Reins, unpanicked};
use std::ffi::c_void;
use std::mem::offset_of;

/// Told some twenty times a second, by the calling thread: points done, of a total that is 0 where
/// it is not known. Anything but 0 ends the work: the mesh so far is kept.
pub type Progress = Option<extern "C" fn(context: *mut c_void, done: u64, total: u64) -> i32>;

/// Threads and progress. NULL where a function takes one: one thread, no progress.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// Size of the struct, `sizeof` it: `ltbw_run_new` sets it.
    pub struct_size: u32,
    /// Threads; 0 means 1. The mesh is the same for any number.
    pub threads: u32,
    /// The progress function, or NULL.
    pub progress: Progress,
    /// Handed to the progress function.
    pub context: *mut c_void,
}

// SAFETY: `repr(C)`, the size first, then numbers and pointers.
unsafe impl Growing for Run {
    const NAME: &str = "ltbw_run";
    const FIRST: usize = offset_of!(Self, context) + size_of::<*mut c_void>();
}

impl Run {
    /// The run that a pointer asks for.
    ///
    /// # Safety
    /// The pointer is null or points to a run.
    pub(crate) unsafe fn of(run: *const Self) -> Result<Self, Failure> {
        let default =
            Self { struct_size: 0, threads: 1, progress: None, context: std::ptr::null_mut() };
        // SAFETY: as the caller promises.
        let given = unsafe { Self::given(run) }?.unwrap_or(default);
        Ok(Self { threads: given.threads.max(1), ..given })
    }

    /// Tells the progress; the answer may end the work.
    pub(crate) fn tell(&self, reins: &Reins) {
        if let Some(progress) = self.progress {
            let Figures { done, total } = reins.progress.figures();
            if progress(self.context, done, total.unwrap_or(0)) != 0 {
                reins.cancel.cancel();
            }
        }
    }

    /// Carries out `work` on a thread of its own, if there is somebody to be told of its progress.
    pub(crate) fn supervise<T: Send>(
        &self,
        work: impl FnOnce(&Reins) -> Result<T, Failure> + Send,
    ) -> Result<T, Failure> {
        let reins = Reins::default();
        if self.progress.is_none() {
            return work(&reins);
        }
        std::thread::scope(|scope| {
            let reins = &reins;
            let worker = std::thread::Builder::new().spawn_scoped(scope, move || {
                let result = unpanicked(|| work(reins));
                reins.progress.end();
                result
            });
            let worker = worker.map_err(|e| Failure::new(Class::Machine, "threads.start", e))?;
            // Ends with the work, which looks at the token.
            while !reins.progress.wait(PATIENCE) {
                self.tell(reins);
            }
            let lost = || Failure::new(Class::Internal, "internal.panic", "lost");
            let result = worker.join().unwrap_or_else(|_| Err(lost()));
            // A bar would stop short of its end.
            if let (Ok(_), Some(total), Some(progress), false) = (
                &result,
                reins.progress.figures().total,
                self.progress,
                reins.cancel.is_cancelled(),
            ) {
                progress(self.context, total, total);
            }
            result
        })
    }
}
