//! The limit of tetrahedra, lowered: a run that meets it fails with a typed error, on every
//! runtime. It neither hangs nor touches a tetrahedron that is not there.

use ltbw::balance::Balance;
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Config, SubmeshError, WorkerId};
use ltbw::simulate::{MeshError, Options, RandomMigrations, SimulationError, simulate_mesh};
use ltbw::threads::{Parallel, RunError};
use ltbw::{Builder, MeshHash, PointSet, WorkerError};
use ltbw_generate::{PointKind, generate};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Longer than any of these runs takes: a run that is not done by then hangs.
const PATIENCE: Duration = Duration::from_secs(120);

/// The end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Whole,
    NoRoom,
}

/// Runs `f` on a thread of its own, which must end.
fn in_time<T: Send + 'static>(what: String, f: impl FnOnce() -> T + Send + 'static) -> T {
    let (sender, receiver) = channel();
    std::thread::spawn(move || sender.send(f()));
    match receiver.recv_timeout(PATIENCE) {
        Ok(result) => result,
        Err(RecvTimeoutError::Timeout) => panic!("{what}: the run hangs"),
        Err(RecvTimeoutError::Disconnected) => panic!("{what}: the run panicked"),
    }
}

struct Scene {
    set: PointSet,
    expected: MeshHash,
    /// Tetrahedra of the whole mesh.
    tets: usize,
}

fn scene(kind: PointKind, count: usize, seed: u64) -> Scene {
    let set = PointSet::new(generate(kind, count, seed)).expect("finite points");
    let mesh = Builder::new().build(&set).expect("a mesh").mesh;
    let tets = mesh.num_tets() + mesh.num_hull_faces();
    Scene { set, expected: mesh.hash().expect("a hash"), tets }
}

fn on_threads(kind: PointKind, count: usize, layout: Layout, distributed: bool) -> End {
    let Scene { set, expected, .. } = scene(kind, count, 7);
    let kernel = Parallel::new(layout.workers).layout(layout);
    let run = match distributed {
        true => kernel.build_distributed(&set).map(|run| run.gather().expect("a whole mesh")),
        false => kernel.build(&set),
    };
    match run {
        Ok(run) => {
            assert_eq!(run.mesh.hash().expect("a hash"), expected, "another mesh");
            End::Whole
        }
        Err(RunError::Worker(WorkerError::Submesh {
            worker,
            error: SubmeshError::NoRoom { limit },
        })) => {
            assert!(worker < WorkerId::new(layout.workers) && limit == layout.max_tets);
            End::NoRoom
        }
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn threads_end_at_the_limit_with_a_typed_error() {
    for (kind, count) in
        [(PointKind::Uniform, 2000), (PointKind::Lines, 150), (PointKind::Clusters, 2000)]
    {
        let tets = scene(kind, count, 7).tets;
        let mut ends = Vec::new();
        for (workers, tenths) in [1, 2, 3, 5].into_iter().flat_map(|w| [1, 4, 8].map(|t| (w, t))) {
            for ownership in Ownership::ALL {
                let max_tets = tets * tenths / 10 / workers as usize;
                let layout = Layout { ownership, max_tets, ..Layout::new(count, workers) };
                let what = format!("{kind:?}, {layout:?}");
                let distributed = tenths == 4;
                let end = in_time(what, move || on_threads(kind, count, layout, distributed));
                // All together have no room for the mesh.
                assert_eq!(end, End::NoRoom);
                ends.push(end);
            }
        }
        for workers in [1, 2, 3] {
            // Interface faces take room, too.
            let layout = Layout { max_tets: 3 * tets, ..Layout::new(count, workers) };
            let what = format!("{kind:?}, {layout:?}");
            let end = in_time(what, move || on_threads(kind, count, layout, false));
            assert_eq!(end, End::Whole, "there is room enough");
        }
    }
}

fn simulated(kind: PointKind, layout: Layout, seed: u64, storm: Option<RandomMigrations>) -> End {
    let Scene { set, expected, .. } = scene(kind, 300, seed);
    let balance = (layout.ownership == Ownership::Block).then(Balance::default);
    let options = Options { seed, storm, balance, max_events: 5_000_000, ..Options::default() };
    match simulate_mesh(&set, &layout, Config::new(layout.workers), &options) {
        Ok(meshed) => {
            assert_eq!(meshed.gathered.mesh.hash().expect("a hash"), expected, "another mesh");
            End::Whole
        }
        Err(MeshError::Simulation(SimulationError::Worker(WorkerError::Submesh {
            worker,
            error: SubmeshError::NoRoom { limit },
        }))) => {
            assert!(worker < WorkerId::new(layout.workers) && limit == layout.max_tets);
            End::NoRoom
        }
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn simulated_runs_end_at_the_limit_with_a_typed_error() {
    let mut ends = Vec::new();
    for seed in 0..60_u64 {
        let kind = [PointKind::Uniform, PointKind::Lines, PointKind::Grid][seed as usize % 3];
        let tets = scene(kind, 300, seed).tets;
        let workers = [2, 3, 8][seed as usize / 3 % 3];
        let ownership = Ownership::ALL[seed as usize / 9 % 3];
        // Blocks move, in some: they find no room where they go.
        let moves = ownership == Ownership::Block && seed % 2 == 0;
        let storm = moves.then_some(RandomMigrations { every: 20_000 });
        let max_tets = tets * (1 + seed as usize % 20) / (5 * workers as usize);
        let layout = Layout {
            ownership,
            max_tets,
            sample: 10,
            blocks_per_worker: 4,
            ..Layout::new(300, workers)
        };
        let what = format!("seed {seed}: {kind:?}, {layout:?}, {storm:?}");
        ends.push(in_time(what, move || simulated(kind, layout, seed, storm)));
    }
    let whole = ends.iter().filter(|&&end| end == End::Whole).count();
    assert!(whole > 5 && ends.len() - whole > 20, "{whole} of {} were whole", ends.len());
}

/// There is no room for what a worker gets of the coarse mesh.
#[test]
fn a_start_without_room_fails() {
    for max_tets in [0, 1, 4, 40] {
        let layout = Layout { max_tets, ..Layout::new(1000, 3) };
        for distributed in [false, true] {
            let what = format!("{layout:?}");
            let end =
                in_time(what, move || on_threads(PointKind::Uniform, 1000, layout, distributed));
            assert_eq!(end, End::NoRoom);
        }
        let what = format!("simulated, {layout:?}");
        let end = in_time(what, move || simulated(PointKind::Uniform, layout, 1, None));
        assert_eq!(end, End::NoRoom);
    }
}
