//! The real mesh on simulated processors: always the sequential kernel's mesh.

use ltbw::balance::Balance;
use ltbw::mesh::{Layout, Ownership};
use ltbw::metrics::Summary;
use ltbw::protocol::{Closure, Config, Rule, WorkerId};
use ltbw::simulate::{
    Bursts, CostModel, Distribution, MeshError, Meshed, Network, Options, RandomMigrations,
    SimulationError, simulate_mesh,
};
use ltbw::{Builder, PointSet, invariants};
use ltbw_generate::{PointKind, Random, generate};

fn options(seed: u64) -> Options {
    let balance = Some(Balance::default());
    Options { seed, balance, max_events: 50_000_000, ..Options::default() }
}

/// Runs and compares with the sequential kernel.
fn run(set: &PointSet, layout: Layout, rule: Rule, options: &Options) -> Meshed {
    run_as(set, layout, Config { rule, ..Config::new(layout.workers) }, options)
}

/// [`run`] with all settings of the protocol.
fn run_as(set: &PointSet, layout: Layout, config: Config, options: &Options) -> Meshed {
    let meshed = simulate_mesh(set, &layout, config, options).expect("a run ends");
    let expected = Builder::new().build(set).expect("a mesh").mesh;
    let hash = |mesh: &ltbw::Mesh| mesh.hash().expect("a hash");
    assert_eq!(hash(&meshed.gathered.mesh), hash(&expected));
    for worker in &meshed.summary.workers {
        assert_eq!(worker.times.all(), meshed.summary.makespan);
    }
    meshed
}

/// The seeds to run: `LTBW_CASES` (their number, or `first..end`, so that a long run can be done in
/// pieces), or these many.
fn seeds(default: u64) -> std::ops::Range<u64> {
    let Ok(text) = std::env::var("LTBW_CASES") else { return 0..default };
    let (first, end) = text.split_once("..").unwrap_or(("0", &text));
    // A typo must not turn the full bar into the small one.
    let number = |text: &str| text.parse().expect("LTBW_CASES is 1000 or 0..1000");
    number(first)..number(end)
}

/// Points come as they lie, or those at the interface first.
fn layout_of(seed: u64, points: usize, workers: u32) -> Layout {
    if (seed / 7).is_multiple_of(2) {
        Layout::for_high_latency(points, workers)
    } else {
        Layout::new(points, workers)
    }
}

/// The case of a seed: kind, size, processors, rule, network, storm.
fn case(seed: u64) -> (PointSet, Layout, Rule, Options) {
    let k = seed as usize;
    let kind = PointKind::ALL[k % PointKind::ALL.len()];
    // The meshes of the moment curve and of lines have quadratic size.
    let most = if matches!(kind, PointKind::Moment | PointKind::Lines) { 3 } else { 12 };
    let points = generate(kind, 100 + 100 * (k / 3 % most), seed);
    let set = PointSet::new(points).expect("finite points");
    let workers = [2, 3, 5, 8, 16, 40, 100, 1024][k / 2 % 8];
    let latency = [0, 1_000, 100_000, 10_000_000, 1_000_000_000][k % 5];
    let network = Network {
        latency,
        distribution: Distribution::ALL[k / 3 % 4],
        bursts: (k % 4 == 1).then_some(Bursts { every: 2_000_000, length: 500_000 }),
        ..Network::default()
    };
    let options = Options {
        network,
        letters: k % 5 == 3,
        poll_every: 1 + k as u32 / 4 % 4,
        slow: if k.is_multiple_of(6) { vec![(WorkerId::new(1), 100.0)] } else { Vec::new() },
        storm: k.is_multiple_of(3).then_some(RandomMigrations { every: 50_000 + latency / 10 }),
        ..options(seed)
    };
    // The paper's rule livelocks where messages take long; it has a test of its own.
    let rule = Rule::WoundWait;
    let layout = Layout { blocks_per_worker: 4, sample: 10, ..layout_of(seed, set.len(), workers) };
    (set, layout, rule, options)
}

