//! Tests of whole refinements: conformity against slow twins, transactions, early ends.

#[macro_use]
mod surface;

mod cavity;
mod combs;
mod complex;
mod rounds;
mod sharp;
mod sizes;

use super::*;
use crate::complex::carrier::{Carrier, corner_point};
use crate::complex::measure::{diametral_side, equatorial_side};
use crate::mesh::item::Queues;
use crate::mesh::marks::ENDS;
use crate::mesh::state::{FACE, State};
use crate::queue::split::Step;
use crate::rules::walk::Way;
use crate::table::{Set, edge};
use ltbw_core::CancelToken;
use ltbw_core::invariants::check_all;
use ltbw_core::mesh::Mesh;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_domain::{Domain, Facet, PrepareOptions, Prepared, Region, vector};
use ltbw_exact::predicates::Sign;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::sync::atomic::{AtomicU64, Ordering};

pub(super) fn ready(kind: DomainKind, shape: &Shape) -> Prepared {
    // The generator was built on another instance of this crate, whose types are not these.
    let made = generate_domain(kind, shape).expect("a domain");
    let mut domain = Domain { vertices: made.vertices, holes: made.holes, ..Domain::default() };
    domain.segments = made.segments;
    for f in made.facets {
        domain.facets.push(Facet { polygons: f.polygons, holes: f.holes, marker: f.marker });
    }
    for r in made.regions {
        let (seed, attribute, max_volume) = (r.seed, r.attribute, r.max_volume);
        domain.regions.push(Region { seed, attribute, max_volume });
    }
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

fn model() -> Prepared {
    ready(DomainKind::CubeOctahedron, &Shape::default())
}

pub(super) fn refine(refiner: &Refiner<'_>, ready: &Prepared) -> Refined {
    refiner.refine(&ready.domain, &ready.lattice).expect("a mesh")
}

/// Checks by brute force what the rules promise at the end, for domains without small angles:
/// every item is in the mesh, and facets have their own planar Delaunay triangulation.
fn check_conforming(state: &State) {
    check_all(&state.mesh).expect("invariants of the mesh");
    assert!(state.is_complete());
    let present = present_segments(state);
    assert!(state.segments.keys().all(|s| present.contains(s)), "a subsegment is missing");
    let mut on: Vec<Vec<VertexId>> = vec![Vec::new(); state.plc.facets.len()];
    for (v, &carrier) in (0..).map(VertexId::new).zip(&state.carriers).skip(1) {
        state.plc.facets_of(&carrier).iter().for_each(|&f| on[f as usize].push(v));
    }
    let mut total = 0;
    for (f, vertices) in (0..).zip(&on) {
        let slow = state.triangulate(f, vertices).expect("a planar mesh");
        assert!(slow.iter().all(|s| state.subfaces.get(s) == Some(&f)), "facet {f}");
        total += slow.len();
    }
    assert_eq!(total, state.subfaces.len());
}

/// The subsegments that the mesh has, by looking at every tetrahedron.
fn present_segments(state: &State) -> Set<[VertexId; 2]> {
    let mut present = Set::default();
    for (t, tet) in state.mesh.topology().iter() {
        let (word, v) = (state.marks.of(t), tet.vertices());
        for (k, [i, j]) in ENDS.into_iter().enumerate() {
            if word >> (4 + k) & 1 == 1 {
                present.insert(edge(v[i], v[j]));
            }
        }
    }
    present
}

/// Does the closed ball of a boundary item hold one of these vertices, of a subface off its facet?
fn holds(state: &State, item: Item, vertices: std::ops::Range<usize>) -> bool {
    let mut vertices = vertices.map(VertexId::at);
    match item {
        Item::Segment([a, b]) => {
            let ends = [a, b].map(|v| state.at(v));
            let mut others = vertices.filter(|v| ![a, b].contains(v));
            others.any(|v| diametral_side(&ends[0], &ends[1], &state.at(v)) != Sign::Positive)
        }
        Item::Subface(s) => {
            let (f, [a, b, c]) = (state.subfaces[&s], s.map(|v| state.at(v)));
            vertices.any(|v| {
                !state.lies_on(state.carriers[v.index()], f)
                    && equatorial_side(&a, &b, &c, &state.at(v)) != Sign::Positive
            })
        }
        Item::Tet(..) => false,
    }
}

/// The closure shows every item with an empty ball that a free point lies in.
#[test]
fn a_free_point_is_in_no_ball_that_was_empty() {
    for (kind, volume) in [(DomainKind::CubeOctahedron, 2e-3), (DomainKind::TwoMaterial, 1e-2)] {
        let ready = ready(kind, &Shape::default());
        let refiner = Refiner::new().max_volume(volume);
        let (mut run, _) = refiner.recovered(&ready.domain, &ready.lattice).expect("a mesh");
        let mut work = Queues::default();
        std::mem::swap(&mut work, &mut run.work);
        let mut free = 0;
        for _ in 0..20_000 {
            let Some(item) = work.next_boundary().or_else(|| work.next_tet()) else { break };
            let step = run.refinement.split(item, &mut work);
            let state = &run.refinement.state;
            assert!(state.is_complete());
            if step != Step::Inserted || state.carriers.last() != Some(&Carrier::Free) {
                continue;
            }
            let last = state.carriers.len() - 1;
            let segments = state.segments.keys().map(|&s| Item::Segment(s));
            let items = segments.chain(state.subfaces.keys().map(|&s| Item::Subface(s)));
            for item in items.filter(|&item| holds(state, item, last..last + 1)) {
                assert!(holds(state, item, 1..last), "{kind:?}: {last} in the ball of {item:?}");
            }
            free += 1;
        }
        assert!(free > 20, "{kind:?}: {free}");
    }
}

/// The way to a point ends at the first subface: at the point of no other way can one be missed.
#[test]
fn the_way_to_a_point_is_barred_exactly_by_the_boundary() {
    let refined = refine(&Refiner::new().max_volume(1e-2), &model());
    let state = &refined.state;
    let tets: Vec<TetId> = refined.tets().collect();
    let middle = |t: TetId| {
        let corners = state.vertices(t).map(|v| state.at(v));
        [0, 1, 2].map(|k| corners.iter().map(|c| c[k] * 0.25).sum::<f64>().round())
    };
    let (mut barred, mut arrived) = (0, 0);
    for (k, &from) in tets.iter().enumerate() {
        let to = tets[(k * 7919 + 13) % tets.len()];
        match state.way(from, &middle(to)) {
            Way::Arrived(t) => {
                assert_eq!(t, to);
                arrived += 1;
            }
            Way::Blocked(s) => {
                assert!(state.subfaces.contains_key(&s));
                barred += 1;
            }
            Way::Outside => panic!("the middle of a tetrahedron is inside"),
        }
        assert!(matches!(state.way(from, &[3e16, 0.0, 0.0]), Way::Blocked(_)));
    }
    // Ways in the cube around the octahedron are free, those through it are not.
    assert!(barred > 10 && arrived > 10, "{barred} {arrived}");
}

/// Marks say what the tables say, from every tetrahedron.
fn check_marks(state: &State) {
    use crate::mesh::marks::face_bit;
    use crate::table::triangle;
    for (t, tet) in state.mesh.topology().iter() {
        let (word, v) = (state.marks.of(t), tet.vertices());
        for (k, [i, j]) in ENDS.into_iter().enumerate() {
            let expected = state.segments.contains_key(&edge(v[i], v[j]));
            assert_eq!(word >> (4 + k) & 1 == 1, expected, "edge {k} of {t}");
        }
        for (slot, face) in FACE.into_iter().enumerate() {
            let [a, b, c] = face.map(|k| v[k]);
            let expected = state.subfaces.contains_key(&triangle(a, b, c));
            assert_eq!(word & face_bit(slot) != 0, expected, "face {slot} of {t}");
        }
    }
}

#[test]
fn domains_without_small_angles_are_met_and_nothing_is_missing() {
    let cases = [
        (DomainKind::CubeOctahedron, 2e-3, 2.0),
        (DomainKind::CubeOctahedron, 2e-3, 1.414),
        (DomainKind::CubeInCube, 2e-3, 2.0),
        (DomainKind::Gear, 4e-3, 2.0),
        (DomainKind::LBlock, 2e-2, 2.0),
        (DomainKind::Stair, 2e-2, 2.0),
        (DomainKind::TwoMaterial, 1e-2, 2.0),
        (DomainKind::Voxels, 5e-2, 2.0),
    ];
    for (kind, volume, ratio) in cases {
        let ready = ready(kind, &Shape::default());
        let refined = refine(&Refiner::new().max_volume(volume).radius_edge(ratio), &ready);
        assert_eq!(refined.outcome, RefineOutcome::Met, "{kind:?} {ratio}");
        assert!(refined.stats.facet_points > 0 && refined.stats.segment_points > 0, "{kind:?}");
        check_conforming(&refined.state);
        check_marks(&refined.state);
    }
}

#[test]
fn a_run_repeats_exactly() {
    let refiner = Refiner::new().max_volume(1e-3);
    let [a, b] = [(), ()].map(|()| refine(&refiner, &model()));
    assert_eq!(a.mesh().topology(), b.mesh().topology());
    assert_eq!(a.with_exterior(), b.with_exterior());
    assert_eq!(a.subfaces(), b.subfaces());
}

#[test]
fn small_angles_end_with_their_names() {
    let mut named = 0;
    let shapes = [60.0, 45.0, 30.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.1]
        .into_iter()
        .flat_map(|angle| [(DomainKind::Wedge, angle), (DomainKind::Spike, angle)]);
    // A spike of 45° or more is none.
    for (kind, angle) in shapes.filter(|&(kind, a)| kind == DomainKind::Wedge || a < 45.0) {
        let ready = ready(kind, &Shape { angle: Some(angle), ..Shape::default() });
        let refined = refine(&Refiner::new().max_volume(1e-2), &ready);
        check_all(refined.mesh()).expect("invariants of the mesh");
        assert!(refined.lost.is_empty(), "{kind:?} {angle}: {:?}", refined.lost);
        if angle == 60.0 && kind == DomainKind::Wedge {
            assert_eq!(refined.outcome, RefineOutcome::Met);
        }
        for excuse in &refined.excuses {
            let small = matches!(
                excuse.reason,
                Reason::SmallDihedral { .. } | Reason::SmallFaceAngle { .. }
            );
            assert!(small, "{kind:?} {angle}: {excuse:?}");
            named += 1;
        }
    }
    assert!(named > 0);
}

#[test]
fn regions_have_their_own_bounds_and_holes_are_left_out() {
    let mut ready = ready(DomainKind::TwoMaterial, &Shape::default());
    assert_eq!(ready.domain.regions.len(), 2, "two materials");
    ready.domain.regions[0].max_volume = Some(1e-3);
    ready.domain.regions[1].max_volume = Some(1e-2);
    let refined = refine(&Refiner::new(), &ready);
    assert_eq!((refined.outcome, refined.regions.len()), (RefineOutcome::Met, 3));
    let count = |region| refined.tets().filter(|&t| refined.region(t) == region).count();
    assert!(count(1) > 3 * count(2), "{} {}", count(1), count(2));
    let mesh = refined.inside();
    let volume = |t: &[u32; 4]| {
        ltbw_domain::quality::TetQuality::of(t.map(|v| &mesh.points[v as usize])).volume
    };
    let sum: f64 = mesh.tets.iter().map(volume).sum();
    assert!((sum - 2.0).abs() < 1e-12, "{sum}");
    let whole = refine(&Refiner::new(), &model());
    assert!(whole.with_exterior().tets.len() > whole.num_tets());
}

#[test]
fn a_sizing_field_is_met() {
    let ready = model();
    let field = |p: Point| 0.05 + 0.2 * p[0];
    let refined = refine(&Refiner::new().sizing(&field), &ready);
    assert_eq!(refined.outcome, RefineOutcome::Met);
    let mesh = refined.inside();
    let (mut fine, mut coarse) = (0, 0);
    for tet in &mesh.tets {
        let corners = tet.map(|v| &mesh.points[v as usize]);
        let x = corners.iter().map(|p| p[0]).sum::<f64>() / 4.0;
        let h: f64 = 0.05 + 0.2 * x;
        let volume = ltbw_domain::quality::TetQuality::of(corners).volume;
        let h = 1.18 * h;
        assert!(volume <= h * h * h * 2f64.sqrt() / 12.0 * (1.0 + 1e-9));
        if x < 0.5 { fine += 1 } else { coarse += 1 }
    }
    assert!(fine > 2 * coarse, "{fine} {coarse}");
}

#[test]
fn bounds_that_no_mesh_meets_are_errors() {
    let ready = model();
    for refiner in [
        Refiner::new().radius_edge(0.9),
        Refiner::new().radius_edge(f64::NAN),
        Refiner::new().max_volume(0.0),
        Refiner::new().max_volume(-1.0),
        Refiner::new().max_volume(f64::NAN),
        Refiner::new().max_volume(1e-60),
    ] {
        let error = refiner.refine(&ready.domain, &ready.lattice).expect_err("no such mesh");
        assert!(matches!(error, RefineError::Bound { .. }), "{error}");
    }
}

#[test]
fn a_budget_ends_the_work_and_is_the_excuse() {
    let refined = refine(&Refiner::new().max_volume(1e-3).max_points(300), &model());
    assert_eq!(refined.outcome, RefineOutcome::Budget);
    let stats = refined.stats;
    assert_eq!(stats.segment_points + stats.facet_points + stats.free_points, 300);
    assert!(refined.excuses.iter().all(|e| e.reason == Reason::Budget));
    assert!(!refined.excuses.is_empty() && refined.lost.is_empty());
    check_all(refined.mesh()).expect("invariants of the mesh");
}

struct Cancels(AtomicU64, CancelToken);

impl ltbw_core::Observer for Cancels {
    fn progress(&self, _: ltbw_core::Progress) {
        if self.0.fetch_add(1, Ordering::Relaxed) == 2 {
            self.1.cancel();
        }
    }
}

#[test]
fn a_cancelled_run_has_a_valid_mesh() {
    let observer = Cancels(AtomicU64::new(0), CancelToken::new());
    let refiner = Refiner::new().max_volume(1e-5).observer(&observer).cancel(&observer.1);
    let refined = refine(&refiner, &model());
    assert_eq!(refined.outcome, RefineOutcome::Cancelled);
    assert!(refined.mesh().num_vertices() < 5000);
    check_all(refined.mesh()).expect("invariants of the mesh");
    let token = CancelToken::new();
    token.cancel();
    let error = Refiner::new().max_volume(1e-3).cancel(&token);
    let result = error.refine(&model().domain, &model().lattice);
    // Cancelled before the boundary was there, or soon after it.
    assert!(result.is_err() || result.is_ok_and(|r| r.outcome == RefineOutcome::Cancelled));
}

/// Topology and cached spheres of a mesh, to the bit.
fn fingerprint(mesh: &Mesh) -> (ltbw_core::topology::Topology, Vec<[u32; 4]>) {
    (mesh.topology().clone(), mesh.spheres_fingerprint())
}

#[test]
fn transactions_are_idempotent() {
    let model = model();
    let refiner = Refiner::new().max_volume(1e-3);
    let (mut run, _) = refiner.recovered(&model.domain, &model.lattice).expect("a mesh");
    let mut work = Queues::default();
    std::mem::swap(&mut work, &mut run.work);
    let (mut deferred, mut inserted) = (0, 0);
    for _ in 0..3000 {
        let Some(item) = work.next_boundary().or_else(|| work.next_tet()) else { break };
        let before = fingerprint(&run.refinement.state.mesh);
        let joint = run.refinement.record.joint_transactions;
        let step = run.refinement.split(item, &mut work);
        if step != Step::Inserted {
            deferred += usize::from(step == Step::Deferred);
            // A circle of items may have been split jointly.
            let is_joint = run.refinement.record.joint_transactions > joint;
            assert!(is_joint || fingerprint(&run.refinement.state.mesh) == before);
            continue;
        }
        inserted += 1;
        // Split, it is gone: to split it again does nothing.
        let before = fingerprint(&run.refinement.state.mesh);
        let again = run.refinement.split(item, &mut work);
        assert_eq!(again, Step::Gone);
        assert_eq!(fingerprint(&run.refinement.state.mesh), before);
    }
    assert!(inserted > 100 && deferred > 10, "{inserted} {deferred}");
    check_marks(&run.refinement.state);
}

#[test]
fn every_point_is_on_its_carrier() {
    let refined =
        refine(&Refiner::new().max_volume(2e-3), &ready(DomainKind::Gear, &Shape::default()));
    let state = &refined.state;
    let (mut on_segments, mut on_facets) = (0, 0);
    for (v, &carrier) in (0..).map(VertexId::new).zip(&state.carriers).skip(1) {
        let p = state.at(v);
        match carrier {
            Carrier::Segment(s, t) => {
                assert_eq!(state.plc.segments[s as usize].line.point(t), p);
                on_segments += 1;
            }
            Carrier::Facet(f) => {
                let corners = &state.plc.facets[f as usize].corners;
                let at = |k: usize| corner_point(&state.plc.corners[corners[k] as usize]);
                let flat = ltbw_exact::predicates::orient3d(&at(0), &at(1), &at(2), &p);
                assert_eq!(flat, Sign::Zero);
                on_facets += 1;
            }
            _ => {}
        }
    }
    assert!(on_segments > 100 && on_facets > 100);
}

#[test]
fn equal_vertices_and_domains_without_an_inside_are_refused() {
    let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
    let mut domain = Domain { vertices, ..Domain::default() };
    for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        domain.facets.push(Facet::polygon(&face, 0));
    }
    let refiner = Refiner::new();
    let snapped = domain.snap().expect("a lattice");
    let error = refiner.refine(&snapped.domain, &snapped.lattice).expect_err("equal vertices");
    assert!(matches!(error, RefineError::DuplicateVertex { .. }), "{error}");
    domain.vertices.pop();
    domain.facets.pop();
    let snapped = domain.snap().expect("a lattice");
    let error = refiner.refine(&snapped.domain, &snapped.lattice).expect_err("a leak");
    assert_eq!(error, RefineError::NoInterior);
}

