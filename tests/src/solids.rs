//! Sound finite element meshes of bodies of every shape: with holes and cavities, pinched, in
//! pieces, cracked, of several materials, thin, graded, turned, scaled, mirrored.

use crate::families::{Rng, grid, scaled, spheres, uniform};
use crate::oracle;
use crate::plant::Subject;
use ltbw::refine::Refiner;
use ltbw::{Builder, Point, PointSet, Sign};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::collections::HashMap;

/// A mesh as plain lists.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Solid {
    /// Points; some may be unused.
    pub points: Vec<Point>,
    /// Tetrahedra.
    pub tets: Vec<[u32; 4]>,
}

impl Solid {
    /// The corners of a tetrahedron.
    #[must_use]
    pub fn corners(&self, tet: usize) -> [Point; 4] {
        self.tets[tet].map(|v| self.points[v as usize])
    }

    /// Cubes of the integer grid that `is_there` says are there, of six tetrahedra each.
    fn cubes(count: usize, is_there: impl Fn([usize; 3]) -> bool) -> Self {
        let mut solid = Self::default();
        let mut number = HashMap::new();
        for cell in 0..count.pow(3) {
            let at = [cell % count, cell / count % count, cell / count / count];
            // Along the diagonal, in each order of the axes.
            let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
            for (k, order) in orders.into_iter().enumerate().filter(|_| is_there(at)) {
                let mut corner = at;
                let mut tet = [0; 4];
                for (step, place) in tet.iter_mut().enumerate() {
                    let new = solid.points.len() as u32;
                    *place = *number.entry(corner).or_insert(new);
                    if *place == new {
                        solid.points.push(corner.map(|i| i as f64));
                    }
                    order.get(step).into_iter().for_each(|&axis| corner[axis] += 1);
                }
                solid.tets.push(if k < 3 { tet } else { [tet[1], tet[0], tet[2], tet[3]] });
            }
        }
        solid
    }

    /// This body with vertices of its own for each group of tetrahedra, where `is_split` says so.
    fn split_where(
        &self,
        group: impl Fn(&Self, usize) -> usize,
        is_split: impl Fn(&Point) -> bool,
    ) -> Self {
        let (mut solid, mut number) = (Self::default(), HashMap::new());
        for (t, tet) in self.tets.iter().enumerate() {
            let group = group(self, t);
            let own = tet.map(|v| {
                let group = if is_split(&self.points[v as usize]) { group } else { 0 };
                *number.entry((group, v)).or_insert_with(|| {
                    solid.points.push(self.points[v as usize]);
                    solid.points.len() as u32 - 1
                })
            });
            solid.tets.push(own);
        }
        solid
    }

    /// This body with vertices of its own for each group of tetrahedra.
    #[must_use]
    pub fn split(&self, group: impl Fn(&Self, usize) -> usize) -> Self {
        self.split_where(group, |_| true)
    }

    /// This body with its points elsewhere; `None` if a tetrahedron is no longer positive.
    #[must_use]
    pub fn placed(&self, place: impl Fn(Point) -> Point) -> Option<Self> {
        let points = self.points.iter().map(|&p| place(p)).collect();
        let solid = Self { points, tets: self.tets.clone() };
        let positive = (0..solid.tets.len()).all(|t| {
            let [a, b, c, d] = solid.corners(t);
            oracle::orient3d(&a, &b, &c, &d) == Sign::Positive
        });
        positive.then_some(solid)
    }

    fn of_points(points: Vec<Point>) -> Self {
        let set = PointSet::new(points).expect("finite points");
        let built = Builder::new().build(&set).expect("a set of dimension 3");
        let Subject { points, tets, .. } = Subject::of(&built.mesh);
        Self { points, tets }
    }
}

/// Which half a tetrahedron is in, along an axis.
fn half(axis: usize) -> impl Fn(&Solid, usize) -> usize {
    move |solid, t| usize::from(solid.corners(t).iter().map(|p| p[axis]).sum::<f64>() > 4.0)
}

