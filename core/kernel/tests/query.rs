//! Queries against brute force, on degenerate and ordinary points.

use ltbw_core::query::{Conflicts, Cursor, Location, Queries};
use ltbw_core::topology::{INFINITE, TetId};
use ltbw_core::{Builder, Duplicate, Inserted, Mesh, Vertex};
use ltbw_exact::predicates::{Sign, cmp_xyz, exact, orient3d, perturb};
use ltbw_exact::{Mode, Point, PointError, PointSet};
use ltbw_generate::{PointKind, generate};
use num_bigint::BigInt;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

fn build(points: &[Point]) -> Mesh {
    let set = PointSet::new(points.to_vec()).expect("finite points");
    Builder::new().build(&set).expect("points of dimension 3").mesh
}

fn grid(k: i32, unit: f64) -> Vec<Point> {
    let place = |i: i32| [i % k, i / k % k, i / k / k].map(|c| f64::from(c) * unit);
    (0..k * k * k).map(place).collect()
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

/// Mixed exponents over the whole range.
fn wide(count: usize, seed: u64) -> Vec<Point> {
    let mut next = random(seed);
    let mut coordinate = || {
        let sign = if next(2) == 0 { 1.0 } else { -1.0 };
        sign * (1.0 + next(4096) as f64 / 4096.0) * 2f64.powi(next(1800) as i32 - 900)
    };
    (0..count).map(|_| [coordinate(), coordinate(), coordinate()]).collect()
}

/// Small sets of points with names: every kind, grids at ordinary and subnormal scale, and wide.
fn sets() -> Vec<(String, Vec<Point>)> {
    let kinds = PointKind::ALL.iter().map(|&k| (k.to_string(), generate(k, 90, 3)));
    let more = [
        ("cube".to_owned(), grid(2, 1.0)),
        ("lattice".to_owned(), grid(4, 0.1)),
        ("subnormal".to_owned(), grid(3, f64::from_bits(3))),
        ("huge".to_owned(), grid(3, 2f64.powi(1000))),
        ("wide".to_owned(), wide(60, 5)),
        (
            "tetrahedron".to_owned(),
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        ),
    ];
    kinds.chain(more).collect()
}

/// Points to ask for: vertices, middles of two, three and four of them, reflections and ulps.
fn questions(points: &[Point], seed: u64) -> Vec<Point> {
    let mut next = random(seed);
    let mut asked = vec![[0.0; 3], [1e300, -1e300, 3.0], [f64::MAX; 3], [5e-324, -0.0, 1.0]];
    asked.extend(points.iter().step_by(1 + points.len() / 20));
    for k in 0..60 {
        let [a, b, c, d] = [0; 4].map(|_| points[next(points.len())]);
        asked.push([0, 1, 2].map(|i| match k % 5 {
            0 => a[i] / 2.0 + b[i] / 2.0,
            1 => a[i] / 4.0 + b[i] / 4.0 + c[i] / 2.0,
            2 => a[i] / 4.0 + b[i] / 4.0 + c[i] / 4.0 + d[i] / 4.0,
            3 => a[i] / 2.0 - b[i] / 2.0,
            _ => f64::from_bits((a[i] + 0.0).to_bits() ^ next(3) as u64),
        }));
    }
    asked.retain(|p| p.iter().all(|c| c.is_finite()));
    asked
}

/// Exact integer in units of 2^-1074.
fn integer(c: f64) -> BigInt {
    let bits = c.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i64, bits & ((1 << 52) - 1));
    let m = if field == 0 { fraction } else { fraction | 1 << 52 };
    let magnitude = BigInt::from(m) << (field.max(1) - 1);
    if c < 0.0 { -magnitude } else { magnitude }
}

fn squared_distance(p: &Point, q: &Point) -> BigInt {
    (0..3).map(|k| integer(p[k]) - integer(q[k])).map(|d| &d * &d).sum()
}

fn vertices(mesh: &Mesh) -> BTreeMap<Vertex, Point> {
    mesh.vertices().collect()
}

/// The smallest simplex that holds `p`, from the list of tetrahedra alone, as its vertices
/// ascending; none outside.
fn brute_locate(tets: &[[Vertex; 4]], at: &BTreeMap<Vertex, Point>, p: &Point) -> Vec<Vertex> {
    for tet in tets {
        let sides = [0, 1, 2, 3].map(|i| {
            let corners = [0, 1, 2, 3].map(|j| if i == j { *p } else { at[&tet[j]] });
            let [a, b, c, d] = &corners;
            exact::orient3d(a, b, c, d)
        });
        if !sides.contains(&Sign::Negative) {
            let held = (0..4).filter(|&i| sides[i] == Sign::Positive);
            let mut simplex: Vec<Vertex> = held.map(|i| tet[i]).collect();
            simplex.sort_unstable();
            return simplex;
        }
    }
    Vec::new()
}

