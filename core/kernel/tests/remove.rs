//! Vertices removed: the mesh is that of the points that are left.

use ltbw_core::invariants::check_all;
use ltbw_core::{
    Builder, Duplicate, Inserted, Mesh, MeshHash, Point, PointSet, Random, RemoveError, Vertex,
};
use ltbw_generate::{PointKind, generate};

fn build(points: &[Point]) -> Mesh {
    let set = PointSet::new(points.to_vec()).expect("finite points");
    Builder::new().build(&set).expect("a mesh").mesh
}

fn hash(mesh: &Mesh) -> MeshHash {
    mesh.hash().expect("a hash")
}

/// A family's points; fewer where a mesh has the square of them.
fn family(kind: PointKind, count: usize, seed: u64) -> Vec<Point> {
    let is_square = matches!(kind, PointKind::Lines | PointKind::Moment);
    generate(kind, if is_square { count.min(120) } else { count }, seed)
}

/// Removes each vertex and inserts its point again, compares with a mesh built without it now and
/// then.
fn each_comes_back(points: &[Point], often: usize) {
    let mut mesh = build(points);
    let before = hash(&mesh);
    let all: Vec<(Vertex, Point)> = mesh.vertices().collect();
    for (k, &(v, p)) in all.iter().enumerate() {
        mesh.remove(v).unwrap_or_else(|error| panic!("{p:?}: {error}"));
        if k % often == 0 {
            check_all(&mesh).unwrap_or_else(|error| panic!("without {p:?}: {error}"));
            let others: Vec<Point> = points.iter().copied().filter(|q| *q != p).collect();
            assert_eq!(hash(&mesh), hash(&build(&others)), "without {p:?}");
            assert_eq!(mesh.num_vertices(), all.len() - 1);
        }
        assert!(matches!(mesh.insert(p), Ok(Inserted::Vertex(_))), "{p:?}");
    }
    assert_eq!(hash(&mesh), before);
    check_all(&mesh).expect("invariants");
}

#[test]
fn each_vertex_of_every_kind_comes_back() {
    for kind in PointKind::ALL {
        each_comes_back(&family(kind, 300, 1), 20);
    }
}

#[test]
fn each_vertex_of_a_grid_comes_back() {
    each_comes_back(&generate(PointKind::Grid, 1000, 1), 200);
}

#[test]
fn each_vertex_of_a_sphere_comes_back() {
    each_comes_back(&generate(PointKind::Sphere, 2000, 2), 400);
    each_comes_back(&generate(PointKind::Cospherical, 700, 2), 100);
}

#[test]
#[ignore = "a minute in a release build: 20,000 points of each kind"]
fn each_of_twenty_thousand_comes_back() {
    for kind in PointKind::ALL {
        let is_square = matches!(kind, PointKind::Lines | PointKind::Moment);
        each_comes_back(&generate(kind, if is_square { 600 } else { 20_000 }, 3), 4000);
    }
}

/// A random half is removed: what is left is the mesh of the other half.
#[test]
fn what_is_left_is_the_mesh_of_what_is_left() {
    for kind in PointKind::ALL {
        // A place with several points is one vertex.
        let points = family(kind, 1000, 4);
        let mut mesh = build(&points);
        let mut all: Vec<(Vertex, Point)> = mesh.vertices().collect();
        all.sort_unstable_by_key(|v| v.0);
        Random::new(5).shuffle(&mut all);
        let (gone, left) = all.split_at(all.len() / 2);
        for &(v, p) in gone {
            mesh.remove(v).unwrap_or_else(|error| panic!("{kind:?} {p:?}: {error}"));
        }
        check_all(&mesh).unwrap_or_else(|error| panic!("{kind:?}: {error}"));
        let points: Vec<Point> = left.iter().map(|v| v.1).collect();
        assert_eq!(hash(&mesh), hash(&build(&points)), "{kind:?}");
        let mut numbers: Vec<Vertex> = mesh.vertices().map(|v| v.0).collect();
        numbers.sort_unstable();
        let mut expected: Vec<Vertex> = left.iter().map(|v| v.0).collect();
        expected.sort_unstable();
        assert_eq!(numbers, expected, "{kind:?}: others keep their numbers");
        for &(v, p) in &all {
            assert_eq!(mesh.point(v).is_some(), numbers.binary_search(&v).is_ok());
            assert!(mesh.point(v).is_none_or(|q| q == p));
        }
        // A mesh with gaps is stored and answers like any other.
        let restored = mesh.snapshot().expect("a hash").restore().expect("a sound snapshot");
        assert_eq!(hash(&restored), hash(&mesh), "{kind:?}");
        let (of_gaps, of_none) = (mesh.queries(), restored.queries());
        let (mut one, mut other) = (of_gaps.cursor(), of_none.cursor());
        let sorted = |edges: ltbw_core::query::Edges<'_, '_>| {
            let mut edges: Vec<[Vertex; 2]> = edges.collect();
            edges.sort_unstable();
            edges
        };
        assert_eq!(sorted(one.edges()), sorted(other.edges()), "{kind:?}");
        for &(v, p) in all.iter().step_by(7) {
            assert_eq!(one.nearest(p), other.nearest(p), "{kind:?} {p:?}");
            assert_eq!(one.neighbours(v), other.neighbours(v), "{kind:?} {p:?}");
        }
    }
}

