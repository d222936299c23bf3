//! The kernel against its invariants, without an outside reference (CGAL's is in `tests/`).

use ltbw_core::invariants::check_all;
use ltbw_core::topology::TetId;
use ltbw_core::{
    Budget, BuildError, Builder, CancelToken, Duplicate, InsertError, Inserted, Mesh, Observer,
    Order, Outcome, Phase, Progress, Role,
};
use ltbw_exact::{Point, PointError, PointSet};
use ltbw_generate::{PointKind, generate};
use std::sync::atomic::{AtomicU64, Ordering};

fn set(points: Vec<Point>) -> PointSet {
    PointSet::new(points).expect("finite points")
}

fn build(points: Vec<Point>) -> Mesh {
    Builder::new().build(&set(points)).expect("points in general position").mesh
}

fn grid(k: u32) -> Vec<Point> {
    let each = |f: &dyn Fn(u32) -> u32| (0..k * k * k).map(|i| f64::from(f(i))).collect::<Vec<_>>();
    let (x, y, z) = (each(&|i| i % k), each(&|i| i / k % k), each(&|i| i / k / k));
    (0..x.len()).map(|i| [x[i], y[i], z[i]]).collect()
}

/// A fixed pseudo-random sequence.
fn random(seed: u64) -> impl FnMut(usize) -> usize {
    let mut s = seed | 1;
    move |bound| {
        s ^= s << 13;
        s ^= s >> 7;
        s ^= s << 17;
        (s >> 20) as usize % bound
    }
}

#[test]
fn invariants_hold_on_every_kind() {
    for kind in PointKind::ALL {
        let mesh = build(generate(kind, 700, 7));
        check_all(&mesh).unwrap_or_else(|e| panic!("{kind:?}: {e}"));
        let vertices = mesh.vertices().count();
        assert_eq!(vertices, mesh.num_vertices());
        // Euler's formula of a triangulated ball: V - E + F - T = 1, with 4 T + H = 2 F; the
        // hull is a sphere, H = 2 (its vertices) - 4.
        let faces = mesh.faces().count();
        assert_eq!(4 * mesh.num_tets() + mesh.num_hull_faces(), 2 * faces, "{kind:?}");
        assert_eq!(mesh.tets().count(), mesh.num_tets());
        assert_eq!(mesh.hull_facets().count(), mesh.num_hull_faces());
    }
}

/// Nearly flat tetrahedra on nearly cocircular points: determinant and numerator of the
/// circumcentre are rounding noise, so the computed radius may be far too small. A guard against
/// flatness that trusts it caches a wrong sphere.
#[test]
fn rounding_noise_is_never_cached_as_a_sphere() {
    for seed in 1..4 {
        let mesh = build(generate(PointKind::Ulps, 8000, seed));
        check_all(&mesh).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    }
}

/// The frame of the cached spheres is the box of the first points.
#[test]
fn points_far_outside_the_first_box_are_inserted_exactly() {
    let mut mesh = build(grid(3));
    let mut next = random(4);
    for scale in [1.5, 3.0, 6.0, 12.0, 100.0, 1e6] {
        for _ in 0..60 {
            let p = [0, 1, 2].map(|_| (next(1 << 16) as f64 / 65536.0 - 0.5) * scale + 1.0);
            mesh.insert(p).expect("a finite point");
            let near = p.map(|c| c + (next(1 << 10) as f64 - 512.0) * 1e-4);
            mesh.insert(near).expect("a finite point");
        }
        check_all(&mesh).unwrap_or_else(|e| panic!("scale {scale}: {e}"));
    }
}

#[test]
fn adjacency_agrees_with_shared_vertices() {
    let mesh = build(generate(PointKind::Uniform, 300, 3));
    let mut hull = 0;
    for t in mesh.tet_ids() {
        let v = mesh.tet(t).expect("a finite tetrahedron");
        for slot in 0..4 {
            let Some(u) = mesh.neighbour(t, slot) else {
                hull += 1;
                continue;
            };
            let w = mesh.tet(u).expect("a finite neighbour");
            let common = v.iter().enumerate().filter(|&(i, x)| i != slot && w.contains(x)).count();
            assert_eq!(common, 3);
            assert!(!w.contains(&v[slot]));
        }
    }
    assert_eq!(hull, mesh.num_hull_faces());
    assert_eq!(mesh.tet(TetId::new(u32::MAX)), None);
    assert_eq!(mesh.neighbour(TetId::new(u32::MAX), 0), None);
    assert_eq!(mesh.neighbour(mesh.tet_ids().next().expect("a tetrahedron"), 4), None);
}

