//! Bad tetrahedra refined on several workers at once, without rounds: a Delaunay mesh of its own
//! vertices that keeps the bounds, whatever the timing.

use ltbw::balance::Stock;
use ltbw::mesh::{LocalMesh, Ownership, Plan, WireVertex, gather};
use ltbw::protocol::{BlockId, Config, Correct, Item, Source, Worker};
use ltbw::refining::{BadTets, Bounds, RefineError, prepare, refine_on_threads, simulate_refined};
use ltbw::simulate::{Network, Options, SimulationError, Storm, simulate};
use ltbw::threads::Parallel;
use ltbw::topology::TetId;
use ltbw::{Builder, Mesh, Point, PointSet, invariants};
use ltbw_generate::{PointKind, generate};
use std::collections::HashMap;

/// The corners of the unit cube and points inside it.
fn cube(inside: usize) -> PointSet {
    let mut points: Vec<Point> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    points.extend(generate(PointKind::Uniform, inside, 1));
    PointSet::new(points).expect("finite points")
}

/// The mesh is the Delaunay mesh of its vertices, keeps the bounds, and has what was given.
fn check(set: &PointSet, bounds: &Bounds, mesh: &Mesh) {
    invariants::check_all(mesh).unwrap_or_else(|defect| panic!("{defect}"));
    let vertices: Vec<(u32, Point)> = mesh.vertices().collect();
    for (v, p) in &vertices {
        assert!(*v as usize >= set.len() || set.points()[*v as usize] == *p, "{v} has moved");
    }
    let points = vertices.iter().map(|&(_, p)| p).collect();
    let anew = Builder::new().build(&PointSet::new(points).expect("finite points")).expect("mesh");
    assert_eq!(mesh.hash().ok(), anew.mesh.hash().ok(), "no Delaunay mesh of its vertices");
    let most = vertices.iter().map(|&(v, _)| v as usize + 1).max().unwrap_or(0);
    let mut at = vec![[f64::NAN; 3]; most];
    vertices.iter().for_each(|&(v, p)| at[v as usize] = p);
    let bad = mesh.tets().filter(|tet| !bounds.keeps(tet.map(|v| at[v as usize]))).count();
    assert_eq!(bad, 0, "bad tetrahedra are left");
    // The independent checker, by numbers without gaps.
    let place: HashMap<u32, u32> = vertices.iter().map(|&(v, _)| v).zip(0..).collect();
    let tets: Vec<[u32; 4]> = mesh.tets().map(|tet| tet.map(|v| place[&v])).collect();
    let points: Vec<Point> = vertices.iter().map(|&(_, p)| p).collect();
    let options = ltbw_verify::Options { all_points: true, ..Default::default() };
    let report = ltbw_verify::check(&ltbw_verify::Mesh::new(&points, &tets), &options);
    assert!(report.passed(), "{:?}", report.defects);
}

/// The length of the shortest edge.
fn shortest_edge(mesh: &Mesh) -> f64 {
    let at: HashMap<u32, Point> = mesh.vertices().collect();
    let length =
        |a: u32, b: u32| (0..3).map(|k| (at[&a][k] - at[&b][k]).powi(2)).sum::<f64>().sqrt();
    let edges = mesh.tets().flat_map(|[a, b, c, d]| {
        [length(a, b), length(a, c), length(a, d), length(b, c), length(b, d), length(c, d)]
    });
    edges.fold(f64::INFINITY, f64::min)
}

/// A source that does not let go of a point whose tetrahedron is gone: a known-bad variant.
struct Stubborn(BadTets);

impl Source<LocalMesh> for Stubborn {
    const WATCHES: bool = true;

    fn next(&mut self, mesh: &LocalMesh) -> Option<WireVertex> {
        self.0.next(mesh)
    }

    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn item(&self, mesh: &LocalMesh, point: &WireVertex) -> Item<TetId> {
        match self.0.item(mesh, point) {
            Item::Gone => Item::Free,
            item => item,
        }
    }

    fn created(&mut self, mesh: &LocalMesh, tets: &[TetId]) {
        self.0.created(mesh, tets);
    }

    fn let_go(&mut self, point: &WireVertex) {
        self.0.let_go(point);
    }

    fn inserted(&mut self, mesh: &LocalMesh, point: &WireVertex) {
        self.0.inserted(mesh, point);
    }

    fn take_block(&mut self, mesh: &LocalMesh, block: BlockId) -> Vec<WireVertex> {
        self.0.take_block(mesh, block)
    }

    fn give(&mut self, block: BlockId, points: Vec<WireVertex>) {
        self.0.give(block, points);
    }

    fn clear(&mut self) {
        self.0.clear();
    }
}

impl Stock for Stubborn {
    fn left(&self) -> u64 {
        self.0.left()
    }

    fn in_block(&self, block: BlockId) -> u64 {
        self.0.in_block(block)
    }
}