/// A mesh is taken apart down to its last tetrahedron, in several orders, and built up again.
#[test]
fn a_mesh_is_taken_apart_and_comes_back() {
    let mut random = Random::new(6);
    for round in 0..40 {
        // Points of a small lattice: planes, lines and spheres have many.
        let mut points: Vec<Point> =
            (0..40).map(|_| [(); 3].map(|()| random.below(4) as f64)).collect();
        points.extend([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let mut mesh = build(&points);
        let before = hash(&mesh);
        let mut all: Vec<(Vertex, Point)> = mesh.vertices().collect();
        random.shuffle(&mut all);
        let mut gone = Vec::new();
        while let Some((v, p)) = all.pop() {
            let left: Vec<Point> = all.iter().map(|v| v.1).chain(gone.iter().copied()).collect();
            let set = PointSet::new(left.clone()).expect("points");
            match (mesh.remove(v), Builder::new().build(&set)) {
                (Ok(()), Ok(built)) => assert_eq!(hash(&mesh), hash(&built.mesh), "{left:?}"),
                (Err(RemoveError::Flat { vertex, left: count }), Err(_)) => {
                    assert_eq!((vertex, count), (v, left.len()));
                    gone.push(p);
                }
                (removed, built) => panic!("{round}: {removed:?}, {built:?}: {left:?}"),
            }
            check_all(&mesh).unwrap_or_else(|error| panic!("{error}: {left:?}"));
        }
        // The last four could not go.
        assert_eq!((mesh.num_vertices(), mesh.num_tets()), (4, 1));
        let slots = mesh.topology().slots();
        for &p in &points {
            mesh.insert(p).expect("a finite point");
        }
        assert_eq!(hash(&mesh), before);
        assert_eq!(mesh.topology().slots(), slots, "free slots are used again");
        check_all(&mesh).expect("invariants");
    }
}

#[test]
fn a_vertex_that_is_none_is_refused() {
    let mut mesh = build(&generate(PointKind::Uniform, 50, 1));
    let before = (mesh.topology().clone(), mesh.spheres_fingerprint());
    for vertex in [50, 1 << 20, Vertex::MAX] {
        assert_eq!(mesh.remove(vertex), Err(RemoveError::Unknown { vertex }));
    }
    assert!(before == (mesh.topology().clone(), mesh.spheres_fingerprint()));
    mesh.remove(7).expect("a vertex");
    assert_eq!(mesh.remove(7), Err(RemoveError::Unknown { vertex: 7 }));
    // Its number is not given again.
    assert_eq!(mesh.insert([0.5; 3]), Ok(Inserted::Vertex(50)));
    assert_eq!((mesh.point(7), mesh.point(50)), (None, Some([0.5; 3])));
    assert!(mesh.points()[7][0].is_nan() && mesh.points().len() == 51);
}

/// A removal that leaves no volume is refused, and leaves no trace.
#[test]
fn the_last_point_beside_a_plane_stays() {
    let plate = |k: u32| (0..k * k).map(move |i| [f64::from(i % k), f64::from(i / k), 0.0]);
    for k in [2, 5, 20] {
        let mut points: Vec<Point> = plate(k).collect();
        points.push([1.25, 1.5, 3.0]);
        let apex = k * k;
        let mut mesh = build(&points);
        let before = (mesh.topology().clone(), mesh.spheres_fingerprint(), mesh.num_vertices());
        let flat = RemoveError::Flat { vertex: apex, left: apex as usize };
        assert_eq!(mesh.remove(apex), Err(flat));
        let after = (mesh.topology().clone(), mesh.spheres_fingerprint(), mesh.num_vertices());
        assert!(before == after, "{k}: a trace");
        // With another one it may go; its link is flat but for that.
        for other in [[1.25, 1.5, -2.0], [1.0, 1.0, 4.0]] {
            let mut mesh = build(&points);
            mesh.insert(other).expect("a finite point");
            mesh.remove(apex).expect("there is volume without it");
            let points: Vec<Point> = plate(k).chain([other]).collect();
            assert_eq!(hash(&mesh), hash(&build(&points)), "{k} {other:?}");
            check_all(&mesh).expect("invariants");
        }
    }
}

/// A vertex that nearly all others see: its corners are meshed apart.
#[test]
fn a_hub_is_removed() {
    for kind in [PointKind::Sphere, PointKind::Cospherical, PointKind::Cylinder, PointKind::Planes]
    {
        let points = generate(kind, 800, 8);
        let (hub, far) = ([0.001, 0.002, 0.003], [1e5, -2e5, 3e4]);
        for extra in [vec![hub], vec![hub, far], vec![far]] {
            let mut mesh = build(&points);
            let before = hash(&mesh);
            let numbers: Vec<Vertex> = extra
                .iter()
                .map(|&p| match mesh.insert(p) {
                    Ok(Inserted::Vertex(v)) => v,
                    other => panic!("{other:?}"),
                })
                .collect();
            let stars: Vec<usize> = numbers
                .iter()
                .map(|&v| mesh.tets().filter(|tet| tet.contains(&v)).count())
                .collect();
            assert!(kind != PointKind::Sphere || stars[0] > 600, "{stars:?}");
            for v in numbers {
                mesh.remove(v).unwrap_or_else(|error| panic!("{kind:?}: {error}"));
                check_all(&mesh).unwrap_or_else(|error| panic!("{kind:?}: {error}"));
            }
            assert_eq!(hash(&mesh), before, "{kind:?}");
        }
    }
    // Their mesh is larger than it is worth: they are searched.
    let mut points = generate(PointKind::Moment, 300, 1);
    let last = points.pop().expect("a point");
    let mut mesh = build(&points);
    let before = hash(&mesh);
    assert_eq!(mesh.insert(last), Ok(Inserted::Vertex(299)));
    mesh.remove(299).expect("a vertex");
    assert_eq!(hash(&mesh), before);
}

#[test]
fn duplicates_go_with_their_vertex() {
    let mut points = generate(PointKind::Uniform, 30, 1);
    points.extend([points[4], points[9], points[4]]);
    let mut mesh = build(&points);
    let at = |number, kept| Duplicate { number, kept };
    assert_eq!(mesh.duplicates(), [at(30, 4), at(31, 9), at(32, 4)]);
    // The number of a duplicate stands for the vertex at its place.
    mesh.remove(32).expect("a duplicate");
    assert_eq!(mesh.duplicates(), [at(31, 9)]);
    for vertex in [4, 30, 32] {
        assert_eq!(mesh.remove(vertex), Err(RemoveError::Unknown { vertex }));
        assert_eq!(mesh.point(vertex), None);
    }
    assert_eq!(mesh.point(31), Some(points[9]));
    let others: Vec<Point> = points.iter().copied().filter(|p| *p != points[4]).collect();
    assert_eq!(hash(&mesh), hash(&build(&others)));
}

/// Coordinates of any size: in big integers, and scaled.
#[test]
fn vertices_of_any_size_are_removed() {
    let mut random = Random::new(9);
    for spread in [0, 100, 900] {
        let mut coordinate = || {
            let size = if spread == 0 { -500 } else { random.below(spread) as i32 - 400 };
            (random.below(5) as f64 - 2.0) * 2f64.powi(size)
        };
        let points: Vec<Point> = (0..90).map(|_| [(); 3].map(|()| coordinate())).collect();
        each_comes_back(&points, 9);
    }
    // A late point makes the mesh one of big integers.
    let points = generate(PointKind::Uniform, 60, 1);
    let mut mesh = build(&points);
    let before = hash(&mesh);
    for far in [[1e200, 0.0, 0.0], [1e-200, 0.5, -1e250]] {
        let Ok(Inserted::Vertex(v)) = mesh.insert(far) else { panic!("{far:?}") };
        mesh.remove(v).expect("a vertex");
        check_all(&mesh).expect("invariants");
        assert_eq!(hash(&mesh), before);
    }
}

/// Few numbers have a vertex: they are found by searching a list.
#[test]
fn vertices_with_far_numbers_are_removed() {
    let points = generate(PointKind::Uniform, 40, 1);
    let mut snapshot = build(&points).snapshot().expect("a hash");
    snapshot.vertices.iter_mut().for_each(|v| v.number *= 1000);
    snapshot.next = 40_000;
    let mut mesh = snapshot.restore_within(1 << 20).expect("a sound snapshot");
    mesh.remove(7000).expect("a vertex");
    assert_eq!(mesh.remove(7000), Err(RemoveError::Unknown { vertex: 7000 }));
    assert_eq!(mesh.insert(points[7]), Ok(Inserted::Vertex(40_000)));
    assert_eq!(mesh.point(40_000), Some(points[7]));
    assert_eq!(hash(&mesh), hash(&build(&points)));
}

/// Numbers without gaps, in the order before.
#[test]
fn what_is_left_is_numbered_anew() {
    let mut points = generate(PointKind::Uniform, 30, 1);
    points.extend([points[4], points[9], points[20]]);
    let mut mesh = build(&points);
    for v in [0, 9, 29] {
        mesh.remove(v).expect("a vertex");
    }
    let before = hash(&mesh);
    let left: Vec<Vertex> = (0..33).filter(|v| ![0, 9, 29, 31].contains(v)).collect();
    assert_eq!(mesh.renumber(), left);
    assert_eq!(hash(&mesh), before);
    let at = |number, kept| Duplicate { number, kept };
    assert_eq!(mesh.duplicates(), [at(27, 3), at(28, 18)]);
    for (now, &v) in (0..).zip(&left) {
        assert_eq!(mesh.point(now), Some(points[v as usize]));
    }
    assert_eq!(mesh.points().len(), left.len());
    assert_eq!(mesh.insert(points[0]), Ok(Inserted::Vertex(29)));
}
