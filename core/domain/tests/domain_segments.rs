//! The exact check of domains: segments, sheets and hole points beside facets.

use crate::common::{check, cubes};
use ltbw_domain::{CheckOptions, DefectKind, Domain, Element, Facet, Severity};
use std::collections::BTreeMap;

#[test]
fn a_segment_in_a_facet_is_drawn_in_it_or_crosses_it() {
    let plain = cubes(&[[0.0; 3]]);
    for ends in [[0, 3], [1, 2], [3, 0], [2, 1]] {
        // Whichever diagonal the triangles of the facet have.
        let mut crossed = plain.clone();
        crossed.segments.push((ends, 0));
        let report = crossed.check(&CheckOptions::default()).unwrap();
        assert_eq!(report.count(DefectKind::Intersection), 1, "{ends:?}: {:?}", report.defects);
        // A polygon of two corners makes it an edge of the facet.
        let mut drawn = plain.clone();
        let facet =
            drawn.facets.iter_mut().find(|f| ends.iter().all(|v| f.polygons[0].contains(v)));
        facet.unwrap().polygons.push(ends.to_vec());
        for segments in [Vec::new(), vec![(ends, 0)]] {
            drawn.segments = segments;
            let report = drawn.check(&CheckOptions::default()).unwrap();
            assert!(report.passed(), "{ends:?}: {:?}", report.defects);
        }
    }
    // A segment along an edge of the box is one of its edges.
    let mut along = plain;
    along.segments.push(([0, 1], 0));
    assert!(along.check(&CheckOptions::default()).unwrap().passed());
}

#[test]
fn a_facet_along_a_diagonal_of_another_crosses_it() {
    let plain = cubes(&[[0.0; 3]]);
    // From a face's diagonal to one corner or two of the opposite face: whichever diagonals the
    // triangles have.
    for (corners, faces) in
        [(&[0, 3, 7][..], 1), (&[1, 2, 6], 1), (&[0, 3, 7, 4], 2), (&[1, 2, 6, 5], 2)]
    {
        let sheet = Facet::polygon(corners, 0);
        let mut crossed = plain.clone();
        crossed.facets.push(sheet.clone());
        for turn in 0..4 {
            crossed.facets.iter_mut().for_each(|facet| facet.polygons[0].rotate_left(1));
            let report = check(&crossed, false);
            let crossings = report.count(DefectKind::Intersection);
            assert_eq!(crossings, faces, "{corners:?} {turn}: {:?}", report.defects);
        }
        // Drawn in the faces, the diagonals are where the sheet ends.
        let mut drawn = plain.clone();
        for facet in &mut drawn.facets {
            let [a, b, c, d] = facet.polygons[0][..] else { unreachable!("faces of a cube") };
            let diagonals = [[a, c], [b, d]].into_iter();
            let ends = diagonals.filter(|ends| ends.iter().all(|v| corners.contains(v)));
            facet.polygons.extend(ends.map(Vec::from));
        }
        drawn.facets.push(sheet);
        let report = check(&drawn, false);
        assert!(report.is_meshable(), "{corners:?}: {:?}", report.defects);
    }
    // Two rectangles through each other, along a diagonal that both have.
    let mut two = Domain::default();
    two.vertices.extend([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]]);
    two.vertices.extend([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0]]);
    two.facets.extend([[0, 1, 2, 3], [0, 4, 2, 5]].map(|p| Facet::polygon(&p, 0)));
    for turn in 0..4 {
        two.facets[turn % 2].polygons[0].rotate_left(1);
        assert_eq!(check(&two, false).count(DefectKind::Intersection), 1, "{turn}");
    }
}

#[test]
fn segments_meet_in_their_ends_alone() {
    let plain = cubes(&[[0.0; 3]]);
    let places = [
        [0.25, 0.5, 0.5],
        [0.75, 0.5, 0.5],
        [0.5, 0.25, 0.5],
        [0.5, 0.75, 0.5],
        [0.5, 0.5, 0.5],
        [0.5, 0.25, 0.75],
        [0.5, 0.75, 0.75],
        [0.25, 0.5, 0.5],
    ];
    // Numbers of the places above: segments, and what is wrong with them.
    type Case<'a> = (&'a [[u32; 2]], &'a [(DefectKind, u64)]);
    let cases: [Case<'_>; 9] = [
        (&[[0, 1]], &[]),
        (&[[0, 1], [2, 3]], &[(DefectKind::Intersection, 1)]),
        (&[[0, 1], [5, 6]], &[]),
        (&[[0, 1], [1, 0]], &[(DefectKind::Overlap, 1)]),
        (&[[0, 1], [4, 3]], &[(DefectKind::TJunction, 1)]),
        (&[[4, 3], [0, 1]], &[(DefectKind::TJunction, 1)]),
        (&[[0, 4], [4, 1], [2, 4], [4, 3]], &[]),
        // Along each other: each has an end on the other, or one has both.
        (&[[0, 1], [0, 4]], &[(DefectKind::TJunction, 1)]),
        // Between equal places.
        (&[[0, 7]], &[(DefectKind::Degenerate, 1)]),
    ];
    for (segments, wrong) in cases {
        let mut domain = plain.clone();
        let mut names = BTreeMap::new();
        for &v in segments.iter().flatten() {
            names.entry(v).or_insert_with(|| {
                domain.vertices.push(places[v as usize]);
                domain.vertices.len() as u32 - 1
            });
        }
        domain.segments = segments.iter().map(|ends| (ends.map(|v| names[&v]), 0)).collect();
        let report = check(&domain, false);
        let errors: Vec<_> = report
            .counts
            .iter()
            .filter(|(kind, _)| kind.severity() == Severity::Error)
            .map(|(&kind, &count)| (kind, count))
            .collect();
        assert_eq!(errors, wrong, "{segments:?}: {:?}", report.defects);
    }
    // A vertex that nothing names may be on a segment: it is one of the mesh's then.
    let mut domain = plain;
    domain.vertices.extend([places[0], places[1], places[4]]);
    domain.segments.push(([8, 9], 0));
    let report = check(&domain, false);
    assert_eq!(report.count(DefectKind::TJunction), 0, "{:?}", report.defects);
    assert_eq!(report.count(DefectKind::UnusedVertex), 1);
}

#[test]
fn hole_points_of_facets_lie_in_pieces_of_them() {
    let hole = |at: [f64; 3]| {
        let mut domain = cubes(&[[0.0; 3]]);
        domain.facets[0].holes.push(at);
        let report = check(&domain, false);
        report.defects.iter().map(|defect| (defect.kind, defect.elements[0])).next()
    };
    let element = Element::FacetHole { facet: 0, hole: 0 };
    assert_eq!(hole([2.0, 2.0, 0.0]), Some((DefectKind::SeedOutside, element)));
    assert_eq!(hole([0.5, 0.0, 0.0]), Some((DefectKind::SeedOnFacet, element)));
    assert_eq!(hole([1.0, 1.0, 0.0]), Some((DefectKind::SeedOnFacet, element)));
    // All of the facet falls away.
    assert_eq!(hole([0.5, 0.25, 0.0]), Some((DefectKind::Degenerate, Element::Facet(0))));
}
