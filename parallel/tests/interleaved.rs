//! Workers in one thread, their steps and messages in random order, FIFO between each pair: the
//! mesh is the sequential kernel's, and nothing is left locked, awaited or under way.
//! With the feature `serde` (always on in a workspace build) every message goes through bytes.

use ltbw::generate::{PointKind, Random, generate};
use ltbw::mesh::{Field, LocalMesh, Plan, gather};
use ltbw::protocol::{Action, Config, Event, Message, Rule, Source, Worker};
use ltbw::{Builder, Point, PointSet, invariants};
use std::collections::{BTreeMap, VecDeque};

type Node = Worker<LocalMesh, Field>;

/// Steps after which a run counts as hanging, per point.
const STEPS_PER_POINT: usize = 2000;

struct World {
    nodes: Vec<Node>,
    channels: BTreeMap<(usize, usize), VecDeque<Message<LocalMesh>>>,
    backoff: Vec<(usize, Event<LocalMesh>)>,
    random: Random,
    migrations: u32,
    blocks: u32,
    setbacks: u32,
    committed: u32,
    /// Messages go through bytes.
    bytes: bool,
}

impl World {
    /// Carries out one step of the world; `false` if nothing can happen any more.
    fn turn(&mut self) -> bool {
        let n = self.nodes.len();
        let mut out = Vec::new();
        let open: Vec<(usize, usize)> = self.channels.keys().copied().collect();
        let busy: Vec<usize> = (0..n).filter(|&w| self.nodes[w].has_work()).collect();
        let choices = open.len() + busy.len() + self.backoff.len();
        if choices == 0 {
            return false;
        }
        let pick = self.random.below(choices as u64) as usize;
        let node = if let Some(&(from, to)) = open.get(pick) {
            let queue = self.channels.get_mut(&(from, to)).expect("an open channel");
            let message = queue.pop_front().expect("a message");
            if queue.is_empty() {
                self.channels.remove(&(from, to));
            }
            let message = if self.bytes { through_bytes(message) } else { message };
            self.nodes[to].step(Event::Message { from: from as u32, message }, &mut out);
            to
        } else if let Some(&w) = busy.get(pick - open.len()) {
            if self.migrations > 0 && self.random.below(40) == 0 {
                let block = self.random.below(u64::from(self.blocks)) as u32;
                let to = self.random.below(n as u64) as u32;
                self.nodes[w].step(Event::Migrate { block, to }, &mut out);
                self.migrations -= u32::from(!out.is_empty());
            }
            self.nodes[w].step(Event::Work, &mut out);
            w
        } else {
            let (w, event) = self.backoff.swap_remove(pick - open.len() - busy.len());
            self.nodes[w].step(event, &mut out);
            w
        };
        for action in out {
            match action {
                Action::Send { to, message } => {
                    self.channels.entry((node, to as usize)).or_default().push_back(message);
                }
                Action::Backoff { ticket, .. } => self.backoff.push((node, Event::Retry(ticket))),
                Action::Note(note) => {
                    self.setbacks +=
                        u32::from(matches!(note, ltbw::protocol::Note::SetBack { .. }));
                    self.committed +=
                        u32::from(matches!(note, ltbw::protocol::Note::Committed { .. }));
                }
            }
        }
        true
    }
}

/// A message that went through bytes: nothing in it can point to shared memory.
#[cfg(feature = "serde")]
fn through_bytes(message: Message<LocalMesh>) -> Message<LocalMesh> {
    let bytes = serde_json::to_vec(&message).expect("bytes");
    let back: Message<LocalMesh> = serde_json::from_slice(&bytes).expect("a message");
    assert_eq!(bytes, serde_json::to_vec(&back).expect("bytes"));
    back
}

#[cfg(not(feature = "serde"))]
fn through_bytes(message: Message<LocalMesh>) -> Message<LocalMesh> {
    message
}

