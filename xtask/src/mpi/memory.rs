//! The calls of MPI under valgrind: buffers that outlive them are where they should be, and every
//! letter is read as far as it was written. `parallel/mpi/src/raw.rs` is the unsafe code there.

use super::{Bench, WATCHDOG, watched};
use crate::require;
use crate::shell::{command, works};
use std::path::Path;

/// The defects of Open MPI itself, told by its package.
const KNOWN: &str = "/usr/share/openmpi/openmpi-valgrind.supp";
/// The exit code where valgrind finds something.
const FOUND: i32 = 99;

/// Runs small jobs of two processes under valgrind; returns their number.
pub(crate) fn run(bench: &Bench) -> Result<u32, String> {
    if !works(command("valgrind").arg("--version")) || !Path::new(KNOWN).exists() {
        let reason = format!("valgrind or {KNOWN} is missing (apt-get install valgrind)");
        require::skip("the calls of MPI under valgrind", "valgrind", &reason)?;
        return Ok(0);
    }
    bench.generate(&["uniform", "300", "-o", "uniform-300.npy"])?;
    // A mesh in parts has letters of all kinds: of points, of collectives, large and small.
    let jobs = [&["delaunay", "uniform-300.npy", "-o", "checked.pvtu"][..], &["mesh", "tee.poly"]];
    for arguments in jobs {
        let mut job = bench.job(2, false);
        job.args(["valgrind", "--quiet", &format!("--error-exitcode={FOUND}")]);
        job.arg(format!("--suppressions={KNOWN}")).arg(&bench.ranked).arg("--quiet");
        let outcome = watched(job.args(arguments), WATCHDOG)?;
        if outcome.code != Some(0) {
            return Err(format!("{arguments:?}: {:?}\n{}", outcome.code, outcome.stderr));
        }
        println!("{arguments:?} under valgrind: {:.2} s", outcome.seconds);
    }
    Ok(jobs.len() as u32)
}
