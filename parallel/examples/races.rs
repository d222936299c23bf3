//! Everything that threads of this crate share, a little of each: `cargo xtask tsan` runs it under
//! ThreadSanitizer. Prints the number of runs; fails if a mesh is not the sequential kernel's.
//!
//! Rayon, which orders the points before the workers start and puts the mesh together after they
//! have ended, has no thread here: it orders memory by fences, which the sanitizer does not know.

use ltbw::balance::Balance;
use ltbw::threads::Parallel;
use ltbw::{Builder, CancelToken, Outcome, Phase, PointSet, Progress};
use ltbw_generate::{PointKind, generate};
use std::time::Duration;

type Failure = Box<dyn std::error::Error>;

/// Runs whose mesh is known, with blocks that move and messages that take their time.
fn whole_runs(points: usize) -> Result<u32, Failure> {
    let mut runs = 0;
    for kind in [PointKind::Uniform, PointKind::Grid, PointKind::Clusters] {
        let set = PointSet::new(generate(kind, points, 3))?;
        let expected = Builder::new().build(&set)?.mesh.hash()?;
        for (workers, latency) in [(2, 0), (4, 0), (4, 200), (9, 0)] {
            let run = Parallel::new(workers).latency(Duration::from_micros(latency));
            let run = run.balance(Balance { low: 16, ask: 2, again: 100_000 });
            if run.measure(1000).build(&set)?.mesh.hash()? != expected {
                return Err(format!("another mesh: {kind:?} on {workers}").into());
            }
            runs += 1;
        }
    }
    Ok(runs)
}

/// A run that the calling thread cancels, as it is told of the progress.
fn cancelled_run(points: usize) -> Result<u32, Failure> {
    let set = PointSet::new(generate(PointKind::Uniform, points, 3))?;
    let token = CancelToken::new();
    // No worker waits for the observer.
    let watch = |p: Progress| {
        if p.phase == Phase::Insert {
            std::thread::sleep(Duration::from_millis(30));
            token.cancel();
        }
    };
    let kernel = Parallel::new(4).latency(Duration::from_millis(20)).observer(&watch);
    let run = kernel.cancel(&token).build(&set)?;
    if run.outcome != Outcome::Cancelled {
        return Err("the run was too short to be cancelled".into());
    }
    Ok(1)
}

fn main() -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let points = std::env::args().nth(1).map_or(Ok(1500), |text| text.parse())?;
    println!("{} runs", whole_runs(points)? + cancelled_run(20 * points)?);
    Ok(())
}