/// Everything of a mesh that an insertion could change, to the bit.
type Fingerprint = (ltbw_core::topology::Topology, Vec<(u32, [u64; 3])>, Vec<[u32; 4]>);

fn fingerprint(mesh: &Mesh) -> Fingerprint {
    let vertices = mesh.vertices().map(|(v, p)| (v, p.map(f64::to_bits))).collect();
    (mesh.topology().clone(), vertices, mesh.spheres_fingerprint())
}

#[test]
fn a_refused_insertion_leaves_no_trace_whichever_tetrahedron_is_refused() {
    let mut choose = random(99);
    let sets = [
        generate(PointKind::Uniform, 120, 1),
        grid(5),
        generate(PointKind::Cospherical, 120, 2),
        generate(PointKind::Duplicates, 120, 3),
    ];
    let (mut refusals, mut insertions, mut ring_refusals) = (0, 0, 0);
    for points in sets {
        let mut reference = build(points[..60].to_vec());
        let mut mesh = build(points[..60].to_vec());
        for _ in 0..80 {
            let p = points[choose(points.len())];
            for k in 0.. {
                let before = fingerprint(&mesh);
                let mut asked = 0;
                let mut role = Role::Cavity;
                let result = mesh.insert_with(p, &mut |_, r| {
                    asked += 1;
                    role = r;
                    asked <= k
                });
                match result {
                    Err(InsertError::Refused { .. }) => {
                        assert_eq!(asked, k + 1, "asked again after the refusal");
                        assert!(fingerprint(&mesh) == before, "refusal {k} left a trace");
                        refusals += 1;
                        ring_refusals += usize::from(role == Role::Ring);
                    }
                    Ok(inserted) => {
                        assert_eq!(reference.insert(p), Ok(inserted));
                        insertions += usize::from(matches!(inserted, Inserted::Vertex(_)));
                        break;
                    }
                    Err(e) => panic!("{e}"),
                }
            }
        }
        check_all(&mesh).expect("invariants");
        assert_eq!(mesh.hash(), reference.hash());
        assert!(fingerprint(&mesh) == fingerprint(&reference), "refusals changed the mesh");
    }
    assert!(
        refusals > 2000 && ring_refusals > 500 && insertions > 60,
        "{refusals} refusals, {ring_refusals} of the ring, {insertions} insertions"
    );
}

#[test]
fn an_admission_that_panics_leaves_no_trace() {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    let points = generate(PointKind::Uniform, 300, 5);
    let mut mesh = build(points.clone());
    for k in 0..40 {
        for p in [[0.3, 0.4, 0.5], [1e300, 1e-300, 0.5]] {
            let before = fingerprint(&mesh);
            let mut asked = 0;
            let panicked = catch_unwind(AssertUnwindSafe(|| {
                mesh.insert_with(p, &mut |_, _| {
                    asked += 1;
                    assert!(asked <= k, "the admission's own panic");
                    asked < 12
                })
            }));
            let own = panicked.as_ref().err().and_then(|e| e.downcast_ref::<&str>().copied());
            assert!(panicked.is_ok() || own.is_some_and(|own| own.contains("own panic")));
            assert!(panicked.is_err() || k >= 12);
            assert!(fingerprint(&mesh) == before, "panic {k} left a trace");
        }
    }
    let mut all = points;
    for p in generate(PointKind::Uniform, 50, 6) {
        mesh.insert(p).expect("a finite point");
        all.push(p);
    }
    check_all(&mesh).expect("invariants");
    assert_eq!(mesh.hash(), build(all).hash());
}

