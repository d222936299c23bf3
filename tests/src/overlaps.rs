//! Overlaps planted into sound meshes of any body. Whether what was planted is one says the oracle.

use crate::families::Rng;
use crate::oracle;
use crate::overlap::overlap;
use crate::solids::Solid;
use ltbw::{Point, Sign};

/// Changes a mesh; the tetrahedra that are not as they were. `None` where this plant does not grow.
type Spoil = fn(&mut Solid, &mut Rng) -> Option<Vec<usize>>;

/// Every way, with its name.
pub const OVERLAPS: [(&str, Spoil); 20] = [
    ("copy of a cell with other vertices", |solid, rng| {
        let tet = any(solid, rng);
        cell(solid, solid.corners(tet))
    }),
    ("copy of a cell, moved", |solid, rng| {
        let [a, b, c, d] = solid.corners(any(solid, rng));
        let step = minus(&b, &a);
        cell(solid, [a, b, c, d].map(|p| plus(&p, &step, 0.3)))
    }),
    ("copy of a cell, moved along its face", |solid, rng| {
        let [a, b, c, d] = solid.corners(any(solid, rng));
        let step = minus(&b, &a);
        cell(solid, [a, b, c, d].map(|p| plus(&p, &step, 0.5)))
    }),
    ("cell inside a cell", |solid, rng| resized(solid, rng, 0.25)),
    ("cell around a cell", |solid, rng| resized(solid, rng, 1.5)),
    ("cell moved into another", |solid, rng| {
        let (from, to) = (any(solid, rng), any(solid, rng));
        let step = minus(&centre(&solid.corners(to)), &centre(&solid.corners(from)));
        cell(solid, solid.corners(from).map(|p| plus(&p, &step, 1.0)))
    }),
    ("cell turned about its centre", |solid, rng| {
        let corners = solid.corners(any(solid, rng));
        let o = centre(&corners);
        let turned = |p: Point| {
            let [x, y, z] = minus(&p, &o);
            plus(&o, &[y, z, x], 1.0)
        };
        cell(solid, corners.map(turned))
    }),
    ("vertex dragged through the opposite face", |solid, rng| {
        let (tet, slot) = (any(solid, rng), rng.below(4) as usize);
        let corners = solid.corners(tet);
        let others: Vec<Point> = (0..4).filter(|&k| k != slot).map(|k| corners[k]).collect();
        let step = minus(&centre(&others), &corners[slot]);
        let new = plus(&corners[slot], &step, 1.5);
        moved(solid, solid.tets[tet][slot], new)
    }),
    ("vertex folded into another cell", |solid, rng| {
        let (tet, other) = (any(solid, rng), any(solid, rng));
        let vertex = solid.tets[tet][rng.below(4) as usize];
        moved(solid, vertex, centre(&solid.corners(other)))
    }),
    ("vertex moved to another", |solid, rng| {
        let [v, w] = [any(solid, rng), any(solid, rng)].map(|t| solid.tets[t][0]);
        moved(solid, v, solid.points[w as usize])
    }),
    ("vertex moved by some ulps", |solid, rng| {
        let vertex = solid.tets[any(solid, rng)][rng.below(4) as usize];
        let mut to = solid.points[vertex as usize];
        to.iter_mut().for_each(|c| {
            let bits = c.to_bits() as i64 + rng.below(5) as i64 - 2;
            *c = if *c == 0.0 { *c } else { f64::from_bits(bits as u64) };
        });
        moved(solid, vertex, to)
    }),
    ("the body once more, moved", |solid, rng| {
        let step = minus(&solid.corners(any(solid, rng))[0], &solid.corners(any(solid, rng))[1]);
        body(solid, |p| plus(&p, &step, 0.375))
    }),
    ("the body inside a cell", |solid, rng| {
        let corners = solid.corners(any(solid, rng));
        let (o, from) = (centre(&corners), solid.points[solid.tets[0][0] as usize]);
        body(solid, |p| plus(&o, &minus(&p, &from), 1e-4))
    }),
    ("the body around itself", |solid, _| {
        let o = centre(&solid.points);
        body(solid, |p| plus(&o, &minus(&p, &o), 3.0))
    }),
    ("cell of other vertices of the mesh", |solid, rng| {
        let tet = [0; 4].map(|_| solid.tets[any(solid, rng)][rng.below(4) as usize]);
        let mut sorted = tet;
        sorted.sort_unstable();
        let is_there = |t: &[u32; 4]| {
            let mut t = *t;
            t.sort_unstable();
            t == sorted
        };
        let four = sorted.windows(2).all(|w| w[0] < w[1]);
        (four && !solid.tets.iter().any(is_there)).then(|| push(solid, tet))?
    }),
    ("cell on a face, from anywhere", |solid, rng| {
        let (tet, other, slot) = (any(solid, rng), any(solid, rng), rng.below(4) as usize);
        solid.points.push(centre(&solid.corners(other)));
        let mut new = solid.tets[tet];
        new[slot] = solid.points.len() as u32 - 1;
        push(solid, new)
    }),
    ("cell on a face, outwards", |solid, rng| {
        let (tet, slot) = (any(solid, rng), rng.below(4) as usize);
        let corners = solid.corners(tet);
        let others: Vec<Point> = (0..4).filter(|&k| k != slot).map(|k| corners[k]).collect();
        let step = minus(&centre(&others), &corners[slot]);
        solid.points.push(plus(&corners[slot], &step, 1.25 + 2.0 * rng.unit()));
        let mut new = solid.tets[tet];
        new[slot] = solid.points.len() as u32 - 1;
        push(solid, new)
    }),
    ("needle through all", |solid, rng| {
        let o = centre(&solid.corners(any(solid, rng)));
        let [u, v, w] = [rng.direction(), rng.direction(), rng.direction()];
        let size = extent(solid);
        let thin = 1e-3 * size;
        cell(
            solid,
            [
                plus(&o, &u, -3.0 * size),
                plus(&plus(&o, &u, 3.0 * size), &v, thin),
                plus(&plus(&o, &u, 3.0 * size), &w, thin),
                plus(&plus(&o, &u, 3.0 * size), &v, -thin),
            ],
        )
    }),
    ("cell around all", |solid, _| {
        let (o, size) = (centre(&solid.points), 20.0 * extent(solid));
        let far = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        cell(solid, far.map(|d| plus(&o, &d, size)))
    }),
    ("fan that goes around twice", |solid, rng| {
        let size = extent(solid);
        let o = plus(&solid.points[0], &[4.0, 0.0, 0.0], size);
        let (first, count) = (solid.points.len() as u32, 5 + 2 * rng.below(6) as u32);
        solid.points.extend([o, plus(&o, &[0.0, 0.0, 1.0], size)]);
        solid.points.extend((0..count).map(|k| {
            let angle = 2.0 * std::f64::consts::TAU * f64::from(k) / f64::from(count);
            plus(&o, &[angle.cos(), angle.sin(), 0.5], size)
        }));
        let tet = |k: u32| [first, first + 1, first + 2 + k, first + 2 + (k + 1) % count];
        (0..count).map(|k| push(solid, tet(k))).collect::<Option<Vec<_>>>().map(|all| all.concat())
    }),
];

