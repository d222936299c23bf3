//! Measures what the simulator's cost model says of the kernel, on this machine:
//! `cargo run --release -p ltbw --example calibrate -- 200000`.
//!
//! Times are the thread's time on a processor, as Linux counts it, so that other programs do not
//! lengthen them. The best of several runs counts.
//!
//! * walk step: point location of a second point set in the finished mesh, along the curve;
//! * conflict test, tetrahedron: what is left of a whole run of one worker. A point has the same
//!   number of each, nearly, and a test alone costs little beside what comes before it, so that the
//!   two cannot be told apart: the rest is divided as the cost model has it.
//!
//! * look at a tetrahedron: what the rounds of a refinement on one thread take more than the model
//!   has for the walks, tests and tetrahedra of one simulated processor that carries them out. So
//!   it stands for all that rounds do beside: bounds, keys, who is foremost, marks.
//!
//! The cost of a message over a network is not measured: it is an assumption of the cost model.

use ltbw::PointSet;
use ltbw::domain::PrepareOptions;
use ltbw::mesh::{Layout, LocalMesh, PointQueue, WireVertex};
use ltbw::protocol::{Config, Costs, Event, Submesh, Worker};
use ltbw::refine::Refiner;
use ltbw::refining::{Plan, simulate_rounds};
use ltbw::simulate::{CostModel, Options};
use ltbw_generate::{DomainKind, PointKind, Shape, generate, generate_domain};

type Failure = Box<dyn std::error::Error>;
type Alone = Worker<LocalMesh, PointQueue>;

/// Runs of each measurement.
const RUNS: usize = 5;
/// The largest volume of a tetrahedron of the model problem that is refined.
const VOLUME: f64 = 1.73783e-6;

/// The thread's time on a processor so far, in nanoseconds.
fn clock() -> Result<f64, Failure> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    Ok(text.split_whitespace().next().ok_or("no time")?.parse()?)
}

fn main() -> Result<(), Failure> {
    let n: usize = std::env::args().nth(1).map_or(Ok(200_000), |text| text.parse())?;
    let set = PointSet::new(generate(PointKind::Uniform, n, 1))?;
    let model = CostModel::default();
    let mut best = [f64::INFINITY; 2];
    for _ in 0..RUNS {
        let (mut worker, whole, costs) = build(&set)?;
        let walk = walk_step(worker.mesh_mut(), n)?;
        let steps = Costs { tests: 0, created: 0, ..costs };
        let rest = whole - walk * costs.walk_steps as f64;
        let modelled = model.work(costs) - model.work(steps);
        for (best, new) in best.iter_mut().zip([walk, rest / modelled]) {
            *best = best.min(new);
        }
        println!("{costs:?}: {:.0} ns per point", whole / n as f64);
    }
    let [walk_step, scale] = best;
    let (test, created) = (scale * model.test, scale * model.created);
    println!(
        "walk step {walk_step:.1} ns, conflict test {test:.1} ns, tetrahedron {created:.1} ns"
    );
    println!("look at a tetrahedron {:.0} ns", looks(&model)?);
    println!("the cost model has: {model:?}");
    Ok(())
}

/// The time that rounds take for each tetrahedron that they look at, beside what the model has.
fn looks(model: &CostModel) -> Result<f64, Failure> {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default())?;
    let ready = domain.prepare(&PrepareOptions::default())?;
    let refiner = Refiner::new().max_volume(VOLUME).one_thread();
    let mut engine = f64::INFINITY;
    for _ in 0..RUNS {
        let refined = refiner.refine(&ready.domain, &ready.lattice)?;
        let seconds = refined.rounds.iter().map(|round| round.end - round.begin).sum::<f64>();
        engine = engine.min(seconds);
    }
    let modelled = |costs: CostModel| {
        let options = Options { costs, ..Options::default() };
        let plan = |points| Plan { layout: Layout::new(points, 1), config: Config::new(1) };
        let run = simulate_rounds(&refiner, &ready.domain, &ready.lattice, &plan, &options)?;
        let makespan = run.summary.map_or(0, |summary| summary.makespan);
        Ok::<f64, Failure>(makespan as f64)
    };
    let others = modelled(CostModel { look: 0.0, ..*model })?;
    let looked = modelled(CostModel { look: 100.0, ..*model })? - others;
    println!("rounds: {engine:.3} s, of it by the model without looks {:.3} s", others * 1e-9);
    Ok((engine * 1e9 - others) / (looked / 100.0))
}

/// Inserts all points with one worker: the worker, the time, and the work done in it.
fn build(set: &PointSet) -> Result<(Alone, f64, Costs), Failure> {
    let mut prepared = Layout::new(set.len(), 1).distribute(set)?;
    let (directory, mesh, field) = prepared.workers.pop().ok_or("no worker")?;
    let mut worker = Worker::new(Config::new(1), directory, mesh, field);
    worker.mesh_mut().take_costs();
    let mut actions = Vec::new();
    let start = clock()?;
    while worker.has_work() {
        worker.step(Event::Work, &mut actions);
        actions.clear();
    }
    let time = clock()? - start;
    let costs = worker.mesh_mut().take_costs();
    Ok((worker, time, costs))
}

/// The time of a step of point location.
fn walk_step(mesh: &mut LocalMesh, n: usize) -> Result<f64, Failure> {
    let points = generate(PointKind::Uniform, n, 2);
    let order = ltbw::order::hilbert(&points);
    mesh.take_costs();
    let start = clock()?;
    for (k, &i) in (1u32..).zip(&order) {
        std::hint::black_box(mesh.walk(&WireVertex::new(k, points[i as usize]), None));
    }
    let time = clock()? - start;
    Ok(time / mesh.take_costs().walk_steps.max(1) as f64)
}
