//! Runs that fail: by a panic of a worker, by a broken invariant, and by a message that is lost.

use super::watchdog::Watchdog;
use super::*;
use crate::WorkerError;
use crate::mailbox::{Endpoint, Received};
use crate::metrics::Nanos;
use crate::protocol::{Action, Attempt, BlockId, Event, Invariant, Message};
use ltbw_generate::{PointKind, generate};

/// A watch that fails after some steps.
struct Bomb<'a> {
    inner: ThreadHooks<'a>,
    steps: u32,
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
        self.inner.order(may_move)
    }

    fn poll_interval(&self) -> Option<Duration> {
        RuntimeHooks::<LocalMesh>::poll_interval(&self.inner)
    }

    fn polled(&mut self, found: usize) {
        RuntimeHooks::<LocalMesh>::polled(&mut self.inner, found);
    }

    fn ended(&mut self, _: &[Action<LocalMesh>]) {
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

    fn take(&mut self, into: &mut Vec<Received<Mail<LocalMesh>>>) {
        Transport::take(&mut self.inner, into);
        let is_grant = |received: &Received<Mail<LocalMesh>>| {
            matches!(received.message.message, Some(Message::Grant { .. }))
        };
        if let Some(place) = into.iter().position(is_grant).filter(|_| !self.done) {
            self.done = true;
            if self.loses {
                into.remove(place);
                return;
            }
            let Received { from, message: Mail { load, message } } = &into[place];
            let again = Mail { load: *load, message: message.as_ref().map(copy) };
            into.insert(place, Received { from: *from, message: again });
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
    let error =
        run_all(loops, &silent(), any_thread).map(drop).expect_err("a grant that arrives twice");
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
            Bomb { inner: kernel.hooks(id, clock), steps }
        };
        let ways = connect(3).into_iter();
        let ways = ways.map(|way| Delayed::new(way, kernel.latency)).collect();
        let error = run_all(kernel.loops(nodes, ways, hooks), &silent(), any_thread).map(drop);
        let said =
            WorkerError::Failed { worker: WorkerId::new(victim), message: "planted".to_string() };
        assert_eq!(error, Err(said.into()));
    }
}

/// A thread that the system refuses, for no address space holds its stack: those before it have
/// begun, and would wait for its answers.
#[test]
fn a_thread_that_is_refused_ends_the_run_of_those_that_have_one() {
    let set = PointSet::new(generate(PointKind::Uniform, 2000, 1)).expect("finite points");
    for victim in 0..3 {
        let (kernel, clock) = (Parallel::new(3), Instant::now());
        let watchdog = Watchdog::with(Duration::from_secs(2));
        let hooks = |id| kernel.hooks(id, clock).watched(Some(watchdog.watch(id)));
        let loops = kernel.loops(nodes(&set, 3), connect(3), hooks);
        let thread = |k| match k == victim {
            true => std::thread::Builder::new().stack_size(1 << 60),
            false => any_thread(k),
        };
        let error = run_all(loops, &silent(), thread).map(drop);
        assert!(matches!(error, Err(RunError::Threads { threads: 3, .. })), "{error:?}");
    }
}

/// A message is lost: the state of each worker is told, and what each did last.
#[test]
fn a_run_that_hangs_fails_and_tells_the_state_of_each_worker() {
    let set = PointSet::new(generate(PointKind::Uniform, 2000, 1)).expect("finite points");
    let (kernel, clock) = (Parallel::new(3), Instant::now());
    let watchdog = Watchdog::with(Duration::from_secs(2));
    let ways = connect(3).into_iter().map(|inner| Faulty { inner, loses: true, done: false });
    let hooks = |id| kernel.hooks(id, clock).watched(Some(watchdog.watch(id)));
    let error = run_all(kernel.loops(nodes(&set, 3), ways.collect(), hooks), &silent(), any_thread)
        .map(drop);
    let Err(RunError::Worker(WorkerError::Failed { message, .. })) = error else {
        panic!("{error:?}")
    };
    assert!(message.starts_with("the run hangs: no point done for "), "{message}");
    for worker in 0..3 {
        assert!(message.contains(&format!("\nworker {worker}: ")), "{message}");
    }
    assert!(message.contains("  operation Ticket") && message.contains("last: "), "{message}");
    // The other workers are not in a step that does not end.
    assert!(!message.contains("in a step after "), "{message}");
}

/// Debug builds watch all runs.
#[test]
fn every_run_of_a_test_is_watched() {
    assert!(silent().watch(WorkerId::default()).is_some());
}
