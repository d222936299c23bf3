//! Items with nothing but exterior around them are left out; bodies in bodies; and refusals.

use crate::common::{check, cubes};
use ltbw_domain::exterior::LEFT_OUT;
use ltbw_domain::{
    CheckOptions, DefectKind, Domain, Facet, Frame, Holes, PrepareError, PrepareOptions, Prepared,
    Region, TroubleKind,
};
use ltbw_exact::Point;

fn prepared(domain: &Domain, oriented: bool) -> Prepared {
    let options = PrepareOptions { oriented, ..PrepareOptions::default() };
    let prepared = domain.prepare(&options).unwrap();
    // The rest has nothing to leave out, and is the same once more.
    assert!(prepared.report.exterior.is_empty());
    let again = prepared.domain.prepare(&PrepareOptions::default()).unwrap();
    assert_eq!((&again.domain, &again.whole), (&prepared.domain, &None));
    let strict = domain.prepare(&PrepareOptions { strict: true, ..options });
    assert_eq!(strict.is_ok(), prepared.notes().is_empty());
    prepared
}

fn volume(prepared: &Prepared) -> String {
    prepared.report.volume().unwrap().to_string()
}

/// Adds a facet with vertices of its own.
fn add(domain: &mut Domain, rings: &[&[Point]]) {
    let polygons = rings.iter().map(|ring| {
        let first = domain.vertices.len() as u32;
        domain.vertices.extend(ring.iter());
        (first..first + ring.len() as u32).collect()
    });
    let polygons = polygons.collect();
    domain.facets.push(Facet { polygons, holes: Vec::new(), marker: 5 });
}

#[test]
fn vertices_outside_are_left_out_and_the_lattice_does_not_reach_for_them() {
    let mut domain = cubes(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).welded().domain;
    let kept = domain.vertices.len();
    // Far outside, in the notch between the cubes, inside, and beside.
    let spare = [[1e7, 3.0, 3.0], [1.75, 1.5, 0.5], [0.5, 0.25, 0.25], [0.0, 0.0, -1e-3]];
    domain.vertices.extend(spare);
    domain.vertices.rotate_right(2);
    let turn = |v: &mut u32| *v += 2;
    domain.facets.iter_mut().flat_map(|f| f.polygons.iter_mut().flatten()).for_each(turn);
    let ready = prepared(&domain, true);
    assert_eq!(ready.domain.vertices.len(), kept + 1);
    assert_eq!(ready.repairs.exterior_vertices, 3);
    assert_eq!(ready.lattice.step(), 2.0_f64.powi(-25));
    assert_eq!(volume(&ready), "3");
    for (v, &number) in ready.vertex_map.iter().enumerate() {
        match ready.domain.vertices.get(number as usize) {
            Some(place) => assert_eq!(*place, domain.vertices[v]),
            None => assert!(number == LEFT_OUT && spare.contains(&domain.vertices[v]), "{v}"),
        }
    }
    // A judge is given the one that only the shape of the body tells to be outside.
    assert_eq!(ready.judged().vertices.len(), kept + 2);
    let notes = ready.notes();
    assert!(notes.iter().any(|n| n.starts_with("3 vertices left out: outside")), "{notes:?}");
    // Numbers in refusals are those of the input.
    domain.vertices[7] = domain.vertices[7].map(|c| c + 1e-9);
    let exact = PrepareOptions { exact_input: true, ..PrepareOptions::default() };
    let error = domain.prepare(&exact).unwrap_err().to_string();
    assert!(error.contains("; vertex 7 at"), "{error}");
}

/// Sheets outside the unit cube: each with the number of its facets.
fn sheets() -> Vec<(Domain, usize)> {
    let (low, high) = ([1.0, 0.0, 1.0], [1.0, 1.0, 1.0]);
    let quad = [low, [2.0, 0.0, 1.5], [2.0, 1.0, 1.5], high];
    let bent = [quad[1], [3.0, 0.0, 1.0], [3.0, 1.0, 1.0], quad[2]];
    let inner: [Point; 3] = [[1.25, 0.25, 1.125], [1.75, 0.25, 1.375], [1.75, 0.75, 1.375]];
    let with = |facets: &[&[&[Point]]]| {
        let mut domain = cubes(&[[0.0; 3]]);
        facets.iter().for_each(|rings| add(&mut domain, rings));
        (domain, facets.len())
    };
    let mut holed = with(&[&[&quad, &inner]]);
    holed.0.facets[6].holes.push([1.6875, 0.375, 1.34375]);
    vec![
        with(&[&[&quad]]),
        with(&[&[&quad], &[&bent]]),
        holed,
        with(&[&[&bent]]),
        with(&[&[&quad[..3]], &[&[quad[2], high, low]]]),
        with(&[
            &[&quad],
            &[&quad.map(|[x, y, z]| [1.0 - x, y, z])],
            &[&bent.map(|[x, y, z]| [x, y, z + 3.0])],
        ]),
    ]
}

