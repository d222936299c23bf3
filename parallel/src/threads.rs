//! The thread runtime: one thread for each worker, in one process.
//!
//! Threads share nothing but mailboxes. A worker takes its messages before every burst of local
//! work (the paper's queues QR before QL before LB) and sleeps when there is neither.

use crate::mailbox::connect;
use crate::mesh::{Field, GatherError, LocalMesh, Plan, Prepared, gather};
use crate::protocol::{
    Action, Attempt, Config, Event, Message, Note, Rule, Source, Ticket, Worker, WorkerId,
};
use crate::transport::{Delayed, Transport};
use ltbw_core::{BuildError, CancelToken, Mesh, Outcome, PointSet, Vertex};
use std::time::{Duration, Instant};

/// Units of local work between two looks at the mailbox.
const BURST: usize = 16;
/// Shortest and longest backoff of the paper's rule.
const BACKOFF: (Duration, u32) = (Duration::from_micros(20), 10);

type Node = Worker<LocalMesh, Field>;

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// There is no first tetrahedron.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A worker has panicked: a defect of this crate.
    #[error("worker {worker} has failed: {message}")]
    Failed {
        /// The worker.
        worker: WorkerId,
        /// What it said.
        message: String,
    },
    /// The submeshes could not be put together.
    #[error(transparent)]
    Gather(#[from] GatherError),
}

/// Figures of one worker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WorkerStats {
    /// Points inserted at once, without a lock.
    pub local: u64,
    /// Operations committed.
    pub operations: u64,
    /// Those of more than one worker.
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
}

impl WorkerStats {
    fn note(&mut self, note: Note) {
        match note {
            Note::Local => self.local += 1,
            Note::SetBack { attempt, .. } => {
                self.setbacks += 1;
                self.worst_setbacks = self.worst_setbacks.max(attempt);
            }
            Note::Committed { parts, .. } => {
                self.operations += 1;
                self.interface += u64::from(parts > 1);
            }
            Note::Migrated(_) => self.migrated += 1,
            Note::Known | Note::Began(_) | Note::Waits(_) | Note::Stopped => {}
        }
    }
}

/// A mesh and how it came about.
#[derive(Debug)]
pub struct Run {
    /// The mesh: of all points if `outcome` is [`Outcome::Complete`].
    pub mesh: Mesh,
    /// How far the run came.
    pub outcome: Outcome,
    /// Input indices of duplicates met, each with the index of the vertex kept; ascending.
    pub duplicates: Vec<(Vertex, Vertex)>,
    /// Seconds to order the points, to build and distribute the coarse mesh.
    pub start_seconds: f64,
    /// Seconds of the workers.
    pub insert_seconds: f64,
    /// Seconds to put the submeshes together.
    pub gather_seconds: f64,
    /// By worker.
    pub workers: Vec<WorkerStats>,
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
    window: usize,
    latency: Duration,
    plan: Option<Plan>,
    cancel: Option<&'a CancelToken>,
}

impl<'a> Parallel<'a> {
    /// A run on `workers` threads, at least one.
    pub fn new(workers: u32) -> Self {
        let workers = workers.max(1);
        // Between threads a message takes microseconds: few operations hide that, and few are in
        // each other's way.
        let window = 16;
        let rule = Rule::default();
        Self { workers, rule, window, latency: Duration::ZERO, plan: None, cancel: None }
    }

    /// Sets the conflict rule.
    pub fn rule(mut self, rule: Rule) -> Self {
        self.rule = rule;
        self
    }

    /// Sets how many operations a worker has under way at most.
    pub fn window(mut self, window: usize) -> Self {
        self.window = window.max(1);
        self
    }

    /// Delays every message: to see how the kernel tolerates it.
    pub fn latency(mut self, latency: Duration) -> Self {
        self.latency = latency;
        self
    }

    /// Sets the layout; its number of workers is replaced by that of the run.
    pub fn plan(mut self, plan: Plan) -> Self {
        self.plan = Some(Plan { workers: self.workers, ..plan });
        self
    }

    /// Sets the token that cancels the run. The result is the mesh of the points inserted before.
    pub fn cancel(mut self, token: &'a CancelToken) -> Self {
        self.cancel = Some(token);
        self
    }

    /// Builds the mesh.
    ///
    /// # Errors
    /// [`RunError`] says why there is no mesh.
    pub fn build(&self, set: &PointSet) -> Result<Run, RunError> {
        let clock = Instant::now();
        let plan = self.plan.unwrap_or_else(|| Plan::new(set.len(), self.workers));
        let Prepared { workers, common } = Plan { roomy: true, ..plan }.prepare(set)?;
        let start_seconds = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let config = Config { workers: self.workers, rule: self.rule, window: self.window };
        let nodes: Vec<Node> = workers
            .into_iter()
            .map(|(directory, mesh, field)| Worker::new(config, directory, mesh, field))
            .collect();
        let ends = if self.latency.is_zero() {
            self.run_all(nodes, connect(self.workers))?
        } else {
            let ways = connect(self.workers).into_iter();
            self.run_all(nodes, ways.map(|way| Delayed::new(way, self.latency)).collect())?
        };
        let insert_seconds = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let cancelled = ends.iter().any(|end| end.cancelled);
        let stats = ends.iter().map(|end| end.stats).collect();
        let meshes = ends.into_iter().map(|end| end.mesh).collect();
        let whole = gather(meshes, common)?;
        Ok(Run {
            mesh: whole.mesh,
            outcome: if cancelled { Outcome::Cancelled } else { Outcome::Complete },
            duplicates: whole.duplicates,
            start_seconds,
            insert_seconds,
            gather_seconds: clock.elapsed().as_secs_f64(),
            workers: stats,
        })
    }