#[test]
fn the_boundary_has_the_markers_of_its_facets_and_points_outwards() {
    let mut ready = ready(DomainKind::TwoMaterial, &Shape::default());
    let count = ready.domain.facets.len() as i32;
    for (marker, facet) in (10..).zip(&mut ready.domain.facets) {
        facet.marker = marker;
    }
    let refined = refine(&Refiner::new().max_volume(2e-2), &ready);
    for mesh in [refined.inside(), refined.with_exterior()] {
        let faces = &mesh.faces;
        assert_eq!(faces.len(), refined.subfaces().len(), "every triangle once");
        let mut seen = vec![0.0; count as usize];
        for face in faces {
            let tet = mesh.tets[face.tet];
            let apex = tet.into_iter().find(|v| !face.corners.contains(v)).expect("a corner");
            let [a, b, c] = face.corners.map(|v| mesh.points[v as usize]);
            let side = ltbw_exact::predicates::orient3d(&a, &b, &c, &mesh.points[apex as usize]);
            assert_eq!(side, Sign::Negative, "it points out of its tetrahedron");
            // All its corners lie in the plane of the facet with this marker.
            let facet = &ready.domain.facets[(face.marker - 10) as usize];
            let at = |k: usize| &ready.domain.vertices[facet.polygons[0][k] as usize];
            for p in [&a, &b, &c] {
                assert_eq!(ltbw_exact::predicates::orient3d(at(0), at(1), at(2), p), Sign::Zero);
            }
            let n = vector::cross(&vector::minus(&b, &a), &vector::minus(&c, &a));
            seen[(face.marker - 10) as usize] += vector::dot(&n, &n).sqrt() / 2.0;
        }
        // Every facet is covered by the triangles that have its marker.
        for (area, facet) in seen.into_iter().zip(&ready.domain.facets) {
            let corners = &facet.polygons[0];
            let at = |k: usize| ready.domain.vertices[corners[k] as usize];
            let fan = (2..corners.len()).map(|k| {
                vector::cross(&vector::minus(&at(k - 1), &at(0)), &vector::minus(&at(k), &at(0)))
            });
            let n = fan.fold([0.0; 3], |s, n| [s[0] + n[0], s[1] + n[1], s[2] + n[2]]);
            assert!((vector::dot(&n, &n).sqrt() / 2.0 - area).abs() < 1e-12);
        }
    }
}