#[test]
fn sheets_that_end_outside_are_left_out_with_a_note() {
    for (n, (domain, count)) in sheets().into_iter().enumerate() {
        for oriented in [false, true] {
            let ready = prepared(&domain, oriented);
            assert_eq!(ready.repairs.ends, (6..6 + count as u32).collect::<Vec<_>>(), "{n}");
            assert_eq!((ready.domain.facets.len(), volume(&ready).as_str()), (6, "1"), "{n}");
            assert_eq!(ready.domain.vertices.len(), 8, "{n}");
            assert_eq!(ready.judged().facets.len(), 6 + count, "{n}");
            let strict = PrepareOptions { oriented, strict: true, ..PrepareOptions::default() };
            let error = domain.prepare(&strict).unwrap_err();
            assert_eq!(error.code(), "domain.strict");
            assert!(error.to_string().contains("ends in the exterior"), "{error}");
            let report = check(&domain.clone().welded().domain, oriented);
            assert_eq!(report.count(DefectKind::EndsOutside), count as u64, "{n}");
            assert!(report.is_meshable() && !report.passed());
        }
    }
}

#[test]
fn gaps_are_no_ends_of_sheets() {
    // Two bodies beside each other or apart, of which the second lacks a side.
    for (x, missing) in [(1.0, 7), (1.0, 8), (1.0, 11), (3.0, 7), (3.0, 10)] {
        for oriented in [false, true] {
            let mut domain = cubes(&[[0.0; 3], [x, 0.0, 0.0]]);
            domain.facets.remove(missing);
            let options = PrepareOptions { oriented, ..PrepareOptions::default() };
            let error = domain.prepare(&options).unwrap_err();
            let report = error.report().unwrap();
            assert!(report.count(DefectKind::Leak) >= 3, "{x} {missing}: {error}");
            assert_eq!(report.troubles[0].kind, TroubleKind::Open);
        }
    }
    // A triangle out of a ball beside a body.
    let mut domain = cubes(&[[0.0; 3]]);
    let ball = ltbw_generate::surfaces::globe(8, 12, 0.0, 1);
    let far = ball.vertices.iter().map(|p| [p[0] + 9.0, p[1], p[2]]).collect();
    domain = domain.join(Domain { vertices: far, ..ball });
    assert_eq!(prepared(&domain, true).report.cells.unwrap().len(), 2);
    domain.facets.pop();
    assert!(domain.prepare(&PrepareOptions::default()).is_err());
}

#[test]
fn voids_at_and_beyond_the_outside_are_left_out() {
    for x in [1.0, 3.0] {
        let mut domain = cubes(&[[0.0; 3], [x, 0.0, 0.0]]);
        domain.holes.push([x + 0.5, 0.5, 0.5]);
        let ready = prepared(&domain, false);
        assert_eq!((ready.domain.facets.len(), volume(&ready).as_str()), (6, "1"));
        assert_eq!((ready.domain.vertices.len(), ready.domain.holes.len()), (8, 0));
        assert_eq!(ready.repairs.exterior.len(), if x == 1.0 { 5 } else { 6 });
        assert_eq!(ready.judged().holes, domain.holes);
        // It may hold a body.
        let body = Domain::cuboid([x + 0.125, 0.125, 0.125], [x + 0.375, 0.375, 0.375]);
        let ready = prepared(&domain.clone().join(body), false);
        assert_eq!(volume(&ready), "65/64");
        // A second void behind a wall in the first one.
        let mut two = domain.clone().join(cubes(&[[x + 1.0, 0.0, 0.0]]));
        two.holes.push([x + 1.5, 0.5, 0.5]);
        assert_eq!(volume(&prepared(&two, false)), "1");
    }
}

