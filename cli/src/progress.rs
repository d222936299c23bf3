//! Progress on stderr: a bar or a spinner on a terminal for what takes over a second, lines of JSON
//! with `--progress json`, and otherwise nothing. It has no colours, whatever `NO_COLOR` says.

use crate::sync::{Counted, Counts, Due, Flag};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use ltbw::Observer;
use serde_json::json;
use std::io::{IsTerminal as _, Write as _};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(1);
/// The name and version of the lines of JSON: `docs/schema/progress.json`.
const SCHEMA: &str = "ltbw.progress/1";
const TICK: Duration = Duration::from_millis(200);

/// Lines of JSON in place of bars.
static JSON: Flag = Flag::new();
/// The begin of the program.
static START: OnceLock<Instant> = OnceLock::new();
/// No bars.
static HIDDEN: Flag = Flag::new();

/// The stages of a command.
static PLAN: OnceLock<&'static [&'static str]> = OnceLock::new();

/// Tells which stages there will be, in their order: each says then which it is, of how many.
pub(crate) fn plan(stages: &'static [&'static str]) {
    PLAN.get_or_init(|| stages);
}

/// The name of a stage for people, with its place in the plan.
fn titled(name: &str, plan: Option<&[&str]>) -> String {
    let place = plan.and_then(|all| Some((all.iter().position(|own| *own == name)?, all.len())));
    place.map_or_else(|| name.to_owned(), |(k, n)| format!("{name} ({} of {n})", k + 1))
}

/// The time that is left, from the pace so far; nothing while that says little.
fn left(counted: Counted, elapsed: Duration) -> String {
    let Counted { done, total: Some(total) } = counted else { return String::new() };
    if done == 0 || done > total || elapsed < TICK {
        return String::new();
    }
    let seconds = elapsed.as_secs_f64() * (total - done) as f64 / done as f64;
    match seconds.ceil() as u64 {
        s @ 0..120 => format!(", {s}s left"),
        s => format!(", {}m left", s.div_ceil(60)),
    }
}

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

