//! Work on a thread of its own, watched by the thread that Python called from.

use crate::failure::Failure;
use ltbw_bindings::{Class, Figures, PATIENCE, Reins, unpanicked};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// The time that interrupted work has to come to its end, before it is left to itself.
const GRACE: Duration = Duration::from_millis(200);

/// Looks for signals and tells the progress: an exception of either ends the work.
pub(crate) fn look(py: Python<'_>, reins: &Reins, tell: Option<&Py<PyAny>>) -> PyResult<()> {
    let looked = py.check_signals().and_then(|()| {
        let Some(tell) = tell else { return Ok(()) };
        let Figures { done, total } = reins.progress.figures();
        let answer = tell.call1(py, (done, total))?;
        // `False`, numpy's too, asks for the end; the mesh so far is kept.
        if let Ok(false) = answer.extract::<bool>(py) {
            reins.cancel.cancel();
        }
        Ok(())
    });
    looked.inspect_err(|_| reins.cancel.cancel())
}

/// Tells that all is done, where it is known how much that is: a bar would stop short of its end.
fn last(py: Python<'_>, reins: &Reins, tell: Option<&Py<PyAny>>) -> PyResult<()> {
    let (Some(tell), Some(total)) = (tell, reins.progress.figures().total) else { return Ok(()) };
    if !reins.cancel.is_cancelled() {
        tell.call1(py, (total, total))?;
    }
    Ok(())
}

/// Carries out `work` on a thread of its own, with the interpreter free for others.
///
/// An exception of `look` cancels the work. What looks at the token ends at once; a check, say,
/// does not: it is left to its thread, which owns all that it works with and drops the result.
pub(crate) fn supervised<T: Send + 'static>(
    py: Python<'_>,
    tell: Option<&Py<PyAny>>,
    work: impl FnOnce(&Reins) -> Result<T, Failure> + Send + 'static,
) -> Result<T, Failure> {
    let reins = Arc::new(Reins::default());
    let (sender, receiver) = channel();
    let own = Arc::clone(&reins);
    let carried_out = move || {
        // Nobody waits for the result of work that was left to itself.
        drop(sender.send(unpanicked(|| work(&own))));
    };
    let started = std::thread::Builder::new().name("ltbw".to_owned()).spawn(carried_out);
    started.map_err(|e| Failure::new(Class::Machine, "threads.start", e))?;
    let mut waiting = receiver;
    let mut raised: Option<(PyErr, Instant)> = None;
    // Ends with the work, or some time after it was cancelled.
    loop {
        // A receiver may be sent to the call without the interpreter, but not lent.
        let (receiver, received) = py.detach(move || {
            let received = waiting.recv_timeout(PATIENCE);
            (waiting, received)
        });
        waiting = receiver;
        match (received, raised.take()) {
            (Ok(_) | Err(RecvTimeoutError::Disconnected), Some((error, _))) => {
                return Err(error.into());
            }
            (Ok(result), None) => {
                if result.is_ok() {
                    last(py, &reins, tell)?;
                }
                return result;
            }
            (Err(RecvTimeoutError::Disconnected), None) => {
                return Err(Failure::new(Class::Internal, "internal.panic", "a thread was lost"));
            }
            (Err(RecvTimeoutError::Timeout), Some((error, since))) if since.elapsed() > GRACE => {
                return Err(error.into());
            }
            (Err(RecvTimeoutError::Timeout), earlier) => {
                let raises = || look(py, &reins, tell).err().map(|error| (error, Instant::now()));
                raised = earlier.or_else(raises);
            }
        }
    }
}

/// Panics, for the test that a panic is an ordinary exception.
#[pyfunction]
#[pyo3(name = "_panics")]
pub(crate) fn panics(py: Python<'_>) -> PyResult<()> {
    let work = |_: &Reins| -> Result<(), Failure> { panic!("asked for") };
    Ok(supervised(py, None, work)?)
}
