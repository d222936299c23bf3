//! Every kind of defect, planted into a good mesh and found with its ids.

use crate::common::{GENERAL, Owned, adjacency, cube, delaunay, kinds, volume6};
use ltbw_verify::{Depth, Kind, Level, Mesh, Options, Outcome, Report, VertexOrder, check};

/// The report, which an adjacency must not change.
fn report(mesh: &Owned) -> Report {
    let view = Mesh::new(&mesh.points, &mesh.tets);
    let report = check(&view, &Options::default());
    let neighbours = adjacency(&mesh.tets);
    let aided = check(&view.with_neighbours(&neighbours), &Options::default());
    assert_eq!(aided.passed(), report.passed());
    // Broken meshes need not have an adjacency.
    if report.level(Level::Topology).outcome == Outcome::Passed {
        assert_eq!(aided, report);
    }
    report
}

fn general() -> Owned {
    let mesh = delaunay(&GENERAL);
    assert!(report(&mesh).passed(), "{:#?}", report(&mesh));
    mesh
}

/// A tetrahedron with four neighbours, and one with a face on the hull.
fn inner_and_outer(mesh: &Owned) -> (usize, usize) {
    let neighbours = adjacency(&mesh.tets);
    let inner = neighbours.iter().position(|n| !n.contains(&u32::MAX));
    let outer = neighbours.iter().position(|n| n.contains(&u32::MAX));
    (inner.expect("the mesh has inner ones"), outer.expect("the mesh has a hull"))
}

/// The listed defects of a kind, as (tets, vertices).
fn found(report: &Report, kind: Kind) -> Vec<(Vec<u32>, Vec<u32>)> {
    let of_kind = report.defects.iter().filter(|d| d.kind == kind);
    of_kind.map(|d| (d.tets.clone(), d.vertices.clone())).collect()
}

#[test]
fn empty_mesh() {
    let r = check(&Mesh::new(&[], &[]), &Options::default());
    assert_eq!(kinds(&r), [Kind::Empty]);
    assert!(!r.passed());
}

#[test]
fn index_out_of_range() {
    let mut mesh = general();
    mesh.tets[3][2] = u32::MAX;
    mesh.tets[5][0] = 12;
    let r = report(&mesh);
    let expected = [3usize, 5].map(|t| (vec![t as u32], mesh.tets[t].to_vec()));
    assert_eq!(found(&r, Kind::IndexOutOfRange), expected);
    let defect = r.defects.iter().find(|d| d.kind == Kind::IndexOutOfRange).unwrap();
    assert_eq!(defect.at[2], None);
    assert_eq!(defect.at[0], Some(mesh.points[mesh.tets[3][0] as usize]));
}

#[test]
fn repeated_vertex() {
    let mut mesh = general();
    mesh.tets[4][3] = mesh.tets[4][1];
    let r = report(&mesh);
    assert_eq!(found(&r, Kind::RepeatedVertex), [(vec![4], mesh.tets[4].to_vec())]);
}

#[test]
fn coordinates_that_are_not_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut mesh = general();
        mesh.points[8][1] = bad;
        let r = report(&mesh);
        assert_eq!(found(&r, Kind::NotFinite), [(vec![], vec![8])]);
        assert_eq!(r.level(Level::Structure).outcome, Outcome::Failed);
        let json = r.certificate().to_json().unwrap();
        assert!(json.contains(&format!("\"{bad}\"")), "{json}");
        // An unused point may be anything.
        let mut mesh = general();
        mesh.points.push([bad; 3]);
        assert!(report(&mesh).passed());
    }
}

#[test]
fn duplicated_tetrahedron() {
    let mut mesh = general();
    let (inner, outer) = inner_and_outer(&mesh);
    let count = mesh.tets.len() as u32;
    for t in [inner, outer] {
        let [a, b, c, d] = mesh.tets[t];
        mesh.tets.push([c, a, b, d]);
    }
    let r = report(&mesh);
    // The copies are named and left out; nothing else is wrong.
    assert_eq!(kinds(&r), [Kind::DuplicateTet]);
    let mut tets: Vec<_> = found(&r, Kind::DuplicateTet).into_iter().map(|d| d.0).collect();
    tets.sort();
    let mut expected = [vec![inner as u32, count], vec![outer as u32, count + 1]];
    expected.sort();
    assert_eq!(tets, expected);
}