#[test]
fn a_refused_point_outside_the_window_does_not_widen_the_mesh() {
    let mut mesh = build(generate(PointKind::Uniform, 50, 1));
    let (before, mode) = (fingerprint(&mesh), mesh.mode());
    let p = [1e300, 1e-300, 0.5];
    let refused = mesh.insert_with(p, &mut |_, _| false);
    assert!(matches!(refused, Err(InsertError::Refused { .. })));
    assert!(fingerprint(&mesh) == before && mesh.mode() == mode);
    assert_eq!(mesh.insert(p), Ok(Inserted::Vertex(50)));
    assert_ne!(mesh.mode(), mode);
    check_all(&mesh).expect("invariants");
}

#[test]
fn any_order_gives_the_same_mesh() {
    let mut choose = random(5);
    for points in [grid(4), generate(PointKind::Cylinder, 80, 1), generate(PointKind::Ulps, 64, 4)]
    {
        let expected = build(points.clone()).hash().expect("a hash");
        for _ in 0..20 {
            let mut shuffled = points.clone();
            for i in (1..shuffled.len()).rev() {
                shuffled.swap(i, choose(i + 1));
            }
            let built = Builder::new().order(Order::Input).build(&set(shuffled)).expect("a mesh");
            check_all(&built.mesh).expect("invariants");
            assert_eq!(built.mesh.hash(), Ok(expected));
        }
    }
}

#[test]
fn a_cavity_of_thousands_is_filled() {
    // The hull of cospherical points; then points near the centre see nearly all of them.
    let points = generate(PointKind::Sphere, 3000, 1);
    let mut mesh = build(points.clone());
    let before = mesh.num_tets();
    for p in [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, -0.02, 0.001]] {
        assert!(matches!(mesh.insert(p), Ok(Inserted::Vertex(_))));
        check_all(&mesh).expect("invariants");
    }
    assert_ne!(before, mesh.num_tets());
    let mut all = points;
    all.extend([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, -0.02, 0.001]]);
    assert_eq!(mesh.hash(), build(all).hash());
}

#[test]
fn duplicates_keep_the_smallest_index() {
    let mut points = grid(3);
    let n = points.len() as u32;
    points.extend(grid(3));
    points.push([-0.0, 0.0, -0.0]);
    points.push([5.0, 5.0, 5.0]);
    for order in [Order::Brio, Order::Input] {
        let built = Builder::new().order(order).build(&set(points.clone())).expect("a mesh");
        let mut expected: Vec<Duplicate> =
            (0..n).map(|i| Duplicate { number: n + i, kept: i }).collect();
        expected.push(Duplicate { number: 2 * n, kept: 0 });
        assert_eq!(built.duplicates, expected);
        assert_eq!(built.mesh.num_vertices(), n as usize + 1);
        let mesh = built.mesh.to_tet_mesh();
        assert_eq!(mesh.points.len(), points.len());
        assert!(mesh.tets.iter().flatten().all(|&v| v < n || v == 2 * n + 1));
    }
    // Reversed, so that the larger indices come first in the insertion order.
    let mut mesh = build(points.clone());
    assert_eq!(mesh.insert([1.0, -0.0, 0.0]), Ok(Inserted::Duplicate(1)));
    assert_eq!(mesh.insert([0.5, 0.25, 0.125]), Ok(Inserted::Vertex(2 * n + 2)));
}

#[test]
fn degenerate_input_names_its_dimension() {
    let error = |points| Builder::new().build(&set(points)).expect_err("no mesh");
    assert_eq!(error(vec![]), BuildError::TooFewPoints { distinct: 0 });
    assert_eq!(error(vec![[1.0; 3]; 9]), BuildError::TooFewPoints { distinct: 1 });
    assert_eq!(error(grid(3)[..3].to_vec()), BuildError::TooFewPoints { distinct: 3 });
    let line = (0..7).map(|i| [f64::from(i), f64::from(2 * i), 0.1]).collect();
    assert_eq!(error(line), BuildError::Collinear { distinct: 7 });
    assert_eq!(error(grid(5)[..25].to_vec()), BuildError::Coplanar { distinct: 25 });
    let nan = PointSet::new(vec![[0.0; 3], [0.0, f64::NAN, 0.0]]);
    assert!(matches!(nan, Err(PointError::NotFinite { index: 1, axis: 'y', .. })), "{nan:?}");
    // A single point off the plane, the last one, is enough.
    let mut points = grid(5)[..25].to_vec();
    points.push([2.0, 2.0, f64::MIN_POSITIVE]);
    check_all(&build(points)).expect("invariants");
}