/// Bodies of cubes, with their names.
fn cubes() -> Vec<(&'static str, Solid)> {
    let sum = |[x, y, z]: [usize; 3]| x + y + z;
    let block = Solid::cubes(2, |_| true);
    let ring = Solid::cubes(3, |[x, y, z]| z == 0 && (x, y) != (1, 1));
    let edge = Solid::cubes(2, |[x, y, z]| z == 0 && x == y);
    let corner = Solid::cubes(2, |at| sum(at) == 0 || sum(at) == 3);
    let mut spare = block.clone();
    spare.points.insert(3, [1.0, 1.0, 0.5]);
    spare.tets.iter_mut().flatten().for_each(|v| *v += u32::from(*v >= 3));
    vec![
        ("block", block.clone()),
        ("one cell", Solid::cubes(1, |_| true).split(|_, t| t)),
        ("ring, a torus", ring.clone()),
        ("cavity", Solid::cubes(3, |at| at != [1; 3])),
        ("pinched edge", edge.clone()),
        ("pinched corner", corner.clone()),
        ("all pinched", Solid::cubes(3, |at| sum(at) % 2 == 0)),
        ("pieces that touch in an edge", edge.split(half(0))),
        ("pieces that touch in a corner", corner.split(half(1))),
        ("pieces", Solid::cubes(3, |[x, _, z]| x != 1 && z == 0)),
        ("concave", Solid::cubes(2, |at| sum(at) < 3)),
        ("crack", block.split(half(2))),
        ("crack that ends", block.split_where(half(2), |p| p[0] > 1.0)),
        ("ring in two parts", ring.split(half(0))),
        (
            "materials",
            block.split(|s, t| {
                let centre =
                    s.corners(t).iter().fold([0.0; 3], |c, p| [0, 1, 2].map(|k| c[k] + p[k]));
                centre.iter().fold(0, |n, &c| 2 * n + usize::from(c > 4.0))
            }),
        ),
        ("every cell apart", block.split(|_, t| t)),
        ("a point that nothing uses", spare),
    ]
}

/// A motion: the new place of each point.
type Placing = fn(Point) -> Point;

/// Places to put a body.
fn places() -> Vec<(&'static str, Placing)> {
    vec![
        ("", |p| p),
        ("turned", |[x, y, z]| {
            [0.36 * x - 0.8 * y + 0.48 * z, 0.48 * x + 0.6 * y + 0.64 * z, -0.8 * x + 0.6 * z]
        }),
        ("slanted needles", |[x, y, z]| [x + 1e3 * z, 0.3 * x + y + 1e3 * z, 1e3 * z - y]),
        ("graded", |p| p.map(|c| 1e3f64.powf(c))),
        ("far away", |[x, y, z]| [x / 3.0 + 1e6, y / 7.0 - 1e6, z / 5.0]),
        ("thin", |[x, y, z]| [x, y, z * 1e-9 + x * 0.25]),
        ("tiny", |p| p.map(|c| c * 2f64.powi(-700) * 2f64.powi(-300))),
        ("huge", |p| p.map(|c| c * 2f64.powi(700))),
    ]
}

/// Sound meshes with their names.
///
/// # Panics
/// If a generator does not do what it does.
#[must_use]
pub fn solids() -> Vec<(String, Solid)> {
    let mut all = Vec::new();
    for (name, solid) in cubes() {
        for (place, put) in places() {
            let placed = solid.placed(put);
            all.extend(placed.map(|solid| (format!("{name} {place}"), solid)));
        }
        // All negative, as some programs write their meshes.
        let mut mirrored = solid;
        mirrored.tets.iter_mut().for_each(|tet| tet.swap(0, 1));
        all.push((format!("{name} mirrored"), mirrored));
    }
    let points = [grid(3), scaled(&grid(3), -400), spheres(&[9]), uniform(40, 3), uniform(12, 4)];
    all.extend(points.into_iter().map(|p| ("points".to_owned(), Solid::of_points(p))));
    for kind in DomainKind::ALL {
        let shape = Shape { count: Some(4), ..Shape::default() };
        let domain = generate_domain(kind, &shape).expect("a domain");
        let refined = Refiner::new().radius_edge(4.0).mesh(&domain).expect("a mesh");
        let inside = refined.inside();
        let solid = Solid { points: inside.points, tets: inside.tets };
        let materials = solid.split(|_, t| Rng::new(t as u64).below(4) as usize);
        all.push((format!("{} at random in four parts", kind.name()), materials));
        all.push((kind.name().to_owned(), solid));
    }
    all
}