#[test]
fn used_points_at_one_place() {
    let mut mesh = delaunay(&[[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 3], [1, 1, -3]]);
    mesh.points.push([-0.0, 0.0, -0.0]);
    let t = mesh.tets.iter().position(|t| t.contains(&0)).unwrap();
    let k = mesh.tets[t].iter().position(|&v| v == 0).unwrap();
    mesh.tets[t][k] = 5;
    let r = report(&mesh);
    assert_eq!(found(&r, Kind::EqualVertices), [(vec![], vec![0, 5])]);
}

#[test]
fn unused_points_are_counted() {
    let mut mesh = general();
    mesh.points.push(mesh.points[2]);
    mesh.points.push([50.0, 50.0, 50.0]);
    let r = report(&mesh);
    assert!(r.passed());
    assert_eq!((r.counts.unused_points, r.counts.places_left_out), (2, 1));
    let options = Options { all_points: true, ..Options::default() };
    let r = check(&Mesh::new(&mesh.points, &mesh.tets), &options);
    assert_eq!(found(&r, Kind::PointLeftOut), [(vec![], vec![13])]);
}

#[test]
fn face_of_three() {
    let mut mesh = general();
    let (inner, _) = inner_and_outer(&mesh);
    let [a, b, c, d] = mesh.tets[inner];
    let other = adjacency(&mesh.tets)[inner][3];
    let far = (0..12).find(|v| {
        !mesh.tets[inner].contains(v) && {
            let mut wanted = [a, b, c, *v];
            wanted.sort_unstable();
            !mesh.tets.iter().any(|t| {
                let mut t = *t;
                t.sort_unstable();
                t == wanted
            })
        }
    });
    mesh.tets.push([a, b, c, far.unwrap()]);
    let r = report(&mesh);
    let (tets, mut vertices) = found(&r, Kind::FaceOverused).remove(0);
    let mut expected = vec![inner as u32, other, mesh.tets.len() as u32 - 1];
    expected.sort_unstable();
    vertices.sort_unstable();
    let mut face = vec![a, b, c];
    face.sort_unstable();
    assert_eq!((tets, vertices), (expected, face));
    assert!(mesh.tets[inner].contains(&d));
}

#[test]
fn flipped_tetrahedron() {
    let mut mesh = general();
    let (inner, _) = inner_and_outer(&mesh);
    mesh.tets[inner].swap(0, 1);
    let r = report(&mesh);
    assert_eq!(kinds(&r), [Kind::SameSide, Kind::InvertedTet]);
    let expected = vec![(vec![inner as u32], mesh.tets[inner].to_vec())];
    assert_eq!(found(&r, Kind::InvertedTet), expected);
    assert_eq!(r.count(Kind::SameSide), 4);
    assert!(found(&r, Kind::SameSide).iter().all(|(tets, _)| tets.contains(&(inner as u32))));
    // No defect is left where the order of vertices means nothing.
    let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
    let r = check(&Mesh::new(&mesh.points, &mesh.tets), &options);
    assert!(r.passed());
    assert_eq!(r.counts.negative_tets, 1);
}

#[test]
fn mirrored_mesh_is_a_note() {
    let mut mesh = general();
    mesh.tets.iter_mut().for_each(|t| t.swap(2, 3));
    let r = report(&mesh);
    assert!(r.passed() && r.mirrored, "{r:#?}");
    assert!(!report(&general()).mirrored);
}

