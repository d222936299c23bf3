//! Items with nothing but exterior around them are not asked for, and excuse nothing else.

use crate::common::domain::Judged;
use ltbw_verify::{
    Conformity, ConformityDefect, Limits, Mesh, Options, Plc, PlcFacet, VertexOrder,
};

const SIDES: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// A domain that grows by boxes and other facets; equal vertices are one.
#[derive(Default)]
struct Built(Plc);

impl Built {
    fn vertex(&mut self, p: [f64; 3]) -> u32 {
        let known = self.0.vertices.iter().position(|v| *v == p);
        known.unwrap_or_else(|| {
            self.0.vertices.push(p);
            self.0.vertices.len() - 1
        }) as u32
    }

    fn facet(&mut self, polygons: &[&[[f64; 3]]], holes: &[[f64; 3]]) {
        let mut ring = |ring: &&[[f64; 3]]| ring.iter().map(|p| self.vertex(*p)).collect();
        let polygons: Vec<Vec<u32>> = polygons.iter().map(&mut ring).collect();
        let holes = holes.to_vec();
        // Equal facets of boxes side by side are one.
        let key = |polygons: &[Vec<u32>]| {
            let mut all = polygons.concat();
            all.sort_unstable();
            all
        };
        if self.0.facets.iter().all(|f| key(&f.polygons) != key(&polygons)) {
            self.0.facets.push(PlcFacet { polygons, holes, marker: 0 });
        }
    }

    fn cuboid(&mut self, low: [f64; 3], high: [f64; 3]) {
        let at = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] });
        SIDES.iter().for_each(|side| self.facet(&[&side.map(at)], &[]));
    }

    /// The unit cube.
    fn cube() -> Self {
        let mut built = Self::default();
        built.cuboid([0.0; 3], [1.0; 3]);
        built
    }
}

/// Unit cubes at these places along x, each in six tetrahedra.
fn mesh(places: &[f64]) -> (Vec<[f64; 3]>, Vec<[u32; 4]>) {
    let (mut points, mut tets): (Vec<[f64; 3]>, Vec<[u32; 4]>) = Default::default();
    for &x in places {
        let corner = |i: u32| [x + f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)];
        let numbers: Vec<u32> = (0..8)
            .map(|i| {
                let known = points.iter().position(|p| *p == corner(i));
                known.unwrap_or_else(|| {
                    points.push(corner(i));
                    points.len() - 1
                }) as u32
            })
            .collect();
        for [a, b] in [[1, 2], [2, 1], [1, 4], [4, 1], [2, 4], [4, 2]] {
            tets.push([0, a, a + b, 7].map(|i| numbers[i as usize]));
        }
    }
    (points, tets)
}

fn judged(domain: &Built, places: &[f64]) -> Conformity {
    let (points, tets) = mesh(places);
    let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
    let (mesh, limits) = (Mesh::new(&points, &tets), Limits::default());
    Judged { mesh: &mesh, plc: &domain.0, tags: None, limits: &limits, options: &options }
        .conforms()
}

fn passes(domain: &Built, places: &[f64]) {
    let found = judged(domain, places);
    assert!(found.passed(), "{:?} {:?}", found.findings, found.mesh_defects);
}

fn fails(domain: &Built, places: &[f64], by: ConformityDefect) {
    let found = judged(domain, places);
    assert!(found.count(by) > 0, "{:?} {:?}", found.findings, found.mesh_defects);
}

use ConformityDefect::{FacetNotTiled, SegmentBroken, VertexMissing};

#[test]
fn vertices_outside_are_not_asked_for_and_those_inside_are() {
    let mut domain = Built::cube();
    passes(&domain, &[0.0]);
    domain.0.vertices.extend([[3.0; 3], [0.5, 0.5, 1.25], [-1.0, 0.0, 0.0]]);
    passes(&domain, &[0.0]);
    domain.0.vertices.push([0.5, 0.25, 0.25]);
    let found = judged(&domain, &[0.0]);
    assert_eq!(found.counts.iter().collect::<Vec<_>>(), [(&VertexMissing, &1)]);
    assert_eq!(found.findings[0].ids, [11]);
}

/// Sheets that hang on an edge of the cube, bent, with a hole, or on nothing.
fn fins() -> Vec<Built> {
    let sheet = |add: &dyn Fn(&mut Built)| {
        let mut domain = Built::cube();
        add(&mut domain);
        domain
    };
    let (low, high) = ([1.0, 0.0, 1.0], [1.0, 1.0, 1.0]);
    let quad: [[f64; 3]; 4] = [low, [2.0, 0.0, 2.0], [2.0, 1.0, 2.0], high];
    let bent: [[f64; 3]; 4] = [quad[1], [3.0, 0.0, 2.0], [3.0, 1.0, 2.0], quad[2]];
    let inner: [[f64; 3]; 3] = [[1.25, 0.25, 1.25], [1.75, 0.25, 1.75], [1.75, 0.75, 1.75]];
    vec![
        sheet(&|d| d.facet(&[&quad], &[])),
        sheet(&|d| {
            d.facet(&[&quad], &[]);
            d.facet(&[&bent], &[]);
        }),
        sheet(&|d| d.facet(&[&quad, &inner], &[[1.6875, 0.375, 1.6875]])),
        sheet(&|d| d.facet(&[&quad, &[low, quad[2]]], &[])),
        sheet(&|d| d.facet(&[&bent], &[])),
        sheet(&|d| {
            d.facet(&[&quad], &[]);
            let ends = [[1.5, 0.5, 0.5], [1.0, 1.0, 1.0]].map(|p| d.vertex(p));
            d.0.segments.push(ends);
        }),
    ]
}

