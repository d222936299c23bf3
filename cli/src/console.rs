//! Output to stdout and to stderr, progress, and Ctrl-C.
//!
//! A closed pipe (`ltbw … | head`) is no error of ours: its reader has what it wanted. Data that
//! stdout cannot take for any other reason, such as a full disk, is an output that could not be
//! written. Lines for people are dropped if stderr takes none: there is nobody to tell.

use crate::outcome::{Exit, Failure};
use crate::sync::Flag;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use ltbw::io::IoError;
use ltbw::{CancelToken, Observer};
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Prints a line for people, to stderr.
pub(crate) fn people(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Prints data, to stdout.
pub(crate) fn data(text: &str) -> Result<(), Failure> {
    data_with(|| std::io::stdout().write_all(text.as_bytes()))
}

/// Prints data to stdout with `print`, and makes sure that it got there.
pub(crate) fn data_with(print: impl FnOnce() -> std::io::Result<()>) -> Result<(), Failure> {
    match print().and_then(|()| std::io::stdout().flush()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Write(IoError::Write { path: "stdout".into(), source }))
        }
        _ => Ok(()),
    }
}

/// A progress bar on stderr: only on a terminal, and only for work that takes over a second. It
/// has no colours, whatever `NO_COLOR` says.
#[derive(Debug)]
pub(crate) struct Progress {
    start: Instant,
    terminal: bool,
    bar: OnceLock<ProgressBar>,
}

impl Progress {
    const PATIENCE: Duration = Duration::from_secs(1);

    /// A bar that does not show yet.
    pub(crate) fn new() -> Self {
        let terminal = std::io::stderr().is_terminal();
        Self { start: Instant::now(), terminal, bar: OnceLock::new() }
    }
}

impl Observer for Progress {
    fn progress(&self, progress: ltbw::Progress) {
        if !self.terminal || self.start.elapsed() < Self::PATIENCE {
            return;
        }
        let bar = self.bar.get_or_init(|| {
            let total = progress.total;
            let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template(template(total)) {
                bar.set_style(style);
            }
            bar
        });
        bar.set_position(progress.done);
    }
}

/// The contents of a progress bar: refinement does not know its end.
fn template(total: Option<u64>) -> &'static str {
    match total {
        None => "insert {spinner} {human_pos} points in {elapsed}",
        Some(_) => "insert {bar:40} {human_pos} of {human_len} points, {eta} left",
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}

/// Ctrl-C (or a termination signal) during a build: before the last point is inserted the first one
/// stops the insertion, after that it changes nothing, and the second one ends the program at once.
/// Output files are renamed into place only when complete, so that neither leaves a broken file
/// under a final name.
#[derive(Debug)]
pub(crate) struct Stop {
    token: CancelToken,
    inserted: Arc<Flag>,
}

impl Stop {
    /// Listens to signals from now on.
    pub(crate) fn on_signal() -> Result<Self, Failure> {
        let stop = Self { token: CancelToken::new(), inserted: Arc::default() };
        let (token, inserted) = (stop.token.clone(), Arc::clone(&stop.inserted));
        let before = Flag::default();
        on_signal(move || {
            if before.set() {
                end_now();
            }
            people(if inserted.is_set() {
                "all points are meshed; finishing (Ctrl-C again: end at once)"
            } else {
                "stopping; the mesh so far will be written (Ctrl-C again: end at once)"
            });
            token.cancel();
        })?;
        Ok(stop)
    }

    /// The token that cancels the insertion.
    pub(crate) fn token(&self) -> &CancelToken {
        &self.token
    }

    /// All points are inserted: what is left to do is done, whatever comes.
    pub(crate) fn inserted(&self) {
        self.inserted.set();
    }
}

/// From now on Ctrl-C ends the program at once, with the exit code for it: for commands that have
/// no partial result.
pub(crate) fn end_on_signal() -> Result<(), Failure> {
    on_signal(end_now)
}

fn on_signal(handler: impl FnMut() + Send + 'static) -> Result<(), Failure> {
    ctrlc::set_handler(handler).map_err(|e| Failure::Other(format!("cannot catch Ctrl-C: {e}")))
}

#[expect(clippy::exit, reason = "runs on the signal thread, which cannot return from main")]
fn end_now() {
    people("ltbw: stopped");
    std::process::exit(Exit::Stopped as i32);
}

#[cfg(test)]
mod tests {
    use super::template;

    #[test]
    fn a_total_that_is_not_known_is_not_told() {
        let (known, unknown) = (template(Some(1000)), template(None));
        assert!(known.contains("{human_len}") && known.contains("{eta}"));
        assert!(!unknown.contains("{human_len}") && !unknown.contains("{eta}"));
    }
}
