//! The simulator, on the smallest mesh that there is.

use ltbw::balance::Balance;
use ltbw::metrics::{Extremes, SpanKind, Summary, WorkerFigures};
use ltbw::protocol::{Config, Correct, Directory, Rule, Rules, Worker, WorkerId};
use ltbw::simulate::{
    Bursts, Distribution, Network, Options, RandomMigrations, Simulation, SimulationError, simulate,
};
use ltbw_generate::Random;
use ltbw_kit::line::{Cuts, Line, Queue, joined};
use std::collections::BTreeSet;

type Run = Simulation<Line, Queue, Correct>;

/// A set of integers, some of which are vertices at the start.
#[derive(Clone, Debug)]
struct Problem {
    start: BTreeSet<i64>,
    points: Vec<i64>,
    range: i64,
}

impl Problem {
    /// `n` random points and `start` vertices.
    fn new(n: usize, start: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let range = 4 * (n + start) as i64 + 4;
        let mut any = || random.below(range as u64) as i64;
        let start = (0..start).map(|_| any()).collect();
        Self { start, points: (0..n).map(|_| any()).collect(), range }
    }

    /// All vertices at the end.
    fn expected(&self) -> BTreeSet<i64> {
        self.start.iter().chain(&self.points).copied().collect()
    }

    /// The problem cut into blocks, and these given to workers; `even` or most to worker 0.
    fn workers<C: Rules>(
        &self,
        config: Config,
        per_worker: u32,
        even: bool,
    ) -> Vec<Worker<Line, Queue, C>> {
        let cuts = Cuts { range: self.range, blocks: config.workers * per_worker };
        let owner = |b| if even || b >= cuts.blocks / 4 * 3 { b / per_worker } else { 0 };
        let owners: Vec<WorkerId> = (0..cuts.blocks).map(owner).map(WorkerId::new).collect();
        let start: Vec<i64> = self.start.iter().copied().collect();
        let worker = |me| {
            let mine = |p: &&i64| owners[cuts.block(**p).index()] == me;
            let points: Vec<i64> = self.points.iter().filter(mine).copied().collect();
            let line = Line::new(me, cuts, &start, &owners);
            Worker::new(config, Directory::new(me, &owners), line, Queue::new(&points, cuts))
        };
        WorkerId::below(config.workers).map(worker).collect()
    }
}

/// Options for a run in which nothing is excused: it ends soon or fails.
fn options(seed: u64) -> Options {
    let balance = Some(Balance::default());
    Options { seed, balance, max_events: 20_000_000, ..Options::default() }
}

fn run(problem: &Problem, workers: u32, rule: Rule, options: &Options) -> Run {
    let config = Config { rule, ..Config::new(workers) };
    simulate(problem.workers(config, 8, true), options).expect("a run ends")
}

fn right(problem: &Problem, run: &Run) {
    assert_eq!(joined(&run.workers), problem.expected());
    let known: u64 = run.summary.workers.iter().map(|w| w.known).sum();
    assert_eq!(run.summary.operations() + known, problem.points.len() as u64);
}

fn conserved(summary: &Summary) {
    for worker in &summary.workers {
        assert_eq!(worker.times.all(), summary.makespan, "time of {}", worker.worker);
        assert!(worker.times.active <= summary.makespan);
        assert!(worker.times.idle_active <= worker.times.idle);
        assert!(worker.times.idle_at_end <= worker.times.idle);
    }
    let whole = (summary.cavity_times, summary.times);
    for (own, times) in summary.workers.iter().map(|w| (w.cavity_times, w.times)).chain([whole]) {
        assert!(own.successful + own.set_back <= times.all() - times.idle);
        assert!(own.local_active + own.interface_active <= own.successful);
        assert!(own.lt().is_none_or(|lt| (0.0..=1.0).contains(&lt)));
    }
    let sum = |f: fn(&WorkerFigures) -> u64| summary.workers.iter().map(f).sum::<u64>();
    assert_eq!(sum(|w| w.cavity_times.successful), whole.0.successful);
    assert_eq!(sum(|w| w.cavity_times.set_back), whole.0.set_back);
    // All that is sent is taken; loads are no messages of the protocol.
    let loads = summary.messages.get("load").map_or(0, |m| m.count);
    assert_eq!(sum(|w| w.sent.count), summary.all_messages().count);
    assert_eq!(sum(|w| w.received), summary.all_messages().count - loads);
    if let Some(Extremes { least: worst, most: best }) = summary.extremes_of_tolerance() {
        let between = |lt| worst.lt() <= Some(lt) && Some(lt) <= best.lt();
        assert!(summary.workers.iter().filter_map(WorkerFigures::lt).all(between));
        assert!(summary.worst_lt_strict() <= worst.lt_strict());
    }
    assert!(summary.lt().is_none_or(|lt| (0.0..=1.0).contains(&lt)));
    assert!(summary.lt_strict().is_none_or(|lt| lt <= 1.0));
    assert!(summary.polls.useful <= summary.polls.total);
}

