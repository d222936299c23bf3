//! The things that a machine may lack: memory, threads, room in a file.
//!
//! Memory is asked for before the work where it is known how much that takes. Where an allocation
//! fails all the same, Rust's standard library says so and aborts; here that ends the program with
//! an exit code of its own.

use crate::outcome::Failure;
#[cfg(unix)]
use crate::{outcome::Exit, sync::Still};

/// From now on a failed allocation ends the program with [`Exit::Machine`], and a file that may not
/// grow any more is an error of writing, not a signal that ends the program.
#[cfg(unix)]
pub(crate) fn watch() -> Result<(), Failure> {
    use signal_hook::consts::{SIGABRT, SIGXFSZ};
    use signal_hook::flag::{register, register_conditional_shutdown};
    // A panic that cannot be carried out aborts, too: that is a defect, and stays one.
    let sound = Still::new();
    let ended = sound.clone();
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        ended.end();
        print(panic);
    }));
    // Nobody looks at this flag: without a handler of the signal there is no error.
    register(SIGXFSZ, Still::new().shared())
        .and_then(|_| register_conditional_shutdown(SIGABRT, Exit::Machine as i32, sound.shared()))
        .map(drop)
        .map_err(|e| Failure::Machine(format!("cannot watch for signals: {e}")))
}

/// Other systems have no such signals.
#[cfg(not(unix))]
pub(crate) fn watch() -> Result<(), Failure> {
    Ok(())
}

/// The threads of each of some processes that share this machine.
pub(crate) fn share(processes: u32) -> u16 {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    u16::try_from(cores / processes.max(1) as usize).unwrap_or(u16::MAX).max(1)
}

/// Starts the threads that sort, check and write: the given number of them, or one for each core.
pub(crate) fn start_threads(threads: Option<u16>) -> Result<(), Failure> {
    let builder = rayon::ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from));
    builder.build_global().map_err(|e| {
        let count = threads.map(|threads| format!("{threads} ")).unwrap_or_default();
        Failure::Machine(format!("cannot start {count}threads: {e}"))
    })
}
