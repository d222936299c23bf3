//! The thread runtime: one thread for each worker, in one process.
//!
//! Threads share nothing but mailboxes. A worker takes its messages before every burst of local
//! work (the paper's queues QR before QL before LB) and sleeps when there is neither.

mod distributed;
mod failure;
mod hooks;
#[cfg(feature = "wire")]
mod ranks;
mod spawn;
mod teller;
mod watchdog;
mod worker_loop;

pub use distributed::Distributed;
pub use failure::RunError;
pub use hooks::BURST;
#[cfg(feature = "wire")]
#[doc(hidden)]
pub use ranks::BuiltPart;
#[doc(hidden)]
pub use worker_loop::{Broken, Ended, Loop, RuntimeHooks};

use crate::balance::{Balance, Workload};
use crate::mailbox::connect;
#[doc(inline)]
pub use crate::mesh::{Layout, Ownership};
use crate::mesh::{LocalMesh, PointQueue, Prepared, Redeal, SharedInput, Wanted};
use crate::metrics::{Collector, SubmeshSize, Summary, Trace};
use crate::payload::Payload;
#[doc(inline)]
pub use crate::protocol::{Closure, Config, Rule};
use crate::protocol::{Correct, Note, Source, Submesh, Worker, WorkerId};
use crate::transport::{Delayed, Mail, Transport};
use hooks::{Running, ThreadHooks};
use ltbw_core::{CancelToken, Duplicate, Mesh, Observer, Outcome, Phase, Vertex};
use ltbw_exact::PointSet;
use spawn::{End, any_thread, run_all};
use std::time::{Duration, Instant};
pub(crate) use teller::PAUSE;
use teller::{Listener, Teller};

/// A submesh that may go from one thread to another, and so may all that it sends.
pub(crate) trait Travels:
    Submesh<Tet: Send, Point: Send, Piece: Send, Patch: Send, Cargo: Send, News: Send> + Send
{
}

impl<S> Travels for S where
    S: Submesh<Tet: Send, Point: Send, Piece: Send, Patch: Send, Cargo: Send, News: Send> + Send
{
}

/// Shortest backoff of the paper's rule, beside four latencies.
const BACKOFF: Duration = Duration::from_micros(20);

type Node<S = LocalMesh, Q = PointQueue> = Worker<S, Q>;

/// Figures of one worker.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WorkerStats {
    /// Points inserted at once, without a lock.
    pub local: u64,
    /// Operations committed.
    pub operations: u64,
    /// Operations with parts at more than one worker.
    pub interface: u64,
    /// Attempts set back.
    pub setbacks: u64,
    /// Most setbacks of one operation.
    pub worst_setbacks: u32,
    /// Messages sent.
    pub messages: u64,
    /// Blocks given away.
    pub migrated: u64,
    /// Looks at the mailbox, and those that found something.
    pub polls: [u64; 2],
    /// Seconds from the first turn of its loop to the last one.
    pub seconds: f64,
}

impl WorkerStats {
    /// Adds the figures of a later run of the same worker.
    pub(crate) fn add(&mut self, other: &Self) {
        self.local += other.local;
        self.operations += other.operations;
        self.interface += other.interface;
        self.setbacks += other.setbacks;
        self.worst_setbacks = self.worst_setbacks.max(other.worst_setbacks);
        self.messages += other.messages;
        self.migrated += other.migrated;
        for (sum, polls) in self.polls.iter_mut().zip(other.polls) {
            *sum += polls;
        }
        self.seconds += other.seconds;
    }

    fn note(&mut self, note: Note) {
        match note {
            Note::Local => self.local += 1,
            Note::SetBack { attempt, .. } => {
                self.setbacks += 1;
                self.worst_setbacks = self.worst_setbacks.max(attempt.number());
            }
            Note::Committed { parts, .. } => {
                self.operations += 1;
                self.interface += u64::from(parts > 1);
            }
            Note::Migrated(_) => self.migrated += 1,
            Note::Duplicate | Note::Gone | Note::Began(_) | Note::Waits(_) | Note::Stopped => {}
        }
    }
}