#[test]
fn who_polls_seldom_has_the_same_mesh_with_fewer_polls() {
    let set = PointSet::new(generate(PointKind::Uniform, 3000, 5)).expect("finite points");
    let layout = Layout::new(set.len(), 4);
    let runs: Vec<Meshed> = [1, 2, 50, u32::MAX]
        .into_iter()
        .map(|poll_every| {
            let costs = CostModel { idle_poll: 0.0, ..CostModel::cow() };
            let options = Options { poll_every, costs, network: Network::cow(), ..options(5) };
            run(&set, layout, Rule::WoundWait, &options)
        })
        .collect();
    let vain = |run: &Meshed| run.summary.polls.total - run.summary.polls.useful;
    // A worker that looks at the end alone looks as seldom as one that does every fiftieth time.
    assert!(runs[..3].is_sorted_by_key(|run| std::cmp::Reverse(vain(run))));
    assert!(vain(&runs[1]) > vain(&runs[3]) && vain(&runs[0]) > 2 * vain(&runs[2]));
    // A cavity takes about 2.4 ms on one of the paper's processors.
    let one = Layout { workers: 1, ..layout };
    let options = Options { costs: CostModel::cow(), ..options(5) };
    let alone = run(&set, one, Rule::WoundWait, &options).summary;
    let each = alone.cavity_times.successful as f64 / alone.operations() as f64;
    assert!((2.0e6..2.8e6).contains(&each), "{each}");
    let never = Options { poll_every: 0, ..options };
    let refused = simulate_mesh(&set, &one, Config::new(1), &never);
    assert!(matches!(refused, Err(MeshError::Simulation(SimulationError::Options(_)))));
}

/// A message of a letter costs its bytes alone, at either end, and waits for the end of its turn.
#[test]
fn messages_of_a_turn_go_in_letters() {
    let set = PointSet::new(generate(PointKind::Uniform, 3000, 5)).expect("finite points");
    let layout = Layout { ownership: Ownership::Newest, ..Layout::new(set.len(), 2) };
    let with = |letters, send| {
        let costs = CostModel { send, receive: send, ..CostModel::default() };
        let own = Options { letters, costs, poll_every: 4, check_every: 50, ..options(5) };
        run(&set, layout, Rule::WoundWait, &Options { balance: None, ..own }).summary
    };
    let [alone, together] = [false, true].map(|letters| with(letters, 20_000.0));
    let talk = |run: &Summary| run.workers.iter().map(|w| w.times.communication).sum::<u64>();
    let sent = |run: &Summary| run.messages.values().map(|kind| kind.count).sum::<u64>();
    let each = |run: &Summary| talk(run) as f64 / sent(run) as f64;
    assert!(1.5 * each(&together) < each(&alone), "{} {}", each(&together), each(&alone));
    assert!(together.makespan < alone.makespan);
    // Where messages cost nothing, to wait for the others of a turn only takes time.
    let [alone, together] = [false, true].map(|letters| with(letters, 0.0));
    assert!(together.makespan > alone.makespan);
}

/// Algorithm 2 polls on while there is nothing to do; a message then waits for the end of a look.
#[test]
fn who_has_nothing_to_do_looks_for_messages_where_that_costs() {
    let set = PointSet::new(generate(PointKind::Uniform, 3000, 5)).expect("finite points");
    let layout = Layout::new(set.len(), 4);
    let with = |idle_poll| {
        let costs = CostModel { idle_poll, ..CostModel::cow() };
        let options = Options { costs, network: Network::cow(), balance: None, ..options(5) };
        run(&set, layout, Rule::WoundWait, &options).summary
    };
    let (asleep, looking) = (with(0.0), with(33_000.0));
    let vain = |run: &Summary| run.polls.total_time - run.polls.useful_time;
    assert!(vain(&looking) > 2 * vain(&asleep), "{} {}", vain(&looking), vain(&asleep));
    assert!(looking.makespan >= asleep.makespan);
    let idle = |run: &Summary| run.workers.iter().map(|w| w.times.idle).sum::<u64>();
    // The time between the ends of two workers is left.
    assert!(100 * idle(&looking) < idle(&asleep), "{} {}", idle(&looking), idle(&asleep));
    for worker in &looking.workers {
        let vain = worker.polls.total_time - worker.polls.useful_time;
        assert!(worker.times.idle_at_end <= worker.times.idle + vain);
    }
}

