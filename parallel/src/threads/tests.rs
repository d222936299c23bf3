//! Runs that fail: by a panic of a worker, by a broken invariant, and by a message that is lost.

use super::*;
use crate::mailbox::Endpoint;
use crate::metrics::Nanos;
use crate::protocol::{Action, Attempt, BlockId, Event, Invariant, Message};
use ltbw_generate::{PointKind, generate};

/// A watch that fails after some steps, or if the run has no end by some time: a run that hangs is
/// a failure, and says what the worker did last.
struct Bomb<'a> {
    inner: ThreadHooks<'a>,
    steps: u32,
    until: Instant,
    last: Vec<String>,
}

impl<'a> Bomb<'a> {
    fn new(inner: ThreadHooks<'a>, steps: u32, time: Duration) -> Self {
        Self { inner, steps, until: Instant::now() + time, last: Vec::new() }
    }
}

impl RuntimeHooks<LocalMesh> for Bomb<'_> {
    const BURST: usize = 16;

    fn now(&mut self) -> Nanos {
        RuntimeHooks::<LocalMesh>::now(&mut self.inner)
    }

    fn until(&mut self, due: Nanos) -> Option<Duration> {
        RuntimeHooks::<LocalMesh>::until(&mut self.inner, due)
    }

    fn backoff(&mut self, attempt: Attempt) -> Nanos {
        RuntimeHooks::<LocalMesh>::backoff(&mut self.inner, attempt)
    }

    fn order(&mut self, may_move: impl Fn(BlockId) -> bool) -> Option<Event<LocalMesh>> {
        assert!(Instant::now() < self.until, "no end; last: {}", self.last.join(", "));
        self.inner.order(may_move)
    }

    fn poll_interval(&self) -> Option<Duration> {
        Some(
            RuntimeHooks::<LocalMesh>::poll_interval(&self.inner)
                .unwrap_or(Duration::from_millis(20)),
        )
    }

    fn polled(&mut self, found: usize) {
        RuntimeHooks::<LocalMesh>::polled(&mut self.inner, found);
    }

    fn ended(&mut self, actions: &[Action<LocalMesh>]) {
        self.last.extend(actions.iter().map(|action| match action {
            Action::Send { to, message } => {
                format!("{} of {:?} to {to}", message.kind(), message.ticket())
            }
            Action::Backoff { ticket, .. } => format!("backoff of {ticket:?}"),
            Action::Note(note) => format!("{note:?}"),
        }));
        self.last.drain(..self.last.len().saturating_sub(8));
        self.steps = self.steps.checked_sub(1).expect("planted");
    }
}

/// A copy of a grant; deriving `Clone` would ask for it of the submesh.
fn copy(message: &Message<LocalMesh>) -> Message<LocalMesh> {
    match message {
        Message::Grant { ticket, attempt, answers, pieces, foreign, .. } => Message::Grant {
            ticket: *ticket,
            attempt: *attempt,
            answers: *answers,
            pieces: pieces.clone(),
            foreign: foreign.clone(),
            bounced: Vec::new(),
            moved: Vec::new(),
        },
        _ => Message::Stop,
    }
}

/// A way on which the first grant arrives twice, or never.
struct Faulty {
    inner: Endpoint<Mail<LocalMesh>, Correct>,
    loses: bool,
    done: bool,
}

impl Transport<Mail<LocalMesh>> for Faulty {
    fn send(&mut self, to: WorkerId, mail: Mail<LocalMesh>) {
        Transport::send(&mut self.inner, to, mail);
    }

    fn flush(&mut self) {
        Transport::flush(&mut self.inner);
    }

    fn take(&mut self, into: &mut Vec<(WorkerId, Mail<LocalMesh>)>) {
        Transport::take(&mut self.inner, into);
        let is_grant = |(_, mail): &(WorkerId, Mail<LocalMesh>)| {
            matches!(mail.message, Some(Message::Grant { .. }))
        };
        if let Some(place) = into.iter().position(is_grant).filter(|_| !self.done) {
            self.done = true;
            if self.loses {
                into.remove(place);
                return;
            }
            let (from, Mail { load, message }) = &into[place];
            let again = (*from, Mail { load: *load, message: message.as_ref().map(copy) });
            into.insert(place, again);
        }
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        Transport::wait(&mut self.inner, timeout);
    }

    fn fail(&mut self) {
        Transport::fail(&mut self.inner);
    }

    fn failed(&self) -> Option<WorkerId> {
        Transport::failed(&self.inner)
    }
}

/// The teller of a run that nobody watches.
fn silent() -> Teller<'static> {
    Teller::new(Listener::default(), 0, 0)
}

fn nodes(set: &PointSet, workers: u32) -> Vec<Node> {
    let config = Config { window: 16, ..Config::new(workers) };
    let prepared = Layout::new(set.len(), workers).distribute(set).expect("a start");
    let workers = prepared.workers.into_iter();
    workers.map(|(directory, mesh, field)| Worker::new(config, directory, mesh, field)).collect()
}

#[test]
fn a_broken_invariant_ends_the_run_by_its_number() {
    let set = PointSet::new(generate(PointKind::Uniform, 2000, 1)).expect("finite points");
    let kernel = Parallel::new(3);
    let clock = Instant::now();
    let ways =
        connect(3).into_iter().map(|inner| Faulty { inner, loses: false, done: false }).collect();
    let loops = kernel.loops(nodes(&set, 3), ways, |id| kernel.hooks(id, clock));
    let error = run_all(loops, &silent()).map(drop).expect_err("a grant that arrives twice");
    let RunError::Worker(WorkerError::Broken { invariant, .. }) = &error else { panic!("{error}") };
    assert_eq!(*invariant, Invariant::P8, "{error}");
    // The process lives.
    assert!(kernel.build(&set).is_ok());
}

#[test]
fn a_worker_that_fails_ends_the_run_by_name() {
    let set = PointSet::new(generate(PointKind::Uniform, 2000, 1)).expect("finite points");
    for (victim, latency) in [(0, 0), (1, 0), (2, 0), (1, 300)] {
        let kernel = Parallel::new(3).latency(Duration::from_micros(latency));
        let nodes = nodes(&set, 3);
        let clock = Instant::now();
        let hooks = |id| {
            let steps = if id == WorkerId::new(victim) { 100 } else { u32::MAX };
            Bomb::new(kernel.hooks(id, clock), steps, Duration::from_secs(60))
        };
        let ways = connect(3).into_iter();
        let ways = ways.map(|way| Delayed::new(way, kernel.latency)).collect();
        let error = run_all(kernel.loops(nodes, ways, hooks), &silent()).map(drop);
        let said =
            WorkerError::Failed { worker: WorkerId::new(victim), message: "planted".to_string() };
        assert_eq!(error, Err(said.into()));
    }
}

#[test]
fn a_run_that_hangs_fails_and_says_what_was_last() {
    let set = PointSet::new(generate(PointKind::Uniform, 2000, 1)).expect("finite points");
    let (kernel, clock) = (Parallel::new(3), Instant::now());
    let ways = connect(3).into_iter().map(|inner| Faulty { inner, loses: true, done: false });
    let hooks = |id| Bomb::new(kernel.hooks(id, clock), u32::MAX, Duration::from_secs(2));
    let error = run_all(kernel.loops(nodes(&set, 3), ways.collect(), hooks), &silent()).map(drop);
    let Err(RunError::Worker(WorkerError::Failed { message, .. })) = error else {
        panic!("{error:?}")
    };
    assert!(message.starts_with("no end; last: ") && message.contains("Ticket"), "{message}");
}
