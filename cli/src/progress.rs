//! Progress on stderr: a bar or a spinner on a terminal for what takes over a second, lines of JSON
//! with `--progress json`, and otherwise nothing. It has no colours, whatever `NO_COLOR` says.

use crate::sync::{Due, Flag};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use ltbw::Observer;
use serde_json::json;
use std::io::{IsTerminal as _, Write as _};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(1);
const TICK: Duration = Duration::from_millis(200);

/// Lines of JSON in place of bars.
static JSON: Flag = Flag::new();
/// No bars.
static HIDDEN: Flag = Flag::new();

/// `--progress`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Show {
    /// Bars on a terminal
    Bar,
    /// A line of JSON on stderr for each stage, and five a second while its points are counted
    Json,
    /// Nothing
    None,
}

/// Sets the way in which progress is shown.
pub(crate) fn show(show: Show) {
    match show {
        Show::Bar => {}
        Show::Json => {
            JSON.set();
        }
        Show::None => {
            HIDDEN.set();
        }
    }
}

fn has_bars() -> bool {
    !JSON.is_set() && !HIDDEN.is_set() && std::io::stderr().is_terminal()
}

/// Writes a line of JSON. Nobody misses it if stderr takes none.
fn line(phase: &str, done: Option<u64>, total: Option<u64>) {
    let text = json!({ "phase": phase, "done": done, "total": total });
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// The name of a stage of the kernel's work.
fn name(phase: ltbw::Phase) -> &'static str {
    match phase {
        ltbw::Phase::Recover => "recover",
        ltbw::Phase::Refine => "refine",
        _ => "insert",
    }
}

/// Progress of work that counts its points.
#[derive(Debug)]
pub(crate) struct Progress {
    start: Instant,
    has_bars: bool,
    bar: OnceLock<ProgressBar>,
    due: Due,
}

impl Progress {
    /// Progress that does not show yet.
    pub(crate) fn new() -> Self {
        let due = Due::default();
        Self { start: Instant::now(), has_bars: has_bars(), bar: OnceLock::new(), due }
    }
}

impl Observer for Progress {
    fn progress(&self, progress: ltbw::Progress) {
        if JSON.is_set() {
            let is_last = progress.total == Some(progress.done);
            if self.due.is_due(self.start.elapsed(), TICK) || is_last {
                line(name(progress.phase), Some(progress.done), progress.total);
            }
            return;
        }
        if !self.has_bars || self.start.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_init(|| bar(template(progress.total), progress.total));
        bar.set_position(progress.done);
    }
}

fn bar(template: &str, total: Option<u64>) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
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

/// A stage of work that counts nothing: on a terminal a spinner turns from its second second on.
/// It ends when this is dropped.
#[derive(Debug)]
pub(crate) struct Stage {
    ended: Arc<(Mutex<bool>, Condvar)>,
    spinner: Option<JoinHandle<()>>,
}

impl Stage {
    /// Begins a stage.
    pub(crate) fn begin(name: &'static str) -> Self {
        if JSON.is_set() {
            line(name, None, None);
        }
        let ended = Arc::<(Mutex<bool>, Condvar)>::default();
        let watched = Arc::clone(&ended);
        let turn = move || spin(name, &watched);
        // Without a thread there is no spinner, which is no reason to fail.
        let thread = std::thread::Builder::new().name("spinner".to_owned());
        let spinner = has_bars().then(|| thread.spawn(turn).ok()).flatten();
        Self { ended, spinner }
    }
}

/// Turns a spinner until the stage has ended.
fn spin(name: &str, (ended, bell): &(Mutex<bool>, Condvar)) {
    let wait = |time| {
        let guard = ended.lock().unwrap_or_else(PoisonError::into_inner);
        let result = bell.wait_timeout_while(guard, time, |ended| !*ended);
        *result.unwrap_or_else(PoisonError::into_inner).0
    };
    if wait(PATIENCE - TICK) {
        return;
    }
    let bar = bar(&format!("{name} {{spinner}} {{elapsed}}"), None);
    bar.tick();
    while !wait(TICK) {
        bar.tick();
    }
    bar.finish_and_clear();
}

impl Drop for Stage {
    fn drop(&mut self) {
        *self.ended.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.ended.1.notify_all();
        if let Some(spinner) = self.spinner.take() {
            // A spinner that panicked is gone; the work is not.
            let _ = spinner.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Stage, template};

    #[test]
    fn a_total_that_is_not_known_is_not_told() {
        let (known, unknown) = (template(Some(1000)), template(None));
        assert!(known.contains("{human_len}") && known.contains("{eta}"));
        assert!(!unknown.contains("{human_len}") && !unknown.contains("{eta}"));
    }

    #[test]
    fn a_stage_ends_when_it_is_dropped() {
        let stage = Stage::begin("check");
        let ended = std::sync::Arc::clone(&stage.ended);
        drop(stage);
        assert!(*ended.0.lock().expect("the lock"));
    }
}
