//! Known angles, and a mesh that leaves more over a bound than it may.

use super::{ALLOWED, Count, Features, Meeting, NEEDLE, judge, judge_refined, limits};
use crate::domains::prepared;
use crate::layered::{random_honeycomb, random_laminate};
use ltbw::domain::{Domain, Facet};
use ltbw::refine::{RefineOutcome, Refiner};
use ltbw_generate::layers::stack;
use ltbw_generate::surfaces::{book, map_points, plate, prism, single};
use ltbw_generate::{DomainKind, Shape, generate_domain};

fn generated(kind: DomainKind, angle: Option<f64>) -> Domain {
    generate_domain(kind, &Shape { angle, ..Shape::default() }).expect("a domain")
}

fn assert_near(name: &str, found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-5, "{name}: {found} degrees, not {wanted}");
}

#[test]
fn boxes_meet_at_right_angles() {
    for domain in [
        stack([3.0, 2.0], &[0.0625; 3], true),
        generated(DomainKind::LBlock, None),
        generated(DomainKind::Voxels, None),
        generated(DomainKind::TwoMaterial, None),
        generated(DomainKind::CubeInCube, None),
    ] {
        let found = Features::of(&prepared(&domain).domain, 0.0);
        for angle in [found.segments, found.segment_facet, found.facets, found.plane] {
            // Along a line segments go on, and facets beside them.
            assert!(angle == 90.0 || angle == 180.0, "{found:?}");
        }
        assert_eq!((found.least(), found.meeting()), (90.0, Meeting::Wide));
    }
}

#[test]
fn a_wedge_has_its_angle_between_facets_and_in_its_ends() {
    for angle in [0.5, 5.0, 14.0, 15.0, 19.9, 20.1, 60.0] {
        let domain = generated(DomainKind::Wedge, Some(angle));
        let found = Features::of(&domain, 0.0);
        assert_near("dihedral", found.facets, angle);
        assert_near("plane", found.plane, angle);
        // A side of an end leaves the side of the prism that it is not on.
        assert_near("segment and facet", found.segment_facet, angle);
        assert_eq!(found.segments, 180.0, "each two have a facet in common");
        assert_eq!(found.needles, if angle < NEEDLE { 2 } else { 0 }, "{angle}");
        let meeting = if angle < 20.0 { Meeting::Sharp } else { Meeting::Wide };
        assert_eq!(found.meeting(), meeting, "{angle}");
    }
}

#[test]
fn sheets_have_the_angle_between_them() {
    for (sheets, angle) in [(2, 10.0), (3, 25.0), (6, 20.5)] {
        assert_near("a book", Features::of(&book(sheets, angle), 0.0).facets, angle);
    }
}

#[test]
fn a_needle_alone_is_counted_apart() {
    // The floor has a tip of atan(0.1) = 5.71 degrees; a wall stands on each of its sides.
    let floor = [[0.0, 0.0], [1.0, 0.0], [0.0, 0.1]];
    let vertices = [0.0, 1.0].iter().flat_map(|&z| floor.map(|[x, y]| [x, y, z])).collect();
    let mut domain = Domain { vertices, ..Domain::default() };
    let faces: [&[u32]; 5] = [&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]];
    domain.facets = faces.iter().map(|face| Facet::polygon(face, 0)).collect();
    let found = Features::of(&domain, 0.0);
    assert_near("plane", found.plane, 0.1_f64.atan().to_degrees());
    assert_near("dihedral", found.facets, found.plane);
    assert_eq!((found.needles, found.meeting()), (2, Meeting::Sharp), "walls meet there");
    // A flat floor of one facet with a notch in its plane: its tip is outside.
    let notched =
        [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 2.2], [2.0, 2.0], [0.0, 1.8]];
    let vertices = notched.map(|[x, y]| [x, y, 0.0]).to_vec();
    let floor = Domain {
        vertices,
        facets: vec![Facet::polygon(&[0, 1, 2, 3, 4, 5, 6], 0)],
        ..Domain::default()
    };
    let found = Features::of(&floor, 0.0);
    assert_near("notch", found.segments, 2.0 * 0.1_f64.atan().to_degrees());
    assert_eq!((found.needles, found.meeting()), (0, Meeting::Sharp));
    // A sheet with a tip that stands free in the plane of the floor, and nothing else at it.
    let tip = Domain { facets: vec![Facet::polygon(&[0, 1, 2], 0)], ..domain };
    let found = Features::of(&tip, 0.0);
    assert_near("tip", found.plane, 0.1_f64.atan().to_degrees());
    assert_eq!((found.segments, found.facets, found.segment_facet), (180.0, 180.0, 180.0));
    assert_eq!((found.needles, found.meeting()), (1, Meeting::Needles));
}

#[test]
fn a_segment_over_a_facet_has_the_angle_to_its_plane() {
    // A square floor, and a segment that leaves its corner over its diagonal, or beside it.
    let floor = |far: [f64; 3]| Domain {
        vertices: vec![[0.0; 3], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0], far],
        facets: vec![Facet::polygon(&[0, 1, 2, 3], 0)],
        segments: vec![([0, 4], 0)],
        ..Domain::default()
    };
    let found = Features::of(&floor([1.0, 1.0, 0.25]), 0.0);
    assert_near("over", found.segment_facet, (0.25 / 2.0_f64.sqrt()).atan().to_degrees());
    assert_eq!(found.meeting(), Meeting::Sharp);
    let found = Features::of(&floor([1.0, -1.0, 0.0]), 0.0);
    assert_eq!(found.segment_facet, 180.0, "beside it");
    assert_near("beside", found.segments, 45.0);
}

