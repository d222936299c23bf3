//! The repairs before a domain is meshed, and what a refusal says of the surface.

use ltbw_domain::{
    CheckOptions, Domain, Facet, Frame, PrepareError, PrepareOptions, Prepared, TroubleKind,
};
use ltbw_exact::Point;

const BOX: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// A domain of cubes of this size at these places, each with vertices of its own.
fn cubes(size: f64, places: &[Point]) -> Domain {
    let mut domain = Domain::default();
    for place in places {
        let first = domain.vertices.len() as u32;
        let corner = |i: u32| [0, 1, 2].map(|k| place[k] + size * f64::from(i >> k & 1));
        domain.vertices.extend((0..8).map(corner));
        domain.facets.extend(BOX.iter().map(|f| Facet::polygon(&f.map(|v| v + first), 0)));
    }
    domain
}

fn surface() -> PrepareOptions {
    PrepareOptions { oriented: true, ..PrepareOptions::default() }
}

fn repaired(domain: &Domain, repair: f64) -> Result<Prepared, PrepareError> {
    domain.prepare(&PrepareOptions { repair, ..surface() })
}

fn volume(prepared: &Prepared) -> String {
    prepared.report.volume().unwrap().to_string()
}

/// The kinds of trouble, with places and bodies.
fn troubles(error: &PrepareError) -> Vec<(TroubleKind, u64, usize)> {
    let report = error.report().unwrap_or_else(|| panic!("{error}"));
    report.troubles.iter().map(|t| (t.kind, t.places, t.bodies)).collect()
}

#[test]
fn facets_without_area_are_dropped_and_their_vertices_spliced() {
    let mut domain = cubes(1.0, &[[0.0; 3]]);
    domain.vertices.push([0.5, 0.0, 0.0]);
    // The edge 0-1 is split in one of its two faces; a flat triangle fills the gap.
    domain.facets[2] = Facet::polygon(&[0, 8, 1, 5, 4], 0);
    domain.facets.push(Facet::polygon(&[0, 1, 8], 0));
    // A triangle that names a vertex twice, and one whose corners are two places.
    domain.facets.push(Facet::polygon(&[0, 1, 1], 0));
    domain.vertices.push([0.0; 3]);
    domain.facets.push(Facet::polygon(&[0, 9, 1], 0));
    let prepared = domain.prepare(&surface()).unwrap();
    assert_eq!(volume(&prepared), "1");
    assert_eq!(prepared.repairs.degenerate, [6, 7, 8]);
    assert_eq!(prepared.repairs.spliced, 1);
    assert_eq!(prepared.facet_map, [0, 1, 2, 3, 4, 5]);
    assert_eq!(prepared.domain.facets[0].polygons[0].len(), 5);
    assert_eq!(prepared.repairs.notes().len(), 2, "{:?}", prepared.repairs.notes());
    // Nothing but such facets is no domain.
    let flat = Domain { facets: domain.facets.split_off(6), ..domain };
    let error = flat.prepare(&surface()).unwrap_err();
    assert_eq!(troubles(&error)[0].0, TroubleKind::Degenerate, "{error}");
}

#[test]
fn equal_facets_of_two_bodies_become_an_inner_facet() {
    let joined = cubes(1.0, &[[0.0; 3], [1.0, 0.0, 0.0]]);
    let prepared = joined.prepare(&surface()).unwrap();
    assert_eq!(volume(&prepared), "2");
    let cells = prepared.report.cells.as_ref().unwrap();
    assert!(cells.len() == 2 && cells.iter().all(|cell| cell.filled), "{cells:?}");
    assert_eq!(prepared.repairs.inner.len(), 1);
    assert_eq!(prepared.domain.facets.len(), 11);
    assert!(prepared.domain.holes.is_empty());
    // A facet that is written twice alike is there once.
    let mut twice = cubes(1.0, &[[0.0; 3]]);
    let mut again = twice.facets[3].clone();
    again.polygons[0].rotate_left(2);
    twice.facets.push(again);
    let prepared = twice.prepare(&surface()).unwrap();
    assert_eq!(prepared.repairs.doubled, [6]);
    assert!(prepared.repairs.inner.is_empty());
    assert_eq!(volume(&prepared), "1");
}

