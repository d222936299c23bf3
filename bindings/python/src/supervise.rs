//! Work on a thread of its own, watched by the thread that Python called from.

use crate::failure::Failure;
use ltbw_bindings::{Class, PATIENCE, Reins, unpanicked};
use pyo3::prelude::*;
use pyo3::types::PyBool;

/// Looks for signals and tells the progress: an exception of either ends the work.
pub(crate) fn look(py: Python<'_>, reins: &Reins, tell: Option<&Py<PyAny>>) -> PyResult<()> {
    let looked = py.check_signals().and_then(|()| {
        let Some(tell) = tell else { return Ok(()) };
        let (done, total) = reins.progress.figures();
        let answer = tell.call1(py, (done, total))?;
        // `False` asks for the end; the mesh so far is kept.
        if answer.bind(py).is(&*PyBool::new(py, false)) {
            reins.cancel.cancel();
        }
        Ok(())
    });
    looked.inspect_err(|_| reins.cancel.cancel())
}

/// Carries out `work` on a thread of its own, with the interpreter free for others.
pub(crate) fn supervised<T: Send>(
    py: Python<'_>,
    tell: Option<&Py<PyAny>>,
    work: impl FnOnce(&Reins) -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let reins = Reins::default();
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
                raised = look(py, reins, tell).err();
            }
        }
        let lost = || Failure::new(Class::Internal, "internal.panic", "a thread was lost");
        let result = worker.join().unwrap_or_else(|_| Err(lost()));
        raised.map_or(result, |error| Err(error.into()))
    })
}

/// Panics, for the test that a panic is an ordinary exception.
#[pyfunction]
#[pyo3(name = "_panics")]
pub(crate) fn panics(py: Python<'_>) -> PyResult<()> {
    let work = |_: &Reins| -> Result<(), Failure> { panic!("asked for") };
    Ok(supervised(py, None, work)?)
}
