//! The steps of the search for what lies on facets and edges: they grow as n log n with the domain.

use ltbw_verify::{ConformityDefect, Limits, Mesh, Options, Plc, PlcFacet, VertexOrder, conforms};
use std::collections::HashMap;

type Cell = [i64; 3];

/// The corners of a set of unit cubes, and its tetrahedra: six around the diagonal of each.
#[derive(Default)]
struct Cubes {
    points: Vec<[f64; 3]>,
    tets: Vec<[u32; 4]>,
    number: HashMap<Cell, u32>,
}

impl Cubes {
    fn new(cells: impl Iterator<Item = Cell>) -> Self {
        let mut cubes = Self::default();
        for cell in cells {
            for [x, y] in [[0, 1], [1, 0], [0, 2], [2, 0], [1, 2], [2, 1]] {
                let mut way = [cell; 4];
                (1..4).for_each(|k| way[k][x] += 1);
                (2..4).for_each(|k| way[k][y] += 1);
                way[3][3 - x - y] += 1;
                let tet = way.map(|p| cubes.at(p));
                cubes.tets.push(tet);
            }
        }
        cubes
    }

    fn at(&mut self, p: Cell) -> u32 {
        let next = self.points.len() as u32;
        *self.number.entry(p).or_insert_with(|| {
            self.points.push(p.map(|c| c as f64));
            next
        })
    }

    /// The findings about these facets, and the steps for each of their corners.
    fn steps(&self, facets: Vec<Vec<u32>>) -> f64 {
        let corners: usize = facets.iter().map(Vec::len).sum();
        let found = self.found(facets);
        assert!(found.passed(), "{:?} {:?}", found.findings, found.mesh_defects);
        found.steps as f64 / corners as f64
    }

    fn found(&self, facets: Vec<Vec<u32>>) -> ltbw_verify::Conformity {
        let facet = |ring| PlcFacet { polygons: vec![ring], holes: Vec::new(), marker: 0 };
        let plc = Plc {
            vertices: self.points.clone(),
            facets: facets.into_iter().map(facet).collect(),
            ..Plc::default()
        };
        let mesh = Mesh::new(&self.points, &self.tets);
        let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
        conforms(&mesh, &plc, None, &Limits::default(), &options)
    }
}

/// Steps for each corner may grow as the logarithm does, and by a tenth more.
fn grow_slowly(steps: &[f64]) {
    for pair in steps.windows(2) {
        assert!(pair[1] < 1.3 * pair[0] + 2.0, "{steps:?}");
    }
}

/// A plate of `size`² cubes, its faces in triangles.
fn plate(size: i64) -> (Cubes, Vec<Vec<u32>>) {
    let mut cubes = Cubes::new((0..size * size).map(|k| [k % size, k / size, 0]));
    let mut facets = Vec::new();
    let mut square = |cell: Cell, [x, y]: [usize; 2]| {
        let mut ring = [cell; 4];
        ring[1][x] += 1;
        ring[2][x] += 1;
        ring[2][y] += 1;
        ring[3][y] += 1;
        let [a, b, c, d] = ring.map(|p| cubes.at(p));
        facets.extend([vec![a, b, c], vec![a, c, d]]);
    };
    for k in 0..size {
        for (axis, end) in [(0, 0), (0, size), (1, 0), (1, size)] {
            let mut cell = [k, k, 0];
            cell[axis] = end;
            square(cell, [1 - axis, 2]);
        }
        for l in 0..size {
            square([k, l, 0], [0, 1]);
            square([k, l, 1], [0, 1]);
        }
    }
    (cubes, facets)
}

#[test]
fn planes_of_many_triangles_take_few_steps_for_each() {
    let steps = [8, 16, 32, 64].map(|size| {
        let (cubes, facets) = plate(size);
        cubes.steps(facets)
    });
    grow_slowly(&steps);
}

#[test]
fn a_missing_triangle_of_many_is_found() {
    let (cubes, mut facets) = plate(16);
    facets.remove(600);
    let found = cubes.found(facets);
    assert!(found.count(ConformityDefect::HullFaceOffFacet) == 1, "{:?}", found.findings);
}

/// A comb of cubes: a back, and every other one a tooth.
fn comb(teeth: i64) -> (Cubes, Vec<Vec<u32>>) {
    let back = (0..2 * teeth).map(|x| [x, -1, 0]);
    let mut cubes = Cubes::new(back.chain((0..teeth).map(|k| [2 * k, 0, 0])));
    let mut ring = vec![[2 * teeth, 0], [2 * teeth, -1]];
    ring.extend((0..2 * teeth).rev().map(|x| [x, -1]));
    ring.extend(
        (0..teeth).flat_map(|k| [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(x, y)| [2 * k + x, y])),
    );
    ring.dedup();
    let mut level = |z: i64| ring.iter().map(|&[x, y]| cubes.at([x, y, z])).collect();
    let (low, high): (Vec<u32>, Vec<u32>) = (level(0), level(1));
    let side = |k: usize| {
        let next = (k + 1) % low.len();
        vec![low[k], low[next], high[next], high[k]]
    };
    let sides = (0..low.len()).map(side).collect();
    (cubes, [sides, vec![low.clone(), high.clone()]].concat())
}

#[test]
fn a_facet_of_many_corners_takes_few_steps_for_each() {
    let steps = [64, 128, 256, 512, 1024].map(|teeth| {
        let (cubes, facets) = comb(teeth);
        cubes.steps(facets)
    });
    grow_slowly(&steps);
}

#[test]
fn a_face_outside_a_facet_of_many_corners_is_found() {
    let (cubes, mut facets) = comb(64);
    // The front of the comb goes without the corners of a tooth.
    let front = facets.last_mut().expect("a front");
    let tip = front.iter().position(|&v| cubes.points[v as usize][1] == 1.0).expect("a tooth");
    front.drain(tip..tip + 2);
    let found = cubes.found(facets);
    assert_eq!(found.count(ConformityDefect::HullFaceOffFacet), 2, "{:?}", found.findings);
}
