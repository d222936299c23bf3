//! Voronoi cells: exact combinatorics, and volumes that fill space.

use ltbw_core::query::{Cell, CellFace, Queries};
use ltbw_core::topology::TetId;
use ltbw_core::{Builder, Mesh, Vertex};
use ltbw_exact::predicates::{insphere, orient3d};
use ltbw_exact::{Point, PointSet, Sign};
use ltbw_generate::{PointKind, generate};
use std::collections::BTreeMap;

fn build(points: &[Point]) -> Mesh {
    let set = PointSet::new(points.to_vec()).expect("finite points");
    Builder::new().build(&set).expect("points of dimension 3").mesh
}

fn grid(k: i32) -> Vec<Point> {
    (0..k * k * k).map(|i| [i % k, i / k % k, i / k / k].map(f64::from)).collect()
}

fn point(queries: &Queries<'_>, v: Vertex) -> Point {
    queries.point(v).expect("a vertex")
}

fn centre(queries: &Queries<'_>, t: TetId) -> Point {
    queries.circumcentre(t).expect("a finite tetrahedron").centre
}

fn minus(p: Point, q: Point) -> Point {
    [0, 1, 2].map(|k| p[k] - q[k])
}

fn dot(p: Point, q: Point) -> f64 {
    (0..3).map(|k| p[k] * q[k]).sum()
}

