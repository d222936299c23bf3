//! Everything that threads of this crate share, a little of each: `cargo xtask tsan` runs it under
//! ThreadSanitizer. Prints the number of runs; fails if a mesh is not the sequential kernel's.
//!
//! Rayon, which orders the points before the workers start and puts the mesh together after they
//! have ended, has no thread here: it orders memory by fences, which the sanitizer does not know.

use ltbw::balance::Balance;
use ltbw::threads::Parallel;
use ltbw::{Builder, CancelToken, Outcome, Phase, PointSet, Progress};
use ltbw_core::cavity::AdmitAll;
use ltbw_core::mesh::lanes::{Batch, Chosen, Follow, Lanes, View};
use ltbw_core::topology::{FaceId, TetId, VertexId};
use ltbw_generate::{PointKind, generate};
use std::sync::atomic::{AtomicBool, Ordering};
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
    let hooks = |p: Progress| {
        if p.phase == Phase::Insert {
            std::thread::sleep(Duration::from_millis(30));
            token.cancel();
        }
    };
    let kernel = Parallel::new(4).latency(Duration::from_millis(20)).observer(&hooks);
    let run = kernel.cancel(&token).build(&set)?;
    if run.outcome != Outcome::Cancelled {
        return Err("the run was too short to be cancelled".into());
    }
    Ok(1)
}

/// Slots written by the lanes that insert into one mesh.
struct Written(Vec<AtomicBool>);

impl Follow for Written {
    type Own = usize;

    fn changed(&self, t: TetId) -> bool {
        self.0[t.index()].load(Ordering::Relaxed)
    }

    fn fetch(&self, _: TetId) {}

    fn opened(&self, _: &mut usize, boundary: impl Iterator<Item = FaceId>) {
        boundary.for_each(drop);
    }

    fn filled(&self, own: &mut usize, _: usize, star: &[TetId], view: View<'_>) {
        *own += star.iter().filter(|&&t| view.tet(t).is_some()).count();
        star.iter().for_each(|t| self.0[t.index()].store(true, Ordering::Relaxed));
    }

    fn ended(&self, _: &mut usize, _: View<'_>) {}
}

/// Insertions of many points into one mesh, in two to five lanes; returns their number.
fn lanes(points: usize) -> Result<u32, Failure> {
    let all = generate(PointKind::Uniform, 2 * points, 4);
    let expected = Builder::new().build(&PointSet::new(all.clone())?)?.mesh.hash()?;
    let (start, rest) = all.split_at(points);
    for many in 2..=5 {
        let mut mesh = Builder::new().build(&PointSet::new(start.to_vec())?)?.mesh;
        let (mut memory, mut filled) = (Lanes::default(), 0);
        for list in rest.chunks(points / 10) {
            let mut cavities = Vec::new();
            for p in list {
                let from = mesh.hint();
                let open =
                    mesh.begin(*p, from, &mut AdmitAll).map_err(|_| "a point is a vertex")?;
                cavities.push(open.tets().collect::<Vec<TetId>>());
            }
            let slots = mesh.make_room_for(list.len(), many)?;
            let follow = Written((0..slots).map(|_| AtomicBool::new(false)).collect());
            let chosen = |k: usize| Chosen {
                p: list[k],
                cavity: &cavities[k],
                is_fixed: k.is_multiple_of(3),
            };
            let number = mesh.num_vertices() as u32;
            let batch = Batch { number, count: list.len(), chosen: &chosen };
            let mut own = vec![0; many];
            let (first, put_off) = mesh.fill_in_lanes(&mut memory, batch, &follow, &mut own);
            filled += own.iter().filter(|&&count| count > 0).count();
            for k in put_off {
                let from = mesh.hint();
                let open = mesh.begin(list[k], from, &mut AdmitAll).map_err(|_| "a vertex")?;
                open.fill_vertex(VertexId::at(first.index() + k));
            }
        }
        if mesh.hash()? != expected || filled < 10 * many {
            return Err(format!("another mesh, or lanes without insertions: {many}").into());
        }
    }
    Ok(4)
}

fn main() -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let points = std::env::args().nth(1).map_or(Ok(1500), |text| text.parse())?;
    println!("{} runs", whole_runs(points)? + cancelled_run(20 * points)? + lanes(points)?);
    Ok(())
}