/// The simplex of a location; checks what it names on the way.
fn simplex(mesh: &Mesh, at: &BTreeMap<Vertex, Point>, p: &Point, found: Location) -> Vec<Vertex> {
    let has = |tet: TetId, corners: &[Vertex]| {
        let all = mesh.tet(tet).expect("a finite tetrahedron");
        assert!(corners.iter().all(|v| all.contains(v)), "{found:?}");
    };
    match found {
        Location::Vertex(v) => vec![v],
        Location::Edge { ends, tet } => {
            has(tet, &ends);
            ends.to_vec()
        }
        Location::Facet { corners, tet } => {
            has(tet, &corners);
            corners.to_vec()
        }
        Location::Tet(t) => {
            let mut all = mesh.tet(t).expect("a finite tetrahedron").to_vec();
            all.sort_unstable();
            all
        }
        Location::OutsideHull { facet, ghost } => {
            assert!(mesh.topology().get(ghost).expect("a slot").is_ghost());
            let [a, b, c] = facet.map(|v| at[&v]);
            assert_eq!(exact::orient3d(&a, &b, &c, p), Sign::Positive, "{p:?} {found:?}");
            assert!(mesh.hull_facets().any(|f| f == facet));
            Vec::new()
        }
    }
}

#[test]
fn locate_agrees_with_exhaustive_search() {
    let mut seen = [0; 5];
    for (name, points) in sets() {
        let mesh = build(&points);
        let (at, tets): (_, Vec<_>) = (vertices(&mesh), mesh.tets().collect());
        let queries = mesh.queries();
        let mut cursor = queries.cursor();
        for p in questions(&points, 11) {
            let found = cursor.locate(p).expect("a finite point");
            let simplex_found = simplex(&mesh, &at, &p, found);
            assert_eq!(simplex_found, brute_locate(&tets, &at, &p), "{name}: {p:?}");
            let searched = cursor.locate_by_search(p).expect("a finite point");
            assert_eq!(simplex(&mesh, &at, &p, searched), simplex_found, "{name}: {p:?}");
            seen[simplex_found.len()] += 1;
        }
    }
    assert!(seen.iter().all(|&n| n > 50), "every kind of answer occurs: {seen:?}");
}

#[test]
fn nearest_agrees_with_brute_force_ties_included() {
    let (mut ties, mut total) = (0, 0);
    for (name, points) in sets() {
        let mesh = build(&points);
        let queries = mesh.queries();
        let mut cursor = queries.cursor();
        for p in questions(&points, 12) {
            let mut all: Vec<(BigInt, Point, Vertex)> =
                mesh.vertices().map(|(v, q)| (squared_distance(&p, &q), q, v)).collect();
            all.sort_by(|a, b| a.0.cmp(&b.0).then_with(|| cmp_xyz(&a.1, &b.1)));
            ties += usize::from(all[0].0 == all[1].0);
            total += 1;
            assert_eq!(cursor.nearest(p), Ok(all[0].2), "{name}: {p:?}");
        }
    }
    assert!(ties > 50 && total - ties > 500, "{ties} ties of {total}");
}

