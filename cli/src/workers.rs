//! The refinement of a domain, by one engine or by workers that share no mesh: in rounds, or as
//! points come.

use crate::console::{self, Stop};
use crate::outcome::{Failure, show};
use ltbw::domain::Prepared;
use ltbw::mesh::Redeal;
use ltbw::refine::{ComplexError, RefineOutcome, Refined, Refiner};
use ltbw::refining::{
    Owners, RefineError, RoundFigures, Splits, ThreadedDomain, ThreadedRounds, domain_on_threads,
    rounds_on_threads,
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
    /// The moves of the cuts between the workers' parts, if there were any.
    pub(crate) redeals: Option<Redeals>,
    /// Their share of a refinement in rounds.
    pub(crate) share: Option<Share>,
}

/// The share of workers in a refinement in rounds.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub(crate) struct Share {
    /// Vertices of the mesh with which they began, which one has made.
    start: u64,
    /// Their part of the points after that.
    by_workers: f64,
    /// The points of the busiest in this run, times the mean.
    busiest: f64,
}

impl Share {
    /// The share in a mesh of as many vertices; none if no worker has begun.
    pub(crate) fn of(
        figures: &RoundFigures,
        workers: &[WorkerStats],
        vertices: u64,
    ) -> Option<Self> {
        let RoundFigures { started: start, points, parted_points, .. } = *figures;
        let (made, after) = (points + parted_points, vertices.saturating_sub(start));
        let most = workers.iter().map(points_of).max()?;
        let mean = workers.iter().map(points_of).sum::<u64>() as f64 / workers.len() as f64;
        (start > 0 && made > 0 && most > 0).then(|| Self {
            start,
            by_workers: made as f64 / after.max(made) as f64,
            busiest: most as f64 / mean,
        })
    }
}

/// The points of a worker.
fn points_of(own: &WorkerStats) -> u64 {
    own.local + own.operations
}

/// The moves of the cuts between the workers' parts.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub(crate) struct Redeals {
    /// Times that they have moved.
    times: u64,
    /// Tetrahedra that have changed their worker by that.
    tets: u64,
}

impl Redeals {
    /// The moves in rounds, if there were any.
    pub(crate) fn of(figures: &RoundFigures) -> Option<Self> {
        let RoundFigures { redeals: times, moved: tets, .. } = *figures;
        (times > 0).then_some(Self { times, tets })
    }
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
    pub(crate) redeal: Redeal,
}

/// The domain's name, and what stops a run.
#[derive(Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub(crate) name: &'a Path,
    pub(crate) stop: &'a Stop,
}

impl Setting<'_> {
    /// The failure of a crew.
    pub(crate) fn failed(&self, error: RefineError) -> Failure {
        let path = || self.name.to_owned();
        match error {
            RefineError::Domain(error) => Failure::Refine { path: path(), error },
            RefineError::Build(error) => Failure::Build { path: path(), error },
            RefineError::Run(error @ RunError::Threads { .. }) => {
                Failure::Machine(error.to_string())
            }
            error => Failure::Other(format!("{}: {error}", show(self.name))),
        }
    }
}

/// Refines a prepared domain, by a crew if there is one.
pub(crate) fn refine(
    refiner: &Refiner<'_>,
    ready: &Prepared,
    crew: Option<Crew>,
    setting: Setting<'_>,
) -> Result<(Refined, Made), Failure> {
    let whole = (&ready.domain, &ready.lattice);
    let Some(Crew { workers, mode, redeal }) = crew else {
        let failed = |error| Failure::Refine { path: setting.name.to_owned(), error };
        return Ok((refiner.refine(whole.0, whole.1).map_err(failed)?, Made::default()));
    };
    let parallel = Parallel::new(workers).redeal(redeal).cancel(setting.stop.token());
    let run = match mode {
        Mode::Rounds => rounds_on_threads(refiner, whole, &parallel).map(Made::by_rounds),
        Mode::Async => domain_on_threads(refiner, whole.0, whole.1, &parallel).map(Made::freely),
    };
    run.map_err(|error| setting.failed(error))
}

impl Made {
    /// A domain that a crew has refined in rounds, and its part in that.
    pub(crate) fn by_rounds(run: ThreadedRounds) -> (Refined, Self) {
        let points = run.workers.iter().map(points_of).sum();
        let redeals = Redeals::of(&run.figures);
        let vertices = run.refined.mesh().num_vertices() as u64;
        let share = Share::of(&run.figures, &run.workers, vertices);
        let ThreadedRounds { refined, workers, owners, ending, .. } = run;
        let made = Self { workers, owners, redeals, share, ..Self::default() };
        made.told(refined, points, ending.err())
    }

    /// A domain that a crew has refined without rounds, and its part in that.
    pub(crate) fn freely(run: ThreadedDomain) -> (Refined, Self) {
        let splits = run.splits.as_ref().ok().copied();
        let points = splits.map_or(0, |own| own.inserted.into_iter().fold(0, u64::saturating_add));
        let made = Self { workers: run.workers, owners: run.owners, splits, ..Self::default() };
        made.told(run.refined, points, run.splits.err())
    }

    /// Notes why a crew has inserted no point, of this number, if it has not.
    fn told(self, refined: Refined, points: u64, unfit: Option<ComplexError>) -> (Refined, Self) {
        // A run that was stopped before has its own reason, and is told of that.
        let is_whole = matches!(refined.outcome, RefineOutcome::Met | RefineOutcome::Excused);
        let nothing = || "nothing was left that workers may insert".to_owned();
        let why = || unfit.map_or_else(nothing, |why| why.to_string());
        let alone = (is_whole && points == 0).then(why);
        (refined, Self { alone, ..self })
    }
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
            refused.iter().fold(0, |sum: u64, own| sum.saturating_add(*own))
        ));
        // Points that give way, or do nothing, have cavities, too.
        points = "cavities";
    }
    let most = made.workers.iter().map(points_of).max().unwrap_or_default();
    let sum = |of: fn(&WorkerStats) -> u64| made.workers.iter().map(of).sum::<u64>();
    console::people(&format!(
        "workers   {}, of at most {most} {points}; {} points at interfaces, {} setbacks, {} \
         messages",
        made.workers.len(),
        sum(|own| own.interface),
        sum(|own| own.setbacks),
        sum(|own| own.messages)
    ));
    if let Some(Share { start, by_workers, busiest }) = made.share {
        let by_workers = 100.0 * by_workers;
        console::people(&format!(
            "share     {by_workers:.1} % of the points after {start} vertices; the busiest has \
             {busiest:.2} times the mean"
        ));
    }
    if let Some(Redeals { times, tets }) = made.redeals {
        console::people(&format!("redeals   {times}, in which {tets} tetrahedra went elsewhere"));
    }
}