fn cross(p: Point, q: Point) -> Point {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

/// Volume of the pyramid from the vertex over a face, by its fan of triangles.
fn pyramid(queries: &Queries<'_>, v: Vertex, face: &CellFace<'_>) -> f64 {
    let apex = point(queries, v);
    let at = |t| minus(centre(queries, t), apex);
    let first = at(face.corners[0]);
    let fan = face.corners.windows(2).skip(1);
    fan.map(|w| dot(first, cross(at(w[0]), at(w[1]))) / 6.0).sum()
}

/// Checks one cell by exact tests: its corners' spheres pass through both vertices, the spheres
/// of different corners differ, and those that follow each other share a third vertex (up to
/// cospherical ones).
fn check_cell(mesh: &Mesh, queries: &Queries<'_>, cell: &Cell<'_>) {
    let v = cell.vertex();
    let on_sphere = |t: TetId, w: Vertex| {
        let [a, b, c, d] = mesh.tet(t).expect("finite").map(|x| point(queries, x));
        insphere(&a, &b, &c, &d, &point(queries, w)).is_zero()
    };
    for face in cell.faces() {
        assert_ne!(face.neighbour, v);
        assert!(!cell.is_bounded() || face.rays.is_none());
        for &t in face.corners {
            let tet = mesh.tet(t).expect("a finite tetrahedron");
            assert!(tet.contains(&v) && tet.contains(&face.neighbour));
            assert!(on_sphere(t, v) && on_sphere(t, face.neighbour));
        }
        for (i, &t) in face.corners.iter().enumerate() {
            for &u in &face.corners[..i] {
                let same = mesh.tet(u).expect("finite").iter().all(|&w| on_sphere(t, w));
                assert!(!same, "corners {t} and {u} of the face {v} {} are one", face.neighbour);
            }
        }
        match face.rays {
            None => assert!(face.corners.len() >= 3),
            Some(ghosts) => {
                assert!(!face.corners.is_empty());
                assert!(ghosts.iter().all(|&g| mesh.topology().get(g).expect("a slot").is_ghost()));
            }
        }
    }
}

#[test]
fn cells_of_every_kind_are_exact_and_symmetric() {
    for kind in PointKind::ALL {
        let mesh = build(&generate(kind, 150, 2));
        let queries = mesh.queries();
        let mut cursor = queries.cursor();
        let hull: Vec<Vertex> = mesh.hull_facets().flatten().collect();
        // Sizes of the faces, by pair of vertices: both cells must have them.
        let mut faces: BTreeMap<[Vertex; 2], Vec<(usize, bool)>> = BTreeMap::new();
        for (v, _) in mesh.vertices() {
            let cell = cursor.cell(v).expect("a vertex");
            assert_eq!(cell.is_bounded(), !hull.contains(&v), "{kind}");
            check_cell(&mesh, &queries, &cell);
            let mut found = Vec::new();
            for face in cell.faces() {
                let size = (face.corners.len(), face.rays.is_some());
                faces.entry([v.min(face.neighbour), v.max(face.neighbour)]).or_default().push(size);
                found.push(face.neighbour);
            }
            if cell.is_bounded() {
                assert!(cell.faces().all(|face| face.rays.is_none()));
                // Euler's formula of a polytope of which three faces or more meet at a corner.
                let edges: usize = cell.faces().map(|f| f.corners.len()).sum::<usize>() / 2;
                assert!(found.len() >= 4 && edges >= found.len() + 2, "{kind}");
            }
            let near = cursor.neighbours(v).expect("a vertex");
            assert!(found.iter().all(|w| near.contains(w)));
        }
        assert!(faces.values().all(|f| f.len() == 2 && f[0] == f[1]), "{kind}");
    }
}

#[test]
fn a_bounded_cell_is_convex_and_bounded_cells_have_their_volume() {
    let points = generate(PointKind::Uniform, 400, 6);
    let mesh = build(&points);
    let queries = mesh.queries();
    let mut cursor = queries.cursor();
    let mut bounded = 0;
    for (v, p) in mesh.vertices() {
        let cell = cursor.cell(v).expect("a vertex");
        if !cell.is_bounded() {
            continue;
        }
        bounded += 1;
        for face in cell.faces() {
            // Counterclockwise seen from the neighbour: every fan triangle is positive.
            assert!(pyramid(&queries, v, &face) > 0.0);
            let apart = minus(point(&queries, face.neighbour), p);
            for &t in face.corners {
                // As near to one vertex as to the other.
                let q = minus(centre(&queries, t), p);
                let scale = dot(q, q).sqrt().max(1.0) * 1e-9;
                assert!((dot(q, apart) - dot(apart, apart) / 2.0).abs() < scale);
            }
        }
        // Each corner appears in three faces: the corners are simple in general position.
        let mut seen: BTreeMap<TetId, usize> = BTreeMap::new();
        cell.faces().flat_map(|f| f.corners).for_each(|&t| *seen.entry(t).or_default() += 1);
        assert!(seen.values().all(|&n| n == 3));
        let (f, e) = (cell.faces().len(), seen.len() * 3 / 2);
        assert_eq!(seen.len() + f, e + 2, "Euler's formula");
    }
    assert!(bounded > 200);
}

#[test]
fn cells_of_a_grid_are_cubes_whatever_the_perturbation_did() {
    let k = 5;
    let mesh = build(&grid(k));
    let queries = mesh.queries();
    let mut cursor = queries.cursor();
    let mut cubes = 0;
    for (v, p) in mesh.vertices() {
        let cell = cursor.cell(v).expect("a vertex");
        let inner = p.iter().filter(|&&c| c > 0.0 && c < f64::from(k - 1)).count();
        // A face for each of the grid's neighbours, and no other.
        assert_eq!(cell.faces().len(), 3 + inner);
        for face in cell.faces() {
            let d = minus(point(&queries, face.neighbour), p);
            assert_eq!(dot(d, d), 1.0);
        }
        assert_eq!(cell.is_bounded(), inner == 3);
        if inner == 3 {
            assert!(cell.faces().all(|face| face.corners.len() == 4));
            let volume: f64 = cell.faces().map(|f| pyramid(&queries, v, &f)).sum();
            assert!((volume - 1.0).abs() < 1e-9);
            cubes += 1;
        } else {
            // Rays come in along facet normals: a wedge, a half strip or a strip with corners.
            assert!(cell.faces().any(|face| face.rays.is_some()));
        }
    }
    assert_eq!(cubes, 27);
}

#[test]
fn rays_leave_along_the_facets_they_name() {
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mesh = build(&points);
    let queries = mesh.queries();
    let mut cursor = queries.cursor();
    for v in 0..4 {
        let cell = cursor.cell(v).expect("a vertex");
        assert_eq!((cell.is_bounded(), cell.faces().len()), (false, 3));
        for face in cell.faces() {
            let [first, last] = face.rays.expect("an unbounded face");
            // The facets of both ghosts have the edge; turning about it counterclockwise seen
            // from the neighbour, the tetrahedron is between the last and the first facet.
            let third = |ghost: TetId| {
                let [a, b, c, _] = mesh.topology().get(ghost).expect("a slot").vertices();
                let all: Vec<Vertex> = queries
                    .hull()
                    .find(|f| {
                        let q = [a, b, c].map(|w| mesh.vertices().nth(w.index() - 1));
                        q.iter().flatten().all(|(w, _)| f.contains(w))
                    })
                    .expect("a hull facet")
                    .to_vec();
                assert!(all.contains(&v) && all.contains(&face.neighbour));
                all.into_iter().find(|&w| w != v && w != face.neighbour).expect("three corners")
            };
            let (a, b) = (third(first), third(last));
            let [p, q, r, s] = [v, face.neighbour, a, b].map(|w| point(&queries, w));
            assert_eq!(orient3d(&p, &q, &r, &s), Sign::Positive);
        }
    }
}