#[test]
fn swapped_neighbours() {
    let mesh = general();
    let mut neighbours = adjacency(&mesh.tets);
    let full = Options::default();
    let view = Mesh::new(&mesh.points, &mesh.tets);
    assert!(check(&view.with_neighbours(&neighbours), &full).passed());
    let (inner, _) = inner_and_outer(&mesh);
    let [x, y, ..] = neighbours[inner];
    neighbours[inner].swap(0, 1);
    let r = check(&view.with_neighbours(&neighbours), &full);
    assert_eq!(kinds(&r), [Kind::WrongNeighbour]);
    let tets: Vec<_> = found(&r, Kind::WrongNeighbour).into_iter().map(|d| d.0).collect();
    assert_eq!(tets, [[inner as u32, y, x], [inner as u32, x, y]]);
    let r = check(&view.with_neighbours(&neighbours[1..]), &full);
    assert_eq!(kinds(&r), [Kind::AdjacencyLength]);
}

#[test]
fn claimed_hull() {
    let mesh = delaunay(&[[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]);
    let view = Mesh::new(&mesh.points, &mesh.tets);
    let mut hull = vec![[2, 1, 0], [3, 0, 1], [0, 2, 3], [3, 1, 2]];
    assert!(check(&view.with_hull(&hull), &Options::default()).passed());
    hull[2] = [0, 1, 2];
    let r = check(&view.with_hull(&hull), &Options::default());
    assert_eq!(found(&r, Kind::HullFacetExtra), [(vec![], vec![0, 1, 2])]);
    assert_eq!(found(&r, Kind::HullFacetMissing), [(vec![0], vec![0, 2, 3])]);
    let r = check(&view.with_hull(&[]), &Options::default());
    assert_eq!(r.count(Kind::HullFacetMissing), 4);
}

#[test]
fn missing_inner_tetrahedron_leaves_a_second_surface() {
    let points: Vec<_> = GENERAL.into_iter().chain([[50, 45, 60], [45, 55, 65]]).collect();
    let mesh = delaunay(&points);
    let neighbours = adjacency(&mesh.tets);
    let on_hull: Vec<u32> = (0..mesh.tets.len())
        .flat_map(|t| (0..4).map(move |i| (t, i)))
        .filter(|&(t, i)| neighbours[t][i] == u32::MAX)
        .flat_map(|(t, i)| (0..4).filter(move |&k| k != i).map(move |k| (t, k)))
        .map(|(t, k)| mesh.tets[t][k])
        .collect();
    let buried = mesh.tets.iter().position(|t| t.iter().all(|v| !on_hull.contains(v)));
    let mut hole = mesh.clone();
    hole.tets.remove(buried.unwrap());
    let r = report(&hole);
    assert_eq!(r.count(Kind::HullDisconnected), 1);
    assert_eq!(r.count(Kind::Euler), 1);
    assert!(r.count(Kind::ConcaveHull) > 0);
    assert_eq!(r.level(Level::Topology).outcome, Outcome::Failed);
}

#[test]
fn missing_hull_tetrahedron_makes_the_hull_concave() {
    let mesh = general();
    let neighbours = adjacency(&mesh.tets);
    // One face on the hull, and all four vertices stay: the surface is dented, nothing else.
    let dent = (0..mesh.tets.len()).find(|&t| {
        let outside = neighbours[t].iter().filter(|&&n| n == u32::MAX).count();
        outside == 1 && {
            let mut rest = mesh.clone();
            rest.tets.remove(t);
            let r = report(&rest);
            kinds(&r) == [Kind::ConcaveHull]
        }
    });
    let t = dent.unwrap();
    let mut dented = mesh.clone();
    let gone = dented.tets.remove(t);
    let r = report(&dented);
    assert_eq!(r.level(Level::Topology).outcome, Outcome::Passed);
    assert_eq!(r.level(Level::Delaunay).outcome, Outcome::Failed);
    // The tetrahedron's faces now form the dent: three reflex edges at its inner vertex.
    let inner = gone[neighbours[t].iter().position(|&n| n == u32::MAX).unwrap()];
    assert_eq!(r.count(Kind::ConcaveHull), 3);
    for (_, vertices) in found(&r, Kind::ConcaveHull) {
        assert!(vertices[..2].contains(&inner));
        assert!(vertices.iter().all(|v| gone.contains(v)));
    }
}

#[test]
fn two_bodies() {
    let mut mesh = delaunay(&[[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]);
    let far: Vec<_> = mesh.points.iter().map(|p| [p[0] + 100.0, p[1], p[2]]).collect();
    mesh.points.extend(far);
    mesh.tets.push(mesh.tets[0].map(|v| v + 4));
    let r = report(&mesh);
    assert_eq!(kinds(&r), [Kind::Disconnected, Kind::HullDisconnected, Kind::Euler]);
    assert_eq!(found(&r, Kind::Disconnected)[0].0, [1]);
    assert_eq!(r.counts.components, 2);
}

#[test]
fn bodies_that_touch_in_a_vertex_or_an_edge() {
    // Two tetrahedra at one vertex: its link is in two parts.
    let points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]];
    let points: Vec<[f64; 3]> = points.iter().map(|p| p.map(f64::from)).collect();
    let mesh = Owned { points: points.clone(), tets: vec![[0, 1, 2, 3], [0, 5, 4, 6]] };
    let r = report(&mesh);
    assert_eq!(found(&r, Kind::VertexLink), [(vec![0, 1], vec![0])]);
    // Two at one edge: four hull facets there.
    let mesh = Owned { points, tets: vec![[0, 1, 2, 3], [0, 5, 4, 3]] };
    let r = report(&mesh);
    assert_eq!(found(&r, Kind::HullEdge), [(vec![0, 0, 1, 1], vec![0, 3])]);
}

