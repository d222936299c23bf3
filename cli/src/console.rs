//! Output to stdout and to stderr, and Ctrl-C.
//!
//! Data that stdout cannot take, for a full disk or because their reader is gone, are an output
//! that could not be written. A pipe that is closed on help (`ltbw help | head`) is no error: its
//! reader has what it wanted. Lines for people are dropped if stderr takes none: there is nobody to
//! tell.

use crate::outcome::{Exit, Failure};
use crate::progress;
use crate::sync::Flag;
use ltbw::CancelToken;
use ltbw::io::IoError;
use std::io::{ErrorKind, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// With `--quiet` people get errors and outcomes alone.
static QUIET: Flag = Flag::new();

/// Prints no more lines for people but those that begin with `ltbw: `.
pub(crate) fn be_quiet() {
    QUIET.set();
}

/// Another process tells people what there is to tell.
static SILENT: Flag = Flag::new();

/// Prints no more lines for people but by [`aloud`].
#[cfg(feature = "wire")]
pub(crate) fn be_silent() {
    SILENT.set();
}

/// Is anybody told more than errors and outcomes by this process? Else notes that cost time need
/// not be found out.
pub(crate) fn is_heard() -> bool {
    !SILENT.is_set() && !QUIET.is_set()
}

/// Prints a line for people, to stderr.
pub(crate) fn people(line: &str) {
    if SILENT.is_set() || QUIET.is_set() && !line.starts_with("ltbw: ") {
        return;
    }
    aloud(line);
}

/// Prints a line for people in any case, to stderr.
pub(crate) fn aloud(line: &str) {
    // A bar may be on the terminal's last line, and comes again below.
    let start = if progress::has_bars() { "\r\x1b[2K" } else { "" };
    let _ = writeln!(std::io::stderr(), "{start}{line}");
}

/// Prints data, to stdout.
pub(crate) fn data(text: &str) -> Result<(), Failure> {
    data_with(|| std::io::stdout().write_all(text.as_bytes()))
}

/// Prints data to stdout with `print`, and makes sure that it got there.
pub(crate) fn data_with(print: impl FnOnce() -> std::io::Result<()>) -> Result<(), Failure> {
    let printed = print().and_then(|()| std::io::stdout().flush());
    printed.map_err(|source| Failure::Write(IoError::Write { path: "stdout".into(), source }))
}

/// Prints help to stdout with `print`, as far as somebody reads it.
pub(crate) fn help_with(print: impl FnOnce() -> std::io::Result<()>) -> Result<(), Failure> {
    data_with(|| match print().and_then(|()| std::io::stdout().flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        printed => printed,
    })
}

/// The token that ends the writing of a file, while one is written.
static WRITING: Mutex<Option<CancelToken>> = Mutex::new(None);

fn writing_now() -> MutexGuard<'static, Option<CancelToken>> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes a file with `write`. Meanwhile a signal that would end the program ends the writing
/// first, which leaves nothing behind.
pub(crate) fn writing<T>(
    write: impl FnOnce(&CancelToken) -> Result<T, IoError>,
) -> Result<T, Failure> {
    let token = CancelToken::new();
    *writing_now() = Some(token.clone());
    let written = write(&token);
    *writing_now() = None;
    written.map_err(Failure::Write)
}

/// Ctrl-C (or a termination signal) during a build. Before there is a mesh that is worth writing it
/// ends the program at once; until the last point is inserted the first one stops the insertion,
/// after that it changes nothing, and the second one ends the program. Output files are renamed
/// into place only when complete, and one that is being written is given up first.
#[derive(Debug, Default)]
pub(crate) struct Stop {
    token: CancelToken,
    begun: Arc<Flag>,
    inserted: Arc<Flag>,
}

impl Stop {
    /// Listens to signals from now on.
    pub(crate) fn on_signal() -> Result<Self, Failure> {
        let stop = Self::default();
        let (begun, inserted) = (Arc::clone(&stop.begun), Arc::clone(&stop.inserted));
        let (token, before) = (stop.token.clone(), Flag::default());
        on_signal(move || {
            if !begun.is_set() {
                return give_up(NOTHING_WRITTEN);
            }
            if before.set() {
                return give_up("stopped");
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

    /// The flag to be set when there is a mesh that is written if the work is stopped.
    pub(crate) fn begun(&self) -> &Flag {
        &self.begun
    }

    /// All points are inserted: what is left to do is done, whatever comes.
    pub(crate) fn inserted(&self) {
        self.inserted.set();
    }
}

/// From now on Ctrl-C ends the program at once, with the exit code for it: for commands that have
/// no partial result. A file that is being written is given up first.
pub(crate) fn end_on_signal() -> Result<(), Failure> {
    on_signal(|| give_up(NOTHING_WRITTEN))
}

/// The last words where no output was written.
const NOTHING_WRITTEN: &str = "cancelled; nothing was written";

/// Ends the program with these words, or the writing of a file, which ends the program then.
fn give_up(why: &str) {
    // As long as this is held no file is begun.
    let writing = writing_now();
    match &*writing {
        Some(token) => token.cancel(),
        None => end_now(why),
    }
}

fn on_signal(handler: impl FnMut() + Send + 'static) -> Result<(), Failure> {
    ctrlc::set_handler(handler).map_err(|e| Failure::Machine(format!("cannot catch Ctrl-C: {e}")))
}

#[expect(clippy::exit, reason = "runs on the signal thread, which cannot return from main")]
fn end_now(why: &str) {
    people(&format!("ltbw: {why}"));
    std::process::exit(Exit::Stopped as i32);
}