/// A mesh and how it came about.
#[derive(Debug)]
pub struct Run {
    /// The mesh: of all points if `outcome` is [`Outcome::Complete`].
    pub mesh: Mesh,
    /// The outcome: whether all points are in the mesh.
    pub outcome: Outcome,
    /// Duplicates met, by input indices, ascending.
    pub duplicates: Vec<Duplicate>,
    /// Seconds to order the points, to build and distribute the coarse mesh.
    pub start_seconds: f64,
    /// Seconds of the workers.
    pub insert_seconds: f64,
    /// Seconds to put the submeshes together.
    pub gather_seconds: f64,
    /// By worker.
    pub workers: Vec<WorkerStats>,
    /// The figures of the workers' time, if [`Parallel::measure`] asked for them.
    pub summary: Option<Summary>,
    /// The timeline of the run, if one was asked for.
    pub trace: Option<Trace>,
}

/// Builds the Delaunay mesh of a point set on several threads.
///
/// The mesh is that of [`ltbw_core::Builder`], whatever the number of workers and the timing.
///
/// ```
/// use ltbw::{Builder, PointSet, threads::Parallel};
/// let points = (0..200).map(|i| [i * 37 % 101, i * 53 % 103, i * 71 % 107].map(f64::from));
/// let set = PointSet::new(points.collect())?;
/// let run = Parallel::new(2).build(&set)?;
/// assert_eq!(run.mesh.hash()?, Builder::new().build(&set)?.mesh.hash()?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Parallel<'a> {
    workers: u32,
    rule: Rule,
    closure: Closure,
    window: usize,
    latency: Duration,
    layout: Option<Layout>,
    /// Not an option: optimised code looks at the numbers before it looks whether blocks move, and
    /// memcheck takes that for a use of what was never written.
    balance: Balance,
    is_balanced: bool,
    redeal: Redeal,
    spans: Option<usize>,
    cancel: Option<&'a CancelToken>,
    listener: Listener<'a>,
    only: Option<&'a [Vertex]>,
}

/// A worker at its end, and its figures.
pub(crate) type Measured<S, Q> = (Node<S, Q>, WorkerStats);

impl<'a> Parallel<'a> {
    /// A run on `workers` threads, at least one.
    ///
    /// Without [`Parallel::layout`] the layout is [`Layout::new`], with [`Ownership::Newest`]
    /// unless [`Parallel::balance`] lets blocks move.
    pub fn new(workers: u32) -> Self {
        let workers = workers.max(1);
        // Between threads a message takes microseconds: few operations hide that, and few are in
        // each other's way.
        let window = 16;
        let rule = Rule::default();
        Self {
            workers,
            rule,
            closure: Closure::default(),
            window,
            latency: Duration::ZERO,
            layout: None,
            balance: Balance::default(),
            is_balanced: false,
            redeal: Redeal::Never,
            spans: None,
            cancel: None,
            listener: Listener::default(),
            only: None,
        }
    }

    /// Sets the conflict rule.
    pub fn rule(mut self, rule: Rule) -> Self {
        self.rule = rule;
        self
    }

    /// Sets what an operation locks.
    pub fn closure(mut self, closure: Closure) -> Self {
        self.closure = closure;
        self
    }

    /// Sets how many operations a worker has under way at most.
    pub fn window(mut self, window: usize) -> Self {
        self.window = window.max(1);
        self
    }

    /// Sets the window of processes: their messages may take hundreds of microseconds, in which one
    /// inserts as many points.
    pub fn among_processes(self) -> Self {
        self.window(64)
    }

    /// Delays every message: to see how the kernel tolerates it.
    pub fn latency(mut self, latency: Duration) -> Self {
        self.latency = latency;
        self
    }

    /// Sets the layout; its number of workers is replaced by that of the run. [`Layout::new`] owns
    /// by blocks, which is slower and needed only if they are to move.
    pub fn layout(mut self, layout: Layout) -> Self {
        self.layout = Some(Layout { workers: self.workers, ..layout });
        self
    }

    /// Lets workers that run out of points ask others for blocks. Not done otherwise: the blocks
    /// are even at the start, and what moves has to be found out about by all.
    pub fn balance(mut self, balance: Balance) -> Self {
        (self.balance, self.is_balanced) = (balance, true);
        self
    }

