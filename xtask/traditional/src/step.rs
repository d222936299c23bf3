//! The time of a step: on the clock, and of the processor.

use crate::Failure;
use serde_json::{Value, json};
use std::time::Instant;

/// The time of a step, in seconds.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    pub(crate) clock: f64,
    /// Of this thread, unless a step says otherwise.
    pub(crate) processor: f64,
}

impl Step {
    pub(crate) fn to_json(self, name: &str) -> Value {
        json!({ "name": name, "clock": self.clock, "processor": self.processor })
    }
}

/// Carries out a step on this thread.
pub(crate) fn timed<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<(Step, T), Failure> {
    let (clock, processor) = (Instant::now(), of_thread()?);
    let made = work()?;
    let step = Step { clock: clock.elapsed().as_secs_f64(), processor: of_thread()? - processor };
    Ok((step, made))
}

/// Seconds that this thread has had a processor.
pub(crate) fn of_thread() -> Result<f64, Failure> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    let nanos = text.split_whitespace().next().ok_or("schedstat is empty")?;
    Ok(nanos.parse::<u64>()? as f64 * 1e-9)
}