/// Runs `points` on `workers` workers; returns setbacks and operations committed.
fn run(points: Vec<Point>, plan: Plan, rule: Rule, migrations: u32, seed: u64) -> (u32, u32) {
    let set = PointSet::new(points).expect("finite points");
    let expected = Builder::new().build(&set).expect("a mesh");
    let prepared = plan.prepare(&set).expect("a mesh");
    let config = Config { rule, ..Config::new(plan.workers) };
    let nodes: Vec<Node> = prepared
        .workers
        .into_iter()
        .map(|(directory, mesh, field)| Worker::new(config, directory, mesh, field))
        .collect();
    let blocks = plan.workers * plan.blocks_per_worker;
    let mut world = World {
        nodes,
        channels: BTreeMap::new(),
        backoff: Vec::new(),
        random: Random::new(seed),
        migrations,
        blocks,
        setbacks: 0,
        committed: 0,
        bytes: seed.is_multiple_of(3),
    };
    let limit = STEPS_PER_POINT * (set.len() + 100);
    let mut steps = 0;
    while world.turn() {
        steps += 1;
        if steps >= limit {
            let nodes: Vec<String> = world.nodes.iter().map(Node::describe).collect();
            let channels: Vec<_> =
                world.channels.iter().map(|(k, q)| (k, q.len(), q[0].kind())).collect();
            panic!("no end after {steps} steps, seed {seed}:\n{}\n{channels:?}", nodes.join("\n"));
        }
    }
    for node in &world.nodes {
        let ended = node.is_stopped() && node.is_quiescent();
        if !ended {
            let all: Vec<String> = world.nodes.iter().map(Node::describe).collect();
            panic!("seed {seed}, {rule}, stopped: {}\n{}", node.is_stopped(), all.join("\n"));
        }
        assert!(node.source().is_empty());
    }
    let meshes = world.nodes.into_iter().map(|node| node.into_parts().0).collect();
    let whole = gather(meshes, prepared.common).expect("a whole mesh");
    invariants::check_all(&whole.mesh).expect("invariants");
    assert_eq!(whole.duplicates, expected.duplicates, "seed {seed}");
    assert_eq!(whole.mesh.hash().expect("a hash"), expected.mesh.hash().expect("a hash"));
    (world.setbacks, world.committed)
}

fn plan(workers: u32, sample: usize) -> Plan {
    Plan { workers, blocks_per_worker: 4, cursors: 4, sample, roomy: false }
}

#[test]
fn one_worker_is_the_sequential_kernel() {
    for kind in [PointKind::Uniform, PointKind::Grid] {
        let (setbacks, committed) =
            run(generate(kind, 2000, 1), plan(1, 10), Rule::WoundWait, 0, 1);
        assert_eq!((setbacks, committed), (0, 0), "nothing is in the way of one worker");
    }
}

#[test]
fn the_mesh_is_one_for_any_number_of_workers_and_any_timing() {
    let mut total = (0, 0);
    for seed in 0..12u64 {
        for workers in [2, 3, 5, 8] {
            for kind in [PointKind::Uniform, PointKind::Grid, PointKind::Clusters] {
                let points = generate(kind, 400, seed);
                let (setbacks, committed) =
                    run(points, plan(workers, 20), Rule::WoundWait, 0, seed);
                total = (total.0 + setbacks, total.1 + committed);
            }
        }
    }
    assert!(total.0 > 20 && total.1 > 5000, "too tame to show anything: {total:?}");
}

#[test]
fn every_rule_gives_the_mesh() {
    for rule in [Rule::WaitDie, Rule::Paper] {
        let mut setbacks = 0;
        for seed in 0..8 {
            for workers in [2, 4, 7] {
                let points = generate(PointKind::Uniform, 300, seed);
                setbacks += run(points, plan(workers, 20), rule, 0, seed).0;
            }
        }
        assert!(setbacks > 50, "{rule} is hardly ever set back: {setbacks}");
    }
}

#[test]
fn blocks_that_move_change_nothing() {
    for rule in [Rule::WoundWait, Rule::WaitDie] {
        for seed in 0..12 {
            for workers in [2, 3, 6] {
                let kind = if seed % 2 == 0 { PointKind::Uniform } else { PointKind::Grid };
                run(generate(kind, 300, seed), plan(workers, 20), rule, 60, seed);
            }
        }
    }
}

#[test]
fn small_sets_empty_workers_and_one_block() {
    for seed in 0..40 {
        for count in [4, 5, 6, 8, 10, 20] {
            for workers in [2, 9, 30] {
                let points = generate(PointKind::Uniform, count, seed);
                run(points, plan(workers, 4), Rule::WoundWait, 10, seed);
            }
        }
    }
    // All points but one in the block of one worker; many points equal.
    let mut points = generate(PointKind::Uniform, 200, 7);
    points.extend(points.clone());
    points.push([1e6; 3]);
    run(points, plan(6, 10), Rule::WoundWait, 10, 3);
}

#[test]
fn degenerate_and_wide_sets() {
    for seed in 0..4 {
        for kind in [PointKind::Grid, PointKind::Sphere, PointKind::Lines, PointKind::Moment] {
            run(generate(kind, 216, seed), plan(4, 12), Rule::WoundWait, 20, seed);
        }
        let scales = [1.0, 1e-300, 1e300];
        let points = generate(PointKind::Uniform, 200, seed);
        let wide = points.iter().zip((0..3).cycle()).map(|(p, k)| p.map(|c| c * scales[k]));
        run(wide.collect(), plan(3, 12), Rule::WoundWait, 10, seed);
    }
}
