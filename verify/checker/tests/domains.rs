//! Meshes of domains with free segments and regions: what the checker says of each by itself.

use ltbw_verify::{
    Conformity, ConformityDefect, Limits, Mesh, Options, Plc, PlcFacet, Point, VertexOrder,
    conforms,
};

fn facets(all: &[[u32; 3]]) -> Vec<PlcFacet> {
    all.iter().map(|f| PlcFacet { polygons: vec![f.to_vec()], ..PlcFacet::default() }).collect()
}

/// The checker's counts.
fn counted(found: &Conformity) -> Vec<(ConformityDefect, u64)> {
    assert_eq!(found.mesh_defect_count, 0, "{:?}", found.mesh_defects);
    found.counts.iter().map(|(&breach, &count)| (breach, count)).collect()
}

/// Two poles, 0 and 1, far from and close to a triangle between them, and the points on the line
/// from pole to pole that follow.
fn poles(height: f64, between: &[f64]) -> Vec<Point> {
    let mut points = vec![[0.0, 0.0, -height], [0.0, 0.0, height]];
    points.extend([[4.0, 0.0, 0.0], [-2.0, 3.0, 0.0], [-2.0, -3.0, 0.0]]);
    points.extend(between.iter().map(|&z| [0.0, 0.0, z]));
    points
}

const SIDES: [[u32; 3]; 6] = [[0, 2, 3], [0, 3, 4], [0, 4, 2], [1, 3, 2], [1, 4, 3], [1, 2, 4]];

fn of_poles(points: &[Point], tets: &[[u32; 4]], segments: &[[u32; 2]]) -> Conformity {
    let plc = Plc {
        vertices: points.to_vec(),
        facets: facets(&SIDES),
        segments: segments.to_vec(),
        ..Plc::default()
    };
    let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
    conforms(&Mesh::new(points, tets), &plc, None, &Limits::default(), &options)
}

#[test]
fn a_free_segment_must_be_a_chain_of_edges() {
    // Poles far from the triangle: it is a face, and the line between them no edge.
    let far = poles(8.0, &[]);
    let two = [[0, 2, 3, 4], [1, 2, 3, 4]];
    assert_eq!(counted(&of_poles(&far, &two, &[])), []);
    let found = of_poles(&far, &two, &[[0, 1]]);
    assert_eq!(counted(&found), [(ConformityDefect::SegmentBroken, 1)]);
    assert_eq!(found.findings[0].ids, [0, 1]);
    // An edge of a facet is one of the mesh, with and without a segment there.
    assert_eq!(counted(&of_poles(&far, &two, &[[0, 2], [3, 2]])), []);
    // Poles close to it: the line is an edge.
    let close = poles(1.0, &[]);
    let three = [[0, 1, 2, 3], [0, 1, 3, 4], [0, 1, 4, 2]];
    assert_eq!(counted(&of_poles(&close, &three, &[[0, 1], [1, 0]])), []);
    // A vertex half-way, in the plane of the triangle: a chain of two edges.
    let half = poles(8.0, &[0.0]);
    let around = |pole| [[pole, 2, 3, 5], [pole, 3, 4, 5], [pole, 4, 2, 5]];
    let six = [around(0), around(1)].concat();
    assert_eq!(counted(&of_poles(&half, &six, &[[1, 0]])), []);
    assert_eq!(counted(&of_poles(&half, &six, &[[0, 5], [5, 1]])), []);
}

/// A box of three cells along x, each of six tetrahedra around the diagonal of a cell.
struct Cells {
    plc: Plc,
    points: Vec<Point>,
    tets: Vec<[u32; 4]>,
    /// The cell of each tetrahedron.
    cells: Vec<usize>,
}

impl Cells {
    /// Seeds in these cells.
    fn new(seeds: &[usize]) -> Self {
        let at = |k: u32| [f64::from(k >> 2), f64::from(k >> 1 & 1), f64::from(k & 1)];
        let points: Vec<Point> = (0..16).map(at).collect();
        let (mut tets, mut cells) = (Vec::new(), Vec::new());
        for cell in 0..3u32 {
            let paths = [[4, 2, 1], [4, 1, 2], [2, 4, 1], [2, 1, 4], [1, 4, 2], [1, 2, 4]];
            for [a, b, c] in paths {
                let first = 4 * cell;
                tets.push([first, first + a, first + a + b, first + a + b + c]);
                cells.push(cell as usize);
            }
        }
        // Walls x = 0 to 3, and four sides.
        let wall = |x: u32| vec![4 * x, 4 * x + 1, 4 * x + 3, 4 * x + 2];
        let side = |a: u32, b: u32| vec![a, b, 12 + b, 12 + a];
        let rings = (0..4).map(wall).chain([side(0, 1), side(1, 3), side(3, 2), side(2, 0)]);
        let facet = |ring| PlcFacet { polygons: vec![ring], ..PlcFacet::default() };
        let plc = Plc {
            vertices: points.clone(),
            facets: rings.map(facet).collect(),
            regions: seeds.iter().map(|&cell| [cell as f64 + 0.5, 0.375, 0.625]).collect(),
            ..Plc::default()
        };
        Self { plc, points, tets, cells }
    }

    /// The checker's counts where the tetrahedra of each cell have its tag.
    fn with_tags(&self, of: [i64; 3], numbered: bool) -> Vec<(ConformityDefect, u64)> {
        let tags: Vec<i64> = self.cells.iter().map(|&cell| of[cell]).collect();
        let options = Options {
            vertex_order: VertexOrder::Any,
            numbered_regions: numbered,
            ..Options::default()
        };
        let mesh = Mesh::new(&self.points, &self.tets);
        let found = conforms(&mesh, &self.plc, Some(&tags), &Limits::default(), &options);
        assert_eq!(found.cells, 3);
        counted(&found)
    }
}

#[test]
fn tags_are_the_numbers_that_the_seeds_give() {
    use ConformityDefect::TagNotOfSeed;
    // By the order of the seeds, not of the cells.
    let all = Cells::new(&[1, 2, 0]);
    assert_eq!(all.with_tags([3, 1, 2], true), []);
    assert_eq!(all.with_tags([2, 1, 3], true), [(TagNotOfSeed, 12)], "two are swapped");
    assert_eq!(all.with_tags([3, 1, 1], true), [(TagNotOfSeed, 6)]);
    // Names of somebody else's.
    assert_eq!(all.with_tags([2, 1, 3], false), []);
    // Two seeds in one cell: the second gives no number. A cell without one has a higher number.
    let some = Cells::new(&[2, 2, 0]);
    assert_eq!(some.with_tags([2, 3, 1], true), []);
    assert_eq!(some.with_tags([2, 77, 1], true), []);
    assert_eq!(some.with_tags([3, 2, 1], true), [(TagNotOfSeed, 12)]);
    assert_eq!(some.with_tags([2, 2, 1], true), [(TagNotOfSeed, 6)]);
    assert_eq!(some.with_tags([2, 0, 1], true), [(TagNotOfSeed, 6)]);
}