#[test]
fn a_void_beside_an_inner_facet_stays_a_void() {
    let mut domain = cubes(4.0, &[[0.0; 3], [4.0, 0.0, 0.0]]);
    let mut void = cubes(2.0, &[[1.0; 3]]);
    void.facets.iter_mut().for_each(|f| f.polygons[0].reverse());
    domain.facets.extend(
        void.facets
            .iter()
            .map(|f| Facet::polygon(&f.polygons[0].iter().map(|v| v + 16).collect::<Vec<_>>(), 0)),
    );
    domain.vertices.append(&mut void.vertices);
    let prepared = domain.prepare(&surface()).unwrap();
    assert_eq!(volume(&prepared), "120");
    assert_eq!(prepared.domain.holes.len(), 1);
}

#[test]
fn a_refusal_names_what_is_wrong_and_in_how_many_bodies() {
    let refused = |domain: &Domain| troubles(&domain.prepare(&surface()).unwrap_err());
    let far = [5.0, 5.0, 5.0];
    let mut open = cubes(1.0, &[[0.0; 3], far]);
    open.facets.remove(1);
    assert_eq!(refused(&open), [(TroubleKind::Open, 4, 1)]);
    let text = open.prepare(&surface()).unwrap_err().to_string();
    assert!(text.contains("; of 2 bodies: open: 4 places in 1 body, the first at ("), "{text}");
    // The same without a lid, and every facet from either side.
    let mut doubled = open.clone();
    doubled.facets.extend(open.facets[..5].iter().cloned().map(|mut facet| {
        facet.polygons[0].reverse();
        facet
    }));
    assert_eq!(refused(&doubled), [(TroubleKind::Open, 4, 1), (TroubleKind::Doubled, 5, 1)]);
    let cross = cubes(1.0, &[[0.0; 3], [0.5; 3], far]);
    assert_eq!(refused(&cross), [(TroubleKind::BodiesCross, 6, 2)]);
    let touch = cubes(1.0, &[[0.0; 3], [1.0, 0.25, 0.25], far]);
    let found = refused(&touch);
    assert_eq!((found[0].0, found[0].2), (TroubleKind::BodiesTouch, 2));
    // The edges of the one lie in the face of the other, which does not draw them.
    assert!(found.iter().skip(1).all(|t| t.0 == TroubleKind::BodiesCross && t.2 == 2), "{found:?}");
    // A vertex of the cube pulled through the opposite face.
    let mut own = cubes(1.0, &[[0.0; 3], far]);
    own.vertices[7] = [0.25, 0.25, -1.0];
    let found = refused(&own);
    assert!(found.iter().any(|t| t.0 == TroubleKind::SelfCrossing && t.2 == 1), "{found:?}");
    assert!(found.iter().all(|t| t.0 != TroubleKind::BodiesCross), "{found:?}");
}

/// A cube whose lid is two rectangles, the seam between them `gap` away from the middles of the
/// side walls' upper edges, which do not have these vertices.
fn seam(gap: f64) -> Domain {
    let mut domain = cubes(1.0, &[[0.0; 3]]);
    domain.vertices.extend([[0.5, gap, 1.0], [0.5, 1.0 - gap, 1.0]]);
    domain.facets[1] = Facet::polygon(&[4, 8, 9, 6], 0);
    domain.facets.push(Facet::polygon(&[8, 5, 7, 9], 0));
    domain
}

#[test]
fn a_seam_of_t_junctions_is_closed_within_the_tolerance_alone() {
    for gap in [0.0, 1e-5] {
        let domain = seam(gap);
        let error = repaired(&domain, 0.0).unwrap_err();
        let kinds: Vec<TroubleKind> = troubles(&error).iter().map(|t| t.0).collect();
        assert!(kinds.contains(&TroubleKind::Open), "{error}");
        let prepared = repaired(&domain, 1e-4).unwrap();
        assert_eq!(prepared.repairs.seams, 2, "{gap}");
        assert!(prepared.repairs.used_tolerance());
        let volume = prepared.report.volume().unwrap().to_f64();
        assert!((volume - 1.0).abs() < 1e-4, "{gap}: {volume}");
    }
    let error = repaired(&seam(1e-5), 1e-7).unwrap_err();
    assert!(!troubles(&error).is_empty(), "{error}");
}

