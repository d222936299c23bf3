//! Random degenerate sets of 5 to 60 snapped points on 2 to 8 workers, all equal to CGAL: 300 of
//! them, or `LTBW_CASES` (10,000 for the full bar):
//! `LTBW_CASES=10000 cargo test --release -p ltbw-tests --test workspace parallel_cgal:: --
//! --nocapture`
//!
//! Events happen in a random order, of which the simulator's virtual time, in every fifth case, is
//! one.

use ltbw::balance::Balance;
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Closure, Config, Rule, WorkerId};
use ltbw::simulate::{Distribution, MeshError, Network, Options, RandomMigrations, simulate_mesh};
use ltbw::{BuildError, Mesh, PointSet};
use ltbw_generate::Random;
use ltbw_tests::cases;
use ltbw_tests::cgal::Cgal;
use ltbw_tests::compare::{compare_mesh, refusal};
use ltbw_tests::families::snapped;
use ltbw_tests::interleave::{Case, Chooser, Figures, Refusal, Tempo};

fn case(random: &mut Random) -> Case {
    let mut below = |n: u64| random.below(n) as usize;
    let workers = 2 + below(7);
    let ownership = match below(5) {
        0 => Ownership::Creator,
        1 | 2 => Ownership::Newest,
        _ => Ownership::Block,
    };
    Case {
        layout: Layout {
            workers: workers as u32,
            blocks_per_worker: 1 + below(4) as u32,
            cursors: 1 + below(4),
            max_in_flight: below(8),
            sample: 4 + below(8),
            ownership,
            ..Layout::new(0, 1)
        },
        closure: if below(4) == 0 { Closure::Vertex } else { Closure::Face },
        rule: [Rule::WoundWait, Rule::WoundWait, Rule::WoundWait, Rule::Paper][below(4)],
        tempo: Tempo::ALL[below(4)],
        slow: (below(4) == 0).then(|| below(workers as u64)),
        // Blocks move only where they own the tetrahedra.
        moves: if ownership == Ownership::Block { [0, 10, 40][below(3)] } else { 0 },
        cancel: None,
        bytes: false,
    }
}

/// The mesh in virtual time.
fn simulated(case: &Case, set: &PointSet, random: &mut Random) -> Result<Mesh, BuildError> {
    let latency = [0, 1_000, 100_000, 1_000_000_000][random.below(4) as usize];
    let distribution = Distribution::ALL[random.below(4) as usize];
    let options = Options {
        seed: random.bits(),
        network: Network { latency, distribution, ..Network::default() },
        slow: case.slow.map(|w| (WorkerId::at(w), 100.0)).into_iter().collect(),
        storm: (case.moves > 0).then_some(RandomMigrations { every: 20_000 + latency / 10 }),
        balance: Some(Balance::default()).filter(|_| case.layout.ownership == Ownership::Block),
        max_events: 1_000_000,
        ..Options::default()
    };
    let config =
        Config { rule: case.rule, closure: case.closure, ..Config::new(case.layout.workers) };
    match simulate_mesh(set, &case.layout, config, &options) {
        Ok(meshed) => Ok(meshed.gathered.mesh),
        Err(MeshError::Build(error)) => Err(error),
        Err(error) => panic!("{error}"),
    }
}

/// A random case and its set; what CGAL says of it is compared. `None`: the points are flat.
fn check(cgal: &mut Cgal, seed: u64) -> Option<Figures> {
    let mut random = Random::new(seed);
    let case = case(&mut random);
    let points = snapped(seed);
    let set = PointSet::new(points.clone()).expect("snapped points are finite");
    let outcome = if seed % 5 == 4 {
        simulated(&case, &set, &mut random).map(|mesh| (mesh, Figures::default()))
    } else {
        let played = case.play(&set, &mut Chooser::new(&[], seed));
        let played = played.map_err(|refusal| match refusal {
            Refusal::Build(error) => error,
            other => panic!("{other}"),
        });
        played.map(|played| (played.mesh, played.figures))
    };
    let reply = cgal.triangulate(&points).unwrap_or_else(|failure| panic!("{failure}"));
    let (same, figures) = match outcome {
        Ok((mesh, figures)) => (compare_mesh(&reply, &mesh), Some(figures)),
        Err(error) => (refusal(&reply, &error), None),
    };
    same.unwrap_or_else(|difference| panic!("{difference}: {case:?} {points:?}"));
    figures
}

#[test]
fn small_sets_on_any_workers_equal_cgal() {
    let Some(mut cgal) = Cgal::for_test("small_sets_on_any_workers_equal_cgal") else { return };
    let count = cases(300);
    let (mut meshes, mut total) = (0, Figures::default());
    for seed in 0..u64::from(count) {
        let checked = std::panic::AssertUnwindSafe(|| check(&mut cgal, seed));
        let found = std::panic::catch_unwind(checked)
            .unwrap_or_else(|_| panic!("seed {seed} fails (see above)"));
        let Some(figures) = found else { continue };
        meshes += 1;
        total.turns += figures.turns;
        total.setbacks += figures.setbacks;
        total.committed += figures.committed;
        total.moved += figures.moved;
    }
    println!("{count} sets, {meshes} with a mesh, all equal to CGAL: {total:?}");
    assert!(2 * meshes > count, "most sets are flat: {meshes} of {count} have a mesh");
    // Enough happened for the order to matter, in runs of some length.
    let busy = total.committed > meshes as usize && total.setbacks > 0 && total.moved > 0;
    assert!(busy || count < 100, "too tame to show anything: {total:?}");
}