#[test]
fn a_ring_is_no_ball() {
    // A prism bent into a ring: three blocks of three tetrahedra between three triangles.
    let mut tets = Vec::new();
    for k in 0..3u32 {
        let [a, b, c] = [3 * k, 3 * k + 1, 3 * k + 2];
        let [d, e, f] = [a, b, c].map(|v| (v + 3) % 9);
        tets.extend([[a, b, c, d], [b, c, d, e], [c, d, e, f]]);
    }
    let points: Vec<[f64; 3]> = (0..9)
        .map(|i| {
            let (x, y) = [(1.0, 0.0), (-0.5, 0.75), (-0.5, -0.75)][i / 3];
            let (r, z) = [(4.0, 0.0), (5.0, 0.0), (4.0, 1.0)][i % 3];
            [r * x, r * y, z]
        })
        .collect();
    let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
    let r = check(&Mesh::new(&points, &tets), &options);
    assert_eq!((r.count(Kind::Euler), r.count(Kind::HullEuler)), (1, 1));
    assert_eq!(r.count(Kind::VertexLink), 0);
}

#[test]
fn moved_vertex() {
    let mut mesh = general();
    mesh.points[8] = [300.0, 310.0, 290.0];
    let r = report(&mesh);
    assert_eq!(r.level(Level::Topology).outcome, Outcome::Passed);
    assert!(r.count(Kind::InvertedTet) > 0 && r.count(Kind::FoldedFace) > 0);
    for (tets, vertices) in found(&r, Kind::InvertedTet) {
        assert!(vertices.contains(&8));
        assert_eq!(vertices, mesh.tets[tets[0] as usize]);
    }
    // Folds are found without the help of the order of vertices.
    let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
    let any = check(&Mesh::new(&mesh.points, &mesh.tets), &options);
    assert_eq!(any.count(Kind::FoldedFace), r.count(Kind::FoldedFace));
    assert_eq!(any.level(Level::Orientation).outcome, Outcome::Failed);
}