/// A cube of six squares that have vertices of their own, each moved inwards by up to `gap`.
fn cracked(gap: f64) -> Domain {
    let whole = cubes(1.0, &[[0.0; 3]]);
    let mut domain = Domain::default();
    for (i, facet) in whole.facets.iter().enumerate() {
        let first = domain.vertices.len() as u32;
        let towards = |c: f64| c + (0.5 - c) * gap * i as f64 / 5.0;
        let corners = facet.polygons[0].iter().map(|&v| whole.vertices[v as usize].map(towards));
        domain.vertices.extend(corners);
        domain.facets.push(Facet::polygon(&[first, first + 1, first + 2, first + 3], 0));
    }
    domain
}

#[test]
fn vertices_within_the_tolerance_are_welded_and_told() {
    let open = repaired(&cracked(1e-5), 0.0).unwrap_err();
    assert_eq!(troubles(&open), [(TroubleKind::Open, 24, 6)]);
    let prepared = repaired(&cracked(1e-5), 1e-4).unwrap();
    assert_eq!(prepared.domain.vertices.len(), 8);
    assert_eq!((prepared.repairs.welded, prepared.repairs.welded_by_tolerance), (16, 16));
    assert!(prepared.repairs.farthest_weld > 1e-6 && prepared.repairs.farthest_weld < 1e-4);
    // Within one step of the lattice, wherever the steps are: without being asked, but told.
    let step = 2.0_f64.powi(-26);
    for gap in [0.3 * step, step] {
        let prepared = repaired(&cracked(gap), 0.0).unwrap();
        assert_eq!(prepared.domain.vertices.len(), 8, "{gap:e}");
        assert!(prepared.repairs.welded >= 15 && prepared.repairs.welded_by_tolerance == 0);
        assert!(!prepared.repairs.notes().is_empty());
    }
    // No edge is collapsed: the ends of the shortest one are farther apart than nothing.
    let mut thin = cubes(1.0, &[[0.0; 3]]);
    thin.vertices.iter_mut().for_each(|p| p[2] *= 1e-4);
    let prepared = repaired(&thin, 1e-3).unwrap();
    assert_eq!(prepared.domain.vertices.len(), 8);
    assert!(prepared.repairs.is_empty(), "{:?}", prepared.repairs);
}

#[test]
fn tolerances_are_lengths_below_a_part_of_the_diagonal() {
    let cube = cubes(1.0, &[[0.0; 3]]);
    for bad in [-1e-6, f64::NAN, 2e-3, f64::INFINITY] {
        let error = repaired(&cube, bad).unwrap_err();
        assert_eq!(error.code(), "domain.tolerance", "{bad}");
    }
    assert!(repaired(&cube, 1.6e-3).is_ok());
}

#[test]
fn the_frame_is_local_from_two_lost_bits_on_unless_the_own_one_is_asked_for() {
    let prepared = |shift: f64, frame: Frame| {
        let domain = cubes(1.0, &[[shift; 3]]);
        domain.prepare(&PrepareOptions { frame, ..surface() }).unwrap().lattice
    };
    assert_eq!(prepared(0.0, Frame::Auto).offset(), [0.0; 3]);
    let far = prepared(1000.0, Frame::Auto);
    assert_eq!((far.offset(), far.lost_bits()), ([1000.5; 3], 0));
    let own = prepared(1000.0, Frame::Own);
    assert_eq!((own.offset(), own.lost_bits()), ([0.0; 3], 11));
    assert_eq!(prepared(0.0, Frame::Local).offset(), [0.5; 3]);
}

#[test]
fn a_report_without_errors_has_no_troubles() {
    let report = cubes(1.0, &[[0.0; 3]]).check(&CheckOptions::default()).unwrap();
    assert!(report.troubles.is_empty() && report.bodies == 0);
}
