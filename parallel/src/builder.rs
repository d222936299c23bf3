//! The builder of meshes of points, on any number of threads.

use crate::balance::Balance;
use crate::metrics::{Summary, Trace};
use crate::sync::Mutex;
use crate::threads::{Distributed, PAUSE, Parallel, Run, RunError, WorkerStats};
use ltbw_core::build::Builder as Sequential;
use ltbw_core::{
    Budget, BuildError, CancelToken, Duplicate, Mesh, Observer, Order, Outcome, Phase, Progress,
    Stats, Vertex,
};
use ltbw_exact::PointSet;
use std::fmt;
use std::sync::PoisonError;
use std::time::Instant;

/// Builds the Delaunay mesh of a point set, on one thread or several.
///
/// The mesh is one function of the points and of the budget, whatever the number of threads. One
/// thread is the sequential kernel; several are those of [`Parallel`], which has more settings.
///
/// ```
/// use ltbw::prelude::*;
/// let points = (0..200).map(|i| [i * 37 % 101, i * 53 % 103, i * 71 % 107].map(f64::from));
/// let set = PointSet::new(points.collect())?;
/// let show = |p: Progress| println!("{:?}: {} of {:?}", p.phase, p.done, p.total);
/// let built = Builder::new().threads(2).observer(&show).build(&set)?;
/// assert_eq!(built.outcome, Outcome::Complete);
/// assert_eq!(built.mesh.hash()?, Builder::new().build(&set)?.mesh.hash()?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub struct Builder<'a> {
    threads: u32,
    order: Order,
    budget: Budget,
    cancel: Option<&'a CancelToken>,
    observer: Option<&'a dyn Observer>,
    balance: Option<Balance>,
    spans: Option<usize>,
    parts: bool,
}

impl Default for Builder<'_> {
    fn default() -> Self {
        Self {
            threads: 1,
            order: Order::default(),
            budget: Budget::default(),
            cancel: None,
            observer: None,
            balance: None,
            spans: None,
            parts: false,
        }
    }
}

impl fmt::Debug for Builder<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Builder")
            .field("threads", &self.threads)
            .field("order", &self.order)
            .field("budget", &self.budget)
            .field("cancel", &self.cancel)
            .field("observer", &self.observer.is_some())
            .field("balance", &self.balance)
            .field("spans", &self.spans)
            .field("parts", &self.parts)
            .finish()
    }
}

/// A mesh and how it came about.
#[derive(Debug)]
#[non_exhaustive]
pub struct Built {
    /// The mesh: of all points if `outcome` is [`Outcome::Complete`].
    pub mesh: Mesh,
    /// The outcome: whether all points are in the mesh.
    pub outcome: Outcome,
    /// Figures of the build. With several threads the seconds of the order are those before the
    /// workers start, and the seconds of the insertion those until the mesh is one.
    pub stats: Stats,
    /// Duplicates met, by input indices, ascending.
    pub duplicates: Vec<Duplicate>,
    /// Figures by worker; empty if one thread inserted.
    pub workers: Vec<WorkerStats>,
    /// The figures of the workers' time, if [`Builder::measure`] asked for them.
    pub summary: Option<Summary>,
    /// The timeline of the workers, if [`Builder::measure`] asked for one.
    pub trace: Option<Trace>,
    /// The tetrahedra by the worker that had them, if [`Builder::parts`] asked for them.
    pub parts: Vec<Vec<[Vertex; 4]>>,
}

impl<'a> Builder<'a> {
    /// A builder for one thread, with the default order and no limits.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the number of threads that insert points, at least one.
    ///
    /// The points are sorted by the threads of rayon's pool.
    pub fn threads(mut self, threads: u32) -> Self {
        self.threads = threads.max(1);
        self
    }

    /// Sets the insertion order. Several threads have an order of their own: with them it decides
    /// only which points a budget allows.
    pub fn order(mut self, order: Order) -> Self {
        self.order = order;
        self
    }

    /// Sets limits on the work.
    ///
    /// A limit of points means the same for any number of threads: the mesh has the points that
    /// come first in the insertion order. What a limit of tetrahedra allows depends on how each
    /// point is inserted after the other: with such a limit one thread inserts them all.
    pub fn budget(mut self, budget: Budget) -> Self {
        self.budget = budget;
        self
    }

    /// Sets the token that cancels the work. The result is the mesh of the points inserted before.
    pub fn cancel(mut self, token: &'a CancelToken) -> Self {
        self.cancel = Some(token);
        self
    }

    /// Sets the observer of progress. It is called from the calling thread: as a phase begins,
    /// while points are inserted ten times a second at most, and when all are.
    pub fn observer(mut self, observer: &'a dyn Observer) -> Self {
        self.observer = Some(observer);
        self
    }

    /// Lets blocks move to threads that run out of points ([`Parallel::balance`]).
    pub fn balance(mut self, balance: Balance) -> Self {
        self.balance = Some(balance);
        self
    }

    /// Takes the time of every step of several threads, for [`Built::summary`]; keeps up to `spans`
    /// stretches of each worker's time, for [`Built::trace`] ([`Parallel::measure`]).
    pub fn measure(mut self, spans: usize) -> Self {
        self.spans = Some(spans);
        self
    }

    /// Keeps the tetrahedra of each worker, for [`Built::parts`].
    pub fn parts(mut self) -> Self {
        self.parts = true;
        self
    }