#[test]
fn the_sequential_mesh_on_any_processors() {
    let (mut setbacks, mut moves) = (0, 0);
    for seed in seeds(60) {
        let (set, layout, rule, options) = case(seed);
        let meshed = run(&set, layout, rule, &options);
        setbacks += meshed.summary.setbacks();
        moves += meshed.summary.workers.iter().map(|w| w.migrations).sum::<u64>();
    }
    assert!(setbacks > 100 && moves > 100, "{setbacks} setbacks, {moves} moves");
}

/// The bar's sizes: 2,000 to 200,000 points on 2 to 1024 processors, blocks moving in each run.
/// All of them, some five seconds a seed:
/// `LTBW_CASES=1000 cargo test --release -p ltbw --test parallel simulate_mesh:: -- --ignored
/// --nocapture`.
#[test]
#[ignore = "more than an hour for all thousand seeds"]
fn large_sets_on_any_processors() {
    let (mut points, mut moves) = (0, 0);
    let mut worst = 0;
    for seed in seeds(10) {
        let kinds = [PointKind::Uniform, PointKind::Grid, PointKind::Clusters, PointKind::Sphere];
        // Evenly distributed over the orders of magnitude.
        let size = 2000.0 * 100f64.powf(Random::new(seed).unit());
        let set = PointSet::new(generate(kinds[seed as usize % 4], size as usize, seed));
        let set = set.expect("finite points");
        let (_, layout, rule, options) = case(seed);
        let every = 5_000_000 + options.network.latency;
        let options =
            Options { storm: Some(RandomMigrations { every }), max_events: 1 << 32, ..options };
        let layout = Layout { blocks_per_worker: 8, ..layout_of(seed, set.len(), layout.workers) };
        let meshed = run(&set, layout, rule, &options);
        points += set.len();
        moves += meshed.summary.workers.iter().map(|w| w.migrations).sum::<u64>();
        worst = worst.max(meshed.summary.worst_setbacks());
        println!("seed {seed}: {} points on {}, {rule}", set.len(), layout.workers);
    }
    println!("{points} points, {moves} moves, at most {worst} setbacks of one operation");
    assert!(moves > 0);
}

#[test]
fn a_tetrahedron_is_known_by_any_of_its_names() {
    // Its owner names a tetrahedron when its neighbour's block moves, and a home names it too: a
    // later home took a face between two tetrahedra of its cavity for a part of the boundary.
    let points = generate(PointKind::Cospherical, 1650, 9);
    let set = PointSet::new(points).expect("finite points");
    let network = Network {
        latency: 1_000_000_000,
        distribution: Distribution::HeavyTail,
        bursts: Some(Bursts { every: 2_000_000, length: 500_000 }),
        ..Network::default()
    };
    let storm = Some(RandomMigrations { every: 100_050_000 });
    let layout = Layout { blocks_per_worker: 4, ..Layout::new(1650, 16) };
    run(&set, layout, Rule::WoundWait, &Options { network, storm, ..options(9) });
}

/// Blocks go on moving in a cancelled run, and take no points along: each processor forgets its
/// own, be it before its first insertion.
#[test]
fn a_cancelled_run_ends_while_blocks_move() {
    // Enough points for each processor to insert its own in two rounds.
    let set = PointSet::new(generate(PointKind::Uniform, 20_000, 3)).expect("finite points");
    let layout = Layout { blocks_per_worker: 4, sample: 10, ..Layout::new(20_000, 3) };
    // Long enough for moves between the cancel and the end of the run.
    let network = Network { latency: 300_000, ..Network::default() };
    let mut moves = 0;
    let mut size_before = 0;
    for cancel in [0, 100_000, 1_000_000, 5_000_000] {
        let storm = Some(RandomMigrations { every: 20_000 });
        let cancel = Some(cancel);
        let options = Options { network, storm, cancel, max_events: 1_000_000, ..options(1) };
        let run = simulate_mesh(&set, &layout, Config::new(3), &options).expect("a run ends");
        invariants::check_all(&run.gathered.mesh).expect("invariants");
        let size = run.gathered.mesh.num_vertices();
        assert!(size_before <= size && size < 20_000, "{size} vertices, {size_before} before");
        size_before = size;
        moves += run.summary.workers.iter().map(|w| w.migrations).sum::<u64>();
    }
    assert!(moves > 20, "{moves} moves");
}

