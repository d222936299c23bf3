//! Good meshes pass, whatever their scale; any other set of tetrahedra does not; Qhull's grid.

use crate::common;

use crate::common::{IntPoint, Owned, delaunay, is_inside, kinds, parse, volume6};
use ltbw_verify::{Kind, Level, Mesh, Options, Outcome, Report, VertexOrder, check};
use proptest::prelude::*;

const ALL: Options = Options {
    depth: ltbw_verify::Depth::Full,
    vertex_order: VertexOrder::Oriented,
    all_points: true,
    max_defects: 10,
    numbered_regions: false,
};

fn report(mesh: &Owned) -> Report {
    check(&Mesh::new(&mesh.points, &mesh.tets), &ALL)
}

/// Points on two sides of a box, its corners among them: most hull facets have coplanar neighbours.
fn boxed(seed: u64) -> Vec<IntPoint> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mut below = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) % n
    };
    let mut points: Vec<IntPoint> = common::cube().iter().map(|p| p.map(|c| 6 * c)).collect();
    while points.len() < 13 {
        let p = [below(7), below(7), below(2) * 6].map(|c| c as i64);
        if !points.contains(&p) {
            points.push(p);
        }
    }
    points
}

/// A hull facet: its tetrahedron, and its corners.
type Facet = (usize, Vec<u32>);

/// The pairs of coplanar hull facets with a common edge of which the far corner of one is in the
/// circle of the other.
fn wrong_circles(points: &[IntPoint], tets: &[[u32; 4]]) -> usize {
    let at = |v: u32| points[v as usize];
    let neighbours = common::adjacency(tets);
    let sides = (0..tets.len()).flat_map(|t| (0..4).map(move |i| (t, i)));
    let hull: Vec<Facet> = sides
        .filter(|&(t, i)| neighbours[t][i] == u32::MAX)
        .map(|(t, i)| (t, (0..4).filter(|&k| k != i).map(|k| tets[t][k]).collect()))
        .collect();
    let far = |one: &[u32], other: &[u32]| {
        let mut apart = other.iter().copied().filter(|v| !one.contains(v));
        apart.next().filter(|_| apart.next().is_none())
    };
    let pairs = hull.iter().flat_map(|own| hull.iter().map(move |other| (own, other)));
    let is_wrong = |&((t, own), (_, other)): &(&Facet, &Facet)| {
        let [a, b, c, d] = tets[*t].map(at);
        let is_in = |q: u32| {
            volume6([at(own[0]), at(own[1]), at(own[2]), at(q)]) == 0
                && is_inside(&[a, b, c, d, at(q)])
        };
        far(own, other).is_some_and(is_in)
    };
    // Each has the other one's far corner in its circle.
    pairs.filter(is_wrong).count() / 2
}

/// The circle test of coplanar hull facets changes no verdict: what it finds a face inside has,
/// too. (`hull.rs` has the proof.) The meshes are those of the points stretched: convex, with a
/// Delaunay mesh of other points.
#[test]
fn no_verdict_rests_on_the_circles_of_coplanar_hull_facets_alone() {
    let stretches = [[1, 1, 1], [1, 3, 1], [4, 1, 1], [1, 2, 5], [3, 1, 2], [1, 1, 6]];
    let options = Options { max_defects: usize::MAX, ..ALL };
    let (mut failed, mut wrong, mut passed) = (0, 0, 0);
    for seed in 0..120 {
        let points = boxed(seed);
        let stretch = stretches[seed as usize % stretches.len()];
        let stretched: Vec<IntPoint> =
            points.iter().map(|p| [0, 1, 2].map(|k| stretch[k] * p[k])).collect();
        let mut mesh = delaunay(&stretched);
        mesh.points = points.iter().map(|p| p.map(|c| c as f64)).collect();
        let r = check(&Mesh::new(&mesh.points, &mesh.tets), &options);
        // One of two tetrahedra inside has five vertices, one of two facets four.
        let is_circle =
            |d: &&ltbw_verify::Defect| d.kind == Kind::NotDelaunay && d.vertices.len() == 4;
        let circles = r.defects.iter().filter(is_circle).count();
        assert_eq!(r.passed(), r.defects.len() == circles, "seed {seed}: {:?}", kinds(&r));
        let own = wrong_circles(&points, &mesh.tets);
        assert!(own == 0 || r.defects.len() > circles, "seed {seed}: {own} circles");
        (failed, wrong) = (failed + usize::from(circles > 0 || own > 0), wrong + own);
        passed += usize::from(r.passed());
    }
    assert!(failed > 40 && wrong > 60 && passed > 20, "{failed}, {wrong}, {passed}");
}

