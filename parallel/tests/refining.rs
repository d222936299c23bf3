//! Bad tetrahedra refined on several workers at once, without rounds: a Delaunay mesh of its own
//! vertices that keeps the bounds, whatever the timing.

use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Config, Correct};
use ltbw::quality::Quality;
use ltbw::refining::{Bounds, RefineError, refine_on_threads, simulate_refined};
use ltbw::simulate::{Network, Options, RandomMigrations};
use ltbw::threads::Parallel;
use ltbw::{BuildError, Builder, CancelToken, Mesh, Outcome, Point, PointSet, invariants};
use ltbw_generate::{PointKind, generate};
use std::collections::HashMap;
use std::time::Duration;

/// The corners of the unit cube and points inside it.
fn cube(inside: usize) -> PointSet {
    let mut points: Vec<Point> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    points.extend(generate(PointKind::Uniform, inside, 1));
    PointSet::new(points).expect("finite points")
}

/// The bounds that are asked for: the largest volume, the largest circumradius to shortest edge.
type Asked = (f64, f64);

fn bounds_of(set: &PointSet, (volume, ratio): Asked) -> Bounds {
    Bounds::new(set, volume, ratio).expect("bounds")
}

/// Is a tetrahedron over the bounds, and has its circumcentre inside the unit cube? By formulas
/// that are not the refiner's: the centre by Cramer's rule, the radius from there to the corners.
/// What is over them by a millionth, or as near to the box, may be either.
fn is_bad(corners: [Point; 4], (volume, ratio): Asked) -> bool {
    let [a, b, c, d] = corners;
    let determinant = |m: [Point; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let rows = [b, c, d].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
    let whole = determinant(rows);
    let sides = rows.map(|row| row.iter().map(|x| x * x).sum::<f64>() / 2.0);
    let centre = [0, 1, 2].map(|k| {
        let mut replaced = rows;
        replaced.iter_mut().zip(sides).for_each(|(row, side)| row[k] = side);
        a[k] + determinant(replaced) / whole
    });
    let distance = |p: &Point, q: &Point| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
    let radius = corners.iter().map(|p| distance(p, &centre)).fold(0.0, f64::max);
    let pairs = [(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)];
    let shortest = pairs.iter().map(|(p, q)| distance(p, q)).fold(f64::INFINITY, f64::min);
    let more = 1.0 + 1e-6;
    let is_over = whole.abs() / 6.0 > volume * more || radius > ratio * shortest * more;
    // Flat ones have no centre that a number could tell.
    is_over && whole.abs() > 1e-12 && centre.iter().all(|&c| 1e-6 < c && c < 1.0 - 1e-6)
}

#[test]
fn bad_tetrahedra_are_told_from_good_ones() {
    let corner = |s: f64| [[0.0; 3], [s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s]];
    // Volume s³/6, radius s √3/2, shortest edge s, centre in the middle of the cube of side s.
    let (volume, ratio) = (0.5f64.powi(3) / 6.0, 0.75f64.sqrt());
    assert!(!is_bad(corner(0.5), (volume, ratio)));
    assert!(is_bad(corner(0.5), (0.999 * volume, ratio)));
    assert!(is_bad(corner(0.5), (volume, 0.999 * ratio)));
    let outside = corner(0.5).map(|p| p.map(|c| c - 0.25));
    assert!(!is_bad(outside, (0.999 * volume, ratio)), "its centre is on the face of the cube");
}

/// The mesh is the Delaunay mesh of its vertices, keeps the bounds, and has what was given.
fn check(set: &PointSet, asked: Asked, mesh: &Mesh) {
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
    let bad = mesh.tets().filter(|tet| is_bad(tet.map(|v| at[v as usize]), asked)).count();
    assert_eq!(bad, 0, "bad tetrahedra are left");
    // The independent checker, by numbers without gaps.
    let place: HashMap<u32, u32> = vertices.iter().map(|&(v, _)| v).zip(0..).collect();
    let tets: Vec<[u32; 4]> = mesh.tets().map(|tet| tet.map(|v| place[&v])).collect();
    let points: Vec<Point> = vertices.iter().map(|&(_, p)| p).collect();
    let options = ltbw_verify::Options { all_points: true, ..Default::default() };
    let report = ltbw_verify::check(&ltbw_verify::Mesh::new(&points, &tets), &options);
    assert!(report.passed(), "{:?}", report.defects);
}

#[test]
fn simulated_processors_refine_a_cube() {
    let set = cube(400);
    let asked = (1e-4, 2.0);
    let bounds = bounds_of(&set, asked);
    let slow = Network { latency: 100_000, ..Network::default() };
    for (workers, ownership) in [
        (1, Ownership::Block),
        (2, Ownership::Newest),
        (5, Ownership::Block),
        (8, Ownership::Creator),
        (16, Ownership::Newest),
    ] {
        let layout = Layout { ownership, ..Layout::new(set.len(), workers) };
        let options = Options { network: slow, check_every: 997, ..Options::default() };
        let config = Config { window: 16, ..Config::new(workers) };
        let run = simulate_refined::<Correct>(&set, bounds, &layout, config, &options);
        let run = run.expect("a run ends");
        check(&set, asked, &run.gathered.mesh);
        let made = run.gathered.mesh.num_vertices() - set.len();
        assert!(made > 1000, "{workers} {ownership:?}: {made} points");
    }
}

/// The paper's Figure 6: the histogram of dihedral angles of a mesh that many processors have
/// refined, over that of a sequential one. Where there are a hundredth of all angles or more the
/// quotient is near 1.
#[test]
fn many_processors_make_tetrahedra_as_good_as_one_does() {
    let set = cube(400);
    let bounds = bounds_of(&set, (3e-5, 2.0));
    let slow = Network { latency: 100_000, ..Network::default() };
    let shares = |workers: u32| -> Vec<f64> {
        let layout = Layout { ownership: Ownership::Newest, ..Layout::new(set.len(), workers) };
        let options = Options { network: slow, ..Options::default() };
        let config = Config { window: 16, ..Config::new(workers) };
        let run = simulate_refined::<Correct>(&set, bounds, &layout, config, &options);
        let mesh = run.expect("a run ends").gathered.mesh;
        let place: HashMap<u32, u32> = mesh.vertices().map(|(v, _)| v).zip(0..).collect();
        let tets: Vec<[u32; 4]> = mesh.tets().map(|tet| tet.map(|v| place[&v])).collect();
        let points: Vec<Point> = mesh.vertices().map(|(_, p)| p).collect();
        let quality = Quality::of(&points, &tets).expect("tetrahedra");
        let all = quality.dihedral.counts.iter().sum::<u64>() as f64;
        quality.dihedral.counts.iter().map(|&count| count as f64 / all).collect()
    };
    let one = shares(1);
    for workers in [4, 16] {
        let quotients = shares(workers).into_iter().zip(&one).enumerate();
        let quotients = quotients.filter(|(_, (_, own))| **own >= 0.01).map(|(k, (many, own))| {
            println!("{workers} processors, {:>3} degrees: {:.3}", 5 * k, many / own);
            many / own
        });
        let quotients: Vec<f64> = quotients.collect();
        assert!(quotients.len() > 15, "{quotients:?}");
        assert!(quotients.iter().all(|q| (0.8..1.25).contains(q)), "{workers}: {quotients:?}");
    }
}

/// Blocks take their bad tetrahedra along.
#[test]
fn blocks_move_while_they_are_refined() {
    let set = cube(300);
    let asked = (2e-4, 2.0);
    let bounds = bounds_of(&set, asked);
    let layout = Layout::new(set.len(), 6);
    for seed in 0..4 {
        let storm = Some(RandomMigrations { every: 10_000 });
        let options = Options { seed, storm, check_every: 499, ..Options::default() };
        let run = simulate_refined::<Correct>(&set, bounds, &layout, Config::new(6), &options);
        let run = run.expect("a run ends");
        check(&set, asked, &run.gathered.mesh);
        let moved: u64 = run.summary.workers.iter().map(|w| w.migrations).sum();
        assert!(moved > 10, "{moved} moves");
    }
}

#[test]
fn threads_refine_a_cube() {
    let set = cube(1000);
    let asked = (3e-5, 1.8);
    let bounds = bounds_of(&set, asked);
    for workers in [1, 2, 3, 8] {
        let run = refine_on_threads(&set, bounds, &Parallel::new(workers)).expect("a run ends");
        check(&set, asked, &run.mesh);
        let operations: u64 = run.workers.iter().map(|w| w.interface).sum();
        assert!((operations > 0) == (workers > 1), "{workers}: {operations} operations");
    }
}

/// The start of many points takes far longer than it takes to cancel it.
#[test]
fn a_run_is_cancelled_while_it_is_prepared_or_later() {
    let set = cube(60_000);
    let bounds = bounds_of(&set, (1e-6, 2.0));
    let token = CancelToken::default();
    token.cancel();
    let start =
        |token: &CancelToken| refine_on_threads(&set, bounds, &Parallel::new(2).cancel(token));
    let cancelled = RefineError::Build(BuildError::Cancelled);
    assert_eq!(start(&token).err(), Some(cancelled.clone()));
    let mut early = 0;
    for millis in [5, 10, 20, 40, 80, 160] {
        let token = CancelToken::default();
        let run = std::thread::scope(|scope| {
            let token = &token;
            scope.spawn(move || {
                std::thread::sleep(Duration::from_millis(millis));
                token.cancel();
            });
            start(token)
        });
        match run {
            Ok(run) => assert_eq!(run.outcome, Outcome::Cancelled, "after {millis} ms"),
            Err(error) => {
                assert_eq!(error, cancelled, "after {millis} ms");
                early += 1;
            }
        }
    }
    assert!(early > 0, "no start was cancelled");
}

/// The least that there is: the corners alone.
#[test]
fn eight_corners_are_enough() {
    let set = cube(0);
    let asked = (1e-3, 2.0);
    let bounds = bounds_of(&set, asked);
    let run = refine_on_threads(&set, bounds, &Parallel::new(4)).expect("a run ends");
    check(&set, asked, &run.mesh);
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
