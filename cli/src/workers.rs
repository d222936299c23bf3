//! The refinement of a domain, by one engine or by workers that share no mesh: in rounds, or as
//! points come.

use crate::console::{self, Stop};
use crate::others::Others;
use crate::outcome::{Failure, show};
use ltbw::domain::Prepared;
use ltbw::refine::{RefineOutcome, Refined, Refiner};
use ltbw::refining::{
    Owners, RefineError, Splits, ThreadedRounds, domain_on_threads, rounds_on_threads,
};
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
    /// The figures of points without rounds.
    pub(crate) splits: Option<Splits>,
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

/// Refines a prepared domain, by a crew if there is one.
pub(crate) fn refine(
    (refiner, ready): (&Refiner<'_>, &Prepared),
    crew: Option<Crew>,
    (stop, name): (&Stop, &Path),
    others: Others<'_>,
) -> Result<Option<(Refined, Made)>, Failure> {
    let failed = |error| Failure::Refine { path: name.to_owned(), error };
    let whole = (&ready.domain, &ready.lattice);
    let Some(Crew { workers, mode }) = crew else {
        return Ok(Some((refiner.refine(whole.0, whole.1).map_err(failed)?, Made::default())));
    };
    let token = stop.token();
    let parallel = Parallel::new(workers).cancel(token);
    // The number of points that they have inserted, and why there is none.
    let of_rounds = |run: ThreadedRounds| {
        let points: u64 = run.workers.iter().map(|own| own.local + own.operations).sum();
        let made = Made { workers: run.workers, owners: run.owners, ..Made::default() };
        (run.refined, made, points, run.ending.err())
    };
    let run = match (mode, others) {
        (_, Some(others)) => match others.refine(refiner, whole, (&parallel, token)) {
            Ok(None) => return Ok(None),
            Ok(Some(run)) => Ok(of_rounds(run)),
            Err(error) => Err(error),
        },
        (Mode::Rounds, _) => rounds_on_threads(refiner, whole, &parallel).map(of_rounds),
        (Mode::Async, _) => domain_on_threads(refiner, whole, &parallel).map(|run| {
            let splits = run.splits.as_ref().ok().copied();
            let points = splits.map_or(0, |own| own.inserted.iter().sum());
            let made = Made { workers: run.workers, owners: run.owners, splits, alone: None };
            (run.refined, made, points, run.splits.err())
        }),
    };
    let (refined, made, points, unfit) = run.map_err(|error| match error {
        RefineError::Domain(error) => failed(error),
        RefineError::Build(error) => Failure::Build { path: name.to_owned(), error },
        RefineError::Run(error @ RunError::Threads { .. }) => Failure::Machine(error.to_string()),
        error => Failure::Other(format!("{}: {error}", show(name))),
    })?;
    // A run that was stopped before has its own reason, and is told of that.
    let is_whole = matches!(refined.outcome, RefineOutcome::Met | RefineOutcome::Excused);
    let nothing = || "nothing was left that workers may insert".to_owned();
    let why = || unfit.map_or_else(nothing, |why| why.to_string());
    let alone = (is_whole && points == 0).then(why);
    Ok(Some((refined, Made { alone, ..made })))
}

/// Says for people what the workers have done.
pub(crate) fn print_workers(made: &Made) {
    if let Some(why) = &made.alone {
        console::people(&format!("note: one thread has refined it: {why}"));
    }
    if made.workers.is_empty() {
        return;
    }
    let mut points = "points";
    if let Some(Splits { inserted: [segments, facets, inside], deferred, refused, .. }) =
        made.splits
    {
        console::people("note: made without rounds: another run makes another mesh");
        console::people(&format!(
            "by them   {segments} points on segments, {facets} on facets, {inside} inside; \
             {deferred} gave way, {} left to one processor",
            refused.iter().sum::<u64>()
        ));
        // Points that give way, or do nothing, have cavities, too.
        points = "cavities";
    }
    let count = |own: &WorkerStats| own.local + own.operations;
    let most = made.workers.iter().map(count).max().unwrap_or_default();
    let sum = |of: fn(&WorkerStats) -> u64| made.workers.iter().map(of).sum::<u64>();
    console::people(&format!(
        "workers   {}, of at most {most} {points}; {} points at interfaces, {} setbacks, {} \
         messages",
        made.workers.len(),
        sum(|own| own.interface),
        sum(|own| own.setbacks),
        sum(|own| own.messages)
    ));
}