#[test]
fn flip_of_two_to_three_and_back() {
    let points = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 3], [1, 1, -3]];
    let good = delaunay(&points);
    let two = vec![[0, 1, 2, 3], [0, 2, 1, 4]];
    let three = vec![[0, 1, 4, 3], [1, 2, 4, 3], [2, 0, 4, 3]];
    for t in two.iter().chain(&three) {
        assert!(volume6(t.map(|v| points[v as usize])) > 0);
    }
    let bad = if good.tets.len() == 2 { three } else { two };
    let r = report(&Owned { points: good.points, tets: bad.clone() });
    assert_eq!(kinds(&r), [Kind::NotDelaunay]);
    for (tets, vertices) in found(&r, Kind::NotDelaunay) {
        let [t, u] = [tets[0], tets[1]].map(|t| bad[t as usize]);
        assert!(vertices[..3].iter().all(|v| t.contains(v) && u.contains(v)));
        assert!(t.contains(&vertices[3]) && u.contains(&vertices[4]));
    }
}

#[test]
fn cube_with_other_ties() {
    let mesh = delaunay(&cube());
    assert!(report(&mesh).passed());
    // The mirror image in x = 1/2 is as good a Delaunay mesh, but not the canonical one.
    let tets: Vec<[u32; 4]> = mesh.tets.iter().map(|&[a, b, c, d]| [a, b, d, c]).collect();
    let other =
        Owned { points: mesh.points, tets: tets.iter().map(|t| t.map(|v| v ^ 4)).collect() };
    let r = report(&other);
    assert_eq!(kinds(&r), [Kind::NotCanonical, Kind::HullNotCanonical]);
    assert_eq!(r.level(Level::Delaunay).outcome, Outcome::Passed);
    assert_eq!(r.level(Level::Canonical).outcome, Outcome::Failed);
    for d in &r.defects {
        assert!(d.tets.iter().all(|&t| (t as usize) < other.tets.len()));
        let both = |v: &&u32| d.tets.iter().all(|&t| other.tets[t as usize].contains(v));
        assert_eq!(d.vertices.iter().filter(both).count(), d.vertices.len() - 2);
    }
    let fast = Options { depth: Depth::Fast, ..Options::default() };
    assert!(check(&Mesh::new(&other.points, &other.tets), &fast).passed());
}

/// Tetrahedra around the axis from (0, 0, h) to (0, 0, -h), one for each side of the polygon.
fn fan(polygon: &[[f64; 2]], h: f64) -> Owned {
    let mut points: Vec<[f64; 3]> = polygon.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let n = polygon.len() as u32;
    points.extend([[0.0, 0.0, h], [0.0, 0.0, -h]]);
    let tets = (0..n).map(|i| [i, (i + 1) % n, n, n + 1]).map(|[a, b, c, d]| [b, a, c, d]);
    Owned { points, tets: tets.collect() }
}

#[test]
fn wound_twice_around_an_axis() {
    // Locally everything is right: positive, a ball, locally Delaunay, convex at every edge.
    let circle = [(65, 0), (0, 65), (-65, 0), (0, -65), (63, 16), (-16, 63), (-63, -16), (16, -63)];
    let mesh = fan(&circle.map(|(x, y)| [x, y].map(f64::from)), 65.0);
    let r = report(&mesh);
    assert_eq!(r.level(Level::Orientation).outcome, Outcome::Passed, "{r:#?}");
    // A vertex of the first turn is beyond a facet of the second.
    assert!(r.count(Kind::HullTurnedAway) > 0);
    assert_eq!(r.level(Level::Delaunay).defects, r.count(Kind::HullTurnedAway));
    let first = &circle[..4];
    let once = fan(&[0, 1, 2, 3].map(|i| [first[i].0, first[i].1].map(f64::from)), 65.0);
    let fast = Options { depth: Depth::Fast, ..Options::default() };
    assert!(check(&Mesh::new(&once.points, &once.tets), &fast).passed());
}

/// A closed spiral of two turns; `swing` positive starts it far out, negative near.
fn spiral(swing: f64, scale: f64) -> Owned {
    let corner = |i: i32| {
        let angle = f64::from(i) * std::f64::consts::TAU / 24.0;
        let r = scale * (swing * (angle / 2.0).cos()).exp();
        [r * angle.cos(), r * angle.sin()]
    };
    fan(&(0..48).map(corner).collect::<Vec<_>>(), 0.05 * scale)
}