#[test]
fn stars_neighbours_and_edges_agree_with_a_recount() {
    for (name, points) in sets() {
        let mesh = build(&points);
        let mut stars: BTreeMap<Vertex, BTreeSet<TetId>> = BTreeMap::new();
        let mut near: BTreeMap<Vertex, BTreeSet<Vertex>> = BTreeMap::new();
        let mut edges = BTreeSet::new();
        for t in mesh.tet_ids() {
            let tet = mesh.tet(t).expect("a finite tetrahedron");
            for a in tet {
                stars.entry(a).or_default().insert(t);
                for b in tet.into_iter().filter(|&b| b != a) {
                    near.entry(a).or_default().insert(b);
                    edges.insert([a.min(b), a.max(b)]);
                }
            }
        }
        let hull: BTreeSet<Vertex> = mesh.hull_facets().flatten().collect();
        let queries = mesh.queries();
        let mut cursor = queries.cursor();
        assert_eq!(stars.len(), mesh.num_vertices(), "{name}");
        for (v, point) in mesh.vertices() {
            let star: Vec<TetId> = stars[&v].iter().copied().collect();
            assert_eq!(cursor.star(v), Some(&star[..]), "{name}: {v}");
            let ring: Vec<Vertex> = near[&v].iter().copied().collect();
            assert_eq!(cursor.neighbours(v), Some(&ring[..]), "{name}: {v}");
            assert_eq!(cursor.is_on_hull(v), Some(hull.contains(&v)));
            assert_eq!((queries.point(v), queries.vertex(v)), (Some(point), Some(v)));
        }
        for &Duplicate { number, kept } in mesh.duplicates() {
            assert_eq!(queries.vertex(number), Some(kept));
            assert_eq!(cursor.star(number).map(<[TetId]>::len), Some(stars[&kept].len()));
        }
        let listed: Vec<[Vertex; 2]> = cursor.edges().collect();
        assert_eq!(listed.len(), edges.len(), "{name}: each edge once");
        assert_eq!(listed.into_iter().collect::<BTreeSet<_>>(), edges, "{name}");
        assert_eq!(queries.hull().count(), mesh.num_hull_faces());
        let beyond = points.len() as Vertex;
        assert_eq!(cursor.star(beyond), None);
        assert_eq!(cursor.neighbours(beyond), None);
        assert!(cursor.cell(beyond).is_none() && queries.point(beyond).is_none());
    }
}

/// Every tetrahedron and hull facet in conflict with `p`, tested one by one.
fn brute_zone(mesh: &Mesh, at: &BTreeMap<Vertex, Point>, p: &Point) -> (Vec<TetId>, usize) {
    let inside = |t: &TetId| {
        let [a, b, c, d] = mesh.tet(*t).expect("a finite tetrahedron").map(|v| at[&v]);
        perturb::side_of_sphere(&a, &b, &c, &d, p).is_positive()
    };
    let sees = |f: &[Vertex; 3]| {
        let [a, b, c] = f.map(|v| at[&v]);
        perturb::side_of_hull_facet(&a, &b, &c, p).is_positive()
    };
    (mesh.tet_ids().filter(inside).collect(), mesh.hull_facets().filter(sees).count())
}

#[test]
fn conflict_zones_agree_with_testing_everything_and_with_inserting() {
    let (mut inside, mut outside) = (0, 0);
    for (name, points) in sets() {
        let mut mesh = build(&points);
        for p in questions(&points, 13).into_iter().take(40) {
            let at = vertices(&mesh);
            let before: BTreeSet<[Vertex; 4]> = sorted(mesh.tets());
            let hull_before = mesh.num_hull_faces();
            let mut boundary = Vec::new();
            let (mut gone, mut hull_gone, mut horizon) = (BTreeSet::new(), 0, 0);
            let mut vertex = None;
            let queries = mesh.queries();
            match queries.cursor().conflicts(p).expect("a finite point") {
                Conflicts::AtVertex(v) => {
                    assert_eq!(at[&v], p.map(|c| c + 0.0));
                    vertex = Some(v);
                }
                Conflicts::Region(region) => {
                    let (tets, hull) = brute_zone(&mesh, &at, &p);
                    let mut found = region.tets.to_vec();
                    found.sort_unstable();
                    assert_eq!((found, region.hull.len()), (tets, hull), "{name}: {p:?}");
                    gone = sorted(region.tets.iter().filter_map(|&t| mesh.tet(t)));
                    (hull_gone, horizon) = (region.hull.len(), region.horizon.len());
                    boundary = region.boundary.to_vec();
                    check_walls(&mesh, &at, &p, &boundary);
                    check_horizon(region.hull, region.horizon);
                }
            }
            if gone.is_empty() {
                outside += 1
            } else {
                inside += 1
            }
            // Inserting does what was foretold.
            let inserted = mesh.insert(p).expect("a finite point");
            let new = match (inserted, vertex) {
                (Inserted::Duplicate(v), Some(w)) => {
                    assert_eq!(v, w);
                    continue;
                }
                (Inserted::Vertex(v), None) => v,
                other => panic!("{name}: {p:?}: {other:?}"),
            };
            let star = boundary.iter().map(|w| [w.corners[0], w.corners[1], w.corners[2], new]);
            let kept = before.difference(&gone).copied();
            let expected: BTreeSet<[Vertex; 4]> = sorted(star).into_iter().chain(kept).collect();
            assert_eq!(sorted(mesh.tets()), expected, "{name}: {p:?}");
            assert_eq!(mesh.num_hull_faces(), hull_before - hull_gone + horizon);
        }
    }
    assert!(inside > 200 && outside > 20, "{inside} {outside}");
}