    /// Sets when the cuts between the workers' parts of a domain move between rounds; a layout that
    /// is set has its own. The mesh is the same.
    pub fn redeal(mut self, redeal: Redeal) -> Self {
        self.redeal = redeal;
        self
    }

    /// Takes the time of every step, for [`Run::summary`]; keeps up to `spans` stretches of each
    /// worker's time, for [`Run::trace`]. Costs two looks at the clock per insertion.
    pub fn measure(mut self, spans: usize) -> Self {
        self.spans = Some(spans);
        self
    }

    /// Sets the token that cancels the run. The result is the mesh of the points inserted before.
    pub fn cancel(mut self, token: &'a CancelToken) -> Self {
        self.cancel = Some(token);
        self
    }

    /// Sets the observer of progress. It is called from the calling thread alone: ten times a
    /// second at most while points are inserted, and once as the other phases begin. No worker
    /// waits for it.
    pub fn observer(mut self, observer: &'a dyn Observer) -> Self {
        self.listener = Listener(Some(observer));
        self
    }

    /// Inserts the points with these numbers alone, each of them named once.
    pub(crate) fn only(mut self, points: Option<&'a [Vertex]>) -> Self {
        self.only = points;
        self
    }

    /// Builds the mesh.
    ///
    /// # Errors
    /// [`RunError`] says why there is no mesh.
    pub fn build(&self, set: &PointSet) -> Result<Run, RunError> {
        let parts = self.build_distributed(set)?;
        self.gather(parts)
    }

    /// Puts the parts together, and says so.
    pub(crate) fn gather(&self, parts: Distributed) -> Result<Run, RunError> {
        let points = parts.common.points.len() as u64;
        self.listener.tell(Phase::Gather, points, points);
        parts.gather()
    }

    /// Builds the mesh and leaves it distributed: every worker has its submesh.
    ///
    /// # Errors
    /// [`RunError`] says why there is no mesh.
    pub fn build_distributed(&self, set: &PointSet) -> Result<Distributed, RunError> {
        let clock = Instant::now();
        let points = self.only.map_or(set.len(), <[Vertex]>::len);
        let total = points as u64;
        let layout = self.plan_for(points);
        if layout.ownership != Ownership::Block && self.is_balanced {
            return Err(RunError::Settings(Ownership::STAYS.to_owned()));
        }
        self.listener.tell(Phase::Order, 0, total);
        let layout = Layout { reserve: true, ..layout };
        let prepared = layout.prepare(set, &self.wanted())?;
        let Prepared { workers, common, started, .. } = prepared;
        let config = self.config();
        let nodes: Vec<Node> = workers
            .into_iter()
            .map(|(directory, mesh, field)| Worker::new(config, directory, mesh, field))
            .collect();
        self.run_nodes(nodes, common, [started as u64, total], clock)
    }

    /// The configuration of each worker.
    pub fn config(&self) -> Config {
        let Self { rule, closure, window, .. } = *self;
        Config { rule, closure, window, ..Config::new(self.workers) }
    }