#[test]
fn coplanar_facets_keep_markers_of_their_own() {
    // A unit cube whose lid is two rectangles with different markers.
    let mut vertices: Vec<Point> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    vertices.extend([[0.25, 0.0, 1.0], [0.25, 1.0, 1.0]]);
    let mut domain = Domain { vertices, ..Domain::default() };
    let faces: [&[u32]; 7] = [
        &[0, 2, 3, 1],
        &[0, 1, 5, 8, 4],
        &[2, 6, 9, 7, 3],
        &[0, 4, 6, 2],
        &[1, 3, 7, 5],
        &[4, 8, 9, 6],
        &[8, 5, 7, 9],
    ];
    for (marker, corners) in (1..).zip(faces) {
        domain.facets.push(Facet::polygon(corners, marker));
    }
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refined = refine(&Refiner::new().max_volume(1e-2), &ready);
    let mesh = refined.inside();
    let mut lid = [0, 0];
    for face in refined.boundary() {
        let p = face.corners.map(|v| mesh.points[v as usize]);
        if face.marker >= 6 {
            assert!(p.iter().all(|p| p[2] == 1.0));
            let left = p.iter().all(|p| p[0] <= 0.25);
            assert_eq!(left, face.marker == 6, "{p:?}");
            lid[(face.marker - 6) as usize] += 1;
        }
    }
    assert!(lid[0] > 0 && lid[1] > lid[0], "{lid:?}");
}
