//! The refinement of a domain, by one engine or by workers that share no mesh: in rounds, or as
//! points come.

use crate::console::{self, Stop};
use crate::outcome::{Failure, show};
use crate::rounds::START;
use ltbw::domain::Prepared;
use ltbw::refine::{RefineOutcome, Refined, Refiner};
use ltbw::refining::{Owners, RefineError, domain_on_threads, rounds_on_threads};
use ltbw::threads::{Parallel, RunError, WorkerStats};
use std::path::Path;

/// The part of workers in a refinement; of none if there were none.
#[derive(Default)]
pub(crate) struct Made {
    /// The figures of each.
    pub(crate) workers: Vec<WorkerStats>,
    /// The workers that have its tetrahedra.
    pub(crate) owners: Owners,
    /// Why one thread has refined all.
    pub(crate) alone: Option<String>,
    /// Did points come without rounds?
    pub(crate) is_timed: bool,
}

/// The mode in which workers refine a domain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Mode {
    // All choose together, then insert: one mesh.
    #[default]
    Rounds,
    // The paper's: each processor its own bad tetrahedra, as they come; another mesh each time.
    Async,
}

/// The workers that refine a domain without a common mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crew {
    pub(crate) workers: u32,
    pub(crate) mode: Mode,
}

/// Vertices of each worker where points come one by one: with fewer, most cavities reach an
/// interface.
pub(crate) const START_EACH: usize = 2048;
/// Tetrahedra of a mesh for each of the largest volume that its domain holds, about.
const TETS_PER_VOLUME: f64 = 1.9;
/// And for each vertex.
const TETS_PER_VERTEX: f64 = 5.5;

/// Vertices at which workers begin that do without rounds: a quarter of what a bound on volumes
/// predicts, but no more than they can use.
pub(crate) fn start_of(workers: u32, ready: &Prepared, max_volume: Option<f64>) -> usize {
    let most = (START_EACH * workers as usize).max(START);
    let volume = ready.report.volume().map_or(0.0, |volume| volume.to_f64());
    let tets = max_volume.map(|bound| TETS_PER_VOLUME * volume / bound);
    // A conversion of floats saturates.
    let vertices = tets.map_or(usize::MAX, |tets| (tets / TETS_PER_VERTEX) as usize);
    most.min(vertices / 4)
}

/// Refines a prepared domain, with the bound on volumes that is asked for, by a crew if there is
/// one.
pub(crate) fn refine(
    (refiner, ready): (Refiner<'_>, &Prepared),
    (crew, max_volume): (Option<Crew>, Option<f64>),
    (stop, name): (&Stop, &Path),
) -> Result<(Refined, Made), Failure> {
    let failed = |error| Failure::Refine { path: name.to_owned(), error };
    let whole = (&ready.domain, &ready.lattice);
    let Some(Crew { workers, mode }) = crew else {
        return Ok((refiner.refine(whole.0, whole.1).map_err(failed)?, Made::default()));
    };
    let parallel = Parallel::new(workers).cancel(stop.token());
    let run = match mode {
        Mode::Rounds => rounds_on_threads(&refiner, whole, &parallel).map(|run| {
            (run.refined, run.workers, run.owners, run.ending.map_or_else(Some, |_| None))
        }),
        Mode::Async => {
            let refiner = refiner.start(start_of(workers, ready, max_volume));
            domain_on_threads(&refiner, whole, &parallel)
                .map(|run| (run.refined, run.workers, run.owners, run.splits.err()))
        }
    };
    let (refined, workers, owners, unfit) = run.map_err(|error| match error {
        RefineError::Domain(error) => failed(error),
        RefineError::Build(error) => Failure::Build { path: name.to_owned(), error },
        RefineError::Run(error @ RunError::Threads { .. }) => Failure::Machine(error.to_string()),
        error => Failure::Other(format!("{}: {error}", show(name))),
    })?;
    // A run that was stopped before has its own reason, and is told of that.
    let is_whole = matches!(refined.outcome, RefineOutcome::Met | RefineOutcome::Excused);
    let is_idle = workers.iter().all(|own| own.local + own.operations == 0);
    let nothing = || "nothing was left that workers may insert".to_owned();
    let alone = (is_whole && is_idle).then(|| unfit.map_or_else(nothing, |why| why.to_string()));
    let is_timed = mode == Mode::Async && alone.is_none();
    Ok((refined, Made { workers, owners, alone, is_timed }))
}

/// Says for people what the workers have done.
pub(crate) fn print_workers(made: &Made) {
    if let Some(why) = &made.alone {
        console::people(&format!("note: one thread has refined it: {why}"));
    }
    if made.workers.is_empty() {
        return;
    }
    if made.is_timed {
        console::people("note: made without rounds: another run makes another mesh");
    }
    let count = |own: &WorkerStats| own.local + own.operations;
    let most = made.workers.iter().map(count).max().unwrap_or_default();
    let sum = |of: fn(&WorkerStats) -> u64| made.workers.iter().map(of).sum::<u64>();
    console::people(&format!(
        "workers   {}, of at most {most} points; {} points at interfaces, {} setbacks, {} messages",
        made.workers.len(),
        sum(|own| own.interface),
        sum(|own| own.setbacks),
        sum(|own| own.messages)
    ));
}