    /// The part of the start that this process makes.
    fn wanted(&self) -> Wanted<'_> {
        Wanted { only: self.only, cancel: self.cancel, ..Wanted::default() }
    }

    /// Runs workers until all points are in, and gives them back with their figures.
    pub(crate) fn run_workers<S, Q>(
        &self,
        nodes: Vec<Node<S, Q>>,
    ) -> Result<Vec<Measured<S, Q>>, RunError>
    where
        S: Payload + SubmeshSize + Travels,
        Q: Source<S> + Workload + Send,
    {
        let clock = Instant::now();
        let teller = Teller::new(Listener::default(), 0, 0);
        let hooks = |id| self.hooks(id, clock).counted(teller.tally()).watched(teller.watch(id));
        let ends = self.run_with_hooks(nodes, &teller, hooks)?;
        let ended = ends.into_iter().map(|(node, hooks)| {
            let (figures, _) = hooks.finish(node.mesh());
            (node, figures)
        });
        Ok(ended.collect())
    }

    fn run_with_hooks<S, Q, W>(
        &self,
        nodes: Vec<Node<S, Q>>,
        teller: &Teller<'_>,
        hooks: impl Fn(WorkerId) -> W,
    ) -> Result<Vec<End<S, Q, W>>, RunError>
    where
        S: Travels,
        Q: Source<S> + Workload + Send,
        W: RuntimeHooks<S> + Send,
    {
        if self.latency.is_zero() {
            return run_all(self.loops(nodes, connect(self.workers), hooks), teller, any_thread);
        }
        let ways = connect(self.workers).into_iter();
        let ways = ways.map(|way| Delayed::new(way, self.latency)).collect();
        run_all(self.loops(nodes, ways, hooks), teller, any_thread)
    }

    /// Runs workers to their end. `started` and `total` are numbers of points to tell of; the start
    /// began at `clock`.
    fn run_nodes(
        &self,
        nodes: Vec<Node>,
        common: SharedInput,
        [started, total]: [u64; 2],
        clock: Instant,
    ) -> Result<Distributed, RunError> {
        let teller = Teller::new(self.listener, started, total);
        let start_seconds = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let hooks = |id| self.hooks(id, clock).counted(teller.tally()).watched(teller.watch(id));
        let ends = self.run_with_hooks(nodes, &teller, hooks)?;
        let insert_seconds = clock.elapsed().as_secs_f64();
        let cancelled = ends.iter().any(|(node, _)| node.has_dropped_points());
        let (mut meshes, mut stats, mut collectors) = (Vec::new(), Vec::new(), Vec::new());
        for (node, hooks) in ends {
            let (figures, collector) = hooks.finish(node.mesh());
            stats.push(figures);
            collectors.extend(collector);
            meshes.push(node.into_parts().0);
        }
        let (summary, trace) = self.summary(collectors);
        let outcome = if cancelled {
            Outcome::Cancelled
        } else {
            self.listener.tell(Phase::Insert, total, total);
            Outcome::Complete
        };
        let seconds = [start_seconds, insert_seconds];
        Ok(Distributed { meshes, common, outcome, seconds, workers: stats, summary, trace })
    }

    /// The layout that was set, or the one by default.
    pub(crate) fn plan_for(&self, points: usize) -> Layout {
        self.layout.unwrap_or_else(|| self.default_layout(points))
    }

    /// The layout by default: a point's star need not be divided where no block moves.
    pub fn default_layout(&self, points: usize) -> Layout {
        let ownership = match self.is_balanced {
            true => Ownership::Block,
            false => Ownership::Newest,
        };
        let redeal = self.redeal;
        Layout { ownership, redeal, ..Layout::new(points, self.workers) }
    }

    fn hooks<'w>(&self, id: WorkerId, start: Instant) -> ThreadHooks<'w>
    where
        'a: 'w,
    {
        let backoff = BACKOFF + 4 * self.latency;
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let crowded = self.workers as usize > processors;
        let Self { cancel, spans, .. } = *self;
        ThreadHooks::new(id, Running { start, cancel, backoff, spans, crowded })
    }

    fn loops<S, Q, T, W>(
        &self,
        nodes: Vec<Node<S, Q>>,
        ways: Vec<T>,
        hooks: impl Fn(WorkerId) -> W,
    ) -> Vec<Loop<S, Q, Correct, T, W>>
    where
        S: Submesh,
        Q: Source<S> + Workload,
        T: Transport<Mail<S>>,
        W: RuntimeHooks<S>,
    {
        let pairs = nodes.into_iter().zip(ways);
        pairs
            .map(|(node, way)| {
                let hooks = hooks(node.id());
                let balance = self.is_balanced.then_some(self.balance);
                Loop::new(node, self.workers, way, hooks, balance)
            })
            .collect()
    }

    fn summary(&self, mut collectors: Vec<Collector>) -> (Option<Summary>, Option<Trace>) {
        let Some(spans) = self.spans else { return (None, None) };
        let makespan = collectors.iter().map(Collector::clock).max().unwrap_or(0);
        collectors.iter_mut().for_each(|collector| collector.rest_until(makespan));
        let summary = Summary::new(&collectors, makespan);
        (Some(summary), (spans > 0).then(|| Trace::take(&mut collectors)))
    }
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests;