/// No edge is shorter than the shortest one given, or than the radius of a sphere with a
/// tetrahedron that is too large. With the known-bad source some are.
#[test]
fn a_point_is_inserted_only_while_its_tetrahedron_stands() {
    const VOLUME: f64 = 1e-4;
    let set = cube(60);
    let bounds = Bounds::new(&set, VOLUME, 2.0).expect("bounds");
    let given = shortest_edge(&Builder::new().build(&set).expect("a mesh").mesh);
    // The largest tetrahedron in a sphere is the regular one.
    let radius = (VOLUME * 27.0 / (8.0 * 3f64.sqrt())).cbrt();
    let least = 0.99 * given.min(radius);
    let plan = Plan { ownership: Ownership::Newest, ..Plan::new(set.len(), 12) };
    let config = Config { window: 32, ..Config::new(12) };
    let network = Network { latency: 300_000, ..Network::default() };
    let options = Options { network, max_events: 5_000_000, ..Options::default() };
    let prepared = || prepare::<Correct>(&set, bounds, &plan, config).expect("a start");

    let (workers, common) = prepared();
    let run = simulate(workers, &options).expect("a run ends");
    let meshes = run.workers.into_iter().map(|worker| worker.into_parts().0).collect();
    let sound = gather(meshes, common).expect("a mesh").mesh;
    check(&set, &bounds, &sound);
    let shortest = shortest_edge(&sound);
    assert!(shortest >= least, "{shortest}; {least} at least");
    let (workers, common) = prepared();
    let stubborn = |worker: Worker<LocalMesh, BadTets, Correct>| {
        let (mesh, source, directory) = worker.into_parts();
        Worker::<_, _, Correct>::new(config, directory, mesh, Stubborn(source))
    };
    let options = Options { max_events: 4 * run.events, ..options };
    match simulate(workers.into_iter().map(stubborn).collect(), &options) {
        // Edges get shorter and shorter.
        Err(error) => assert!(matches!(error, SimulationError::TooManyEvents { .. }), "{error}"),
        Ok(run) => {
            let meshes = run.workers.into_iter().map(|worker| worker.into_parts().0).collect();
            let broken = gather(meshes, common).expect("a mesh").mesh;
            let shortest = shortest_edge(&broken);
            assert!(shortest < least, "{shortest} although {least} was to be kept");
        }
    }
}

#[test]
fn simulated_processors_refine_a_cube() {
    let set = cube(400);
    let bounds = Bounds::new(&set, 1e-4, 2.0).expect("bounds");
    let slow = Network { latency: 100_000, ..Network::default() };
    for (workers, ownership) in [
        (1, Ownership::Block),
        (2, Ownership::Newest),
        (5, Ownership::Block),
        (8, Ownership::Creator),
        (16, Ownership::Newest),
    ] {
        let plan = Plan { ownership, ..Plan::new(set.len(), workers) };
        let options = Options { network: slow, check_every: 997, ..Options::default() };
        let config = Config { window: 16, ..Config::new(workers) };
        let run = simulate_refined::<Correct>(&set, bounds, &plan, config, &options);
        let run = run.expect("a run ends");
        check(&set, &bounds, &run.gathered.mesh);
        let made = run.gathered.mesh.num_vertices() - set.len();
        assert!(made > 1000, "{workers} {ownership:?}: {made} points");
    }
}

/// Blocks take their bad tetrahedra along.
#[test]
fn blocks_move_while_they_are_refined() {
    let set = cube(300);
    let bounds = Bounds::new(&set, 2e-4, 2.0).expect("bounds");
    let plan = Plan::new(set.len(), 6);
    for seed in 0..4 {
        let storm = Some(Storm { every: 10_000 });
        let options = Options { seed, storm, check_every: 499, ..Options::default() };
        let run = simulate_refined::<Correct>(&set, bounds, &plan, Config::new(6), &options);
        let run = run.expect("a run ends");
        check(&set, &bounds, &run.gathered.mesh);
        let moved: u64 = run.summary.workers.iter().map(|w| w.migrations).sum();
        assert!(moved > 10, "{moved} moves");
    }
}

#[test]
fn threads_refine_a_cube() {
    let set = cube(1000);
    let bounds = Bounds::new(&set, 3e-5, 1.8).expect("bounds");
    for workers in [1, 2, 3, 8] {
        let run = refine_on_threads(&set, bounds, &Parallel::new(workers)).expect("a run ends");
        check(&set, &bounds, &run.mesh);
        let operations: u64 = run.workers.iter().map(|w| w.interface).sum();
        assert!((operations > 0) == (workers > 1), "{workers}: {operations} operations");
    }
}

/// The least that there is: the corners alone.
#[test]
fn eight_corners_are_enough() {
    let set = cube(0);
    let bounds = Bounds::new(&set, 1e-3, 2.0).expect("bounds");
    let run = refine_on_threads(&set, bounds, &Parallel::new(4)).expect("a run ends");
    check(&set, &bounds, &run.mesh);
    // One in the middle; the centres of all others lie on the faces.
    assert_eq!(run.mesh.num_vertices(), 9);
}

#[test]
fn bounds_that_cannot_be_kept_are_refused() {
    let set = cube(0);
    for (volume, ratio) in [(0.0, 2.0), (f64::NAN, 2.0), (1.0, 1.0), (1.0, f64::NAN)] {
        let refused = Bounds::new(&set, volume, ratio);
        assert!(matches!(refused, Err(RefineError::Bounds { .. })), "{volume} {ratio}");
    }
    let far = PointSet::new(cube(0).points().iter().map(|p| p.map(|c| c + 1e9)).collect());
    let refused = Bounds::new(&far.expect("finite points"), 1.0, 2.0);
    assert!(matches!(refused, Err(RefineError::Range)), "{refused:?}");
}