#[test]
fn the_paper_gets_the_same_mesh() {
    let set = PointSet::new(generate(PointKind::Uniform, 1500, 4)).expect("finite points");
    let meshed = run(&set, Layout::new(1500, 6), Rule::Paper, &options(4));
    assert!(meshed.summary.setbacks() > 0);
}

#[test]
fn a_seed_reproduces_a_run() {
    let set = PointSet::new(generate(PointKind::Clusters, 3000, 2)).expect("finite points");
    let network = Network { distribution: Distribution::HeavyTail, ..Network::default() };
    let storm = Some(RandomMigrations { every: 100_000 });
    let options = Options { network, storm, spans: 1_000_000, ..options(7) };
    let of = || {
        let meshed = run(&set, Layout::new(3000, 9), Rule::WoundWait, &options);
        (meshed.summary, meshed.events, meshed.trace)
    };
    assert_eq!(of(), of());
}

#[test]
fn the_papers_variants_get_the_same_mesh() {
    let (mut setbacks, mut moves) = ([0; 2], 0);
    for seed in 0..36 {
        let kinds = [PointKind::Uniform, PointKind::Grid, PointKind::Cospherical];
        let points = generate(kinds[seed as usize % 3], 600, seed);
        let set = PointSet::new(points).expect("finite points");
        let ownership = Ownership::ALL[seed as usize / 3 % 3];
        let rule = Rule::ALL[seed as usize / 6 % 2];
        let workers = [2, 5, 9][seed as usize / 2 % 3];
        let own_curves = seed % 4 > 1;
        let layout = Layout { ownership, own_curves, ..Layout::new(600, workers) };
        let layout = Layout { blocks_per_worker: 4, sample: 60, ..layout };
        let options = match ownership {
            Ownership::Block => {
                Options { storm: Some(RandomMigrations { every: 20_000 }), ..options(seed) }
            }
            Ownership::Newest | Ownership::Creator => Options { balance: None, ..options(seed) },
        };
        for (closure, sum) in [Closure::Face, Closure::Vertex].into_iter().zip(&mut setbacks) {
            let config = Config { rule, closure, ..Config::new(workers) };
            let meshed = run_as(&set, layout, config, &options);
            *sum += meshed.summary.setbacks();
            moves += meshed.summary.workers.iter().map(|w| w.migrations).sum::<u64>();
        }
    }
    let [face, vertex] = setbacks;
    assert!(face > 0 && vertex > 2 * face && moves > 50, "{face}, {vertex}, {moves} moves");
}

#[test]
fn what_is_not_owned_by_blocks_does_not_move() {
    let set = PointSet::new(generate(PointKind::Uniform, 200, 1)).expect("finite points");
    for ownership in [Ownership::Newest, Ownership::Creator] {
        let layout = Layout { ownership, ..Layout::new(200, 2) };
        let error =
            simulate_mesh(&set, &layout, Config::new(2), &options(1)).expect_err("balanced");
        assert!(matches!(error, MeshError::Simulation(SimulationError::Options(_))), "{error}");
        assert!(error.to_string().contains("creator"), "{error}");
    }
}

#[test]
fn the_invariants_hold_between_the_events_of_a_run_with_moves() {
    for seed in 0..3 {
        let set = PointSet::new(generate(PointKind::Uniform, 250, seed)).expect("finite points");
        let options = Options {
            storm: Some(RandomMigrations { every: 20_000 }),
            check_every: 7,
            ..options(seed)
        };
        let layout = Layout { blocks_per_worker: 8, ..Layout::new(250, 3) };
        let meshed = run(&set, layout, Rule::WoundWait, &options);
        let moved: u64 = meshed.summary.workers.iter().map(|worker| worker.migrations).sum();
        assert!(moved > 0, "no block moves");
    }
}