#[test]
fn a_refused_point_leaves_the_mesh() {
    let mut mesh = build(grid(3));
    let before = fingerprint(&mesh);
    for p in [[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0], [0.0, 0.0, f64::NEG_INFINITY]] {
        assert!(matches!(mesh.insert(p), Err(InsertError::Point(PointError::NotFinite { .. }))));
    }
    assert!(fingerprint(&mesh) == before);
}

#[test]
fn points_outside_the_window_are_inserted_exactly() {
    for scale in [1.0, 2f64.powi(-120), 2f64.powi(190), 2f64.powi(-700)] {
        let points: Vec<Point> = grid(4).iter().map(|p| p.map(|c| c * scale)).collect();
        let far = [[1e300, -1e-300, 3.0], [5e-324, 1.0, -1e250], [-1e308, 1e308, 1e308]];
        let mut mesh = build(points.clone());
        for (k, &p) in far.iter().enumerate() {
            assert_eq!(mesh.insert(p), Ok(Inserted::Vertex((points.len() + k) as u32)));
            check_all(&mesh).expect("invariants");
        }
        let mut all = points;
        all.extend(far);
        assert_eq!(mesh.hash(), build(all).hash());
    }
}

#[derive(Default)]
struct Count {
    calls: AtomicU64,
    last: AtomicU64,
    stop_after: u64,
    token: CancelToken,
}

impl Observer for Count {
    fn progress(&self, progress: Progress) {
        let Progress { phase, done, total } = progress;
        assert_eq!(phase, Phase::Insert);
        let last = self.last.swap(done, Ordering::Relaxed);
        assert!(last <= done && total.is_some_and(|total| done <= total));
        if self.calls.fetch_add(1, Ordering::Relaxed) + 1 == self.stop_after {
            self.token.cancel();
        }
    }
}

#[test]
fn cancel_and_budget_leave_a_valid_mesh_so_far() {
    let points = set(generate(PointKind::Uniform, 20_000, 1));
    let watch = Count { stop_after: 3, ..Count::default() };
    let built =
        Builder::new().observer(&watch).cancel(&watch.token).build(&points).expect("a mesh");
    assert_eq!(built.outcome, Outcome::Cancelled);
    assert_eq!(built.mesh.num_vertices(), 3 * 1024);
    check_all(&built.mesh).expect("invariants");

    let budget = Budget { max_points: Some(500), ..Budget::default() };
    let built = Builder::new().budget(budget).build(&points).expect("a mesh");
    assert_eq!((built.outcome, built.mesh.num_vertices()), (Outcome::Budget, 500));
    check_all(&built.mesh).expect("invariants");

    let budget = Budget { max_tets: Some(10_000), ..Budget::default() };
    let built = Builder::new().budget(budget).build(&points).expect("a mesh");
    assert_eq!(built.outcome, Outcome::Budget);
    assert!((10_000..20_000).contains(&built.mesh.num_tets()), "{}", built.mesh.num_tets());

    let watch = Count::default();
    let built = Builder::new().observer(&watch).build(&points).expect("a mesh");
    assert_eq!(built.outcome, Outcome::Complete);
    assert_eq!(watch.last.load(Ordering::Relaxed), 20_000);

    let token = CancelToken::new();
    token.cancel();
    let cancelled = Builder::new().cancel(&token).build(&points);
    assert_eq!(cancelled.map(|_| ()).expect_err("cancelled"), BuildError::Cancelled);
}

#[test]
fn filters_and_cached_spheres_decide_nearly_everything_on_uniform_points() {
    // A stage that always falls through would be slow but right: only counting shows it.
    let stats = build(generate(PointKind::Uniform, 20_000, 9)).predicate_stats();
    assert_eq!(stats.insphere_exact, 0, "{stats:?}");
    assert_eq!(stats.orient3d_exact, 0, "{stats:?}");
    assert!(stats.sphere_undecided * 20 < stats.insphere_calls, "{stats:?}");
    assert!(stats.insphere_calls < 60 * 20_000, "{stats:?}");
    assert!(stats.orient3d_calls < 20 * 20_000, "{stats:?}");
}
