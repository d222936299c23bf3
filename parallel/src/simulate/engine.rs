//! The simulator's loop.

mod letters;

use super::error::SimulationError;
use super::event::{Entry, What};
use super::network::Links;
use super::options::Options;
use super::processor::{Asking, Envelope, Next, Processor, WorkTime};
use crate::WorkerError;
use crate::balance::{Balancer, Workload};
use crate::check::{
    Between, Check, History, Inspect, NewsNumbers, UnderWay, check_news, count_news,
};
use crate::metrics::{Cause, Collector, Nanos, Step, SubmeshSize, Summary, Trace};
use crate::payload::{LOAD_BYTES, Payload, bytes};
use crate::protocol::{
    Action, Broken, Event, Note, Rules, Source, Submesh, Worker, WorkerId, message_of,
};
use ltbw_core::Random;
use std::collections::BinaryHeap;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A simulated run.
#[derive(Debug)]
pub struct Simulation<S: Submesh, Q, C> {
    /// The workers when all have stopped. Nothing is locked or awaited.
    pub workers: Vec<Worker<S, Q, C>>,
    /// The figures of their time.
    pub summary: Summary,
    /// Events that it took.
    pub events: u64,
    /// The timeline, if [`Options::spans`] is not 0.
    pub trace: Option<Trace>,
}

/// Runs `workers`, one on each processor, until all have stopped. Their directories must be
/// right, and every one must be new.
///
/// # Errors
///
/// [`SimulationError`]: senseless options, too many events, no progress, or a worker that has not
/// ended properly.
pub fn simulate<S, Q, C>(
    workers: Vec<Worker<S, Q, C>>,
    options: &Options,
) -> Result<Simulation<S, Q, C>, SimulationError>
where
    S: Payload + SubmeshSize + Inspect,
    Q: Source<S> + Workload,
    C: Rules,
{
    options.check(workers.len())?;
    if let Some((place, worker)) = workers.iter().enumerate().find(|(k, w)| w.id().index() != *k) {
        return Err(SimulationError::Workers { place, id: worker.id() });
    }
    let mut engine = Engine::new(workers, options);
    engine.run()?;
    engine.finish()
}

/// Why a worker has failed, if it has.
fn failure_of<S: Submesh, Q: Source<S>, C: Rules>(
    worker: &Worker<S, Q, C>,
) -> Option<SimulationError> {
    let submesh = |error| WorkerError::Submesh { worker: worker.id(), error }.into();
    worker.error().map(submesh)
}

struct Engine<'a, S: Submesh, Q, C> {
    options: &'a Options,
    processors: Vec<Processor<S, Q, C>>,
    links: Links,
    random: Random,
    heap: BinaryHeap<Entry<S>>,
    now: Nanos,
    sequence: u64,
    events: u64,
    operations: u64,
    setbacks: u64,
    last_insertion: Nanos,
    stopped: usize,
    /// A worker has failed.
    failed: Option<SimulationError>,
    actions: Vec<Action<S>>,
    history: History,
    /// News under way.
    news: NewsNumbers,
}

