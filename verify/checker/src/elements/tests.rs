//! The search finds what a comparison of all pairs finds, and makes about n log n tests, on meshes
//! of long, thin and graded cells, too.

use crate::mesh::{Mesh, Options, Point};
use crate::{Level, check_elements};
use std::collections::HashMap;

/// A mesh that a test owns.
struct Owned {
    points: Vec<Point>,
    tets: Vec<[u32; 4]>,
}

impl Owned {
    /// The tests of the level *overlap*, of a sound mesh.
    fn tests(&self) -> u64 {
        let report = check_elements(&Mesh::new(&self.points, &self.tets), &options(), false);
        assert!(report.passed(), "{report}");
        let level = report.level(Level::Overlap);
        level.filter + level.exact
    }

    /// Each cell with vertices of its own.
    fn apart(&self) -> Self {
        let points = self.tets.iter().flatten().map(|&v| self.points[v as usize]).collect();
        let tets = (0..self.tets.len() as u32).map(|t| [0, 1, 2, 3].map(|k| 4 * t + k)).collect();
        Self { points, tets }
    }
}

fn options() -> Options {
    Options { max_defects: 1 << 20, ..Options::default() }
}

/// A grid of nx × ny × nz boxes of six tetrahedra each, of which `is_there` says which are there,
/// its corners where `place` says.
fn grid(
    [nx, ny, nz]: [usize; 3],
    is_there: impl Fn([usize; 3]) -> bool,
    place: impl Fn([f64; 3]) -> Point,
) -> Owned {
    let mut mesh = Owned { points: Vec::new(), tets: Vec::new() };
    let mut number = HashMap::new();
    for cell in 0..nx * ny * nz {
        let at = [cell % nx, cell / nx % ny, cell / nx / ny];
        // Along the diagonal, in each order of the axes.
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        for (k, order) in orders.into_iter().enumerate().filter(|_| is_there(at)) {
            let mut corner = at;
            let mut tet = [0; 4];
            for (step, vertex) in tet.iter_mut().enumerate() {
                let count = mesh.points.len() as u32;
                *vertex = *number.entry(corner).or_insert_with(|| {
                    mesh.points.push(place(corner.map(|i| i as f64)));
                    count
                });
                order.get(step).into_iter().for_each(|&axis| corner[axis] += 1);
            }
            mesh.tets.push(if k < 3 { tet } else { [tet[1], tet[0], tet[2], tet[3]] });
        }
    }
    mesh
}

/// `n` tetrahedra around one edge.
fn fan(n: u32) -> Owned {
    let ring = (0..n).map(|k| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n);
        [3.0 * angle.cos(), 2.0 * angle.sin(), angle.cos() - angle.sin()]
    });
    // The edge runs along a diagonal, so that every box is large.
    let points = [[-9.0, -8.0, -9.0], [9.0, 8.0, 10.0]].into_iter().chain(ring).collect();
    Owned { points, tets: (0..n).map(|k| [0, 1, 2 + k, 2 + (k + 1) % n]).collect() }
}

/// A cone of one apex over an arched patch of 2 n² triangles.
fn cone(n: u32) -> Owned {
    let height = |i: u32, j: u32| f64::from(i * i + j * j) / f64::from(n * n);
    let node = |k: u32| (k % (n + 1), k / (n + 1));
    let mut points: Vec<Point> = (0..(n + 1) * (n + 1))
        .map(node)
        .map(|(i, j)| {
            let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            [x + height(i, j) / 4.0, y - height(i, j) / 8.0, height(i, j) / 2.0]
        })
        .collect();
    let apex = points.len() as u32;
    points.push([4.0, 3.0, 40.0]);
    let quad = |k: u32| {
        let (i, j) = (k % n, k / n);
        let [a, b] = [j, j + 1].map(|j| i + (n + 1) * j);
        [[a, a + 1, b + 1, apex], [a, b + 1, b, apex]]
    };
    Owned { points, tets: (0..n * n).flat_map(quad).collect() }
}

fn slanted([x, y, z]: [f64; 3], long: f64) -> Point {
    [x + long * z, 0.3 * x + y + long * z, long * z - y]
}

#[test]
fn tests_grow_as_n_log_n() {
    let ring = |[x, y, _]: [usize; 3]| !(2..6).contains(&x) || !(2..6).contains(&y);
    let graded = |p: [f64; 3]| p.map(|x| 1.3f64.powf(x) - x / 7.0);
    // Each doubles the number of tetrahedra twice.
    let families: Vec<(&str, [Owned; 3])> = vec![
        ("bars", [32, 64, 128].map(|n| grid([8, 8, n], ring, |p| p))),
        ("plates", [8, 16, 32].map(|n| grid([16, n, 2], |_| true, |p| slanted(p, 1e-3)))),
        ("needles", [8, 16, 32].map(|n| grid([16, n, 1], |_| true, |p| slanted(p, 1e3)))),
        ("graded", [8, 16, 32].map(|n| grid([9, 7, n], ring, graded))),
        ("cells apart", [8, 16, 32].map(|n| grid([4, 5, n], |_| true, |p| p).apart())),
        ("fan", [512, 1024, 2048].map(fan)),
        ("fan apart", [512, 1024, 2048].map(|n| fan(n).apart())),
        ("cone", [16, 23, 32].map(cone)),
        ("cone apart", [16, 23, 32].map(|n| cone(n).apart())),
        (
            "needles apart",
            [8, 16, 32].map(|n| grid([16, n, 1], |_| true, |p| slanted(p, 1e3)).apart()),
        ),
    ];
    for (name, sizes) in families {
        let tests = sizes.each_ref().map(Owned::tests);
        let each = [0, 1, 2].map(|k| tests[k] / sizes[k].tets.len() as u64);
        println!("{name}: {} tets, {tests:?}, {each:?} a tetrahedron", sizes[2].tets.len());
        // n log n: each by 2 and a little, both together by little more than 4.
        assert!(tests[2] < 5 * tests[0], "{name}: {tests:?}");
    }
}
