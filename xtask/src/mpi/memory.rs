//! The calls of MPI under valgrind: buffers that outlive them are where they should be, and every
//! letter is read as far as it was written. `parallel/mpi/src/raw.rs` is the unsafe code there.

use super::{Bench, WATCHDOG, watched};
use crate::require;
use crate::shell::{command, root, works};
use std::path::Path;

/// The defects of Open MPI itself, told by its package; a file of ours has those of its launcher.
const KNOWN: &str = "/usr/share/openmpi/openmpi-valgrind.supp";
const OF_LAUNCHER: &str = "parallel/mpi/valgrind.supp";
/// The exit code where valgrind finds something.
const FOUND: i32 = 99;

/// Runs a small job of two processes under valgrind, with letters of all kinds: of points, of
/// collectives, large and small.
pub(crate) fn run(bench: &Bench) -> Result<(), String> {
    if !works(command("valgrind").arg("--version")) || !Path::new(KNOWN).exists() {
        let reason =
            format!("valgrind or {KNOWN} is missing (apt-get install valgrind openmpi-bin)");
        return require::skip("the calls of MPI under valgrind", "valgrind", &reason);
    }
    let mut job = bench.job(2, false);
    job.args(["valgrind", "--quiet", &format!("--error-exitcode={FOUND}")]);
    job.arg(format!("--suppressions={KNOWN}"));
    job.arg(format!("--suppressions={}", root().join(OF_LAUNCHER).display()));
    job.arg(&bench.ranked).args(["--quiet", "mesh", "tee.poly", "-o", "checked.pvtu"]);
    let outcome = watched(&mut job, WATCHDOG)?;
    match outcome.code {
        Some(0) => println!("the calls of MPI under valgrind: {:.2} s", outcome.seconds),
        code => return Err(format!("under valgrind: {code:?}\n{}", outcome.stderr)),
    }
    Ok(())
}