impl<'a, S, Q, C> Engine<'a, S, Q, C>
where
    S: Payload + SubmeshSize + Inspect,
    Q: Source<S> + Workload,
    C: Rules,
{
    fn new(workers: Vec<Worker<S, Q, C>>, options: &'a Options) -> Self {
        let count = workers.len();
        let mut random = Random::new(options.seed);
        let links = Links::new(options.network, count, random.bits());
        let processors = workers
            .into_iter()
            .map(|mut worker| {
                let id = worker.id();
                // Work done before the run does not count.
                worker.mesh_mut().take_costs();
                Processor {
                    inbox: Default::default(),
                    retries: Default::default(),
                    orders: Default::default(),
                    is_busy: false,
                    looks_since: None,
                    unpolled: 0,
                    answers: false,
                    letters: Vec::new(),
                    slowness: options.slowness(id),
                    balancer: options.balance.map(|b| Balancer::new(b, id, count)),
                    asking: Asking::No,
                    collector: Collector::new(id, options.spans),
                    worker,
                }
            })
            .collect();
        let mut engine = Self {
            options,
            processors,
            links,
            random,
            heap: BinaryHeap::new(),
            now: 0,
            sequence: 0,
            events: 0,
            operations: 0,
            setbacks: 0,
            last_insertion: 0,
            stopped: 0,
            failed: None,
            actions: Vec::new(),
            history: History::default(),
            news: NewsNumbers::default(),
        };
        engine.failed = engine.processors.iter().find_map(|p| failure_of(&p.worker));
        for id in WorkerId::below(count as u32) {
            engine.at(0, What::Free(id));
        }
        if let Some(time) = options.cancel {
            engine.at(time, What::Cancel);
        }
        if let Some(storm) = options.storm.filter(|_| count > 1) {
            engine.at(storm.every, What::RandomMigrations);
        }
        engine
    }

    fn at(&mut self, time: Nanos, what: What<S>) {
        self.sequence += 1;
        self.heap.push(Entry { time, sequence: self.sequence, what });
    }

    /// Ends: events are counted.
    fn run(&mut self) -> Result<(), SimulationError> {
        while let Some(Entry { time, what, .. }) = self.heap.pop() {
            self.now = time;
            self.events += 1;
            self.check_progress()?;
            self.happen(what);
            if let Some(error) = self.failed.take() {
                return Err(error);
            }
            let every = self.options.check_every;
            if every > 0 && self.events.is_multiple_of(every) {
                self.check_invariants()?;
            }
        }
        Ok(())
    }

    /// The invariants over all workers and all messages under way.
    fn check_invariants(&mut self) -> Result<(), SimulationError> {
        fn message<S: Submesh>(to: WorkerId, envelope: &Envelope<S>) -> Option<UnderWay<'_, S>> {
            let message = envelope.message.as_ref()?;
            Some(UnderWay { from: envelope.from, to, message })
        }
        let flying = self.heap.iter().filter_map(|entry| match &entry.what {
            What::Arrive(to, envelope) => message(*to, envelope),
            _ => None,
        });
        let waiting = self.processors.iter().flat_map(|processor| {
            let to = processor.worker.id();
            processor.inbox.iter().filter_map(move |envelope| message(to, envelope))
        });
        let held = self.processors.iter().flat_map(|processor| {
            processor.letters.iter().filter_map(|(to, envelope)| message(*to, envelope))
        });
        let workers = self.processors.iter().map(|processor| &processor.worker);
        let between = Between::new(workers, flying.chain(waiting).chain(held));
        let checked = between.check().and_then(|()| self.history.look(&between));
        self.consistent(checked)
    }

    fn consistent(&self, checked: Check) -> Result<(), SimulationError> {
        let time = self.now;
        let error =
            |Broken { invariant, what }| SimulationError::Inconsistent { time, invariant, what };
        checked.map_err(error)
    }

    fn check_progress(&mut self) -> Result<(), SimulationError> {
        let (time, operations) = (self.now, self.operations);
        if self.events > self.options.max_events {
            return Err(SimulationError::TooManyEvents { events: self.events, operations, time });
        }
        if time.saturating_sub(self.last_insertion) <= self.options.patience {
            return Ok(());
        }
        match self.processors.iter().find(|p| !p.worker.is_passive()) {
            None => {
                self.last_insertion = time;
                Ok(())
            }
            Some(processor) => Err(SimulationError::NoProgress {
                since: self.last_insertion,
                time,
                worker: processor.worker.id(),
                operations,
                setbacks: self.setbacks,
            }),
        }
    }

    fn happen(&mut self, what: What<S>) {
        match what {
            What::Arrive(to, envelope) => {
                let processor = &mut self.processors[to.index()];
                // A worker that has stopped has nothing to give.
                if envelope.message.is_some() || !processor.worker.is_stopped() {
                    processor.inbox.push_back(envelope);
                    self.wake(to);
                }
            }
            What::Free(id) => {
                self.processors[id.index()].is_busy = false;
                self.wake(id);
            }
            What::Retry(id, ticket) => {
                self.processors[id.index()].retries.push_back(ticket);
                self.wake(id);
            }
            What::Ask(id) => {
                self.processors[id.index()].asking = Asking::Now;
                self.wake(id);
            }
            What::Cancel => {
                for id in WorkerId::below(self.processors.len() as u32) {
                    self.processors[id.index()].orders.push_back(Event::Cancel);
                    self.wake(id);
                }
            }
            What::RandomMigrations => self.storm(),
        }
    }

    /// A processor that is not busy takes up what there is to do.
    fn wake(&mut self, id: WorkerId) {
        let processor = &mut self.processors[id.index()];
        if processor.is_busy {
            return;
        }
        let looked = processor.end_of_looks(self.now, &self.options.costs);
        if looked > self.now {
            processor.is_busy = true;
            return self.at(looked, What::Free(id));
        }
        if processor.is_between_turns(self.options.poll_every) {
            self.flush(id);
        }
        let processor = &mut self.processors[id.index()];
        match processor.next(self.options.poll_every) {
            Next::Rest => {
                processor.rest(self.now, &self.options.costs);
                self.flush(id);
            }
            Next::GoOn => self.step(id, Event::Work, self.now, 0),
            Next::Ask => self.ask(id),
            Next::Take(envelope) => self.take(id, envelope),
            Next::Do(event) => {
                let polled = self.poll(id, false);
                self.step(id, event, polled, 0);
            }
        }
        self.watch(id);
    }

    /// A look for messages; returns when it ends.
    fn poll(&mut self, id: WorkerId, useful: bool) -> Nanos {
        let processor = &mut self.processors[id.index()];
        let end = self.now + processor.time(self.options.costs.poll);
        processor.collector.poll(self.now, end, useful);
        end
    }

    /// Takes a message out of the inbox.
    fn take(&mut self, id: WorkerId, envelope: Envelope<S>) {
        let begin = self.poll(id, true);
        let processor = &mut self.processors[id.index()];
        let Envelope { bytes, goes_along, .. } = envelope;
        let receiving = processor.time(self.options.costs.receiving(bytes, goes_along));
        let from = envelope.from;
        if let Some(balancer) = &mut processor.balancer {
            balancer.heard(from, envelope.load);
        }
        if let Some(message) = envelope.message {
            self.step(id, Event::Message { from, message }, begin, receiving);
            return;
        }
        if let Some(balancer) = &mut processor.balancer {
            for block in balancer.give(&processor.worker, from) {
                processor.orders.push_back(Event::Migrate { block, to: from });
            }
        }
        self.occupy(id, begin, begin.max(self.now + 1) + receiving);
    }

    /// A step that begins at `begin` with receiving a message.
    fn step(&mut self, id: WorkerId, event: Event<S>, begin: Nanos, receiving: Nanos) {
        let mut actions = std::mem::take(&mut self.actions);
        let cause = Cause::of(&event);
        if let Event::Message { message, .. } = &event {
            count_news(message, &mut self.news, -1);
        }
        let processor = &mut self.processors[id.index()];
        // A worker that has panicked is not looked at again: the run ends.
        let step = AssertUnwindSafe(|| processor.worker.step(event, &mut actions));
        if let Err(panic) = catch_unwind(step) {
            self.failed = Some(WorkerError::of_panic(id, message_of(&*panic)).into());
            return;
        }
        let failed = failure_of(&processor.worker);
        let WorkTime { all, walk } = processor.work_time(&self.options.costs);
        let worked = begin + receiving + all;
        let load = processor.worker.source().left();
        let mut end = worked;
        for (k, action) in actions.iter().enumerate() {
            if let Action::Send { to, message } = action {
                count_news(message, &mut self.news, 1);
                let bytes = bytes::<S>(message);
                let goes_along = self.options.letters && processor.has_letter(*to, &actions[..k]);
                end += processor.time(self.options.costs.sending(bytes, goes_along));
                processor.collector.sent(message.kind(), bytes);
            }
        }
        let step = Step { begin, end, communication: receiving + (end - worked), walk };
        processor.collector.step(cause, step, &actions);
        processor.is_busy = true;
        let checked = check_news(&processor.worker, &self.news);
        self.failed = failed.or_else(|| self.consistent(checked).err());
        self.carry_out(id, worked, load, &mut actions);
        self.at(end, What::Free(id));
        actions.clear();
        self.actions = actions;
    }

    /// Carries out a step's actions: a message leaves when it and those before it are sent.
    fn carry_out(&mut self, id: WorkerId, worked: Nanos, load: u64, actions: &mut Vec<Action<S>>) {
        let mut time = worked;
        for action in actions.drain(..) {
            match action {
                Action::Send { to, message } => {
                    let bytes = bytes::<S>(&message);
                    let processor = &mut self.processors[id.index()];
                    let goes_along = self.options.letters && processor.has_letter(to, &[]);
                    let message = Some(message);
                    let envelope = Envelope { from: id, load, bytes, goes_along, message };
                    if self.options.letters {
                        processor.letters.push((to, envelope));
                        continue;
                    }
                    time += processor.time(self.options.costs.sending(bytes, goes_along));
                    self.post(to, envelope, time);
                }
                Action::Backoff { ticket, attempt } => {
                    let Options { backoff, network, .. } = self.options;
                    let longest = backoff.saturating_add(network.latency.saturating_mul(4));
                    let longest = longest.saturating_mul(1 << attempt.number().min(10));
                    let wait = 1 + self.random.below(longest);
                    self.at(time + wait, What::Retry(id, ticket));
                }
                Action::Note(note) => self.note(note, worked),
            }
        }
    }

    fn note(&mut self, note: Note, time: Nanos) {
        match note {
            Note::Local | Note::Committed { .. } => {
                self.operations += 1;
                self.last_insertion = time;
            }
            Note::Duplicate | Note::Gone => self.last_insertion = time,
            Note::SetBack { .. } => self.setbacks += 1,
            Note::Stopped => self.stopped += 1,
            Note::Began(_) | Note::Waits(_) | Note::Migrated(_) => {}
        }
    }

    /// Sees to it that a worker with few points left asks for more.
    fn watch(&mut self, id: WorkerId) {
        let processor = &mut self.processors[id.index()];
        let load = processor.worker.source().left();
        let Some(balancer) = processor.balancer.as_mut() else { return };
        if !balancer.is_low(load) || processor.asking != Asking::No || processor.worker.is_stopped()
        {
            return;
        }
        processor.asking = Asking::Later;
        let time = self.now + balancer.pause();
        self.at(time, What::Ask(id));
    }

    /// A worker with few points left asks for more.
    fn ask(&mut self, id: WorkerId) {
        let begin = self.poll(id, false);
        let processor = &mut self.processors[id.index()];
        let load = processor.worker.source().left();
        let whom = processor.balancer.as_mut().map_or(Vec::new(), |b| b.ask(load));
        let mut end = begin.max(self.now + 1);
        let (bytes, goes_along) = (LOAD_BYTES, false);
        let sending = processor.time(self.options.costs.sending(bytes, goes_along));
        for to in whom {
            end += sending;
            self.processors[id.index()].collector.sent("load", LOAD_BYTES);
            let envelope = Envelope { from: id, load, bytes, goes_along, message: None };
            self.post(to, envelope, end);
        }
        self.occupy(id, begin, end);
    }

    /// The processor is busy with loads.
    fn occupy(&mut self, id: WorkerId, begin: Nanos, end: Nanos) {
        let processor = &mut self.processors[id.index()];
        processor.collector.control(begin, end);
        processor.is_busy = true;
        self.at(end, What::Free(id));
    }

    /// Orders a random worker to give a random block to another random worker.
    fn storm(&mut self) {
        let Some(storm) = self.options.storm.filter(|_| self.stopped < self.processors.len())
        else {
            return;
        };
        self.at(self.now + storm.every, What::RandomMigrations);
        let count = self.processors.len() as u64;
        let from = self.random.below(count);
        let to = WorkerId::at(((from + 1 + self.random.below(count - 1)) % count) as usize);
        let directory = self.processors[from as usize].worker.directory();
        if self.processors[from as usize].worker.is_stopped() {
            return;
        }
        let mine: Vec<_> = directory.blocks().filter(|&b| directory.is_mine(b)).collect();
        if mine.is_empty() {
            return;
        }
        let block = mine[self.random.below(mine.len() as u64) as usize];
        self.processors[from as usize].orders.push_back(Event::Migrate { block, to });
        self.wake(WorkerId::at(from as usize));
    }

    fn finish(self) -> Result<Simulation<S, Q, C>, SimulationError> {
        let those = |wrong: fn(&Processor<S, Q, C>) -> bool| -> Vec<WorkerId> {
            self.processors.iter().filter(|p| wrong(p)).map(|p| p.worker.id()).collect()
        };
        let workers = those(|p| !p.worker.is_stopped());
        if !workers.is_empty() {
            return Err(SimulationError::Stuck { time: self.now, workers });
        }
        let workers = those(|p| !p.worker.is_quiescent());
        if !workers.is_empty() {
            return Err(SimulationError::NotQuiescent { workers });
        }
        let (mut workers, mut collectors) = (Vec::new(), Vec::new());
        let makespan = self.processors.iter().map(|p| p.collector.clock()).max().unwrap_or(0);
        for mut processor in self.processors {
            processor.collector.finish(makespan, processor.worker.mesh());
            workers.push(processor.worker);
            collectors.push(processor.collector);
        }
        let summary = Summary::new(&collectors, makespan);
        let trace = (self.options.spans > 0).then(|| Trace::take(&mut collectors));
        Ok(Simulation { workers, summary, events: self.events, trace })
    }
}