#[test]
fn what_is_flat_within_a_tolerance_is_one_facet() {
    // Sides of two triangles each, caps of fans: one plane each within the tolerance.
    let noisy = single(prism(6, 1e-6, 3));
    let within = Features::of(&noisy, 1e-4);
    assert_eq!(within.needles, 0, "{within:?}");
    assert!((within.least() - 90.0).abs() < 0.01, "{within:?}");
    assert_eq!(within.meeting(), Meeting::Wide);
    // The sides, half as wide as high, are two triangles each.
    let exact = Features::of(&noisy, 0.0);
    assert!((exact.plane - 0.5_f64.atan().to_degrees()).abs() < 0.01, "{exact:?}");
    // Fans of 48 corners are needles unless they are one facet.
    let fans = single(prism(48, 1e-6, 3));
    assert!(Features::of(&fans, 0.0).needles > 50);
    assert_eq!(Features::of(&fans, 1e-4).meeting(), Meeting::Wide);
    assert_eq!(Features::of(&prism(48, 0.0, 0), 1e-9).meeting(), Meeting::Wide);
    // Markers keep facets apart.
    let mut marked = prism(48, 0.0, 0);
    (0..).zip(&mut marked.facets).for_each(|(marker, facet)| facet.marker = marker);
    assert!(Features::of(&marked, 1e-4).needles > 50);
    // Triangles of one plane are one facet without any.
    assert_near("a plate", Features::of(&plate(3, 0.1), 0.0).least(), 90.0);
}

#[test]
fn angles_are_those_of_the_turned_and_scaled_domain() {
    let domain = generated(DomainKind::Spike, Some(17.0));
    let own = Features::of(&domain, 0.0);
    // Two neighbouring faces of the pyramid rise from the top of the cube, whose plane has a hole
    // for it: the sharpest angle is at the apex, in a face.
    assert_eq!(own.meeting(), Meeting::Sharp);
    let turned = map_points(&domain, |[x, y, z]| {
        [0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y, z].map(|c| 64.0 * c)
    });
    let other = Features::of(&turned, 0.0);
    assert_near("segments", other.segments, own.segments);
    assert_near("segment and facet", other.segment_facet, own.segment_facet);
    assert_near("facets", other.facets, own.facets);
    assert_near("plane", other.plane, own.plane);
}

#[test]
fn honeycombs_and_laminates_meet_at_wide_angles() {
    for seed in 0..30 {
        for (name, domain) in [random_honeycomb(seed), random_laminate(seed)] {
            let found = Features::of(&prepared(&domain).domain, 0.0);
            assert_eq!(found.meeting(), Meeting::Wide, "{name}: {found:?}");
            assert!(found.least() > 59.9, "{name}: {found:?}");
        }
    }
}

/// The planted negative: a sound mesh that is judged by bounds it was not asked for.
#[test]
fn a_mesh_that_leaves_too_much_over_a_bound_is_told() {
    let ready = prepared(&generated(DomainKind::TwoMaterial, None));
    let refiner = Refiner::new().max_volume(1e-2);
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    assert_eq!(refined.outcome, RefineOutcome::Met);
    let count = |ratio, volume| -> Count {
        let asked = limits(&ready.domain, Some(ratio), Some(volume));
        judge_refined(&ready, &refined, &asked).expect("a sound mesh").1
    };
    let met = count(2.0, 1e-2);
    assert_eq!((met.over, met.share, met.is_broken()), (0, 0.0, false));
    for (ratio, volume) in [(2.0, 5e-3), (1.0, 1e-2)] {
        let more = count(ratio, volume);
        assert!(more.share > ALLOWED && more.over > 0 && more.is_broken(), "{more}");
    }
    // All is over: the first region's bound is the mesh's, the second's its own.
    let all = count(2.0, 1e-9);
    assert!(all.over == all.tets && (all.share - 1.0).abs() < 1e-12, "{all}");
    // The same where a wedge excuses it.
    let ready = prepared(&generated(DomainKind::Wedge, Some(10.0)));
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let asked = limits(&ready.domain, Some(1.0), None);
    let (_, sharp) = judge_refined(&ready, &refined, &asked).expect("a sound mesh");
    assert!(sharp.share > ALLOWED && !sharp.is_broken(), "{sharp}");
}

#[test]
fn no_mesh_is_a_broken_bar_and_a_defect_is_no_count() {
    let ready = prepared(&generated(DomainKind::LBlock, None));
    let refined = Refiner::new().refine(&ready.domain, &ready.lattice).expect("a mesh");
    let (asked, features) =
        (limits(&ready.domain, Some(2.0), None), Features::of(&ready.domain, 0.0));
    let none = ltbw::TetMesh { tets: Vec::new(), tet_tags: None, ..refined.inside() };
    let (_, count) = judge(&ready.domain, 0.0, &none, &asked).expect("nothing to test");
    assert_eq!(count.features, features);
    assert!(count.share == 1.0 && count.is_broken(), "{count}");
    let mut bad = refined.inside();
    bad.tets[1] = bad.tets[0];
    assert!(judge(&ready.domain, 0.0, &bad, &asked).is_err());
}