#[test]
fn the_38_flat_tetrahedra_of_qhull() {
    let mesh = parse(include_str!("../testdata/qhull_grid_4x4x4.txt"));
    assert_eq!((mesh.points.len(), mesh.tets.len()), (64, 200));
    let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
    let r = check(&Mesh::new(&mesh.points, &mesh.tets), &options);
    assert_eq!(r.count(Kind::FlatTet), 38);
    let volume = |t: u32| {
        let corner = |v: u32| mesh.points[v as usize].map(|c| c as i64);
        volume6(mesh.tets[t as usize].map(corner))
    };
    let flat: Vec<u32> = (0..200).filter(|&t| volume(t) == 0).collect();
    let named: Vec<u32> =
        r.defects.iter().filter(|d| d.kind == Kind::FlatTet).map(|d| d.tets[0]).collect();
    assert_eq!(named, flat);
    assert_eq!(r.level(Level::Orientation).outcome, Outcome::Failed);
    assert_ne!(r.level(Level::Delaunay).outcome, Outcome::Passed);
    // Inner faces of flat tetrahedra have no in-sphere test; nor have some edges of the hull.
    let neighbours = common::adjacency(&mesh.tets);
    let pairs = (0..200u32).flat_map(|t| neighbours[t as usize].map(|u| (t, u)));
    let inner = pairs.filter(|&(t, u)| u != u32::MAX && t < u);
    let beside = inner.filter(|(t, u)| flat.contains(t) || flat.contains(u)).count() as u64;
    assert_eq!(r.level(Level::Orientation).untested, beside);
    assert_eq!(r.level(Level::Canonical).untested + 1, r.level(Level::Delaunay).untested);
    assert!(r.level(Level::Canonical).untested >= beside);
    assert_eq!(r.volume, 27.0);
}

/// The certificate of a small mesh, field by field: the schema is a promise.
#[test]
fn certificate_schema() {
    let mesh = delaunay(&[[0, 0, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0]]);
    let json = report(&mesh).certificate().to_json().unwrap();
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["schema"], "ltbw.cert/1");
    assert_eq!(value["passed"], true);
    let part = &value["mesh"];
    assert_eq!(part["hash_schema"], "ltbw.mesh/1");
    assert_eq!(part["hash"].as_str().unwrap().len(), 64);
    for (name, count) in [
        ("points", 4),
        ("vertices", 4),
        ("unused_points", 0),
        ("places_left_out", 0),
        ("tets", 1),
        ("faces", 4),
        ("edges", 6),
        ("hull_facets", 4),
        ("hull_vertices", 4),
        ("components", 1),
        ("negative_tets", 0),
    ] {
        assert_eq!(part[name], count, "{name}");
    }
    assert_eq!(part["volume"], 1.0 / 6.0);
    assert_eq!(part["mirrored"], false);
    let names: Vec<_> = Level::ALL.iter().map(|l| l.name()).collect();
    for (level, name) in value["levels"].as_array().unwrap().iter().zip(names) {
        assert_eq!(level["level"], name);
        assert_eq!(level["outcome"], "passed");
        for field in ["filter", "exact", "untested", "defects"] {
            assert!(level[field].is_u64(), "{field}");
        }
    }
    assert_eq!(value["defects"], serde_json::json!([]));

    let tets = [[0, 1, 2, 9]];
    let bad = check(&Mesh::new(&mesh.points, &tets), &ALL).certificate().to_json().unwrap();
    let value: serde_json::Value = serde_json::from_str(&bad).unwrap();
    assert_eq!(value["passed"], false);
    assert_eq!(value["mesh"]["hash"], serde_json::Value::Null);
    assert!(value["mesh"]["no_hash"].is_string());
    assert_eq!(value["defect_counts"]["index_out_of_range"], 1);
    let defect = &value["defects"][0];
    assert_eq!(defect["kind"], "index_out_of_range");
    assert_eq!(defect["tets"], serde_json::json!([0]));
    assert_eq!(defect["vertices"], serde_json::json!([0, 1, 2, 9]));
    assert_eq!(defect["at"][3], serde_json::Value::Null);
    assert_eq!(defect["at"][1], serde_json::json!([0.0, 0.0, 1.0]));
}

/// The report of the mesh with its adjacency given, as a mesh generator would give it.
fn aided(mesh: &Owned) -> Report {
    let neighbours = common::adjacency(&mesh.tets);
    check(&Mesh::new(&mesh.points, &mesh.tets).with_neighbours(&neighbours), &ALL)
}

/// A block of a grid, each cube cut into six tetrahedra along its main diagonal.
fn kuhn(n: u32) -> Owned {
    let id = |x: u32, y: u32, z: u32| (x * (n + 1) + y) * (n + 1) + z;
    let axis = |k: u32| 0..=k;
    let points = axis(n).flat_map(|x| {
        axis(n).flat_map(move |y| axis(n).map(move |z| [f64::from(x), f64::from(y), f64::from(z)]))
    });
    let steps = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let mut tets = Vec::new();
    for cube in 0..n * n * n {
        let corner = [cube / (n * n), cube / n % n, cube % n];
        for (k, order) in steps.iter().enumerate() {
            let mut at = corner;
            let mut tet = [id(at[0], at[1], at[2]); 4];
            for (slot, &axis) in order.iter().enumerate() {
                at[axis] += 1;
                tet[slot + 1] = id(at[0], at[1], at[2]);
            }
            if k >= 3 {
                tet.swap(2, 3);
            }
            tets.push(tet);
        }
    }
    Owned { points: points.collect(), tets }
}

