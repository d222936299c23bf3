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
//! The cost of a message over a network is not measured: it is an assumption of the cost model.

use ltbw::PointSet;
use ltbw::mesh::{Layout, LocalMesh, PointQueue, WireVertex};
use ltbw::protocol::{Config, Costs, Event, Submesh, Worker};
use ltbw::simulate::CostModel;
use ltbw_generate::{PointKind, generate};

type Failure = Box<dyn std::error::Error>;
type Alone = Worker<LocalMesh, PointQueue>;

/// Runs of each measurement.
const RUNS: usize = 5;

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
    println!("the cost model has: {model:?}");
    Ok(())
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