#[test]
fn the_set_is_sorted_whatever_happens() {
    let mut setbacks = 0;
    for seed in 0..60 {
        let workers = 2 + seed as u32 % 15;
        let problem = Problem::new(100 + 40 * seed as usize, 1 + seed as usize % 7, seed);
        let latency = [0, 1_000, 300_000, 1_000_000_000][seed as usize % 4];
        let network = Network {
            latency,
            distribution: Distribution::ALL[seed as usize / 4 % 4],
            bursts: (seed % 3 == 0).then_some(Bursts { every: 2_000_000, length: 500_000 }),
            ..Network::default()
        };
        let options = Options {
            network,
            slow: if seed % 5 == 0 { vec![(WorkerId::new(1), 100.0)] } else { Vec::new() },
            storm: (seed % 2 == 0).then_some(RandomMigrations { every: 20_000 + latency / 10 }),
            ..options(seed)
        };
        let run = run(&problem, workers, Rule::WoundWait, &options);
        right(&problem, &run);
        conserved(&run.summary);
        setbacks += run.summary.setbacks();
    }
    assert!(setbacks > 100, "the runs must be full of conflicts: {setbacks}");
}

#[test]
fn the_paper_lives_by_its_backoff() {
    for seed in 0..5 {
        let problem = Problem::new(400, 3, seed);
        let run = run(&problem, 6, Rule::Paper, &options(seed));
        right(&problem, &run);
        conserved(&run.summary);
        assert!(run.summary.setbacks() > 0);
    }
}

#[test]
fn a_seed_reproduces_a_run() {
    let problem = Problem::new(2000, 20, 1);
    let network = Network { distribution: Distribution::Exponential, ..Network::default() };
    let storm = Some(RandomMigrations { every: 100_000 });
    let of = |seed| {
        let options = Options { network, storm, spans: 100_000, ..options(seed) };
        run(&problem, 12, Rule::WoundWait, &options)
    };
    let (a, b, c) = (of(1), of(1), of(2));
    assert_eq!((a.summary.clone(), a.events, &a.trace), (b.summary, b.events, &b.trace));
    assert_ne!(a.summary.makespan, c.summary.makespan, "another seed is another run");
}

#[test]
fn many_processors() {
    let problem = Problem::new(20_000, 4000, 1);
    let run = run(&problem, 1024, Rule::WoundWait, &options(1));
    right(&problem, &run);
    conserved(&run.summary);
}

#[test]
fn one_processor_sends_nothing() {
    let problem = Problem::new(500, 0, 1);
    let run = run(&problem, 1, Rule::WoundWait, &options(1));
    right(&problem, &run);
    conserved(&run.summary);
    assert_eq!(run.summary.all_messages().count, 0);
    assert!(run.summary.lt().is_none() && run.summary.times.active == 0);
    assert!((run.summary.efficiency(run.summary.makespan) - 1.0).abs() < 1e-12);
}

#[test]
fn more_workers_than_points() {
    for n in 0..6 {
        let problem = Problem::new(n, 0, 3);
        let run = run(&problem, 9, Rule::WoundWait, &options(1));
        right(&problem, &run);
    }
}

#[test]
fn blocks_go_to_those_that_run_out_of_points() {
    let makespan = |seed, balance| {
        let problem = Problem::new(8_000, 400, seed);
        let workers = problem.workers::<Correct>(Config::new(8), 16, false);
        let run = simulate(workers, &Options { balance, ..options(1) }).expect("a run ends");
        right(&problem, &run);
        conserved(&run.summary);
        (run.summary.makespan, run.summary.workers.iter().map(|w| w.migrations).sum::<u64>())
    };
    let (mut with, mut without) = (0, 0);
    for seed in 1..=6 {
        let (time, moved) = makespan(seed, Some(Balance::default()));
        let (alone, none) = makespan(seed, None);
        assert!(moved >= 3 && none == 0, "{moved} blocks moved");
        with += time;
        without += alone;
    }
    assert!(3 * with < 2 * without, "{with} ns with the balancer, {without} ns without");
}