#[test]
fn report_does_not_depend_on_threads() {
    let mut mesh = kuhn(20);
    let count = mesh.tets.len();
    for t in (0..count).step_by(7) {
        mesh.tets[t].swap(0, 1);
    }
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| report(&mesh).certificate().to_json().unwrap())
    };
    let one = run(1);
    assert!(one.contains("inverted_tet"));
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

#[test]
fn a_grid_of_cubes_passes_as_delaunay() {
    let mesh = kuhn(6);
    let r = report(&mesh);
    assert_eq!(r.level(Level::Delaunay).outcome, Outcome::Passed, "{r:#?}");
    assert_eq!(r.counts.edges, 7 * 7 * 6 * 3 + 7 * 36 * 3 + 216);
    assert_eq!(r.volume, 216.0);
    // Not canonical, so there is no short proof: the report is the same all the same.
    assert_eq!(aided(&mesh), r);
    let fast = Options { depth: ltbw_verify::Depth::Fast, ..ALL };
    let neighbours = common::adjacency(&mesh.tets);
    let view = Mesh::new(&mesh.points, &mesh.tets);
    let short = check(&view.with_neighbours(&neighbours), &fast);
    assert!(short.passed(), "{short:#?}");
    assert_eq!(short, check(&view, &fast));
}

/// Distinct points, snapped to a grid so coarse that most quintuples are degenerate.
fn snapped() -> impl Strategy<Value = Vec<IntPoint>> {
    (1i64..5).prop_flat_map(|side| {
        prop::collection::btree_set(prop::array::uniform3(-side..=side), 4..10)
            .prop_map(|set| set.into_iter().collect::<Vec<_>>())
            .prop_shuffle()
    })
}

fn scaled(mesh: &Owned, exponent: i32) -> Owned {
    // In two steps: 2^-1074 is no normal number.
    let half = 2f64.powi(exponent / 2);
    let rest = 2f64.powi(exponent - exponent / 2);
    let points = mesh.points.iter().map(|p| p.map(|c| c * half * rest)).collect();
    Owned { points, tets: mesh.tets.clone() }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn canonical_meshes_pass(points in snapped(), exponent in -1074i32..1020) {
        let mesh = delaunay(&points);
        prop_assume!(!mesh.tets.is_empty());
        let r = report(&mesh);
        prop_assert!(r.passed(), "{:#?}", r);
        prop_assert!(!r.mirrored);
        // The short proof says the same, the numbers that it does not count included.
        prop_assert_eq!(&aided(&mesh), &r);
        for exponent in [exponent, -1074, -200, 180, 1020] {
            let r = report(&scaled(&mesh, exponent));
            prop_assert!(r.passed(), "2^{}: {:#?}", exponent, r);
        }
    }

    #[test]
    fn any_other_mesh_fails(
        points in snapped(),
        kind in 0..4,
        pick in any::<prop::sample::Index>(),
        vertex in any::<prop::sample::Index>(),
        place in 0usize..4,
    ) {
        let good = delaunay(&points);
        prop_assume!(!good.tets.is_empty());
        let t = pick.index(good.tets.len());
        let mut bad = good.clone();
        match kind {
            0 => bad.tets[t][place] = vertex.index(points.len()) as u32,
            1 => drop(bad.tets.remove(t)),
            2 => bad.tets.push(good.tets[t]),
            _ => bad.tets[t].swap(place, (place + 1) % 4),
        }
        prop_assume!(bad.tets != good.tets);
        let r = report(&bad);
        // One tetrahedron alone is a mesh of either handedness.
        prop_assert_eq!(r.passed(), r.mirrored && r.counts.tets == 1, "{:?}", kinds(&r));
        // Nor does any adjacency make it pass; a true one changes nothing in the report.
        let a = aided(&bad);
        prop_assert_eq!(a.passed(), r.passed(), "{:?}", kinds(&a));
        if r.level(Level::Topology).outcome == Outcome::Passed {
            prop_assert_eq!(a, r);
        }
    }

    #[test]
    fn no_panic_on_garbage(
        points in prop::collection::vec(prop::array::uniform3(prop_oneof![
            any::<f64>(), Just(0.0), Just(1.0), Just(-0.0), Just(f64::NAN), Just(f64::MAX),
            Just(-f64::MAX), Just(5e-324),
        ]), 0..9),
        tets in prop::collection::vec(prop::array::uniform4(prop_oneof![
            8 => 0u32..8, 1 => any::<u32>(),
        ]), 0..12),
        neighbours in prop::collection::vec(any::<[u32; 4]>(), 0..12),
        hull in prop::collection::vec(prop::array::uniform3(0u32..9), 0..6),
    ) {
        let mesh = Mesh::new(&points, &tets).with_neighbours(&neighbours).with_hull(&hull);
        let options = Options { all_points: true, ..Options::default() };
        let r = check(&mesh, &options);
        prop_assert!(r.certificate().to_json().is_ok());
        for d in &r.defects {
            prop_assert_eq!(d.vertices.len(), d.at.len());
        }
    }
}
