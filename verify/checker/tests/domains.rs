//! Meshes of domains with free segments and regions: what the checker says of each by itself.

use crate::common::domain::Judged;
use crate::common::team::{Lost, on_team};
use ltbw_verify::{
    Conformity, ConformityDefect, DomainPart, Exchange, Limits, Mesh, Options, Plc, PlcFacet,
    Point, VertexOrder, conforms_parted,
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
    let (mesh, limits) = (Mesh::new(points, tets), Limits::default());
    Judged { mesh: &mesh, plc: &plc, tags: None, limits: &limits, options: &options }.conforms()
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
        let (tags, limits) = (Some(&tags[..]), Limits::default());
        let judged =
            Judged { mesh: &mesh, plc: &self.plc, tags, limits: &limits, options: &options };
        let found = judged.conforms();
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

/// A change of a domain, and what the checker finds then.
type Planted<'p> = (&'p dyn Fn(&mut Plc), &'p [ConformityDefect]);

/// Breaches of every kind, wherever the parts of the mesh end.
#[test]
fn planted_breaches_are_found_whole_and_in_parts() {
    use ConformityDefect::*;
    let sound = Cells::new(&[0, 1, 2]);
    let tags: Vec<i64> = sound.cells.iter().map(|&cell| cell as i64 + 1).collect();
    let usual =
        Options { vertex_order: VertexOrder::Any, numbered_regions: true, ..Options::default() };
    let judge = |own: &Cells, tags: &[i64], limits: &Limits| {
        let mesh = Mesh::new(&own.points, &own.tets);
        let judged =
            Judged { mesh: &mesh, plc: &own.plc, tags: Some(tags), limits, options: &usual };
        judged.conforms()
    };
    let none = Limits::default();
    assert!(judge(&sound, &tags, &none).passed());

    // The domain, the tags, the limits.
    let in_domain: [Planted<'_>; 8] = [
        (&|plc| plc.holes.push([1.5, 0.375, 0.625]), &[HoleMeshed]),
        (&|plc| plc.regions.push([9.0; 3]), &[RegionNotMeshed]),
        (&|plc| plc.vertices.push([0.25, 0.5, 0.5]), &[VertexMissing]),
        (&|plc| plc.segments.push([1, 2]), &[SegmentBroken]),
        (&|plc| plc.segments.push([0, 13]), &[SegmentBroken]),
        (&|plc| _ = plc.facets.remove(1), &[TagsDiffer, TagNotOfSeed]),
        (&|plc| _ = plc.facets.remove(0), &[HullFaceOffFacet]),
        (&|plc| plc.vertices[0][0] = 2f64.powi(-70), &[TooFine]),
    ];
    for (plant, expected) in in_domain {
        let mut own = Cells::new(&[0, 1, 2]);
        plant(&mut own.plc);
        let found = judge(&own, &tags, &none);
        let kinds: Vec<ConformityDefect> = found.counts.keys().copied().collect();
        assert_eq!(kinds, expected, "{:?}", found.findings);
    }
    for t in 0..tags.len() {
        let mut other = tags.clone();
        other[t] = 9;
        let found = judge(&sound, &other, &none);
        assert!(found.count(TagsDiffer) > 0 && found.count(TagNotOfSeed) == 1, "{t}");
    }
    for (limits, kind) in [
        (Limits { max_volume: Some(0.125), ..Limits::default() }, VolumeExceeded),
        (Limits { max_edge: Some(1.5), ..Limits::default() }, EdgeExceeded),
        (Limits { radius_edge: Some(0.75), ..Limits::default() }, RatioExceeded),
        (Limits { region_volumes: vec![None, Some(0.125)], ..Limits::default() }, VolumeExceeded),
    ] {
        let found = judge(&sound, &tags, &limits);
        let expected = if limits.region_volumes.is_empty() { 18 } else { 6 };
        assert_eq!(counted(&found), [(kind, expected)]);
    }
    let limits = Limits { min_dihedral: Some(60.0), ..Limits::default() };
    let small = judge(&sound, &tags, &limits).below_dihedral.expect("angles");
    assert_eq!(small.count, 18);

    // The mesh: a tetrahedron is missing, or there twice, or turned over its wall, or flat.
    for t in 0..tags.len() {
        let plant = |how: &dyn Fn(&mut Cells, &mut Vec<i64>)| {
            let (mut own, mut tags) = (Cells::new(&[0, 1, 2]), tags.clone());
            how(&mut own, &mut tags);
            judge(&own, &tags, &none)
        };
        let missing = plant(&|own, tags| {
            own.tets.remove(t);
            tags.remove(t);
        });
        assert!(missing.count(HullFaceOffFacet) + missing.count(FacetNotTiled) > 0, "{t}");
        let twice = plant(&|own, tags| {
            own.tets.push(own.tets[t]);
            tags.push(tags[t]);
        });
        assert!(twice.mesh_defect_count > 0, "{t}");
        let wall = [0, 1, 2, 3].map(|k| 4 * (t as u32 / 6) + k);
        let flat = plant(&|own, _| own.tets[t] = wall);
        assert!(!flat.passed(), "{t}");
        let torn = plant(&|own, _| {
            let v = own.tets[t][1];
            own.points.push(own.points[v as usize]);
            own.tets[t][1] = own.points.len() as u32 - 1;
        });
        assert!(torn.mesh_defect_count > 0, "a vertex that is there twice: {t}");
    }
}

/// The numbers of vertices, which nobody sorts by, have to be those of one place each.
#[test]
fn numbers_that_parts_do_not_agree_upon_are_found() {
    let own = Cells::new(&[]);
    for swapped in [false, true] {
        let all = on_team(2, |team| {
            let me = team.me();
            let tets: Vec<[u32; 4]> = own.tets.iter().skip(me).step_by(2).copied().collect();
            let mut numbers: Vec<u32> = (0..16).collect();
            if swapped && me == 1 {
                numbers.swap(5, 6);
            }
            let part =
                DomainPart { points: &own.points, numbers: &numbers, tets: &tets, tags: None };
            let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
            conforms_parted(team, &part, &own.plc, &Limits::default(), &options)
        });
        for found in all {
            let found = found.expect("findings");
            assert_eq!(found.mesh_defect_count > 0, swapped, "{:?}", found.mesh_defects);
            assert_eq!(found.passed(), !swapped, "{:?}", found.findings);
        }
    }
}

/// Whatever a member sends in place of what it has to: an error that names it, or findings.
#[test]
fn bytes_that_make_no_sense_are_refused_by_name() {
    let own = Cells::new(&[0, 1, 2]);
    let cut: fn(&mut Vec<u8>) = |bytes| _ = bytes.pop();
    let wild: fn(&mut Vec<u8>) = |bytes| bytes.iter_mut().for_each(|byte| *byte ^= 0xa5);
    let mut refused = 0;
    for k in 0..64 {
        for how in [cut, wild] {
            let ends = on_team(3, |team| {
                let me = team.me();
                if me == 1 {
                    team.garble(k, how);
                }
                let tets: Vec<[u32; 4]> = own.tets.iter().skip(me).step_by(3).copied().collect();
                let numbers: Vec<u32> = (0..16).collect();
                let points = &own.points;
                let part = DomainPart { points, numbers: &numbers, tets: &tets, tags: None };
                let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
                conforms_parted(team, &part, &own.plc, &Limits::default(), &options).map(drop)
            });
            refused += ends.iter().filter(|end| end.is_err()).count();
            let is_named =
                |end: &Result<(), Lost>| !matches!(end, Err(Lost::Nonsense(from, _)) if *from != 1);
            assert!(ends.iter().all(is_named), "{k}: {ends:?}");
        }
    }
    assert!(refused > 20, "{refused}");
}