/// A void whose floor is one facet with the body's: the facet is cut.
#[test]
fn a_facet_that_goes_on_beyond_the_body_is_cut() {
    let mut domain = cubes(&[[0.0; 3], [1.0, 0.0, 0.0]]).welded().domain;
    let at = |p: Point| domain.vertices.iter().position(|v| *v == p).unwrap() as u32;
    let bottom = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(at);
    let middle = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]].map(at);
    let [a, b, c, d] = bottom;
    let [p, q] = middle;
    let is_bottom =
        |f: &Facet| f.polygons[0].iter().all(|v| domain.vertices[*v as usize][2] == 0.0);
    let mut facets: Vec<Facet> = domain.facets.iter().filter(|f| !is_bottom(f)).cloned().collect();
    // The wall between is there twice.
    facets.retain(|f| f.polygons[0].iter().any(|v| domain.vertices[*v as usize][0] != 1.0));
    let wall = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]].map(at);
    facets.push(Facet::polygon(&wall, 0));
    let floor = vec![vec![a, p, b, c, q, d], vec![p, q]];
    facets.push(Facet { polygons: floor, holes: Vec::new(), marker: 7 });
    domain.facets = facets;
    assert_eq!(volume(&prepared(&domain, false)), "2");
    domain.holes.push([1.5, 0.5, 0.5]);
    let ready = prepared(&domain, false);
    assert_eq!(volume(&ready), "1");
    let cut = ready.domain.facets.iter().filter(|f| f.marker == 7).count();
    assert_eq!((cut, ready.domain.segments.len()), (2, 1));
}

/// The unit cube, and pairs of opposite triangles that stand on its edges.
fn flapped(flaps: &[[Point; 3]]) -> Domain {
    let mut domain = cubes(&[[0.0; 3]]);
    for flap in flaps {
        add(&mut domain, &[flap]);
        add(&mut domain, &[&[flap[2], flap[1], flap[0]]]);
    }
    domain
}