    /// Builds the mesh.
    ///
    /// Cost: expected O(n log n) time for points without large degenerate cavities; about 370
    /// bytes a point, beside the input, for uniform points.
    ///
    /// A build that stops early has the valid mesh of the points inserted before, and
    /// [`Built::outcome`] says why.
    ///
    /// # Errors
    /// [`RunError::Build`] says why there is no first tetrahedron; the others are about several
    /// threads alone.
    pub fn build(&self, set: &PointSet) -> Result<Built, RunError> {
        let mut sequential = Sequential::new().order(self.order).budget(self.budget);
        if let Some(token) = self.cancel {
            sequential = sequential.cancel(token);
        }
        if self.threads > 1 && self.budget.max_tets.is_none() {
            return self.build_in_parallel(&sequential, set);
        }
        let throttle = self.observer.map(Throttle::new);
        if let Some(throttle) = &throttle {
            let total = Some(sequential.allowed(set.len()) as u64);
            throttle.progress(Progress { phase: Phase::Order, done: 0, total });
            sequential = sequential.observer(throttle);
        }
        let ltbw_core::build::Built { mesh, outcome, stats, duplicates } = sequential.build(set)?;
        let parts = if self.parts { vec![mesh.tets().collect()] } else { Vec::new() };
        let (workers, summary, trace) = (Vec::new(), None, None);
        Ok(Built { mesh, outcome, stats, duplicates, workers, summary, trace, parts })
    }

    /// Was the work not cancelled?
    fn still(&self) -> Result<(), RunError> {
        match self.cancel.is_some_and(CancelToken::is_cancelled) {
            true => Err(BuildError::Cancelled.into()),
            false => Ok(()),
        }
    }

    /// Builds the mesh of the points of all slices as one member of a team: each gets its own part.
    ///
    /// # Errors
    /// As [`Parallel::build_on`]; a team has no budget.
    #[cfg(feature = "wire")]
    #[doc(hidden)]
    pub fn build_on(
        &self,
        team: &mut crate::team::Team,
        slice: &crate::distributed::Slice,
    ) -> Result<crate::threads::BuiltPart, RunError> {
        if self.budget != Budget::default() {
            return Err(RunError::Settings("a team has no budget".to_owned()));
        }
        self.kernel(team.size(), None).among_processes().build_on(team, slice)
    }

    /// Builds the mesh by several threads.
    fn build_in_parallel(
        &self,
        sequential: &Sequential<'_>,
        set: &PointSet,
    ) -> Result<Built, RunError> {
        self.still()?;
        let clock = Instant::now();
        let total = sequential.allowed(set.len());
        // Which points a budget allows, the order of all of them tells: some time for many.
        if let (Some(observer), true) = (self.observer, total < set.len()) {
            observer.progress(Progress { phase: Phase::Order, done: 0, total: Some(total as u64) });
        }
        let only = sequential.allowed_points(set)?;
        let choice_seconds = clock.elapsed().as_secs_f64();
        self.still()?;
        let kernel = self.kernel(self.threads, only.as_deref());
        let mut built = self.put_together(&kernel, kernel.build_distributed(set)?)?;
        built.stats.order_seconds += choice_seconds;
        if only.is_some() && built.outcome == Outcome::Complete {
            built.outcome = Outcome::Budget;
        }
        Ok(built)
    }

    /// The parallel kernel with these settings, for the points with these numbers.
    fn kernel<'k>(&self, workers: u32, only: Option<&'k [Vertex]>) -> Parallel<'k>
    where
        'a: 'k,
    {
        let mut kernel = Parallel::new(workers).only(only);
        if let Some(token) = self.cancel {
            kernel = kernel.cancel(token);
        }
        if let Some(observer) = self.observer {
            kernel = kernel.observer(observer);
        }
        if let Some(balance) = self.balance {
            kernel = kernel.balance(balance);
        }
        if let Some(spans) = self.spans {
            kernel = kernel.measure(spans);
        }
        kernel
    }

    /// The mesh of all parts.
    fn put_together(&self, kernel: &Parallel<'_>, apart: Distributed) -> Result<Built, RunError> {
        let count = if self.parts { apart.parts() } else { 0 };
        let parts = (0..count).map(|part| apart.tets(part).collect()).collect();
        let run = kernel.gather(apart)?;
        let stats = Stats {
            order_seconds: run.start_seconds,
            insert_seconds: run.insert_seconds + run.gather_seconds,
            predicates: run.mesh.predicate_stats(),
        };
        let Run { mesh, outcome, duplicates, workers, summary, trace, .. } = run;
        Ok(Built { mesh, outcome, stats, duplicates, workers, summary, trace, parts })
    }
}

/// An observer that is called by time.
struct Throttle<'a> {
    observer: &'a dyn Observer,
    /// The phase of the last report, and its time.
    last: Mutex<Option<(Phase, Instant)>>,
}

impl<'a> Throttle<'a> {
    fn new(observer: &'a dyn Observer) -> Self {
        Self { observer, last: Mutex::new(None) }
    }
}

impl Observer for Throttle<'_> {
    fn progress(&self, progress: Progress) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let is_new =
            |&(phase, time): &(Phase, Instant)| phase != progress.phase || time.elapsed() >= PAUSE;
        if progress.total == Some(progress.done) || last.as_ref().is_none_or(is_new) {
            self.observer.progress(progress);
            *last = Some((progress.phase, Instant::now()));
        }
    }
}
