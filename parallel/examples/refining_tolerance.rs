//! Latency tolerance of refinement without rounds, on simulated processors:
//! `cargo run --release -p ltbw --example refining_tolerance -- 4000 1e-5 16`.
//!
//! The corners of the unit cube and that number of points inside it, refined to that largest volume
//! and to a ratio of 2 on that many processors, with latencies from 1 to 300 µs.

use ltbw::mesh::{Layout, Ownership};
use ltbw::metrics::tolerance;
use ltbw::protocol::{Config, Correct};
use ltbw::refining::{Bounds, simulate_refined};
use ltbw::simulate::{Network, Options};
use ltbw::{Point, PointSet};
use ltbw_generate::{PointKind, generate};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [inside, volume, processors] = words.as_slice() else {
        return Err("usage: refining_tolerance POINTS VOLUME PROCESSORS".into());
    };
    let (inside, volume, processors) = (inside.parse()?, volume.parse()?, processors.parse()?);
    let mut points: Vec<Point> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    points.extend(generate(PointKind::Uniform, inside, 1));
    let set = PointSet::new(points)?;
    let bounds = Bounds::new(&set, volume, 2.0)?;
    let run = |processors: u32, latency: u64| {
        let layout = Layout { ownership: Ownership::Newest, ..Layout::new(set.len(), processors) };
        let network = Network { latency, ..Network::default() };
        let options = Options { network, ..Options::default() };
        simulate_refined::<Correct>(&set, bounds, &layout, Config::new(processors), &options)
    };
    let alone = run(1, 1_000)?.summary;
    println!("one processor: {} points, {} ms", alone.operations(), alone.makespan / 1_000_000);
    println!("latency  points  LT worst     all  LT strict  efficiency  setbacks  active  let go");
    for latency in [1_000, 10_000, 100_000, 300_000] {
        let s = run(processors, latency)?.summary;
        println!(
            "{:>4} µs {:>7} {:>9} {:>7} {:>10} {:>9.1} % {:>6.2} % {:>5.1} % {:>7}",
            latency / 1000,
            s.operations(),
            tolerance(s.worst_lt()),
            tolerance(s.lt()),
            tolerance(s.lt_strict()),
            100.0 * s.efficiency(alone.makespan),
            100.0 * s.setback_share(),
            100.0 * s.cavities.share_active(),
            s.workers.iter().map(|w| w.known).sum::<u64>(),
        );
    }
    Ok(())
}