/// Whether a changed tetrahedron overlaps any other, says the oracle.
#[must_use]
pub fn is_overlapping(solid: &Solid, changed: &[usize]) -> bool {
    let all = 0..solid.tets.len();
    changed
        .iter()
        .any(|&t| all.clone().any(|u| t != u && overlap(solid.corners(t), solid.corners(u))))
}

fn any(solid: &Solid, rng: &mut Rng) -> usize {
    rng.below(solid.tets.len() as u64) as usize
}

fn minus(p: &Point, q: &Point) -> Point {
    [0, 1, 2].map(|k| p[k] - q[k])
}

fn plus(p: &Point, step: &Point, times: f64) -> Point {
    [0, 1, 2].map(|k| p[k] + times * step[k])
}

fn centre(points: &[Point]) -> Point {
    let part = 1.0 / points.len() as f64;
    points.iter().fold([0.0; 3], |sum, p| plus(&sum, p, part))
}

/// The largest difference of coordinates.
fn extent(solid: &Solid) -> f64 {
    let of_axis = |k: usize| {
        let all = || solid.points.iter().map(|p| p[k]);
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    (0..3).map(of_axis).fold(0.0, f64::max)
}

/// A new tetrahedron, turned to the orientation of the first one; `None` if it is flat.
fn push(solid: &mut Solid, [a, b, c, d]: [u32; 4]) -> Option<Vec<usize>> {
    let sign = |solid: &Solid, t: usize| {
        let [a, b, c, d] = solid.corners(t);
        oracle::orient3d(&a, &b, &c, &d)
    };
    let new = solid.tets.len();
    solid.tets.push([a, b, c, d]);
    if sign(solid, new) != sign(solid, 0) {
        solid.tets[new] = [a, b, d, c];
    }
    (sign(solid, new) != Sign::Zero).then(|| vec![new])
}

/// A new tetrahedron with vertices of its own.
fn cell(solid: &mut Solid, corners: [Point; 4]) -> Option<Vec<usize>> {
    let first = solid.points.len() as u32;
    solid.points.extend(corners);
    push(solid, [first, first + 1, first + 2, first + 3])
}

/// A copy of a tetrahedron with the same centre, in another size.
fn resized(solid: &mut Solid, rng: &mut Rng, times: f64) -> Option<Vec<usize>> {
    let corners = solid.corners(any(solid, rng));
    let o = centre(&corners);
    cell(solid, corners.map(|p| plus(&o, &minus(&p, &o), times)))
}

/// The body once more, elsewhere; `None` if it is large.
fn body(solid: &mut Solid, place: impl Fn(Point) -> Point) -> Option<Vec<usize>> {
    let (first, tets) = (solid.points.len() as u32, solid.tets.clone());
    let copies: Vec<Point> = solid.points.iter().map(|&p| place(p)).collect();
    solid.points.extend(copies);
    let copied = |t: &[u32; 4]| push(solid, t.map(|v| v + first));
    let all: Option<Vec<Vec<usize>>> =
        (tets.len() <= 100).then(|| tets.iter().map(copied).collect())?;
    all.map(|all| all.concat())
}

/// A vertex is moved.
fn moved(solid: &mut Solid, vertex: u32, to: Point) -> Option<Vec<usize>> {
    solid.points[vertex as usize] = to;
    Some((0..solid.tets.len()).filter(|&t| solid.tets[t].contains(&vertex)).collect())
}
