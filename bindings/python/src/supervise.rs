//! Work on a thread of its own, watched by the thread that Python called from.

use crate::failure::{Class, Failure};
use crate::sync::Progress;
use ltbw::CancelToken;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

/// The time between two looks at signals and two calls of the progress function.
pub(crate) const PATIENCE: Duration = Duration::from_millis(50);

/// The work may be cancelled by this, and tells its progress to that.
pub(crate) struct Reins {
    pub(crate) cancel: CancelToken,
    pub(crate) progress: Progress,
}

impl Reins {
    pub(crate) fn new() -> Self {
        Self { cancel: CancelToken::new(), progress: Progress::default() }
    }

    /// Looks for signals and tells the progress: an exception of either ends the work.
    pub(crate) fn look(&self, py: Python<'_>, tell: Option<&Py<PyAny>>) -> PyResult<()> {
        let looked = py.check_signals().and_then(|()| {
            let Some(tell) = tell else { return Ok(()) };
            let (done, total) = self.progress.figures();
            let answer = tell.call1(py, (done, total))?;
            // `False` asks for the end; the mesh so far is kept.
            if answer.bind(py).is(&*pyo3::types::PyBool::new(py, false)) {
                self.cancel.cancel();
            }
            Ok(())
        });
        looked.inspect_err(|_| self.cancel.cancel())
    }
}

/// Carries out `work` on a thread of its own, with the interpreter free for others.
pub(crate) fn supervised<T: Send>(
    py: Python<'_>,
    tell: Option<&Py<PyAny>>,
    work: impl FnOnce(&Reins) -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let reins = Reins::new();
    std::thread::scope(|scope| {
        let reins = &reins;
        let worker = scope.spawn(move || {
            let result = unpanicked(|| work(reins));
            reins.progress.end();
            result
        });
        let mut raised = None;
        // Ends with the work, which looks at the token.
        while !py.detach(|| reins.progress.wait(PATIENCE)) {
            if raised.is_none() {
                raised = reins.look(py, tell).err();
            }
        }
        let result = worker.join().unwrap_or_else(|panic| Err(defect(&*panic)));
        raised.map_or(result, |error| Err(error.into()))
    })
}

/// Turns a panic of `work` into an ordinary exception.
pub(crate) fn unpanicked<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(defect(&*panic)))
}

fn defect(panic: &(dyn Any + Send)) -> Failure {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic");
    Failure::new(Class::Internal, "internal.panic", format!("a defect of ltbw: {text}"))
}

/// Panics, for the test that a panic is an ordinary exception.
#[pyfunction]
#[pyo3(name = "_panics")]
pub(crate) fn panics(py: Python<'_>) -> PyResult<()> {
    let work = |_: &Reins| -> Result<(), Failure> { panic!("asked for") };
    Ok(supervised(py, None, work)?)
}