#[test]
fn wound_twice_seen_from_the_outer_turn() {
    let r = report(&spiral(0.6, 1.0));
    assert_eq!(r.level(Level::Orientation).outcome, Outcome::Passed);
    assert_eq!(kinds(&r), [Kind::HullTurnedAway]);
    assert_eq!(r.level(Level::Delaunay).outcome, Outcome::Failed);
}

#[test]
fn wound_twice_seen_from_the_inner_turn() {
    // All of the first tetrahedron is inside every facet: only the ray tells. The small scale is
    // below the range of the ray's filter, so exact arithmetic decides there.
    for scale in [1.0, 2f64.powi(-400)] {
        let r = report(&spiral(-0.6, scale));
        assert_eq!(r.level(Level::Orientation).outcome, Outcome::Passed);
        assert_eq!(kinds(&r), [Kind::HullWoundTwice]);
        // The ray leaves the first turn between corners 0 and 1, the second 24 corners later.
        for (tets, _) in found(&r, Kind::HullWoundTwice) {
            assert!(tets[0] == 0 && (23..=25).contains(&tets[1]), "{tets:?}");
        }
    }
}

#[test]
fn wound_twice_with_the_ray_through_an_edge() {
    // 47 corners over two turns: the ray, in the plane y = 0, leaves through an edge of the
    // second turn, which belongs to two facets.
    let corner = |i: i32| {
        let angle = (f64::from(i) - 0.5) * std::f64::consts::TAU * 2.0 / 47.0;
        let r = (-0.6 * (angle / 2.0).cos()).exp();
        if i == 24 { [r, 0.0] } else { [r * angle.cos(), r * angle.sin()] }
    };
    let r = report(&fan(&(0..47).map(corner).collect::<Vec<_>>(), 0.05));
    assert_eq!(kinds(&r), [Kind::HullWoundTwice]);
    let tets: Vec<_> = found(&r, Kind::HullWoundTwice).into_iter().map(|d| d.0).collect();
    assert_eq!(tets, [[0, 23], [0, 24]]);
}

#[test]
fn link_in_two_parts_that_together_count_as_a_disk() {
    // A ring of six triangles (V - E + F = 0) and one more triangle (1) around point 0.
    let ring = [[1, 2, 4], [2, 5, 4], [2, 3, 5], [3, 6, 5], [3, 1, 6], [1, 4, 6]];
    let tets: Vec<[u32; 4]> =
        ring.iter().chain(&[[7, 8, 9]]).map(|&[a, b, c]| [0, a, b, c]).collect();
    let points = GENERAL.map(|p| p.map(|c| c as f64));
    let r = check(&Mesh::new(&points, &tets), &Options::default());
    let links: Vec<_> = found(&r, Kind::VertexLink).into_iter().map(|d| d.1).collect();
    assert_eq!(links, [[0]]);
}

#[test]
fn unsound_tetrahedra_do_not_hide_the_others() {
    let mut mesh = general();
    mesh.tets.push([0, 1, 2, 99]);
    let r = report(&mesh);
    assert_eq!(kinds(&r), [Kind::IndexOutOfRange]);
    assert_eq!(r.counts.vertices, 12);
    // The later levels have nothing against the rest, but do not pass.
    for level in &r.levels[1..] {
        assert_eq!(level.outcome, Outcome::Incomplete, "{}", level.level);
    }
    assert!(r.level(Level::Delaunay).filter > 0);
}

#[test]
fn lists_are_bounded_and_counts_are_not() {
    let mesh = general();
    let tets: Vec<[u32; 4]> = mesh.tets.iter().map(|_| [99; 4]).collect();
    let options = Options { max_defects: 2, ..Options::default() };
    let r = check(&Mesh::new(&mesh.points, &tets), &options);
    assert_eq!(r.count(Kind::IndexOutOfRange), tets.len() as u64);
    assert_eq!(found(&r, Kind::IndexOutOfRange).len(), 2);
    let text = r.defects[0].to_string();
    assert!(text.starts_with("index_out_of_range: tets [0], 99, "), "{text}");
}