#[test]
fn sheets_outside_are_not_asked_for_and_excuse_nothing_else() {
    for mut domain in fins() {
        passes(&domain, &[0.0]);
        // A body beside that the mesh lacks, and a segment.
        let facets = domain.0.facets.len();
        domain.cuboid([-1.0, 0.0, 0.0], [0.0, 1.0, 1.0]);
        fails(&domain, &[0.0], VertexMissing);
        fails(&domain, &[0.0], FacetNotTiled);
        passes(&domain, &[-1.0, 0.0]);
        domain.0.facets.truncate(facets);
        domain.0.vertices.push([0.5, 0.5, 0.125]);
        fails(&domain, &[0.0], VertexMissing);
        domain.0.vertices.pop();
        let ends = [[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]].map(|p| domain.vertex(p));
        domain.0.segments.push(ends);
        fails(&domain, &[0.0], SegmentBroken);
    }
}

#[test]
fn voids_at_and_beyond_the_outside_are_not_asked_for() {
    for x in [1.0, 2.0] {
        let mut domain = Built::cube();
        domain.cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        // Without a hole point it is a body.
        fails(&domain, &[0.0], FacetNotTiled);
        passes(&domain, &[0.0, x]);
        domain.0.holes.push([x + 0.5, 0.5, 0.5]);
        passes(&domain, &[0.0]);
        // And with one it must not be meshed.
        fails(&domain, &[0.0, x], ConformityDefect::HoleMeshed);
        // Another beside it is a body until there is a hole point in it, too.
        domain.cuboid([x, 0.0, 1.0], [x + 1.0, 1.0, 2.0]);
        fails(&domain, &[0.0], FacetNotTiled);
        domain.0.holes.push([x + 0.5, 0.25, 1.125]);
        passes(&domain, &[0.0]);
    }
}

#[test]
fn a_wall_between_two_bodies_is_asked_for() {
    let mut domain = Built::cube();
    domain.cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]);
    passes(&domain, &[0.0, 1.0]);
    // A wall that the mesh does not have.
    let at = |y: f64, z: f64| [0.5, y, z];
    domain.facet(&[&[at(0.25, 0.25), at(0.75, 0.25), at(0.75, 0.75)]], &[]);
    fails(&domain, &[0.0, 1.0], FacetNotTiled);
}

#[test]
fn shells_inside_are_asked_for_whether_they_are_bodies_or_voids() {
    for hole in [false, true] {
        let mut domain = Built::cube();
        domain.cuboid([0.25; 3], [0.75; 3]);
        if hole {
            domain.0.holes.push([0.5; 3]);
        }
        fails(&domain, &[0.0], VertexMissing);
        fails(&domain, &[0.0], FacetNotTiled);
    }
}

/// A surface that seems open, for a vertex lies inside an edge that does not name it, is no reason
/// to take its body for nothing.
#[test]
fn a_body_with_a_t_junction_is_asked_for() {
    let mut domain = Built::cube();
    domain.cuboid([2.0, 0.0, 0.0], [3.0, 1.0, 1.0]);
    let v = domain.vertex([2.0, 0.5, 1.0]);
    let side = domain
        .0
        .facets
        .iter_mut()
        .rev()
        .find(|f| f.polygons[0].iter().all(|&v| domain.0.vertices[v as usize][0] == 2.0));
    let ring = &mut side.expect("a side of the second cube").polygons[0];
    let at = |v: u32| domain.0.vertices[v as usize];
    let k = (0..4).find(|&k| at(ring[k])[2] + at(ring[(k + 1) % 4])[2] == 2.0).expect("an edge");
    ring.insert(k + 1, v);
    fails(&domain, &[0.0], VertexMissing);
    fails(&domain, &[0.0], FacetNotTiled);
}

/// Where nothing is bounded nothing is left out: a mesh of it is none of it.
#[test]
fn an_open_surface_is_all_asked_for() {
    let mut domain = Built::cube();
    let lid = domain.0.facets.remove(1);
    fails(&domain, &[2.0], FacetNotTiled);
    domain.0.facets.insert(1, lid);
    passes(&domain, &[0.0]);
}

/// Holes and spare vertices at places where axes and diagonals meet edges and corners.
#[test]
fn places_that_look_at_edges_are_found_all_the_same() {
    let mut domain = Built::cube();
    for (k, x) in [2.0, 4.0, 6.0].into_iter().enumerate() {
        domain.cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        let c = [0.5, 0.25, 0.125][k];
        domain.0.holes.push([x + c, c, c]);
        domain.0.vertices.push([x + 0.5, -1.0, 0.0]);
        domain.0.vertices.push([x + 0.5, 0.5, 2.0]);
    }
    passes(&domain, &[0.0]);
}
