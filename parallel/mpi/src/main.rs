//! The program `ltbw-mpi`: the commands `delaunay` and `mesh` of `ltbw` by the processes of an MPI
//! job, which share nothing. `docs/distributed.md` tells how it is built and run.
//!
//! | module | what it holds |
//! |---|---|
//! | `raw` | the calls of MPI, unsafe code |
//! | `post` | letters from process to process |
#![deny(unsafe_code)]

mod post;
#[allow(unsafe_code)]
mod raw;

use ltbw::team::Team;
use ltbw_cli::ranks::{Checkpoint, Ended, run};
use mpi::environment::{Threading, initialize_with_threading};
use mpi::topology::{Communicator, SimpleCommunicator};
use post::{Mpi, Waiting};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::process::ExitCode;
use std::thread::current;
use std::time::Duration;

/// The exit code of a panic: that of an internal software error in `sysexits.h`.
const PANIC: u8 = 70;

fn main() -> ExitCode {
    let Some((universe, threading)) = initialize_with_threading(Threading::Funneled) else {
        eprintln!("ltbw-mpi: MPI is initialised already");
        return ExitCode::from(7);
    };
    let world = universe.world();
    let rank = world.rank();
    if threading < Threading::Funneled {
        eprintln!("ltbw-mpi: this MPI cannot be used beside other threads (MPI_THREAD_FUNNELED)");
        world.abort(7);
    }
    abort_on_panic(rank);
    let asked = std::env::var("LTBW_MPI_WAIT").ok();
    let waiting = match Waiting::of(&world, asked.as_deref()) {
        Ok(waiting) => waiting,
        Err(why) => {
            eprintln!("ltbw-mpi: rank {rank}: {why}");
            world.abort(2);
        }
    };
    let latency = asked_for("LTBW_MPI_LATENCY_US").map_or(Duration::ZERO, Duration::from_micros);
    let fault = asked_for("LTBW_MPI_PANIC_RANK").filter(|&asked| i64::from(rank) == asked as i64);
    let fault = fault.and(asked_for("LTBW_MPI_PANIC_LETTER"));
    let mut team = Team::new(Mpi::new(&world, waiting, fault)).latency(latency);
    let checkpoint = match checkpoint() {
        Ok(checkpoint) => checkpoint,
        Err(why) => {
            eprintln!("ltbw-mpi: rank {rank}: {why}");
            world.abort(2);
        }
    };
    // A panic of another thread comes here with whatever that was to do.
    let ended = catch_unwind(AssertUnwindSafe(|| run(&mut team, checkpoint)));
    match ended.unwrap_or(Ended::Alone(PANIC)) {
        Ended::Together(code) => {
            drop(team);
            ExitCode::from(code)
        }
        // The others wait for this process.
        Ended::Alone(code) => world.abort(code.into()),
    }
}

/// Rounds from one checkpoint to the next, if nothing else is said.
const EVERY: u64 = 50;

/// The checkpoints that the environment asks for.
fn checkpoint() -> Result<Option<Checkpoint>, String> {
    let asked = std::env::var("LTBW_MPI_CHECKPOINT_ROUNDS").ok();
    let every = match asked.as_deref().map(str::parse) {
        None => EVERY,
        Some(Ok(every)) if every > 0 => every,
        _ => return Err("LTBW_MPI_CHECKPOINT_ROUNDS is no number from 1 on".to_owned()),
    };
    let path = std::env::var_os("LTBW_MPI_CHECKPOINT");
    Ok(path.map(|path| Checkpoint { path: path.into(), every }))
}

/// A number of the environment, for tests: they delay letters, and plant panics.
fn asked_for(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// A process that panics would wait for the others in the end, and these for it: the job ends. MPI
/// is this thread's alone.
fn abort_on_panic(rank: i32) {
    let (print, here) = (take_hook(), current().id());
    set_hook(Box::new(move |panic| {
        eprintln!("ltbw-mpi: rank {rank}: a panic; this is a defect of the program");
        print(panic);
        if current().id() == here {
            SimpleCommunicator::world().abort(PANIC.into());
        }
    }));
}