fn sorted(tets: impl Iterator<Item = [Vertex; 4]>) -> BTreeSet<[Vertex; 4]> {
    tets.map(|mut t| {
        t.sort_unstable();
        t
    })
    .collect()
}

fn check_walls(
    mesh: &Mesh,
    at: &BTreeMap<Vertex, Point>,
    p: &Point,
    boundary: &[ltbw_core::query::RegionFace],
) {
    for bound in boundary {
        let [a, b, c] = bound.corners.map(|v| at[&v]);
        assert_eq!(orient3d(p, &a, &b, &c), Sign::Positive);
        if let Some(t) = bound.beyond {
            let tet = mesh.tet(t).expect("a finite tetrahedron");
            assert!(bound.corners.iter().all(|v| tet.contains(v)));
        }
    }
}

fn check_horizon(hull: &[[Vertex; 3]], horizon: &[[Vertex; 2]]) {
    // The horizon is the boundary of the hull facets: their edges that have no partner.
    let edges: BTreeSet<[Vertex; 2]> =
        hull.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    let open: BTreeSet<[Vertex; 2]> =
        edges.iter().copied().filter(|&[a, b]| !edges.contains(&[b, a])).collect();
    assert_eq!(horizon.iter().copied().collect::<BTreeSet<_>>(), open);
    assert_eq!(horizon.len(), open.len());
}

fn is_shared<T: Send + Sync>() {}

#[test]
fn many_threads_ask_one_mesh() {
    is_shared::<Mesh>();
    is_shared::<Queries<'static>>();
    is_shared::<Cursor<'static>>();
    let points = generate(PointKind::Clusters, 4000, 8);
    let mesh = build(&points);
    let queries = mesh.queries();
    let asked = generate(PointKind::Uniform, 3000, 9);
    let ask = |cursor: &mut Cursor<'_>, p: Point| {
        let location = cursor.locate(p).expect("a finite point");
        let nearest = cursor.nearest(p).expect("a finite point");
        let Conflicts::Region(region) = cursor.conflicts(p).expect("a finite point") else {
            panic!("{p:?} is no vertex");
        };
        let region = (region.tets.len(), region.boundary.len());
        let outside = matches!(location, Location::OutsideHull { .. });
        let tet = if let Location::Tet(t) = location { Some(t) } else { None };
        let faces = cursor.cell(nearest).expect("a vertex").faces().len();
        (outside, tet, nearest, region, faces)
    };
    let mut one = queries.cursor();
    let alone: Vec<_> = asked.iter().map(|&p| ask(&mut one, p)).collect();
    let together: Vec<_> = asked
        .par_chunks(50)
        .map_init(
            || queries.cursor(),
            |cursor, chunk| chunk.iter().map(|&p| ask(cursor, p)).collect::<Vec<_>>(),
        )
        .flatten()
        .collect();
    assert_eq!(alone, together);
}

#[test]
fn points_that_are_not_finite_are_refused() {
    let mesh = build(&grid(2, 1.0));
    let queries = mesh.queries();
    let mut cursor = queries.cursor();
    let p = [0.0, f64::INFINITY, 0.0];
    let error = PointError::NotFinite { index: 0, axis: 'y', value: f64::INFINITY };
    assert_eq!(cursor.locate(p), Err(error.clone()));
    assert_eq!(cursor.nearest(p), Err(error.clone()));
    assert_eq!(cursor.conflicts(p), Err(error));
}

#[test]
fn modes_of_all_kinds_are_among_the_sets_and_memory_is_counted() {
    let mut modes = [0; 3];
    for (_, points) in sets() {
        let mesh = build(&points);
        modes[match mesh.mode() {
            Mode::Normal => 0,
            Mode::Rescaled { .. } => 1,
            Mode::Wide => 2,
        }] += 1;
        let queries = mesh.queries();
        let mut cursor = queries.cursor();
        let ghosts = mesh.topology().iter().filter(|(_, t)| t.vertices()[3] == INFINITE).count();
        assert_eq!(ghosts, queries.hull().count());
        assert!(queries.memory_bytes() >= 8 * mesh.num_vertices());
        let before = cursor.memory_bytes();
        assert!(cursor.cell(mesh.tets().flatten().next().expect("a vertex")).is_some());
        assert!(cursor.memory_bytes() > before);
    }
    assert!(modes.iter().all(|&n| n > 0), "{modes:?}");
}
