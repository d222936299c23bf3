//! The refinement of a domain, by one engine or by workers that share no mesh.

use crate::console::{self, Stop};
use crate::outcome::{Failure, show};
use ltbw::domain::Prepared;
use ltbw::refine::{ComplexError, RefineOutcome, Refined, Refiner};
use ltbw::refining::{Owners, RefineError, rounds_on_threads};
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
}

/// Refines a prepared domain on as many workers, if that is asked for.
pub(crate) fn refine(
    (refiner, ready): (&Refiner<'_>, &Prepared),
    workers: Option<u32>,
    (stop, name): (&Stop, &Path),
) -> Result<(Refined, Made), Failure> {
    let failed = |error| Failure::Refine { path: name.to_owned(), error };
    let Some(workers) = workers else {
        let refined = refiner.refine(&ready.domain, &ready.lattice).map_err(failed)?;
        return Ok((refined, Made::default()));
    };
    let parallel = Parallel::new(workers).cancel(stop.token());
    let whole = (&ready.domain, &ready.lattice);
    let run = rounds_on_threads(refiner, whole, &parallel).map_err(|error| match error {
        RefineError::Domain(error) => failed(error),
        RefineError::Build(error) => Failure::Build { path: name.to_owned(), error },
        RefineError::Run(error @ RunError::Threads { .. }) => Failure::Machine(error.to_string()),
        error => Failure::Other(format!("{}: {error}", show(name))),
    })?;
    // A run that was stopped before has its own reason, and is told of that.
    let is_whole = matches!(run.refined.outcome, RefineOutcome::Met | RefineOutcome::Excused);
    let is_idle = run.workers.iter().all(|own| own.local + own.operations == 0);
    let why = |ending: Result<_, ComplexError>| match ending {
        Err(why) => why.to_string(),
        Ok(_) => "nothing was left that workers may insert".to_owned(),
    };
    let alone = (is_whole && is_idle).then(|| why(run.ending));
    Ok((run.refined, Made { workers: run.workers, owners: run.owners, alone }))
}

/// Says for people what the workers have done.
pub(crate) fn print_workers(made: &Made) {
    if let Some(why) = &made.alone {
        console::people(&format!("note: one thread has refined it: {why}"));
    }
    if made.workers.is_empty() {
        return;
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