    /// Runs every worker on a thread of its own.
    fn run_all<T>(&self, nodes: Vec<Node>, ways: Vec<T>) -> Result<Vec<End>, RunError>
    where
        T: Transport<Message<LocalMesh>> + Send,
    {
        let cancel = self.cancel;
        let results: Vec<std::thread::Result<Option<End>>> = std::thread::scope(|scope| {
            let threads: Vec<_> = nodes
                .into_iter()
                .zip(ways)
                .map(|(node, way)| scope.spawn(move || Loop::new(node, way, cancel).run()))
                .collect();
            threads.into_iter().map(std::thread::ScopedJoinHandle::join).collect()
        });
        let mut ends = Vec::with_capacity(results.len());
        let mut failed = None;
        for (worker, result) in (0..).zip(results) {
            match result {
                Ok(Some(end)) => ends.push(end),
                // It stopped because another one failed.
                Ok(None) => {}
                Err(panic) => failed = failed.or(Some((worker, panic))),
            }
        }
        match failed {
            None => Ok(ends),
            Some((worker, panic)) => {
                let text = panic.downcast_ref::<String>().cloned();
                let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_string()));
                let message = text.unwrap_or_else(|| "it panicked".to_string());
                Err(RunError::Failed { worker, message })
            }
        }
    }
}

/// What a worker leaves.
struct End {
    mesh: LocalMesh,
    stats: WorkerStats,
    cancelled: bool,
}

/// A worker's loop.
struct Loop<'a, T> {
    node: Node,
    way: T,
    cancel: Option<&'a CancelToken>,
    cancelled: bool,
    stats: WorkerStats,
    actions: Vec<Action<LocalMesh>>,
    inbox: Vec<(WorkerId, Message<LocalMesh>)>,
    /// Operations that back off, with the end of their time.
    resting: Vec<(Instant, Ticket)>,
    random: u64,
}

impl<'a, T: Transport<Message<LocalMesh>>> Loop<'a, T> {
    fn new(node: Node, way: T, cancel: Option<&'a CancelToken>) -> Self {
        let random = 0x9e37_79b9_7f4a_7c15 ^ u64::from(node.id()) << 32 | 1;
        Self {
            node,
            way,
            cancel,
            cancelled: false,
            stats: WorkerStats::default(),
            actions: Vec::new(),
            inbox: Vec::new(),
            resting: Vec::new(),
            random,
        }
    }

    /// Runs until all work is done everywhere; `None` if another worker has failed.
    ///
    /// Ends: the protocol does (`docs/protocol.md`), and a failure wakes every worker.
    fn run(mut self) -> Option<End> {
        while !self.node.is_stopped() {
            if self.way.failed().is_some() {
                return None;
            }
            let heard = self.hear();
            self.look_at_token();
            let worked = self.work();
            self.way.flush();
            if !heard && !worked && !self.node.is_stopped() {
                let now = Instant::now();
                let rest = self.resting.iter().map(|(due, _)| due.saturating_duration_since(now));
                // A cancel token wakes nobody: look at it now and then.
                let look = self.cancel.map(|_| Duration::from_millis(20));
                self.way.wait(rest.chain(look).min());
            }
        }
        self.way.flush();
        let Self { node, stats, cancelled, .. } = self;
        Some(End { mesh: node.into_parts().0, stats, cancelled })
    }

    /// Answers all messages that are there.
    fn hear(&mut self) -> bool {
        let mut inbox = std::mem::take(&mut self.inbox);
        self.way.take(&mut inbox);
        self.stats.polls[0] += 1;
        let heard = !inbox.is_empty();
        self.stats.polls[1] += u64::from(heard);
        for (from, message) in inbox.drain(..) {
            self.step(Event::Message { from, message });
        }
        self.inbox = inbox;
        heard
    }

    /// Some local work.
    fn work(&mut self) -> bool {
        let mut worked = false;
        if !self.resting.is_empty() {
            let now = Instant::now();
            let resting = std::mem::take(&mut self.resting);
            let (over, resting): (Vec<_>, Vec<_>) =
                resting.into_iter().partition(|&(due, _)| due <= now);
            self.resting = resting;
            for (_, ticket) in over {
                self.step(Event::Retry(ticket));
                worked = true;
            }
        }
        for _ in 0..BURST {
            if !self.node.has_work() {
                break;
            }
            self.step(Event::Work);
            worked = true;
        }
        worked
    }

    fn look_at_token(&mut self) {
        if !self.cancelled && self.cancel.is_some_and(CancelToken::is_cancelled) {
            self.cancelled = !self.node.source().is_empty();
            self.step(Event::Cancel);
        }
        if self.node.mesh().is_full() && !self.node.source().is_empty() {
            self.step(Event::Cancel);
        }
    }

    fn step(&mut self, event: Event<LocalMesh>) {
        self.node.step(event, &mut self.actions);
        for action in self.actions.drain(..) {
            match action {
                Action::Send { to, message } => {
                    self.stats.messages += 1;
                    self.way.send(to, message);
                }
                Action::Note(note) => self.stats.note(note),
                Action::Backoff { ticket, attempt } => {
                    let time = backoff(attempt, &mut self.random);
                    self.resting.push((Instant::now() + time, ticket));
                }
            }
        }
    }
}

/// A random time that doubles with every attempt.
fn backoff(attempt: Attempt, random: &mut u64) -> Duration {
    *random ^= *random << 13;
    *random ^= *random >> 7;
    *random ^= *random << 17;
    let most = BACKOFF.0 * (1 << attempt.min(BACKOFF.1));
    most.mul_f64((*random >> 11) as f64 / (1u64 << 53) as f64)
}