#[test]
fn pairs_of_opposite_facets_with_nothing_between_are_left_out() {
    let (a, b) = ([1.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
    let cases: [&[[Point; 3]]; 5] = [
        &[[a, [2.0, 0.0, 2.0], b]],
        &[[a, [2.0, 0.0, 2.0], b], [a, [3.0, 0.0, 1.0], [2.0, 0.0, 2.0]]],
        &[[a, [2.0, 0.0, 2.0], b], [a, b, [0.5, -1.0, 1.0]]],
        // Inside, and in both.
        &[[a, [0.5, 0.5, 0.5], b]],
        &[[a, [0.5, 0.5, 0.5], b], [[0.25, 0.25, 3.0], [0.75, 0.25, 3.0], [0.5, 0.75, 3.0]]],
    ];
    for flaps in cases {
        let ready = prepared(&flapped(flaps), true);
        let all: Vec<u32> = (6..6 + 2 * flaps.len() as u32).collect();
        assert_eq!((&ready.repairs.flaps, ready.repairs.inner.len()), (&all, 0), "{flaps:?}");
        assert_eq!((ready.domain.facets.len(), volume(&ready).as_str()), (6, "1"));
    }
    // A side of a cube that is there three times is there once.
    let mut thrice = cubes(&[[0.0; 3]]);
    let mut back = thrice.facets[1].clone();
    back.polygons[0].reverse();
    thrice.facets.insert(0, back);
    thrice.facets.push(thrice.facets[2].clone());
    let ready = prepared(&thrice, true);
    assert_eq!(ready.repairs.flaps, [0, 7]);
    assert_eq!((volume(&ready).as_str(), ready.report.cells.unwrap().len()), ("1", 1));
    // A lid over a notch, from either side: what is below it stays outside.
    let mut lid = cubes(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).welded().domain;
    let ends = [[1.0, 0.0, 2.0], [1.0, 1.0, 2.0], [2.0, 1.0, 1.0], [2.0, 0.0, 1.0]];
    add(&mut lid, &[&ends]);
    add(&mut lid, &[&[ends[3], ends[2], ends[1], ends[0]]]);
    assert_eq!(volume(&prepared(&lid, true)), "3");
}

/// Cubes in each other, turned outwards where it says so.
fn nested(outwards: &[bool]) -> Domain {
    let mut domain = Domain::default();
    for (n, out) in outwards.iter().enumerate() {
        let low = [n as f64; 3];
        let mut cube = Domain::cuboid(low, low.map(|c| 16.0 - c));
        if !out {
            cube.facets.iter_mut().for_each(|f| f.polygons[0].reverse());
        }
        domain = domain.join(cube);
    }
    domain
}

#[test]
fn bodies_in_bodies_are_what_their_orientation_says() {
    let filled = |domain: &Domain, nested_voids: bool, oriented: bool| -> Vec<bool> {
        let options = CheckOptions { oriented, nested_voids, ..CheckOptions::default() };
        domain.check(&options).unwrap().cells.unwrap().iter().map(|c| c.filled).collect()
    };
    let (o, i) = (true, false);
    let cases: [(&[bool], &[bool], u64); 10] = [
        (&[o, i], &[true, false], 0),
        (&[o, o], &[true, true], 1),
        (&[i, i], &[true, true], 1),
        (&[i, o], &[true, false], 0),
        (&[o, i, o, i], &[true, false, true, false], 0),
        (&[o, o, o], &[true, true, true], 2),
        (&[o, o, i], &[true, true, false], 1),
        (&[o, i, i], &[true, false, true], 0),
        (&[i, i, o, o], &[true, true, false, true], 1),
        (&[o, i, o, o], &[true, false, true, true], 1),
    ];
    for (turned, inside, count) in cases {
        let domain = nested(turned);
        assert_eq!(filled(&domain, false, true), inside, "{turned:?}");
        let ready = prepared(&domain, true);
        assert_eq!(ready.report.count(DefectKind::Nested), count, "{turned:?}");
        assert_eq!(ready.notes().len(), usize::from(count > 0), "{turned:?}");
        // However they are turned, oriented or not, and whatever the file says.
        let every_other: Vec<bool> = (0..turned.len()).map(|k| k % 2 == 0).collect();
        for oriented in [false, true] {
            assert_eq!(filled(&domain, true, oriented), every_other, "{turned:?}");
            let mut auto = domain.clone();
            let mut options = PrepareOptions { oriented, ..PrepareOptions::default() };
            Holes::Auto.apply(&mut auto, &mut options);
            let ready = auto.prepare(&options).unwrap();
            assert_eq!(ready.domain.holes.len(), turned.len() / 2);
            assert!(ready.notes().is_empty());
            let mut all = ready.domain.clone();
            Holes::None.apply(&mut all, &mut options);
            let options = PrepareOptions { nested_voids: false, ..options };
            assert_eq!(volume(&all.prepare(&options).unwrap()), "4096");
        }
    }
    // A wall between two bodies of one shell is no nesting.
    let mut walled = cubes(&[[0.0; 3], [1.0, 0.0, 0.0]]).welded().domain;
    walled.facets.remove(10);
    assert_eq!(filled(&walled, true, false), [true, true]);
}

#[test]
fn orientation_is_told_once_a_body() {
    let mut domain = nested(&[true, true]).join(cubes(&[[20.0; 3], [30.0; 3]]));
    (12..18).chain([20]).for_each(|f| domain.facets[f].polygons[0].reverse());
    domain.facets[0].polygons[0].reverse();
    domain.facets[1].polygons[0].reverse();
    let report = check(&domain, true);
    // The outer body has two such facets, the third body nothing else, the fourth one.
    assert_eq!(report.inward, [0, 1, 12, 13, 14, 15, 16, 17, 20]);
    assert_eq!(report.count(DefectKind::Orientation), 3, "{:?}", report.defects);
    let auto = CheckOptions { oriented: true, nested_voids: true, ..CheckOptions::default() };
    let report = domain.check(&auto).unwrap();
    assert_eq!(report.count(DefectKind::Orientation), 4, "{:?}", report.defects);
    domain.turn_round(&report.inward);
    assert_eq!(domain.check(&auto).unwrap().count(DefectKind::Orientation), 0);
}

#[test]
fn regions_outside_stay_refused_and_holes_beyond_too() {
    let mut domain = sheets().swap_remove(0).0;
    domain.regions.push(Region { seed: [1.5, 0.5, 0.5], attribute: 1.0, max_volume: None });
    let error = domain.prepare(&PrepareOptions::default()).unwrap_err();
    assert_eq!(error.report().unwrap().count(DefectKind::SeedOutside), 1);
    domain.regions.clear();
    domain.holes.push([1.5, 0.5, 0.5]);
    let error = domain.prepare(&PrepareOptions::default()).unwrap_err();
    assert_eq!(error.report().unwrap().count(DefectKind::SeedOutside), 1);
}

/// Where the lattice of a far-away domain leaves no facet an area, that is the reason.
#[test]
fn a_refusal_names_a_defect() {
    for size in [1e-3, 1e-6, 1e-9] {
        for turned in [false, true] {
            let mut domain = cubes(&[[0.0; 3]]);
            domain
                .vertices
                .iter_mut()
                .for_each(|p| *p = [p[0], 2.0 * p[1], p[2]].map(|c| 1e6 + size * c));
            if turned {
                domain.vertices.iter_mut().for_each(|p| p[2] -= 1e6);
            }
            let options = PrepareOptions { frame: Frame::Own, ..PrepareOptions::default() };
            let error = domain.prepare(&options).unwrap_err();
            let PrepareError::BelowLattice { report, .. } = &error else { panic!("{error}") };
            assert!(!report.is_meshable() && !report.defects.is_empty(), "{error}");
            assert!(error.to_string().contains("domain.degenerate"), "{error}");
        }
    }
}