#[test]
fn a_cancelled_run_ends_with_a_mesh() {
    let problem = Problem::new(5000, 40, 1);
    let full = run(&problem, 8, Rule::WoundWait, &options(1));
    let options = Options { cancel: Some(full.summary.makespan / 3), ..options(1) };
    let run = run(&problem, 8, Rule::WoundWait, &options);
    let vertices = joined(&run.workers);
    assert!(vertices.is_subset(&problem.expected()) && vertices.is_superset(&problem.start));
    let done = run.summary.operations();
    assert!(done > 0 && done < full.summary.operations(), "{done} inserted");
    assert_eq!(vertices.len() as u64, problem.start.len() as u64 + done);
}

#[test]
fn limits_are_errors() {
    let problem = Problem::new(5000, 40, 1);
    let start = |options: &Options| {
        simulate(problem.workers::<Correct>(Config::new(8), 8, true), options).map(|_| ())
    };
    let few = Options { max_events: 1000, ..options(1) };
    assert!(matches!(
        start(&few),
        Err(SimulationError::TooManyEvents { events: 1001, operations: 1.., .. })
    ));
    let network = Network { latency: 1_000_000_000, ..Network::default() };
    let hasty = Options { patience: 10_000_000, network, ..options(1) };
    assert!(matches!(start(&hasty), Err(SimulationError::NoProgress { .. })));
    let senseless = [
        Options { slow: vec![(WorkerId::new(8), 2.0)], ..options(1) },
        Options { slow: vec![(WorkerId::default(), f64::NAN)], ..options(1) },
        Options { storm: Some(RandomMigrations { every: 0 }), ..options(1) },
        Options {
            network: Network { bursts: Some(Bursts { every: 5, length: 5 }), ..Network::default() },
            ..options(1)
        },
    ];
    for options in &senseless {
        assert!(matches!(start(options), Err(SimulationError::Options(_))), "{options:?}");
    }
    let mut shuffled = problem.workers::<Correct>(Config::new(3), 8, true);
    shuffled.swap(0, 1);
    let error = simulate(shuffled, &options(1)).map(|_| ()).unwrap_err();
    assert_eq!(error, SimulationError::Workers { place: 0, id: WorkerId::new(1) });
    let none = problem.workers::<Correct>(Config::new(3), 8, true).drain(..0).collect();
    assert!(matches!(simulate(none, &options(1)).map(|_| ()), Err(SimulationError::Options(_))));
}

#[test]
fn a_trace_has_every_moment_once() {
    let problem = Problem::new(3000, 40, 1);
    let options = Options { spans: 1_000_000, ..options(1) };
    let run = run(&problem, 4, Rule::WoundWait, &options);
    let trace = run.trace.expect("spans were asked for");
    assert!(trace.is_complete);
    for worker in &run.summary.workers {
        let spans: Vec<_> = trace.spans.iter().filter(|s| s.worker == worker.worker).collect();
        assert_eq!((spans[0].begin, spans[spans.len() - 1].end), (0, run.summary.makespan));
        assert!(spans.windows(2).all(|pair| pair[0].end == pair[1].begin));
        let of = |kind| -> u64 {
            spans.iter().filter(|s| s.kind == kind).map(|s| s.end - s.begin).sum()
        };
        assert_eq!(of(SpanKind::Wait), worker.times.idle_active);
        assert_eq!(of(SpanKind::Wait) + of(SpanKind::Idle), worker.times.idle);
        assert!(of(SpanKind::Fill) > 0 && of(SpanKind::Walk) > 0 && of(SpanKind::Expand) > 0);
    }
    let mut text = Vec::new();
    trace.write(&mut text).expect("memory takes everything");
    let text = String::from_utf8(text).expect("ASCII");
    assert_eq!(text.matches("\"ph\":\"X\"").count(), trace.spans.len());
    assert_eq!(text.matches("thread_name").count(), 4);
    let short = Options { spans: 10, ..options };
    let run = self::run(&problem, 4, Rule::WoundWait, &short);
    assert!(!run.trace.expect("spans were asked for").is_complete);
}