/// Sets the way in which progress is shown; the program begins.
pub(crate) fn show(show: Show) {
    START.get_or_init(Instant::now);
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

/// Are there bars on a terminal?
pub(crate) fn has_bars() -> bool {
    !JSON.is_set() && !HIDDEN.is_set() && std::io::stderr().is_terminal()
}

/// Writes a line of JSON. Nobody misses it if stderr takes none.
fn line(phase: &str, done: Option<u64>, total: Option<u64>) {
    let text = json!({ "schema": SCHEMA, "phase": phase, "done": done, "total": total });
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// The name of a stage of the kernel's work.
fn name(phase: ltbw::Phase) -> &'static str {
    match phase {
        ltbw::Phase::Recover => "recover",
        ltbw::Phase::Refine => "refine",
        ltbw::Phase::Order => "order",
        ltbw::Phase::Gather => "gather",
        _ => "insert",
    }
}

/// The state of a stage, for the thread that shows it.
#[derive(Debug, Default)]
struct Shown {
    ended: Mutex<bool>,
    bell: Condvar,
    /// Its points, once some are counted.
    counts: Counts,
}

/// A stage of work: on a terminal a bar or a spinner is there from its second second on, and at
/// once where the program has worked for longer. It ends when this is dropped.
#[derive(Debug)]
pub(crate) struct Stage {
    shown: Arc<Shown>,
    thread: Option<JoinHandle<()>>,
}

impl Stage {
    /// Begins a stage.
    pub(crate) fn begin(name: &'static str) -> Self {
        if JSON.is_set() {
            line(name, None, None);
        }
        let shown = Arc::<Shown>::default();
        let watched = Arc::clone(&shown);
        let turn = move || spin(name, &watched);
        // Without a thread there is no spinner, which is no reason to fail.
        let thread = std::thread::Builder::new().name("spinner".to_owned());
        let thread = has_bars().then(|| thread.spawn(turn).ok()).flatten();
        Self { shown, thread }
    }
}

/// The time that a stage waits before it shows, at the age of the program.
fn patience(age: Duration) -> Duration {
    PATIENCE.saturating_sub(TICK).saturating_sub(age).max(TICK)
}

/// Shows a stage until it has ended.
fn spin(name: &str, shown: &Shown) {
    let wait = |time| {
        let guard = shown.ended.lock().unwrap_or_else(PoisonError::into_inner);
        let result = shown.bell.wait_timeout_while(guard, time, |ended| !*ended);
        *result.unwrap_or_else(PoisonError::into_inner).0
    };
    let waited = patience(START.get_or_init(Instant::now).elapsed());
    if wait(waited) {
        return;
    }
    let (title, start) = (titled(name, PLAN.get().copied()), Instant::now());
    let name = &title;
    let mut counted = None;
    let mut bar = bar(&template(name, counted), None);
    bar.tick();
    while !wait(TICK) {
        let now = shown.counts.get();
        if let Some(Counted { done, total }) = now {
            if counted.is_none() {
                bar.finish_and_clear();
                bar = self::bar(&template(name, now), total);
            }
            bar.set_position(done);
            bar.set_message(left(Counted { done, total }, start.elapsed() + waited));
            counted = now;
        }
        bar.tick();
    }
    bar.finish_and_clear();
}

fn bar(template: &str, total: Option<u64>) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// The contents of a bar: nothing is counted at first, and refinement does not know its end.
fn template(name: &str, counts: Option<Counted>) -> String {
    match counts {
        None => format!("{name} {{spinner}} {{elapsed}}"),
        Some(Counted { total: None, .. }) => {
            format!("{name} {{spinner}} {{human_pos}} points in {{elapsed}}")
        }
        Some(Counted { total: Some(_), .. }) => {
            format!("{name} {{bar:40}} {{human_pos}} of {{human_len}} points{{msg}}")
        }
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        *self.shown.ended.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.shown.bell.notify_all();
        if let Some(thread) = self.thread.take() {
            // A spinner that panicked is gone; the work is not.
            let _ = thread.join();
        }
    }
}

/// Stages that follow each other, as the kernel names them; most count their points.
#[derive(Debug)]
pub(crate) struct Progress<'a> {
    start: Instant,
    due: Due,
    stage: Mutex<(&'static str, Option<Stage>)>,
    begun: &'a Flag,
}

impl<'a> Progress<'a> {
    /// Begins a stage whose points are counted once there are some; `begun` is set when there is a
    /// mesh that is worth writing.
    pub(crate) fn begin(name: &'static str, begun: &'a Flag) -> Self {
        let stage = Mutex::new((name, Some(Stage::begin(name))));
        Self { start: Instant::now(), due: Due::default(), stage, begun }
    }
}

impl Observer for Progress<'_> {
    fn progress(&self, progress: ltbw::Progress) {
        let ltbw::Progress { phase, done, total } = progress;
        // Points are put in order first, and a domain's boundary is recovered first.
        if matches!(phase, ltbw::Phase::Insert | ltbw::Phase::Refine) {
            self.begun.set();
        }
        let mut stage = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        if stage.0 != name(phase) {
            // The one before ends first: on a terminal both would be on one line.
            stage.1 = None;
            *stage = (name(phase), Some(Stage::begin(name(phase))));
        }
        if matches!(phase, ltbw::Phase::Order | ltbw::Phase::Gather) {
            return;
        }
        if let Some(stage) = &stage.1 {
            stage.shown.counts.set(done, total);
        }
        let is_due = || self.due.is_due(self.start.elapsed(), TICK) || total == Some(done);
        if JSON.is_set() && is_due() {
            line(name(phase), Some(done), total);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Counted, Flag, PATIENCE, Progress, Stage, left, patience, template, titled};
    use ltbw::{Observer as _, Phase};
    use std::sync::Arc;
    use std::time::Duration;

    #[test]
    fn a_total_that_is_not_known_is_not_told() {
        let of = |total| template("insert", Some(Counted { done: 1, total }));
        let (known, unknown) = (of(Some(1000)), of(None));
        assert!(known.contains("{human_len}") && known.contains("{msg}"));
        assert!(!unknown.contains("{human_len}") && !unknown.contains("{msg}"));
        assert!(unknown.contains("{human_pos}") && !template("x", None).contains("{human_pos}"));
    }

    #[test]
    fn the_time_left_is_told_from_the_pace() {
        let at =
            |done, seconds| left(Counted { done, total: Some(1000) }, Duration::from_secs(seconds));
        assert_eq!((at(0, 5), at(60, 0)), (String::new(), String::new()), "not `0s left`");
        assert_eq!((at(60, 6), at(1000, 6)), (", 94s left".into(), ", 0s left".into()));
        assert_eq!(at(10, 60), ", 99m left");
    }

    #[test]
    fn a_stage_tells_its_place_in_the_plan() {
        let plan: &[&str] = &["read", "insert", "hash"];
        assert_eq!(titled("insert", Some(plan)), "insert (2 of 3)");
        assert_eq!(
            (titled("page", Some(plan)), titled("page", None)),
            ("page".into(), "page".into())
        );
    }

    #[test]
    fn a_stage_ends_when_it_is_dropped() {
        let stage = Stage::begin("check");
        let shown = Arc::clone(&stage.shown);
        drop(stage);
        assert!(*shown.ended.lock().expect("the lock"));
    }

    #[test]
    fn a_stage_shows_within_the_first_second_and_at_once_after_it() {
        let age = Duration::from_millis;
        assert!(patience(age(0)) < PATIENCE && patience(age(0)) > age(500));
        assert!(patience(age(600)) < age(400) && patience(age(60_000)) < age(300));
    }

    #[test]
    fn points_are_shown_as_they_are_counted() {
        let begun = Flag::default();
        let progress = Progress::begin("insert", &begun);
        let shown = || {
            let stage = progress.stage.lock().expect("the stage");
            (stage.0, stage.1.as_ref().expect("a stage").shown.counts.get())
        };
        let counts = || shown().1;
        assert_eq!(counts(), None);
        let now = |done, total| ltbw::Progress { phase: Phase::Insert, done, total };
        progress.progress(now(3, Some(9)));
        assert_eq!(counts(), Some(Counted { done: 3, total: Some(9) }));
        progress.progress(now(4, None));
        assert_eq!(counts(), Some(Counted { done: 4, total: None }));
        progress.progress(ltbw::Progress { phase: Phase::Gather, done: 9, total: Some(9) });
        assert_eq!(shown(), ("gather", None));
    }
}
